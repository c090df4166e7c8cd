# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes warped by a map of space that is not affine: twist, bend, taper.

The child's field φ is evaluated at T(p), where the warp moves T(p) to p. T may stretch without limit far away, so φ∘T
has no Lipschitz bound in all of space. But φ, guarded, is at least the distance to the child's box B. So where it is
less than a margin m, T(p) is within m of B, and there the greatest singular value of T's Jacobian has a bound S. The
field

    max(min(φ(T(p)), m) / S, distance to a box around the warped shape)

is constant in its first part wherever that bound is not known to hold. So it keeps the child's Lipschitz bound, if T is
continuous wherever it leads to within m of B. And it is negative where φ∘T is.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import Vector, apply, clamp, cos, length, maximum, minimum, sin
from .base import Shape, Slots, number, part
from .operators import Operator, Transformed, guarded
from .primitives import Box

_MARGIN = 0.125  # of the greatest side of the child's box
_THINNEST = 0.01  # least scale of a taper


class Warp(Operator, abstract=True):
    """The child's field at ``_asked(p)``, clamped and divided as the module describes."""

    @cached_property
    def _guarded(self) -> Shape:
        return guarded(self.child)

    @cached_property
    def _box(self) -> tuple[np.ndarray, np.ndarray]:
        """The child's box (low, high)."""
        return self.child.bounds()

    @property
    def _margin(self) -> float:
        low, high = self._box
        return _MARGIN * float((high - low).max())

    def _asked(self, p: Vector, slot: Slots) -> Vector:
        raise NotImplementedError

    def _stretch(self) -> float:
        """Bound of the greatest singular value of the Jacobian, where the result is within the margin of the box."""
        raise NotImplementedError

    def _warped_box(self) -> tuple[np.ndarray, np.ndarray]:
        """A box (low, high) around the warped shape."""
        raise NotImplementedError

    @cached_property
    def _around(self) -> Transformed:
        low, high = self._warped_box()
        place = np.eye(4)
        place[:3, 3] = (low + high) / 2.0
        return Transformed(Box(tuple((high - low) / 2.0)), place)

    @cached_property
    def lipschitz(self):
        return self._guarded.lipschitz

    def build(self, p, slot):
        field = self._guarded.build(self._asked(p, slot), slot)
        stretch = max(self._stretch(), 1.0)
        return maximum(minimum(field, slot(self._margin)) * slot(1.0 / stretch), self._around.build(p, slot))

    def bounds(self, matrix=None):
        return self._around.bounds(matrix)

    def growth(self, matrix=None):
        return self._around.growth(matrix)

    def relation(self):
        if not self.child.validate() and not self.child.bounded:
            return f"{self.label()}: the shape has no end: intersect it with a box first."
        return ""


def _greatest_singular_value(a: float, b: float) -> float:
    """Greatest singular value of the matrix (a, b; 0, 1)."""
    trace = a * a + b * b + 1.0
    return math.sqrt(0.5 * (trace + math.sqrt(max(trace * trace - 4.0 * a * a, 0.0))))


def _farthest(low: np.ndarray, high: np.ndarray) -> float:
    """Greatest distance from the z axis in a box."""
    return math.hypot(max(abs(low[0]), abs(high[0])), max(abs(low[1]), abs(high[1])))


@frozen
class Twist(Warp):
    """The shape twisted around the z axis; the plane z = 0 stays."""

    child: Shape = part("Shape that is twisted")
    angle: float = number(
        math.radians(90.0),
        "Rotation per metre along z, counter-clockwise as seen from above",
        unit="ANGLE",
        minimum=-1e4,
        maximum=1e4,
        soft_maximum=math.tau,
    )

    def _asked(self, p, slot):
        turn = p.z * slot(self.angle)
        c, s = cos(turn), sin(turn)
        return Vector(c * p.x + s * p.y, c * p.y - s * p.x, p.z)

    def _stretch(self):
        # At the distance r from the axis the twist is a shear by angle · r across it.
        return _greatest_singular_value(1.0, abs(self.angle) * (_farthest(*self._box) + self._margin))

    def _warped_box(self):
        low, high = self._box
        farthest = _farthest(low, high)
        return np.array([-farthest, -farthest, low[2]]), np.array([farthest, farthest, high[2]])

    def volume(self):
        return self.child.volume()


