# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Outlines: regions of the plane whose edge is made of straight segments, with the exact signed distance.

The sign is that of the nearest segment, which has the inside on its left. Where a corner is nearest, it is that of the
one of its two segments whose line is farther away (Bærentzen and Aanæs 2005, "Signed distance computation using the
angle weighted pseudonormal", in the plane).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, call
from ...graph.functions import Function, TableFunction
from ...graph.interval_kernels import square_bounds, unit_bounds
from ...graph.tables import Table, table
from ...jit import doubles_at, kernel, stack_array
from ..shapes.base import LARGEST, Slots, number
from ..shapes.profiles import Profile
from . import boxes

_HEAD = 2  # numbers before the boxes: of leaves, and where segments begin
_ROW = 6  # numbers of a segment: both ends, and 1/length² and 1/length
_ASIDE = 1e-7  # of the outline's size: how far beside a segment it is looked what is there


@kernel
def _to_box(numbers, node, x, y):
    """Square of the distance of a point to a node's box."""
    at = 2 + 4 * node
    dx = max(max(numbers[at] - x, x - numbers[at + 2]), 0.0)
    dy = max(max(numbers[at + 1] - y, y - numbers[at + 3]), 0.0)
    return dx * dx + dy * dy


@kernel
def _nearest(numbers, x, y):
    """Square of the distance to the nearest segment, the vector from there, and on which side of it the point is
    (±1)."""
    stack = stack_array(64)
    leaves, segments = int(numbers[0]), int(numbers[1])
    best, best_x, best_y, best_aside, side = math.inf, 0.0, 0.0, 0.0, 1.0
    depth, node = 0, 1
    distance = _to_box(numbers, 1, x, y)
    while True:
        if distance <= best * (1.0 + 1e-13) and distance < math.inf:
            if node < leaves:
                near, far = 2 * node, 2 * node + 1
                d_near, d_far = _to_box(numbers, near, x, y), _to_box(numbers, far, x, y)
                if d_far < d_near:
                    near, far, d_near, d_far = far, near, d_far, d_near
                stack[depth], stack[depth + 1] = far, d_far
                depth += 2
                node, distance = near, d_near
                continue
            at = segments + (node - leaves) * 24
            for _ in range(4):
                x0, y0, x1, y1 = numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]
                ux, uy, px, py = x1 - x0, y1 - y0, x - x0, y - y0
                across = ux * py - uy * px
                along = (ux * px + uy * py) * numbers[at + 4]
                aside = abs(across) * numbers[at + 5]
                if along > 0.0 and along < 1.0:
                    scale = across * numbers[at + 4]
                    dx, dy = -uy * scale, ux * scale
                    square = aside * aside
                elif along <= 0.0:
                    dx, dy = px, py
                    square = dx * dx + dy * dy
                else:
                    dx, dy = x - x1, y - y1
                    square = dx * dx + dy * dy
                at += 6
                if square < best * (1.0 - 1e-13) or square <= best * (1.0 + 1e-13) and aside > best_aside:
                    best, best_x, best_y, best_aside = square, dx, dy, aside
                    side = -1.0 if across > 0.0 else 1.0
        if depth == 0:
            return best, best_x, best_y, side
        depth -= 2
        node, distance = int(stack[depth]), stack[depth + 1]


@kernel
def outline_distance(address, x, y):
    """The distance of a point, of the kind ``TableFunction``."""
    square, _, _, side = _nearest(doubles_at(address), x, y)
    if not square < math.inf:
        return math.inf if x == x and y == y else math.nan
    return side * math.sqrt(square)


@kernel
def outline_slope(address, x, y):
    """Its derivatives."""
    square, dx, dy, side = _nearest(doubles_at(address), x, y)
    length = math.sqrt(square)
    if not 0.0 < length < math.inf:
        return 0.0, 0.0
    return side * dx / length, side * dy / length


@kernel
def _part(low, high, other_low, other_high):
    """Bounds of u/√(u² + v²) for u and v within bounds."""
    least, most = square_bounds(other_low, other_high)
    return unit_bounds(low, high, least, most)


