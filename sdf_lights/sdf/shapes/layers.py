# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes bounded by level sets of another's field: offsets and walls; and elongated shapes."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import POINT, Formula, Vector, clamp
from .base import LARGEST, Family, Shape, Slots, Term, number, part
from .operators import Folded, Operator, guarded, level_bounds


class Layer(Operator, abstract=True):
    """A field that is a function of the child's field alone, with slopes of at most 1.

    The child is guarded: the position of its level sets must be known.
    """

    @cached_property
    def _guarded(self) -> Shape:
        return guarded(self.child)

    @cached_property
    def lipschitz(self):
        return self._guarded.lipschitz

    def _level(self) -> float:
        """The shape is where the child's field is at most this."""
        raise NotImplementedError

    def _remade(self, field: Formula, slot: Slots, factor: float = 1.0) -> Formula:
        """The field, from the child's, both ``factor`` times as large as distances."""
        raise NotImplementedError

    def build(self, p, slot):
        return self._remade(self._guarded.build(p, slot), slot)

    def terms(self, matrix, factor):
        terms = self._guarded.terms(matrix, factor)
        slots = Slots()
        formula = self._remade(POINT.x, slots, factor)
        return [*terms, Term(formula, np.array(slots.values), 1, Family.MAP, 0.0, terms[-1].lipschitz)]

    def bounds(self, matrix=None):
        return level_bounds(self._guarded, self._level(), matrix)

    def growth(self, matrix=None):
        return self._guarded.growth(matrix)


@frozen
class Offset(Layer):
    """The shape with its surface moved outwards, or inwards by a negative offset.

    The new surface is a level set of the field. Outside shapes with exact fields, and unions of them, its distance is
    the offset.
    """

    child: Shape = part("Shape whose surface moves")
    offset: float = number(0.1, "How far outwards", minimum=-LARGEST, soft_maximum=1.0)

    @cached_property
    def exact_outside(self):
        return self.child.exact_outside and self.offset >= 0.0

    def _level(self):
        return self.offset

    def _remade(self, field, slot, factor=1.0):
        return field - slot(self.offset * factor)


@frozen
class Round(Layer):
    """The shape with its outer edges rounded; it grows on all sides by the radius."""

    child: Shape = part("Shape that is rounded")
    radius: float = number(0.05, "Radius of the rounded edges", minimum=0.0, soft_maximum=1.0)

    @cached_property
    def exact_outside(self):
        return self.child.exact_outside

    def _level(self):
        return self.radius

    def _remade(self, field, slot, factor=1.0):
        return field - slot(self.radius * factor)


@frozen
class Onion(Layer):
    """A wall along the surface of the shape, hollow inside: half of it outside the surface, half inside."""

    child: Shape = part("Shape that is hollowed")
    thickness: float = number(0.05, "Thickness of the wall", soft_maximum=1.0)

    def _level(self):
        return 0.5 * self.thickness

    def _remade(self, field, slot, factor=1.0):
        return abs(field) - slot(0.5 * self.thickness * factor)


@frozen
class Shell(Layer):
    """The shape hollowed: a wall inside its surface."""

    child: Shape = part("Shape that is hollowed")
    thickness: float = number(0.05, "Thickness of the wall", soft_maximum=1.0)

    def _level(self):
        return 0.0

    def _remade(self, field, slot, factor=1.0):
        half = slot(0.5 * self.thickness * factor)
        return abs(field + half) - half


@frozen
class Elongate(Folded):
    """The shape cut along the planes through its origin, with the parts moved apart and the gaps filled."""

    child: Shape = part("Shape that is elongated")
    half_length: tuple[float, float, float] = number(
        (0.0, 0.0, 0.5), "Half of the length added along x, y and z", minimum=0.0
    )

    def _asked(self, p, slot):
        half = slot(self.half_length)
        return Vector(*(q - clamp(q, -h, h) for q, h in zip(p, half)))

    def bounds(self, matrix=None):
        # Each point of the shape is moved by at most half_length along each axis.
        low, high = self.child.bounds(matrix)
        linear = np.eye(3) if matrix is None else matrix[:3, :3]
        margin = np.abs(linear) @ self.half_length
        return low - margin, high + margin
