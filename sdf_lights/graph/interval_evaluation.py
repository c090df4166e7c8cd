# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of a formula's values over boxes, by ``interval_arithmetic`` at each node; ``slope_evaluation`` adds bounds of
slopes."""

from __future__ import annotations

import numpy as np

from ..interruption import check
from .formula import CALL, CONSTANT, ITERATE, PARAMETER, RESULT, STATE, VARIABLE, Formula, Numbers, axis_of, body, order
from .functions import TableFunction, evaluate
from .interval_arithmetic import DOUBLE, Arithmetic, Condition, Interval, Line, Precision
from .numpy_evaluation import rounds
from .operations import CONDITIONS, OPERATIONS


def enclose(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), precision: Precision = DOUBLE
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n,), (n,) of the formula's values over boxes with the corners ``low`` and ``high`` (n, 3).

    Boxes may be points, and they may be infinite. If a formula has no value in all of a box, or none that can be
    bounded, the bounds are −∞ and ∞.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    with np.errstate(all="ignore"):
        arithmetic = Arithmetic(precision)
        found = run((formula,), Boxes(arithmetic, low, high, parameters))[0]
        return tuple(np.broadcast_to(bound, low.shape[:1]).astype(np.float64) for bound in found[:2])


def _squares(base: Formula, other: Formula) -> int:
    """How often ``base`` must be squared to give ``other``; 0 if that is impossible."""
    count = 0
    while other.kind == "multiply" and other.operands[0] is other.operands[1]:
        count, other = count + 1, other.operands[0]
        if other is base:
            return count
    return 0


MARGIN = 1e-12  # relative to the bounded value: more than the rounding of a few hundred operations


def called(node: Formula, operands: list[Interval]) -> tuple[Interval, list[tuple[np.ndarray, np.ndarray]]]:
    """Bounds of the value of a function of tables, and of its derivative by each of its coordinates.
    Raises ValueError if the function has no known bounds."""
    function = node.value
    if not isinstance(function, TableFunction) or function.bounds is None:
        raise ValueError(f"the function {function.name!r} has no known bounds")
    coordinates = operands[function.tables :]
    addresses = [operand.low for operand in operands[: function.tables]]
    bounds = evaluate(function.bounds, [*addresses, *(end for part in coordinates for end in part[:2])])
    undefined = None
    for part in coordinates:
        if part.undefined is not None:
            undefined = part.undefined if undefined is None else undefined | part.undefined
    low, high = (np.where(np.isnan(end), unknown, end) for end, unknown in zip(bounds[:2], (-np.inf, np.inf)))
    slopes = [
        (np.where(np.isnan(least), -np.inf, least), np.where(np.isnan(most), np.inf, most))
        for least, most in zip(bounds[2::2], bounds[3::2])
    ]
    return Interval(low, high, undefined), slopes


class Boxes:
    """The interval rules of each kind of node. ``lipschitz`` has the same for values with gradients.

    A box may have several rows, each for a part of its points: see ``divide``.
    """

    def __init__(self, arithmetic: Arithmetic, low: np.ndarray, high: np.ndarray, parameters: np.ndarray):
        self.arithmetic = arithmetic
        greatest = arithmetic.precision.greatest
        self.low, self.high = np.minimum(low, greatest), np.maximum(high, -greatest)
        self.parameters = parameters
        self.live: list[dict] = []  # all values that are still needed, from the outermost loop to the innermost

    def position(self, axis: int) -> Interval:
        """Bounds of a coordinate over each box."""
        return Interval(self.low[:, axis], self.high[:, axis])

    def number(self, value: float) -> Interval:
        """A constant or parameter, the same in all boxes."""
        return self.arithmetic.number(value)

    def apply(self, node: Formula, operands: list) -> Interval | Condition:
        """The value of an operation of the graph.

        Powers of one formula and remainders a − n⌊a/n⌋ have tighter bounds than their parts.
        """
        if node.kind == "multiply":
            for base, other, interval in zip(node.operands, node.operands[::-1], operands):
                squares = _squares(base, other)
                if squares:
                    return self.arithmetic.odd_power(interval, squares)
        if node.kind == "subtract":
            found = self.arithmetic.subtract(*operands)
            floored = self._floored(*node.operands)
            if floored:
                low, high = self.arithmetic.remainder(operands[0], *floored)[:2]
                if found.whole:
                    low, high = np.ceil(low), np.floor(high)
                found = found._replace(low=np.maximum(found.low, low), high=np.minimum(found.high, high))
            return found
        return getattr(self.arithmetic, node.kind)(*operands)

    def select(self, condition: Condition, then: Interval, otherwise: Interval) -> Interval:
        """The value of a choice by a condition."""
        return self.arithmetic.select(condition, then, otherwise)

    def interval(self, value: Interval) -> Interval:
        """The interval part of a value."""
        return value

    def _floored(self, a: Formula, product: Formula) -> tuple[Interval, Line] | None:
        """The number and the line of ``product`` = number · floor(line of a), if it has that form."""
        factors = ((None, product),)
        if product.kind == "multiply":
            factors = product.operands, product.operands[::-1]
        for factor, step in factors:
            if step.kind == "floor":
                period = self.arithmetic.number(1.0) if factor is None else self._fixed(factor)
                line = self._line(step.operands[0], a) if period else None
                return line and (period, line)
        return None

    def _line(self, formula: Formula, a: Formula, depth: int = 4) -> Line | None:
        arithmetic = self.arithmetic
        if formula is a:
            return Line(arithmetic.number(1.0), arithmetic.number(0.0), 0.0)
        if not depth or formula.kind not in ("add", "subtract", "multiply", "divide"):
            return None
        left, right = formula.operands
        apply = getattr(arithmetic, formula.kind)
        number, line = self._fixed(right), None
        if number:
            line = self._line(left, a, depth - 1)
        elif formula.kind in ("add", "multiply"):
            number = self._fixed(left)
            line = number and self._line(right, a, depth - 1)
        if line is None:
            return None
        if formula.kind in ("multiply", "divide"):
            size = apply(Interval(np.float64(0.0), line.size + line.shift.magnitude), number).magnitude
            return Line(apply(line.scale, number), apply(line.shift, number), size)
        return Line(line.scale, apply(line.shift, number), line.size + line.shift.magnitude + number.magnitude)

    def _fixed(self, formula: Formula, depth: int = 4) -> Interval | None:
        """A number, or the result of a few numbers."""
        if formula.kind == CONSTANT:
            return self.arithmetic.number(formula.value)
        if formula.kind == PARAMETER:
            return self.arithmetic.number(self.parameters[formula.value])
        if not depth or formula.kind not in OPERATIONS or formula.kind in CONDITIONS or formula.kind == "select":
            return None
        operands = [self._fixed(operand, depth - 1) for operand in formula.operands]
        return None if None in operands else getattr(self.arithmetic, formula.kind)(*operands)

    def call(self, node: Formula, operands: list) -> Interval:
        """The value of a function of tables."""
        return called(node, operands)[0]

    def divide(self, node: Formula) -> None:
        """Called when the value of a node is known: here parts of boxes can be separated."""


def run(roots: tuple[Formula, ...], boxes: Boxes, known: dict | None = None) -> list:
    """Values of the roots; those of other nodes are dropped after their last use."""
    known = known or {}
    nodes = [node for node in order(*roots, known=set(known)) if node not in known]
    uses = dict.fromkeys(nodes, 0)
    for node in (*roots, *(operand for node in nodes for operand in node.operands)):
        if node in uses:
            uses[node] += 1
    values = dict(known)
    boxes.live.append(values)
    for node in nodes:
        check()
        operands = [values[operand] for operand in node.operands]
        if node.kind == CONSTANT:
            values[node] = boxes.number(node.value)
        elif node.kind == VARIABLE:
            values[node] = boxes.position(axis_of(node))
        elif node.kind == PARAMETER:
            values[node] = boxes.number(boxes.parameters[node.value])
        elif node.kind == ITERATE:
            values[node] = _loop(node, operands, boxes)
        elif node.kind == CALL:
            values[node] = [boxes.call(node, operands)]
        elif node.kind == RESULT:
            values[node] = operands[0][node.value]
        else:
            values[node] = boxes.apply(node, operands)
        for operand in node.operands:
            if operand in uses:
                uses[operand] -= 1
                if not uses[operand]:
                    values.pop(operand, None)
        boxes.divide(node)
    boxes.live.pop()
    return [values[root] for root in roots]


def _loop(node: Formula, operands: list, boxes: Boxes) -> list:
    """States after the loop: of the points that ran to its end, and of those that stopped in some iteration."""
    loop, size = node.value, len(node.value.steps)
    captures = dict(zip(node.operands[1 + size :], operands[1 + size :]))
    own = [n for n in body(node) if n.kind == STATE and n.value[0] == loop.level]
    count = boxes.interval(operands[0])
    least, most = (rounds(float(end), loop.limit) for end in count[:2])
    # The states of running and stopped points, and whether some points of a box may be either.
    now = dict(
        states=operands[1 : 1 + size],
        stopped=operands[1 : 1 + size],
        any_running=np.True_,
        any_stopped=np.False_,
        captures=list(captures.values()),
    )
    boxes.live.append(now)
    for number in range(most):
        known = dict(zip(captures, now["captures"])) | {state: now["states"][state.value[1]] for state in own}
        values = run(loop.roots(), boxes, known)
        going = values.pop() if loop.going is not None else Condition(np.True_, np.True_)
        stopping = now["any_running"] & ~(going.certain & (number < least))
        if np.any(stopping):
            chosen = Condition(stopping & ~now["any_stopped"], stopping)
            now["stopped"] = [boxes.select(chosen, *pair) for pair in zip(now["states"], now["stopped"])]
            now["any_stopped"] = now["any_stopped"] | stopping
        now["any_running"] = now["any_running"] & going.possible
        now["states"] = values
        if not np.any(now["any_running"]):
            break
    boxes.live.pop()
    last = Condition(now["any_running"] & ~now["any_stopped"], now["any_running"])
    return [boxes.select(last, *pair) for pair in zip(now["states"], now["stopped"])]
