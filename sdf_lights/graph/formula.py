# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas: hash-consed expression graphs over variables, parameters and constants.

This module has what other modules need to make and read them: the nodes of ``formula_nodes``, functions, and vectors of
three formulas.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .formula_nodes import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    POSITION,
    RESULT,
    STATE,
    VARIABLE,
    Formula,
    Loop,
    Numbers,
    apply,
    axis_of,
    body,
    call,
    constant,
    formula_of,
    intern,
    numbers_may_change,
    order,
    parameter,
    slots,
    variable,
)

__all__ = (
    "CALL",
    "CONSTANT",
    "ITERATE",
    "PARAMETER",
    "POINT",
    "POSITION",
    "RESULT",
    "STATE",
    "VARIABLE",
    "Formula",
    "Loop",
    "Numbers",
    "Vector",
    "acos",
    "apply",
    "asin",
    "atan2",
    "axis_of",
    "body",
    "call",
    "clamp",
    "constant",
    "cos",
    "exp",
    "floor",
    "formula_of",
    "intern",
    "length",
    "log",
    "maximum",
    "minimum",
    "numbers_may_change",
    "order",
    "parameter",
    "power",
    "select",
    "sin",
    "slots",
    "sqrt",
    "tan",
    "variable",
)


def sqrt(a: Formula | float) -> Formula:
    """Square root; undefined below 0."""
    return apply("sqrt", a)


def sin(a: Formula | float) -> Formula:
    """Sine of an angle in radians."""
    return apply("sin", a)


def cos(a: Formula | float) -> Formula:
    """Cosine of an angle in radians."""
    return apply("cos", a)


def tan(a: Formula | float) -> Formula:
    """Tangent of an angle in radians."""
    return apply("tan", a)


def asin(a: Formula | float) -> Formula:
    """Arcsine in radians, −π/2 to π/2; undefined outside of [−1, 1]."""
    return apply("asin", a)


def acos(a: Formula | float) -> Formula:
    """Arccosine in radians, 0 to π; undefined outside of [−1, 1]."""
    return apply("acos", a)


def atan2(y: Formula | float, x: Formula | float) -> Formula:
    """The angle of (x, y) to the x axis, −π to π."""
    return apply("atan2", y, x)


def exp(a: Formula | float) -> Formula:
    """Exponential function."""
    return apply("exp", a)


def log(a: Formula | float) -> Formula:
    """Natural logarithm; undefined below 0."""
    return apply("log", a)


def power(a: Formula | float, exponent: Formula | float) -> Formula:
    """``a`` to the power ``exponent``; undefined where a < 0 and the exponent is not whole."""
    return apply("power", a, exponent)


def floor(a: Formula | float) -> Formula:
    """The greatest integer that is not above ``a``."""
    return apply("floor", a)


def minimum(*operands: Formula | float) -> Formula:
    """Least of one or more operands."""
    return _fold("minimum", operands)


def maximum(*operands: Formula | float) -> Formula:
    """Greatest of one or more operands."""
    return _fold("maximum", operands)


def clamp(a: Formula | float, low: Formula | float, high: Formula | float) -> Formula:
    """``a`` limited to [low, high]; ``high`` if low > high."""
    return minimum(maximum(a, low), high)


def select(condition: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """``then`` where the condition (a comparison) holds, else ``otherwise``; both are computed."""
    return apply("select", condition, then, otherwise)


def length(*components: Formula | float) -> Formula:
    """Euclidean norm."""
    return sqrt(_fold("add", [apply("multiply", c, c) for c in components]))


def _fold(kind: str, operands) -> Formula:
    # A balanced tree: short chains of dependent instructions, and a depth that grows only with the logarithm of the
    # number of operands.
    operands = list(operands)
    while len(operands) > 1:
        pairs = [apply(kind, a, b) for a, b in zip(operands[::2], operands[1::2])]
        operands = pairs + operands[len(pairs) * 2 :]
    first = operands[0]
    return first if isinstance(first, Formula) else constant(first)


class Vector(NamedTuple):
    """Three formulas with the arithmetic of vectors (a scalar operand applies to each component)."""

    x: Formula
    y: Formula
    z: Formula

    def _with(self, function: Callable[[Formula, Formula], Formula], other) -> "Vector":
        return Vector(*(function(a, b) for a, b in zip(self, other if isinstance(other, tuple) else (other,) * 3)))

    def __add__(self, other):
        return self._with(lambda a, b: a + b, other)

    def __sub__(self, other):
        return self._with(lambda a, b: a - b, other)

    def __mul__(self, other):
        return self._with(lambda a, b: a * b, other)

    def __truediv__(self, other):
        return self._with(lambda a, b: a / b, other)

    __radd__, __rmul__ = __add__, __mul__  # type: ignore[misc]  # of tuples

    def __rsub__(self, other):
        return -self + other

    def __neg__(self):
        return Vector(*(-a for a in self))

    def __abs__(self):
        return Vector(*(abs(a) for a in self))

    def minimum(self, other) -> "Vector":
        """Lesser of each pair of components."""
        return self._with(minimum, other)

    def maximum(self, other) -> "Vector":
        """Greater of each pair of components."""
        return self._with(maximum, other)

    def least(self) -> Formula:
        """The least component."""
        return minimum(*self)

    def greatest(self) -> Formula:
        """The greatest component."""
        return maximum(*self)

    def dot(self, other) -> Formula:
        """Scalar product with another vector or tuple of as many components."""
        return _fold("add", [a * b for a, b in zip(self, other)])

    def cross(self, other) -> "Vector":
        """Vector product, right-handed."""
        (a, b, c), (u, v, w) = self, other
        return Vector(b * w - c * v, c * u - a * w, a * v - b * u)

    def length(self) -> Formula:
        """Euclidean length."""
        return length(*self)

    def normalized(self) -> "Vector":
        """The vector with length 1; zero if it is shorter than any relevant length."""
        return self / maximum(self.length(), 1e-150)

    def reflected(self, normal) -> "Vector":
        """Mirror image in the plane through the origin with this unit normal."""
        return self - Vector(*normal) * (2.0 * self.dot(normal))

    def rotated(self, axis, cosine: Formula | float, sine: Formula | float) -> "Vector":
        """Rotated about a unit axis by the angle with this cosine and sine, counter-clockwise as seen from the tip of
        the axis.

        Rodrigues' formula.
        """
        axis = Vector(*axis)
        return self * cosine + axis.cross(self) * sine + axis * (self.dot(axis) * (1.0 - cosine))


POINT = Vector(*(variable(POSITION, axis) for axis in range(3)))
"""The point at which a formula is evaluated."""
