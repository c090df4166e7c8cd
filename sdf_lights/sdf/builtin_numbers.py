# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions of the expression language for numbers, fields and vectors, and for folding the point.

Most are written once, for floats and formulas: see ``expression_values.compute``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..graph import formula
from ..graph.continuity import declare
from ..graph.formula import Formula
from . import expression_values
from .expression_values import (
    Condition,
    Misuse,
    Scalar,
    Vector,
    Work,
    absolute,
    choose,
    compute,
    cos,
    kind_of,
    maximum,
    minimum,
    sin,
    spread,
    sqrt,
)
from .functions import FUNCTIONS, MATHEMATICS, POINTS, Argument, Function, spread_word, word
from .noise import value_noise

Value = Scalar | Vector
Vector3 = Vector

# -- numbers, fields and vectors --------------------------------------------------------------------------------------


def _vector(slots: Work, size: int, given: tuple) -> Vector:
    flat = [scalar for value in given for scalar in expression_values.components(value)]
    for value in given:
        if kind_of(value) not in ("number", "field", "vector"):
            raise Misuse(
                f"a vector is made of numbers and fields, not of a {kind_of(value)}",
                f"write vec{size}({', '.join('xyz'[:size])})",
            )
    if len(flat) == 1:
        flat *= size
    if len(flat) != size:
        raise Misuse(f"vec{size} does not take {len(flat)} components", f"write vec{size}({', '.join('xyz'[:size])})")
    return tuple(flat)


FUNCTIONS["vec2"] = Function(
    "vec2",
    MATHEMATICS,
    (Argument("x", "value"),),
    lambda slots, *given: _vector(slots, 2, given),
    "A vector of two components, as in `vec2(length(p.xy) - 1, p.z)`. `(x, y)` is one too.",
    True,
    "vec2(x, y)",
)
FUNCTIONS["vec3"] = Function(
    "vec3",
    MATHEMATICS,
    (Argument("x", "value"),),
    lambda slots, *given: _vector(slots, 3, given),
    "A vector of three components, made of numbers and vectors, `vec3(p.xy, 0)`, or of the same number three times, "
    "`vec3(1)`. `(x, y, z)` is one too.",
    True,
    "vec3(x, y, z)",
)


def _fold(function: Callable) -> Callable:
    def run(first, *others):
        for other in others:
            first = function(first, other)
        return first

    return run


def _sign(a: Scalar) -> Scalar:
    return where(0.0 < a, 1.0, 0.0) - where(a < 0.0, 1.0, 0.0)


def where(truth, then: Scalar, otherwise: Scalar) -> Scalar:
    """``then`` where ``truth`` holds, else ``otherwise``: a number for a boolean, a formula for a comparison."""
    if isinstance(truth, Formula):
        return formula.select(truth, then, otherwise)
    return then if truth else otherwise


def _clamp(a: Scalar, low: Scalar, high: Scalar) -> Scalar:
    return minimum(maximum(a, low), high)


def _smoothstep(low: Scalar, high: Scalar, a: Scalar) -> Scalar:
    t = _clamp((a - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _round(a: Scalar) -> Scalar:
    return expression_values.floor(a + 0.5)


def modulo(a: Scalar, divisor: Scalar) -> Scalar:
    """Remainder with the sign of the divisor."""
    return a - divisor * expression_values.floor(a / divisor)


spread_word("sin", sin, "Sine of an angle in radians.", "angle")
spread_word("cos", cos, "Cosine of an angle in radians.", "angle")
spread_word("tan", expression_values.tan, "Tangent of an angle in radians.", "angle")
spread_word("asin", expression_values.asin, "Angle in radians whose sine is the value.", "value")
spread_word("acos", expression_values.acos, "Angle in radians whose cosine is the value.", "value")
spread_word("atan", expression_values.atan, "Angle in radians whose tangent is the value.", "value")
spread_word("atan2", expression_values.atan2, "Angle in radians of the point (x, y).", "y", "x")
spread_word("radians", lambda a: a * (math.pi / 180.0), "Degrees as radians.", "degrees")
spread_word("degrees", lambda a: a * (180.0 / math.pi), "Radians as degrees.", "radians")
spread_word("sqrt", sqrt, "Square root.", "value")
spread_word("exp", expression_values.exp, "e to the power of the value.", "value")
spread_word("log", expression_values.log, "Natural logarithm.", "value")
spread_word(
    "pow",
    expression_values.power,
    "Base to the power of the exponent, also written `base ** exponent`.",
    "base",
    "exponent",
)
spread_word("abs", absolute, "The value without its sign.", "value")
spread_word("sign", _sign, "−1, 0 or 1.", "value", cost=5)
spread_word("floor", expression_values.floor, "The greatest whole number that is not above the value.", "value")
spread_word(
    "ceil", lambda a: -expression_values.floor(-a), ("The least whole number that is not below the value."), "value"
)
spread_word("round", _round, "The nearest whole number.", "value")
spread_word(
    "fract",
    lambda a: a - expression_values.floor(a),
    ("The fractional part: the value minus the greatest whole number that is not above it."),
    "value",
)
spread_word(
    "mod", modulo, "Remainder with the sign of the divisor, also written `value % divisor`.", "value", "divisor", cost=4
)
spread_word("min", _fold(minimum), "The least value.", "value", variadic=True)
spread_word("max", _fold(maximum), "The greatest value.", "value", variadic=True)
spread_word("clamp", _clamp, "The value limited to a range.", "value", "low", "high", cost=2)
spread_word(
    "mix",
    lambda a, b, t: a + (b - a) * t,
    "Linear interpolation from a (at t = 0) to b (at t = 1).",
    "a",
    "b",
    "t",
    cost=3,
)
spread_word("step", lambda edge, a: where(a < edge, 0.0, 1.0), "0 below the edge, 1 from the edge on.", "edge", "value")
spread_word(
    "smoothstep",
    _smoothstep,
    "From 0 below low to 1 above high, with a smooth curve between.",
    "low",
    "high",
    "value",
    cost=8,
)


@word(MATHEMATICS)
def select(slots: Work, condition: Condition, then: Any, otherwise: Any):
    """One value where the condition holds, another elsewhere; also written `then if condition else otherwise`.

    A condition compares numbers or fields: `a < b`, `<=`, `>`, `>=`. `and`, `or` and `not` combine conditions.
    """
    return choose(slots, condition, then, otherwise)


def dot_product(a: Vector, b: Vector) -> Scalar:
    """Scalar product. Raises ``Misuse`` for vectors of different length."""
    if len(a) != len(b):
        raise Misuse("vectors of two and of three components cannot be combined", "use one kind, as in p.xy or p")
    return sum((x * y for x, y in zip(a[1:], b[1:])), a[0] * b[0])


def cross_product(a: Vector, b: Vector) -> Vector:
    """Vector product of two vectors of three components, right-handed."""
    return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))


