# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractals of orbits: the positions of a point under repeated maps.

Distance estimates of such sets divide the position of the orbit by the derivative of the map along it (J. C. Hart, D.
J. Sandin, L. H. Kauffman, "Ray tracing deterministic 3-D fractals", 1989). Their derivative is that at the point alone,
so the estimate may exceed the distance and jump. Here the derivative is bounded over all points around, and the
quotient is a proven bound with slope 1: near the surface, 0.2 times (Mandelbox) to 0.75 times (Mandelbulb) the
estimate.

**Reach.** Let a map f take each ball of radius ρ < 1/t around x into the ball of radius E(ρ) = s ρ / (1 − t ρ) around
f(x), with s and t that depend on x. Let d be the signed distance of f(x) to some surface, or a bound of it with slope
1. Then |d| / (s + t |d|), which solves E(ρ) = |d|, bounds the distance of x from the preimage of the surface. It has
slope 1 too if, with h = |x − y|,

    E_y(ρ − h) ≤ E_x(ρ) − E_x(h),                                        (1)

because d is at least d − E_x(h) at y. For (1) it is sufficient that t_y ≤ t_x / (1 − t_x h) and s_y ≤ s_x / (1 − t_x
h)²:

    s ≥ |Df|,   |∇ ln s| ≤ 2t,   |∇ (1/t)| ≤ 1.                          (2)

Two maps in sequence have slope s₁ s₂ and bend t₁ + s₁ t₂, which inherit (1). Adding x itself to f(x), as Mandelbrot's
sets do, adds ρ to E and leaves (1) unchanged. So does the greater E that has s + 1 for s: if t_y ≤ t_x / (1 − t_x h),
(ρ − h) / (1 − t_y (ρ − h)) ≤ ρ / (1 − t_x ρ) − h / (1 − t_x h).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...frozen import frozen
from ...graph.formula import Formula, Vector, atan2, constant, cos, length, maximum, minimum, power, sin
from ...graph.loops import iterate
from . import support
from .base import BOUND, NONE, Shape, Slots, number
from .primitives import Box
from .reflections import into_tetrahedral_chamber

MOST_ROUNDS = 30


class Reach(NamedTuple):
    """How much a map separates points: s and t of the module's text."""

    slope: Formula
    bend: Formula

    def then(self, slope: Formula, bend: Formula) -> "Reach":
        """Of this map followed by another one, which has its slope and bend at the image of this one."""
        return Reach(self.slope * slope, self.bend + self.slope * bend)

    def pulled_back(self, distance: Formula) -> Formula:
        """The bound at the point, from one at its image."""
        return distance / (self.slope + self.bend * abs(distance))


START = Reach(constant(1.0), constant(0.0))


def rounds(default: float):
    """Dataclass field of the length of orbits."""
    return number(
        default,
        "Number of times that the map is applied: more show finer detail",
        unit="NONE",
        minimum=1.0,
        maximum=MOST_ROUNDS,
        soft_maximum=12.0,
        whole=True,
        label="Iterations",
    )


class Orbital(Shape, abstract=True):
    """A shape in a ball around the origin. The maps have no scale: ``_reach()`` is the ball's radius in their space."""

    exactness = BOUND
    radius: float

    def _reach(self) -> float:
        raise NotImplementedError

    def _field(self, p: Vector, slot: Slots) -> Formula:
        """The field in the space of the map."""
        raise NotImplementedError

    def build(self, p: Vector, slot: Slots) -> Formula:
        unit = slot(self.radius / self._reach())
        return self._field(p / unit, slot) * unit

    def bounds(self, matrix=None):
        return support.bounds(lambda directions: support.of_ball(directions, self.radius), matrix)


