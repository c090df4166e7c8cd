# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires and bands that wind around the z axis: coils, knots, twisted rings.

The nearest point of such a curve has no closed form. But the half plane through the axis and a given point cuts the
curve in a few known points, and the field is defined in that half plane. It is a bound of the distance. Its slope has
two parts: that within the half plane, and, perpendicular to it, the motion of the cut points as the half plane turns,
divided by the distance ρ from the axis. Each class derives the greatest slope, and divides by it.

A wire that crosses the half plane at a slant is cut in an ellipse. To make it round, offsets from the cut point (d, in
the half plane) are measured without their part along the wire, of direction τ: |d|² − (d · τ)².
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, atan2, clamp, cos, floor, length, maximum, minimum, select, sin, sqrt
from .base import BOUND, Slots, number
from .primitives import Primitive, corner

_SAMPLES = 400  # points of a curve per turn, for its box
_RIM = 48  # points around a wire, for its box
_STEEPEST = 0.99  # sine of the slope of a wire


def _of_sections(directions: np.ndarray, angles: np.ndarray, center: tuple, *axes: tuple) -> np.ndarray:
    """Support of all sections of a solid by half planes through the z axis, from some of them.

    The sections at the ``angles`` (m,) are ellipses with this center and these two semi-axes, or points without axes.
    For each, the part away from the axis and the part along z are given, (…, m) or numbers, for any number of ellipses
    per section.
    """

    def turned(vector):
        away, up = np.broadcast_arrays(*vector, angles)[:2]
        return np.stack([away * np.cos(angles), away * np.sin(angles), up])

    center, *axes = map(turned, (center, *axes))
    reached = np.tensordot(directions, center, 1)
    if axes:
        reached += np.sqrt(sum(np.tensordot(directions, axis, 1) ** 2 for axis in axes))
    # Every other section is at most half of a step away from one of these, along an arc that is not quite straight.
    between = 0.501 * sum(np.sqrt((np.diff(vector) ** 2).sum(axis=0).max(axis=-1)) for vector in (center, *axes))
    reached = reached.max(axis=-1) + np.multiply.outer(np.linalg.norm(directions, axis=1), between)
    return reached.reshape(len(directions), -1).max(axis=1)