def difference(a: Vector, b: Vector) -> Vector:
    """a − b, component by component."""
    return spread(lambda x, y: x - y, a, b)


def norm(vector: Vector) -> Scalar:
    """Euclidean length."""
    return sqrt(dot_product(vector, vector))


def unit(vector: Vector) -> Vector:
    """The vector with length 1. Raises ``Misuse`` for the zero vector."""
    size = norm(vector)
    if isinstance(size, float) and size == 0.0:
        raise Misuse("a vector of length 0 has no direction", "give another vector")
    return tuple(component / size for component in vector)


@word(MATHEMATICS, cost=2)
def dot(a: Vector, b: Vector):
    """Dot product."""
    return dot_product(a, b)


@word(MATHEMATICS, cost=3)
def cross(a: Vector3, b: Vector3):
    """Cross product."""
    return cross_product(a, b)


@word(MATHEMATICS, cost=2)
def length(vector: Vector):
    """Length of a vector."""
    return norm(vector)


@word(MATHEMATICS, cost=4)
def normalize(vector: Vector):
    """The vector of length 1 in the same direction."""
    return unit(vector)


@word(MATHEMATICS, cost=40)
def noise(slots: Work, point: Vector3, seed: float = 0.0):
    """Smooth random values between −1 and 1, with features of one metre: `noise(4 * p)` has them four times finer.

    Another seed, a whole number from 0 to 288, gives different noise.
    """

    def at(point: Vector, seed: Scalar) -> Scalar:
        return expression_values.settled(value_noise(formula.Vector(*map(as_formula, point)), seed))

    return compute(slots, at, point, seed)


def as_formula(scalar: Scalar) -> Formula:
    """A scalar as a formula."""
    return scalar if isinstance(scalar, Formula) else formula.constant(scalar)


# -- points -----------------------------------------------------------------------------------------------------------


@word(POINTS, cost=5)
def repeat(slots: Work, point: Value, period: Value):
    """The point relative to the centre of its cell, if cells of the given size fill space.

    A shape at this point appears in every cell: `sphere(0.2)(repeat(p, 1))`. A direction with a period of 0 is not
    repeated.
    """

    def cell(a: Scalar, size: Scalar) -> Scalar:
        return a if type(size) is float and size == 0.0 else compute(slots, lambda a, b: a - b * _round(a / b), a, size)

    return spread(cell, point, period)


@word(POINTS, cost=8)
def fold(point: Vector, normal: Vector, offset: Scalar = 0.0):
    """The point, mirrored to the side of a plane that its normal points to, if it is on the other side.

    The plane is at this distance in metres from the origin, along the normal.
    """
    normal = unit(normal)
    beyond = 2.0 * minimum(dot_product(point, normal) - offset, 0.0)
    return difference(point, tuple(beyond * n for n in normal))


@word(POINTS, cost=8)
def mirror(point: Vector3, normal: Vector3 = (1.0, 0.0, 0.0)):
    """The point, mirrored to the side of a plane through the origin that its normal points to, if it is on the other
    side."""
    return fold(point, normal)


@word(POINTS, cost=10)
def polar(point: Vector, count: Scalar):
    """The point rotated about the z axis, by whole sectors, into the sector around the x axis.

    A shape at this point appears that many times around the axis: `sphere(0.2)(polar(p, 6) - (1, 0, 0))`.
    """
    part = math.tau / count
    turn = part * _round(expression_values.atan2(point[1], point[0]) / part)
    c, s = cos(turn), sin(turn)
    # The point already lies in the sector. The clamp is for interval arithmetic, which cannot see that.
    radius, side = norm(point[:2]), sin(minimum(0.5 * part, 0.5 * math.pi))
    x = maximum(point[0] * c + point[1] * s, radius * cos(0.5 * part))
    y = _clamp(point[1] * c - point[0] * s, -side * radius, side * radius)
    # From one sector to the next, the point jumps to its mirror image: only the sign of y changes there.
    number = as_formula(count)
    if number.kind == formula.PARAMETER or number.kind == formula.CONSTANT:
        for value, even in ((x, False), (y, True)):
            if isinstance(value, Formula):
                declare(value, map(as_formula, point[:2]), even, (number,))
    return (x, y, *point[2:])
