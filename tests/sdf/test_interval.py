# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals hold every value; they are not much wider than they must be."""

import warnings
from fractions import Fraction

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, interval_evaluation, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.loops import iterate
from sdf_lights.graph.operations import CONDITIONS, OPERATIONS
from support.shapes import samples

x, y, z = f.POINT
INFINITY = float("inf")


def operations():
    """Each operation, on coordinates and with numbers of each sign."""
    for kind, operation in OPERATIONS.items():
        if kind == "select":
            yield kind, f.select(x < y, x - z, z)
            yield "select, both conditions", f.select(x <= 0.5, f.select(y < x, f.sqrt(y), z), f.apply("log", x))
        elif kind in CONDITIONS:
            yield kind, f.select(f.apply(kind, x, y), f.constant(1.0), f.constant(2.0))
        else:
            yield kind, f.apply(kind, *f.POINT[: operation.arity])
        if operation.arity == 2 and kind not in CONDITIONS:
            for number in (-2.0, -0.5, 0.0, 2.0, 3.0, 2.5):
                yield f"{kind} of {number}", f.apply(kind, f.constant(number), x)
                yield f"{kind} by {number}", f.apply(kind, x, f.constant(number))
            yield f"{kind} with itself", f.apply(kind, x, x)


def _julia(*states):
    """A round of a quaternion Julia set with the derivative's length, and its bailout."""
    u, v, w, steps = states
    return (u * u - v * v - w * w - 0.2, 2.0 * u * v + 0.6, 2.0 * u * w, steps + 1.0), u * u + v * v + w * w < 16.0


def _nested(u, total):
    (inner,) = iterate(3, (u,), lambda v: ((abs(v) - 0.5 * total,), None), 3)
    return (inner * 1.25, total + inner * x), f.minimum(u, y) < 2.0


LOOPS = {
    "escape": iterate(12, (x, y, z, 0.0), _julia, 12)[3],
    "escaped": f.length(*iterate(6, (x, y, z, 0.0), _julia, 8)[:3]),
    "nested": sum(iterate(f.parameter(0), (x, 0.5), _nested, 4)),
    "no rounds": iterate(-1.0, (x + y,), lambda u: ((u * 2.0,), None), 4)[0],
}


def _floor(a):
    return f.apply("floor", a)


def _whole_numbers():
    """Sums, products and choices of whole numbers, of either sign."""
    u, v = _floor(abs(x)), _floor(y)
    yield "difference", abs(u - _floor(abs(y)))
    yield "products", f.sqrt(u * v - u * u) + abs(v - u * 3.0)
    yield "far", (u * 1e8) * (v * 1e8) + u - abs(1e16 - u)
    yield "minimum", abs(f.minimum(u, v) - u) / (u + 1.0)


REMAINDERS = {
    "fraction": (x - _floor(x), (0.0, 1.0)),
    "remainder": (x - 0.3 * _floor(x / 0.3), (0.0, 0.3)),
    "remainder by a parameter": (x - f.parameter(0) * _floor(x / f.parameter(0)), (0.0, 3.0)),
    "negative period": (x - _floor(x / -0.7) * -0.7, (-0.7, 0.0)),
    "nearest cell": (x - 2.5 * _floor(x * 0.4 + 0.5), (-1.25, 1.25)),
    "of whole numbers": (y - 289.0 * _floor((y + 0.5) * (1.0 / 289.0)), (-0.5, 288.5)),
    "shifted far": (x - _floor((x + 1e9) - 1e9), (-1e-6, 1.0 + 1e-6)),
}

FORMULAS = {f"operation {name}": (formula, ()) for name, formula in operations()}
FORMULAS |= {f"loop, {name}": (formula, (3.0,)) for name, formula in LOOPS.items()}
FORMULAS |= {f"whole numbers, {name}": (formula, ()) for name, formula in _whole_numbers()}
FORMULAS |= {f"remainder, {name}": (formula, (3.0,)) for name, (formula, _) in REMAINDERS.items()}
FORMULAS |= {name: (shape.formula(), shape.parameters()) for name, shape in samples.SHAPES_TO_TRY.items()}


