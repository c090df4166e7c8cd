# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Profiles: regions of the plane, from which ``swept`` makes solids. Each is given by its signed distance.

A profile is documented and validated like a shape. Expressions use its ``name()``; ``PROFILES`` lists all. Its plane is
that of x and y; z is ignored. Here are those with round edges; ``polygons`` has the others.

The distances follow from geometry, after folding by symmetry. Inigo Quilez, "2D distance functions", collects many of
the same regions.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, length, maximum, minimum, select
from .. import program
from ..program import Op, combine, primitive
from .base import BOUND, EXACT, Parametric, Slots, number
from .clipping import placed
from .primitives import corner

PROFILES: dict[str, type["Profile"]] = {}
"""Every profile by its name in expressions, in order of definition."""


class Profile(Parametric):
    """A region of the plane. ``exactness`` and ``lipschitz`` of its field are defined as for a shape."""

    exactness = EXACT
    lipschitz = 1.0
    mirrored = True  # whether it is symmetric in x
    size = 1  # its cost, in primitives

    def __init_subclass__(cls, abstract: bool = False, **options):
        """Register the class in ``PROFILES``, unless it is abstract."""
        super().__init_subclass__(**options)
        if not abstract:
            PROFILES[cls.name()] = cls

    def support(self, directions: np.ndarray) -> np.ndarray:
        """Greatest d · x of the points x of the profile, (n,), for directions d (n, 2) of any length."""
        raise NotImplementedError

    def area(self) -> float | None:
        """Area in square metres, or None if no closed form is known."""
        return None

    def moment(self, offset: float) -> float | None:
        """Integral of x + offset over the part right of x = −offset, or None if no closed form is known.

        Times 2π, this is the volume of the solid of revolution about that line (Pappus).
        """
        area = self.area()
        return area * offset if area is not None and self.mirrored and self.least_x() >= -offset else None

    def extruded_program(self, matrix: np.ndarray | None, height: float) -> np.ndarray:
        """Closed-form program of the solid with this profile across z, within height/2 of the plane.

        ``matrix`` (4 × 4) transforms the solid. Raises ``program.NoClosedForm`` if there is none.
        """
        raise program.NoClosedForm(f"An extruded {self.label().lower()} has no closed form for its ray intervals.")

    def revolved_program(self, matrix: np.ndarray | None, offset: float) -> np.ndarray:
        """As ``extruded_program``, for the solid of revolution: x + offset is the distance from the axis, y is z.
        Raises ``program.NoClosedForm`` if there is none."""
        raise program.NoClosedForm(f"A revolved {self.label().lower()} has no closed form for its ray intervals.")

    def least_x(self) -> float:
        """Least x coordinate of the profile."""
        return -float(self.support(np.array([(-1.0, 0.0)]))[0])

    def beside_axis(self, offset: float) -> bool:
        """Whether no part of the profile is beyond the line x = −offset, or only a mirror image is."""
        return self.least_x() >= -offset or (self.mirrored and offset == 0.0)


def _norm(directions: np.ndarray) -> np.ndarray:
    return np.linalg.norm(directions, axis=1)


def _cylinder(matrix: np.ndarray | None, x: float, y: float, radius: float, height: float) -> np.ndarray:
    return primitive(Op.CYLINDER, placed(matrix, x, y), (radius, height))


def _torus(matrix: np.ndarray | None, offset: float, radius: float) -> np.ndarray:
    """Program of a disk of this radius, revolved: a ball if ``offset`` is 0, else ``offset`` is at least the radius."""
    if offset == 0.0:
        return primitive(Op.SPHERE, placed(matrix), (radius,))
    if offset < radius:
        raise program.NoClosedForm("A torus that overlaps itself has no closed form for its ray intervals.")
    return primitive(Op.TORUS, placed(matrix), (offset, radius))


@frozen
class Circle(Profile):
    """A disk."""

    radius: float = number(0.5, "Distance from the centre to the edge")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return length(p.x, p.y) - slot(self.radius)

    def support(self, directions):
        return self.radius * _norm(directions)

    def area(self) -> float:
        return math.pi * self.radius**2

    def moment(self, offset):
        if offset >= self.radius:
            return self.area() * offset
        half_chord = math.sqrt(self.radius**2 - offset**2)
        right = self.radius**2 * (math.pi - math.acos(offset / self.radius)) + offset * half_chord
        return right * offset + 2.0 / 3.0 * half_chord**3

    def extruded_program(self, matrix, height):
        return _cylinder(matrix, 0.0, 0.0, self.radius, height)

    def revolved_program(self, matrix, offset):
        return _torus(matrix, offset, self.radius)


