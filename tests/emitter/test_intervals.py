# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray intervals against marching the shapes' own distance formulas, and against exact arithmetic."""

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.sdf.shapes import Box, Cone, Cylinder, Difference, Sphere, Torus, Transformed, Union

from tests.emitter.shapes_under_test import PLACEMENTS, SHAPES, moved, turned
from tests.emitter.support import Lamps

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
    lamp = Lamps(lamps.build_lamp(name, shape, np.eye(4)))
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
    here, there = (Lamps(lamps.build_lamp(name, shape, m)) for m in (np.eye(4), matrix))
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
    lamp = Lamps(lamps.build_lamp("torus", Torus(1.0, minor), np.eye(4)))
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
    lamp = Lamps(lamps.build_lamp("ball", Sphere(1.0), np.eye(4)))
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no extended precision on this machine")
    for distance in (30.0, 300.0, 3e3, 3e4):
        o = np.array([0.3, -0.2, 1.0])
        o *= distance / np.linalg.norm(o)
        side = np.cross(o, [1.0, 0.0, 0.0])
        d = side * (impact / np.linalg.norm(side)) - o
        d /= np.linalg.norm(d)
        (c, h), = lamp.trace(o, d)
        ours = 2.0 * h * (3.0 * c * c + h * h)

        wide_o, wide_d = o.astype(np.longdouble), d.astype(np.longdouble)
        square, offset = wide_d @ wide_d, np.cross(wide_o, wide_d)
        half, centre = np.sqrt((1 - offset @ offset / square) / square), -(wide_o @ wide_d) / square
        exact = 2 * half * (3 * centre**2 + half**2)
        # The closest approach is rounded to 1e-16 of the distance; a grazing chord magnifies that by impact/half².
        assert abs(ours / exact - 1.0) < 4e-16 * distance * (1.0 + impact / float(half) ** 2)
        if distance == 3e4:
            b, root = o @ d, np.sqrt((o @ d) ** 2 - (o @ o - 1))
            assert abs(((root - b) ** 3 - (-root - b) ** 3) / exact - 1.0) > 3e-9


def test_origin_inside_is_clamped_to_zero():
    lamp = Lamps(lamps.build_lamp("ball", Sphere(1.0), np.eye(4)))
    (c, h), = lamp.trace((0.5, 0, 0), (1, 0, 0))
    assert c - h == 0.0 and c + h == 0.5
    assert len(lamp.trace((2.0, 0, 0), (1, 0, 0))) == 0


def test_coincident_faces_leave_no_slivers():
    """Boxes that touch are one; a box without itself, or without a box that shares faces with it, has no skin left."""
    halves = Union(Transformed(Box((0.5, 1, 1)), moved(-0.5)), Transformed(Box((0.5, 1, 1)), moved(0.5)))
    carved = Difference(Box((1, 1, 1)), Transformed(Box((0.5, 1, 1)), moved(0.5)))
    tilt = moved(3.0, 1.0, 2.0) @ turned(0.3, 0) @ turned(0.8, 2)
    rng = np.random.default_rng(8)
    for shape, most, volume in ((halves, 1, 8.0), (carved, 1, 4.0)):
        lamp = Lamps(lamps.build_lamp("boxes", shape, tilt))
        assert abs(lamp.row["volume"] / volume - 1.0) < 1e-4
        for o, d in zip(*rays_at(shape, rng, 2000)):
            spans = lamp.trace(tilt[:3, :3] @ o + tilt[:3, 3], tilt[:3, :3] @ d)
            assert len(spans) <= most


def test_more_spans_than_primitives():
    """A comb of slots: each difference can divide every interval, and the rows asked for hold them all."""
    slots = [Transformed(Box((0.01, 2, 2)), moved(x)) for x in np.linspace(-0.9, 0.9, 31)]
    lamp = Lamps(lamps.build_lamp("comb", Difference(Box((1, 1, 1)), *slots), np.eye(4)))
    spans = lamp.trace((-5, 0, 0), (1, 0, 0))
    assert len(spans) == 32
    assert np.isclose(2.0 * spans[:, 1].sum(), 2.0 - 31 * 0.02, rtol=1e-12)


def test_axis_parallel_rays():
    """Directions with zero components, through the middle and along faces."""
    cases = {Box((1, 2, 3)): 6.0, Cylinder(0.5, 3.0): 3.0, Cone(0.5, 2.0): 2.0, Torus(1.0, 0.25): 0.0}
    for shape, through in cases.items():
        lamp = Lamps(lamps.build_lamp("lamp", shape, np.eye(4)))
        spans = lamp.trace((0, 0, 10), (0, 0, -1))
        assert np.isclose(2.0 * spans[:, 1].sum(), through, rtol=1e-12)
        assert np.isfinite(lamp.trace((1, 2, 10), (0, 0, -1))).all()


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
    for factor, clamp, divide, found, error in ((1, np.inf, 1, 1.0, 0.0), (3, np.inf, 1, 0.0, 0.126),
                                                (3, 0.05, 1, 0.0, 0.105), (3, 0.05, 3, 1.0, 0.0)):
        count, total = published_march(origins, directions, factor, clamp, divide)
        assert np.mean(count == 3) == found
        assert np.mean(np.abs(total - expected)) / expected == pytest.approx(error, rel=0.05, abs=1e-8)

    slabs = Union(*(Transformed(Box((half, 2.0, 2.0)), moved(x)) for x, half in SLABS))
    lamp = Lamps(lamps.build_lamp("slabs", slabs, np.eye(4)))
    for o, d in zip(origins[:1000], directions[:1000]):
        spans = lamp.trace(o, d)
        assert len(spans) == 3
        assert abs(2.0 * spans[:, 1].sum() - expected) < 1e-12