def boxes(count: int = 200, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3) of boxes of all sizes and shapes, near and far: points, slivers, half spaces, all of space."""
    rng = np.random.default_rng(seed)
    center = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-4, 1, (count, 1))
    center[::7] = rng.integers(-2, 3, (len(center[::7]), 3)) / 2.0
    center[1::31] *= 10.0 ** rng.uniform(-300, 150, (len(center[1::31]), 1))
    half = (
        10.0 ** rng.uniform(-17, 1.5, (count, 1))
        * rng.uniform(0, 1, (count, 3))
        * np.maximum(1.0, np.abs(center).max(axis=1, keepdims=True))
    )
    half[::5] = 0.0
    half[1::5, 1] = 0.0
    low, high = center - half, center + half
    low[::6] = np.where(rng.random((len(low[::6]), 3)) < 0.3, 0.0, low[::6])
    low[3::29] = np.where(rng.random((len(low[3::29]), 3)) < 0.5, -INFINITY, low[3::29])
    high[5::29] = np.where(rng.random((len(high[5::29]), 3)) < 0.5, INFINITY, high[5::29])
    low[-1], high[-1] = -INFINITY, INFINITY
    return np.minimum(low, high), np.maximum(low, high)


def points_in(low: np.ndarray, high: np.ndarray, rng) -> np.ndarray:
    """One point (n, 3) of each box; some on faces and corners, some next to them, some at zero."""
    greatest = np.finfo(float).max
    least, most = np.maximum(low, -greatest), np.minimum(high, greatest)
    fraction = rng.choice([0.0, 1.0, -1.0], p=[0.2, 0.2, 0.6], size=low.shape)
    fraction = np.where(fraction < 0.0, rng.random(low.shape), fraction)
    # An infinite side is tried at all orders of magnitude.
    far = rng.choice([-1.0, 1.0], size=low.shape) * 10.0 ** rng.uniform(-5, 308, low.shape)
    with np.errstate(all="ignore"):
        points = np.where(np.isfinite(high - low), least + (most - least) * fraction, far)
    points = np.where(rng.random(low.shape) < 0.1, 0.0, points)
    return np.clip(points, least, most)


def _evaluate(formula, points, parameters, natively: bool):
    yield numpy_evaluation.evaluate(formula, points, parameters)
    if natively and codegen_native.AVAILABLE:
        yield codegen_native.evaluate(formula, points, parameters)


@pytest.mark.parametrize("name", FORMULAS)
def test_every_value_is_inside(name):
    formula, parameters = FORMULAS[name]
    low, high = boxes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        least, most = interval_evaluation.enclose(formula, low, high, parameters)
    assert least.shape == most.shape == (len(low),) and (least <= most).all()
    rng = np.random.default_rng(4)
    defined = 0
    for _ in range(4):
        points = points_in(low, high, rng)
        for values in _evaluate(formula, points, parameters, name not in samples.SHAPES_TO_TRY):
            known = ~np.isnan(values)
            defined += known.sum()
            wrong = known & ~((least <= values) & (values <= most))
            assert not wrong.any(), (points[wrong][0], values[wrong][0], least[wrong][0], most[wrong][0])
    assert defined


@pytest.mark.parametrize("kind", ["add", "subtract", "multiply", "divide"])
def test_exact_results_are_inside(kind):
    """Rounding is outward: the bounds at a point have the exact sum, product and so on between them."""
    rng = np.random.default_rng(5)
    points = rng.normal(size=(2000, 3)) * 10.0 ** rng.uniform(-100, 100, (2000, 1))
    points[:, 1] *= 10.0 ** rng.uniform(-30, 30, 2000)
    points[::3] = points[::3, [0, 0, 2]] * rng.uniform(0.5, 2.0, (len(points[::3]), 3))
    least, most = interval_evaluation.enclose(f.apply(kind, x, y), points, points)
    for (u, v, _), low, high in zip(points, least, most):
        exact = OPERATIONS[kind].meaning(Fraction(u), Fraction(v))
        assert low <= exact <= high
        # Not by more than 3 units in the last place, or the least normal number.
        assert high - low <= 2.0**-50 * abs(exact) + 2.0**-1020


# The steps of Newton's method in a Bézier tube divide by slopes that bounds cannot keep away from 0.
@pytest.mark.parametrize("name", [name for name in samples.SHAPES_TO_TRY if name != "bezier_tube"])
def test_bounds_of_small_boxes_are_tight(name):
    """The width of the bounds is proportional to that of the box, so boxes near the surface become few and thin."""
    shape = samples.SHAPES_TO_TRY[name]
    low, high = samples.window(shape)
    points = (low + high) / 2 + (high - low) * np.random.default_rng(6).uniform(-0.7, 0.7, (60, 3))
    widths = []
    for size in (1e-6, 1e-8):
        half = size * np.abs(points).max()
        least, most = interval_evaluation.enclose(shape.formula(), points - half, points + half, shape.parameters())
        widths.append((most - least) / half)
    # Folds and loops use a coordinate many times over, and each use adds to the width.
    typical = np.median(widths, axis=1)
    assert typical[1] <= 1.5 * typical[0] and typical[1] <= 1000.0


def test_what_is_undefined_has_bounds_all_the_same():
    low, high = np.array([(-2.0, -1.0, 0.0), (-2.0, 4.0, 0.0)]), np.array([(-1.0, -1.0, 0.0), (4.0, 4.0, 0.0)])
    least, most = interval_evaluation.enclose(f.sqrt(x), low, high)
    np.testing.assert_array_equal(least, [-INFINITY, 0.0])
    np.testing.assert_allclose(most, [INFINITY, 2.0])
    assert interval_evaluation.enclose(f.constant(0.0) / f.constant(0.0) + x, low, high)[1].min() == INFINITY
    # √x < 3 wherever there is a root, but NaN < 3 does not hold either: the other side may come out.
    least, most = interval_evaluation.enclose(f.select(f.sqrt(x) < 3.0, 1.0, 2.0) + 0.0 * y, low, high)
    np.testing.assert_array_equal([least, most], [(1.0, 1.0), (2.0, 2.0)])


def test_bounds_know_what_a_square_is():
    box = np.full((1, 3), -2.0), np.full((1, 3), 1.0)
    for formula, bounds in [
        (x * x, (0.0, 4.0)),
        (f.apply("power", x, 2.0), (0.0, 4.0)),
        (f.apply("power", x, 3.0), (-8.0, 1.0)),
        (f.apply("power", x, -2.0), (0.25, INFINITY)),
        (f.length(x, y, z), (0.0, 12.0**0.5)),
        (f.apply("sin", 10.0 * x), (-1.0, 1.0)),
        (f.cos(x), (np.cos(2.0), 1.0)),
        (f.apply("atan2", y, x), (-np.pi, np.pi)),
        (f.apply("atan2", y + 3.0, x), (np.arctan2(1, 1), np.arctan2(1, -2))),
    ]:
        np.testing.assert_allclose(np.ravel(interval_evaluation.enclose(formula, *box)), bounds, atol=1e-12)


@pytest.mark.parametrize("name", REMAINDERS)
def test_bounds_know_what_a_remainder_is(name):
    formula, expected = REMAINDERS[name]
    low, high = interval_evaluation.enclose(formula, np.full((1, 3), -20.0), np.full((1, 3), 30.0), [3.0])
    np.testing.assert_allclose([low[0], high[0]], expected, atol=1e-5)


def test_numbers_stay_exact():
    """An exponent that is computed is still whole, so negative numbers have powers."""
    formula = f.apply("power", x, f.parameter(0) - 1.0)
    box = np.full((1, 3), -2.0), np.full((1, 3), -1.0)
    np.testing.assert_allclose(np.ravel(interval_evaluation.enclose(formula, *box, [4.0])), (-8.0, -1.0))


def test_whole_numbers_stay_whole():
    """Hashes multiply them until a rounding error of the first would be all that is left of the last."""
    hashed = _floor(x)
    for _ in range(6):
        hashed = (34.0 * hashed + 1.0) * hashed
        hashed = hashed - 289.0 * _floor((hashed + 0.5) * (1.0 / 289.0))
    low, high = interval_evaluation.enclose(hashed, np.full((1, 3), 17.25), np.full((1, 3), 17.75))
    assert low == high == numpy_evaluation.evaluate(hashed, np.full((1, 3), 17.5))


def test_no_boxes():
    low, high = interval_evaluation.enclose(f.length(x, y), np.zeros((0, 3)), np.zeros((0, 3)))
    assert low.shape == high.shape == (0,)


def test_deep_formulas():
    deep = x
    for i in range(10_000):
        deep = deep + float(i % 7)
    low, high = interval_evaluation.enclose(deep, np.zeros((1, 3)), np.ones((1, 3)))
    total = sum(i % 7 for i in range(10_000))
    assert low <= total <= total + 1 <= high <= low + 1.001
