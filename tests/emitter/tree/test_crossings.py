# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through interior trees: all crossings, against a march of its own, closed forms, and known answers."""

import numpy as np
import pytest

from sdf_lights.emitter.intersection.intervals import regularize, solve
from sdf_lights.emitter.lamps import SMALLEST_INTERVAL
from sdf_lights.emitter.tree.nodes import BOUNDARY
from sdf_lights.jit import kernel
from sdf_lights.sdf.shapes import Box, Difference, Sphere, Torus, Transformed
from sdf_lights.sdf.shapes.blends import SmoothUnion
from support.lamps import oracle
from support.lamps.hard_cases import HARD_CASES, SHEETS, SLABS, SMOOTH, Steeper, around, published, scattered
from support.lamps.rays import Traced
from support.lamps.shapes_under_test import COMPOSITES, FieldOf, moved
from support.rivals import marching

RAYS = 120


def check(shape, rays, count):
    """Every crossing of a shape is found, as it is and with its closed forms hidden; returns the evaluations per
    ray."""
    origins, directions = rays(shape, np.random.default_rng(5), count)
    truth = oracle.find(shape, origins, directions)
    assert truth.counts.any()
    for traced in (Traced(shape), Traced(FieldOf(shape))):
        found = traced.trace(origins, directions)
        verdict = oracle.judge(shape, origins, directions, found[:, 0], found[:, 1], truth)
        assert verdict.wrong == 0.0
        assert verdict.below < 0.01
        assert verdict.length_error < 1e-8
    return found[:, 3].mean()


