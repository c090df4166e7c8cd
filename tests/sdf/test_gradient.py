# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradients against differences of values, on every operation, loop and shape."""

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.gradient import gradient
from sdf_lights.graph.loops import iterate
from sdf_lights.graph.operations import CONDITIONS, OPERATIONS
from sdf_lights.sdf.shapes.base import EXACT
from support.shapes import samples

x, y, z = f.POINT


def _read(formula, points, parameters):
    return np.stack([numpy_evaluation.evaluate(part, points, parameters) for part in gradient(formula)], axis=-1)


def _differences(formula, points, parameters, step):
    """Central differences (n, 3), and how far those to both sides are apart (n, 3)."""
    found, bend = [], []
    here = numpy_evaluation.evaluate(formula, points, parameters)
    for axis in range(3):
        offset = step * np.eye(3)[axis]
        after, before = (numpy_evaluation.evaluate(formula, points + sign * offset, parameters) for sign in (1.0, -1.0))
        found.append((after - before) / (2.0 * step))
        bend.append(np.abs(after - 2.0 * here + before) / step)
    return np.stack(found, axis=-1), np.stack(bend, axis=-1)


def operations():
    """Each operation where it is smooth, with inner derivatives along all axes."""
    u, v = x * y + 0.5 * z, y - x * z
    inside = f.sin(u) * 0.9
    operands = {
        "sqrt": (u * u + 0.1,),
        "asin": (inside,),
        "acos": (inside,),
        "log": (u * u + 0.1,),
        "power": (u * u + 0.1, v),
        "divide": (u, v * v + 0.5),
    }
    for kind, operation in OPERATIONS.items():
        if kind == "select":
            yield kind, f.select(u < v, u * v, v - u)
        elif kind not in CONDITIONS:
            yield kind, f.apply(kind, *operands.get(kind, (u, v)[: operation.arity]))
    yield "power of a negative number", f.apply("power", u, 17.0)
    yield "power of a parameter", f.apply("power", abs(u) + 0.1, f.parameter(0))


def _escape(u, v, n):
    return (u * u - v * v + x, 2.0 * u * v + y, n + z), u * u + v * v < 4.0


def _inner(a, total):
    (b,) = iterate(2, (a * y,), lambda c: ((f.sin(c) + total * z,), None), 2)
    return (b + a, total * b), None


LOOPS = {
    "parameter": iterate(f.parameter(0), (x,), lambda u: ((u * u - y,), None), 9)[0],
    "escape": f.length(*iterate(7, (x, y, z), _escape, 7)),
    "nested": sum(iterate(3, (x, z), _inner, 3)),
    "with captures": iterate(3, (1.0,), lambda u: ((u * f.cos(x * y) + z,), u < 2.0), 3)[0] * x,
}

FORMULAS = {f"operation {name}": formula for name, formula in operations()}
FORMULAS |= {f"loop, {name}": formula for name, formula in LOOPS.items()}


@pytest.mark.parametrize("name", FORMULAS)
def test_gradients_are_limits_of_differences(name):
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (500, 3))
    found = _read(FORMULAS[name], points, [3.0])
    expected, bend = _differences(FORMULAS[name], points, [3.0], 1e-5)
    smooth = (bend < 1e-2 * (1.0 + np.abs(expected))).all(axis=1)
    assert smooth.mean() > 0.9
    np.testing.assert_allclose(found[smooth], expected[smooth], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", samples.SHAPES_TO_TRY)
def test_gradients_of_shapes(name):
    shape = samples.SHAPES_TO_TRY[name]
    low, high = samples.window(shape)
    extent = (high - low).max()
    points = (low + high) / 2 + extent * np.random.default_rng(2).uniform(-0.7, 0.7, (200, 3))
    found = _read(shape.formula(), points, shape.parameters())
    step = 1e-6 * extent
    expected, bend = _differences(shape.formula(), points, shape.parameters(), step)
    # A field that is continuous has a slope on both sides of its creases; a second difference shows them.
    smooth = (bend < 1e-3).all(axis=1) & np.isfinite(found).all(axis=1)
    assert smooth.mean() > 0.7
    agree = np.abs(found - expected)[smooth].max(axis=1) < 1e-3
    assert agree.mean() > 0.97
    if shape.exactness == EXACT:
        np.testing.assert_allclose(np.linalg.norm(found[smooth][agree], axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("name", ["sphere", "torus", "box", "capsule", "cylinder", "cone", "nested"])
def test_gradients_are_finite_everywhere(name):
    """At centres and creases, where differences have no limit, tiny and far away."""
    shape = samples.SHAPES_TO_TRY[name]
    found = _read(shape.formula(), samples.points(shape, 500), shape.parameters())
    assert np.isfinite(found).all()
    assert np.linalg.norm(found, axis=1).max() <= shape.lipschitz * 2.0 + 1e-9


def test_the_gradient_of_a_length_at_its_centre_is_zero():
    origin = np.zeros((1, 3))
    np.testing.assert_array_equal(_read(f.length(x, y, z), origin, ()), origin)
    np.testing.assert_array_equal(_read(f.apply("atan2", y, x), origin, ()), origin)


def test_gradients_of_what_does_not_depend_on_the_point():
    zero = f.constant(0.0)
    assert gradient(f.parameter(0) * 2.0) == (zero, zero, zero)
    assert gradient(x + f.sin(f.parameter(0))) == (f.constant(1.0), zero, zero)
    assert gradient(f.apply("floor", x * y)) == (zero, zero, zero)


def test_a_loop_runs_once_for_its_value_and_its_gradient():
    formula = LOOPS["escape"]
    loops = {node for part in gradient(formula) for node in f.order(part) if node.kind == f.ITERATE}
    assert len(loops) == 1


def test_gradients_of_gradients():
    """They are formulas like any other."""
    second = gradient(gradient(f.sin(x * y)).x).x
    points = np.random.default_rng(3).normal(size=(50, 3))
    u, v = points[:, 0], points[:, 1]
    np.testing.assert_allclose(numpy_evaluation.evaluate(second, points), -v * v * np.sin(u * v), atol=1e-12)


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
def test_gradients_are_read_natively():
    for name in ("torus", "three"):
        shape = samples.SHAPES_TO_TRY[name]
        points = samples.points(shape, 200)[:200]
        for part in gradient(shape.formula()):
            np.testing.assert_allclose(
                codegen_native.evaluate(part, points, shape.parameters()),
                numpy_evaluation.evaluate(part, points, shape.parameters()),
                atol=1e-9,
            )


def test_deep_formulas():
    deep = x
    for i in range(5_000):
        deep = f.sin(deep) if i % 2 else deep + y
    assert np.isfinite(_read(deep, np.ones((1, 3)), ())).all()