class _Coil(Primitive, abstract=True):
    """A wire along a curve whose distance from the axis and height grow linearly with the angle.

    Let s be the growth of both together per radian, and R the mean distance from the axis. The wire's direction has the
    part ν = s/N along this growth and μ = R/N around the axis, N = √(R² + s²). Offsets along the growth are scaled by
    √(1 − ν²) = μ relative to those across: see the module. In the half plane that gives the slope 1. With its turning,
    the slope is √(x² + μ² y² (1 + s²/ρ²)) for a unit vector (x, y), at most max(1, μ √(1 + s²/ρ²)). Nearer to the axis
    than half of the way to the wire the field is held constant, so this ρ decides.

    Beyond an end, offsets d from it are measured as √(|d|² − (d·τ)² + (d·e)²), with τ the wire's direction and e that
    around the axis. In the end's half plane, where d·e = 0, this equals the value for the wire, so the field is
    continuous. The end, an ellipsoid, does not bulge. The eigenvalues under the root are 1 − ν, 1 and 1 + ν, so its
    slope is at most √(1 + ν).
    """

    exactness = BOUND

    turns: float
    minor_radius: float

    def _ends(self) -> tuple[float, float, float]:
        """Distance from the axis at the lower and the upper end, and height."""
        raise NotImplementedError

    def _mean(self) -> float:
        first, last, _ = self._ends()
        return 0.5 * (first + last)

    def _growth(self) -> tuple[float, float, float]:
        """Growth of the distance from the axis and of the height per radian, and s."""
        first, last, height = self._ends()
        away, up = (last - first) / (math.tau * self.turns), height / (math.tau * self.turns)
        return away, up, math.hypot(away, up)

    def _direction(self) -> tuple[float, float]:
        """μ and ν."""
        size = self._growth()[2]
        whole = math.hypot(self._mean(), size)
        return self._mean() / whole, size / whole

    def _section(self, stretch: float) -> np.ndarray:
        """Two vectors (away from the axis, up): across the growth, as long as the wire is thick, and along it."""
        away, up, size = self._growth()
        return self.minor_radius / size * np.array([(-up, away), (away * stretch, up * stretch)])

    def _cut(self) -> np.ndarray:
        """Semi-axes of the wire's cut."""
        return self._section(1.0 / self._direction()[0])

    def _end_reach(self) -> np.ndarray:
        """How far an end reaches beyond its centre: away from the axis, and up."""
        mu, nu = self._direction()
        return np.hypot(*self._section(math.sqrt(1.0 + nu * nu) / mu))

    def build(self, p: Vector, slot: Slots) -> Formula:
        first, last, height = self._ends()
        away, up, size = self._growth()
        mu, nu = self._direction()
        radius, reach, cut = self.minor_radius, self._end_reach(), np.hypot(*self._cut())[0]
        inner, outer = min(first, last), max(first, last)
        unit_away, unit_up, turn = slot(away / size), slot(up / size), slot(math.tau * size)
        mu_, nu_, half_turns = slot(mu), slot(nu), slot(math.pi * self.turns)

        rho, angle = length(p.x, p.y), atan2(p.y, p.x)
        # In the half plane, from the wire at this angle: along its growth, and across.
        out, above = rho - (slot(self._mean()) + angle * slot(away)), p.z - angle * slot(up)
        along, aside = out * unit_away + above * unit_up, above * unit_away - out * unit_up
        lowest = -floor((half_turns + angle) * (1.0 / math.tau))
        highest = floor((half_turns - angle) * (1.0 / math.tau))
        along = along - clamp(floor(along / turn + 0.5), lowest, highest) * turn
        to_wire = length(aside, along * mu_)

        def to_end(side: float, distance: float) -> Formula:
            end = math.pi * self.turns
            cosine, sine = slot(math.cos(end)), slot(side * math.sin(end))
            x, y, z = p.x - cosine * slot(distance), p.y - sine * slot(distance), p.z - slot(0.5 * side * height)
            around = y * cosine - x * sine
            onwards = around * mu_ + ((x * cosine + y * sine) * unit_away + z * unit_up) * nu_
            return sqrt(maximum(x * x + y * y + z * z - onwards * onwards + around * around, 0.0))

        ends = minimum(to_end(-1.0, first), to_end(1.0, last))
        steep = 0.5 * (inner - cut)
        # The least to_wire at which the distance from the axis is ``steep``.
        most = radius / cut * (inner - steep)
        wire = minimum(select(lowest <= highest, to_wire, ends), ends, slot(most)) - slot(radius)
        slope = max(math.sqrt(1.0 + nu), mu * math.sqrt(1.0 + (size / steep) ** 2))
        return maximum(
            wire * slot(1.0 / slope),
            slot(inner - reach[0]) - rho,
            rho - slot(outer + radius / math.sqrt(1.0 - nu)),
            abs(p.z) - slot(0.5 * abs(height) + reach[1]),
        )

    def relation(self) -> str:
        first, last, _ = self._ends()
        if self._direction()[1] > _STEEPEST:
            return f"{self.label()}: the wire hardly turns around the axis: make it wider, or give it more turns."
        if self._end_reach()[0] >= min(first, last):
            return (
                f"{self.label()}: minor radius {self.minor_radius:g} is too much for a wire at a distance of "
                f"{min(first, last):g} from the axis: make it smaller."
            )
        return ""

    def volume(self) -> float | None:
        first, last, _ = self._ends()
        mu, _ = self._direction()
        # Not if it runs into the neighbouring turn, which comes nearer by its growth over the angle of the end.
        end = self._end_reach().max() / mu / min(first, last)
        if mu * self._growth()[2] * (math.tau - end) < 2.0 * self.minor_radius:
            return None
        section = math.pi * self.minor_radius**2 / mu
        # Pappus: the centre of the cut moves around the axis; and two halves of an ellipsoid.
        return section * (math.tau * self.turns * self._mean() + 4.0 / 3.0 * self.minor_radius)

    def support(self, directions):
        first, last, height = self._ends()
        mu, nu = self._direction()
        way = np.linspace(-1.0, 1.0, 2 + int(_SAMPLES * self.turns))
        center = self._mean() + 0.5 * (last - first) * way, 0.5 * height * way
        reached = [_of_sections(directions, math.pi * self.turns * way, center, *self._cut())]
        for side, distance in ((-1.0, first), (1.0, last)):
            cosine, sine = math.cos(math.pi * self.turns), side * math.sin(math.pi * self.turns)
            outwards = directions[:, 0] * cosine + directions[:, 1] * sine
            around = directions[:, 1] * cosine - directions[:, 0] * sine
            across, along = (outwards * d + directions[:, 2] * h for d, h in self._section(1.0))
            # The inverse of the matrix under the root.
            size = np.sqrt(across**2 + (self.minor_radius * around + nu / mu * along) ** 2 + (along / mu) ** 2)
            reached.append(outwards * distance + directions[:, 2] * 0.5 * side * height + size)
        return np.maximum.reduce(reached)