@pytest.mark.parametrize("name", HARD_CASES)
def test_hard_cases(name):
    case = HARD_CASES[name]
    check(case.shape, case.rays, RAYS if case.shape.size < 100 else RAYS // 4)


@pytest.mark.slow
@pytest.mark.parametrize("name", HARD_CASES)
def test_hard_cases_with_many_rays(name):
    case = HARD_CASES[name]
    check(case.shape, case.rays, 20_000)


@kernel
def _whole(program, o, d, spans, smallest):
    return regularize(spans, solve(program, o, d, spans), smallest)


@pytest.mark.parametrize("name", COMPOSITES)
def test_pruned_programs_give_the_same_to_the_last_digit(name):
    """Boxes join without seams: the walk gives what the whole program gives along the whole ray."""
    shape = COMPOSITES[name]
    traced = Traced(shape)
    origins, directions = around(shape, np.random.default_rng(3), 400)
    moved_origins, _, segments = traced.segments(origins, directions)
    found = traced.trace(origins, directions)
    smallest = SMALLEST_INTERVAL * np.linalg.norm(traced.tree.half)
    several = 0
    for index, (o, d) in enumerate(zip(moved_origins, directions)):
        spans = np.empty((len(traced.spans), 2))
        count = _whole(traced.tree.program, tuple(o), tuple(d), spans, smallest)
        expected = np.clip(spans[:count], *segments[index])
        expected = expected[expected[:, 1] - expected[:, 0] >= smallest]
        assert found[index, 0] == len(expected)
        assert found[index, 1] == pytest.approx((expected[:, 1] - expected[:, 0]).sum(), abs=1e-15)
        several += len(expected) > 1
    assert several > 10 or name in ("frame", "thin", "coincident", "apart")


def test_empty_and_full_boxes_cost_no_evaluation():
    traced = Traced(FieldOf(Sphere(1.0)))
    past = traced.trace(np.array([[-3.0, 0.9, 0.9]]), np.array([[1.0, 0.0, 0.0]]))
    assert past[0, 0] == 0 and past[0, 3] <= 2  # a box is taken as a whole where the field is monotonic along the ray
    through = traced.trace(np.array([[-3.0, 0.1, 0.2]]), np.array([[1.0, 0.0, 0.0]]))
    assert through[0, 0] == 1
    assert through[0, 1] == pytest.approx(2.0 * np.sqrt(0.95), abs=1e-11)
    assert through[0, 3] <= 14


@pytest.mark.parametrize("shape", [SMOOTH, Torus(0.7, 0.25), scattered(10)], ids=["smooth", "torus", "ten"])
def test_fewer_evaluations_than_the_published_rule(shape):
    """Although it resolves 10,000 times finer, and without counting what the rule's bisections cost."""
    field = Traced(FieldOf(shape))
    origins, directions = around(shape, np.random.default_rng(2), 1500)
    ours = field.trace(origins, directions)
    theirs = field.march(marching.PUBLISHED, origins, directions)
    assert ours[:, 3].mean() * 1.25 < theirs[:, 2].mean()


def test_fields_that_overestimate():
    """The published table: three slabs, by a field three times too steep; the rule misses the thin one."""
    shape = Steeper(SLABS, 3.0)
    traced = Traced(shape)
    origins, directions = published(shape, np.random.default_rng(3), 500)
    found = traced.trace(origins, directions)
    assert np.all(found[:, 0] == 3)
    assert np.allclose(found[:, 1], 1.66 * np.sqrt(1.02), rtol=0.0, atol=1e-10)
    # Rays that reach the box of the slabs are behind the place where the first step would have missed.
    low, high = origins[:, 0] + 0.05, np.full(500, 2.0)
    out = np.zeros((500, 3))
    _march(traced, marching.PUBLISHED, origins, directions, np.stack([np.zeros(500), high - low], axis=1), out)
    assert np.mean(out[:, 0] == 3) < 0.2


def _march(traced, rule, origins, directions, segments, out):
    from support.lamps import rays

    rays._march(
        traced.blocks,
        traced.rows,
        len(traced.tree.field.terms),
        rule,
        1.0,
        1e-3,
        origins - traced.tree.center,
        directions,
        segments,
        out,
    )


def test_origins_inside_begin_at_zero():
    for shape in (Torus(1.0, 0.3), FieldOf(Torus(1.0, 0.3)), SmoothUnion(Sphere(0.5), Box(0.4), radius=0.1)):
        o = (1.0, 0.0, 0.1) if shape.bounds()[1][0] > 1.0 else (0.1, 0.1, 0.1)
        for d in ((1.0, 0.0, 0.0), (0.0, -0.6, 0.8), (-1.0, 0.0, 0.0)):
            first, *_ = Traced(shape).intervals(o, d)
            assert first[0] == pytest.approx(0.0, abs=1e-15)
            assert abs(shape.distance(np.array(o) + first[1] * np.array(d))) < 1e-11


@pytest.mark.parametrize("factor", [1e-3, 0.2, 50.0])
def test_directions_of_any_length(factor):
    shape = FieldOf(SMOOTH)
    traced = Traced(shape)
    origins, directions = around(shape, np.random.default_rng(6), 300)
    plain, scaled = traced.trace(origins, directions), traced.trace(origins, factor * directions)
    assert np.array_equal(plain[:, 0], scaled[:, 0])
    assert np.allclose(plain[:, 1], factor * scaled[:, 1], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize(
    "shape", [Torus(0.7, 0.25), FieldOf(Torus(0.7, 0.25)), SHEETS, SMOOTH], ids=["torus", "field", "sheets", "smooth"]
)
def test_rays_along_axes_and_splits(shape):
    """In planes that divide the tree, along its edges, and through its centre."""
    traced = Traced(shape)
    splits = traced.tree.nodes["split"][traced.tree.nodes["first"] >= 0][:40]
    axes = traced.tree.nodes["axis"][traced.tree.nodes["first"] >= 0][:40]
    origins, directions = [], []
    for axis, split in zip(axes, splits):
        for along in range(3):
            d = np.zeros(3)
            d[along] = 1.0
            o = traced.tree.center + 0.3 * traced.tree.half
            if along != axis:
                o[axis] = traced.tree.center[axis] + split
            o[along] -= 3.0 * traced.tree.half[along]
            origins.append(o)
            directions.append(d)
    origins, directions = np.array(origins), np.array(directions)
    found = traced.trace(origins, directions)
    truth = oracle.find(shape, origins, directions)
    assert np.allclose(found[:, 1], truth.lengths, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("wrapped", [False, True], ids=["program", "field"])
def test_intervals_without_room_are_counted(wrapped):
    """A comb of 33 teeth and room for 5: the nearest are kept, and the rest of the ray is unresolved."""
    slots = [Transformed(Box((0.01, 2, 2)), moved(x)) for x in np.linspace(-0.9, 0.9, 32)]
    comb = Difference(Box((1, 1, 1)), *slots)
    shape = FieldOf(comb) if wrapped else comb
    o, d = np.array([[-5.0, 0.1, 0.2]]), np.array([[1.0, 0.0, 0.0]])
    full, few = Traced(shape), Traced(shape, rows=5)
    assert full.trace(o, d)[0, 0] == 33
    out = few.trace(o, d)[0]
    assert out[0] == 5
    assert np.allclose(few.intervals(o[0], d[0]), full.intervals(o[0], d[0])[:5], rtol=0.0, atol=1e-12)
    assert out[2] == pytest.approx(1.0 + 5.0 - full.intervals(o[0], d[0])[4, 1], abs=1e-6)


def test_one_box_is_a_tree():
    """A shape that is never divided: the walk is a single box."""
    traced = Traced(FieldOf(Sphere(0.5)))
    traced.tables["lamp_nodes"] = nodes = traced.tree.nodes[:1].copy()
    nodes["first"], nodes["state"], nodes["gradient"] = -1, BOUNDARY, [[-np.inf], [np.inf]]
    traced.blocks["lamp_nodes_address"] = nodes.ctypes.data
    assert np.allclose(traced.intervals((-2.0, 0.3, 0.0), (1.0, 0.0, 0.0)), [[1.6, 2.4]], rtol=0.0, atol=1e-11)
    assert len(traced.intervals((-2.0, 0.5001, 0.0), (1.0, 0.0, 0.0))) == 0
