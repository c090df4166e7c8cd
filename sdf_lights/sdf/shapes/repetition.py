# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of a shape: in rows, and around an axis.

The field is the least of all copies' fields, but not all are computed. Let the child lie within half a width w of its
centre along an axis of copies with the spacing s. For one point of the child, the nearest copy to a point p is in the
cell of p after rounding. Over all points of the child, these are at most ⌈2w/s⌉ + 1 neighbouring copies: the
candidates. So the nearest copy, and every copy that contains p, is a candidate. If the child's field is the distance
outside, the least field is that of a candidate.

The field of another child may be least for a copy farther away, and the result would jump where the candidates change.
Then either all copies are computed, or the field is clamped to s/2. A copy that becomes a candidate, or ceases to be
one, is at least that far away. So with a guarded child, there are no jumps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, apply, clamp, cos, maximum, minimum, select, sin
from ...graph.loops import iterate
from ..program import NoClosedForm
from .base import EXACT, LARGEST, Shape, Slots, number, part
from .operators import Guarded, Operator, Transformed, Union, images, images_growth, images_program
from .primitives import Box

_MOST_COPIES = 64  # copies that are unrolled, for pruning or tracing in closed form
_MOST_PARTS = 1024  # of all that is unrolled
_MOST_COMPUTED = 50_000  # parts, at a point
_MOST_CANDIDATES = 1000  # iterations of the loop over them
_ENDLESS = 1e9  # copies on each side of an endless row


def _floor(a: Formula) -> Formula:
    return apply("floor", a)


def _least(rounds: Formula, start: tuple, field: Callable, step: Callable) -> Formula:
    """Least ``field(*state)`` over the states start, step(start), …"""

    def body(least, *state):
        return (minimum(least, field(*state)), *step(*state)), None

    # Any number that no field exceeds, also in single precision.
    return iterate(rounds, (1e30, *start), body, _MOST_CANDIDATES)[0]


def _of_least(rounds: Formula, start: tuple, field: Callable, value: Callable, step: Callable) -> Formula:
    """``value(*state)`` where ``field(*state)`` is the least, as in ``_least``."""

    def body(least, found, *state):
        distance = field(*state)
        is_nearer = distance < least
        return (minimum(least, distance), select(is_nearer, value(*state), found), *step(*state)), None

    return iterate(rounds, (1e30, 0.0, *start), body, _MOST_CANDIDATES)[1]


class Repeated(Operator, abstract=True):
    """A union of copies of the child."""

    def _copies(self, p: Vector, slot: Slots) -> tuple[Formula, tuple, Callable, Callable]:
        """For ``_least``: how many copies may be the nearest to p, the first state, p in the copy of a state, the next
        state."""
        raise NotImplementedError

    def along(self, p, slot):
        if self.child.along(p, Slots()) is None:
            return None
        rounds, start, asked, step = self._copies(p, slot)
        return _of_least(
            rounds,
            start,
            lambda *state: self.child.build(asked(*state), slot),
            lambda *state: self.child.along(asked(*state), slot),
            step,
        )

    def _places(self) -> np.ndarray:
        """Matrices (n, 4, 4) that map the child to its copies."""
        raise NotImplementedError

    def _apart(self) -> bool:
        """Whether the copies certainly do not touch."""
        raise NotImplementedError

    def _number(self) -> float:
        """How many copies there are."""
        raise NotImplementedError

    @cached_property
    def size(self):
        return int(min(self._number(), _MOST_COPIES)) * self.child.size

    @cached_property
    def exact_outside(self):
        return self.child.exact_outside

    @cached_property
    def exactness(self):
        return EXACT if self.child.exactness == EXACT and self._apart() else super().exactness

    def volume(self):
        volume = self.child.volume()
        return self._number() * volume if volume is not None and self._apart() else None

    def terms(self, matrix, factor):
        if self._number() > _MOST_COPIES or self.size > _MOST_PARTS:
            return super().terms(matrix, factor)
        return Union([Transformed(self.child, place) for place in self._places()]).terms(matrix, factor)

    def program(self, matrix=None):
        if self._number() > _MOST_COPIES:
            raise NoClosedForm(f"{self.label()} has more copies than are traced in closed form.")
        return images_program(self.child, self._places(), matrix)

    def relation(self):
        if self.size > _MOST_COMPUTED:
            return (
                f"{self.label()}: copies of copies have more than {_MOST_COMPUTED} parts in all: make the counts "
                "smaller."
            )
        return ""


