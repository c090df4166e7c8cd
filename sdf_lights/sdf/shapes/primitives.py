# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Primitives. Each is centred at the origin; its axis, if it has one, is z.

The distances follow from geometry: the nearest point of a convex profile, after folding by symmetry. Inigo Quilez,
"Distance functions", collects the same shapes.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select, sqrt
from ..program import Op, combine, primitive
from . import support
from .base import BOUND, SMALLEST, Shape, Slots, number


class Primitive(Shape, abstract=True):
    """A shape without children. ``op`` is its operation in the emitter's kernels, if they have one."""

    op: Op | None = None

    def support(self, directions: np.ndarray) -> np.ndarray:
        """Greatest d · x of the points x of the shape, (n,), for directions d (n, 3) of any length."""
        raise NotImplementedError

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        return support.bounds(self.support, matrix)

    def program(self, matrix: np.ndarray | None = None) -> np.ndarray:
        if self.op is None:
            return super().program(matrix)
        return primitive(self.op, np.eye(4) if matrix is None else matrix, self._program_parameters())

    def _program_parameters(self) -> tuple[float, ...]:
        return tuple(getattr(self, field.name) for field in self.fields())


@frozen
class Sphere(Primitive):
    """A ball."""

    op = Op.SPHERE

    radius: float = number(0.5, "Distance from the centre to the surface")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return p.length() - slot(self.radius)

    def volume(self) -> float:
        return 4.0 / 3.0 * math.pi * self.radius**3

    def support(self, directions):
        return support.of_ball(directions, self.radius)


@frozen
class Ellipsoid(Primitive):
    """A ball stretched along x, y and z.

    The field is that of the unit sphere in scaled space, times the least radius, which never exceeds the distance.
    """

    exactness = BOUND

    radii: tuple[float, float, float] = number((0.7, 0.5, 0.3), "Half of the size along x, y and z")

    def build(self, p: Vector, slot: Slots) -> Formula:
        radii = slot(self.radii)
        return ((p / radii).length() - 1.0) * minimum(*radii)

    def volume(self) -> float:
        return 4.0 / 3.0 * math.pi * math.prod(self.radii)

    def support(self, directions):
        return support.of_ball(directions * self.radii, 1.0)

    def program(self, matrix=None):
        stretch = np.diag([*self.radii, 1.0])
        return primitive(Op.SPHERE, stretch if matrix is None else matrix @ stretch, (1.0,))


def corner(faces, edges=()) -> Formula:
    """Signed distance to a convex corner, from coordinates along perpendicular axes.

    The solid is where all of ``faces`` are negative. ``edges`` are positive beyond the ends of its faces, and never
    inside the solid.
    """
    outside = length(*(maximum(q, 0.0) for q in (*faces, *edges)))
    return outside + minimum(maximum(*faces), 0.0)


def rhombus_side(x: Formula, y: Formula, half_width: float, half_height: float, slot: Slots) -> tuple[Formula, Formula]:
    """For a rhombus in the plane with its corners on the axes, where x and y ≥ 0: coordinates out of its side, and past
    the ends of the side. For ``corner``, as a face and an edge."""
    side = math.hypot(half_width, half_height)
    sine, cosine = half_width / side, half_height / side
    out = x * slot(cosine) + y * slot(sine) - slot(half_width * cosine)
    along = y * slot(cosine) - x * slot(sine)
    middle = 0.5 * (half_height * cosine - half_width * sine)
    return out, abs(along - slot(middle)) - slot(0.5 * side)


@frozen
class Box(Primitive):
    """A rectangular block."""

    op = Op.BOX

    half_size: tuple[float, float, float] = number((0.5, 0.5, 0.5), "Half of the size along x, y and z")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return corner(abs(p) - slot(self.half_size))

    def volume(self) -> float:
        return 8.0 * math.prod(self.half_size)

    def support(self, directions):
        return np.abs(directions) @ self.half_size

    def _program_parameters(self):
        return self.half_size


