# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids with flat faces. All distances are exact.

A point is first reflected into one chamber of the solid's symmetry. The nearest point of a convex solid lies in the
same chamber, which contains little of the solid: a part of a face, half of an edge, a corner.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select
from ..program import Op, combine, primitive
from . import support
from .base import Slots, number
from .clipping import half_space, placed, polyhedron
from .polygons import Polygonal, Rectangle, RegularPolygon
from .primitives import Primitive, corner, rhombus_side
from .reflections import GOLDEN, into_icosahedral_chamber, into_octahedral_chamber, into_tetrahedral_chamber
from .sectors import MOST_SECTORS
from .swept import Prismatic


def _cyclic(points) -> np.ndarray:
    """Points (n, 3) with their coordinates in each of the three cyclic orders."""
    return np.concatenate([np.roll(points, shift, axis=1) for shift in range(3)])


def _signs(*magnitudes: float) -> np.ndarray:
    """All points whose coordinates have these magnitudes, with all combinations of signs."""
    return np.array(list(itertools.product(*[(m, -m) if m else (0.0,) for m in magnitudes])))


_OCTAHEDRON = _cyclic(_signs(1.0, 0.0, 0.0))
_CUBE = _signs(1.0, 1.0, 1.0) / math.sqrt(3.0)
_TETRAHEDRON = _CUBE[np.prod(_CUBE, axis=1) > 0.0]
_ICOSAHEDRON = _cyclic(_signs(0.0, GOLDEN, 1.0)) / math.hypot(GOLDEN, 1.0)
_DODECAHEDRON = np.concatenate([_CUBE, _cyclic(_signs(GOLDEN, 0.0, 1.0 / GOLDEN)) / math.sqrt(3.0)])


# -- regular polyhedra ------------------------------------------------------------------------------------------------


class Regular(Primitive, abstract=True):
    """A solid whose symmetry maps each of its faces, edges and corners to every other.

    ``corners`` are those of radius 1, ``normals`` the unit normals of the faces. ``chamber`` has the directions of the
    centre of a face, the middle of one of its edges and an end of that edge: ``_folded`` moves points between them.
    """

    radius: float
    corners: np.ndarray
    normals: np.ndarray
    chamber: tuple
    _folded: Callable[[Vector], Vector]

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        normal, middle, end = (np.divide(v, np.linalg.norm(v)) for v in cls.chamber)
        cls._inradius = float(end @ normal)
        middle = middle * (end @ middle)
        # Out of the face, towards the edge, along the edge: three perpendicular directions.
        outwards, along = middle - cls._inradius * normal, end - middle
        cls._apothem, cls._half_edge = float(np.linalg.norm(outwards)), float(np.linalg.norm(along))
        cls._frame = [Vector(*v.tolist()) for v in (normal, outwards / cls._apothem, along / cls._half_edge)]

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, p = slot(self.radius), self._folded(p)
        ratios = self._inradius, self._apothem, self._half_edge
        out, outwards, along = (p.dot(axis) - radius * ratio for axis, ratio in zip(self._frame, ratios))
        return corner((out,), (outwards, along))

    def volume(self) -> float:
        sides = round(math.pi / math.atan2(self._half_edge, self._apothem))  # of a face
        face = sides * self._apothem * self._half_edge
        return len(self.normals) * face * self._inradius / 3.0 * self.radius**3

    def support(self, directions):
        return support.of_points(directions, self.radius * self.corners)

    def program(self, matrix=None):
        return polyhedron(matrix, self.normals, self.radius * self._inradius)


@frozen
class Tetrahedron(Regular):
    """A pyramid of four equal triangles.

    Its corners are four of the eight corners of a cube.
    """

    corners = _TETRAHEDRON
    normals = -_TETRAHEDRON
    chamber = (-1.0, 1.0, 1.0), (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)

    radius: float = number(0.75, "Distance from the centre to the corners")

    _folded = staticmethod(into_tetrahedral_chamber)


