# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed form of the Menger sponge, against all crossings with the planes between its cells and against a march."""

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build
from sdf_lights.emitter.intersection.intervals import regularize
from sdf_lights.emitter.primitives.sponge import classify_sponge, most_spans, sponge_spans
from sdf_lights.emitter.tree import interior
from sdf_lights.jit import kernel
from sdf_lights.sdf.shapes import Box, Difference, Exclusive, Intersection, Sphere, Torus, Transformed, Union
from sdf_lights.sdf.shapes.fractals import MengerSponge
from support.lamps import oracle
from support.lamps.hard_cases import around, directions, grazing, inside
from support.lamps.shapes_under_test import PLACEMENTS, moved, scaled, sheared, turned

LEVELS = range(6)


def filled(p, levels):
    """Whether cells of the last level are full; p (…, 3) are points of them, with coordinates from 0 to 1."""
    full = np.all((p >= 0.0) & (p < 1.0), axis=-1)
    for place in range(1, levels + 1):
        full &= (np.floor(p * 3.0**place) % 3 == 1).sum(axis=-1) < 2
    return full


def by_planes(o, d, half_size, levels):
    """Intervals (n, 2) of a ray: between crossings with planes that follow one another, a point tells.

    In extended precision, so that intervals far below a millionth of a cell are those that exist.
    """
    o, d, count = np.asarray(o, np.longdouble), np.asarray(d, np.longdouble), 3**levels
    planes = (2.0 * np.arange(count + 1) - count) * np.longdouble(half_size) / count
    t = np.sort(np.concatenate([(planes - o[axis]) / d[axis] for axis in range(3) if d[axis] != 0.0]))
    full = filled((o + 0.5 * (t[1:] + t[:-1])[:, None] * d) / (2.0 * half_size) + 0.5, levels)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], full, [0]])))
    return t[edges].astype(float).reshape(-1, 2)


@kernel
def _regular(spans, smallest):
    return regularize(spans, len(spans), smallest)


@kernel
def _spans(o, d, half_size, levels, spans, smallest):
    return regularize(spans, sponge_spans(o, d, half_size, levels, spans, 0), smallest)


def spans_of(o, d, half_size, levels):
    """Intervals of a ray by the kernel, and by the planes; slivers are removed from both."""
    smallest = 1e-10 * half_size / np.linalg.norm(d)
    spans = np.full((most_spans((half_size, levels)) + 2, 2), np.nan)
    found = spans[: _spans(tuple(map(float, o)), tuple(map(float, d)), half_size, levels, spans, smallest)]
    assert np.isnan(spans[-1]).all()  # a row of scratch is allowed for
    expected = by_planes(o, d, half_size, levels)
    expected = expected[: _regular(expected, smallest)]
    return found, expected


def random_rays(rng, half_size, n):
    """Near a cube: directions of any length, some with a coordinate that is zero or almost."""
    for index in range(n):
        d = rng.normal(size=3)
        d[rng.integers(3)] *= (1.0, 0.0, -0.0, 1e-7, 1e-13, 1e-200)[index % 6]
        if index % 5 == 0:
            d[rng.integers(3)] = 0.0
        if not d.any():
            continue
        d /= np.linalg.norm(d)
        yield half_size * (rng.uniform(-1.05, 1.05, 3) - rng.uniform(-2.0, 2.0) * d), d * 10.0 ** rng.uniform(-6.0, 6.0)


@pytest.mark.parametrize("levels", LEVELS)
def test_intervals_are_those_between_planes(levels):
    rng = np.random.default_rng(levels)
    hits = 0
    for half_size in (0.5, 1e-3, 77.7):
        for o, d in random_rays(rng, half_size, 300):
            found, expected = spans_of(o, d, half_size, levels)
            assert found.shape == expected.shape
            # A coordinate that hardly changes is known to 1e-16 of the size, so its crossings with planes are not
            # known.
            slow = np.abs(d[d != 0.0]).min() < 1e-3 * np.abs(d).max()
            assert np.allclose(
                found, expected, rtol=0.0, atol=(1e-6 if slow else 1e-12) * half_size / np.linalg.norm(d)
            )
            hits += len(found) > 0
    assert hits > 400


