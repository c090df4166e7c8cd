# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Round and box-like solids, and the infinite regions that cut others. All distances are exact."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select, sqrt
from ..program import NoClosedForm, Op, combine, primitive
from . import support
from .balls import circular_sector
from .base import LARGEST, SMALLEST, Slots, number
from .clipping import half_space, placed, sector
from .primitives import Box, Primitive, corner, rhombus_side

_ENDLESS = 1e15  # metres that replace infinity if a closed form needs a length


@frozen
class RoundedBox(Primitive):
    """A rectangular block with round edges and corners."""

    half_size: tuple[float, float, float] = number((0.5, 0.5, 0.5), "Half of the outer size along x, y and z")
    radius: float = number(0.1, "Radius of the edges", minimum=0.0, soft_maximum=1.0)

    def _core(self) -> np.ndarray:
        """Half sizes of the box that the surface is ``radius`` away from."""
        return np.subtract(self.half_size, self.radius)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return corner(abs(p) - slot(tuple(self._core()))) - slot(self.radius)

    def relation(self) -> str:
        if self.radius > min(self.half_size):
            return (
                f"Rounded Box: radius {self.radius:g} is more than the least half size {min(self.half_size):g}: "
                "make the radius smaller."
            )
        return ""

    def volume(self) -> float:
        x, y, z = 2.0 * self._core()
        r = self.radius
        # Steiner's formula for a parallel body.
        return x * y * z + 2.0 * (x * y + y * z + z * x) * r + math.pi * (x + y + z) * r**2 + 4.0 / 3.0 * math.pi * r**3

    def support(self, directions):
        return np.abs(directions) @ self._core() + support.of_ball(directions, self.radius)

    def program(self, matrix=None):
        if self.radius == 0.0:
            return Box(self.half_size).program(matrix)
        core = self._core()
        boxes = [core + self.radius * np.eye(3)[axis] for axis in range(3)]
        parts = [primitive(Op.BOX, placed(matrix), tuple(box)) for box in boxes if box.min() > 0.0]
        for axis in np.flatnonzero(core):
            turned = np.eye(4)[:, [(axis + 1) % 3, (axis + 2) % 3, axis, 3]]
            middle = core * (1.0 - np.eye(3)[axis])
            # If the core is flat, edges coincide.
            for edge in dict.fromkeys(tuple(middle * signs) for signs in itertools.product((1.0, -1.0), repeat=3)):
                place = placed(matrix, *edge) @ turned
                parts.append(primitive(Op.CAPSULE, place, (self.radius, 2.0 * core[axis])))
        return combine(Op.UNION, parts or [primitive(Op.SPHERE, placed(matrix), (self.radius,))])


@frozen
class CrossedBars(Primitive):
    """Three square bars along x, y and z that cross in the middle."""

    length: float = number(1.0, "Length of the bars")
    width: float = number(0.3, "Width of the bars")

    def build(self, p: Vector, slot: Slots) -> Formula:
        half_length, half_width = slot(0.5 * self.length), slot(0.5 * self.width)
        # Folded so that the bar along x is the nearest.
        a, b, c = abs(p)
        along, least = maximum(a, b, c), minimum(a, b, c)
        middle = maximum(minimum(a, b), minimum(maximum(a, b), c))
        bar = Vector(along - half_length, middle - half_width, least - half_width)
        # In the middle the bar is open towards the next one: its side begins at their shared edge.
        to_side = length(maximum(half_width - along, 0.0), half_width - middle)
        inside = select(maximum(*bar) < 0.0, minimum(half_length - along, to_side), 0.0)
        return bar.maximum(0.0).length() - inside

    def relation(self) -> str:
        if self.width >= self.length:
            return (
                f"Crossed Bars: width {self.width:g} is not less than the length {self.length:g}: "
                "make the bars thinner, or use a box."
            )
        return ""

    def volume(self) -> float:
        return self.width**2 * (3.0 * self.length - 2.0 * self.width)

    def _bars(self) -> list[np.ndarray]:
        return [np.full(3, 0.5 * self.width) + 0.5 * (self.length - self.width) * axis for axis in np.eye(3)]

    def support(self, directions):
        return np.max([np.abs(directions) @ bar for bar in self._bars()], axis=0)

    def program(self, matrix=None):
        return combine(Op.UNION, [primitive(Op.BOX, placed(matrix), tuple(bar)) for bar in self._bars()])


