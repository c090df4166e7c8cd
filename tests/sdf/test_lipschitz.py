# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No slope that is measured is greater than the bound, and on exact distances the bound is seldom more than 1."""

import warnings

import numpy as np
import pytest

from sdf_lights.graph import formula as f
from sdf_lights.graph import interval_evaluation, lipschitz, numpy_evaluation
from sdf_lights.graph.loops import iterate
from sdf_lights.sdf.noise import value_noise
from sdf_lights.sdf.shapes import SHAPES, Box, Transformed
from sdf_lights.sdf.shapes.base import EXACT
from support.shapes import samples

x, y, z = f.POINT


def boxes(shape, count: int, seed: int):
    """Boxes (n, 3) of all sizes in and around a shape, some of them flat, many on its planes of symmetry."""
    rng = np.random.default_rng(seed)
    low, high = samples.window(shape)
    extent = high - low
    center = (low + high) / 2 + extent * rng.uniform(-0.8, 0.8, (count, 3))
    center = np.where(rng.random((count, 3)) < 0.1, (low + high) / 2, center)
    half = extent.max() * 10.0 ** rng.uniform(-5, 0.3, (count, 1)) * rng.uniform(0, 1, (count, 3))
    half = np.where(rng.random((count, 3)) < 0.05, 0.0, half)
    return center - half, center + half