@pytest.mark.parametrize("levels", [1, 2, 4])
def test_rays_in_planes_and_along_edges(levels):
    """They see what is on one side of the plane; the planes are at whole numbers and a half, which have no rounding."""
    half_size, rng = 0.5 * 3.0**levels, np.random.default_rng(levels)
    seen = 0
    for index in range(600):
        o = np.floor(rng.uniform(-half_size, half_size + 1.0, 3)) + 0.5
        still = rng.permutation(3)[: 1 + index % 2]
        d = rng.normal(size=3) if index % 3 else rng.choice([-1.0, 1.0], 3)
        d[still] = 0.0
        found, _ = spans_of(o, d, half_size, levels)
        assert np.isfinite(found).all()
        beside = []
        for side in range(4):
            away = np.zeros(3)
            away[still] = 1e-7 * np.array([side % 2 - 0.5, side // 2 - 0.5])[: len(still)]
            beside.append(spans_of(o + away, d, half_size, levels)[1])
        assert any(found.shape == other.shape and np.allclose(found, other, rtol=0.0, atol=1e-10) for other in beside)
        seen += len(found)
    assert seen > 200


@pytest.mark.parametrize("levels", [1, 3])
def test_rays_through_edges_and_corners_of_cells(levels):
    """Crossings with two or three planes at once leave neither slivers nor NaN."""
    half_size, rng = 0.5 * 3.0**levels, np.random.default_rng(9)
    for _ in range(400):
        corner = np.floor(rng.uniform(-half_size, half_size + 1.0, 3)) + 0.5
        d = rng.integers(-2, 3, 3).astype(float)
        if np.count_nonzero(d) < 2:
            continue
        o = corner + np.where(d == 0.0, 0.3, 0.0) - 4.0 * d
        found, expected = spans_of(o, d, half_size, levels)
        assert found.shape == expected.shape and np.allclose(found, expected, rtol=0.0, atol=1e-10)


def through_corners(shape, rng, n):
    """From one corner of a cell to another, or 1e-16 to 1e-4 beside them; none almost along a plane."""
    half, count = shape.half_size, 3 ** int(shape.levels)
    a, b = (2.0 * rng.integers(0, count + 1, (2, 8 * n, 3)) / count - 1.0) * half
    off = half * rng.choice([0.0, 1.0], (8 * n, 1)) * 10.0 ** rng.uniform(-16.0, -4.0, (8 * n, 1))
    a += off * directions(rng, 8 * n)
    with np.errstate(invalid="ignore"):
        d = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    good = np.abs(d).min(axis=1) > 1e-3
    assert good.sum() >= n
    return (a - 2.0 * half * d)[good][:n], d[good][:n]


def check_every_interval(levels, placement, count):
    """Neither a gap of rounding nor a lost interval in rays of a lamp, of which many pass edges closely."""
    shape, matrix = MengerSponge(0.5, levels), PLACED[placement]
    lamp = Lamps(build.build_lamp("sponge", shape, matrix))
    smallest, back = lamps.SMALLEST_INTERVAL * lamp.row["bounding_radius"], np.linalg.inv(matrix[:3, :3])
    for rays in (around, grazing, inside, through_corners):
        origins, along = rays(shape, np.random.default_rng(levels), count)
        origins, along = origins @ matrix[:3, :3].T + matrix[:3, 3], along @ matrix[:3, :3].T
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        for o, d in zip(origins, along):
            expected = by_planes(back @ (o - matrix[:3, 3]), back @ d, 0.5, levels)
            expected = np.maximum(expected[expected[:, 1] > 0.0], 0.0)
            expected = expected[: _regular(expected, smallest)]
            found = lamp.trace(o, d) @ [[1.0, 1.0], [-1.0, 1.0]]
            found = found[: _regular(found, smallest)]  # a ray may begin where it leaves the sponge
            assert len(found) == len(expected)
            # Rays 1e-6 from along a plane meet it where rounding, 1e-16 of the size, tells to 1e-10.
            assert np.allclose(found, expected, rtol=0.0, atol=100.0 * smallest)


PLACED = {
    "as it is": np.eye(4),
    "a kilometre": scaled(1e3, 1e3, 1e3),
    "a millimetre": scaled(1e-3, 1e-3, 1e-3),
    "stretched": turned(0.3, 0) @ scaled(10.0, 1.0, 0.1) @ turned(0.4, 1),
    "sheared": turned(0.6, 0) @ sheared(0.8) @ turned(0.4, 1),
    "far": moved(1e4, -2e4, 3e3) @ turned(0.5),
}


@pytest.mark.parametrize("placement", PLACED)
@pytest.mark.parametrize("levels", range(1, 7))
def test_cells_join_and_no_interval_is_lost(levels, placement):
    check_every_interval(levels, placement, 40)


@pytest.mark.slow
@pytest.mark.parametrize("placement", ["as it is", "sheared", "far"])
@pytest.mark.parametrize("levels", range(1, 7))
def test_cells_join_and_no_interval_is_lost_in_many_rays(levels, placement):
    check_every_interval(levels, placement, 200)


def test_an_edge_that_is_cut_off_by_a_hair_exists():
    """The oracle, which steps over 5.6e-9 of a ray, marches more finely and does not count it as a gap of rounding."""
    shape = MengerSponge(0.5, 5.0)
    o = np.array([[-0.0535406002249057, -0.2696789859178331, 0.21072885109041423]])
    d = np.array([[-0.2211143096307795, 0.8953610332190677, 0.38657092786368114]])
    found, expected = spans_of(o[0], d[0], 0.5, 5)
    expected = expected[expected[:, 1] > 0.0]
    assert len(found[found[:, 1] > 0.0]) == len(expected) == 21
    assert np.diff(expected, axis=1).min() == pytest.approx(5.649589275812544e-9, rel=1e-5)
    truth = oracle.find(shape, o, d)
    assert truth.counts == 20
    lengths = np.diff(np.maximum(expected, 0.0), axis=1).sum(keepdims=True)[0]
    assert oracle.judge(shape, o, d, np.array([21]), lengths, truth).wrong == 0.0


def test_a_gap_that_does_not_exist_is_wrong():
    ball, o, d = Sphere(0.5), np.array([[-2.0, 0.1, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    truth = oracle.find(ball, o, d)
    for count in (0, 2):
        assert oracle.judge(ball, o, d, np.array([count]), truth.lengths, truth).wrong == 1.0
    assert oracle.judge(ball, o, d, truth.counts, truth.lengths, truth).wrong == 0.0


def test_number_of_intervals():
    """The bound holds for many rays, and for those along a row of holes of the last level."""
    for levels in LEVELS:
        found, _ = spans_of((-3.0, 0.5 - 0.5 / 3**levels - 1.0 / 3**levels, 0.4999), (1.0, 0.0, 0.0), 0.5, levels)
        assert levels == 0 or len(found) == 3 ** (levels - 1) + 1
    rng = np.random.default_rng(3)
    most = [max(len(spans_of(o, d, 0.5, levels)[0]) for o, d in random_rays(rng, 0.5, 3000)) for levels in (1, 2, 3)]
    assert most[0] == 3 and all(3 ** (n - 1) < count <= most_spans((1.0, n)) for n, count in zip((1, 2, 3), most))


@kernel
def _flags(c, h, half_size, levels):
    return classify_sponge(c, h, half_size, levels)


@pytest.mark.parametrize("levels", range(1, 4))
def test_cells_and_parts_of_them_are_certain(levels):
    """The cells of every level: full, empty, or neither; and boxes in cells of the last level."""
    half_size, rng = 0.35, np.random.default_rng(2)
    for level in range(1, levels + 1):
        count = 3**level
        cells = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        cells = cells[rng.permutation(len(cells))[:500]]
        full = filled((cells + 0.5) / count, level)
        for cell, solid in zip(cells, full):
            c, h = (2.0 * (cell + 0.5) / count - 1.0) * half_size, half_size / count
            expected = (0, 1) if not solid else (1, 0) if level == levels else (0, 0)
            assert _flags(tuple(c), (h, h, h), half_size, levels) == expected
            if level == levels:
                size = rng.uniform(0.0, 0.5, 3)
                part = c + 2.0 * h * rng.uniform(-0.5, 0.5, 3) * (1.0 - 2.0 * size)
                assert _flags(tuple(part), tuple(h * size), half_size, levels) == expected


CUBE = MengerSponge(0.5, 3.0)
LAMPS = {
    "solid": MengerSponge(0.4, 0.0),
    "one level": MengerSponge(0.4, 1.0),
    "two levels": MengerSponge(0.7, 2.0),
    "three levels": CUBE,
    "four levels": MengerSponge(0.6, 4.0),
    "stretched": Transformed(CUBE, scaled(2.0, 1.0, 0.4)),
    "sheared": Transformed(MengerSponge(0.5, 2.0), turned(0.6, 0) @ sheared(0.8) @ turned(0.4, 1)),
    "without a ball": Difference(CUBE, Transformed(Sphere(0.4), moved(0.4, 0.3, 0.5))),
    "out of a torus": Difference(Torus(0.6, 0.25), Transformed(MengerSponge(0.7, 2.0), turned(0.3, 0))),
    "two": Exclusive(MengerSponge(0.5, 2.0), Transformed(MengerSponge(0.5, 2.0), moved(0.2) @ turned(0.5, 1))),
    "common": Intersection(MengerSponge(0.5, 3.0), MengerSponge(0.45, 2.0)),
    "beside a block": Union(CUBE, Transformed(Box((0.2, 0.5, 0.5)), moved(0.7))),
}


@pytest.mark.parametrize("rays", [around, grazing, inside])
@pytest.mark.parametrize("name", LAMPS)
def test_lamps_have_the_intervals_of_the_field(name, rays):
    shape = LAMPS[name]
    lamp = Lamps(build.build_lamp(name, shape, np.eye(4)))
    assert lamp.row["kind"] == lamps.CLOSED and lamp.row["direct"]
    origins, directions = rays(shape, np.random.default_rng(4), 200)
    truth = oracle.find(shape, origins, directions)
    complete = truth.complete  # a march along a face may take too many steps
    origins, directions, truth = (
        origins[complete],
        directions[complete],
        oracle.Crossings(*(x[complete] for x in truth)),
    )
    assert len(origins) > 60
    spans = [lamp.trace(o, d) for o, d in zip(origins, directions)]
    verdict = oracle.judge(
        shape,
        origins,
        directions,
        np.array([len(rows) for rows in spans]),
        np.array([2.0 * rows[:, 1].sum() for rows in spans]),
        truth,
    )
    assert verdict.wrong == 0.0 and verdict.below < 0.01
    assert verdict.length_error < 1e-6


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_points_are_drawn_without_rejection(placement):
    """All boxes of the tree of a sponge are full or empty, as it is divided along the planes between cells."""
    for levels in range(1, 4):
        shape = MengerSponge(0.45, levels)
        tree = interior.tree(shape)
        assert not len(tree.boundary)
        assert tree.nodes["mass"][0] == pytest.approx(shape.volume(), rel=1e-12)
    lamp = Lamps(build.build_lamp("sponge", shape, PLACEMENTS[placement]))
    points = lamp.points(np.random.default_rng(1).random((3000, 3))) - PLACEMENTS[placement][:3, 3]
    local = points @ np.linalg.inv(PLACEMENTS[placement][:3, :3]).T
    assert shape.distance(local).max() < 1e-9


@pytest.mark.parametrize("levels", [9, 12])
def test_the_deepest_sponges(levels):
    """As many levels as a sponge may have: lamps are built, and rays do not run out of rows."""
    shape = MengerSponge(0.5, levels)
    lamp = Lamps(build.build_lamp("sponge", shape, np.eye(4)))
    rng = np.random.default_rng(6)
    for rays in (around(shape, rng, 20), inside(shape, rng, 5)):
        for o, d in zip(*rays):
            spans = lamp.trace(o, d)
            assert np.all(spans[:, 1] > 0.0) and np.all(spans[1:, 0] - spans[1:, 1] > spans[:-1, 0] + spans[:-1, 1])
            for c, h in spans[:: max(len(spans) // 10, 1)]:
                assert shape.distance(np.array([o + c * d]))[0] <= 1e-12
