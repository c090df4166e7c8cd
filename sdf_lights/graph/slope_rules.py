# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The slope of each operation, from those of its operands; and square roots of sums of squares, which are norms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .formula import ITERATE, Formula, order
from .interval_arithmetic import Condition, Interval
from .operations import OPERATIONS
from .slope import ARITHMETIC, Slope, length_of, scaled, select_slope, slope_sum, steepest_bound, unit_bounds


def _along(derivative: Callable) -> Callable:
    """Rule of a function of one operand, from its derivative."""
    return lambda value, operands: scaled(operands[0], derivative(ARITHMETIC, value, operands[0].value))


ZERO, _ONE, _MINUS_ONE = (ARITHMETIC.number(number) for number in (0.0, 1.0, -1.0))


def _multiply(value: Interval, operands: list[Slope]):
    a, b = operands
    if a is b:
        return scaled(a, ARITHMETIC.add(a.value, a.value))
    return slope_sum(scaled(a, b.value), scaled(b, a.value))


def _divide(value: Interval, operands: list[Slope]):
    a, b = operands
    inverse = ARITHMETIC.divide(_ONE, b.value)
    return slope_sum(scaled(a, inverse), scaled(b, ARITHMETIC.negate(ARITHMETIC.multiply(value, inverse))))


def _power(value: Interval, operands: list[Slope]):
    a, b = operands
    less = ARITHMETIC.power(a.value, ARITHMETIC.subtract(b.value, _ONE))
    terms = [scaled(a, ARITHMETIC.multiply(b.value, less))]
    if b.gradient is not None:
        terms.append(scaled(b, ARITHMETIC.multiply(value, ARITHMETIC.log(a.value))))
    return slope_sum(*terms)


def _atan2(value: Interval, operands: list[Slope]):
    """(x ∇y − y ∇x) / r², with (x, y)/r a unit vector."""
    units, least = unit_bounds(operands)
    y, x = (Interval(*unit) for unit in units)
    inverse = ARITHMETIC.divide(_ONE, Interval(least, np.full_like(least, np.inf)))
    gradient, norm = slope_sum(scaled(operands[0], x), scaled(operands[1], ARITHMETIC.negate(y)))
    if gradient is None:
        return None, 0.0
    steepest = steepest_bound(operands, units)
    return scaled(Slope(value, gradient, np.minimum(norm, steepest)), inverse)


RULES: dict[str, Callable] = {
    **{kind: _along(row.derivative) for kind, row in OPERATIONS.items() if row.derivative is not None},
    "negate": lambda value, operands: (
        None if operands[0].gradient is None else ARITHMETIC.negate(operands[0].gradient),
        operands[0].norm,
    ),
    "add": lambda value, operands: slope_sum(*(operand[1:3] for operand in operands)),
    "subtract": lambda value, operands: slope_sum(operands[0][1:3], scaled(operands[1], _MINUS_ONE)),
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "atan2": _atan2,
}


_MOST_PARTS = 12
_PASSES_ROOTS_ON = frozenset({"add", "minimum", "maximum", "select", "multiply", "divide"})


def under_roots(formula: Formula) -> set[Formula]:
    """Nodes under a square root, and those of which they are sums, choices and multiples."""
    nodes = order(formula)
    found = set()
    for node in reversed(nodes):
        if node.kind == ITERATE:
            for root in node.value.roots():
                found |= under_roots(root)
        elif node.kind == "sqrt" or (node in found and node.kind in _PASSES_ROOTS_ON):
            found.update(node.operands)
    return found


def _root(slope: Slope) -> Slope:
    """A value whose square is the sum of the squares of the parts."""
    return slope.parts[0] if len(slope.parts) == 1 else length_of(ARITHMETIC.sqrt(slope.value), list(slope.parts))


def _constant_root(slope: Slope) -> Slope | None:
    if slope.gradient is not None or np.any(slope.value.low < 0.0):
        return None
    return Slope(ARITHMETIC.sqrt(slope.value), None, 0.0)


def _with_parts(slope: Slope) -> Slope:
    """The slope with its parts; a slope without parts becomes the square of a number."""
    root = _constant_root(slope) if slope.parts is None else None
    return slope if root is None else slope._replace(parts=(root,))


def square_parts(kind: str, operands: list[Slope], condition: Condition | None) -> tuple[Slope, ...] | None:
    """Parts of the value of one node; for a choice, ``condition`` tells where it is the first of two operands."""
    a, b = (*operands, None)[:2]
    if condition is not None:
        a, b = _with_parts(a), _with_parts(b)
        return None if a.parts is None or b.parts is None else (select_slope(condition, _root(a), _root(b)),)
    if (kind == "multiply" and a is b) or (kind == "power" and b.value.is_number and b.value.low == 2.0):
        return (a._replace(parts=None),)
    if kind in ("multiply", "divide"):
        if kind == "multiply" and a.parts is None:
            a, b = b, a
        scale = _constant_root(b)
        if a.parts is None or scale is None:
            return None
        rule = getattr(ARITHMETIC, kind)
        return tuple(Slope(rule(part.value, scale.value), *RULES[kind](None, [part, scale])) for part in a.parts)
    if kind == "add":
        a, b = _with_parts(a), _with_parts(b)
        if a.parts is None or b.parts is None:
            return None
        return (*a.parts, *b.parts) if len(a.parts) + len(b.parts) <= _MOST_PARTS else (_root(a), _root(b))
    return None
