# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray intervals against marching the shapes' own distance formulas, and against exact arithmetic."""

import numpy as np
import pytest

from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build
from sdf_lights.emitter.intersection.fields import NEGATED
from sdf_lights.emitter.intersection.intervals import regularize, rows_needed, solve
from sdf_lights.emitter.intersection.membership import classify
from sdf_lights.emitter.primitives.cylinder import cylinder_span
from sdf_lights.emitter.primitives.frustum import frustum_span
from sdf_lights.jit import kernel
from sdf_lights.sdf.program import Op, combine, primitive
from sdf_lights.sdf.shapes import Box, Cone, Cylinder, Difference, Sphere, Torus, Transformed, Union
from support.lamps.shapes_under_test import PLACEMENTS, SHAPES, moved, turned

STEP = 2e-4  # least step of the marcher, so the size of the smallest thing it can be sure of


def directions_of(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def rays_at(shape, rng, n):
    """Origins around and in the bounding box, directions towards points of the box."""
    low, high = shape.bounds()
    centre, size = 0.5 * (low + high), high - low
    targets = low + rng.random((n, 3)) * size
    origins = centre + directions_of(rng, n) * np.linalg.norm(size) * rng.choice([0.2, 0.7, 2.0], (n, 1))
    d = targets - origins
    return origins, d / np.linalg.norm(d, axis=1, keepdims=True)


def march(shape, origins, directions, reach):
    """Number of entries (or starts) inside along each ray, and the length inside: steps of |φ|, at least STEP."""
    t = np.zeros(len(origins))
    inside = shape.distance(origins) <= 0.0
    count, total = inside.astype(int), np.zeros(len(origins))
    active = np.arange(len(origins))
    field = shape.distance(origins)
    while len(active):
        # A quarter less than the distance is still safe, and keeps rounding out of the argument.
        step = np.maximum(np.abs(field), STEP)
        ahead = origins[active] + (t[active] + step)[:, None] * directions[active]
        field = shape.distance(ahead)
        now = field <= 0.0
        crossed = now != inside[active]
        total[active] += np.where(crossed, 0.5, now) * step
        count[active] += crossed & now
        inside[active] = now
        t[active] += step
        left = t[active] < reach
        active, field = active[left], field[left]
    return count, total


@pytest.mark.parametrize("name", SHAPES)
def test_every_crossing_is_found(name):
    shape = SHAPES[name]
    lamp = Lamps(build.build_lamp(name, shape, np.eye(4)))
    origins, directions = rays_at(shape, np.random.default_rng(11), 600)
    reach = 2.0 * np.linalg.norm(np.subtract(*shape.bounds())) + 2.0
    counts, lengths = march(shape, origins, directions, reach)
    doubtful = wrong = 0
    for o, d, count, total in zip(origins, directions, counts, lengths):
        spans = lamp.trace(o, d)
        assert abs(2.0 * spans[:, 1].sum() - total) < 40 * STEP
        gaps = np.diff(np.column_stack([spans[:, 0] - spans[:, 1], spans[:, 0] + spans[:, 1]]).ravel())
        if len(gaps) and gaps.min() < 4 * STEP or count > len(spans) and total < 4 * STEP * count:
            doubtful += 1  # too short for the marcher to be an authority
            continue
        wrong += count != len(spans)
    assert wrong == 0
    assert doubtful < 12


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("name", ["torus", "cone", "capsule", "nested", "coincident"])
def test_intervals_follow_affine_maps(name, placement):
    """The same ray, mapped with the lamp: the ends keep their parameters."""
    shape, matrix = SHAPES[name], PLACEMENTS[placement]
    here, there = (Lamps(build.build_lamp(name, shape, m)) for m in (np.eye(4), matrix))
    reach = np.linalg.norm(np.subtract(*shape.bounds(matrix)))
    for o, d in zip(*rays_at(shape, np.random.default_rng(5), 300)):
        stretched = matrix[:3, :3] @ d
        factor = np.linalg.norm(stretched)
        local = here.trace(o, d)
        world = there.trace(matrix[:3, :3] @ o + matrix[:3, 3], stretched / factor) / factor
        local = local[local[:, 1] > 1e-6]  # grazing: may be lost to the rounding of the mapped ray
        world = world[world[:, 1] > 1e-6]
        assert len(local) == len(world)
        # The mapped origin and direction are rounded: relative to the distance and the matrix's stretch.
        distance = np.linalg.norm(matrix[:3, 3]) + np.linalg.norm(matrix[:3, :3] @ o) + reach
        slack = 1e-9 + 1e-13 * distance / np.linalg.svd(matrix[:3, :3])[1][2]
        assert np.allclose(local, world, rtol=0.0, atol=min(slack, 1e-5))


@pytest.mark.parametrize("minor", [0.5, 0.35, 0.1, 1e-2, 1e-3])
def test_torus_roots_lie_on_the_torus(minor):
    """Also for rays through the axis, along it, in the plane of the ring, and almost tangent."""
    lamp = Lamps(build.build_lamp("torus", Torus(1.0, minor), np.eye(4)))
    rng = np.random.default_rng(2)
    angle = rng.uniform(0, 2 * np.pi, 400)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(400)], axis=1)
    targets = ring + minor * rng.uniform(-1.0, 1.0, (400, 3))
    tangent = 1.0 + 0.999999 * minor
    origins = [*(3.0 * directions_of(rng, 400)), (3, 0, 0), (0, 0, 3), (1, 0, 3), (3, 1, 0), (-3, tangent, 0)]
    targets = [*targets, (0, 0, 0), (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, tangent, 0)]
    found = 0
    for o, target in zip(np.array(origins, float), np.array(targets, float)):
        d = (target - o) / np.linalg.norm(target - o)
        for c, h in lamp.trace(o, d):
            for t in (c - h, c + h):
                p = o + t * d
                distance = np.hypot(np.hypot(p[0], p[1]) - 1.0, p[2]) - minor
                assert abs(distance) < 1e-9 * minor + 1e-14
                found += 1
    assert found > 300


