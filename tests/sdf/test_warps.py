# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Warped and displaced shapes: the set by pointwise definition, slopes by Jacobians and by pairs; noise."""

import itertools
import math

import numpy as np
import pytest

from sdf_lights.graph import numpy_evaluation
from sdf_lights.graph.formula import CONSTANT, POINT, VARIABLE, Vector, axis_of, order
from sdf_lights.graph.operations import OPERATIONS
from sdf_lights.sdf.noise import PERIOD, STEEPEST, value_noise
from sdf_lights.sdf.shapes import BOUND, Box, Cylinder, Ellipsoid, Sphere, Transformed, Union
from sdf_lights.sdf.shapes.base import Slots
from sdf_lights.sdf.shapes.displacement import NoiseDisplacement, WaveDisplacement
from sdf_lights.sdf.shapes.solids import HalfSpace
from sdf_lights.sdf.shapes.warps import Bend, Taper, Twist
from support.shapes.operated import CORNER, PAIR, SHEARED, moved

CHILDREN = {"box": Box((0.3, 0.2, 0.4)), "corner": CORNER, "pair": moved(PAIR, 0.2, 0.3, 0.1), "sheared": SHEARED}
WARPS = {
    "twist": lambda c: Twist(c, 3.0),
    "strong twist": lambda c: Twist(c, -20.0),
    "bend": lambda c: Bend(c, 2.0),
    "strong bend": lambda c: Bend(c, c.bounds()[1][2] + 0.3),
    "taper": lambda c: Taper(c, 1.2, 0.3),
    "spread": lambda c: Taper(c, 0.1, 2.0),
}
DISPLACED = {
    "waves": lambda c: WaveDisplacement(c, 0.08, (0.2, 0.4, 1e9), (0.3, 0.0, 0.2)),
    "noise": lambda c: NoiseDisplacement(c, 0.1, 0.3, 4.0, 5.0),
}
each_child = pytest.mark.parametrize("child", CHILDREN.values(), ids=CHILDREN)
each_warp = pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)


def around(shape, count, beyond=0.3, seed=1):
    low, high = shape.bounds()
    return np.random.default_rng(seed).uniform(low - beyond * (high - low), high + beyond * (high - low), (count, 3))


def unwarped(shape, at):
    slots = Slots()
    return np.stack([numpy_evaluation.evaluate(q, at, slots.values) for q in shape._asked(POINT, slots)], axis=-1)


def greatest_slope(shape, pairs=40_000):
    a = around(shape, pairs)
    low, high = shape.bounds()
    b = a + np.random.default_rng(2).normal(size=a.shape) * (high - low) * 1e-4
    return (np.abs(shape.distance(a) - shape.distance(b)) / np.linalg.norm(a - b, axis=1)).max()


@each_child
@each_warp
def test_a_warp_is_where_the_child_was(warp, child):
    shape = warp(child)
    assert shape.validate() == ""
    at = around(shape, 20_000)
    before = child.distance(unwarped(shape, at))
    clear = np.abs(before) > 1e-9
    np.testing.assert_array_equal((shape.distance(at) <= 0.0)[clear], (before <= 0.0)[clear])
    inside = before < -1e-9
    np.testing.assert_allclose(shape.distance(at[inside]) * max(shape._stretch(), 1.0), before[inside], atol=1e-12)


@each_child
@each_warp
def test_stretch_bounds_the_jacobian_near_the_child(warp, child):
    """Numerically, wherever the child is nearer than the margin; and the bound is not idle."""
    shape = warp(child)
    low, high = child.bounds()
    at = around(shape, 20_000)
    q = unwarped(shape, at)
    near = np.linalg.norm(np.maximum(np.maximum(low - q, q - high), 0.0), axis=1) < shape._margin
    at, step = at[near], 1e-6
    columns = [(unwarped(shape, at + step * e) - unwarped(shape, at - step * e)) / (2.0 * step) for e in np.eye(3)]
    greatest = np.linalg.svd(np.stack(columns, axis=-1), compute_uv=False)[:, 0].max()
    assert greatest <= shape._stretch() * (1.0 + 1e-6)
    assert greatest > 0.4 * shape._stretch()


@each_child
@pytest.mark.parametrize("make", [*WARPS.values(), *DISPLACED.values()], ids=[*WARPS, *DISPLACED])
def test_fields_keep_their_slope(make, child):
    shape = make(child)
    assert shape.lipschitz == pytest.approx(1.0) and shape.exactness == BOUND and shape.certified
    assert greatest_slope(shape) <= 1.0 + 1e-9


