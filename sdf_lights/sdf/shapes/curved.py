# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids with curved sides: pods, eggs, drops, hearts, superellipsoids."""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, length, maximum, power, select
from ..program import Op, combine, primitive
from . import support
from .base import BOUND, Slots, number
from .clipping import placed
from .primitives import Primitive
from .profiles import Almond
from .solids import RoundCone
from .swept import Revolution

_TINY = 1e-150  # far below any relevant length; its square is not 0
_SHARPEST = 20.0  # exponent: at an edge of a superellipsoid that is nearly a box


@frozen
class Vesica(Primitive):
    """A pod along z, pointed at both ends: an arc revolved about its chord.

    Also known as a lemon, or vesica piscis in the plane.
    """

    half_width: float = number(0.25, "Greatest distance from the axis to the surface")
    half_height: float = number(0.5, "Distance from the centre to the points, along z")

    def _revolution(self) -> Revolution:
        return Revolution(Almond(self.half_width, self.half_height))

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._revolution().build(p, slot)

    def relation(self) -> str:
        if self.half_width > self.half_height:
            return (
                f"Vesica: half width {self.half_width:g} is more than the half height {self.half_height:g}: make "
                "it smaller, or use a lens."
            )
        return ""

    def volume(self) -> float:
        return self._revolution().volume()

    def support(self, directions):
        return self._revolution().support(directions)


@frozen
class Egg(Primitive):
    """An egg along z: two balls and between them an arc that touches both, without a crease.

    The larger ball is below.
    """

    bottom_radius: float = number(0.36, "Radius of the larger ball")
    top_radius: float = number(0.2, "Radius of the smaller ball")
    height: float = number(0.4, "Distance between the centres of the balls")

    def _arc(self) -> float:
        """Distance beyond the axis of the centre of the side's arc, at the height of the lower centre.

        The arc's radius, minus that of the upper ball, is the distance between their centres.
        """
        difference = self.bottom_radius - self.top_radius
        return 0.5 * (self.height - difference) * (self.height + difference) / difference

    def _lower(self) -> float:
        """z of the lower centre."""
        return 0.5 * (self.bottom_radius - self.top_radius - self.height)

    def build(self, p: Vector, slot: Slots) -> Formula:
        bottom, top, away, height = (
            slot(value) for value in (self.bottom_radius, self.top_radius, self._arc(), self.height)
        )
        across, up = length(p.x, p.y), p.z - slot(self._lower())
        above = up - height
        side = length(across + away, up) - (away + bottom)
        upper = select(above * away > across * height, length(across, above) - top, side)
        return select(up < 0.0, length(across, up) - bottom, upper)

    def relation(self) -> str:
        difference = self.bottom_radius - self.top_radius
        if difference < 1e-6 * self.height:
            return (
                f"Egg: top radius {self.top_radius:g} must be less than the bottom radius {self.bottom_radius:g}: "
                "make it smaller, or use a capsule."
            )
        if self.height <= difference:
            return (
                f"Egg: at height {self.height:g} one ball lies inside the other: make the height more "
                f"than the difference of the radii, {difference:g}."
            )
        return ""

    def volume(self) -> float:
        bottom, top, away = self.bottom_radius, self.top_radius, self._arc()
        radius = away + bottom
        # Where the arc touches the upper ball, above the lower centre.
        seam = radius * self.height / (radius - top)
        cap = self.height + top - seam
        angle = math.asin(seam / radius)
        side = math.pi * (
            (radius**2 + away**2) * seam
            - seam**3 / 3.0
            - away * (seam * math.sqrt((radius - seam) * (radius + seam)) + radius**2 * angle)
        )
        return 2.0 / 3.0 * math.pi * bottom**3 + side + math.pi / 3.0 * cap**2 * (3.0 * top - cap)

    def support(self, directions):
        across, up, size = np.hypot(*directions[:, :2].T), directions[:, 2], np.linalg.norm(directions, axis=1)
        away = self._arc()
        upper = np.where(
            up * away > across * self.height,
            up * self.height + self.top_radius * size,
            (away + self.bottom_radius) * size - away * across,
        )
        return up * self._lower() + np.where(up < 0.0, self.bottom_radius * size, upper)


def _drop(matrix: np.ndarray | None, radius: float, height: float) -> np.ndarray:
    """Program of a ball at the origin and the cone from it to a point at z = ``height``."""
    seam = radius**2 / height
    cone = primitive(
        Op.CONE,
        placed(matrix, z=0.5 * (seam + height)),
        (radius * math.sqrt((1.0 - radius / height) * (1.0 + radius / height)), height - seam),
    )
    return combine(Op.UNION, [primitive(Op.SPHERE, placed(matrix), (radius,)), cone])


@frozen
class Droplet(Primitive):
    """A drop along z: a ball at −height/2 that narrows to a point at +height/2."""

    radius: float = number(0.3, "Radius of the ball")
    height: float = number(0.7, "Distance from the centre of the ball to the point")

    def _round_cone(self) -> RoundCone:
        return RoundCone(self.radius, 0.0, self.height)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._round_cone().build(p, slot)

    def relation(self) -> str:
        if self.height <= self.radius:
            return (
                f"Droplet: at height {self.height:g} the point lies in the ball: make the height more than the "
                f"radius {self.radius:g}."
            )
        return ""

    def volume(self) -> float:
        return self._round_cone().volume()

    def support(self, directions):
        return self._round_cone().support(directions)

    def program(self, matrix=None):
        return _drop(placed(matrix, z=-0.5 * self.height), self.radius, self.height)


