# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Profiles with straight edges: rectangles, regular polygons, stars, and polygons of any points.

``Polygon`` takes any number of points, as a ``SetOperation`` takes shapes: ``Polygon((0, 0), (1, 0), (0, 1))``. A point
may have a z, which is ignored.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import field
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, clamp, length, maximum, minimum, select, sqrt
from .. import program
from ..program import Op, combine, primitive
from .base import BOUND, EXACT, LARGEST, ShapeError, Slots, number
from .clipping import half_space, placed, polyhedron
from .operators import balanced
from .primitives import corner
from .profiles import Profile
from .sectors import MOST_SECTORS, into_sector

MOST_POINTS = 256  # of a polygon: each costs time at every point of space
_FLAT = 1e-9  # slope below which an edge of a profile is perpendicular to the axis of revolution
_STRAIGHT = 1e-12  # sine of the turn below which a corner counts as straight
_SHORTEST = 1e-300  # squared length of an edge between equal points, which must not be a zero divisor


class Polygonal(Profile, abstract=True):
    """A region with straight edges that neither cross nor touch each other."""

    def outline(self) -> np.ndarray:
        """The corners (n, 2), in order around the region."""
        raise NotImplementedError

    def support(self, directions):
        return (directions @ self.outline().T).max(axis=1)

    def area(self) -> float | None:
        return abs(_signed_area(self.outline()))

    def moment(self, offset):
        # Green's theorem: the integral of max(x, 0)² dy / 2 along the edges; each edge is positive in one piece.
        a = self.outline() + (offset, 0.0)
        b = np.roll(a, -1, axis=0)
        u, v = np.maximum(a[:, 0], 0.0), np.maximum(b[:, 0], 0.0)
        positive = (u + v) / np.maximum(np.abs(a[:, 0]) + np.abs(b[:, 0]), np.sqrt(_SHORTEST))
        squares = (u * u + u * v + v * v) / 3.0 * positive
        return abs(float(0.5 * np.sum(squares * (b[:, 1] - a[:, 1]))))

    def extruded_program(self, matrix, height):
        def beside(a, b):
            return half_space(matrix, (b[1] - a[1], a[0] - b[0], 0.0), a[0] * b[1] - a[1] * b[0]), True

        ends = polyhedron(matrix, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)], 0.5 * height)
        return _hull_without_pockets(ends, beside, self._corners())

    def revolved_program(self, matrix, offset):
        corners = self._corners() + (offset, 0.0)
        low, high = corners[:, 1].min(), corners[:, 1].max()
        # Cones end well beyond the solid, so no two faces coincide.
        low, high = 1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low
        around = primitive(Op.CYLINDER, placed(matrix, z=0.5 * (low + high)), (2.0 * corners[:, 0].max(), high - low))

        def beside(a, b):
            """The left side of an edge that goes down is outside a cone; that of an edge that goes up is inside."""
            across, up = b - a
            if abs(up) <= _FLAT * abs(across):
                side = -math.copysign(1.0, across)
                return half_space(matrix, (0.0, 0.0, side), side * a[1]), True
            return _cone(matrix, low, high, a, across / up), up > 0.0

        return _hull_without_pockets(around, beside, corners)

    def _corners(self) -> np.ndarray:
        """The outline, counter-clockwise and without straight corners."""
        corners = _without_straight_corners(self.outline())
        return corners if _signed_area(corners) > 0.0 else corners[::-1]


def _cone(matrix: np.ndarray | None, low: float, high: float, through: np.ndarray, slope: float) -> np.ndarray | None:
    """Program of the points between z = ``low`` and ``high`` that are nearer to the z axis than a line. The line's
    distance changes with ``slope``, and it goes ``through`` a point (distance, z). None if there are none."""

    def radius(z):
        return through[0] + (z - through[1]) * slope

    if max(radius(low), radius(high)) <= 0.0:
        return None
    tip = through[1] - through[0] / slope if slope != 0.0 else low
    low, high = tip if radius(low) < 0.0 else low, tip if radius(high) < 0.0 else high
    radii = max(radius(low), 0.0), max(radius(high), 0.0)
    return primitive(Op.FRUSTUM, placed(matrix, z=0.5 * (low + high)), (*radii, high - low))