@pytest.mark.parametrize("impact", [0.0, 0.5, 0.99])
def test_distance_costs_no_digits(impact):
    """r₊³ − r₋³ of a sphere from up to 30,000 radii away, in extended precision; the plain quadratic loses it."""
    lamp = Lamps(build.build_lamp("ball", Sphere(1.0), np.eye(4)))
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no extended precision on this machine")
    for distance in (30.0, 300.0, 3e3, 3e4):
        o = np.array([0.3, -0.2, 1.0])
        o *= distance / np.linalg.norm(o)
        side = np.cross(o, [1.0, 0.0, 0.0])
        d = side * (impact / np.linalg.norm(side)) - o
        d /= np.linalg.norm(d)
        ((c, h),) = lamp.trace(o, d)
        ours = 2.0 * h * (3.0 * c * c + h * h)

        wide_o, wide_d = o.astype(np.longdouble), d.astype(np.longdouble)
        square, offset = wide_d @ wide_d, np.cross(wide_o, wide_d)
        half, centre = np.sqrt((1 - offset @ offset / square) / square), -(wide_o @ wide_d) / square
        exact = 2 * half * (3 * centre**2 + half**2)
        # The closest approach is rounded to 1e-16 of the distance; a grazing chord magnifies that by impact/half².
        assert abs(ours / exact - 1.0) < 4e-16 * distance * (1.0 + impact / float(half) ** 2)
        if distance == 3e4 and impact > 0.0:  # through the middle, its roundings may happen to be none
            b, root = o @ d, np.sqrt((o @ d) ** 2 - (o @ o - 1))
            assert abs(((root - b) ** 3 - (-root - b) ** 3) / exact - 1.0) > 3e-9


def test_origin_inside_is_clamped_to_zero():
    lamp = Lamps(build.build_lamp("ball", Sphere(1.0), np.eye(4)))
    ((c, h),) = lamp.trace((0.5, 0, 0), (1, 0, 0))
    assert c - h == 0.0 and c + h == 0.5
    assert len(lamp.trace((2.0, 0, 0), (1, 0, 0))) == 0