@frozen
class Ring(Profile):
    """The region between two circles around the origin."""

    radius: float = number(0.4, "Distance from the centre to the middle of the band")
    thickness: float = number(0.1, "Width of the band")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return abs(length(p.x, p.y) - slot(self.radius)) - slot(0.5 * self.thickness)

    def relation(self) -> str:
        if self.thickness >= 2.0 * self.radius:
            return (
                f"Ring: thickness {self.thickness:g} is at least twice the radius {self.radius:g}, so there is no "
                "hole: make the thickness smaller, or use a circle."
            )
        return ""

    def _circles(self) -> tuple[Circle, Circle]:
        return Circle(self.radius + 0.5 * self.thickness), Circle(self.radius - 0.5 * self.thickness)

    def support(self, directions):
        return self._circles()[0].support(directions)

    def area(self) -> float:
        return 2.0 * math.pi * self.radius * self.thickness

    def moment(self, offset):
        outer, inner = self._circles()
        return outer.moment(offset) - inner.moment(offset)

    def extruded_program(self, matrix, height):
        outer, inner = self._circles()
        # The hole is longer than the solid, so no two faces coincide.
        return combine(
            Op.DIFFERENCE, [outer.extruded_program(matrix, height), inner.extruded_program(matrix, 2.0 * height)]
        )

    def revolved_program(self, matrix, offset):
        outer, inner = self._circles()
        return combine(Op.DIFFERENCE, [outer.revolved_program(matrix, offset), inner.revolved_program(matrix, offset)])


@frozen
class Ellipse(Profile):
    """A disk scaled along x and y.

    The field is that of the unit circle in the scaled plane, times the lesser radius, which never exceeds the distance.
    """

    exactness = BOUND

    radius_x: float = number(0.5, "Half of the size along x", label="Radius X")
    radius_y: float = number(0.3, "Half of the size along y", label="Radius Y")

    def build(self, p: Vector, slot: Slots) -> Formula:
        x, y = slot(self.radius_x), slot(self.radius_y)
        return (length(p.x / x, p.y / y) - 1.0) * minimum(x, y)

    def support(self, directions):
        return _norm(directions * (self.radius_x, self.radius_y))

    def area(self) -> float:
        return math.pi * self.radius_x * self.radius_y

    def moment(self, offset):
        # The plane scaled back to the unit circle: x + offset and the area are multiplied by the radii.
        return Circle(1.0).moment(offset / self.radius_x) * self.radius_x**2 * self.radius_y

    def extruded_program(self, matrix, height):
        stretch = np.diag([self.radius_x, self.radius_y, 1.0, 1.0])
        return Circle(1.0).extruded_program(placed(matrix) @ stretch, height)

    def revolved_program(self, matrix, offset):
        stretch = np.diag([self.radius_x, self.radius_x, self.radius_y, 1.0])
        return Circle(1.0).revolved_program(placed(matrix) @ stretch, offset / self.radius_x)