def _signed_area(corners: np.ndarray) -> float:
    """Positive if the corners go around counter-clockwise."""
    x, y = (corners - corners.mean(axis=0)).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _turns(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sine and cosine of the turn at each corner, times the lengths of its two edges; and those lengths."""
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1), lengths


def _without_straight_corners(corners: np.ndarray) -> np.ndarray:
    while True:
        sines, cosines, lengths = _turns(corners)
        # The tip of a needle turns back: it is not straight, however thin it is.
        kept = (np.abs(sines) > _STRAIGHT * lengths) | (cosines < 0.0)
        if kept.all():
            return corners
        # One at a time: when a corner is removed, its neighbours may become straight, or stop being straight.
        corners = np.delete(corners, np.argmin(kept), axis=0)


def _hull(corners: np.ndarray) -> list[int]:
    """Indices of the corners of the convex hull of a counter-clockwise outline, in the order of the outline."""
    order = np.lexsort((corners[:, 1], corners[:, 0]))

    def chain(indices) -> list[int]:
        kept: list[int] = []
        for index in indices:
            while len(kept) > 1:
                a, b = corners[kept[-1]] - corners[kept[-2]], corners[index] - corners[kept[-1]]
                if a[0] * b[1] - a[1] * b[0] > _STRAIGHT * math.hypot(*a) * math.hypot(*b):
                    break
                kept.pop()
            kept.append(int(index))
        return kept[:-1]

    return sorted(chain(order) + chain(order[::-1]))


def _hull_without_pockets(
    around: np.ndarray, beside: Callable, corners: np.ndarray, closed: bool = True
) -> np.ndarray | None:
    """Program of the inside of a counter-clockwise outline: its convex hull minus the pockets, and so on inwards.

    Tor and Middleditch, "Convex Decomposition of Simple Polygons", 1984. ``around`` is a program of more than the
    whole. ``beside(a, b)`` is a program of the left side of the edge from a to b, and True; or of its right side, and
    False (None for nothing). If it is not ``closed``, the edge from the last corner to the first is left out: the
    outline is that of a pocket, cut out of a part that ends there anyway.
    """
    hull = _hull(corners)
    inside, outside = [around], []
    for start, end in zip(hull, hull[1:] + [hull[0] + len(corners)]):
        if closed or end < len(corners):
            cut, left = beside(corners[start], corners[end % len(corners)])
            if cut is not None:
                (inside if left else outside).append(cut)
            elif left:
                return None
        if end - start > 1:
            chain = corners[np.arange(end, start - 1, -1) % len(corners)]
            pocket = _hull_without_pockets(around, beside, chain, closed=False)
            if pocket is not None:
                outside.append(pocket)
    # Within a pocket only its own edges matter.
    inside = inside[1:] if not closed and len(inside) > 1 else inside
    return combine(Op.DIFFERENCE, [combine(Op.INTERSECTION, inside), *outside])


@frozen
class Rectangle(Polygonal):
    """A rectangle."""

    width: float = number(0.8, "Size along x")
    height: float = number(0.5, "Size along y")

    def build(self, p: Vector, slot: Slots) -> Formula:
        return corner((abs(p.x) - slot(0.5 * self.width), abs(p.y) - slot(0.5 * self.height)))

    def outline(self):
        return 0.5 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) * (self.width, self.height)

    def extruded_program(self, matrix, height):
        return primitive(Op.BOX, placed(matrix), (0.5 * self.width, 0.5 * self.height, 0.5 * height))


def _radial(count: float, radii: tuple[float, ...]) -> np.ndarray:
    """Points (n, 2) at equal angles, the first in the direction of y, at the given distances in turn."""
    distances = np.tile(radii, int(count))
    angles = math.tau * np.arange(len(distances)) / len(distances)
    return distances[:, None] * np.stack([-np.sin(angles), np.cos(angles)], axis=1)


@frozen
class RegularPolygon(Polygonal):
    """A polygon of equal sides and angles, with a corner in the direction of y."""

    sides: float = number(
        6.0, "Number of sides", unit="NONE", minimum=3.0, maximum=MOST_SECTORS, soft_maximum=12.0, whole=True
    )
    radius: float = number(0.5, "Distance from the centre to the corners")

    def folded(self, p: Vector, slot: Slots) -> tuple[Formula, Formula]:
        """Coordinates of p relative to the nearest side: outwards from the centre, and along the side from its middle:
        ≥ 0."""
        along, aside = into_sector(p.y, abs(p.x), int(self.sides), MOST_SECTORS, slot)
        sine, cosine = slot(math.sin(math.pi / self.sides)), slot(math.cos(math.pi / self.sides))
        return along * cosine + aside * sine, along * sine - aside * cosine

    def build(self, p: Vector, slot: Slots) -> Formula:
        out, along = self.folded(p, slot)
        angle = math.pi / self.sides
        return corner((out - slot(self.radius * math.cos(angle)),), (along - slot(self.radius * math.sin(angle)),))

    def outline(self):
        return _radial(self.sides, (self.radius,))


@frozen
class Star(Polygonal):
    """A star of straight edges, with a point in the direction of y."""

    points: float = number(
        5.0, "Number of points", unit="NONE", minimum=3.0, maximum=MOST_SECTORS, soft_maximum=12.0, whole=True
    )
    radius: float = number(0.5, "Distance from the centre to the points")
    inner_radius: float = number(0.2, "Distance from the centre to the corners between two points")

    def build(self, p: Vector, slot: Slots) -> Formula:
        along, aside = into_sector(p.y, abs(p.x), int(self.points), MOST_SECTORS, slot)
        angle = math.pi / self.points
        edge = self.inner_radius * math.cos(angle) - self.radius, self.inner_radius * math.sin(angle)
        u, v, radius = slot(edge[0]), slot(edge[1]), slot(self.radius)
        from_point = along - radius
        way = clamp((from_point * u + aside * v) / (u * u + v * v), 0.0, 1.0)
        distance = length(from_point - way * u, aside - way * v)
        return select(from_point * v - aside * u > 0.0, distance, -distance)

    def relation(self) -> str:
        if self.inner_radius > self.radius:
            return (
                f"Star: inner radius {self.inner_radius:g} is more than the radius {self.radius:g}: make the inner "
                "radius smaller."
            )
        return ""

    def outline(self):
        return _radial(self.points, (self.radius, self.inner_radius))


@frozen
class Plus(Polygonal):
    """Two bars of the same size that cross at right angles, along x and y."""

    half_length: float = number(0.5, "Distance from the centre to the ends of the bars")
    half_width: float = number(0.15, "Half of the width of the bars")

    def build(self, p: Vector, slot: Slots) -> Formula:
        half_length, half_width = slot(self.half_length), slot(self.half_width)
        along, aside = maximum(abs(p.x), abs(p.y)), minimum(abs(p.x), abs(p.y))
        end, side = along - half_length, aside - half_width
        # In the middle a bar is open towards the other: its side begins at their shared corner.
        to_side = length(maximum(half_width - along, 0.0), side)
        inside = select(maximum(end, side) < 0.0, minimum(-end, to_side), 0.0)
        return length(maximum(end, 0.0), maximum(side, 0.0)) - inside

    def relation(self) -> str:
        if self.half_width > self.half_length:
            return (
                f"Plus: half width {self.half_width:g} is more than the half length {self.half_length:g}, so there "
                "are no bars: make the half width smaller."
            )
        return ""

    def outline(self):
        a, b = self.half_length, self.half_width
        arm = np.array([(b, b), (b, a), (-b, a)])
        quarter_turn = np.array([(0.0, 1.0), (-1.0, 0.0)])
        return np.concatenate([arm @ np.linalg.matrix_power(quarter_turn, turns) for turns in range(4)])

    def extruded_program(self, matrix, height):
        sizes = [(self.half_length, self.half_width), (self.half_width, self.half_length)]
        return combine(Op.UNION, [primitive(Op.BOX, placed(matrix), (*size, 0.5 * height)) for size in sizes])


@frozen
class Polygon(Polygonal):
    """The region inside a closed line through the given points.

    Where the line crosses itself, a point is inside if the way out crosses the line an odd number of times.
    """

    mirrored = False

    points: tuple[tuple[float, float], ...] = field(metadata=dict(description="corners, in order"))

    def __init__(self, *points):
        """Points are given as arguments or as one sequence; each is two or three numbers."""
        if len(points) == 1 and np.ndim(points[0]) == 2:
            points = tuple(points[0])
        corners = []
        for point in points:
            try:
                x, y, *rest = (float(value) for value in point)
            except (TypeError, ValueError, OverflowError):
                x, y, rest = 0.0, 0.0, [0.0, 0.0]
            if len(rest) > 1:
                raise ShapeError(f"Polygon: a point must be two or three numbers, not {point!r:.40}.")
            corners.append((x, y))
        object.__setattr__(self, "points", tuple(corners))

    def replaced(self, **values):
        return type(self)(*values.get("points", self.points))

    def build(self, p: Vector, slot: Slots) -> Formula:
        corners = [(slot(x), slot(y)) for x, y in self.points]
        # Whether the corner is at or below the point, as ±1.
        below = [select(y <= p.y, 1.0, -1.0) for _, y in corners]
        starts = list(zip(corners, below))
        squares, signs = [], []
        for (a, a_below), (b, b_below) in zip(starts, starts[1:] + starts[:1]):
            u, v = b[0] - a[0], b[1] - a[1]
            x, y = p.x - a[0], p.y - a[1]
            way = clamp((x * u + y * v) / maximum(u * u + v * v, _SHORTEST), 0.0, 1.0)
            across, up = x - way * u, y - way * v
            squares.append(across * across + up * up)
            # The ray along +x meets the edge if its ends are on different sides of the ray and the point is on its
            # left.
            met = maximum(a_below * b_below, (v * x - u * y) * a_below)
            signs.append(select(met < 0.0, -1.0, 1.0))
        return sqrt(minimum(*squares)) * balanced(operator.mul, signs)

    def relation(self) -> str:
        if not 3 <= len(self.points) <= MOST_POINTS:
            return f"Polygon: it has {len(self.points)} points: give it at least 3 and at most {MOST_POINTS}."
        corners = np.array(self.points)
        if not np.isfinite(corners).all():
            return "Polygon: a point has a coordinate that is not a finite number: give it an ordinary one."
        if np.abs(corners).max() > LARGEST:
            return f"Polygon: a point has a coordinate above {LARGEST:g}: make the polygon smaller."
        if np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)[1] <= _STRAIGHT * np.abs(corners).max():
            return "Polygon: all its points lie on one straight line: move one of them aside."
        return ""

    @property
    def size(self) -> int:
        return len(self.points)

    @property
    def exactness(self) -> str:
        # If edges coincide, both sides may be equal, but the field is still 0.
        return EXACT if self.simple else BOUND

    def outline(self):
        """The corners, without repeated neighbours."""
        corners = np.array(self.points)
        return corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]

    @cached_property
    def simple(self) -> bool:
        """Whether no two edges cross or touch, except neighbours at their common corner."""
        a = self.outline()
        b = np.roll(a, -1, axis=0)

        def side(p, q, r):
            """On which side of each line p–q each point r is: (edges, points)."""
            (px, py), (qx, qy), (rx, ry) = p.T[:, :, None], q.T[:, :, None], r.T[:, None, :]
            return np.sign((qx - px) * (ry - py) - (qy - py) * (rx - px))

        of_a, of_b = side(a, b, a), side(a, b, b)
        apart = (of_a * of_b > 0.0) | (of_a * of_b > 0.0).T
        # Edges on one line meet unless they end before the other begins.
        low, high = np.minimum(a, b), np.maximum(a, b)
        apart |= (low[:, None] > high[None, :]).any(axis=-1) | (high[:, None] < low[None, :]).any(axis=-1)
        n = len(a)
        steps = (np.arange(n)[:, None] - np.arange(n)) % n
        neighbours = (steps <= 1) | (steps == n - 1)
        sines, cosines, lengths = _turns(a)
        back = (np.abs(sines) <= _STRAIGHT * lengths) & (cosines < 0.0)
        return bool((apart | neighbours).all() and not back.any())

    def area(self):
        return super().area() if self.simple else None

    def moment(self, offset):
        return super().moment(offset) if self.simple else None

    def _corners(self):
        if not self.simple:
            raise program.NoClosedForm("A polygon that crosses itself has no closed form for its ray intervals.")
        return super()._corners()
