# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids swept from a profile: along z, or around it."""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, length, maximum, minimum, select
from ..program import NoClosedForm, Op, combine
from . import support
from .base import BOUND, Shape, ShapeError, Slots, number, part
from .clipping import sector
from .polygons import Plus, Star
from .primitives import Primitive, corner
from .profiles import HeartOutline, Moon, Profile
from .sectors import MOST_SECTORS


class Swept(Shape, abstract=True):
    """A solid from the field of a profile."""

    profile: Profile

    def __post_init__(self):
        if not isinstance(self.profile, Profile):
            raise ShapeError(f"{self.label()} sweeps a profile, not {self.profile!r:.40}.")
        super().__post_init__()

    @property
    def lipschitz(self) -> float:
        return max(1.0, self.profile.lipschitz)

    @property
    def size(self) -> int:
        return self.profile.size

    def support(self, directions: np.ndarray) -> np.ndarray:
        """Greatest d · x of the points x of the shape, (n,), for directions d (n, 3) of any length; or slightly
        more."""
        raise NotImplementedError

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        return support.bounds(self.support, matrix)

    def check(self) -> str:
        return self.profile.check() or super().check()


@frozen
class Extrusion(Swept):
    """A profile with thickness: a bar along z, centred.

    The distance is exact if that of the profile is and the ends have no rounding.
    """

    profile: Profile = part("Cross-section of the bar", "profile")
    height: float = number(0.3, "Length along z")
    rounding: float = number(0.0, "Radius of the edges around both ends", minimum=0.0, soft_maximum=1.0)

    @property
    def exactness(self) -> str:
        # Where the profile is concave, rounded edges meet in a crease, which the field does not know.
        return self.profile.exactness if self.rounding == 0.0 else BOUND

    def build(self, p: Vector, slot: Slots) -> Formula:
        rounding = slot(self.rounding)
        side, end = self.profile.build(p, slot), abs(p.z) - slot(0.5 * self.height)
        return corner((side + rounding, end + rounding)) - rounding

    def relation(self) -> str:
        if self.rounding > 0.5 * self.height:
            return (
                f"Extrusion: rounding {self.rounding:g} is more than half of the height {self.height:g}: make the "
                "rounding smaller."
            )
        return ""

    def volume(self) -> float | None:
        area = self.profile.area()
        return None if area is None or self.rounding > 0.0 else area * self.height

    def support(self, directions):
        return self.profile.support(directions[:, :2]) + support.of_segment(directions, 0.5 * self.height)

    def program(self, matrix=None):
        if self.rounding > 0.0:
            raise NoClosedForm("An extrusion with rounded edges has no closed form for its ray intervals.")
        return self.profile.extruded_program(matrix, self.height)


def _beyond_axis(shape: "Revolution | PartialRevolution") -> str:
    farthest = shape.offset + float(shape.profile.support(np.array([(1.0, 0.0)]))[0])
    if farthest <= 0.0:
        return f"{shape.label()}: the whole profile is beyond the axis: make the offset more than {-farthest:g} larger."
    return ""


@frozen
class Revolution(Swept):
    """A profile revolved about the z axis, all the way round.

    The profile's y is the solid's z, and its x is the distance from the axis minus the offset. The part beyond the axis
    is left out. The distance is exact if that of the profile is, and if the part left out is only a mirror image of the
    rest.
    """

    profile: Profile = part("Section of the solid by a half plane through the axis", "profile")
    offset: float = number(0.0, "Distance from the axis to the origin of the profile", minimum=0.0)

    @property
    def exactness(self) -> str:
        return self.profile.exactness if self.profile.beside_axis(self.offset) else BOUND

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self.profile.build(Vector(length(p.x, p.y) - slot(self.offset), p.z, p.z), slot)

    def relation(self) -> str:
        return _beyond_axis(self)

    def volume(self) -> float | None:
        moment = self.profile.moment(self.offset)
        return None if moment is None else math.tau * moment

    def support(self, directions):
        across, along = np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2]
        return self.profile.support(np.stack([across, along], axis=1)) + self.offset * across

    def program(self, matrix=None):
        return self.profile.revolved_program(matrix, self.offset)