@frozen
class Mandelbulb(Orbital):
    """The points p that z → zⁿ + p never moves far away, with powers in spherical coordinates.

    A power multiplies the angles from the z axis and around it, and raises the length (D. White and P. Nylander, 2009).
    Whole powers have proven bounds. Others tear space along a half plane (y = 0, x < 0), where no bound exists and rays
    may miss light: of pairs of points, some with a distance of 1e-6 and some of 0.1, 1 in 20,000 are torn apart.
    """

    radius: float = number(0.5, "Radius of the smallest ball around the shape")
    power: float = number(
        8.0, "Exponent n", unit="NONE", minimum=2.0, maximum=32.0, soft_maximum=16.0, label="Exponent"
    )
    rounds: float = rounds(4.0)
    always_continuous = False

    @property
    def certified(self) -> bool:
        return self.power == math.floor(self.power)

    @property
    def exactness(self) -> str:
        return BOUND if self.certified else NONE

    def _reach(self):
        # Beyond it, |zⁿ| − |p| is greater than both |z| and |p|.
        return 2.0 ** (1.0 / (self.power - 1.0))

    def _field(self, p, slot):
        n, escape = self.power, slot(self._reach())
        exponent, floor, lowest = slot(n), 0.5, slot(0.5**n)
        beyond = escape * 2.0  # so far out, later iterations do not increase the bound
        # With r = |z| and a = |(z.x, z.y)|, the derivative of zⁿ is at most s = n rⁿ⁻¹ min(n, r / a): circles around
        # the axis are stretched most, from a = r sin θ to rⁿ |sin nθ|. |∇ ln s|² is at most n (n − 2) / r² + 1 / a², so
        # less than 4 max(c / r, 1 / a)² with the c below. Near the origin r is held above a floor, for 1 / r.
        least_bend = slot(0.5 * max(n - 1.0, math.sqrt(4.0 / 3.0 * n * (n - 2.0))))

        def step(x, y, z, r, slope, bend, field):
            around, far = length(x, y), maximum(r, floor)
            raised = power(minimum(r, beyond), exponent)  # points farther out are not used, but computed
            axis = maximum(around, far / exponent)
            reach = Reach(slope, bend).then(
                exponent * maximum(raised, lowest) / axis, maximum(least_bend / far, 1.0 / axis)
            )
            reach = reach._replace(slope=reach.slope + 1.0)
            polar, azimuth = atan2(around, z) * exponent, atan2(y, x) * exponent
            side = raised * sin(polar)
            q = Vector(side * cos(azimuth), side * sin(azimuth), raised * cos(polar)) + p
            further = q.length()
            return (*q, further, *reach, maximum(field, reach.pulled_back(further - escape))), r < beyond

        r = p.length()
        return iterate(slot(self.rounds), (*p, r, *START, r - escape), step, MOST_ROUNDS)[-1]


_FREE = dict(unit="NONE", minimum=-2.0, maximum=2.0, soft_maximum=1.0)


@frozen
class JuliaQuaternion(Orbital):
    """The points q that q → q² + c never moves far away: a slice of the Julia set of quaternions.

    x is the real part of q, y and z are the next two parts. The last part is that of the slice.
    """

    radius: float = number(0.6, "Radius of the ball that contains the shape")
    constant: tuple[float, float, float] = number((-0.2, 0.6, 0.2), "First three parts of c", **_FREE)
    constant_w: float = number(0.2, "Last part of c", **_FREE)
    slice_w: float = number(0.0, "Last part of q where the slice is taken", **_FREE)
    rounds: float = rounds(8.0)

    def _reach(self):
        return 0.5 + math.sqrt(0.25 + math.hypot(*self.constant, self.constant_w))  # r² = r + |c|

    def _field(self, p, slot):
        escape, c, c_w = slot(self._reach()), slot(self.constant), slot(self.constant_w)
        # With s = 2r, |∇ ln s| = 1 / r. If r is held above a floor, t = 1 / (r + floor) is at least half of it.
        floor = 0.4

        def step(x, y, z, w, r, slope, bend, field):
            far = maximum(r, floor)
            reach = Reach(slope, bend).then(far * 2.0, 1.0 / (far + floor))
            double = x * 2.0
            q = x * x - y * y - z * z - w * w + c.x, double * y + c.y, double * z + c.z, double * w + c_w
            further = length(*q)
            return (*q, further, *reach, maximum(field, reach.pulled_back(further - escape))), r < escape * 2.0

        w = slot(self.slice_w)
        r = length(*p, w)
        return iterate(slot(self.rounds), (*p, w, r, *START, r - escape), step, MOST_ROUNDS)[-1]


def _inverted(v: Vector, radius: Formula | float, floor: Formula | float) -> tuple[Formula, Formula, Formula]:
    """For v, relative to the centre of a sphere that is inverted: the factor of v, and the slope and bend of the map.

    Nearer to the centre than ``floor`` the factor is constant.
    """
    far = maximum(v.length(), floor)
    factor = maximum(1.0, radius * radius / (far * far))
    return factor, factor, 1.0 / far


