# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes from formulas of the point, without further knowledge."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph import interval_evaluation, lipschitz
from ...graph.formula import ITERATE, PARAMETER, POINT, Formula, Vector, maximum, order, parameter
from ...graph.substitution import substitute
from ...graph.tables import kept
from ..limits import negative_region
from .base import NONE, SMALLEST, Shape, Slots, part
from .displacement import Displaced
from .operators import Transformed
from .primitives import Box

_OPERATIONS_OF_A_PRIMITIVE = 20
_EVERYWHERE = np.full((1, 3), -np.inf), np.full((1, 3), np.inf)


def _operations(formulas: tuple[Formula, ...], known: frozenset[Formula]) -> int:
    """Operations at each point, including the maximum iterations of loops."""
    return sum(
        node.value.limit * _operations(node.value.roots(), frozenset(node.operands)) if node.kind == ITERATE else 1
        for node in order(*formulas, known=known)
        if node not in known
    )


def _compact(formula: Formula, values: Sequence[float]) -> tuple[Formula, tuple[float, ...]]:
    """The formula with its used slots numbered from 0, and their values."""
    used = [node.value for node in order(formula) if node.kind == PARAMETER]
    slots = {slot: parameter(index) for index, slot in enumerate(used)}
    return substitute(formula, POINT, slots), tuple(kept(values[slot]) for slot in used)


@frozen
class Field(Shape, abstract=True):
    """The region in which a formula is negative. Not in ``SHAPES``: artists write the formula.

    Interval arithmetic finds its limits, if it has any, unless it is cut to a box around the origin.
    """

    exactness = NONE
    lipschitz = math.inf

    value: Formula = dataclasses.field(metadata=dict(description="formula of the point"))
    numbers: tuple[float, ...] = dataclasses.field(default=(), metadata=dict(description="values of its slots"))
    cut: Box | None = dataclasses.field(default=None, metadata=dict(description="box that it is cut to"))

    @classmethod
    def of(cls, formula: Formula, values: Sequence[float], cut: Box | None = None) -> "Field":
        """The field of a formula with parameters in slots of ``values``; it need not use all of them."""
        return cls(*_compact(formula, values), cut)

    @cached_property
    def _operations(self) -> int:
        return _operations((self.value,), frozenset())

    @property
    def size(self) -> int:
        """The cost of the formula at each point, in primitives."""
        return 1 + self._operations // _OPERATIONS_OF_A_PRIMITIVE

    @cached_property
    def _box(self) -> Shape | None:
        """A box around the region; None if it has no limits."""
        if self.cut is not None:
            return self.cut
        limits = negative_region(self.value, self.numbers, self._operations)
        if limits is None:
            return None
        place = np.eye(4)
        place[:3, 3] = (limits[0] + limits[1]) / 2.0
        return Transformed(Box(tuple((limits[1] - limits[0]) / 2.0)), place)

    @property
    def bounded(self) -> bool:
        return self._box is not None

    def bounds(self, matrix=None):
        return self._box.bounds(matrix) if self.bounded else (np.full(3, -np.inf), np.full(3, np.inf))

    def build(self, p: Vector, slot: Slots) -> Formula:
        value = substitute(self.value, p, [slot(number) for number in self.numbers])
        return value if self.cut is None else maximum(value, self.cut.build(p, slot))

    def relation(self) -> str:
        return "" if self.cut is None else self.cut.check()


@frozen
class FieldDisplacement(Displaced, abstract=True):
    """A shape whose surface is displaced by a formula of the point: outwards where it is positive.

    The formula and its slope have limits. Not in ``SHAPES``: artists write the formula.
    """

    child: Shape = part("Shape whose surface moves")
    value: Formula = dataclasses.field(default=POINT.x, metadata=dict(description="formula of the point"))
    numbers: tuple[float, ...] = dataclasses.field(default=(), metadata=dict(description="values of its slots"))

    @classmethod
    def of(cls, child: Shape, formula: Formula, values: Sequence[float]) -> "FieldDisplacement | None":
        """As ``Field.of``. None if no limits, or none of the slope, are known for all of space."""
        made = cls(child, *_compact(formula, values))
        return made if math.isfinite(made.amplitude) and math.isfinite(made._slope) else None

    @cached_property
    def amplitude(self) -> float:
        low, high = interval_evaluation.enclose(self.value, *_EVERYWHERE, self.numbers)
        return max(float(-low[0]), float(high[0]), SMALLEST)

    @cached_property
    def _slope(self) -> float:
        return max(float(lipschitz.lipschitz(self.value, *_EVERYWHERE, self.numbers)[0]), SMALLEST)

    def _steepest(self) -> float:
        return self._slope / self.amplitude

    def _pattern(self, p: Vector, slot: Slots) -> Formula:
        return substitute(self.value, p, [slot(number) for number in self.numbers]) * slot(-1.0 / self.amplitude)