@frozen
class PartialRevolution(Swept):
    """A profile revolved about the z axis, but not all the way round.

    As ``revolution``; the solid is symmetrical about the positive x axis.
    """

    profile: Profile = part("Section of the solid by a half plane through the axis", "profile")
    offset: float = number(0.0, "Distance from the axis to the origin of the profile", minimum=0.0)
    angle: float = number(
        math.pi,
        "Angle of the revolution",
        unit="ANGLE",
        minimum=0.001,
        maximum=2.0 * math.pi - 0.001,
        soft_maximum=2.0 * math.pi - 0.001,
    )

    @property
    def exactness(self) -> str:
        return self.profile.exactness if self.profile.least_x() >= -self.offset else BOUND

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = slot(math.sin(0.5 * self.angle)), slot(math.cos(0.5 * self.angle))
        offset, aside = slot(self.offset), abs(p.y)
        around = self.profile.build(Vector(length(p.x, p.y) - offset, p.z, p.z), slot)
        # The nearer end is the profile in the half plane at angle/2.
        outwards, past = p.x * cosine + aside * sine, aside * cosine - p.x * sine
        end = maximum(self.profile.build(Vector(outwards - offset, p.z, p.z), slot), -outwards)
        to_end = length(maximum(end, 0.0), past)
        return select(past > 0.0, to_end, select(around > 0.0, around, -minimum(-around, to_end)))

    def relation(self) -> str:
        return _beyond_axis(self)

    def volume(self) -> float | None:
        moment = self.profile.moment(self.offset)
        return None if moment is None else self.angle * moment

    def support(self, directions):
        x, aside, along = directions[:, 0], np.abs(directions[:, 1]), directions[:, 2]
        sine, cosine = math.sin(0.5 * self.angle), math.cos(0.5 * self.angle)
        # The half plane of the solid that is nearest to the direction: its own, or that of the nearer end.
        within = aside * cosine <= x * sine
        across = np.where(within, np.hypot(x, aside), x * cosine + aside * sine)
        return self.profile.support(np.stack([across, along], axis=1)) + self.offset * across

    def program(self, matrix=None):
        around = self.profile.revolved_program(matrix, self.offset)
        return combine(Op.INTERSECTION, [around, sector(matrix, self.angle)])


# -- extrusions that numbers alone make -------------------------------------------------------------------------------


class Prismatic(Primitive, abstract=True):
    """An extruded profile."""

    def _profile(self) -> Profile:
        raise NotImplementedError

    def _extrusion(self) -> Extrusion:
        return Extrusion(self._profile(), self.height)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._extrusion().build(p, slot)

    def relation(self) -> str:
        return self._profile().relation().replace(self._profile().label(), self.label(), 1)

    def volume(self) -> float:
        return self._extrusion().volume()

    def support(self, directions):
        return self._extrusion().support(directions)

    def program(self, matrix=None):
        return self._extrusion().program(matrix)


@frozen
class StarPrism(Prismatic):
    """A star with thickness. One of its points is in the direction of y."""

    points: float = number(
        5.0, "Number of points", unit="NONE", minimum=3.0, maximum=MOST_SECTORS, soft_maximum=12.0, whole=True
    )
    radius: float = number(0.6, "Distance from the axis to the points")
    inner_radius: float = number(0.25, "Distance from the axis to the corners between two points")
    height: float = number(0.3, "Length along z")

    def _profile(self):
        return Star(self.points, self.radius, self.inner_radius)


@frozen
class PlusPrism(Prismatic):
    """Two equal bars that cross at right angles, with thickness."""

    half_length: float = number(0.5, "Distance from the axis to the ends of the bars, which are along x and y")
    half_width: float = number(0.15, "Half of the width of the bars")
    height: float = number(0.3, "Length along z")

    def _profile(self):
        return Plus(self.half_length, self.half_width)


@frozen
class Crescent(Prismatic):
    """A crescent moon with thickness: a disk minus another disk."""

    radius: float = number(0.5, "Radius of the disk")
    bite_radius: float = number(0.4, "Radius of the disk that is taken away")
    offset: float = number(0.25, "Distance between the axes of the disks, along x", soft_maximum=2.0)
    height: float = number(0.2, "Length along z")

    def _profile(self):
        return Moon(self.radius, self.bite_radius, self.offset)


@frozen
class HeartPrism(Prismatic):
    """A heart with thickness: a square on its corner, with half a disk on each of its upper sides. Its top is at +y."""

    width: float = number(0.8, "Size along x")
    height: float = number(0.3, "Length along z")

    def _profile(self):
        return HeartOutline(self.width)