@frozen
class Repetition(Repeated):
    """Copies of the shape in rows along x, y and z, centred as a whole. They may overlap.

    A count of 0 repeats without end: the shape is then useful only inside an intersection.
    """

    child: Shape = part("Shape that is repeated")
    count: tuple[float, float, float] = number(
        (3.0, 3.0, 1.0),
        "Copies along x, y and z; 0 for an endless row",
        unit="NONE",
        minimum=0.0,
        maximum=1e6,
        whole=True,
    )
    spacing: tuple[float, float, float] = number((1.0, 1.0, 1.0), "Distance from copy to copy along x, y and z")

    def _number(self):
        return math.inf if 0.0 in self.count else math.prod(self.count)

    @cached_property
    def bounded(self):
        return 0.0 not in self.count and self.child.bounded

    @property
    def _held(self) -> bool:
        """Whether the field is clamped to half of the spacing."""
        return not self.child.exact_outside and self._number() > _MOST_COPIES

    @cached_property
    def _part(self) -> Shape:
        return Guarded(self.child) if self._held else self.child

    @cached_property
    def lipschitz(self):
        return self._part.lipschitz

    def _widths(self) -> np.ndarray:
        low, high = self.child.bounds()
        return high - low

    @cached_property
    def _candidates(self) -> np.ndarray:
        """How many copies are computed along each axis."""
        count = np.where(np.equal(self.count, 0.0), np.inf, self.count)
        if not self._held and not self.child.exact_outside:
            return count
        return np.minimum(count, np.ceil(self._widths() / self.spacing) + 1.0)

    @cached_property
    def _extent(self) -> np.ndarray:
        """Half of the distance from the first copy to the last."""
        return np.where(np.equal(self.count, 0.0), _ENDLESS, np.subtract(self.count, 1.0) / 2.0) * self.spacing

    def _copies(self, p, slot):
        candidates = self._candidates
        everything = candidates == self.count
        edge = np.where(everything, 0.0, self.child.bounds()[1])
        # Copies are numbered from the middle; for an even number, that is half a spacing off.
        shift = np.where(np.equal(self.count, 0.0), 0.0, np.mod(np.subtract(self.count, 1.0), 2.0) / 2.0)
        last = self._extent / self.spacing
        spacing, edge, shift, first, most = (
            slot(tuple(v.tolist()))
            for v in (np.array(self.spacing), edge, shift, -last, np.where(everything, -last, last - candidates + 1.0))
        )
        counts = slot(tuple(candidates.tolist()))
        q = Vector(
            *(
                x - s * clamp(_floor((x - e) / s + h + 0.5) - h, low, high)
                for x, s, e, h, low, high in zip(p, spacing, edge, shift, first, most)
            )
        )

        def asked(index: Formula) -> Vector:
            row = _floor((index + 0.5) / counts.x)  # integers, even after an inexact division
            layer = _floor((row + 0.5) / counts.y)
            place = Vector(index - row * counts.x, row - layer * counts.y, layer)
            return q - place * spacing

        return slot(float(candidates.prod())), (0.0,), asked, lambda index: (index + 1.0,)

    def build(self, p, slot):
        rounds, start, asked, step = self._copies(p, slot)
        least = _least(rounds, start, lambda index: self._part.build(asked(index), slot), step)
        if not self._held:
            return least
        everything = self._candidates == self.count
        held = 0.5 * min((s for s, whole in zip(self.spacing, everything) if not whole), default=LARGEST)
        low, high = self._part.bounds()
        middle = slot(tuple(((low + high) / 2.0).tolist()))
        box = Box(tuple((high - low) / 2.0 + self._extent)).build(p - middle, slot)
        return maximum(minimum(least, slot(held)), box)

    def bounds(self, matrix=None):
        low, high = self._part.bounds(matrix)
        linear = np.eye(3) if matrix is None else matrix[:3, :3]
        endless = (linear[:, np.equal(self.count, 0.0)] != 0.0).any(axis=1)
        margin = np.where(endless, np.inf, np.abs(linear) @ self._extent)
        return low - margin, high + margin

    def growth(self, matrix=None):
        return self._part.growth(matrix)

    def _places(self):
        index = np.array(list(np.ndindex(*map(int, self.count))))
        places = np.tile(np.eye(4), (len(index), 1, 1))
        places[:, :3, 3] = index * self.spacing - self._extent
        return places

    def _apart(self):
        return bool(np.logical_or(np.equal(self.count, 1.0), self._widths() < self.spacing).all())

    def relation(self):
        problem = super().relation()
        if problem or self.child.validate():
            return problem
        endless = np.equal(self.count, 0.0)
        if not self.child.bounded and not np.isfinite(self._widths()[endless]).all():
            return "Repetition: a shape without end is repeated without end: give a count, or intersect it with a box."
        if not self.child.bounded and self._held:
            return (
                f"Repetition: more than {_MOST_COPIES} copies of a shape without end: "
                "make the count smaller, or intersect the shape with a box."
            )
        if self._candidates.prod() > _MOST_CANDIDATES:
            return (
                f"Repetition: more than {_MOST_CANDIDATES} copies overlap each other: make the spacing larger, or "
                "the count or the shape smaller."
            )
        return ""