@frozen
class CappedTorus(Primitive):
    """A part of a ring around the z axis, with round ends."""

    major_radius: float = number(0.5, "Distance from the centre to the middle of the tube")
    minor_radius: float = number(0.125, "Radius of the tube and of its ends")
    angle: float = number(
        math.radians(240.0),
        "Angle around the axis from end to end; half of it on either side of the x axis",
        unit="ANGLE",
        minimum=0.0,
        maximum=2.0 * math.pi,
        soft_maximum=2.0 * math.pi,
    )

    def _end(self) -> tuple[float, float]:
        """Coordinates x and y of the middle of the tube at one end; the other end has −y."""
        return (self.major_radius * math.cos(0.5 * self.angle), self.major_radius * math.sin(0.5 * self.angle))

    def build(self, p: Vector, slot: Slots) -> Formula:
        major, x, y = slot(self.major_radius), *map(slot, self._end())
        aside, to_ring = abs(p.y), length(p.x, p.y) - major
        to_end = (p.x - x) * (p.x - x) + (aside - y) * (aside - y)
        in_plane = select(aside * x >= p.x * y, to_end, to_ring * to_ring)
        return sqrt(in_plane + p.z * p.z) - slot(self.minor_radius)

    def relation(self) -> str:
        if self.minor_radius > self.major_radius:
            return (
                f"Capped Torus: minor radius {self.minor_radius:g} is more than the major radius "
                f"{self.major_radius:g}, so the tube overlaps itself: make the minor radius smaller."
            )
        if self.angle > math.pi and self._end()[1] < self.minor_radius:
            return (
                f"Capped Torus: at {math.degrees(self.angle):g}° the ends overlap: make the angle smaller, "
                "or use a torus."
            )
        return ""

    def volume(self) -> float:
        minor = self.minor_radius
        return math.pi * minor**2 * self.major_radius * self.angle + 4.0 / 3.0 * math.pi * minor**3

    def support(self, directions):
        x, y = self._end()
        aside = np.abs(directions[:, 1])
        ends = directions[:, 0] * x + aside * y
        arc = np.where(aside * x >= directions[:, 0] * y, ends, support.of_disk(directions, self.major_radius))
        return arc + support.of_ball(directions, self.minor_radius)

    def program(self, matrix=None):
        x, y = self._end()
        ends = [primitive(Op.SPHERE, placed(matrix, x, side), (self.minor_radius,)) for side in (y, -y)]
        if self.angle == 0.0:
            return ends[0]
        ring = primitive(Op.TORUS, placed(matrix), (self.major_radius, self.minor_radius))
        arc = combine(Op.INTERSECTION, [ring, sector(matrix, self.angle)])
        return combine(Op.UNION, [arc, *ends])