@frozen
class Almond(Profile):
    """The intersection of two equal disks: pointed at both ends of y.

    Also known as vesica piscis.
    """

    half_width: float = number(0.25, "Half of the size along x")
    half_height: float = number(0.5, "Distance from the centre to the points, along y")

    def arc(self) -> tuple[float, float]:
        """Radius of the disks, and the distance of their centres from the origin."""
        radius = 0.5 * (self.half_width + self.half_height**2 / self.half_width)
        return radius, radius - self.half_width

    def build(self, p: Vector, slot: Slots) -> Formula:
        radius, away = (slot(value) for value in self.arc())
        tip = slot(self.half_height)
        x, y = abs(p.x), abs(p.y)
        # The tip is nearest to the points beyond the line from the farther centre through it.
        return select((y - tip) * away > x * tip, length(x, y - tip), length(x + away, y) - radius)

    def relation(self) -> str:
        if self.half_width > self.half_height:
            return (
                f"Almond: half width {self.half_width:g} is more than the half height {self.half_height:g}: make "
                "it smaller, or exchange the two and turn the profile."
            )
        return ""

    def support(self, directions):
        radius, away = self.arc()
        across, along = np.abs(directions).T
        # Normals of the arc turn from x to the direction of the tip as seen from the centre.
        on_arc = along * away <= across * self.half_height
        return np.where(on_arc, radius * _norm(directions) - away * across, self.half_height * along)

    def moment(self, offset):
        if offset > 0.0:
            return super().moment(offset)
        radius, _ = self.arc()
        angle = 2.0 * math.atan2(self.half_width, self.half_height)  # half of the arc's
        if angle > 0.02:
            return radius**3 * (math.sin(angle) - math.sin(angle) ** 3 / 3.0 - angle * math.cos(angle))
        return radius**3 * angle**5 * (2.0 / 15.0 - 11.0 / 315.0 * angle**2)  # the same without cancellation

    def area(self) -> float:
        radius, away = self.arc()
        return 2.0 * (radius**2 * math.atan2(self.half_height, away) - away * self.half_height)

    def extruded_program(self, matrix, height):
        radius, away = self.arc()
        return combine(Op.INTERSECTION, [_cylinder(matrix, x, 0.0, radius, height) for x in (-away, away)])


@frozen
class Moon(Profile):
    """A disk minus another disk: a crescent.

    The other disk is moved along x.
    """

    mirrored = False

    radius: float = number(0.5, "Radius of the disk")
    bite_radius: float = number(0.4, "Radius of the disk that is taken away")
    offset: float = number(0.25, "Distance between the centres of the disks", soft_maximum=2.0)

    def tip(self) -> tuple[float, float]:
        """Where the two circles meet, y > 0."""
        x = 0.5 * (self.offset + (self.radius - self.bite_radius) * (self.radius + self.bite_radius) / self.offset)
        return x, math.sqrt(max((self.radius - x) * (self.radius + x), 0.0))

    def build(self, p: Vector, slot: Slots) -> Formula:
        tip_x, tip_y = (slot(value) for value in self.tip())
        radius, bite, offset = slot(self.radius), slot(self.bite_radius), slot(self.offset)
        x, y = p.x, abs(p.y)
        # Beyond the tip: away from the line from the first centre through it, and of that from the second.
        beyond_tip = minimum(x * tip_y - y * tip_x, x * tip_y - y * tip_x - offset * (tip_y - y))
        region = maximum(length(x, y) - radius, bite - length(x - offset, y))
        return select(beyond_tip > 0.0, length(x - tip_x, y - tip_y), region)

    def relation(self) -> str:
        if not abs(self.radius - self.bite_radius) < self.offset < self.radius + self.bite_radius:
            return (
                f"Moon: at an offset of {self.offset:g} the circles do not cross: make it more than "
                f"{abs(self.radius - self.bite_radius):g} and less than {self.radius + self.bite_radius:g}."
            )
        return ""

    def support(self, directions):
        tip_x, tip_y = self.tip()
        across, along = directions[:, 0], np.abs(directions[:, 1])
        between_tips = across * tip_y > along * tip_x
        return np.where(between_tips, across * tip_x + along * tip_y, self.radius * _norm(directions))

    def _segment(self, radius: float, chord: float) -> tuple[float, float]:
        """Area, and its first moment about the centre, of the part of a disk beyond a chord at the given distance."""
        half_chord = math.sqrt(max((radius - chord) * (radius + chord), 0.0))
        return radius**2 * math.atan2(half_chord, chord) - chord * half_chord, 2.0 / 3.0 * half_chord**3

    def _covered(self) -> tuple[float, float]:
        """Area that the other disk covers, and its first moment about the y axis."""
        chord, _ = self.tip()
        near, near_moment = self._segment(self.radius, chord)
        far, far_moment = self._segment(self.bite_radius, self.offset - chord)
        return near + far, near_moment + far * self.offset - far_moment

    def area(self) -> float:
        return math.pi * self.radius**2 - self._covered()[0]

    def moment(self, offset):
        return self.area() * offset - self._covered()[1] if self.least_x() >= -offset else None

    def extruded_program(self, matrix, height):
        return combine(
            Op.DIFFERENCE,
            [
                _cylinder(matrix, 0.0, 0.0, self.radius, height),
                _cylinder(matrix, self.offset, 0.0, self.bite_radius, 2.0 * height),
            ],
        )


