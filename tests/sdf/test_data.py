# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Outlines and tubes: distances against a search of all segments, bounds over boxes, and what copies of them share."""

import copy
import math
import pickle

import numpy as np
import pytest

from sdf_lights.emitter.tree import interior
from sdf_lights.graph import codegen_glsl
from sdf_lights.graph.formula import POINT
from sdf_lights.graph.functions import evaluate
from sdf_lights.sdf.data.outline import OUTLINE, Outline, outline_table, windings
from sdf_lights.sdf.data.picture import contour
from sdf_lights.sdf.data.tube import TUBE, Tube, with_gap
from sdf_lights.sdf.shapes import SHAPES, Difference, Sphere, Transformed, Union
from sdf_lights.sdf.shapes.base import Slots
from sdf_lights.sdf.shapes.field import Field
from support import glsl


def _flower(x=0.0, y=0.0, count=90):
    turn = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    radius = 0.4 * (1.0 + 0.3 * np.cos(5.0 * turn))
    rim = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    return [rim + (x, y), 0.4 * rim + (x, y)]


def _square(x, y):
    return np.array([(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)])


def _spring():
    turn = np.linspace(0.0, 4.0 * math.pi, 120)
    return np.column_stack([np.cos(turn), np.sin(turn), 0.1 * turn]), 0.02 + 0.1 * turn / turn[-1]


OUTLINES = {
    "flower": Outline.of(_flower()),
    "corner": Outline.of([np.array([(0, 0), (2, 0), (0.05, 0.03), (0, 1)])]),
    "many": Outline.of([loop for x in range(6) for y in range(4) for loop in _flower(x, y, 30)]),
}
POINTED, RADII = _spring()
TUBES = {
    "spring": Tube.of([(POINTED, RADII, False)]),
    "ring": Tube.of([(POINTED[:60] * (1, 1, 0), 0.1, True)]),
    "balls": Tube.of([(np.array([(0, 0, 0), (0.1, 0, 0), (0.1, 0, 0)]), np.array([0.05, 0.4, 0.3]), False)]),
}


@pytest.mark.parametrize("name", OUTLINES)
def test_outlines_have_the_distance_to_the_nearest_of_all_segments(name):
    outline = OUTLINES[name]
    segments = outline.segments
    low, high = segments.reshape(-1, 2).min(axis=0), segments.reshape(-1, 2).max(axis=0)
    points = np.random.default_rng(1).uniform(low - 0.3, high + 0.3, (3000, 2))
    ends, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    t = ((points[:, None] - ends) * along).sum(axis=2) / (along**2).sum(axis=1)
    nearest = ends + np.clip(t, 0.0, 1.0)[..., None] * along
    expected = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
    expected[windings(segments, points) != 0] *= -1.0
    found = outline.distance(np.column_stack([points, np.zeros(len(points))]))
    np.testing.assert_allclose(found, expected, atol=1e-13)


@pytest.mark.parametrize("name", TUBES)
def test_tubes_have_the_distance_to_the_nearest_of_all_balls(name):
    tube = TUBES[name]
    numbers = tube.data.array
    rows = numbers[int(numbers[1]) :][: 36 * int(numbers[0])].reshape(-1, 9)
    points = np.random.default_rng(1).uniform(*tube.bounds(), (1000, 3)) * 1.3
    s = np.linspace(0.0, 1.0, 300)[:, None]
    expected = np.full(len(points), np.inf)
    for row in rows:
        centers, radii = row[:3] + s * row[7] * row[4:7], row[3] - row[8] * row[7] * s[:, 0]
        expected = np.minimum(expected, (np.linalg.norm(points[:, None] - centers, axis=2) - radii).min(axis=1))
    found = tube.distance(points)
    assert (found <= expected + 1e-12).all()
    np.testing.assert_allclose(found, expected, atol=1e-4)


@pytest.mark.parametrize(
    "function, shape", [(OUTLINE, s) for s in OUTLINES.values()] + [(TUBE, s) for s in TUBES.values()]
)
def test_bounds_over_boxes_hold_for_values_and_slopes(function, shape):
    axes, rng = (2 if function is OUTLINE else 3), np.random.default_rng(4)
    low = rng.uniform(-1.2, 1.2, (3000, axes))
    high = low + rng.uniform(1e-4, 0.2, (3000, 1)) * rng.random((3000, axes))
    address = float(shape.data.address)
    bounds = evaluate(function.bounds, [address, *(end for k in range(axes) for end in (low[:, k], high[:, k]))])
    points = np.moveaxis(low + rng.random((30, 3000, axes)) * (high - low), -1, 0)
    values = evaluate(function, [address, *points])[0]
    assert (bounds[0] <= values).all() and (values <= bounds[1]).all()
    for k, slopes in enumerate(evaluate(function.derivatives, [address, *points])):
        assert (bounds[2 + 2 * k] <= slopes + 1e-12).all() and (slopes <= bounds[3 + 2 * k] + 1e-12).all()
        assert np.mean(bounds[3 + 2 * k] - bounds[2 + 2 * k]) < 1.7