@frozen
class BoxFrame(Primitive):
    """The twelve edges of a block, as square bars that lie inside the block."""

    half_size: tuple[float, float, float] = number((0.5, 0.5, 0.5), "Half of the outer size along x, y and z")
    thickness: float = number(0.05, "Width of the bars, measured inwards from the outer faces", soft_maximum=1.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        half_size, thickness = slot(self.half_size), slot(self.thickness)
        half_bar = thickness * 0.5
        outer = abs(p) - half_size
        # Folded into one octant, a bar along x is a box of outer length and half_bar across, centred half_bar inwards.
        across = abs(outer + half_bar) - half_bar
        outside = minimum(
            corner((outer.x, across.y, across.z)),
            corner((across.x, outer.y, across.z)),
            corner((across.x, across.y, outer.z)),
        )
        # Inside a corner, the nearest surface is not always that of the nearest bar. It is one of the outer faces or of
        # the three openings, which are convex. Each of the two formulas is exact on its own side of the surface.
        depth = (outer + thickness).maximum(0.0)
        openings = minimum(length(depth.y, depth.z), length(depth.x, depth.z), length(depth.x, depth.y))
        inside = maximum(maximum(*outer), -openings)
        return maximum(outside, 0.0) + minimum(inside, 0.0)

    def relation(self) -> str:
        if self.thickness > min(self.half_size):
            return (
                f"Box Frame: thickness {self.thickness:g} is more than the least half size "
                f"{min(self.half_size):g}, so the bars overlap: make the thickness smaller."
            )
        return ""

    def volume(self) -> float:
        # In one octant a point is in the frame if at least two of its coordinates are within the thickness of a face.
        return 8.0 * self.thickness**2 * (sum(self.half_size) - 2.0 * self.thickness)

    def support(self, directions):
        return np.abs(directions) @ self.half_size

    def program(self, matrix=None):
        parts = [Box(self.half_size).program(matrix)]
        inner = np.subtract(self.half_size, self.thickness)
        for axis in range(3):
            opening = inner.copy()
            opening[axis] = 2.0 * self.half_size[axis]  # well past the outer faces: no two faces coincide
            if opening.min() > 0.0:
                parts.append(Box(tuple(opening)).program(matrix))
        return combine(Op.DIFFERENCE, parts)


@frozen
class Torus(Primitive):
    """A ring around the z axis."""

    op = Op.TORUS

    major_radius: float = number(0.5, "Distance from the centre to the middle of the tube")
    minor_radius: float = number(0.175, "Radius of the tube")

    def build(self, p: Vector, slot: Slots) -> Formula:
        major, minor = slot(self.major_radius), slot(self.minor_radius)
        return length(length(p.x, p.y) - major, p.z) - minor

    def relation(self) -> str:
        if self.minor_radius > self.major_radius:
            return (
                f"Torus: minor radius {self.minor_radius:g} is more than the major radius {self.major_radius:g}, "
                "so the tube overlaps itself: make the minor radius smaller."
            )
        return ""

    def volume(self) -> float:
        return 2.0 * math.pi**2 * self.major_radius * self.minor_radius**2

    def support(self, directions):
        return support.of_disk(directions, self.major_radius) + support.of_ball(directions, self.minor_radius)


@frozen
class Capsule(Primitive):
    """A cylinder along z with a half ball on each end."""

    op = Op.CAPSULE

    radius: float = number(0.25, "Radius of the tube and of its ends")
    height: float = number(0.5, "Length of the straight part, without the ends", minimum=0.0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, half_height = slot(self.radius), slot(self.height) * 0.5
        return length(p.x, p.y, p.z - clamp(p.z, -half_height, half_height)) - radius

    def volume(self) -> float:
        return math.pi * self.radius**2 * (self.height + 4.0 / 3.0 * self.radius)

    def support(self, directions):
        return support.of_segment(directions, 0.5 * self.height) + support.of_ball(directions, self.radius)


@frozen
class Cylinder(Primitive):
    """A round bar along z with flat ends."""

    op = Op.CYLINDER

    radius: float = number(0.5, "Radius of the ends")
    height: float = number(1.0, "Length along z")

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, half_height = slot(self.radius), slot(self.height) * 0.5
        return corner((length(p.x, p.y) - radius, abs(p.z) - half_height))

    def volume(self) -> float:
        return math.pi * self.radius**2 * self.height

    def support(self, directions):
        return support.of_disk(directions, self.radius) + support.of_segment(directions, 0.5 * self.height)


def _frustum(p: Vector, bottom: Formula, top: Formula | float, half_height: Formula) -> Formula:
    """Signed distance to a frustum with the radius ``bottom`` at −half_height and ``top`` at +half_height."""
    across, height, narrowing = length(p.x, p.y), half_height * 2.0, bottom - top
    # In the plane through the axis: the nearest points of the slant (from the upper rim down) and of the nearer end.
    beyond_top, below_top = across - top, p.z - half_height
    slant = narrowing * narrowing + height * height
    along = clamp((beyond_top * narrowing - below_top * height) / slant, 0.0, 1.0)
    end = abs(p.z) - half_height
    to_slant = (beyond_top - along * narrowing, below_top + along * height)
    to_end = (maximum(across - select(p.z < 0.0, bottom, top), 0.0), end)
    distance = sqrt(minimum(*(u * u + v * v for u, v in (to_slant, to_end))))
    beyond_slant = beyond_top * height + below_top * narrowing
    return select(maximum(beyond_slant, end) <= 0.0, -distance, distance)


@frozen
class Cone(Primitive):
    """A cone along z: its base at −height/2, its tip at +height/2."""

    op = Op.CONE

    radius: float = number(0.5, "Radius of the base")
    height: float = number(1.0, "Length along z, from the base to the tip")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return _frustum(p, slot(self.radius), 0.0, slot(self.height) * 0.5)

    def volume(self) -> float:
        return math.pi * self.radius**2 * self.height / 3.0

    def support(self, directions):
        tip = 0.5 * self.height * directions[:, 2]
        return np.maximum(tip, support.of_disk(directions, self.radius) - tip)


@frozen
class Frustum(Primitive):
    """A cone along z without its tip, or a cylinder that becomes narrower or wider.

    Also known as a capped cone. One of the radii may be 0: then it is a cone.
    """

    op = Op.FRUSTUM

    bottom_radius: float = number(0.5, "Radius of the end at −height/2", minimum=0.0)
    top_radius: float = number(0.25, "Radius of the end at +height/2", minimum=0.0)
    height: float = number(1.0, "Length along z")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return _frustum(p, slot(self.bottom_radius), slot(self.top_radius), slot(self.height) * 0.5)

    def relation(self) -> str:
        if max(self.bottom_radius, self.top_radius) < SMALLEST:
            return f"Frustum: both radii are below {SMALLEST:g}, so nothing is left: give one end a larger radius."
        return ""

    def volume(self) -> float:
        bottom, top = self.bottom_radius, self.top_radius
        return math.pi / 3.0 * self.height * (bottom**2 + bottom * top + top**2)

    def support(self, directions):
        end = 0.5 * self.height * directions[:, 2]
        return np.maximum(
            support.of_disk(directions, self.bottom_radius) - end, support.of_disk(directions, self.top_radius) + end
        )