def test_coincident_faces_leave_no_slivers():
    """Boxes that touch are one; a box without itself, or without a box that shares faces with it, has no skin left."""
    halves = Union(Transformed(Box((0.5, 1, 1)), moved(-0.5)), Transformed(Box((0.5, 1, 1)), moved(0.5)))
    carved = Difference(Box((1, 1, 1)), Transformed(Box((0.5, 1, 1)), moved(0.5)))
    tilt = moved(3.0, 1.0, 2.0) @ turned(0.3, 0) @ turned(0.8, 2)
    rng = np.random.default_rng(8)
    for shape, most, volume in ((halves, 1, 8.0), (carved, 1, 4.0)):
        lamp = Lamps(build.build_lamp("boxes", shape, tilt))
        assert abs(lamp.row["volume"] / volume - 1.0) < 1e-4
        for o, d in zip(*rays_at(shape, rng, 2000)):
            spans = lamp.trace(tilt[:3, :3] @ o + tilt[:3, 3], tilt[:3, :3] @ d)
            assert len(spans) <= most


def test_more_spans_than_primitives():
    """A comb of slots: each difference can divide every interval, and the rows asked for hold them all."""
    slots = [Transformed(Box((0.01, 2, 2)), moved(x)) for x in np.linspace(-0.9, 0.9, 31)]
    lamp = Lamps(build.build_lamp("comb", Difference(Box((1, 1, 1)), *slots), np.eye(4)))
    spans = lamp.trace((-5, 0, 0), (1, 0, 0))
    assert len(spans) == 32
    assert np.isclose(2.0 * spans[:, 1].sum(), 2.0 - 31 * 0.02, rtol=1e-12)


def test_axis_parallel_rays():
    """Directions with zero components, through the middle and along faces."""
    cases = {Box((1, 2, 3)): 6.0, Cylinder(0.5, 3.0): 3.0, Cone(0.5, 2.0): 2.0, Torus(1.0, 0.25): 0.0}
    for shape, through in cases.items():
        lamp = Lamps(build.build_lamp("lamp", shape, np.eye(4)))
        spans = lamp.trace((0, 0, 10), (0, 0, -1))
        assert np.isclose(2.0 * spans[:, 1].sum(), through, rtol=1e-12)
        assert np.isfinite(lamp.trace((1, 2, 10), (0, 0, -1))).all()


def ring(p):
    return np.hypot(p[..., 0], p[..., 1])


def in_sponge(p, half_size, levels):
    """No two coordinates have a 1 in the same place of their digits in base 3."""
    ones = [np.floor((p / half_size + 1.0) / 2.0 * 3.0**place) % 3 == 1 for place in range(1, int(levels) + 1)]
    return np.all(np.abs(p) <= half_size, axis=-1) & np.all(np.sum(ones, axis=-1) < 2, axis=0)


# What is inside, as ``sdf.program`` says it: of points in the primitive's own space, with its parameters.
INSIDE = {
    Op.SPHERE: lambda p, k: np.linalg.norm(p, axis=-1) <= k[0],
    Op.BOX: lambda p, k: np.all(np.abs(p) <= k[:3], axis=-1),
    Op.TORUS: lambda p, k: np.hypot(ring(p) - k[0], p[..., 2]) <= k[1],
    Op.CAPSULE: lambda p, k: np.hypot(ring(p), np.maximum(np.abs(p[..., 2]) - k[1] / 2, 0)) <= k[0],
    Op.CYLINDER: lambda p, k: (ring(p) <= k[0]) & (np.abs(p[..., 2]) <= k[1] / 2),
    Op.CONE: lambda p, k: (ring(p) <= k[0] * (0.5 - p[..., 2] / k[1])) & (np.abs(p[..., 2]) <= k[1] / 2),
    Op.HALF_SPACE: lambda p, k: p[..., 2] <= 0.0,
    Op.FRUSTUM: lambda p, k: (
        (ring(p) <= 0.5 * (k[0] + k[1]) + p[..., 2] * (k[1] - k[0]) / k[2]) & (np.abs(p[..., 2]) <= k[2] / 2)
    ),
    Op.SPONGE: lambda p, k: in_sponge(p, k[0], k[1]),
}
SETS = {
    Op.UNION: np.logical_or,
    Op.INTERSECTION: np.logical_and,
    Op.DIFFERENCE: np.greater,
    Op.EXCLUSIVE: np.logical_xor,
}
PARAMETERS = {
    Op.SPHERE: (0.6,),
    Op.BOX: (0.7, 0.5, 0.3),
    Op.TORUS: (0.6, 0.2),
    Op.CAPSULE: (0.3, 0.7),
    Op.CYLINDER: (0.5, 0.9),
    Op.CONE: (0.6, 1.0),
    Op.HALF_SPACE: (),
    Op.FRUSTUM: (0.6, 0.2, 0.8),
    Op.SPONGE: (0.7, 2.0),
}