@frozen
class Octahedron(Regular):
    """Two square pyramids joined at their bases: eight equal triangles.

    Its corners are on the axes.
    """

    corners = _OCTAHEDRON
    normals = _CUBE
    chamber = (1.0, 1.0, 1.0), (0.0, 1.0, 1.0), (0.0, 0.0, 1.0)

    radius: float = number(0.65, "Distance from the centre to the corners")

    _folded = staticmethod(into_octahedral_chamber)


class _Icosahedral(Regular, abstract=True):
    chamber = (1.0, 0.0, GOLDEN), (0.0, 0.0, 1.0), (0.0, 1.0 / GOLDEN, GOLDEN)

    _folded = staticmethod(into_icosahedral_chamber)


@frozen
class Dodecahedron(_Icosahedral):
    """A ball-like solid with twelve pentagons as faces."""

    corners = _DODECAHEDRON
    normals = _ICOSAHEDRON

    radius: float = number(0.6, "Distance from the centre to the corners")


@frozen
class Icosahedron(_Icosahedral):
    """A ball-like solid with twenty triangles as faces."""

    corners = _ICOSAHEDRON
    normals = _DODECAHEDRON
    chamber = _Icosahedral.chamber[::-1]

    radius: float = number(0.6, "Distance from the centre to the corners")


@frozen
class RhombicDodecahedron(Primitive):
    """A solid with twelve rhombi as faces; copies of it fill space without gaps."""

    radius: float = number(0.65, "Distance from the centre to the six farthest corners, which are on the axes")

    def build(self, p: Vector, slot: Slots) -> Formula:
        p, half = into_octahedral_chamber(p), math.sqrt(0.5)
        # Of the face around (0, 1, 1), a rhombus with its diagonals along (0, −1, 1) and x.
        out = (p.z + p.y) * half - slot(self.radius * half)
        return corner((out,), rhombus_side((p.z - p.y) * half, p.x, self.radius * half, 0.5 * self.radius, slot))

    def volume(self) -> float:
        return 2.0 * self.radius**3

    def support(self, directions):
        return support.of_points(directions, self.radius * np.concatenate([_OCTAHEDRON, 0.5 * math.sqrt(3.0) * _CUBE]))

    def program(self, matrix=None):
        return polyhedron(matrix, _cyclic(_signs(1.0, 1.0, 0.0)), self.radius)


# -- prisms and pyramids ----------------------------------------------------------------------------------------------


@frozen
class Prism(Prismatic):
    """A bar along z with a regular polygon of any number of sides as its ends.

    One of the corners is in the direction of y.
    """

    sides: float = number(
        5.0, "Number of sides", unit="NONE", minimum=3.0, maximum=MOST_SECTORS, soft_maximum=12.0, whole=True
    )
    radius: float = number(0.5, "Distance from the axis to the corners")
    height: float = number(0.8, "Length along z")

    def _profile(self):
        return RegularPolygon(self.sides, self.radius)


@frozen
class TriangularPrism(Prismatic):
    """A bar along z with equilateral triangles as its ends; a corner is in the direction of y."""

    radius: float = number(0.6, "Distance from the axis to the corners")
    height: float = number(0.8, "Length along z")

    def _profile(self):
        return RegularPolygon(3, self.radius)


@frozen
class HexagonalPrism(Prismatic):
    """A bar along z with regular hexagons as its ends; a corner is in the direction of y."""

    radius: float = number(0.5, "Distance from the axis to the corners")
    height: float = number(0.8, "Length along z")

    def _profile(self):
        return RegularPolygon(6, self.radius)