def test_the_twist_turns_by_its_angle():
    bar = Twist(moved(Box((0.5, 0.05, 1.0)), 0.5, 0.0, 0.0), math.radians(90.0))
    for height in (-0.9, 0.0, 0.5, 0.9):
        angle = math.radians(90.0) * height
        point = np.array([0.9 * math.cos(angle), 0.9 * math.sin(angle), height])
        assert bar.distance(point) < 0.0 < bar.distance(point * (-1.0, -1.0, 1.0))
    assert bar.volume() == pytest.approx(0.2)


def test_the_bend_makes_rings():
    bar = Bend(Box((math.pi * 0.99, 0.1, 0.1)), 1.0)
    angle = np.linspace(-0.95 * math.pi, 0.95 * math.pi, 50)
    middle = np.stack([np.sin(angle), np.zeros(50), 1.0 - np.cos(angle)], axis=1)
    np.testing.assert_allclose(bar.distance(middle) * bar._stretch(), -0.1, atol=1e-12)
    assert bar.distance(np.array([0.0, 0.0, 1.0])) > 0.0 and bar.distance(np.array([0.0, 0.0, 2.0])) > 0.0
    # A bend of no account at all, to the last digits.
    at = around(CORNER, 1000, 0.0)
    straight = Bend(CORNER, 1e8)
    assert (
        np.abs(straight.distance(at) - np.minimum(CORNER.distance(at), straight._margin))[
            CORNER.distance(at) < 0.0
        ].max()
        < 1e-7
    )


def test_the_taper_scales_its_ends():
    cone = Taper(Cylinder(0.5, 2.0), 1.0, 0.2)
    for height, scale in ((-1.0, 1.0), (0.0, 0.6), (1.0, 0.2)):
        assert cone.distance(np.array([0.49 * scale, 0.0, 0.999 * height])) < 0.0
        assert cone.distance(np.array([0.51 * scale, 0.0, 0.999 * height])) > 0.0
    np.testing.assert_allclose(cone.bounds()[1], (0.5, 0.5, 1.0))


@pytest.mark.parametrize(
    "shape, problem",
    [
        (Twist(HalfSpace()), "Twist: the shape has no end: intersect it with a box first."),
        (
            Bend(Sphere(0.5), 0.4),
            "Bend: the shape, 0.5 high, reaches the centre of the circle of radius 0.4: make the radius larger.",
        ),
        (
            Bend(Box((5.0, 0.1, 0.1)), 1.0),
            "Bend: the shape is longer than the circle of radius 1 is round: make the radius larger.",
        ),
        (Taper(Sphere(), 0.0, 1.0), "Taper: bottom is 0, but must be at least 0.01."),
        (Bend(Sphere(-1.0), 0.4), "Sphere: radius is -1, but must be at least 1e-06."),
    ],
)
def test_what_is_wrong_is_said(shape, problem):
    assert shape.validate() == problem


# -- displacement -----------------------------------------------------------------------------------------------------


@each_child
def test_waves_by_hand(child):
    shape = WaveDisplacement(child, 0.08, (0.2, 0.4, 1e9), (0.25, 0.0, 0.0))
    at = around(shape, 5000)
    wave = np.cos(math.tau * (at[:, 0] / 0.2 + 0.25)) * np.cos(math.tau * at[:, 1] / 0.4)
    slope = 0.08 * math.tau / 0.2
    expected = (shape._guarded.distance(at) + 0.08 * wave) / (1.0 + slope)
    np.testing.assert_allclose(shape.distance(at), expected, atol=1e-9)  # 2π z / 1e9 is not quite 0


def test_waves_are_as_steep_as_they_say():
    wave = WaveDisplacement(Sphere(), 1.0, (0.3, 0.5, 0.7))
    slots = Slots()
    pattern = wave._pattern(POINT, slots)
    at = np.random.default_rng(1).uniform(-1.0, 1.0, (200_000, 3))
    columns = [
        (
            numpy_evaluation.evaluate(pattern, at + 1e-6 * e, slots.values)
            - numpy_evaluation.evaluate(pattern, at - 1e-6 * e, slots.values)
        )
        / 2e-6
        for e in np.eye(3)
    ]
    assert 0.98 < np.linalg.norm(columns, axis=0).max() / wave._steepest() < 1.0 + 1e-6