def inside(program, points):
    stack = []
    for row in program:
        if row["arity"]:
            second, first = stack.pop(), stack.pop()
            stack.append(SETS[row["op"]](first, second))
        else:
            local = points @ row["inverse"][:, :3].T + row["inverse"][:, 3]
            stack.append(INSIDE[row["op"]](local, row["parameters"]))
    return stack.pop()


def random_map(rng):
    return (
        moved(*rng.uniform(-0.4, 0.4, 3))
        @ turned(*rng.uniform(0, 7, 1), axis=rng.integers(3))
        @ turned(rng.uniform(0, 7), axis=rng.integers(3))
        @ np.diag([*rng.uniform(0.5, 1.5, 3), 1.0])
    )


def random_program(rng, size):
    """Any tree of set operations on any primitives."""
    if size == 1:
        op = Op(rng.choice(list(INSIDE)))
        return primitive(op, random_map(rng), PARAMETERS[op])
    left = rng.integers(1, size)
    return combine(Op(rng.choice(list(SETS))), [random_program(rng, left), random_program(rng, size - left)])


@kernel
def _solved(program, o, d, spans, chosen, smallest):
    return regularize(spans, solve(program, o, d, spans, chosen), smallest)


def solved(program, o, d, chosen=None, smallest=0.0):
    spans = np.empty((rows_needed(program)[0], 2))
    return spans[: _solved(program, tuple(map(float, o)), tuple(map(float, d)), spans, chosen, smallest)].copy()


@pytest.mark.parametrize("size", [1, 2, 3, 6, 20])
def test_random_programs_against_membership(size):
    """Every primitive and set operation, unbounded ones too: points along a ray are inside where its intervals say."""
    rng = np.random.default_rng(size)
    for _ in range(40):
        program = random_program(rng, size)
        for _ in range(6):
            o, d = rng.normal(size=3), rng.normal(size=3)
            spans = solved(program, o, d)
            assert np.all(np.diff(spans.ravel()) >= 0.0)
            t = rng.uniform(-8.0, 8.0, 3000)
            t = t[np.abs(t[:, None] - spans.ravel()).min(axis=1, initial=np.inf) > 1e-9]
            found = np.any((t[:, None] > spans[:, 0]) & (t[:, None] < spans[:, 1]), axis=1)
            assert np.array_equal(found, inside(program, o + t[:, None] * d))


def test_chosen_instructions_are_a_program():
    """A list of instructions gives what a program of just those gives."""
    rng = np.random.default_rng(4)
    parts = [random_program(rng, 3) for _ in range(4)]
    whole = combine(Op.UNION, parts)
    first, second = len(parts[0]), len(parts[0]) + len(parts[1])
    # The second and third part, and the union of which they are the operands.
    third = np.arange(second + 1, second + 1 + len(parts[2]))
    chosen = np.concatenate([np.arange(first, second), third, [third[-1] + 1]]).astype(np.int32)
    assert np.array_equal(whole[chosen], combine(Op.UNION, parts[1:3]))
    everywhere = combine(Op.UNION, [primitive(Op.HALF_SPACE, np.diag([1.0, s, s, 1.0]), ()) for s in (1, -1)])
    without = combine(Op.DIFFERENCE, [everywhere, whole[chosen]])
    negated = np.append(chosen, NEGATED).astype(np.int32)
    for _ in range(200):
        o, d = rng.normal(size=3), rng.normal(size=3)
        half = tuple(rng.uniform(0.0, 0.3, 3))
        for indices, expected in ((chosen, whole[chosen]), (negated, without)):
            assert np.array_equal(solved(whole, o, d, indices, 1e-12), solved(expected, o, d, None, 1e-12))
            box = half if indices is chosen else (0.0, 0.0, 0.0)  # which no two half spaces together can enclose
            assert classified(whole, o, box, indices) == classified(expected, o, box)


@kernel
def _classified(program, c, h, chosen):
    return classify(program, c, h, chosen)


def classified(program, c, h, chosen=None):
    return _classified(program, tuple(map(float, c)), tuple(map(float, h)), chosen)