class _Pyramidal(Primitive, abstract=True):
    """The base of pyramids: equal slanted faces that rise from a polygon to a tip on the z axis."""

    def _base(self) -> Polygonal:
        raise NotImplementedError

    def _folded(self, p: Vector, slot: Slots) -> tuple[Formula, Formula]:
        """Coordinates of p relative to the nearest side of the base: outwards from the axis, and along the side from
        its middle: ≥ 0."""
        return self._base().folded(p, slot)

    def _middles(self) -> np.ndarray:
        """Middles of the sides of the base, (n, 2)."""
        outline = self._base().outline()
        return 0.5 * (outline + np.roll(outline, -1, axis=0))

    def _apothem(self) -> float:
        """Distance from the axis to the sides of the base."""
        return float(np.linalg.norm(self._middles()[0]))

    def _slopes(self, height: float) -> np.ndarray:
        """Normals (n, 3) of the faces below a tip ``height`` above the base."""
        apothem = self._apothem()
        return np.insert(self._middles() * (height / apothem), 2, apothem, axis=1)

    def _corners(self, z: float) -> np.ndarray:
        """Corners (n, 3) of the base at height z."""
        return np.insert(self._base().outline(), 2, z, axis=1)

    def _slant(self, p: Vector, up: Formula, height: float, slot: Slots) -> tuple[Formula, Formula, Formula]:
        """The signed distance to the slanted faces, that to the rim or base, and a value that is negative where the
        latter holds.

        ``up`` is the height above the base, ``height`` that of the tip.
        """
        apothem, half_side = self._apothem(), 0.5 * float(np.linalg.norm(np.diff(self._base().outline()[:2], axis=0)))
        out, along = self._folded(p, slot)
        out = out - slot(apothem)
        slant = math.hypot(apothem, height)
        sine, cosine = slot(apothem / slant), slot(height / slant)
        # In the plane of the face: ``climb`` from its lower edge up, ``along`` the edge from its middle.
        climb = up * cosine - out * sine
        face = corner((out * cosine + up * sine,), rhombus_side(along, climb, half_side, slant, slot))
        below = length(maximum(out, 0.0), maximum(along - slot(half_side), 0.0), up)
        return face, below, climb


class _Pyramid(_Pyramidal, abstract=True):
    """A pyramid on a base at −height/2."""

    height: float

    def build(self, p: Vector, slot: Slots) -> Formula:
        up = p.z + slot(0.5 * self.height)
        face, below, climb = self._slant(p, up, self.height, slot)
        return select(climb < 0.0, below, maximum(face, -up))

    def volume(self) -> float:
        return self._base().area() * self.height / 3.0

    def support(self, directions):
        tip = (0.0, 0.0, 0.5 * self.height)
        return support.of_points(directions, [*self._corners(-0.5 * self.height), tip])

    def program(self, matrix=None):
        slopes = self._slopes(self.height)
        offsets = [0.5 * self.height * self._apothem()] * len(slopes)
        return polyhedron(matrix, [*slopes, (0.0, 0.0, -1.0)], [*offsets, 0.5 * self.height])


@frozen
class Pyramid(_Pyramid):
    """A pyramid along z with a square base at −height/2 and its tip at +height/2."""

    half_size: float = number(0.5, "Half of the length of the base's sides, which are along x and y")
    height: float = number(0.8, "Length along z, from the base to the tip")

    def _base(self):
        return Rectangle(2.0 * self.half_size, 2.0 * self.half_size)

    def _folded(self, p, slot):
        return maximum(abs(p.x), abs(p.y)), minimum(abs(p.x), abs(p.y))


@frozen
class RegularPyramid(_Pyramid):
    """A pyramid along z with a regular polygon of any number of sides as its base.

    The base is at −height/2 with a corner in the direction of y, the tip at +height/2.
    """

    sides: float = number(
        5.0,
        "Number of sides of the base",
        unit="NONE",
        minimum=3.0,
        maximum=MOST_SECTORS,
        soft_maximum=12.0,
        whole=True,
    )
    radius: float = number(0.6, "Distance from the axis to the corners of the base")
    height: float = number(0.8, "Length along z, from the base to the tip")

    def _base(self):
        return RegularPolygon(self.sides, self.radius)