@frozen
class Bend(Warp):
    """The shape bent upwards: the x axis becomes a circle around a line parallel to y, above the origin.

    Lengths along x stay as they are at z = 0; above they become shorter, below longer.
    """

    child: Shape = part("Shape that is bent")
    radius: float = number(1.0, "Radius of the circle that the x axis becomes")

    @property
    def _gap(self) -> float:
        """Distance of the box from two positions that it must not reach: the centre, and where both ends of the circle
        meet."""
        low, high = self._box
        ends = math.pi * self.radius - max(abs(low[0]), abs(high[0]))
        return float(min(self.radius - high[2], ends))

    @property
    def _margin(self):
        return min(super()._margin, 0.25 * self._gap)

    def _asked(self, p, slot):
        radius = slot(self.radius)
        up = radius - p.z
        # Their difference is radius − length(x, radius − z), without the digits lost for large radii.
        height = (p.z * (radius + up) - p.x * p.x) / (radius + length(p.x, up))
        return Vector(radius * apply("atan2", p.x, up), p.y, height)

    def _stretch(self):
        return self.radius / (self.radius - self._box[1][2] - self._margin)

    def _warped_box(self):
        low, high = self._box
        start, end = low[0] / self.radius, high[0] / self.radius
        quarters = math.pi / 2.0 * np.arange(-2.0, 3.0)
        angles = np.array([start, end, *quarters[(quarters > start) & (quarters < end)]])
        radii = np.array([self.radius - high[2], self.radius - low[2]])
        x = np.outer(radii, np.sin(angles))
        z = self.radius - np.outer(radii, np.cos(angles))
        return np.array([x.min(), low[1], z.min()]), np.array([x.max(), high[1], z.max()])

    def relation(self):
        problem = super().relation()
        if problem or self.child.validate():
            return problem
        low, high = self._box
        if high[2] >= self.radius:
            return (
                f"Bend: the shape, {high[2]:g} high, reaches the centre of the circle of radius {self.radius:g}: "
                "make the radius larger."
            )
        if self._gap <= 0.0:
            return (
                f"Bend: the shape is longer than the circle of radius {self.radius:g} is round: make the radius larger."
            )
        return ""


@frozen
class Taper(Warp):
    """The shape made wider or narrower across z, evenly from its lower to its upper end."""

    child: Shape = part("Shape that is tapered")
    bottom: float = number(1.0, "Scale at the lower end", unit="NONE", minimum=_THINNEST, maximum=1e3, soft_maximum=2.0)
    top: float = number(0.5, "Scale at the upper end", unit="NONE", minimum=_THINNEST, maximum=1e3, soft_maximum=2.0)

    def _asked(self, p, slot):
        low, high = self._box
        share = clamp((p.z - slot(float(low[2]))) * slot(1.0 / self._height), 0.0, 1.0)
        scale = slot(self.bottom) + slot(self.top - self.bottom) * share
        return Vector(p.x / scale, p.y / scale, p.z)

    @property
    def _height(self) -> float:
        low, high = self._box
        return max(float(high[2] - low[2]), 1e-12)

    def _stretch(self):
        # Across the axis 1 / scale, and a shear that grows with the distance from it.
        least = min(self.bottom, self.top)
        slope = abs(self.top - self.bottom) / self._height
        return _greatest_singular_value(1.0 / least, slope * (_farthest(*self._box) + self._margin) / least)

    def _warped_box(self):
        low, high = self._box
        scales = np.array([[self.bottom], [self.top]])
        corners = np.concatenate([low[:2] * scales, high[:2] * scales])
        return np.array([*corners.min(axis=0), low[2]]), np.array([*corners.max(axis=0), high[2]])
