# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of balls, and balls cut by balls. The ball is centred at the origin; the axis is z.

All distances are exact. In the plane through the axis, the surface consists of two curves that meet in a point, the
rim. Where neither curve has a nearest point of its own, the rim is nearest. Elsewhere both distances are lower bounds
of the true one and one of them attains it, so the greater one is the distance.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select
from ..program import Op, combine, primitive
from . import support
from .base import LARGEST, Slots, number
from .clipping import half_space, placed, within_cone
from .primitives import Primitive


def _cap_volume(radius: float, height: float) -> float:
    """Volume of the cap of thickness ``height`` that a plane cuts off a ball."""
    return math.pi / 3.0 * height**2 * (3.0 * radius - height)


def _chord(radius: float, height: float) -> float:
    """Radius of the circle in which a plane at distance ``height`` from the centre cuts a sphere."""
    return math.sqrt(max((radius - height) * (radius + height), 0.0))


def circular_sector(across: Formula, along: Formula, radius: Formula, sine: Formula, cosine: Formula) -> Formula:
    """Signed distance in the plane, where across ≥ 0, to the part of a disk near the positive ``along`` axis.

    ``sine`` and ``cosine`` are those of the angle between that axis and the straight sides.
    """
    beyond_arc = length(across, along) - radius
    side = clamp(across * sine + along * cosine, 0.0, radius)
    to_side = length(across - side * sine, along - side * cosine)
    beyond_side = across * cosine - along * sine
    return maximum(beyond_arc, select(beyond_side > 0.0, to_side, -to_side))