@pytest.mark.parametrize(
    "loops, odd, nonzero",
    [
        ([_square(0.0, 0.0), _square(0.5, 0.5)], 1.5, 1.75),
        ([_square(0.0, 0.0), _square(0.5, 0.5)[::-1]], 1.5, 1.5),
        ([_square(0.0, 0.0), _square(1.0, 0.0)], 2.0, 2.0),
        ([_square(0.0, 0.0), 0.5 * _square(0.5, 0.5)], 0.75, 1.0),
        ([np.array([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])], 0.5, 0.5),
    ],
)
def test_loops_are_filled_by_both_rules(loops, odd, nonzero):
    assert Outline.of(loops).area() == pytest.approx(odd)
    assert Outline.of(loops, nonzero=True).area() == pytest.approx(nonzero)


def test_shapes_of_the_same_data_are_the_same_and_share_their_tree():
    first, again = (SHAPES["extrusion"](Outline.of(_flower()), 0.2, 0.02) for _ in range(2))
    other = SHAPES["extrusion"](Outline.of(_flower(0.1)), 0.2, 0.02)
    assert first == again and hash(first) == hash(again) and first != other
    assert first.formula() is other.formula()  # so nothing compiles
    assert interior.tree(first) is interior.tree(again) and interior.tree(first) is not interior.tree(other)
    assert pickle.loads(pickle.dumps(first)) == copy.deepcopy(first) == first


def test_outlines_and_tubes_combine_with_other_shapes():
    sign = SHAPES["extrusion"](OUTLINES["flower"], 0.2, 0.0)
    points = np.random.default_rng(2).uniform(-0.6, 0.6, (2000, 3))
    moved = Transformed(TUBES["ring"], np.diag([0.4, 0.4, 0.4, 1.0]))
    joined = Union(Difference(sign, Sphere(0.2)), moved)
    expected = np.minimum(np.maximum(sign.distance(points), -Sphere(0.2).distance(points)), moved.distance(points))
    np.testing.assert_allclose(joined.distance(points), expected, atol=1e-12)
    tree = interior.tree(joined)
    assert tree.certified and tree.nodes["mass"][0] > 0.0
    # A field that artists write keeps its table, though it knows an address alone.
    slots = Slots()
    field = Field.of(sign.build(POINT, slots) * 1.5, slots.values)
    del slots
    np.testing.assert_allclose(field.distance(points), 1.5 * sign.distance(points), atol=1e-12)
    assert interior.tree(field).certified


def test_a_gap_opens_a_closed_path():
    turn = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    for gap, left in ((0.5, 2.0 * math.pi - 0.5), (100.0, 0.2 * math.pi)):
        path = with_gap(ring, gap)
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(left, rel=1e-3)


@pytest.mark.parametrize("shape", [*OUTLINES.values(), *TUBES.values()])
def test_glsl_has_the_same_distances(shape):
    points = np.random.default_rng(3).uniform(-1.3, 1.3, (2000, 3)).astype(np.float32)
    numbers = np.concatenate([[0.0], shape.parameters()[1:], shape.data.array])
    first = len(shape.parameters())
    source = f"#define table_number(i) k[{first} + (i)]\n" + codegen_glsl.function(
        shape.formula(), "read", written=set()
    )
    found = glsl.evaluate(source, "read", points, numbers)
    np.testing.assert_allclose(found, shape.distance(points.astype(float)), atol=2e-5)


def test_contours_are_closed_and_around_what_is_above_the_threshold():
    values = np.random.default_rng(1).random((60, 60))
    segments = contour(values, 0.5)
    assert sorted(map(tuple, segments[:, :2])) == sorted(map(tuple, segments[:, 2:]))
    y, x = np.mgrid[:60, :60] + 0.5
    found = Outline(outline_table(segments)).distance(np.stack([x, y, 0.0 * x], axis=-1))
    assert ((found < 0.0) == (values > 0.5)).all()
