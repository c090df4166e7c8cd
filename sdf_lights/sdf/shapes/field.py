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

from ..formula import ITERATE, PARAMETER, POINT, Formula, Vector, order, parameter
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

    Whether it has limits, and which, is found by interval arithmetic.
    """

    exactness = NONE
    lipschitz = math.inf

    value: Formula = dataclasses.field(metadata=dict(description="formula of the point"))
    numbers: tuple[float, ...] = dataclasses.field(default=(), metadata=dict(description="values of its slots"))

    @classmethod
    def of(cls, formula: Formula, values: Sequence[float]) -> "Field":
        """The field of a formula with parameters in slots of ``values``, of which it need not use all."""
        used = [node.value for node in order(formula) if node.kind == PARAMETER]
        slots = {slot: parameter(index) for index, slot in enumerate(used)}
        return cls(substitute(formula, POINT, slots), tuple(float(values[slot]) for slot in used))

    @cached_property
    def _operations(self) -> int:
        return _operations((self.value,), frozenset())

    @property
    def size(self) -> int:
        """How many primitives the formula is worth, by what it takes at each point."""
        return 1 + self._operations // _OPERATIONS_OF_A_PRIMITIVE

    @cached_property
    def _limits(self) -> np.ndarray | None:
        return negative_region(self.value, self.numbers, self._operations)

    @cached_property
    def _box(self) -> Transformed:
        """A box around the region."""
        place = np.eye(4)
        place[:3, 3] = (self._limits[0] + self._limits[1]) / 2.0
        return Transformed(Box(tuple((self._limits[1] - self._limits[0]) / 2.0)), place)

    @property
    def bounded(self) -> bool:
        return self._limits is not None

    def bounds(self, matrix=None):
        return self._box.bounds(matrix) if self.bounded else (np.full(3, -np.inf), np.full(3, np.inf))

    def build(self, p: Vector, slot: Slots) -> Formula:
        return substitute(self.value, p, [slot(number) for number in self.numbers])