@frozen
class PolarRepetition(Repeated):
    """Copies of the shape around the z axis, at equal angles. They may overlap."""

    child: Shape = part("Shape that is repeated")
    count: float = number(
        6.0,
        "Copies on the full circle",
        unit="NONE",
        minimum=1.0,
        maximum=_MOST_CANDIDATES,
        soft_maximum=32.0,
        whole=True,
    )

    @property
    def _angle(self) -> float:
        return math.tau / self.count

    @cached_property
    def _sector(self) -> tuple[float, float]:
        """Middle and half width of the angle around the axis that contains the shape."""
        low, high = self.child.bounds()
        corners = [complex(x, y) for x in (low[0], high[0]) for y in (low[1], high[1])]
        middle = complex((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0)
        around_axis = low[0] <= 0.0 <= high[0] and low[1] <= 0.0 <= high[1]
        if around_axis or not np.isfinite(corners).all():
            return 0.0, math.pi
        # The box is in a half plane beside the axis: no corner is more than half a turn from another.
        turned = np.angle(np.array(corners) / middle)
        half = (turned.max() - turned.min()) / 2.0
        return float(np.angle(middle) + turned.min() + half), float(half)

    @property
    def _candidates(self) -> float:
        _, half = self._sector
        if not self.child.exact_outside or half == math.pi:
            return self.count
        return min(self.count, math.ceil(2.0 * half / self._angle) + 1.0)

    def _copies(self, p, slot):
        middle, half = self._sector
        angle = slot(self._angle)
        first = angle * _floor((apply("atan2", p.y, p.x) - slot(middle + half)) / angle + 0.5)
        start = _turned(p.x, p.y, cos(first), sin(first))
        c, s = slot(math.cos(self._angle)), slot(math.sin(self._angle))
        return (
            slot(self._candidates),
            start,
            lambda x, y: Vector(x, y, p.z),
            lambda x, y: _turned(x, y, c, s),
        )

    def build(self, p, slot):
        rounds, start, asked, step = self._copies(p, slot)
        return _least(rounds, start, lambda x, y: self.child.build(asked(x, y), slot), step)

    def _places(self):
        angles = self._angle * np.arange(self.count)
        places = np.tile(np.eye(4), (len(angles), 1, 1))
        places[:, 0, 0] = places[:, 1, 1] = np.cos(angles)
        places[:, 1, 0] = np.sin(angles)
        places[:, 0, 1] = -places[:, 1, 0]
        return places

    def bounds(self, matrix=None):
        return images(self.child.bounds(), self._places() if matrix is None else matrix @ self._places())

    def growth(self, matrix=None):
        return images_growth(self.child.growth(), self._places() if matrix is None else matrix @ self._places())

    def _number(self):
        return self.count

    def _apart(self):
        return self.count == 1.0 or 2.0 * self._sector[1] < self._angle


def _turned(x: Formula, y: Formula, c: Formula, s: Formula) -> tuple[Formula, Formula]:
    """(x, y) rotated clockwise by the angle of cosine c and sine s."""
    return c * x + s * y, c * y - s * x