@frozen
class Heart(Primitive):
    """A heart of two drops that lean apart from one point at the bottom.

    The distance is exact outside. Inside it never exceeds the distance to the surface: the field of one drop does not
    know that its surface ends in the other.
    """

    exactness = BOUND
    exact_outside = True

    radius: float = number(0.28, "Radius of the drops")
    height: float = number(0.62, "Distance from the point to the centres of the drops")
    spread: float = number(
        math.radians(38.0),
        "Angle between the axes of the drops",
        unit="ANGLE",
        minimum=0.0,
        maximum=math.pi,
        soft_maximum=0.5 * math.pi,
    )

    def _drop(self) -> RoundCone:
        return RoundCone(0.0, self.radius, self.height)

    def _axis(self) -> tuple[float, float]:
        """x and z of the direction of the drop that leans to positive x."""
        return math.sin(0.5 * self.spread), math.cos(0.5 * self.spread)

    def _point(self) -> float:
        """z of the point: the box is centred."""
        return -0.5 * (self.height * self._axis()[1] + self.radius)

    def build(self, p: Vector, slot: Slots) -> Formula:
        # A drop consists of balls with their centres on this side of the plane x = 0. Its part beyond the plane,
        # mirrored, is in the same balls. So for a point on this side, the drop on this side is the nearer one.
        sine, cosine = (slot(value) for value in self._axis())
        x, z = abs(p.x), p.z - slot(self._point())
        along = x * sine + z * cosine - slot(0.5 * self.height)
        return self._drop().build(Vector(x * cosine - z * sine, p.y, along), slot)

    def relation(self) -> str:
        if self.height <= self.radius:
            return (
                f"Heart: at height {self.height:g} the point lies in the drops: make the height more than the "
                f"radius {self.radius:g}."
            )
        return ""

    def support(self, directions):
        sine, cosine = self._axis()
        lobe = self.height * (np.abs(directions[:, 0]) * sine + directions[:, 2] * cosine)
        lobe += support.of_ball(directions, self.radius)
        return self._point() * directions[:, 2] + np.maximum(lobe, 0.0)

    def program(self, matrix=None):
        sine, cosine = self._axis()
        drops = []
        for side in (-1.0, 1.0):
            leaning = np.eye(4)
            leaning[:3, :3] = [(cosine, 0.0, side * sine), (0.0, 1.0, 0.0), (-side * sine, 0.0, cosine)]
            upright = np.diag([1.0, -1.0, -1.0, 1.0])  # the ball is at the far end
            upright[2, 3] = self.height
            drops.append(_drop(placed(matrix, z=self._point()) @ leaning @ upright, self.radius, self.height))
        return combine(Op.UNION, drops)


@frozen
class Superellipsoid(Primitive):
    """A form between a double pyramid, an ellipsoid and a box, set by two exponents.

    An exponent of 1 gives straight lines with an edge, 2 an ellipse, larger ones a box with round edges. The solid is
    the unit ball of the norm N = ((|x/a|ʳ + |y/b|ʳ)^(t/r) + |z/c|ᵗ)^(1/t). A norm that is at most L |p| has the
    Lipschitz bound L, because N(p) − N(q) ≤ N(p − q). The field is (N − 1) / L. |p| is itself the norm for r = t = 2,
    and the r-norm of two numbers is at most max(1, 2^(1/r − 1/2)) times their 2-norm. So L follows factor by factor.
    """

    exactness = BOUND

    half_size: tuple[float, float, float] = number((0.5, 0.5, 0.5), "Half of the size along x, y and z")
    exponent_xy: float = number(
        4.0,
        "Exponent r of the outline as seen along z",
        unit="NONE",
        minimum=1.0,
        maximum=_SHARPEST,
        label="Exponent XY",
    )
    exponent_z: float = number(
        4.0,
        "Exponent t of the outline as seen from the side",
        unit="NONE",
        minimum=1.0,
        maximum=_SHARPEST,
        label="Exponent Z",
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        r, t = slot(self.exponent_xy), slot(self.exponent_z)
        q = abs(p) / slot(self.half_size)
        # N(q) = m N(q/m): powers of numbers up to 1 neither overflow nor vanish.
        greatest = maximum(*q, _TINY)
        x, y, z = q / greatest
        across = power(power(x, r) + power(y, r), t / r)
        norm = greatest * power(across + power(z, t), 1.0 / t)
        return (norm - 1.0) * slot(1.0 / self._slope())

    def _slope(self) -> float:
        """The bound L of the norm."""

        def steepest(exponent):
            return max(1.0, 2.0 ** (1.0 / exponent - 0.5))

        a, b, c = self.half_size
        return steepest(self.exponent_z) * max(steepest(self.exponent_xy) / min(a, b), 1.0 / c)

    def volume(self) -> float:
        r, t = self.exponent_xy, self.exponent_z
        # Integrals of Dirichlet: the area of the outline along z, and how it shrinks with height.
        across = math.gamma(1.0 + 1.0 / r) ** 2 / math.gamma(1.0 + 2.0 / r)
        along = math.gamma(1.0 + 2.0 / t) * math.gamma(1.0 + 1.0 / t) / math.gamma(1.0 + 3.0 / t)
        return 8.0 * math.prod(self.half_size) * across * along

    def support(self, directions):
        def dual(exponent, u, v):
            """The dual norm: the greatest product with a vector of norm 1."""
            return np.maximum(u, v) if exponent == 1.0 else _norm(exponent / (exponent - 1.0), u, v)

        x, y, z = (np.abs(directions) * self.half_size).T
        return dual(self.exponent_z, dual(self.exponent_xy, x, y), z)


def _norm(exponent: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(uᵉ + vᵉ)^(1/e) of numbers ≥ 0."""
    greatest = np.maximum(np.maximum(u, v), _TINY)
    return greatest * ((u / greatest) ** exponent + (v / greatest) ** exponent) ** (1.0 / exponent)