@pytest.mark.parametrize("op", INSIDE)
def test_boxes_are_classified_conservatively_and_tightly(op):
    """A flag is never wrong, for any map; without a map, a box is undecided only where the surface passes it."""
    rng = np.random.default_rng(int(op))
    for matrix, tight in ((np.eye(4), True), (random_map(rng), False)):
        program = primitive(op, matrix, PARAMETERS[op])
        undecided = crossed = 0
        for _ in range(500):
            half = 0.4 * rng.random(3)
            centre = rng.uniform(-1.0, 1.0, 3)
            flags = classified(program, centre, half)
            there = inside(
                program,
                centre
                + half
                * np.concatenate([rng.uniform(-1, 1, (300, 3)), np.clip(rng.uniform(-1.5, 1.5, (600, 3)), -1, 1)]),
            )
            assert flags != (1, 1)
            assert not flags[0] or there.all()
            assert not flags[1] or not there.any()
            undecided += flags == (0, 0)
            crossed += there.any() and not there.all()
        # Some boxes are crossed at so small a corner that no sample falls into it.
        assert crossed > 40
        assert not tight or crossed > 0.9 * undecided


def test_half_spaces():
    """Infinite ends, rays within and along the plane, and planes that the origin is far from."""
    below, above = (primitive(Op.HALF_SPACE, np.diag([1.0, sign, sign, 1.0]), ()) for sign in (1, -1))
    for o, d, expected in (
        ((0, 0, 2), (0, 0, -0.5), [(4.0, np.inf)]),
        ((0, 0, 2), (1, 0, 1), [(-np.inf, -2.0)]),
        ((0, 0, -1), (1, 0, 0), [(-np.inf, np.inf)]),
        ((0, 0, 1), (1, 0, 0), []),
    ):
        assert np.array_equal(solved(below, o, d), np.reshape(expected, (-1, 2)))
    rng = np.random.default_rng(1)
    everything = combine(Op.UNION, [below, above])
    slab = combine(Op.INTERSECTION, [below, primitive(Op.HALF_SPACE, moved(z=-1e-3) @ np.diag([1.0, -1, -1, 1]), ())])
    for _ in range(100):
        o, d = 3.0 * rng.normal(size=3), rng.normal(size=3)
        assert np.array_equal(solved(everything, o, d, smallest=1e-12), [(-np.inf, np.inf)])
        for op in (Op.INTERSECTION, Op.EXCLUSIVE, Op.DIFFERENCE):
            assert len(solved(combine(op, [everything, everything]), o, d, smallest=1e-12)) == (op == Op.INTERSECTION)
        for distance in (1.0, 1e3, 1e6):
            ((start, end),) = solved(slab, (o[0] * distance, o[1] * distance, o[2]), d)
            assert end - start == pytest.approx(1e-3 / abs(d[2]), rel=1e-10)


@pytest.mark.parametrize("difference", [0.0, 1e-15, 1e-12, 1e-9, 1e-6])
def test_frustums_that_are_almost_cylinders(difference):
    rng = np.random.default_rng(6)
    along = [
        ((0.1, 0.2, 5.0), (0.0, 0.0, -1.0)),
        ((0.1, 0.2, 5.0), (1e-14, 0.0, -1.0)),
        ((0.4, 0.0, 5.0), (0, 0, 1.0)),
        ((0.6, 0.0, 5.0), (0.0, 0.0, 1.0)),
        ((0.6, 0.0, 0.0), (1e-9, 0.0, 1.0)),
    ]
    rays = along + [(rng.normal(size=3), rng.normal(size=3)) for _ in range(2000)]
    hits = 0
    for o, d in rays:
        o, d = tuple(map(float, o)), tuple(map(float, d))
        frustum, cylinder = frustum_span(o, d, 0.5, 0.5 * (1.0 - difference), 0.4), cylinder_span(o, d, 0.5, 0.4)
        if cylinder[1] - cylinder[0] > 1e-2:
            assert np.allclose(frustum, cylinder, rtol=0.0, atol=1e-13 + 100.0 * difference)
            hits += 1
        elif cylinder[0] > cylinder[1]:
            assert not frustum[1] - frustum[0] > 1e-2
    assert hits > 300