_TURNS = dict(unit="NONE", minimum=0.05, maximum=100.0, soft_maximum=10.0)


@frozen
class Helix(_Coil):
    """A wire wound around the z axis, centred: a coil spring. Its ends are round.

    The wire is round to first order: in a half plane through the axis it is an ellipse.
    """

    radius: float = number(0.35, "Distance from the axis to the middle of the wire")
    pitch: float = number(0.25, "Distance along z from one turn to the next")
    turns: float = number(3.0, "Number of turns; fractions are allowed", **_TURNS)
    minor_radius: float = number(0.06, "Radius of the wire")

    def _ends(self):
        return self.radius, self.radius, self.pitch * self.turns


@frozen
class Spiral(_Coil):
    """A wire wound around the z axis whose distance from the axis changes on its way up. It is flat for a height of 0.

    The wire is round to first order. Its ends are round.
    """

    bottom_radius: float = number(0.12, "Distance from the axis to the middle of the wire at its lower end")
    top_radius: float = number(0.5, "Distance from the axis to the middle of the wire at its upper end")
    height: float = number(0.4, "Distance along z between the ends", minimum=0.0)
    turns: float = number(3.0, "Number of turns; fractions are allowed", **_TURNS)
    minor_radius: float = number(0.045, "Radius of the wire")

    def _ends(self):
        return self.bottom_radius, self.top_radius, self.height

    def relation(self):
        if self._growth()[2] <= 1e-6 * self._mean():
            return "Spiral: its turns lie on one another: make the height larger, or one of the radii."
        return super().relation()


@frozen
class TorusKnot(Primitive):
    """A closed wire on a torus around the z axis: a knot, or a chain if the two numbers of turns have a common divisor.

    The wire is round to first order. With R, r and w the radii, a point in the half plane has the distance s from the
    middle of the torus and the angle δ around it from the nearest cut of the wire. For p turns around the axis and q
    around the tube, let k = q r / p. The wire's slant is k/ρ, so along the circle offsets are scaled by √λ, λ = 1 / (1
    + k²/ρ²), where ρ is at least R − r:

        g = √((s − r)² + λ m²),  m = min(s, r) δ

    For the unit vector (x, y) of the two parts, |∇g|² ≤ x² + y² where s ≥ r, because the change of m is at most 1 in
    the half plane and k/ρ perpendicular to it. Elsewhere it is at most (x + √λ δ y)² + y². Where g is less than a
    constant G < r, √λ δ ≤ η = G / √(r² − G²), so this is at most ((η + √(η² + 4)) / 2)². The change of λ adds at most g
    k² / (ρ (ρ² + k²)). Nearer to the axis than R − r the field is multiplied by ρ / (R − r). This compensates the 1/ρ
    and adds the field's size over R − r. g never exceeds G.
    """

    exactness = BOUND

    major_radius: float = number(0.4, "Distance from the axis to the middle of the torus")
    radius: float = number(
        0.15, "Distance from the middle of the torus to the middle of the wire", label="Torus Radius"
    )
    minor_radius: float = number(0.05, "Radius of the wire")
    around_axis: float = number(
        2.0, "Turns around the axis", unit="NONE", minimum=1.0, maximum=20.0, soft_maximum=7.0, whole=True
    )
    around_tube: float = number(
        3.0, "Turns around the tube of the torus", unit="NONE", minimum=0.0, maximum=20.0, soft_maximum=9.0, whole=True
    )

    def _slant(self) -> tuple[float, float]:
        """k, and the least √λ."""
        k = self.around_tube * self.radius / self.around_axis
        inner = self.major_radius - self.radius
        return k, inner / math.hypot(inner, k)

    def _steepness(self, most: float) -> float:
        """Bound of the slope of the field where g is at most G, ``most``."""
        k, _ = self._slant()
        inner, w = self.major_radius - self.radius, self.minor_radius
        shear = math.pi / self.around_axis
        if most < self.radius:
            shear = min(shear, most / math.sqrt((self.radius - most) * (self.radius + most)))
        return 0.5 * (shear + math.hypot(shear, 2.0)) + max(
            most * k**2 / (inner * (inner**2 + k**2)), max(w, most - w) / inner
        )

    def build(self, p: Vector, slot: Slots) -> Formula:
        r, w, inner = self.radius, self.minor_radius, self.major_radius - self.radius
        most = w + 0.3 * r
        rho, radius = length(p.x, p.y), slot(r)
        out = rho - slot(self.major_radius)
        from_middle = length(out, p.z)
        step = slot(math.tau / self.around_axis)
        angle = atan2(p.z, out) - atan2(p.y, p.x) * slot(self.around_tube / self.around_axis)
        angle = angle - floor(angle / step + 0.5) * step
        held = maximum(rho, slot(inner))
        along = minimum(from_middle, radius) * angle * held / length(held, slot(self._slant()[0]))
        wire = minimum(length(from_middle - radius, along), slot(most)) - slot(w)
        nearness = minimum(rho * slot(1.0 / inner), 1.0)
        return maximum(wire * nearness * slot(1.0 / self._steepness(most)), from_middle - slot(r + w))

    def relation(self) -> str:
        if self.radius + self.minor_radius >= self.major_radius:
            return (
                "Torus Knot: the wire reaches the axis: make the major radius larger, or the torus radius or the "
                "minor radius smaller."
            )
        return ""

    def support(self, directions):
        p, q, r, w = self.around_axis, self.around_tube, self.radius, self.minor_radius
        longest = min(w / (self._slant()[1] * r), math.pi / p)
        turn = np.linspace(0.0, math.tau, 1 + int(_SAMPLES * max(1.0, q / p)))
        strand = math.tau * np.arange(p)[:, None, None]
        # Points around the cut of the wire, and the greatest distance from one to half of the way to the next.
        rim = math.tau * np.arange(_RIM)[:, None] / _RIM
        between = math.pi / _RIM * math.hypot(w, (r + w) * longest)
        angle = (q * turn + strand) / p
        vectors = np.exp(1j * angle) * ((r + w * np.cos(rim)) * np.exp(1j * longest * np.sin(rim)))
        center = self.major_radius + vectors.real, vectors.imag
        return _of_sections(directions, turn, center) + between * np.linalg.norm(directions, axis=1)


