# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""GLSL, run on the GPU or on Mesa's software renderer, against NumPy: every operation, loop and shape.

Within float32 of NumPy means: the value is inside the bounds that interval arithmetic gives when every single operation
may be as wrong as ``glsl.PRECISION`` says. So the tolerance is that of the formula at that point: narrow where it is
well conditioned, wide where large terms cancel, and both sides of a jump where rounding can fall on either.
"""

import re

import numpy as np
import pytest

from sdf_lights.graph import codegen_glsl, interval_evaluation, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.gradient import gradient
from sdf_lights.graph.loops import iterate
from sdf_lights.graph.operations import CONDITIONS, OPERATIONS
from support import glsl
from support.shapes import samples

x, y, z = f.POINT


def _points(count: int = 300) -> np.ndarray:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-3, 1, (count, 1))
    points[::5] = rng.integers(-3, 4, (len(points[::5]), 3)) / 2.0
    points[1::9] *= 10.0 ** rng.uniform(-36, 12, (len(points[1::9]), 1))
    return np.concatenate([points, np.zeros((1, 3))])


def _check(formula, points, parameters=(), size: int = 1):
    """Compare at points that float32 holds."""
    points = points.astype(np.float32).astype(np.float64)
    points[np.abs(points) < glsl.PRECISION.tiny] = 0.0  # as GLSL may do
    parts = (formula,) if size == 1 else tuple(formula)
    source = codegen_glsl.function(formula, "read")
    values = glsl.evaluate(source, "read", points, parameters, size).reshape(len(points), size).astype(np.float64)
    known = 0
    for part, found in zip(parts, values.T):
        low, high = interval_evaluation.enclose(part, points, points, parameters, glsl.PRECISION)
        expected = numpy_evaluation.evaluate(part, points, parameters)
        # What is undefined in exact arithmetic, or may be after rounding, can have any value.
        bounded = np.isfinite(expected) & (low > -np.inf) & (high < np.inf)
        wrong = bounded & ~((low <= found) & (found <= high))
        assert not wrong.any(), (points[wrong][0], found[wrong][0], expected[wrong][0], low[wrong][0], high[wrong][0])
        known += bounded.mean() / size
    assert known > 0.05


def operations():
    """Each operation, on coordinates and with numbers of each sign."""
    for kind, operation in OPERATIONS.items():
        if kind == "select":
            yield kind, f.select(x < y, x - z, z)
        elif kind in CONDITIONS:
            yield kind, f.select(f.apply(kind, x, y), f.constant(1.0), f.constant(2.0)) + x
        else:
            yield kind, f.apply(kind, *f.POINT[: operation.arity])
        if operation.arity == 2 and kind not in CONDITIONS:
            for number in (-2.0, 3.0, 2.5):
                yield f"{kind} of {number}", f.apply(kind, f.constant(number), x) + y
                yield f"{kind} by {number}", f.apply(kind, x, f.constant(number)) + y
    yield "power by a parameter", f.apply("power", x, f.parameter(0))
    yield "remainder", x - 0.3 * f.apply("floor", x / 0.3)
    yield "constants", (x * 1e-30 + 1e300) * 0.0 + f.minimum(x / f.maximum(abs(y), 1e-300), 1e39) * f.constant(-1e-6)


def _escape(u, v, n):
    return (u * u - v * v + x, 2.0 * u * v + y, n + z), u * u + v * v < 4.0


def _outer(a, total):
    (b,) = iterate(f.parameter(0), (a * y,), lambda c: ((f.sin(c) + total * z - (x + y) * c,), abs(c) < 9.0), 6)
    return (b + a, total * b), f.minimum(a, total) < 5.0


LOOPS = {
    "parameter": iterate(f.parameter(0), (x,), lambda u: ((u * u - y,), None), 9)[0],
    "escape": f.length(*iterate(7, (x, y, z), _escape, 7)),
    "nested": sum(iterate(3, (x, z), _outer, 3)),
    "nothing to do": iterate(f.parameter(1), (x, y), lambda u, v: ((v, u), None), 4)[0],
    "swap": sum(iterate(3, (x, 2.0 * y), lambda u, v: ((v, u), None), 4)[i] * (i + 1.0) for i in range(2)),
}
FORMULAS = {f"operation {name}": formula for name, formula in operations()}
FORMULAS |= {f"loop, {name}": formula for name, formula in LOOPS.items()}


@pytest.mark.parametrize("name", FORMULAS)
def test_operations_agree(name):
    _check(FORMULAS[name], _points(), [3.0, -1.0])


@pytest.mark.parametrize("name", samples.SHAPES_TO_TRY)
def test_shapes_agree(name):
    shape = samples.SHAPES_TO_TRY[name]
    _check(shape.formula(), samples.points(shape, 300), shape.parameters())


@pytest.mark.parametrize("name", ["torus", "box", "three", "nested"])
def test_distances_have_the_precision_of_float32(name):
    """In plain terms, of shapes whose formulas are well conditioned: the error is that of the coordinates."""
    shape = samples.SHAPES_TO_TRY[name]
    points = samples.points(shape, 2000).astype(np.float32).astype(np.float64)
    values = glsl.evaluate(codegen_glsl.function(shape.formula(), "field"), "field", points, shape.parameters())
    size = np.abs(points).max(axis=1) + np.abs(shape.parameters()).max()
    assert (np.abs(values - shape.distance(points)) <= 4.0 * glsl.ULP * size).all()


@pytest.mark.parametrize(
    "formula",
    [pytest.param(samples.SHAPES_TO_TRY[name].formula(), id=name) for name in ("torus", "box", "cone")]
    + [pytest.param(formula, id=name) for name, formula in LOOPS.items() if name in ("escape", "parameter")],
)
def test_gradients_agree(formula):
    parameters = [0.5, 0.2, 0.3, 0.1]
    _check(gradient(formula), _points(), parameters, 3)
    _check((formula, *gradient(formula)), _points(), parameters, 4)


def test_far_and_tiny():
    """Squares of 1e10 and of 1e-18 do not leave the range of float32."""
    for size in (1e10, 1e18, 1e-18):
        points = size * np.random.default_rng(2).normal(size=(100, 3))
        found = glsl.evaluate(codegen_glsl.function(f.length(x, y, z), "read"), "read", points)
        np.testing.assert_allclose(found, np.linalg.norm(points, axis=1), rtol=1e-6)


def test_values_of_powers():
    """Also where pow is undefined in GLSL: negative numbers with whole exponents, and 0."""
    bases, exponents = np.meshgrid([-2.0, -1.0, -0.5, 0.0, 0.5, 2.0], [-3.0, -2.0, 0.0, 1.0, 2.0, 3.0, 17.0])
    points = np.stack([bases.ravel(), exponents.ravel(), 0.0 * bases.ravel()], axis=-1)
    found = glsl.evaluate(codegen_glsl.function(f.apply("power", x, y), "read"), "read", points)
    with np.errstate(divide="ignore"):
        expected = np.clip(np.power(points[:, 0], points[:, 1]), None, np.finfo(np.float32).max)
    np.testing.assert_allclose(found, expected, rtol=2e-6)


def test_angles_are_those_of_numpy():
    directions = np.random.default_rng(3).normal(size=(1000, 3)).astype(np.float32)
    directions[:8, :2] = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (-1, -1)]
    found = glsl.evaluate(codegen_glsl.function(f.apply("atan2", y, x), "read"), "read", directions)
    expected = np.arctan2(directions[:, 1].astype(float), directions[:, 0])
    np.testing.assert_allclose(found, expected, rtol=4.0 * glsl.ULP, atol=0.0)
    near_one = np.stack([1.0 - 10.0 ** np.linspace(-7, 0, 500)] * 3, axis=-1).astype(np.float32)
    for kind, function in (("asin", np.arcsin), ("acos", np.arccos), ("atan", np.arctan)):
        found = glsl.evaluate(codegen_glsl.function(f.apply(kind, x), "read"), "read", near_one)
        np.testing.assert_allclose(found, function(near_one[:, 0].astype(float)), rtol=6.0 * glsl.ULP, atol=0.0)


def test_text():
    text = codegen_glsl.function(samples.SHAPES_TO_TRY["torus"].formula(), "torus", "lamp.k[{}]")
    assert (
        text
        == """\