@pytest.mark.parametrize("bottom, top", [(0.5, 0.2), (0.0, 0.5), (0.5, 0.0), (0.3, 0.31)])
def test_frustum_ends_lie_on_its_surface(bottom, top):
    """Also of rays through the apex, along the axis and along a line of the side."""
    rng = np.random.default_rng(7)
    line = np.array([top - bottom, 0.0, 0.8])
    rays = [(rng.normal(size=3), rng.normal(size=3)) for _ in range(1000)]
    rays += [
        ((0.0, 0.0, 3.0), (0.0, 0.0, -1.0)),
        ((0.05, 0.0, 3.0), (0.0, 0.0, -1.0)),
        ((0.0, 0.1, 0.0), line),
        ((0.02, 0.1, 0.0), line),
    ]
    hits = 0
    for o, d in rays:
        o, d = np.array(o, float), np.array(d, float)
        start, end = frustum_span(tuple(o), tuple(d), bottom, top, 0.4)
        for t in (start, end) if start < end else ():
            x, y, z = o + t * d
            side = np.hypot(x, y) - (0.5 * (bottom + top) + (top - bottom) * z / 0.8)
            assert abs(max(side, abs(z) - 0.4)) < 1e-12
            hits += 1
    assert hits > 60


SLABS = ((-1.0, 0.03), (-0.45, 0.4), (0.45, 0.4))  # centre and half width along x


def slab_field(x, factor=1.0):
    boxes = []
    for centre, half in SLABS:
        q = np.abs(x - (centre, 0.0, 0.0)) - (half, 2.0, 2.0)
        boxes.append(np.linalg.norm(np.maximum(q, 0.0), axis=-1) + np.minimum(q.max(axis=-1), 0.0))
    return factor * np.min(boxes, axis=0)


def published_march(origins, directions, factor, clamp, divide):
    """The published stepping rule: counts and lengths of intervals along each ray.

    Crossings are refined by bisection; the march goes on from where the step had landed.
    """

    def field(t):
        return slab_field(origins + t[:, None] * directions, factor)

    n = len(origins)
    t, value = np.zeros(n), field(np.zeros(n))
    inside, entry = value <= 0.0, np.zeros(n)
    count, total = np.zeros(n, int), np.zeros(n)
    while (t < 3.5).any():
        step = np.maximum(np.where(inside, np.minimum(-value, clamp), value / divide), 0.01)
        ahead = t + step
        value = field(ahead)
        crossed = (value <= 0.0) != inside
        a, b = t, ahead
        for _ in range(34 if crossed.any() else 0):
            middle = 0.5 * (a + b)
            same = (field(middle) <= 0.0) == inside
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        root = 0.5 * (a + b)
        count += crossed & inside
        total += np.where(crossed & inside, root - entry, 0.0)
        entry = np.where(crossed & ~inside, root, entry)
        t, inside = ahead, inside ^ crossed
    return count, total


def test_stepping_on_fields_that_overestimate():
    """The published table: only a Lipschitz bound outside saves a field three times too steep; intervals need none."""
    rng = np.random.default_rng(3)
    n = 2000
    origins = np.column_stack([rng.uniform(-1.55, -1.30, n), np.zeros((n, 2))])
    directions = np.column_stack([np.ones(n), rng.choice([-0.1, 0.1], (n, 2))])
    length = np.linalg.norm(directions[0])
    directions /= length
    expected = 1.66 * length
    for factor, clamp, divide, found, error in (
        (1, np.inf, 1, 1.0, 0.0),
        (3, np.inf, 1, 0.0, 0.126),
        (3, 0.05, 1, 0.0, 0.105),
        (3, 0.05, 3, 1.0, 0.0),
    ):
        count, total = published_march(origins, directions, factor, clamp, divide)
        assert np.mean(count == 3) == found
        assert np.mean(np.abs(total - expected)) / expected == pytest.approx(error, rel=0.05, abs=1e-8)

    slabs = Union(*(Transformed(Box((half, 2.0, 2.0)), moved(x)) for x, half in SLABS))
    lamp = Lamps(build.build_lamp("slabs", slabs, np.eye(4)))
    for o, d in zip(origins[:1000], directions[:1000]):
        spans = lamp.trace(o, d)
        assert len(spans) == 3
        assert abs(2.0 * spans[:, 1].sum() - expected) < 1e-12