@frozen
class SolidAngle(Primitive):
    """The part of a ball inside a cone whose tip is at the centre.

    The cone opens towards +z.
    """

    radius: float = number(0.75, "Radius of the ball")
    angle: float = number(
        math.radians(80.0),
        "Opening angle of the cone; above 180° the ball lacks a cone",
        unit="ANGLE",
        minimum=0.001,
        maximum=2.0 * math.pi - 0.001,
        soft_maximum=2.0 * math.pi - 0.001,
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = slot(math.sin(0.5 * self.angle)), slot(math.cos(0.5 * self.angle))
        return circular_sector(length(p.x, p.y), p.z, slot(self.radius), sine, cosine)

    def volume(self) -> float:
        return 4.0 / 3.0 * math.pi * self.radius**3 * math.sin(0.25 * self.angle) ** 2

    def support(self, directions):
        return np.maximum(0.0, support.of_cap(directions, self.radius, self.radius * math.cos(0.5 * self.angle)))

    def program(self, matrix=None):
        ball = primitive(Op.SPHERE, placed(matrix), (self.radius,))
        return within_cone(ball, matrix, self.angle, self.radius)


@frozen
class CutSphere(Primitive):
    """A ball with a flat bottom, cut off by a plane."""

    radius: float = number(0.5, "Radius of the ball")
    cut: float = number(
        -0.25, "Height of the plane above the centre of the ball; the part below is cut off", minimum=-LARGEST
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, cut, rim = slot(self.radius), slot(self.cut), slot(_chord(self.radius, self.cut))
        across = length(p.x, p.y)
        beyond_rim = minimum(across - rim, across * cut - p.z * rim)
        faces = maximum(p.length() - radius, cut - p.z)
        return select(beyond_rim >= 0.0, length(across - rim, p.z - cut), faces)

    def relation(self) -> str:
        if abs(self.cut) >= self.radius:
            return (
                f"Cut Sphere: the cut at {self.cut:g} does not meet the ball of radius {self.radius:g}: "
                "move the cut closer to 0."
            )
        return ""

    def volume(self) -> float:
        return _cap_volume(self.radius, self.radius - self.cut)

    def support(self, directions):
        return support.of_cap(directions, self.radius, self.cut)

    def program(self, matrix=None):
        ball = primitive(Op.SPHERE, placed(matrix), (self.radius,))
        return combine(Op.INTERSECTION, [ball, half_space(matrix, (0.0, 0.0, -1.0), -self.cut)])


@frozen
class Hemisphere(Primitive):
    """The upper half of a ball: a dome."""

    radius: float = number(0.5, "Radius of the ball")

    def _cut_sphere(self) -> CutSphere:
        return CutSphere(self.radius, 0.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._cut_sphere().build(p, slot)

    def volume(self) -> float:
        return self._cut_sphere().volume()

    def support(self, directions):
        return self._cut_sphere().support(directions)

    def program(self, matrix=None):
        return self._cut_sphere().program(matrix)


@frozen
class CutHollowSphere(Primitive):
    """A bowl: a hollow ball without its upper part, with a round rim."""

    radius: float = number(0.5, "Radius of the ball, to the middle of the wall")
    cut: float = number(
        0.1, "Height of the rim above the centre of the ball; the part above is cut off", minimum=-LARGEST
    )
    thickness: float = number(0.1, "Thickness of the wall", soft_maximum=1.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, cut, rim = slot(self.radius), slot(self.cut), slot(_chord(self.radius, self.cut))
        across = length(p.x, p.y)
        beyond_rim = p.z * rim - across * cut
        to_middle = select(beyond_rim > 0.0, length(across - rim, p.z - cut), abs(p.length() - radius))
        return to_middle - slot(0.5 * self.thickness)

    def relation(self) -> str:
        if abs(self.cut) >= self.radius:
            return (
                f"Cut Hollow Sphere: the cut at {self.cut:g} does not meet the ball of radius {self.radius:g}: "
                "move the cut closer to 0."
            )
        rim = _chord(self.radius, self.cut)
        if 0.5 * self.thickness > rim:
            return (
                f"Cut Hollow Sphere: thickness {self.thickness:g} is more than the width of the opening, "
                f"{2.0 * rim:g}, so the rim overlaps itself: make the thickness smaller."
            )
        return ""

    def volume(self) -> float:
        half_wall, rim = 0.5 * self.thickness, _chord(self.radius, self.cut)
        shell = (self.radius + half_wall) ** 3 - (self.radius - half_wall) ** 3
        wall = 2.0 / 3.0 * math.pi * (1.0 + self.cut / self.radius) * shell
        # Pappus: half a disk, whose centroid is 4/(3π) of its radius away from the rim along the wall.
        centroid = rim - self.cut / self.radius * 4.0 / (3.0 * math.pi) * half_wall
        return wall + 2.0 * math.pi * centroid * 0.5 * math.pi * half_wall**2

    def support(self, directions):
        middle = support.of_cap(directions * (1.0, 1.0, -1.0), self.radius, -self.cut)
        return middle + support.of_ball(directions, 0.5 * self.thickness)

    def program(self, matrix=None):
        half_wall, rim = 0.5 * self.thickness, _chord(self.radius, self.cut)
        wall = primitive(Op.SPHERE, placed(matrix), (self.radius + half_wall,))
        if self.radius > half_wall:
            wall = combine(Op.DIFFERENCE, [wall, primitive(Op.SPHERE, placed(matrix), (self.radius - half_wall,))])
        downwards = placed(matrix) @ np.diag([1.0, 1.0, -1.0, 1.0])
        wall = within_cone(wall, downwards, 2.0 * math.atan2(rim, -self.cut), self.radius + half_wall)
        return combine(Op.UNION, [wall, primitive(Op.TORUS, placed(matrix, z=self.cut), (rim, half_wall))])


@frozen
class DeathStar(Primitive):
    """A ball with a round dent made by another ball above it."""

    radius: float = number(0.5, "Radius of the ball")
    dent_radius: float = number(0.35, "Radius of the ball that made the dent")
    offset: float = number(0.6, "Distance between the centres of the two balls")

    def _rim(self) -> tuple[float, float]:
        """Radius and height of the circle in which the spheres meet."""
        height = 0.5 * (self.offset + (self.radius - self.dent_radius) * (self.radius + self.dent_radius) / self.offset)
        return _chord(self.radius, height), height

    def build(self, p: Vector, slot: Slots) -> Formula:
        rim, height = map(slot, self._rim())
        offset = slot(self.offset)
        across, above_dent = length(p.x, p.y), p.z - offset
        # Seen from either centre, the direction is above that of the rim.
        beyond_rim = minimum(p.z * rim - across * height, above_dent * rim - across * (height - offset))
        faces = maximum(p.length() - slot(self.radius), slot(self.dent_radius) - length(across, above_dent))
        return select(beyond_rim > 0.0, length(across - rim, p.z - height), faces)

    def relation(self) -> str:
        if self.offset >= self.radius + self.dent_radius:
            return (
                f"Death Star: at offset {self.offset:g} the dent does not reach the ball: make the offset "
                f"less than the sum of the radii, {self.radius + self.dent_radius:g}."
            )
        if self.offset <= abs(self.radius - self.dent_radius):
            return (
                f"Death Star: at offset {self.offset:g} one ball lies inside the other: make the offset "
                f"more than the difference of the radii, {abs(self.radius - self.dent_radius):g}."
            )
        return ""

    def volume(self) -> float:
        _, height = self._rim()
        dent = _cap_volume(self.radius, self.radius - height) + _cap_volume(
            self.dent_radius, self.dent_radius - (self.offset - height)
        )
        return 4.0 / 3.0 * math.pi * self.radius**3 - dent

    def support(self, directions):
        _, height = self._rim()
        return support.of_cap(directions * (1.0, 1.0, -1.0), self.radius, -height)

    def program(self, matrix=None):
        ball = primitive(Op.SPHERE, placed(matrix), (self.radius,))
        dent = primitive(Op.SPHERE, placed(matrix, z=self.offset), (self.dent_radius,))
        return combine(Op.DIFFERENCE, [ball, dent])


@frozen
class Lens(Primitive):
    """A lens with two round faces and a sharp rim: the intersection of two equal balls."""

    radius: float = number(0.6, "Radius of the rim")
    thickness: float = number(0.5, "Thickness along z, on the axis")

    def _sphere(self) -> tuple[float, float]:
        """Radius of the two spheres, and the distance of their centres from that of the lens."""
        sagitta = 0.5 * self.thickness
        return (self.radius**2 + sagitta**2) / self.thickness, (self.radius**2 - sagitta**2) / self.thickness

    def build(self, p: Vector, slot: Slots) -> Formula:
        sphere, center = map(slot, self._sphere())
        rim, across, z = slot(self.radius), length(p.x, p.y), abs(p.z)
        above = z + center
        return select(above * rim < across * center, length(across - rim, z), length(across, above) - sphere)

    def relation(self) -> str:
        if self.thickness > 2.0 * self.radius:
            return (
                f"Lens: thickness {self.thickness:g} is more than that of a ball, {2.0 * self.radius:g}: "
                "make the lens thinner or wider."
            )
        return ""

    def volume(self) -> float:
        return 2.0 * _cap_volume(self._sphere()[0], 0.5 * self.thickness)

    def support(self, directions):
        sphere, center = self._sphere()
        upwards = directions * (1.0, 1.0, 0.0) + np.abs(directions) * (0.0, 0.0, 1.0)
        return support.of_cap(upwards, sphere, center) - center * upwards[:, 2]

    def program(self, matrix=None):
        sphere, center = self._sphere()
        balls = [primitive(Op.SPHERE, placed(matrix, z=z), (sphere,)) for z in (-center, center)]
        return combine(Op.INTERSECTION, balls)