@frozen
class Mandelbox(Shape):
    """The points that stay near while space is folded at a box, inverted at a sphere, and scaled.

    z → scale · sphere(box(z)) + p. The box, of half size 1, mirrors points beyond its faces; the sphere, of radius 1,
    inverts points inside it (T. Lowe, 2010).
    """

    exactness = BOUND

    half_size: float = number(0.5, "Half of the size along x, y and z")
    scale: float = number(
        3.0, "Scale of each round; may be negative", unit="NONE", minimum=-10.0, maximum=10.0, soft_maximum=4.0
    )
    inner_radius: float = number(
        0.5,
        "Distance from the centre of the sphere below which space is only scaled",
        unit="NONE",
        minimum=0.05,
        maximum=1.0,
        soft_maximum=1.0,
    )
    rounds: float = rounds(4.0)

    def relation(self) -> str:
        if abs(self.scale) < 1.1:
            return f"Mandelbox: scale is {self.scale:g}, but must be at least 1.1, or at most -1.1."
        return ""

    def _reach(self) -> float:
        """Half of the size in the space of the map."""
        # On an axis, scale · (2 − p) + p is not farther out than p.
        return 2.0 * (self.scale + 1.0) / (self.scale - 1.0) if self.scale > 0.0 else 2.0

    def build(self, p: Vector, slot: Slots) -> Formula:
        unit, most = slot(self.half_size / self._reach()), abs(self.scale)
        # No coordinate larger than that decreases again.
        escape = slot((2.0 * most + self._reach()) / (most - 1.0))
        scale, growth, floor, half_size = slot(self.scale), slot(most), slot(self.inner_radius), slot(self._reach())
        # Outside the box, the set looks as at the nearest point of the box.
        start = (p / unit).minimum(half_size).maximum(-half_size)

        def step(x, y, z, far, slope, bend, field):
            q = Vector(x, y, z)
            q = q.minimum(1.0).maximum(-1.0) * 2.0 - q
            factor, *inversion = _inverted(q, 1.0, floor)
            reach = Reach(slope, bend).then(*inversion)
            reach = reach._replace(slope=reach.slope * growth + 1.0)
            q = q * (scale * factor) + start
            further = abs(q).greatest()
            return (*q, further, *reach, maximum(field, reach.pulled_back(further - escape))), far < escape * 3.0

        first = abs(start).greatest()
        *_, field = iterate(slot(self.rounds), (*start, first, *START, first - half_size), step, MOST_ROUNDS)
        return maximum(field * unit, Box((self.half_size,) * 3).build(p, slot))

    def bounds(self, matrix=None):
        return Box((self.half_size,) * 3).bounds(matrix)


# Four balls of radius 1 that touch one another, in the corners of a tetrahedron, and the sphere around them.
_BALL = Vector(*(math.sqrt(0.5),) * 3)
_AROUND = 1.0 + math.sqrt(1.5)
# The sphere through the points where they touch, perpendicular to them; its inversion shows the ball in the middle.
_MIDDLE = math.sqrt(0.5)
_MIDDLE_BALL = _MIDDLE**2 / _AROUND
# The sphere perpendicular to three of them and to the outer sphere: the distance of its centre, and its radius.
_SIDE = (_AROUND**2 + 0.5) * math.sqrt(1.5)
_SIDE_RADIUS = math.sqrt(_SIDE**2 - _AROUND**2)
_SIDE_CENTER = Vector(*(_SIDE / math.sqrt(3.0) * sign for sign in (-1.0, 1.0, 1.0)))


@frozen
class ApollonianGasket(Orbital):
    """Balls packed into a ball: four that touch one another, and the largest possible ball in every gap.

    Each round fills the gaps around the balls of the round before (F. Soddy, 1937). Inversions in five spheres
    perpendicular to the first ones map gaps to larger ones: D. W. Boyd, "The osculatory packing of a three dimensional
    sphere", 1973.
    """

    radius: float = number(0.5, "Radius of the ball that contains the others")
    rounds: float = rounds(3.0)

    def _reach(self):
        return _AROUND

    def _field(self, p, slot):
        def balls(q: Vector) -> Formula:
            return minimum((q - _BALL).length() - 1.0, q.length() - _MIDDLE_BALL)

        def step(x, y, z, slope, bend, field):
            q, reach = Vector(x, y, z), Reach(slope, bend)
            factor, *inversion = _inverted(q, _MIDDLE, 0.5 * _MIDDLE_BALL)
            q, reach = q * factor, reach.then(*inversion)
            factor, *inversion = _inverted(q - _SIDE_CENTER, _SIDE_RADIUS, 1.0)
            q, reach = into_tetrahedral_chamber((q - _SIDE_CENTER) * factor + _SIDE_CENTER), reach.then(*inversion)
            return (*q, *reach, minimum(field, reach.pulled_back(balls(q)))), None

        r = p.length()
        start = into_tetrahedral_chamber(p / maximum(r * (1.0 / _AROUND), 1.0))  # the nearest point in the ball around
        *_, field = iterate(slot(self.rounds), (*start, *START, balls(start)), step, MOST_ROUNDS)
        return maximum(field, r - _AROUND)