def test_noise_stays_within_one_and_is_as_steep_as_it_says():
    """By its definition: trilinear interpolation of ±1 with the quintic fade, over a cell and all corner values.

    The length of the gradient is convex in the corners' values, so those are its extremes.
    """
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=8))).reshape(-1, 2, 2, 2)
    grid = np.linspace(0.0, 0.5, 26)  # the other half of each axis is its mirror image
    fade = grid**3 * (grid * (6.0 * grid - 15.0) + 10.0)
    weight, slope = np.stack([1.0 - fade, fade]), 30.0 * grid**2 * (1.0 - grid) ** 2 * np.array([[-1.0], [1.0]])
    squared = sum(
        np.einsum("nijk,ia,jb,kc->nabc", corners, *factors, optimize=True) ** 2
        for factors in ((slope, weight, weight), (weight, slope, weight), (weight, weight, slope))
    )
    assert math.sqrt(squared.max()) == pytest.approx(STEEPEST, abs=1e-12)

    at = np.random.default_rng(1).uniform(-400.0, 400.0, (200_000, 3))
    noise = numpy_evaluation.evaluate(value_noise(POINT), at)
    assert -1.0 <= noise.min() < -0.98 and 0.98 < noise.max() <= 1.0 and abs(noise.mean()) < 0.01


def test_noise_is_random_numbers_at_whole_points():
    at = np.stack(np.meshgrid(*[np.arange(-8.0, 8.0)] * 3), axis=-1).reshape(-1, 3)
    values = numpy_evaluation.evaluate(value_noise(POINT, 3.0), at)
    lattice = (values + 1.0) * (PERIOD - 1.0) / 2.0
    np.testing.assert_allclose(lattice, np.round(lattice), atol=1e-9)
    assert len(np.unique(np.round(lattice))) == PERIOD
    for offset in (1, 16, 256):  # neighbours along z, x and y have nothing to do with each other
        assert abs(np.corrcoef(values[:-offset], values[offset:])[0, 1]) < 0.1
    assert abs(np.corrcoef(values, numpy_evaluation.evaluate(value_noise(POINT, 4.0), at))[0, 1]) < 0.1
    np.testing.assert_allclose(numpy_evaluation.evaluate(value_noise(POINT, 3.0), at + PERIOD), values, atol=1e-12)


def test_noise_needs_no_more_than_single_precision_for_its_integers():
    """In float32 the noise is that of float64, to rounding: no step of the hash leaves the exact integers."""
    at = np.random.default_rng(1).uniform(-50.0, 50.0, (20_000, 3)).astype(np.float32)
    formula = value_noise(POINT, 7.0)
    values = {}
    for node in order(formula):
        if node.kind == CONSTANT:
            values[node] = np.float32(node.value)
        elif node.kind == VARIABLE:
            values[node] = at[:, axis_of(node)]
        else:
            values[node] = OPERATIONS[node.kind].meaning(*(values[o] for o in node.operands))
        assert values[node].dtype == np.float32
    assert np.abs(values[formula] - numpy_evaluation.evaluate(formula, at)).max() < 3e-5


def test_octaves_add_detail_and_keep_the_amplitude():
    at = np.random.default_rng(1).uniform(-3.0, 3.0, (50_000, 3))
    for octaves in (1.0, 2.0, 6.0):
        shape = NoiseDisplacement(Sphere(), 1.0, 0.5, octaves)
        slots = Slots()
        pattern = shape._pattern(POINT, slots)
        values = numpy_evaluation.evaluate(pattern, at, slots.values)
        assert np.abs(values).max() <= 1.0
        first = 0.5 / (1.0 - 0.5**octaves)
        coarse = first * numpy_evaluation.evaluate(value_noise(Vector(*(2.0 * q for q in POINT))), at)
        assert np.abs(values - coarse).max() <= 1.0 - first + 1e-12


@pytest.mark.parametrize("make", DISPLACED.values(), ids=DISPLACED)
def test_displaced_shapes_are_pruned_part_by_part(make):
    parts = [moved(Sphere(0.3), x, 0.0, 0.0) for x in range(6)]
    terms = make(Union(parts)).terms(np.eye(4), 1.0)
    assert [term.arity for term in terms].count(0) == 7 and all(term.lipschitz <= 1.0 for term in terms)
    tall = Transformed(Ellipsoid(), np.diag([1.0, 1.0, 5.0, 1.0]))
    assert np.isfinite(make(tall).bounds()).all()
