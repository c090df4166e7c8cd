# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of which nothing is known but a formula."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..formula import ITERATE, PARAMETER, POINT, Formula, Vector, maximum, order, parameter
from ..limits import negative_region
from ..substitution import substitute
from .base import NONE, Shape, Slots
from .operators import Transformed
from .primitives import Box

_OPERATIONS_OF_A_PRIMITIVE = 20


def _operations(formulas: tuple[Formula, ...], known: frozenset[Formula]) -> int:
    """Operations at each point, with all the rounds that loops can have."""
    return sum(
        node.value.limit * _operations(node.value.roots(), frozenset(node.operands)) if node.kind == ITERATE else 1
        for node in order(*formulas, known=known) if node not in known)


@dataclass(frozen=True)
class Field(Shape, abstract=True):
    """The region in which a formula is negative. Not in ``SHAPES``: artists write the formula.

    Whether it has limits, and which, is found by interval arithmetic, unless it is cut to a box around the origin.
    """

    exactness = NONE
    lipschitz = math.inf

    value: Formula = dataclasses.field(metadata=dict(description="formula of the point"))
    numbers: tuple[float, ...] = dataclasses.field(default=(), metadata=dict(description="values of its slots"))
    cut: Box | None = dataclasses.field(default=None, metadata=dict(description="box that it is cut to"))

    @classmethod
    def of(cls, formula: Formula, values: Sequence[float], cut: Box | None = None) -> "Field":
        """The field of a formula with parameters in slots of ``values``, of which it need not use all."""
        used = [node.value for node in order(formula) if node.kind == PARAMETER]
        slots = {slot: parameter(index) for index, slot in enumerate(used)}
        return cls(substitute(formula, POINT, slots), tuple(float(values[slot]) for slot in used), cut)

    @cached_property
    def _operations(self) -> int:
        return _operations((self.value,), frozenset())

    @property
    def size(self) -> int:
        """How many primitives the formula is worth, by what it takes at each point."""
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
