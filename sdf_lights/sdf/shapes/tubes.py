# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tubes along plane curves: all points within a radius of the curve, like neon signs.

Outside a tube, the distance is that to the curve minus the radius. Inside it is the same, as long as the curve does not
come near itself and bends less than the tube is thick.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select
from ..program import Op, combine, primitive
from . import support
from .base import BOUND, EXACT, LARGEST, Slots, number
from .clipping import placed, sector
from .primitives import Primitive

_TINY = 1e-300  # keeps a possible zero away from 0


def _ball(radius: float) -> float:
    return 4.0 / 3.0 * math.pi * radius**3


def _rod(matrix: np.ndarray | None, start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """Program of a capsule between two points of the xy plane."""
    along = end - start
    size = float(np.hypot(*along))
    if size == 0.0:
        return primitive(Op.SPHERE, placed(matrix, *start), (radius,))
    turned = np.eye(4)
    turned[:2, :3] = [(0.0, along[1] / size, along[0] / size), (0.0, -along[0] / size, along[1] / size)]
    turned[2, :3] = 1.0, 0.0, 0.0
    return primitive(Op.CAPSULE, placed(matrix, *(0.5 * (start + end))) @ turned, (radius, size))


@frozen
class Horseshoe(Primitive):
    """A tube in the xy plane along an arc with straight parts at both ends. The arc's middle is at +y."""

    radius: float = number(0.32, "Distance from the centre of the arc to the middle of the tube")
    minor_radius: float = number(0.08, "Radius of the tube and of its ends")
    angle: float = number(
        math.radians(210.0),
        "Angle of the arc",
        unit="ANGLE",
        minimum=0.0,
        maximum=2.0 * math.pi,
        soft_maximum=2.0 * math.pi,
    )
    leg: float = number(0.25, "Length of the straight parts", minimum=0.0)

    def _direction(self) -> tuple[float, float]:
        """Sine and cosine of the angle between the y axis and the ends of the arc."""
        return math.sin(0.5 * self.angle), math.cos(0.5 * self.angle)

    def _leg(self) -> tuple[np.ndarray, np.ndarray]:
        """Start and end of the straight part at positive x."""
        sine, cosine = self._direction()
        start = self.radius * np.array([sine, cosine])
        return start, start + self.leg * np.array([cosine, -sine])

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = (slot(value) for value in self._direction())
        radius, aside = slot(self.radius), abs(p.x)
        # In the frame of the end of the arc: out from the centre, and on along the straight part.
        out, on = aside * sine + p.y * cosine - radius, aside * cosine - p.y * sine
        to_leg = length(out, maximum(on - slot(self.leg), 0.0))
        across = select(on > 0.0, to_leg, length(aside, p.y) - radius)
        return length(across, p.z) - slot(self.minor_radius)

    def relation(self) -> str:
        if self.minor_radius > self.radius:
            return (
                f"Horseshoe: minor radius {self.minor_radius:g} is more than the radius {self.radius:g}, so the "
                "tube overlaps itself: make the minor radius smaller."
            )
        if min(end[0] for end in self._leg()) < self.minor_radius and self.angle > math.pi:
            return (
                "Horseshoe: its ends run into each other: make the angle, the straight parts or the minor radius "
                "smaller."
            )
        return ""

    def volume(self) -> float:
        return math.pi * self.minor_radius**2 * (self.radius * self.angle + 2.0 * self.leg) + _ball(self.minor_radius)

    def support(self, directions):
        sine, cosine = self._direction()
        aside, up = np.abs(directions[:, 0]), directions[:, 1]
        on_arc = np.where(aside * cosine <= up * sine, self.radius * np.hypot(aside, up), -np.inf)
        ends = [aside * end[0] + up * end[1] for end in self._leg()]
        return np.maximum.reduce([on_arc, *ends]) + support.of_ball(directions, self.minor_radius)

    def program(self, matrix=None):
        start, end = self._leg()
        mirror = np.array([-1.0, 1.0])
        legs = [_rod(matrix, side * start, side * end, self.minor_radius) for side in (1.0, mirror)]
        ring = primitive(Op.TORUS, placed(matrix), (self.radius, self.minor_radius))
        if self.angle < 2.0 * math.pi:
            upwards = np.eye(4)[:, [1, 0, 2, 3]] @ np.diag([1.0, 1.0, -1.0, 1.0])  # x to y
            ring = combine(Op.INTERSECTION, [ring, sector(placed(matrix) @ upwards, self.angle)])
        return combine(Op.UNION, [ring, *legs])


@frozen
class FigureEight(Primitive):
    """A tube in the xy plane in the form of ∞: two arcs and the two straight parts between them, which cross.

    The distance is exact outside. Inside, where the straight parts cross, it never exceeds the distance to the surface.
    """

    exactness = BOUND
    exact_outside = True

    radius: float = number(0.2, "Distance from the centres of the arcs to the middle of the tube")
    half_distance: float = number(0.32, "Half of the distance between the centres of the arcs")
    minor_radius: float = number(0.07, "Radius of the tube")

    def _tangent(self) -> tuple[float, float]:
        """Sine and cosine of the angle between the straight parts and the x axis."""
        sine = self.radius / self.half_distance
        return sine, math.sqrt((1.0 - sine) * (1.0 + sine))

    def build(self, p: Vector, slot: Slots) -> Formula:
        sine, cosine = self._tangent()
        u, v, center = slot(cosine), slot(sine), slot(self.half_distance)
        x, y = abs(p.x), abs(p.y)
        # A quarter of the curve, because the rest is its mirror image: straight to the point where it touches the arc.
        along, aside = x * u + y * v, y * u - x * v
        on_arc = length(x - center, y) - slot(self.radius)
        across = select(along > slot(self.half_distance * cosine), on_arc, aside)
        return length(across, p.z) - slot(self.minor_radius)

    def relation(self) -> str:
        if self.half_distance <= self.radius:
            return (
                f"Figure Eight: half distance {self.half_distance:g} must be more than the radius {self.radius:g}, "
                "for the straight parts to cross: make it larger."
            )
        return ""

    def support(self, directions):
        return (
            self.half_distance * np.abs(directions[:, 0])
            + support.of_disk(directions, self.radius)
            + support.of_ball(directions, self.minor_radius)
        )

    def program(self, matrix=None):
        if self.minor_radius > self.radius:
            return super().program(matrix)
        sine, cosine = self._tangent()
        size = self.half_distance * cosine
        parts = []
        for side in (1.0, -1.0):
            ring = placed(matrix, side * self.half_distance)
            there = ring @ np.diag([side, side, 1.0, 1.0])
            parts.append(
                combine(
                    Op.INTERSECTION,
                    [
                        primitive(Op.TORUS, ring, (self.radius, self.minor_radius)),
                        sector(there, math.pi + 2.0 * math.asin(sine)),
                    ],
                )
            )
            end = size * np.array([cosine, side * sine])
            parts.append(_rod(matrix, -end, end, self.minor_radius))
        return combine(Op.UNION, parts)


@frozen
class BezierTube(Primitive):
    """A tube along a quadratic Bézier curve, given by three points: from the first to the third, drawn towards the
    second.

    The distance is exact outside, and inside where the curve bends less than the tube is thick.
    """

    exact_outside = True
    _halvings, _steps = 8, 5

    start: tuple[float, float, float] = number(
        (-0.5, 0.0, -0.2), "Start of the curve", minimum=-LARGEST, soft_maximum=10.0
    )
    control: tuple[float, float, float] = number(
        (0.0, 0.4, 0.7), "Control point that the curve is drawn towards", minimum=-LARGEST, soft_maximum=10.0
    )
    end: tuple[float, float, float] = number((0.5, 0.0, -0.2), "End of the curve", minimum=-LARGEST, soft_maximum=10.0)
    radius: float = number(0.06, "Radius of the tube and of its ends")

    def _coefficients(self) -> tuple[np.ndarray, np.ndarray, float]:
        """a and b of the curve start + 2a t + b t², 0 ≤ t ≤ 1, and the t of its vertex, the sharpest bend."""
        start, control, end = np.array([self.start, self.control, self.end])
        a, b = control - start, start - 2.0 * control + end
        return a, b, min(max(float(-(a @ b) / max(b @ b, _TINY)), 0.0), 1.0)

    @property
    def exactness(self) -> str:
        # A parabola stays at least its least radius of curvature away from itself, so only that matters.
        a, b, vertex = self._coefficients()
        speed = np.linalg.norm(a + vertex * b)
        return EXACT if self.radius * np.linalg.norm(np.cross(a, b)) < 2.0 * speed**3 else BOUND

    def build(self, p: Vector, slot: Slots) -> Formula:
        """The squared distance has its least value at a root of its derivative f, a cubic, where f changes from
        negative to positive.

        The second derivative of f changes sign at the vertex of the curve: f is concave before it and convex after it.
        So each of the two parts has at most one such root. Bisection brackets it, and Newton's method then approaches
        it from one side.
        """
        a, b, vertex = self._coefficients()
        start, a_, b_ = p - slot(self.start), slot(tuple(a.tolist())), slot(tuple(b.tolist()))
        constant, linear = -start.dot(a_), slot(2.0 * float(a @ a)) - start.dot(b_)
        square, cube = slot(3.0 * float(a @ b)), slot(float(b @ b))

        def cubic(t):
            return constant + t * (linear + t * (square + t * cube)), linear + t * (square * 2.0 + t * cube * 3.0)

        def to_curve(t):
            return (start - (a_ * 2.0 + b_ * t) * t).length()

        def nearest(low, high, convex):
            for _ in range(self._halvings):
                middle = (low + high) * 0.5
                value, slope = cubic(middle)
                # Whether the root is before the middle. Beyond a root of this kind a convex f is positive and rises,
                # and before one a concave f is negative and rises.
                before = minimum(value, slope) > 0.0 if convex else minimum(-value, slope) <= 0.0
                low, high = select(before, low, middle), select(before, middle, high)
            t = high if convex else low
            for _ in range(self._steps):
                value, slope = cubic(t)
                t = clamp(t - value / maximum(slope, _TINY), low, high)
            return to_curve(t)

        middle = slot(vertex)
        return minimum(nearest(0.0, middle, False), nearest(middle, 1.0, True)) - slot(self.radius)

    def volume(self) -> float | None:
        # The volume of a tube is that of a straight one of the same length (Steiner, Weyl).
        if self.exactness != EXACT:
            return None
        return math.pi * self.radius**2 * self._arc_length() + _ball(self.radius)

    def _arc_length(self) -> float:
        a, b, _ = self._coefficients()
        size = math.sqrt(b @ b)
        if size <= 1e-6 * math.sqrt(a @ a):
            return 2.0 * float(np.linalg.norm(a + 0.5 * b))
        # Twice the integral of |a + b t| = size · √((t − t₀)² + off²), with the vertex at t₀.
        vertex = -float(a @ b) / size**2
        off = float(np.linalg.norm(np.cross(a, b))) / size**2

        def integral(t):
            return t * math.hypot(t, off) + (off**2 * math.asinh(t / off) if off > 0.0 else 0.0)

        return size * (integral(1.0 - vertex) - integral(-vertex))

    def support(self, directions):
        a, b, _ = self._coefficients()
        along, bend = directions @ a, directions @ b
        # The greatest product is at an end, or where the curve is perpendicular to the direction.
        turn = np.clip(-along / np.where(bend < 0.0, bend, -_TINY), 0.0, 1.0)
        farthest = np.maximum.reduce([2.0 * along * t + bend * t * t for t in (0.0, 1.0, turn)])
        return directions @ self.start + farthest + support.of_ball(directions, self.radius)