@kernel
def outline_bounds(address, x_low, x_high, y_low, y_high):
    """Bounds of the distance and its derivatives in a box."""
    numbers = doubles_at(address)
    x, y, hx, hy = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high), 0.5 * (x_high - x_low), 0.5 * (y_high - y_low)
    radius = math.hypot(hx, hy)
    if not radius < math.inf:
        return -math.inf, math.inf, -1.0, 1.0, -1.0, 1.0
    square, _, _, side = _nearest(numbers, x, y)
    distance = math.sqrt(square)
    if not distance < math.inf:
        return -math.inf, math.inf, -1.0, 1.0, -1.0, 1.0
    margin = 1e-9 * (distance + radius)
    low, high = side * distance - radius - margin, side * distance + radius + margin
    # Every segment that is nearest to some point of the box bounds the gradient.
    reach = (distance + 2.0 * radius) * (1.0 + 1e-9)
    reach = reach * reach
    sx0, sx1, sy0, sy1 = math.inf, -math.inf, math.inf, -math.inf
    stack = stack_array(64)
    leaves, segments = int(numbers[0]), int(numbers[1])
    stack[0] = 1.0
    depth, found = 1, 0
    while depth > 0:
        depth -= 1
        node = int(stack[depth])
        if _to_box(numbers, node, x, y) > reach:
            continue
        if node < leaves:
            stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
            depth += 2
            continue
        for row in range(4):
            at = segments + (4 * (node - leaves) + row) * 6
            x0, y0, x1, y1 = numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]
            ux, uy = x1 - x0, y1 - y0
            along = (ux * (x - x0) + uy * (y - y0)) * numbers[at + 4]
            near = min(max(along, 0.0), 1.0)
            dx, dy = x - (x0 + near * ux), y - (y0 + near * uy)
            if dx * dx + dy * dy > reach:
                continue
            found += 1
            if found > 24:
                return low, high, -1.0, 1.0, -1.0, 1.0
            spread = (abs(ux) * hx + abs(uy) * hy) * numbers[at + 4] + 1e-9
            if along + spread > 0.0 and along - spread < 1.0:
                nx, ny = uy * numbers[at + 5], -ux * numbers[at + 5]
                sx0, sx1, sy0, sy1 = min(sx0, nx), max(sx1, nx), min(sy0, ny), max(sy1, ny)
            for end in range(2):
                if along - spread > 0.0 if end == 0 else along + spread < 1.0:
                    continue
                dx, dy = (x - x0, y - y0) if end == 0 else (x - x1, y - y1)
                a, b = _part(dx - hx, dx + hx, dy - hy, dy + hy)
                c, d = _part(dy - hy, dy + hy, dx - hx, dx + hx)
                if high > 0.0:
                    sx0, sx1, sy0, sy1 = min(sx0, a), max(sx1, b), min(sy0, c), max(sy1, d)
                if low < 0.0:
                    sx0, sx1, sy0, sy1 = min(sx0, -b), max(sx1, -a), min(sy0, -d), max(sy1, -c)
    margin = 1e-9
    return (
        low,
        high,
        max(sx0 - margin, -1.0),
        min(sx1 + margin, 1.0),
        max(sy0 - margin, -1.0),
        min(sy1 + margin, 1.0),
    )


_GLSL = """\
float outline_box(int at, float x, float y)
{
    float dx = max(max(table_number(at) - x, x - table_number(at + 2)), 0.0);
    float dy = max(max(table_number(at + 1) - y, y - table_number(at + 3)), 0.0);
    return dx * dx + dy * dy;
}

float outline(int table, float x, float y)
{
    int stack[40];
    float distances[40];
    int leaves = int(table_number(table));
    int segments = table + int(table_number(table + 1));
    float best = 1e30;
    float best_aside = 0.0;
    float side = 1.0;
    int depth = 1;
    stack[0] = 1;
    distances[0] = 0.0;
    while (depth > 0) {
        depth--;
        int node = stack[depth];
        if (distances[depth] > best * 1.000002) {
            continue;
        }
        if (node < leaves) {
            {descent}
        }
        int at = segments + (node - leaves) * 24;
        for (int row = 0; row < 4; row++) {
            vec2 start = vec2(table_number(at), table_number(at + 1));
            vec2 end = vec2(table_number(at + 2), table_number(at + 3));
            vec2 u = end - start;
            vec2 p = vec2(x, y) - start;
            float across = u.x * p.y - u.y * p.x;
            float along = dot(u, p) * table_number(at + 4);
            float aside = abs(across) * table_number(at + 5);
            vec2 q = along <= 0.0 ? p : vec2(x, y) - end;
            float square = along > 0.0 && along < 1.0 ? aside * aside : dot(q, q);
            if (square < best * 0.999998 || (square <= best * 1.000002 && aside > best_aside)) {
                best = square;
                best_aside = aside;
                side = across > 0.0 ? -1.0 : 1.0;
            }
            at += 6;
        }
    }
    return side * sqrt(best);
}
""".replace("{descent}", boxes.descent("outline_box", 4, "x, y"))