@frozen
class Bipyramid(_Pyramidal):
    """Two equal pyramids joined at their bases, a regular polygon of any number of sides: a crystal along z.

    One of the polygon's corners is in the direction of y.
    """

    sides: float = number(
        6.0,
        "Number of sides of the polygon",
        unit="NONE",
        minimum=3.0,
        maximum=MOST_SECTORS,
        soft_maximum=12.0,
        whole=True,
    )
    radius: float = number(0.4, "Distance from the axis to the corners of the polygon")
    height: float = number(1.2, "Length along z, from tip to tip")

    def _base(self):
        return RegularPolygon(self.sides, self.radius)

    def build(self, p: Vector, slot: Slots) -> Formula:
        face, rim, climb = self._slant(p, abs(p.z), 0.5 * self.height, slot)
        return select(climb < 0.0, rim, face)

    def volume(self) -> float:
        return self._base().area() * self.height / 3.0

    def support(self, directions):
        tip = support.of_segment(directions, 0.5 * self.height)
        return np.maximum(support.of_points(directions, self._corners(0.0)), tip)

    def program(self, matrix=None):
        slopes = self._slopes(0.5 * self.height)
        both = np.concatenate([slopes, slopes * (1.0, 1.0, -1.0)])
        return polyhedron(matrix, both, 0.5 * self.height * self._apothem())


# -- blocks -----------------------------------------------------------------------------------------------------------


@frozen
class Rhombus(Primitive):
    """A bar along z with rhombi as its ends; the corners are in the directions of x and y."""

    half_size: tuple[float, float, float] = number(
        (0.6, 0.35, 0.2), "Half of the rhombus' diagonals along x and y, and half of the size along z"
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        x, y, z = self.half_size
        out, past = rhombus_side(abs(p.x), abs(p.y), x, y, slot)
        return corner((out, abs(p.z) - slot(z)), (past,))

    def volume(self) -> float:
        return 4.0 * math.prod(self.half_size)

    def support(self, directions):
        x, y, z = np.abs(directions).T * np.reshape(self.half_size, (3, 1))
        return np.maximum(x, y) + z

    def program(self, matrix=None):
        x, y, z = self.half_size
        return polyhedron(matrix, [*_signs(y, x, 0.0), *_signs(0.0, 0.0, 1.0)], [x * y] * 4 + [z] * 2)


@frozen
class Wedge(Primitive):
    """A ramp: half of a block, cut along the diagonal; it rises in the direction of x."""

    half_size: tuple[float, float, float] = number((0.5, 0.4, 0.3), "Half of the size along x, y and z")

    def build(self, p: Vector, slot: Slots) -> Formula:
        x, y, z = self.half_size
        # A triangle with its right angle at the origin of (u, w), extruded along y.
        u, w = slot(x) - p.x, p.z + slot(z)
        slope, past = rhombus_side(u, w, 2.0 * x, 2.0 * z, slot)
        beside = length(u - clamp(u, 0.0, slot(2.0 * x)), w - clamp(w, 0.0, slot(2.0 * z)))
        triangle = select(minimum(u, w) < 0.0, beside, maximum(corner((slope,), (past,)), -u, -w))
        return corner((triangle, abs(p.y) - slot(y)))

    def volume(self) -> float:
        return 4.0 * math.prod(self.half_size)

    def support(self, directions):
        across, y = directions[:, [0, 2]] * self.half_size[::2], np.abs(directions[:, 1]) * self.half_size[1]
        return (across @ np.array([(-1, -1), (1, -1), (1, 1)]).T).max(axis=1) + y

    def program(self, matrix=None):
        x, _, z = self.half_size
        block = primitive(Op.BOX, placed(matrix), self.half_size)
        return combine(Op.INTERSECTION, [block, half_space(matrix, (-z, 0.0, x))])