@frozen
class MobiusBand(Primitive):
    """A band around the z axis that is twisted on its way. With one half turn, or any odd number, it has a single side.

    In the half plane through the axis it is a rectangle, and the field is the distance to the rectangle, up to a
    constant. Where the distance is less than the constant, the distance s from the middle of the rectangle is at most
    half of its diagonal plus the constant. When the half plane turns, the rectangle turns t/2 times as fast, for t half
    turns. The distance to it changes by at most s times the angle, so its slope is at most √(1 + (t s / 2ρ)²).
    """

    exactness = BOUND

    radius: float = number(0.4, "Distance from the axis to the middle of the band")
    width: float = number(0.3, "Width of the band")
    thickness: float = number(0.05, "Thickness of the band")
    half_turns: float = number(
        1.0,
        "Half turns of the twist; negative numbers twist the other way",
        unit="NONE",
        minimum=-12.0,
        maximum=12.0,
        soft_maximum=6.0,
        whole=True,
    )

    def _half_diagonal(self) -> float:
        return 0.5 * math.hypot(self.width, self.thickness)

    def build(self, p: Vector, slot: Slots) -> Formula:
        reach = self._half_diagonal()
        most = 0.25 * (self.radius - reach)
        slope = math.hypot(1.0, 0.5 * self.half_turns * (reach + most) / (self.radius - reach - most))
        out = length(p.x, p.y) - slot(self.radius)
        angle = atan2(p.y, p.x) * slot(0.5 * self.half_turns)
        cosine, sine = cos(angle), sin(angle)
        u, v = out * cosine + p.z * sine, p.z * cosine - out * sine
        band = corner((abs(u) - slot(0.5 * self.thickness), abs(v) - slot(0.5 * self.width)))
        return maximum(minimum(band, slot(most)) * slot(1.0 / slope), length(out, p.z) - slot(reach))

    def relation(self) -> str:
        if self._half_diagonal() >= self.radius:
            return (
                f"Mobius Band: at a radius of {self.radius:g} the band reaches the axis: make the radius larger, "
                "or the width smaller."
            )
        return ""

    def volume(self) -> float:
        return math.tau * self.radius * self.width * self.thickness

    def support(self, directions):
        turn = np.linspace(-math.pi, math.pi, 1 + int(_SAMPLES * max(1.0, abs(self.half_turns))))
        angle = 0.5 * self.half_turns * turn
        u, v = (
            0.5 * size * np.array(side)[:, None]
            for size, side in ((self.thickness, (1.0, 1.0, -1.0, -1.0)), (self.width, (1.0, -1.0, 1.0, -1.0)))
        )
        distance, height = u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle)
        return _of_sections(directions, turn, (self.radius + distance, height))
