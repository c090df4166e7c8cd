# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractals made of smaller copies of themselves, with any number of levels.

A solid's copies are mirror images of one another. Reflections lead a point to the side of the mirrors where one copy
is. Scaling that copy to the size of the whole leads to the level above. Reflections change no length locally and a
scaling changes all equally, so the distance to the final solid, scaled back, has slope 1 (J. C. Hart, D. J. Sandin, L.
H. Kauffman, "Ray tracing deterministic 3-D fractals", 1989). It is the exact distance if the reflections lead to the
nearest copy, and copies touch at most along edges.

``orbits`` has the fractals that are no copies of themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, length, maximum, select
from ...graph.loops import iterate
from ..program import Op
from . import support
from .base import BOUND, LARGEST, Shape, Slots, number
from .polyhedra import Dodecahedron, Icosahedron, Octahedron, Tetrahedron
from .primitives import Box, Primitive
from .profiles import Profile
from .reflections import GOLDEN, into_icosahedral_chamber, into_octahedral_chamber, into_tetrahedral_chamber
from .swept import Prismatic

MOST_LEVELS = 12


def levels(default: float, description: str = "How often the solid is replaced by its copies"):
    """Dataclass field of the number of levels; 0 is the solid itself."""
    return number(default, description, unit="NONE", minimum=0.0, maximum=MOST_LEVELS, soft_maximum=6.0, whole=True)


def _led(p: Vector, count: Formula, step: Callable[[Vector], Vector]) -> Vector:
    """p after ``count`` steps."""
    return Vector(*iterate(count, p, lambda *q: (tuple(step(Vector(*q))), None), MOST_LEVELS))


# -- copies at the corners --------------------------------------------------------------------------------------------


class Flake(Primitive, abstract=True):
    """A solid replaced by copies of itself in its own corners, those by their copies, and so on.

    ``_folded`` leads to the copy in ``_corner()``. ``count`` copies, ``_ratio()`` times the size, touch at most.
    """

    levels: float
    count: int
    _folded: Callable[[Vector], Vector]

    def _solid(self) -> Primitive:
        raise NotImplementedError

    def _corner(self) -> tuple[float, float, float]:
        raise NotImplementedError

    def _ratio(self) -> float:
        raise NotImplementedError

    def build(self, p: Vector, slot: Slots) -> Formula:
        growth = 1.0 / self._ratio()
        scale, shift = slot(growth), slot(tuple((growth - 1.0) * c for c in self._corner()))
        p = _led(p, slot(self.levels), lambda q: self._folded(q) * scale - shift)
        return self._solid().build(p, slot) * slot(self._ratio() ** self.levels)

    def volume(self) -> float:
        return self._solid().volume() * (self.count * self._ratio() ** 3) ** self.levels

    def support(self, directions):
        return self._solid().support(directions)


@frozen
class SierpinskiTetrahedron(Flake):
    """Four tetrahedra of half the size in the corners of one, and so on: the tetrix of Sierpiński."""

    count = 4

    radius: float = number(0.75, "Distance from the centre to the corners")
    levels: float = levels(4.0)

    _folded = staticmethod(into_tetrahedral_chamber)

    def _solid(self):
        return Tetrahedron(self.radius)

    def _corner(self):
        return (self.radius / math.sqrt(3.0),) * 3

    def _ratio(self):
        return 0.5


@frozen
class OctahedronFlake(Flake):
    """Six octahedra of half the size in the corners of one, and so on."""

    count = 6

    radius: float = number(0.65, "Distance from the centre to the corners")
    levels: float = levels(3.0)

    _folded = staticmethod(into_octahedral_chamber)

    def _solid(self):
        return Octahedron(self.radius)

    def _corner(self):
        return (0.0, 0.0, self.radius)

    def _ratio(self):
        return 0.5


@frozen
class IcosahedronFlake(Flake):
    """Twelve icosahedra in the corners of one, each as large as possible without overlap, and so on."""

    count = 12

    radius: float = number(0.6, "Distance from the centre to the corners")
    levels: float = levels(2.0)

    _folded = staticmethod(into_icosahedral_chamber)

    def _solid(self):
        return Icosahedron(self.radius)

    def _corner(self):
        size = self.radius / math.hypot(1.0, GOLDEN)
        return (size, 0.0, size * GOLDEN)

    def _ratio(self):
        return 1.0 / (1.0 + GOLDEN)


