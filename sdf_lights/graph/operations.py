# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of the operations of formulas: one row per operation, with its form in every evaluator."""

from __future__ import annotations

import enum
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class Native(enum.Enum):
    """How machine code computes an operation, and its name there."""

    ARITHMETIC = enum.auto()  # an instruction of LLVM
    INTRINSIC = enum.auto()  # a built-in function of LLVM
    LIBRARY = (
        enum.auto()
    )  # a function of C's mathematics; several points at a time by ``vector_math``, if it has the function
    COMPARISON = enum.auto()  # two operands, by this symbol
    CHOICE = enum.auto()  # the first of two operands if the comparison by this symbol holds
    SELECT = enum.auto()


class Operation(NamedTuple):
    """One row.

    ``meaning`` is the operation on float64 arrays; constants are folded with it, too. ``glsl`` is an expression of its
    operands; ``{name}_…`` is one of ``codegen_glsl``'s helpers. ``infix`` is its symbol in text and its precedence;
    without one, it is written as a call. Bounds over boxes are the method of the same name of
    ``interval_arithmetic.Arithmetic``.

    ``derivative(algebra, value, operand)`` is that of an operation of one operand. ``algebra`` has a method for each
    operation, ``number`` and ``square``: for formulas it gives gradients, for intervals bounds of slopes. ``gradient``
    and ``slope_rules`` have separate rules for operations that need the derivatives of all operands at once.
    """

    arity: int
    meaning: Callable
    native: tuple[Native, str]
    glsl: str
    infix: tuple[str, int] | None = None
    derivative: Callable[[Any, Any, Any], Any] | None = None
    commutes: bool = False


def _sine_inverse_slope(algebra, a):
    return algebra.divide(algebra.number(1.0), algebra.sqrt(algebra.subtract(algebra.number(1.0), algebra.square(a))))


_A, _I, _L = Native.ARITHMETIC, Native.INTRINSIC, Native.LIBRARY

OPERATIONS: dict[str, Operation] = {
    "negate": Operation(1, np.negative, (_A, "fneg"), "(-{})"),
    "abs": Operation(1, np.abs, (_I, "fabs"), "abs({})"),
    "sqrt": Operation(
        1, np.sqrt, (_I, "sqrt"), "sqrt({})", derivative=lambda alg, value, a: alg.divide(alg.number(0.5), value)
    ),
    "sin": Operation(1, np.sin, (_L, "sin"), "sin({})", derivative=lambda alg, value, a: alg.cos(a)),
    "cos": Operation(1, np.cos, (_L, "cos"), "cos({})", derivative=lambda alg, value, a: alg.negate(alg.sin(a))),
    "tan": Operation(
        1, np.tan, (_L, "tan"), "tan({})", derivative=lambda alg, value, a: alg.add(alg.number(1.0), alg.square(value))
    ),
    "asin": Operation(
        1, np.arcsin, (_L, "asin"), "{name}_asin({})", derivative=lambda alg, value, a: _sine_inverse_slope(alg, a)
    ),
    "acos": Operation(
        1,
        np.arccos,
        (_L, "acos"),
        "{name}_acos({})",
        derivative=lambda alg, value, a: alg.negate(_sine_inverse_slope(alg, a)),
    ),
    "atan": Operation(
        1,
        np.arctan,
        (_L, "atan"),
        "{name}_atan({})",
        derivative=lambda alg, value, a: alg.divide(alg.number(1.0), alg.add(alg.number(1.0), alg.square(a))),
    ),
    "exp": Operation(1, np.exp, (_L, "exp"), "exp({})", derivative=lambda alg, value, a: value),
    "log": Operation(
        1, np.log, (_L, "log"), "log({})", derivative=lambda alg, value, a: alg.divide(alg.number(1.0), a)
    ),
    "floor": Operation(1, np.floor, (_I, "floor"), "floor({})"),
    "add": Operation(2, np.add, (_A, "fadd"), "({} + {})", infix=("+", 2), commutes=True),
    "subtract": Operation(2, np.subtract, (_A, "fsub"), "({} - {})", infix=("-", 2)),
    "multiply": Operation(2, np.multiply, (_A, "fmul"), "({} * {})", infix=("*", 3), commutes=True),
    "divide": Operation(2, np.divide, (_A, "fdiv"), "({} / {})", infix=("/", 3)),
    "power": Operation(2, np.power, (_L, "pow"), "{name}_power({}, {})"),
    "atan2": Operation(2, np.arctan2, (_L, "atan2"), "{name}_atan2({}, {})"),
    "minimum": Operation(2, np.minimum, (Native.CHOICE, "<"), "min({}, {})", commutes=True),
    "maximum": Operation(2, np.maximum, (Native.CHOICE, ">"), "max({}, {})", commutes=True),
    # Comparisons are conditions: they may only stand as the first operand of select.
    "less": Operation(2, np.less, (Native.COMPARISON, "<"), "({} < {})", infix=("<", 1)),
    "less_equal": Operation(2, np.less_equal, (Native.COMPARISON, "<="), "({} <= {})", infix=("<=", 1)),
    "select": Operation(3, np.where, (Native.SELECT, ""), "({} ? {} : {})"),
}

CONDITIONS = frozenset({"less", "less_equal"})