@frozen
class HeartOutline(Profile):
    """A heart: a square on its corner, with half a disk on each of its upper sides."""

    width: float = number(0.8, "Size along x")

    def _square(self) -> tuple[float, float, float]:
        """Side of the square; horizontal distance of the middles of its upper sides; vertical distance from them down
        to its corner.

        The corner is at the same distance below the origin as the top is above it.
        """
        side = self.width / (1.0 + math.sqrt(0.5))
        return side, side * math.sqrt(0.125), side * math.sqrt(1.125)

    def _bottom(self) -> float:
        side, _, below = self._square()
        return -0.5 * (below + 0.5 * side)

    def build(self, p: Vector, slot: Slots) -> Formula:
        side, root = slot(self._square()[0]), math.sqrt(0.5)
        # Along the lower right side of the square from the corner, and away from it, into the square.
        x, y = abs(p.x) * root, (p.y - slot(self._bottom())) * root
        along, away = y + x, y - x
        half = side * 0.5
        lobe = length(along - side, away - half) - half
        before = minimum(along, 0.0)
        to_side, to_cleft = length(before, away), length(along - side, away - side)
        distance = minimum(to_side, to_cleft)
        return select(along > side, lobe, select(away > 0.0, -distance, distance))

    def support(self, directions):
        side, aside, below = self._square()
        across, up = np.abs(directions[:, 0]), directions[:, 1]
        lobe = across * aside + up * (self._bottom() + below) + 0.5 * side * _norm(directions)
        return np.maximum(lobe, up * self._bottom())

    def area(self) -> float:
        side = self._square()[0]
        return side**2 * (1.0 + 0.25 * math.pi)

    def extruded_program(self, matrix, height):
        side, aside, below = self._square()
        turned = np.eye(4)
        turned[:2, :2] = math.sqrt(0.5) * np.array([(1.0, -1.0), (1.0, 1.0)])
        square = placed(matrix, y=self._bottom() + side * math.sqrt(0.5)) @ turned
        lobes = [_cylinder(matrix, x, self._bottom() + below, 0.5 * side, height) for x in (-aside, aside)]
        return combine(Op.UNION, [primitive(Op.BOX, square, (0.5 * side, 0.5 * side, 0.5 * height)), *lobes])


@frozen
class RoundedRectangle(Profile):
    """A rectangle with round corners."""

    width: float = number(0.8, "Size along x")
    height: float = number(0.5, "Size along y")
    rounding: float = number(0.1, "Radius of the corners", minimum=0.0)

    def _core(self) -> np.ndarray:
        """Half of the size of the rectangle between the centres of the corners."""
        return 0.5 * np.array([self.width, self.height]) - self.rounding

    def build(self, p: Vector, slot: Slots) -> Formula:
        x, y = self._core().tolist()
        return corner((abs(p.x) - slot(x), abs(p.y) - slot(y))) - slot(self.rounding)

    def relation(self) -> str:
        if 2.0 * self.rounding > min(self.width, self.height):
            return (
                f"Rounded Rectangle: rounding {self.rounding:g} is more than half of the lesser side, "
                f"{min(self.width, self.height):g}: make the rounding smaller."
            )
        return ""

    def support(self, directions):
        return np.abs(directions) @ self._core() + self.rounding * _norm(directions)

    def area(self) -> float:
        return self.width * self.height - (4.0 - math.pi) * self.rounding**2

    def extruded_program(self, matrix, height):
        x, y = self._core().tolist()
        half = 0.5 * height
        parts = [
            primitive(Op.BOX, placed(matrix), size)
            for size, there in (((x + self.rounding, y, half), y > 0.0), ((x, y + self.rounding, half), x > 0.0))
            if there
        ]
        if self.rounding > 0.0:
            ends = dict.fromkeys([(x, y), (x, -y), (-x, y), (-x, -y)])
            parts += [_cylinder(matrix, *end, self.rounding, height) for end in ends]
        return combine(Op.UNION, parts)