float torus(vec3 p)
{
    float a0 = (sqrt(((p.x * p.x) + (p.y * p.y))) - lamp.k[0]);
    return (sqrt(((a0 * a0) + (p.z * p.z))) - lamp.k[1]);
}
"""
    )
    assert text == codegen_glsl.function(samples.SHAPES_TO_TRY["torus"].formula(), "torus", "lamp.k[{}]")


def test_functions_share_a_shader():
    """Each brings its own helpers, under names of its own."""
    angle = f.apply("atan2", y, x)
    source = codegen_glsl.function(angle, "first") + codegen_glsl.function(2.0 * angle, "second")
    source += "\nfloat both(vec3 p)\n{\n    return first(p) + second(p);\n}\n"
    np.testing.assert_allclose(glsl.evaluate(source, "both", np.array([(1.0, 1.0, 0.0)])), 0.75 * np.pi, rtol=1e-6)


def test_numbers_are_written_for_float32():
    for value in (0.0, -0.0, 1.0, -1.5, 0.1, 1e-5, 1e9, 123456789.0, 1e-30, -3e38):
        text = codegen_glsl.literal(value)
        assert np.float32(text) == np.float32(value) and re.fullmatch(r"-?\d+\.\d+(e[+-]\d+)?", text)
    assert float(codegen_glsl.literal(1e-300)) > 0.0 and np.isfinite(np.float32(codegen_glsl.literal(np.inf)))


@pytest.mark.parametrize("name", ["", "1a", "a b", "gl_a", "a__b", "a;", "ä"])
def test_names_have_to_be_names(name):
    with pytest.raises(ValueError, match="not a valid name of a GLSL function"):
        codegen_glsl.function(x, name)
    with pytest.raises(ValueError, match="1 to 4 values"):
        codegen_glsl.function((x,) * 5, "read")


def test_deep_formulas_are_written_without_nesting():
    deep = x
    for i in range(1000):
        deep = f.sqrt(deep * deep * 0.25 + y) if i % 3 else deep + 0.1
    source = codegen_glsl.function(deep, "read")
    assert max(map(len, source.splitlines())) < 1500
    _check(deep, np.abs(_points(50)))