@frozen
class Link(Primitive):
    """A link of a chain: a ring in the xz plane, stretched along z."""

    major_radius: float = number(0.3, "Radius of the two bends, to the middle of the tube")
    minor_radius: float = number(0.1, "Radius of the tube")
    height: float = number(0.5, "Length of the straight parts", minimum=0.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        beyond_bars = maximum(abs(p.z) - slot(0.5 * self.height), 0.0)
        return length(length(p.x, beyond_bars) - slot(self.major_radius), p.y) - slot(self.minor_radius)

    def relation(self) -> str:
        if self.minor_radius > self.major_radius:
            return (
                f"Link: minor radius {self.minor_radius:g} is more than the major radius {self.major_radius:g}, "
                "so the tube overlaps itself: make the minor radius smaller."
            )
        return ""

    def volume(self) -> float:
        return math.pi * self.minor_radius**2 * (2.0 * math.pi * self.major_radius + 2.0 * self.height)

    def support(self, directions):
        bend = self.major_radius * np.hypot(directions[:, 0], directions[:, 2])
        return bend + support.of_segment(directions, 0.5 * self.height) + support.of_ball(directions, self.minor_radius)

    def program(self, matrix=None):
        bend = np.eye(4)[:, [2, 0, 1, 3]]  # the torus' axis becomes y
        parts = []
        for side in (1.0, -1.0):
            ring = primitive(
                Op.TORUS, placed(matrix, z=side * 0.5 * self.height) @ bend, (self.major_radius, self.minor_radius)
            )
            half = half_space(matrix, (0.0, 0.0, -side), -0.5 * self.height)
            bar = primitive(Op.CAPSULE, placed(matrix, x=side * self.major_radius), (self.minor_radius, self.height))
            # The bars' round ends lie in the bends, so no faces coincide.
            parts += [combine(Op.INTERSECTION, [ring, half]), bar]
        return combine(Op.UNION, parts)


@frozen
class RoundedCylinder(Primitive):
    """A round bar along z with round edges."""

    radius: float = number(0.5, "Radius of the bar")
    height: float = number(1.0, "Length along z")
    rounding: float = number(0.1, "Radius of the edges", minimum=0.0, soft_maximum=1.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, half_height = slot(self.radius - self.rounding), slot(0.5 * self.height - self.rounding)
        return corner((length(p.x, p.y) - radius, abs(p.z) - half_height)) - slot(self.rounding)

    def relation(self) -> str:
        largest = min(self.radius, 0.5 * self.height)
        if self.rounding > largest:
            return (
                f"Rounded Cylinder: rounding {self.rounding:g} is more than the radius or half of the height: "
                f"make it at most {largest:g}."
            )
        return ""

    def volume(self) -> float:
        radius, height, r = self.radius - self.rounding, self.height - 2.0 * self.rounding, self.rounding
        body = math.pi * (radius**2 * height + 2.0 * radius * (radius + height) * r)
        # Steiner's formula: the integral of the mean curvature of a cylinder is π (height + π radius).
        return body + math.pi * (height + math.pi * radius) * r**2 + 4.0 / 3.0 * math.pi * r**3

    def support(self, directions):
        disk = support.of_disk(directions, self.radius - self.rounding)
        axis = support.of_segment(directions, 0.5 * self.height - self.rounding)
        return disk + axis + support.of_ball(directions, self.rounding)

    def program(self, matrix=None):
        core, half_core = self.radius - self.rounding, 0.5 * self.height - self.rounding
        if core == 0.0:
            return primitive(Op.CAPSULE, placed(matrix), (self.rounding, 2.0 * half_core))
        parts = [primitive(Op.CYLINDER, placed(matrix), (core, self.height))]
        if half_core > 0.0:
            parts.append(primitive(Op.CYLINDER, placed(matrix), (self.radius, 2.0 * half_core)))
        if self.rounding > 0.0:
            if self.rounding > core:
                raise NoClosedForm("Rounded Cylinder has no closed form where the edges' tori overlap themselves.")
            for z in {half_core, -half_core}:
                parts.append(primitive(Op.TORUS, placed(matrix, z=z), (core, self.rounding)))
        return combine(Op.UNION, parts)


@frozen
class Tube(Primitive):
    """A hollow round bar along z, open at both ends."""

    radius: float = number(0.5, "Outer radius")
    height: float = number(1.0, "Length along z")
    thickness: float = number(0.1, "Thickness of the wall", soft_maximum=1.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        middle, half_wall = slot(self.radius - 0.5 * self.thickness), slot(0.5 * self.thickness)
        return corner((abs(length(p.x, p.y) - middle) - half_wall, abs(p.z) - slot(0.5 * self.height)))

    def relation(self) -> str:
        if self.thickness >= self.radius:
            return (
                f"Tube: thickness {self.thickness:g} leaves no hole in a radius of {self.radius:g}: "
                "make the wall thinner, or use a cylinder."
            )
        return ""

    def volume(self) -> float:
        return math.pi * self.thickness * (2.0 * self.radius - self.thickness) * self.height

    def support(self, directions):
        return support.of_disk(directions, self.radius) + support.of_segment(directions, 0.5 * self.height)

    def program(self, matrix=None):
        # The hole is longer than the bar: no two faces coincide.
        sizes = (self.radius, self.height), (self.radius - self.thickness, 2.0 * self.height)
        return combine(Op.DIFFERENCE, [primitive(Op.CYLINDER, placed(matrix), size) for size in sizes])


@frozen
class PieSlice(Primitive):
    """A slice of a cylinder, like a slice of cake; its point is on the z axis.

    The middle of the slice is on the positive x axis.
    """

    radius: float = number(0.6, "Radius of the cylinder")
    height: float = number(0.5, "Length along z")
    angle: float = number(
        math.radians(120.0),
        "Angle at the point of the slice; above 180° the cylinder lacks a slice",
        unit="ANGLE",
        minimum=0.001,
        maximum=2.0 * math.pi - 0.001,
        soft_maximum=2.0 * math.pi - 0.001,
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = slot(math.sin(0.5 * self.angle)), slot(math.cos(0.5 * self.angle))
        slice_ = circular_sector(abs(p.y), p.x, slot(self.radius), sine, cosine)
        return corner((slice_, abs(p.z) - slot(0.5 * self.height)))

    def volume(self) -> float:
        return 0.5 * self.angle * self.radius**2 * self.height

    def support(self, directions):
        sine, cosine = math.sin(0.5 * self.angle), math.cos(0.5 * self.angle)
        aside = np.abs(directions[:, 1])
        end = self.radius * (directions[:, 0] * cosine + aside * sine)
        arc = np.where(aside * cosine > directions[:, 0] * sine, end, support.of_disk(directions, self.radius))
        return np.maximum(arc, 0.0) + support.of_segment(directions, 0.5 * self.height)

    def program(self, matrix=None):
        bar = primitive(Op.CYLINDER, placed(matrix), (self.radius, self.height))
        return combine(Op.INTERSECTION, [bar, sector(matrix, self.angle)])


@frozen
class RoundCone(Primitive):
    """A cone along z with a ball at each end: the convex hull of two balls."""

    bottom_radius: float = number(0.4, "Radius of the ball at −height/2")
    top_radius: float = number(0.2, "Radius of the ball at +height/2")
    height: float = number(0.6, "Distance between the centres of the balls")

    def _slope(self) -> tuple[float, float]:
        """Sine and cosine of the angle between the side and the axis."""
        sine = (self.bottom_radius - self.top_radius) / self.height
        return sine, math.sqrt(max((1.0 - sine) * (1.0 + sine), 0.0))

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = self._slope()
        half_height = slot(0.5 * self.height)
        across = length(p.x, p.y)
        # The solid consists of balls between the two; the nearest one lies along the normal of the side.
        center = clamp(p.z - across * slot(sine / cosine), -half_height, half_height)
        radius = slot(0.5 * (self.bottom_radius + self.top_radius)) - center * slot(sine)
        return length(across, p.z - center) - radius

    def relation(self) -> str:
        if self.height <= abs(self.bottom_radius - self.top_radius):
            return (
                f"Round Cone: at height {self.height:g} one ball lies inside the other: make the height more than "
                f"the difference of the radii, {abs(self.bottom_radius - self.top_radius):g}."
            )
        return ""

    def _side(self) -> tuple[float, float, float, float]:
        """The circles in which the side touches the balls: lower and upper radius, lower and upper z."""
        sine, cosine = self._slope()
        bottom, top = self.bottom_radius, self.top_radius
        return bottom * cosine, top * cosine, bottom * sine - 0.5 * self.height, top * sine + 0.5 * self.height

    def volume(self) -> float:
        bottom, top, low, high = self._side()
        sine, _ = self._slope()
        caps = sum(
            math.pi / 3.0 * r**3 * (1.0 + s) ** 2 * (2.0 - s)
            for r, s in ((self.bottom_radius, sine), (self.top_radius, -sine))
        )
        return caps + math.pi / 3.0 * (high - low) * (bottom**2 + bottom * top + top**2)

    def support(self, directions):
        end = 0.5 * self.height * directions[:, 2]
        return np.maximum(
            support.of_ball(directions, self.bottom_radius) - end, support.of_ball(directions, self.top_radius) + end
        )

    def program(self, matrix=None):
        bottom, top, low, high = self._side()
        balls = [
            primitive(Op.SPHERE, placed(matrix, z=z), (radius,))
            for z, radius in ((-0.5 * self.height, self.bottom_radius), (0.5 * self.height, self.top_radius))
        ]
        side = primitive(Op.FRUSTUM, placed(matrix, z=0.5 * (low + high)), (bottom, top, high - low))
        return combine(Op.UNION, [side, *balls])


@frozen
class Bicone(Primitive):
    """Two equal cones joined at their bases: a spindle along z."""

    radius: float = number(0.4, "Radius of the rim in the middle")
    height: float = number(1.2, "Length along z, from tip to tip")

    def build(self, p: Vector, slot: Slots) -> Formula:
        side, past = rhombus_side(length(p.x, p.y), abs(p.z), self.radius, 0.5 * self.height, slot)
        return corner((side,), (past,))

    def volume(self) -> float:
        return math.pi / 3.0 * self.radius**2 * self.height

    def support(self, directions):
        tip = support.of_segment(directions, 0.5 * self.height)
        return np.maximum(support.of_disk(directions, self.radius), tip)

    def program(self, matrix=None):
        # Each cone goes on beyond the rim, so their bases do not coincide.
        cones = []
        for side in (1.0, -1.0):
            place = placed(matrix, z=-0.25 * side * self.height) @ np.diag([1.0, 1.0, side, 1.0])
            cones.append(primitive(Op.CONE, place, (3.0 * self.radius, 1.5 * self.height)))
        return combine(Op.INTERSECTION, cones)


@frozen
class InfiniteCylinder(Primitive):
    """An infinite round bar along z.

    It reaches to infinity, so it is useful only where another shape cuts it.
    """

    bounded = False

    radius: float = number(0.25, "Radius of the bar")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return length(p.x, p.y) - slot(self.radius)

    def volume(self) -> float:
        return math.inf

    def support(self, directions):
        return support.of_disk(directions, self.radius) + np.where(directions[:, 2] == 0.0, 0.0, np.inf)

    def program(self, matrix=None):
        return primitive(Op.CYLINDER, placed(matrix), (self.radius, _ENDLESS))


@frozen
class HalfSpace(Primitive):
    """Everything on one side of a plane.

    It reaches to infinity, so it is useful only where it cuts another shape.
    """

    bounded = False

    normal: tuple[float, float, float] = number(
        (0.0, 0.0, 1.0),
        "Direction out of the solid, across the plane; its length does not matter",
        unit="NONE",
        minimum=-LARGEST,
        soft_maximum=1.0,
    )
    offset: float = number(0.0, "Distance of the plane from the origin, along the normal", minimum=-LARGEST)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return p.dot(slot(self._unit_normal())) - slot(self.offset)

    def _unit_normal(self) -> tuple[float, float, float]:
        return tuple(np.divide(self.normal, np.linalg.norm(self.normal)).tolist())

    def relation(self) -> str:
        if np.linalg.norm(self.normal) < SMALLEST:
            return "Half Space: the normal has no length: give at least one of its components a value other than 0."
        return ""

    def volume(self) -> float:
        return math.inf

    def support(self, directions):
        along = directions @ self._unit_normal()
        return np.where(along >= np.linalg.norm(directions, axis=1), along * self.offset, np.inf)

    def program(self, matrix=None):
        return half_space(matrix, self._unit_normal(), self.offset)


@frozen
class Slab(Primitive):
    """Everything between two planes perpendicular to the z axis.

    It reaches to infinity, so it is useful only where it cuts another shape.
    """

    bounded = False

    thickness: float = number(0.2, "Distance between the planes")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return abs(p.z) - slot(0.5 * self.thickness)

    def volume(self) -> float:
        return math.inf

    def support(self, directions):
        endless = (directions[:, 0] != 0.0) | (directions[:, 1] != 0.0)
        return np.where(endless, np.inf, support.of_segment(directions, 0.5 * self.thickness))

    def program(self, matrix=None):
        half = 0.5 * self.thickness
        return combine(
            Op.INTERSECTION, [half_space(matrix, (0.0, 0.0, 1.0), half), half_space(matrix, (0.0, 0.0, -1.0), half)]
        )