@frozen
class DodecahedronFlake(Flake):
    """Twenty dodecahedra in the corners of one, each as large as possible without overlap, and so on."""

    count = 20

    radius: float = number(0.6, "Distance from the centre to the corners")
    levels: float = levels(2.0)

    _folded = staticmethod(into_icosahedral_chamber)

    def _solid(self):
        return Dodecahedron(self.radius)

    def _corner(self):
        size = self.radius / math.sqrt(3.0)
        return (0.0, size / GOLDEN, size * GOLDEN)

    def _ratio(self):
        return 1.0 / (2.0 + GOLDEN)


@frozen
class CantorDust(Flake):
    """Eight blocks in the corners of one, and so on: in each direction, a line without its middle."""

    count = 8

    half_size: tuple[float, float, float] = number((0.5, 0.5, 0.5), "Half of the size along x, y and z")
    ratio: float = number(
        0.4,
        ("Size of the copies, as a fraction of the whole"),
        unit="NONE",
        minimum=0.05,
        maximum=0.49,
        soft_maximum=0.49,
    )
    levels: float = levels(3.0)

    _folded = staticmethod(abs)

    def _solid(self):
        return Box(self.half_size)

    def _corner(self):
        return self.half_size

    def _ratio(self):
        return self.ratio


# -- holes ------------------------------------------------------------------------------------------------------------


@frozen
class MengerSponge(Primitive):
    """A cube with a square hole from each face to the opposite one, each of its 20 parts with such holes, and so on."""

    exactness = BOUND
    op = Op.SPONGE

    half_size: float = number(0.5, "Half of the size along x, y and z")
    levels: float = levels(3.0, "How often holes are cut, each time a third as wide")

    def build(self, p: Vector, slot: Slots) -> Formula:
        half_size = slot(self.half_size)

        def cut(x, y, z, hole, field):
            # In a hole two coordinates, from the middle of the cell, are less than half of its width; then the median
            # is.
            _, median, _ = into_octahedral_chamber(Vector(x, y, z))
            folded = abs(abs(Vector(x, y, z) - hole) - hole)  # from the middle of the nearest of the cell's 27 parts
            return (*folded, hole * (1.0 / 3.0), maximum(field, hole - median)), None

        solid = Box((self.half_size,) * 3).build(p, slot)
        # From outside the cube, use the holes at the nearest point of it.
        first = (*abs(p).minimum(half_size), half_size * (1.0 / 3.0), solid)
        *_, field = iterate(slot(self.levels), first, cut, MOST_LEVELS)
        return field

    def volume(self) -> float:
        return (2.0 * self.half_size) ** 3 * (20.0 / 27.0) ** self.levels

    def support(self, directions):
        return self.half_size * np.abs(directions).sum(axis=1)


# -- Koch -------------------------------------------------------------------------------------------------------------

_SIXTY = (0.5, 0.5 * math.sqrt(3.0))  # cosine and sine of 60 degrees


def _folded_at_sixty(u: Formula, v: Formula) -> tuple[Formula, Formula]:
    """(u, v), or its mirror image if it is left of the line through the origin at 60 degrees to u."""
    cosine, sine = _SIXTY
    left = maximum(v * cosine - u * sine, 0.0) * 2.0
    return u + left * sine, v - left * cosine