OUTLINE = TableFunction(
    "outline",
    outline_distance,
    bounds=Function("outline_bounds", outline_bounds, results=6),
    derivatives=Function("outline_slope", outline_slope, results=2),
    lipschitz=1.0,
    glsl=_GLSL,
    operations=150.0,
)


def outline_table(segments: np.ndarray) -> Table:
    """Table of segments (n, 4), x and y of both ends, with the inside on their left. Those without length are left out.
    Raises ValueError if none is left."""
    segments = np.asarray(segments, np.float64).reshape(-1, 4)
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    segments, lengths = segments[lengths > 0.0], lengths[lengths > 0.0]
    if not len(segments):
        raise ValueError("an outline needs segments that have a length")
    low, high = np.minimum(segments[:, :2], segments[:, 2:]), np.maximum(segments[:, :2], segments[:, 2:])
    order, nodes = boxes.tree(low, high)
    rows = np.column_stack([segments, lengths**-2, 1.0 / lengths])[order]
    head = [len(nodes) // 2, _HEAD + nodes.size]
    return table(np.concatenate([head, nodes.ravel(), rows.ravel()]))


@frozen
class Outline(Profile, abstract=True):
    """A region of the plane with an edge of straight segments, and what lies within ``offset`` of it."""

    mirrored = False

    data: Table = dataclasses.field(metadata=dict(description="its segments, see ``outline_table``"))
    offset: float = number(0.0, "By how much the region grows", minimum=-LARGEST)

    @classmethod
    def of(cls, loops: Sequence[np.ndarray], offset: float = 0.0, nonzero: bool = False) -> "Outline":
        """The region inside closed ``loops`` (n, 2), as ``oriented`` has it."""
        return cls(outline_table(oriented(loops, nonzero)), offset)

    @cached_property
    def segments(self) -> np.ndarray:
        """Both ends (n, 4) of the segments."""
        numbers = self.data.array
        return np.unique(numbers[int(numbers[1]) :].reshape(-1, _ROW)[:, :4], axis=0)

    def build(self, p: Vector, slot: Slots) -> Formula:
        (distance,) = call(OUTLINE, slot(self.data.address), p.x, p.y)
        return distance - slot(self.offset)

    def support(self, directions):
        points = self.segments.reshape(-1, 2)
        grown = max(self.offset, 0.0) * np.linalg.norm(directions, axis=1)
        return np.array([(points @ direction).max() for direction in directions]) + grown

    def area(self) -> float | None:
        if self.offset != 0.0:
            return None
        x0, y0, x1, y1 = self.segments.T
        return float(0.5 * np.sum(x0 * y1 - x1 * y0))

    def moment(self, offset):
        return None

    def relation(self) -> str:
        if not np.isfinite(self.segments).all() or np.abs(self.segments).max() > LARGEST:
            return f"Outline: a corner is not within {LARGEST:g} m of the origin: move it nearer."
        return ""


def oriented(loops: Sequence[np.ndarray], nonzero: bool = False) -> np.ndarray:
    """Segments (n, 4) of closed loops (m, 2) each, with the inside on their left.

    Inside is what an odd number of loops is around; if ``nonzero``, what more loops go around to the left than to the
    right, or the other way. Loops that cross are divided where they do, and what is no edge is left out.
    """
    ends = [np.column_stack([loop, np.roll(loop, -1, axis=0)]) for loop in loops if len(loop) > 2]
    if not ends:
        return np.zeros((0, 4))
    segments = divided(np.concatenate(ends))
    normal = np.column_stack([segments[:, 1] - segments[:, 3], segments[:, 2] - segments[:, 0]])  # to the left
    length = np.linalg.norm(normal, axis=1)
    segments, normal = segments[length > 0.0], (normal.T / np.where(length > 0.0, length, 1.0)).T[length > 0.0]
    if not len(segments):
        return segments
    middle = 0.5 * (segments[:, :2] + segments[:, 2:])
    step = _ASIDE * float(np.ptp(segments.reshape(-1, 2), axis=0).max())
    left, right = (windings(segments, middle + sign * step * normal) for sign in (1.0, -1.0))
    left, right = (turns != 0 if nonzero else turns % 2 != 0 for turns in (left, right))
    segments[~left] = segments[~left][:, [2, 3, 0, 1]]
    segments = segments[left != right]
    # Of two loops that share an edge it is there twice.
    turned = (segments[:, 0] > segments[:, 2]) | (segments[:, 0] == segments[:, 2]) & (segments[:, 1] > segments[:, 3])
    ordered = np.where(turned[:, None], segments[:, [2, 3, 0, 1]], segments)
    _, first = np.unique(ordered, axis=0, return_index=True)
    return segments[np.sort(first)]


@kernel
def _windings(segments, rows, starts, low, scale, points, turns):
    for index in range(len(points)):
        x, y = points[index, 0], points[index, 1]
        line = int((y - low) * scale)
        turn = 0
        if 0 <= line < len(starts) - 1:
            for place in range(starts[line], starts[line + 1]):
                row = rows[place]
                x0, y0, x1, y1 = segments[row, 0], segments[row, 1], segments[row, 2], segments[row, 3]
                if (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0):
                    turn += 1 if y1 > y0 else -1
        turns[index] = turn


def windings(segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How often the loops that segments (m, 4) make go around points (n, 2), to the left."""
    segments = np.ascontiguousarray(segments)
    low, high = segments[:, 1::2].min(axis=1), segments[:, 1::2].max(axis=1)
    bottom, size = low.min(), max(float(high.max() - low.min()), 1e-300)
    lines = int(np.clip(len(segments) // 4, 1, 4096))
    scale = lines / (size * (1.0 + 1e-9))
    first, last = (((end - bottom) * scale).astype(np.int64) for end in (low, high))
    counts = last - first + 1
    rows = np.repeat(np.arange(len(segments)), counts)
    inside = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(first, counts)
    order = np.argsort(inside, kind="stable")
    starts = np.searchsorted(inside[order], np.arange(lines + 2))
    turns = np.zeros(len(points), np.int64)
    _windings(segments, rows[order], starts, float(bottom), float(scale), np.ascontiguousarray(points), turns)
    return turns


@kernel
def _crossings(segments, low, high, order, out, cuts):
    """Write pairs (segment, place along it) where segments cross, to ``out`` and ``cuts``; returns how many there are.

    ``order`` sorts segments by their lowest x.
    """
    count = 0
    for a in range(len(order)):
        i = order[a]
        for b in range(a + 1, len(order)):
            j = order[b]
            if low[j, 0] > high[i, 0]:
                break
            if low[j, 1] > high[i, 1] or high[j, 1] < low[i, 1]:
                continue
            ux, uy = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
            vx, vy = segments[j, 2] - segments[j, 0], segments[j, 3] - segments[j, 1]
            wx, wy = segments[j, 0] - segments[i, 0], segments[j, 1] - segments[i, 1]
            area = ux * vy - uy * vx
            if area == 0.0:
                continue
            s, t = (wx * vy - wy * vx) / area, (wx * uy - wy * ux) / area
            if not (-1e-12 <= s <= 1.0 + 1e-12 and -1e-12 <= t <= 1.0 + 1e-12):
                continue
            for which in range(2):
                place = s if which == 0 else t
                if 1e-12 < place < 1.0 - 1e-12:
                    if count < len(out):
                        out[count], cuts[count] = i if which == 0 else j, place
                    count += 1
    return count


def divided(segments: np.ndarray) -> np.ndarray:
    """The segments (n, 4), divided where they cross."""
    segments = np.ascontiguousarray(segments, np.float64)
    low, high = np.minimum(segments[:, :2], segments[:, 2:]), np.maximum(segments[:, :2], segments[:, 2:])
    order, room = np.argsort(low[:, 0], kind="stable"), len(segments)
    while True:
        out, cuts = np.empty(room, np.int64), np.empty(room)
        count = _crossings(segments, low, high, order, out, cuts)
        if count <= room:
            break
        room = count
    if not count:
        return segments
    out, cuts = out[:count], cuts[:count]
    pieces = [segments[np.setdiff1d(np.arange(len(segments)), out)]]
    for index in np.unique(out):
        start, end = segments[index, :2], segments[index, 2:]
        places = np.unique(np.concatenate([[0.0], cuts[out == index], [1.0]]))[:, None]
        points = start + places * (end - start)
        points[-1] = end
        pieces.append(np.column_stack([points[:-1], points[1:]]))
    return np.concatenate(pieces)
