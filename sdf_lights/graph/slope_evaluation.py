# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates formulas over boxes with their gradients, and splits boxes at clamps and folds."""

from __future__ import annotations

import numpy as np

from .box_sides import SIGN, STEP, declared_inputs, find_sides, remainder_limits, taken_rows
from .continuity import declared, joins
from .discontinuity import (
    any_of,
    at_limits,
    combined,
    common_source,
    discontinuous_choice,
    either,
    outside_domain,
    with_limits,
)
from .formula import CONSTANT, PARAMETER, RESULT, STATE, VARIABLE, Formula
from .interval_arithmetic import Condition, Interval
from .interval_evaluation import Boxes, called
from .operations import CONDITIONS
from .slope import (
    ARITHMETIC,
    CONTINUOUS,
    Discontinuity,
    Slope,
    length_of,
    magnitude_of,
    scaled,
    select_slope,
    slope_sum,
    steepest_bound,
)
from .slope_rules import RULES, ZERO, square_parts, under_roots


class SlopeBoxes(Boxes):
    """Rules for values with gradients, for each kind of node.

    If it is undecided on which side of a clamp, a fold or a cell's border a box is, the box is split into the points on
    either side. Later operations use both sides, as in the distance to a box, which joins one inside and one outside,
    or after repeated reflections. Without the split, they would combine the sides in ways that do not occur.
    """

    def __init__(self, formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray, parts: int):
        super().__init__(ARITHMETIC, low, high, parameters)
        self.parts = parts
        self.under_roots = under_roots(formula)
        self.sides = find_sides(formula) if parts > 1 else {}
        self.rows = np.arange(len(low))  # the box of each row
        self.inputs = declared_inputs(formula)
        self.discontinuous_inputs: dict[
            Formula, np.ndarray | None
        ] = {}  # (boxes,) in which of them each is discontinuous

    def position(self, axis):
        direction = np.zeros((3, 1))
        direction[axis] = 1.0
        return Slope(super().position(axis), Interval(direction, direction), 1.0)

    def number(self, value):
        return Slope(super().number(value), None, 0.0)

    def interval(self, value):
        return value.value

    def select(self, condition, then, otherwise):
        discontinuity = Discontinuity(discontinuous_choice(condition, then, otherwise, then is not otherwise))
        return select_slope(condition, then, otherwise)._replace(discontinuity=discontinuity)

    def apply(self, node, operands):
        if node.kind in CONDITIONS:
            return self._compared(super().apply(node, [operand.value for operand in operands]), operands)
        condition = None
        if node.kind == "select":
            condition, *operands = operands
        elif node.kind in ("minimum", "maximum"):
            condition = self._first_of(node, operands)
        slope = self._slope(node, operands, condition)
        if node in self.under_roots:
            slope = slope._replace(parts=square_parts(node.kind, operands, condition))
        domain = outside_domain(node, operands) if slope.gradient is not None else None
        if domain is not None:
            low, high = (np.where(domain, end, bound) for end, bound in zip((-np.inf, np.inf), slope.gradient[:2]))
            slope = slope._replace(gradient=Interval(low, high), norm=np.where(domain, np.inf, slope.norm))
        discontinuity = self._discontinuity(node, operands, condition)
        return slope._replace(
            discontinuity=self._rejoined(node, discontinuity) if discontinuity.boxes is not None else discontinuity
        )

    def call(self, node, operands):
        tables = node.value.tables
        value, bounds = called(node, [operand.value for operand in operands])
        parts = operands[tables:]
        gradient, norm = slope_sum(*(scaled(part, Interval(*slope)) for part, slope in zip(parts, bounds)))
        if gradient is None:
            return Slope(value, None, 0.0)
        most = node.value.lipschitz
        if np.isfinite(most):
            units = [(np.maximum(low / most, -1.0), np.minimum(high / most, 1.0)) for low, high in bounds]
            norm = np.minimum(norm, most * steepest_bound(parts, units))
        discontinuous = None
        for part in parts:
            discontinuous = either(discontinuous, part.discontinuity.boxes)
        return Slope(value, gradient, norm, discontinuity=Discontinuity(discontinuous))

    def _compared(self, found: Condition, operands: list[Slope]) -> Condition:
        """A condition on a discontinuous value: a box counts as a whole, because the jump may be between its rows."""
        discontinuous = either(operands[0].discontinuity.boxes, operands[1].discontinuity.boxes)
        if discontinuous is None or not self.divided:
            return found
        n = len(self.rows)
        certain, possible = (np.broadcast_to(truth, n) for truth in found)
        whole = [self.whole(join, truth)[self.rows] for join, truth in ((np.minimum, certain), (np.maximum, possible))]
        return Condition(np.where(discontinuous, whole[0], certain), np.where(discontinuous, whole[1], possible))

    @property
    def divided(self) -> bool:
        """Whether boxes have several rows."""
        return len(self.rows) > self.rows.max(initial=-1) + 1

    def _discontinuity(self, node: Formula, operands: list[Slope], condition: Condition | None) -> Discontinuity:
        """The discontinuity of the value of an operation, from its operands."""
        kind, a = node.kind, operands[0]
        if condition is not None:
            jumps = kind == "select" and not joins(*node.operands)
            discontinuous = discontinuous_choice(condition, a, operands[1], jumps)
            if discontinuous is None:
                return CONTINUOUS
            if not jumps:
                return with_limits(Discontinuity(discontinuous, common_source(operands), at_limits(node, operands)))
            numbers = a.is_number and operands[1].is_number
            limits = (float(a.value.low), float(operands[1].value.low)) if numbers else None
            return with_limits(Discontinuity(discontinuous, node if numbers else None, limits))
        if kind == "floor":
            discontinuous = either(a.discontinuity.boxes, any_of(np.floor(a.value.low) != np.floor(a.value.high)))
            sides = self.live[-1].get((node.operands[0], STEP))
            discontinuous = discontinuous if sides is None else either(discontinuous, any_of(sides != 0))
            return (
                CONTINUOUS
                if discontinuous is None
                else Discontinuity(discontinuous, node if a.discontinuity.boxes is None else None)
            )
        if kind == "subtract" and a.discontinuity.boxes is None and operands[1].discontinuity.boxes is not None:
            floored = self._floored(*node.operands)
            if floored is not None:
                return with_limits(
                    operands[1].discontinuity._replace(limits=remainder_limits(*floored), even=False, zero=None)
                )
        discontinuity = combined(node, operands)
        if kind == "atan2":
            y, x = a.value, operands[1].value
            cut = any_of((x.low <= 0.0) & (y.low < 0.0) & (y.high >= 0.0))
            if cut is not None:  # the gradient only records the centre
                return (
                    Discontinuity(cut, node, (-np.pi, np.pi), True)
                    if discontinuity.boxes is None
                    else Discontinuity(either(discontinuity.boxes, cut))
                )
        return discontinuity

    def _rejoined(self, node: Formula, discontinuity: Discontinuity) -> Discontinuity:
        """The discontinuity that is left after the declarations about the formula."""
        about = declared(node)
        if about is None:
            return discontinuity
        for number in about.whole:
            value = self._fixed(number)
            if value is None or not value.is_number or value.low != np.floor(value.low):
                return discontinuity
        found = None
        for part in about.inputs:
            found = either(found, self._discontinuous_input(part))
        if found is not None:
            return discontinuity._replace(boxes=any_of(discontinuity.boxes & found))
        return Discontinuity(discontinuity.boxes, node, None, True) if about.even else CONTINUOUS

    def _discontinuous_input(self, node: Formula):
        if node.kind in (VARIABLE, PARAMETER, CONSTANT):
            return None
        if node.kind == STATE:
            return self.live[-1][node].discontinuity.boxes if node in self.live[-1] else np.True_
        if node not in self.discontinuous_inputs:  # it is not part of the formula: its parts are discontinuous or not
            return np.True_
        found = self.discontinuous_inputs[node]
        return None if found is None else found[self.rows]

    def _slope(self, node, operands, condition):
        if node.kind == "select":
            return select_slope(condition, *operands)
        value = super().apply(node, [operand.value for operand in operands])
        if condition is not None:
            return select_slope(condition, *operands, value)
        if node.kind == "abs":
            return magnitude_of(operands[0])
        if node.kind == "floor":
            return Slope(self._floor(node, value), None, 0.0)
        if node.kind == "sqrt" and operands[0].parts is not None:
            parts = operands[0].parts
            slope = magnitude_of(parts[0]) if len(parts) == 1 else length_of(value, list(parts))
            return slope._replace(value=value)
        return Slope(value, *RULES[node.kind](value, operands))

    def _first_of(self, node: Formula, operands: list[Slope]) -> Condition:
        """Where a minimum or maximum is its first operand. If both are the same, so are their gradients."""
        a, b = (operand.value for operand in operands)
        if node.kind == "maximum":
            a, b = b, a
        first, second = a.high <= b.low, b.high <= a.low
        sides = self.live[-1].get(node.operands)
        if sides is None and node.operands[::-1] in self.live[-1]:
            sides = -self.live[-1][node.operands[::-1]]
        if sides is not None:
            sides = -sides if node.kind == "maximum" else sides
            first, second = first | (sides < 0), second | (sides > 0)
        undefined = (
            a.undefined if b.undefined is None else (b.undefined if a.undefined is None else a.undefined | b.undefined)
        )
        if undefined is not None:
            first, second = first & ~undefined, second & ~undefined
        return Condition(first, ~second | first)

    def _floor(self, node: Formula, value: Interval) -> Interval:
        sides = self.live[-1].get((node.operands[0], STEP))
        if sides is None:
            return value
        # On the lower side of a step the number itself is included, but the floor is that of the points below.
        return value._replace(high=np.where(sides < 0, value.low, value.high))

    def divide(self, node):
        if node.kind == RESULT:
            result = self.live[-1][node]
            if result.discontinuity.boxes is not None:
                self.live[-1][node] = result._replace(discontinuity=self._rejoined(node, result.discontinuity))
        if node in self.inputs and isinstance(self.live[-1].get(node), Slope):
            found = self.live[-1][node].discontinuity.boxes
            if found is not None:
                found = self.whole(np.maximum, np.broadcast_to(found, len(self.rows)))
            self.discontinuous_inputs[node] = found
        for pair in self.sides.get(node, ()):
            values = self.live[-1]
            if pair not in values and all(side in values for side in pair if isinstance(side, Formula)):
                self._divide(*pair)

    def _divide(self, a: Formula, b: Formula | str) -> None:
        values = self.live[-1]
        u = values[a].value
        if b == SIGN:
            v = ZERO
        elif b == STEP:
            step = np.floor(u.high)
            v = Interval(step, step)
        else:
            v = values[b].value
        open_ = (u.low < v.high) & (v.low < u.high)
        if b == STEP:
            open_ = (u.low < step) & (u.low >= step - 1.0)
        for side in (u, v):
            if side.undefined is not None:
                open_ = open_ & ~side.undefined
        if not np.any(open_):
            return
        n = len(self.rows)
        full = 2 * np.bincount(self.rows, minlength=self.rows.max() + 1)[self.rows] > self.parts
        open_ = np.flatnonzero(open_ & ~full)
        if not len(open_):
            return
        index = np.concatenate([np.arange(n), open_])
        self.rows, self.low, self.high = self.rows[index], self.low[index], self.high[index]
        done: dict = {}
        for frame in self.live:
            frame.update(taken_rows(frame, index, n, done))
        sides = np.zeros(len(index), np.int8)  # −1: a ≤ b, 1: a ≥ b, 0: undecided
        sides[open_], sides[n:] = -1, 1
        values[a, b] = sides
        u, v = taken_rows(u, index, n, {}), taken_rows(v, index, n, {})
        self._restrict(a, u, v, sides)
        if isinstance(b, Formula):
            self._restrict(b, v, u, -sides)

    def _restrict(self, node: Formula, value: Interval, other: Interval, sides: np.ndarray) -> None:
        """Restrict the value of a node to its side of another."""
        if np.ndim(value.low):
            low = np.where(sides > 0, np.maximum(value.low, other.low), value.low)
            high = np.where(sides < 0, np.minimum(value.high, other.high), value.high)
            values = self.live[-1]
            values[node] = values[node]._replace(value=value._replace(low=low, high=high))

    def whole(self, join, values: np.ndarray) -> np.ndarray:
        """Values (…, rows) of the boxes (…, n) from those of all their rows."""
        first = np.argsort(self.rows, kind="stable")
        starts = np.flatnonzero(np.diff(self.rows[first], prepend=-1))
        return join.reduceat(values[..., first], starts, axis=-1) if len(first) else values