@pytest.mark.parametrize("name", samples.SHAPES_TO_TRY)
def test_no_slope_is_steeper_than_its_bound(name):
    shape = samples.SHAPES_TO_TRY[name]
    low, high = boxes(shape, 100, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bounds = lipschitz.lipschitz(shape.formula(), low, high, shape.parameters())
        whole = lipschitz.lipschitz(shape.formula(), low, high, shape.parameters(), parts=1)
    assert not np.isnan(bounds).any() and (bounds >= 0.0).all()
    rng = np.random.default_rng(2)
    for scale in (1.0, 1e-3):
        a, b = low + (high - low) * rng.random((2, 8, len(low), 3))
        b = np.clip(a + scale * (b - a), low, high)
        values = shape.distance(np.stack([a, b]))
        rise, run = np.abs(values[0] - values[1]), np.linalg.norm(a - b, axis=-1)
        # Differences are known to the rounding of the values.
        rounding = 1e-13 * (1.0 + np.abs(values).max(axis=0))
        assert (rise <= bounds * run + rounding).all()
        assert (rise <= whole * run + rounding).all()


def _direct(shape) -> bool:
    """Exact, and neither a loop nor a root found by iteration: of those the rounds' bounds multiply."""
    return (
        shape.exactness == EXACT
        and shape.lipschitz == 1.0
        and shape.name() != "bezier_tube"
        and not any(node.kind == f.ITERATE for node in f.order(shape.formula()))
    )


@pytest.mark.parametrize("name", [name for name, shape in samples.SHAPES_TO_TRY.items() if _direct(shape)])
def test_bounds_of_small_boxes_are_near_one(name):
    """Creases and centres, of which a small box seldom has any, may have more."""
    shape = samples.SHAPES_TO_TRY[name]
    rng = np.random.default_rng(3)
    low, high = samples.window(shape)
    center = (low + high) / 2 + (high - low) * rng.uniform(-0.6, 0.6, (200, 3))
    half = 1e-3 * (high - low).min()
    bounds = lipschitz.lipschitz(shape.formula(), center - half, center + half, shape.parameters())
    assert np.quantile(bounds, 0.9) <= 1.2
    assert (bounds >= 1.0 - 1e-6).mean() >= 0.9


def _bound(formula, low=-1.0, high=1.0, parameters=()):
    return lipschitz.lipschitz(formula, np.full((1, 3), low), np.full((1, 3), high), parameters)[0]


@pytest.mark.parametrize(
    "formula, bound",
    [
        (f.constant(3.0) + f.parameter(0), 0.0),
        (3.0 * x - 4.0 * y, 5.0),
        (x * x, 2.0),
        (f.length(x, y, z), 1.0),
        (f.length(f.length(x, y) - 0.5, z), 1.0),
        (f.sqrt(f.minimum(x * x + y * y, x * x + z * z)), 1.0),
        (f.sqrt(4.0 * (x * x + y * y) / 16.0), 0.5),
        (abs(abs(x) - 0.5), 1.0),
        (f.sin(x), 1.0),
        (f.sqrt(x + 1.0), np.inf),
        (f.apply("atan2", y, x), np.inf),
        (f.apply("atan2", y, x + 2.0), 1.0),
        (1.0 / x, np.inf),
        (1.0 / (x + 2.0), 1.0),
        (f.maximum(x, 0.0) + f.minimum(x, 0.0), 1.0),
        (f.sqrt(x * x + 1.0), 2.0**-0.5),
        (f.apply("exp", x), np.e),
        (f.apply("log", x + 2.0), 1.0),
        (f.length(0.6 * x + 0.8 * y, 0.8 * x - 0.6 * y), 1.0),
    ],
)
def test_bounds_of_simple_formulas(formula, bound):
    assert bound * (1.0 - 1e-12) <= _bound(formula, parameters=[1.0]) <= bound * (1.0 + 1e-9)


_ASIDE = np.eye(4)
_ASIDE[:3, 3] = (0.5, 0.1, 0.0)
_CELL = 2.0 * f.apply("floor", 0.5 * x + 0.5)  # of x, in cells of two metres
_TURN = f.apply("atan2", y, x + 0.001)


@pytest.mark.parametrize(
    "formula, sides, jumps",
    [
        (x - f.apply("floor", x), 1.0, True),
        (abs(x - f.apply("floor", x) - 0.5), 1.0, False),  # the same on both sides of each step
        (abs(x - f.apply("floor", x) - 0.4), 1.0, True),
        (f.length(3.0 * (x - f.apply("floor", x + 0.5)), y), 3.0, False),
        (f.cos(2.0 * np.pi * (x - f.apply("floor", x))), 2.0 * np.pi, False),
        (f.cos(np.pi * (x - f.apply("floor", x))), np.pi, True),
        (abs(x - 2.0 * f.apply("floor", 0.5 * x + 0.5)) - 0.3, 1.0, False),
        (x - _CELL, 1.0, False),  # no step is inside
        (x - (0.5 + 0.1 * y) * f.apply("floor", x / (0.5 + 0.1 * y)), 1.0, True),
        (f.select(x < 0.5, 2.0 * x, 3.0 * y), 3.0, True),
        (f.select(x < 0.5, 2.0 * x, 3.0 * y) * 0.0 + x, 1.0, False),
        (f.select(x < 0.0, -x, x) + y, 2.0, False),  # written another way
        (f.select(x < 0.5, x * x, x - 0.25), 2.0, False),  # a polynomial that goes on smoothly
        (f.select(x < 0.5, x * x, x - 0.2), 2.0, True),
        (f.select(x < 2.0, 2.0 * x, 3.0 * y), 2.0, False),  # decided in all of the box
        (f.minimum(f.select(x < 0.0, 5.0, 6.0), y), 1.0, False),  # the discontinuity is not what the minimum takes
        (f.minimum(f.select(x < 0.0, 0.0, 6.0), y), 1.0, True),
        (f.sin(3.0 * _TURN) * 0.0 + f.apply("tan", 2.0 * x), np.inf, True),
        (f.power(x, 1.5), 1.5, True),  # it has no value below 0
    ],
)
def test_what_jumps_has_no_bound_of_its_slope(formula, sides, jumps):
    low, high = np.full((1, 3), -0.8), np.full((1, 3), 0.9)
    found = lipschitz.lipschitz(formula, low, high, jumps=False)[0]
    if formula.kind != "power":
        assert found >= sides * 0.5 if np.isfinite(sides) else found == np.inf
    assert np.isinf(lipschitz.lipschitz(formula, low, high)[0]) == jumps
    assert lipschitz.discontinuous(formula, low, high)[0] == jumps
    if jumps:
        assert lipschitz.may_be_discontinuous(formula)


@pytest.mark.parametrize("turns, jumps", [(2.0, False), (3.0, False), (2.5, True)])
def test_the_cut_of_an_angle(turns, jumps):
    """A wave around the axis closes if a whole number of them fits."""
    low, high = np.array([[-0.9, -0.1, 0.0]]), np.array([[-0.7, 0.1, 0.2]])
    assert lipschitz.discontinuous(f.sin(turns * f.apply("atan2", y, x)) + x, low, high)[0] == jumps
    assert not lipschitz.discontinuous(f.sin(turns * f.apply("atan2", y, x)) + x, low + 1.6, high + 1.6)[0]


def _number(value):
    return f.Vector(*map(f.constant, value)) if isinstance(value, tuple) else f.constant(value)


def test_noise_and_shapes_are_continuous_though_they_round():
    low, high = np.array([[-0.9, -0.35, -0.3]]), np.array([[-0.3, 0.35, 0.3]])
    rows = SHAPES["repetition"](Box(0.1), (3, 1, 1), 0.5)
    ring = SHAPES["polar_repetition"](Transformed(Box(0.1), _ASIDE), 5.0)
    for shape in (rows, ring):
        moved = shape.build(f.Vector(x + 0.1 * f.sin(y), y, z), _number)
        assert lipschitz.lipschitz(moved, low, high)[0] == lipschitz.lipschitz(moved, low, high, jumps=False)[0]
        discontinuous = shape.build(f.Vector(x + 0.1 * f.apply("floor", 3.0 * y), y, z), _number)
        assert lipschitz.discontinuous(discontinuous, low, high)[0]
    noise = value_noise(f.Vector(4.0 * x, 4.0 * y, 4.0 * z))
    assert np.isfinite(lipschitz.lipschitz(noise, low, high)[0])
    assert lipschitz.discontinuous(value_noise(f.Vector(4.0 * f.apply("floor", x + 0.5 * y), y, z)), low, high)[0]


def test_bounds_of_the_gradient_have_it_between_them():
    formula = f.length(f.length(x, y) - 0.5, z)
    low, high = lipschitz.gradient_bounds(formula, np.array([(0.6, -0.1, 0.05)]), np.array([(0.8, 0.1, 0.1)]))
    # Out of the tube's middle at (0.5, 0, 0): mostly along x, a little up, and either way along y.
    assert low.shape == high.shape == (1, 3)
    assert 0.6 < low[0, 0] < high[0, 0] <= 1.0 and -0.3 < low[0, 1] < 0.0 < high[0, 1] < 0.3 and 0.1 < low[0, 2]


def test_loops():
    """A fold that is repeated, and points that leave a loop early."""
    (folded,) = iterate(f.parameter(0), (x,), lambda u: ((abs(u) - 0.5,), None), 5)
    assert _bound(folded, parameters=[3.0]) == pytest.approx(1.0)
    grown = iterate(4, (x, 1.0), lambda u, n: ((2.0 * u, n + 1.0), abs(u) < 1.0), 4)[0]
    assert _bound(grown, 0.3, 0.4) == pytest.approx(4.0)  # 0.3 … 0.8 go on, 1.2 … 1.6 do not
    sides = lipschitz.lipschitz(grown, np.full((1, 3), 0.3), np.full((1, 3), 0.9), jumps=False)[0]
    assert sides == pytest.approx(4.0)
    assert _bound(grown, 0.3, 0.9) == np.inf  # between points that go on and points that do not, it jumps
    assert _bound(grown, 2.0, 3.0) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "formula, bound, loose",
    [
        (f.length(x, y, z), 1.0, 1.01),
        (x * x * y, 5.0**0.5, 1.1),
        (f.sin(3.0 * x) * f.cos(2.0 * y), 3.0, 1.1),
        (x * (1.0 - x), 3.0, 1.1),
        (f.sqrt(x), np.inf, 1.0),
    ],
)
def test_global_bounds(formula, bound, loose):
    found = lipschitz.global_lipschitz(formula, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert bound * (1.0 - 1e-9) <= found <= bound * loose


def test_global_bounds_of_shapes():
    for name in ("torus", "box", "nested", "three"):
        shape = samples.SHAPES_TO_TRY[name]
        bound = lipschitz.global_lipschitz(shape.formula(), *samples.window(shape), shape.parameters())
        points = samples.points(shape, 500)[:500]
        step = 1e-6 * np.random.default_rng(4).normal(size=points.shape)
        slopes = np.abs(shape.distance(points + step) - shape.distance(points)) / np.linalg.norm(step, axis=1)
        assert slopes.max() <= bound * (1.0 + 1e-6) and bound <= 3.0
    assert lipschitz.global_lipschitz(x * x, np.full(3, -np.inf), np.full(3, np.inf)) == np.inf
    assert lipschitz.global_lipschitz(f.length(x, y, z), np.full(3, -np.inf), np.full(3, np.inf)) == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", samples.SHAPES_TO_TRY)
def test_no_slope_is_steeper_than_the_global_bound(name):
    shape = samples.SHAPES_TO_TRY[name]
    low, high = samples.window(shape)
    bound = lipschitz.global_lipschitz(shape.formula(), low, high, shape.parameters())
    rng = np.random.default_rng(5)
    a = low + (high - low) * rng.random((20_000, 3))
    b = np.clip(a + rng.normal(size=a.shape) * (high - low) * 10.0 ** rng.uniform(-7, 0, (len(a), 1)), low, high)
    values = shape.distance(np.stack([a, b]))
    rounding = 1e-14 * (1.0 + np.abs(values).max(axis=0))
    assert (np.abs(values[0] - values[1]) <= bound * np.linalg.norm(a - b, axis=1) + rounding).all()


def test_slopes_of_boxes_without_values():
    """Where a formula has no value nothing is known of its slope, and nothing is claimed."""
    assert _bound(f.sqrt(x), -2.0, -1.0) == np.inf
    low, high = interval_evaluation.enclose(f.sqrt(x), np.full((1, 3), -2.0), np.full((1, 3), -1.0))
    assert (low, high) == (-np.inf, np.inf)
    assert np.isnan(numpy_evaluation.evaluate(f.sqrt(x), np.full((1, 3), -1.5))).all()
