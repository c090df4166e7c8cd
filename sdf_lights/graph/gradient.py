# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradients of formulas, as formulas: every evaluator can evaluate them.

Forward mode (Griewank and Walther, "Evaluating Derivatives", 2nd ed., chapter 3). Loops carry the derivatives of their
states as further states. At a crease the gradient is that of one side; at a jump, that beside the jump.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from .formula import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    RESULT,
    STATE,
    VARIABLE,
    Formula,
    Vector,
    apply,
    axis_of,
    body,
    call,
    constant,
    order,
    select,
)
from .loops import iterate
from .operations import CONDITIONS, OPERATIONS

_ZERO = constant(0.0)
_NONE = Vector(_ZERO, _ZERO, _ZERO)


class _Dual(NamedTuple):
    value: Formula
    slope: Any  # a vector; None for a condition


def gradient(formula: Formula) -> Vector:
    """The gradient of the formula with respect to the position.

    At its centre the gradient of a length is zero, and so is that of an angle.
    """
    return _differentiated((formula,), {})[0].slope


def _differentiated(roots: tuple[Formula, ...], known: dict[Formula, _Dual]) -> list[_Dual]:
    found: dict[Formula, Any] = dict(known)
    for node in order(*roots, known=set(known)):
        if node not in found:
            found[node] = _dual(node, [found[operand] for operand in node.operands])
    return [found[root] for root in roots]


def _dual(node: Formula, operands: list) -> _Dual | list[_Dual]:
    """Value and gradient of one node; for a loop, those of all its states."""
    if node.kind in (CONSTANT, PARAMETER):
        return _Dual(node, _NONE)
    if node.kind == VARIABLE:
        return _Dual(node, Vector(*(constant(float(axis == axis_of(node))) for axis in range(3))))
    if node.kind == ITERATE:
        return _loop(node, operands)
    if node.kind == CALL:
        return _called(node, operands)
    if node.kind == RESULT:
        return operands[0][node.value]
    value = apply(node.kind, *(operand.value for operand in operands))
    if node.kind in CONDITIONS:
        return _Dual(value, None)
    slopes = [operand.slope for operand in operands]
    if all(slope in (None, _NONE) for slope in slopes):
        return _Dual(value, _NONE)
    return _Dual(value, _RULES[node.kind](value, [operand.value for operand in operands], slopes))


def _called(node: Formula, operands: list[_Dual]) -> list[_Dual]:
    function = node.value
    values = call(function, *(operand.value for operand in operands))
    parts = operands[getattr(function, "tables", 0) :]
    if all(part.slope == _NONE for part in parts):
        return [_Dual(value, _NONE) for value in values]
    if getattr(function, "derivatives", None) is None:
        raise ValueError(f"the function {function.name!r} has no known derivative")
    slope = _NONE
    for part, derivative in zip(parts, call(function.derivatives, *(operand.value for operand in operands))):
        slope = slope + part.slope * derivative
    return [_Dual(values[0], slope)]


def _loop(node: Formula, operands: list[_Dual]) -> list[_Dual]:
    loop, size = node.value, len(node.value.steps)
    captures = dict(zip(node.operands[1 + size :], operands[1 + size :]))
    own = [n for n in body(node) if n.kind == STATE and n.value[0] == loop.level]

    def run(*states: Formula):
        duals = _paired(states)
        steps = _differentiated(loop.roots(), captures | {state: duals[state.value[1]] for state in own})
        going = steps.pop().value if loop.going is not None else None
        return _flat(steps), going

    return _paired(iterate(operands[0].value, _flat(operands[1 : 1 + size]), run, loop.limit))


def _flat(duals: list[_Dual]) -> tuple[Formula, ...]:
    return tuple(formula for dual in duals for formula in (dual.value, *dual.slope))


def _paired(formulas: tuple[Formula, ...]) -> list[_Dual]:
    return [_Dual(formulas[i], Vector(*formulas[i + 1 : i + 4])) for i in range(0, len(formulas), 4)]


def _select(condition: Formula, then: Vector, otherwise: Vector) -> Vector:
    return Vector(*(select(condition, a, b) for a, b in zip(then, otherwise)))


class _Formulas:
    """The algebra of ``operations.Operation.derivative`` that returns formulas."""

    number = staticmethod(constant)

    def __getattr__(self, kind: str) -> Callable[..., Formula]:
        return functools.partial(apply, kind)

    def square(self, a: Formula) -> Formula:
        return a * a


_ALGEBRA = _Formulas()


def _along(derivative: Callable) -> Callable:
    """Rule of a function of one operand, from its derivative."""
    return lambda value, operands, slopes: slopes[0] * derivative(_ALGEBRA, value, operands[0])


def _power(value: Formula, operands: list[Formula], slopes: list[Vector]) -> Vector:
    a, b = operands
    slope = slopes[0] * (b * apply("power", a, b - 1.0))
    if slopes[1] != _NONE:
        slope += slopes[1] * select(a > 0.0, value * apply("log", a), 0.0)
    return slope


def _atan2(value: Formula, operands: list[Formula], slopes: list[Vector]) -> Vector:
    y, x = operands
    square = x * x + y * y
    return (slopes[0] * x - slopes[1] * y) * _or_zero(square, 1.0 / square)


def _or_zero(positive: Formula, value: Formula) -> Formula:
    return select(positive > 0.0, value, 0.0)


_RULES: dict[str, Callable[[Formula, list[Formula], list[Vector]], Vector]] = {
    **{kind: _along(row.derivative) for kind, row in OPERATIONS.items() if row.derivative is not None},
    "negate": lambda value, operands, slopes: slopes[0] * -1.0,
    "abs": lambda value, operands, slopes: _select(operands[0] < 0.0, slopes[0] * -1.0, slopes[0]),
    "sqrt": lambda value, operands, slopes: slopes[0] * _or_zero(value, 0.5 / value),
    "floor": lambda value, operands, slopes: _NONE,
    "add": lambda value, operands, slopes: slopes[0] + slopes[1],
    "subtract": lambda value, operands, slopes: slopes[0] - slopes[1],
    "multiply": lambda value, operands, slopes: slopes[0] * operands[1] + slopes[1] * operands[0],
    "divide": lambda value, operands, slopes: (slopes[0] - slopes[1] * value) / operands[1],
    "power": _power,
    "atan2": _atan2,
    "minimum": lambda value, operands, slopes: _select(operands[0] <= operands[1], *slopes),
    "maximum": lambda value, operands, slopes: _select(operands[0] >= operands[1], *slopes),
    "select": lambda value, operands, slopes: _select(operands[0], slopes[1], slopes[2]),
}
