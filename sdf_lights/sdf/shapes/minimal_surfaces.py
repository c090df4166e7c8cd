# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets that follow triply periodic minimal surfaces, cut to a block.

As usual, the surfaces are approximated by the zeros of short trigonometric polynomials F of the position in radians,
one turn per period: H. G. von Schnering and R. Nesper, "Nodal surfaces of Fourier series", 1991.

Each class states ``slope``, a bound of |∇F|, so |F| / slope is a bound of the distance to the surface. The bounds of
the gyroid and of Schwarz P are the least possible, as shown there. The others are proven by a grid: |∇F|² is a
trigonometric polynomial of some degree n in each coordinate, so its maximum is at most that over N points per period
and coordinate times 1 / cos³(πn/N) (M. Riesz; H. Ehlich and K. Zeller, "Schwankung von Polynomen zwischen
Gitterpunkten", 1964). They are within 1 % of the least ones.
"""

from __future__ import annotations

import math

from ...frozen import frozen
from ...graph.formula import Formula, Vector, cos, maximum, sin
from .base import BOUND, Shape, Slots, number
from .primitives import Box


@frozen
class PeriodicSheet(Shape, abstract=True):
    """A sheet around a periodic surface inside a block. The surface divides space into two endless mazes."""

    exactness = BOUND
    slope = 1.0  # greatest slope of F per radian

    half_size: tuple[float, float, float] = number(
        (0.5, 0.5, 0.5), "Half of the size along x, y and z of the block that the sheet fills"
    )
    period: float = number(0.5, "Period of the surface")
    thickness: float = number(
        0.04, "Least thickness of the sheet; it is thicker where the surface bends most", soft_maximum=1.0
    )

    def surface(self, cosine: Vector, sine: Vector) -> Formula:
        """F, from the cosines and sines of the position in radians."""
        raise NotImplementedError

    def build(self, p: Vector, slot: Slots) -> Formula:
        angle = p * slot(math.tau / self.period)
        value = self.surface(Vector(*map(cos, angle)), Vector(*map(sin, angle)))
        sheet = abs(value) * slot(self.period / (math.tau * self.slope)) - slot(0.5 * self.thickness)
        return maximum(sheet, Box(self.half_size).build(p, slot))

    def bounds(self, matrix=None):
        return Box(self.half_size).bounds(matrix)


def _cycle(v: Vector) -> Vector:
    """(y, z, x)"""
    return Vector(v.y, v.z, v.x)


def _doubled(cosine: Vector) -> Vector:
    """Cosines of twice the angles."""
    return cosine * cosine * 2.0 - 1.0


def _product(v: Vector) -> Formula:
    return v.x * v.y * v.z


def _total(v: Vector) -> Formula:
    return v.x + v.y + v.z


@frozen
class Gyroid(PeriodicSheet):
    """A sheet along the gyroid of Schoen, cut to a block: it twists in every direction and has no straight line.

    F = sin x cos y + sin y cos z + sin z cos x. By the inequality of Cauchy and Schwarz
    (cos x cos y − sin x sin z)² ≤ cos² y + sin² z. The three components of ∇F are of this form, with the coordinates in
    turn, so |∇F|² ≤ 3, as at the origin.
    """

    slope = math.sqrt(3.0)

    def surface(self, cosine, sine):
        return sine.dot(_cycle(cosine))


@frozen
class SchwarzP(PeriodicSheet):
    """A sheet along the primitive surface of Schwarz, cut to a block: rooms with six openings, in a cubic grid.

    F = cos x + cos y + cos z, so |∇F|² = sin² x + sin² y + sin² z ≤ 3.
    """

    slope = math.sqrt(3.0)

    def surface(self, cosine, sine):
        return _total(cosine)


@frozen
class SchwarzD(PeriodicSheet):
    """A sheet along the diamond surface of Schwarz, cut to a block: rooms with four openings, as atoms in diamond.

    F = cos x cos y cos z − sin x sin y sin z.
    """

    slope = 1.23

    def surface(self, cosine, sine):
        return _product(cosine) - _product(sine)


@frozen
class Neovius(PeriodicSheet):
    """A sheet along the surface of Neovius, cut to a block: rooms with openings towards twelve edges of a cube.

    F = 3 (cos x + cos y + cos z) + 4 cos x cos y cos z.
    """

    slope = 7.02

    def surface(self, cosine, sine):
        return _total(cosine) * 3.0 + _product(cosine) * 4.0


@frozen
class SchoenIwp(PeriodicSheet):
    """A sheet along the I-WP surface of Schoen, cut to a block: rooms with openings towards eight corners of a cube.

    F = 2 (cos x cos y + cos y cos z + cos z cos x) − (cos 2x + cos 2y + cos 2z).
    """

    slope = 5.23

    def surface(self, cosine, sine):
        return cosine.dot(_cycle(cosine)) * 2.0 - _total(_doubled(cosine))


@frozen
class SchoenFrd(PeriodicSheet):
    """A sheet along the F-RD surface of Schoen, cut to a block: rooms with openings to twelve and to eight sides.

    F = 4 cos x cos y cos z − (cos 2x cos 2y + cos 2y cos 2z + cos 2z cos 2x).
    """

    slope = 7.08

    def surface(self, cosine, sine):
        doubled = _doubled(cosine)
        return _product(cosine) * 4.0 - doubled.dot(_cycle(doubled))


@frozen
class FischerKochS(PeriodicSheet):
    """A sheet along the S surface of Fischer and Koch, cut to a block: finer passages than those of the gyroid.

    F = cos 2x sin y cos z + cos x cos 2y sin z + sin x cos y cos 2z.
    """

    slope = 2.46

    def surface(self, cosine, sine):
        doubled = _doubled(cosine)
        return doubled.x * sine.y * cosine.z + cosine.x * doubled.y * sine.z + sine.x * cosine.y * doubled.z


@frozen
class Lidinoid(PeriodicSheet):
    """A sheet along the surface of Lidin, cut to a block: a gyroid's sibling with rings of three passages.

    F = ½ (sin 2x cos y sin z + sin 2y cos z sin x + sin 2z cos x sin y)
    − ½ (cos 2x cos 2y + cos 2y cos 2z + cos 2z cos 2x) + 0.15.
    """

    slope = 2.62

    def surface(self, cosine, sine):
        doubled = _doubled(cosine)
        # sin 2x / 2 = sin x cos x
        twisted = (sine * cosine).dot(_cycle(cosine) * _cycle(_cycle(sine)))
        return twisted - doubled.dot(_cycle(doubled)) * 0.5 + 0.15