@frozen
class KochCurve(Profile):
    """The inside of Koch's curve: a triangle with a smaller one on the middle of each side, and so on.

    One of the corners is in the direction of y.
    """

    radius: float = number(0.6, "Distance from the centre to the corners of the largest triangle")
    levels: float = levels(4.0, "How often triangles are put on the sides, each time a third as large")

    def build(self, p: Vector, slot: Slots) -> Formula:
        half_side = slot(self.radius * _SIXTY[1])
        # From the middle of the nearest side of the triangle: along it, and out of it.
        out, along = _folded_at_sixty(-p.y, abs(p.x))

        def step(u, v):
            # Of the four parts of the side, the two beyond its middle are mirror images.
            u, v = _folded_at_sixty(u - half_side * (1.0 / 3.0), v)
            return (abs(u * 3.0 - half_side), v * 3.0), None

        u, v = iterate(slot(self.levels), (abs(along), out - slot(0.5 * self.radius)), step, MOST_LEVELS)
        distance = length(maximum(u - half_side, 0.0), v) * slot(3.0**-self.levels)
        return select(v < 0.0, -distance, distance)

    def area(self) -> float:
        triangle = 0.75 * math.sqrt(3.0) * self.radius**2
        return triangle * (1.6 - 0.6 * (4.0 / 9.0) ** self.levels)

    def support(self, directions):
        angles = math.pi / 2.0 + math.tau / 6.0 * np.arange(0, 6, 1 if self.levels else 2)
        return (directions @ (self.radius * np.array([np.cos(angles), np.sin(angles)]))).max(axis=1)


@frozen
class KochSnowflake(Prismatic):
    """A snowflake with thickness: a triangle with a smaller one on the middle of each side, and so on."""

    radius: float = number(0.6, "Distance from the axis to the corners of the largest triangle")
    levels: float = levels(4.0, "How often triangles are put on the sides, each time a third as large")
    height: float = number(0.2, "Length along z")

    def _profile(self):
        return KochCurve(self.radius, self.levels)


# -- kaleidoscope -----------------------------------------------------------------------------------------------------


def _turned(angles: tuple[float, float, float]) -> np.ndarray:
    """Rotation matrix (3, 3) about x, then y, then z, by angles in radians."""
    matrix = np.eye(3)
    for axis, angle in enumerate(angles):
        turn = np.eye(3)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        turn[np.ix_((u, v), (u, v))] = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))
        matrix = turn @ matrix
    return matrix


def _angles(default: tuple[float, float, float], description: str):
    return number(default, description, unit="ANGLE", minimum=-math.tau, maximum=math.tau, soft_maximum=math.pi)


@frozen
class Kifs(Shape):
    """A kaleidoscope of blocks: mirrors, rotations and a scaling, repeated.

    In each round, space is rotated, folded by the nine mirrors of a cube, rotated again, and scaled about a point.
    Known as kaleidoscopic iterated function systems (Knighty, fractalforums.com, 2010).
    """

    exactness = BOUND

    half_size: float = number(0.5, "Half of the size of the repeated block, before it is scaled")
    levels: float = levels(6.0, "Number of rounds")
    scale: float = number(2.0, "Scale of each round", unit="NONE", minimum=1.05, maximum=10.0, soft_maximum=4.0)
    center: tuple[float, float, float] = number(
        (0.0, 0.25, 0.5), "Centre of the scaling in each round", minimum=-LARGEST
    )
    fold_angles: tuple[float, float, float] = _angles(
        (0.0, 0.0, 0.0), "Rotation about x, y and z before the mirrors of each round"
    )
    angles: tuple[float, float, float] = _angles(
        (0.3, 0.2, 0.0), "Rotation about x, y and z after the mirrors of each round"
    )

    def build(self, p: Vector, slot: Slots) -> Formula:
        before, after = (
            [slot(tuple(row)) for row in _turned(angles).tolist()] for angles in (self.fold_angles, self.angles)
        )
        scale, shift = slot(self.scale), slot(tuple((self.scale - 1.0) * c for c in self.center))

        def step(q: Vector) -> Vector:
            q = into_octahedral_chamber(Vector(*(row.dot(q) for row in before)))
            return Vector(*(row.dot(q) for row in after)) * scale - shift

        block = Box((self.half_size,) * 3).build(_led(p, slot(self.levels), step), slot)
        return maximum(block * slot(self.scale**-self.levels), p.length() - slot(self._radius()))

    def _radius(self) -> float:
        """Radius of a ball around the origin that contains the shape."""
        # Points farther out than the scaling's centre move even farther away in a round.
        block, center = math.sqrt(3.0) * self.half_size, math.hypot(*self.center)
        return center + (block - center) * self.scale**-self.levels

    def bounds(self, matrix=None):
        return support.bounds(lambda directions: support.of_ball(directions, self._radius()), matrix)
