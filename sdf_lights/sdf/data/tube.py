# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tubes along curves: balls that move along straight segments while their radius changes evenly.

The ball that is nearest to a point, of those with the centre a + s u and the radius r − k s for 0 ≤ s ≤ l, is at
s = (p − a)·u − k ρ/√(1 − k²), ρ the distance to the line, or at the end next to that: the distance is convex in s.
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
from ..shapes.base import BOUND, LARGEST, SMALLEST, Shape, Slots
from . import boxes

_HEAD = 2  # numbers before the boxes: of leaves, and where segments begin
_ROW = 9  # numbers of a segment: an end, its radius, the direction, the length, and k


@kernel
def _to_box(numbers, node, x, y, z):
    """Signed distance to a node's box, which no ball in it is nearer than."""
    at = 2 + 6 * node
    dx = max(numbers[at] - x, x - numbers[at + 3])
    dy = max(numbers[at + 1] - y, y - numbers[at + 4])
    dz = max(numbers[at + 2] - z, z - numbers[at + 5])
    most = max(max(dx, dy), dz)
    if most <= 0.0:
        return most
    dx, dy, dz = max(dx, 0.0), max(dy, 0.0), max(dz, 0.0)
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def _to_segment(numbers, at, x, y, z):
    """Distance to a segment's balls, and the vector from the centre of the nearest."""
    px, py, pz = x - numbers[at], y - numbers[at + 1], z - numbers[at + 2]
    ux, uy, uz, k = numbers[at + 4], numbers[at + 5], numbers[at + 6], numbers[at + 8]
    along = px * ux + py * uy + pz * uz
    s = along
    if abs(k) >= 1.0:
        s = math.inf if k < 0.0 else -math.inf
    elif k != 0.0:
        qx, qy, qz = px - along * ux, py - along * uy, pz - along * uz
        s -= k * math.sqrt((qx * qx + qy * qy + qz * qz) / (1.0 - k * k))
    s = min(max(s, 0.0), numbers[at + 7])
    dx, dy, dz = px - s * ux, py - s * uy, pz - s * uz
    return math.sqrt(dx * dx + dy * dy + dz * dz) - (numbers[at + 3] - k * s), dx, dy, dz


@kernel
def _nearest(numbers, x, y, z):
    """Distance to the nearest ball, the vector from its centre, and where its segment is in the table."""
    stack = stack_array(64)
    leaves, segments = int(numbers[0]), int(numbers[1])
    best, best_x, best_y, best_z, best_at = math.inf, 0.0, 0.0, 0.0, segments
    depth, node = 0, 1
    distance = _to_box(numbers, 1, x, y, z)
    while True:
        if distance < best:
            if node < leaves:
                near, far = 2 * node, 2 * node + 1
                d_near, d_far = _to_box(numbers, near, x, y, z), _to_box(numbers, far, x, y, z)
                if d_far < d_near:
                    near, far, d_near, d_far = far, near, d_far, d_near
                stack[depth], stack[depth + 1] = far, d_far
                depth += 2
                node, distance = near, d_near
                continue
            at = segments + (node - leaves) * 36
            for _ in range(4):
                found, dx, dy, dz = _to_segment(numbers, at, x, y, z)
                if found < best:
                    best, best_x, best_y, best_z, best_at = found, dx, dy, dz, at
                at += 9
        if depth == 0:
            return best, best_x, best_y, best_z, best_at
        depth -= 2
        node, distance = int(stack[depth]), stack[depth + 1]


@kernel
def tube_distance(address, x, y, z):
    """The distance of a point, of the kind ``TableFunction``."""
    best, _, _, _, _ = _nearest(doubles_at(address), x, y, z)
    return best if x == x and y == y and z == z else math.nan


@kernel
def tube_slope(address, x, y, z):
    """Its derivatives."""
    _, dx, dy, dz, _ = _nearest(doubles_at(address), x, y, z)
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    if not 0.0 < length < math.inf:
        return 0.0, 0.0, 0.0
    return dx / length, dy / length, dz / length


@kernel
def tube_along(address, x, y, z):
    """How far along its path the centre of the nearest ball is, from 0 at its start to 1 at its end."""
    numbers = doubles_at(address)
    best, dx, dy, dz, at = _nearest(numbers, x, y, z)
    if not abs(best) < math.inf:
        return 0.0
    s = (
        (x - dx - numbers[at]) * numbers[at + 4]
        + (y - dy - numbers[at + 1]) * numbers[at + 5]
        + (z - dz - numbers[at + 2]) * numbers[at + 6]
    )
    part = min(max(s / numbers[at + 7], 0.0), 1.0) if numbers[at + 7] > 0.0 else 0.0
    leaves, segments = int(numbers[0]), int(numbers[1])
    place = segments + 36 * leaves + 2 * ((at - segments) // 9)
    return numbers[place] + part * (numbers[place + 1] - numbers[place])


@kernel
def tube_along_bounds(address, x_low, x_high, y_low, y_high, z_low, z_high):
    """Bounds of that: it jumps where two parts of a curve are equally near."""
    return 0.0, 1.0, -math.inf, math.inf, -math.inf, math.inf, -math.inf, math.inf


@kernel
def _axis(low, high, b_low, b_high, c_low, c_high):
    """Bounds of u/√(u² + v² + w²)."""
    b, c = square_bounds(b_low, b_high), square_bounds(c_low, c_high)
    return unit_bounds(low, high, b[0] + c[0], b[1] + c[1])


@kernel
def tube_bounds(address, x_low, x_high, y_low, y_high, z_low, z_high):
    """Bounds of the distance and its derivatives in a box."""
    numbers = doubles_at(address)
    x, y, z = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high), 0.5 * (z_low + z_high)
    hx, hy, hz = 0.5 * (x_high - x_low), 0.5 * (y_high - y_low), 0.5 * (z_high - z_low)
    radius = math.sqrt(hx * hx + hy * hy + hz * hz)
    if not radius < math.inf:
        return -math.inf, math.inf, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0
    distance, _, _, _, _ = _nearest(numbers, x, y, z)
    if not distance < math.inf:
        return -math.inf, math.inf, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0
    margin = 1e-9 * (abs(distance) + radius)
    low, high = distance - radius - margin, distance + radius + margin
    reach = high + radius
    ax, bx, ay, by, az, bz = math.inf, -math.inf, math.inf, -math.inf, math.inf, -math.inf
    stack = stack_array(64)
    leaves, segments = int(numbers[0]), int(numbers[1])
    stack[0] = 1.0
    depth, found = 1, 0
    while depth > 0:
        depth -= 1
        node = int(stack[depth])
        if _to_box(numbers, node, x, y, z) > reach:
            continue
        if node < leaves:
            stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
            depth += 2
            continue
        for row in range(4):
            at = segments + (4 * (node - leaves) + row) * 9
            value, dx, dy, dz = _to_segment(numbers, at, x, y, z)
            if value > reach:
                continue
            found += 1
            if found > 24:
                return low, high, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0
            # The vector from the nearest centre changes no faster than this with the point.
            k = numbers[at + 8]
            spread = radius
            if 0.0 < abs(k) < 1.0:
                spread *= 1.0 + abs(k) / math.sqrt(1.0 - k * k)
            a, b = _axis(dx - spread, dx + spread, dy - spread, dy + spread, dz - spread, dz + spread)
            ax, bx = min(ax, a), max(bx, b)
            a, b = _axis(dy - spread, dy + spread, dx - spread, dx + spread, dz - spread, dz + spread)
            ay, by = min(ay, a), max(by, b)
            a, b = _axis(dz - spread, dz + spread, dx - spread, dx + spread, dy - spread, dy + spread)
            az, bz = min(az, a), max(bz, b)
    margin = 1e-9
    return (
        low,
        high,
        max(ax - margin, -1.0),
        min(bx + margin, 1.0),
        max(ay - margin, -1.0),
        min(by + margin, 1.0),
        max(az - margin, -1.0),
        min(bz + margin, 1.0),
    )


_GLSL = """\
float tube_box(int at, vec3 p)
{
    vec3 low = vec3(table_number(at), table_number(at + 1), table_number(at + 2));
    vec3 high = vec3(table_number(at + 3), table_number(at + 4), table_number(at + 5));
    vec3 d = max(low - p, p - high);
    return length(max(d, 0.0)) + min(max(max(d.x, d.y), d.z), 0.0);
}

vec3 tube_nearest(int table, vec3 point)
{
    int stack[40];
    float distances[40];
    int leaves = int(table_number(table));
    int segments = table + int(table_number(table + 1));
    vec3 best = vec3(1e30, 0.0, 0.0);
    int depth = 1;
    stack[0] = 1;
    distances[0] = -1e30;
    while (depth > 0) {
        depth--;
        int node = stack[depth];
        if (distances[depth] >= best.x) {
            continue;
        }
        if (node < leaves) {
            {descent}
        }
        int at = segments + (node - leaves) * 36;
        for (int row = 0; row < 4; row++) {
            vec3 p = point - vec3(table_number(at), table_number(at + 1), table_number(at + 2));
            vec3 u = vec3(table_number(at + 4), table_number(at + 5), table_number(at + 6));
            float taper = table_number(at + 8);
            float along = dot(p, u);
            float s = along - taper * length(p - along * u) / sqrt(max(1.0 - taper * taper, 1e-12));
            s = abs(taper) >= 1.0 ? (taper < 0.0 ? 1e30 : -1e30) : s;
            s = min(max(s, 0.0), table_number(at + 7));
            float found = length(p - s * u) - (table_number(at + 3) - taper * s);
            if (found < best.x) {
                best = vec3(found, float((at - segments) / 9), s);
            }
            at += 9;
        }
    }
    return best;
}

float tube(int table, float x, float y, float z)
{
    return tube_nearest(table, vec3(x, y, z)).x;
}
""".replace("{descent}", boxes.descent("tube_box", 6, "point"))

_ALONG_GLSL = """\
float tube_along(int table, float x, float y, float z)
{
    vec3 nearest = tube_nearest(table, vec3(x, y, z));
    int row = int(nearest.y);
    int segments = table + int(table_number(table + 1));
    float size = table_number(segments + 9 * row + 7);
    int place = segments + 36 * int(table_number(table)) + 2 * row;
    return mix(table_number(place), table_number(place + 1), size > 0.0 ? clamp(nearest.z / size, 0.0, 1.0) : 0.0);
}
"""

TUBE = TableFunction(
    "tube",
    tube_distance,
    bounds=Function("tube_bounds", tube_bounds, results=8),
    derivatives=Function("tube_slope", tube_slope, results=3),
    lipschitz=1.0,
    glsl=_GLSL,
    operations=200.0,
)


TUBE_ALONG = TableFunction(
    "tube_along",
    tube_along,
    bounds=Function("tube_along_bounds", tube_along_bounds, results=8),
    glsl=_ALONG_GLSL,
    needs=(TUBE,),
    operations=200.0,
)


def tube_table(segments: np.ndarray, along: np.ndarray | None = None) -> Table:
    """Table of segments (n, 8): x, y, z and radius of both ends. A segment may be a point, a ball.

    ``along`` (n, 2) says how far along its path each end is; without it, the segments are one path.
    Raises ValueError without a segment.
    """
    segments = np.asarray(segments, np.float64).reshape(-1, 8)
    if not len(segments):
        raise ValueError("a tube needs a segment")
    start, end, radius, last = segments[:, :3], segments[:, 4:7], segments[:, 3], segments[:, 7]
    lengths = np.linalg.norm(end - start, axis=1)
    whole = lengths > 0.0
    radius = np.where(whole, radius, np.maximum(radius, last))
    with np.errstate(all="ignore"):
        direction = np.where(whole[:, None], (end - start) / lengths[:, None], [1.0, 0.0, 0.0])
        k = np.where(whole, (radius - last) / lengths, 0.0)
    low = np.minimum(start - radius[:, None], end - last[:, None])
    high = np.maximum(start + radius[:, None], end + last[:, None])
    if along is None:
        along = _along(lengths)
    order, nodes = boxes.tree(low, high)
    rows = np.column_stack([start, radius, direction, lengths, k])[order]
    head = [len(nodes) // 2, _HEAD + nodes.size]
    return table(np.concatenate([head, nodes.ravel(), rows.ravel(), along[order].ravel()]))


def _along(lengths: np.ndarray) -> np.ndarray:
    """Parts (n, 2) of the length of a path at both ends of its segments of these lengths (n,)."""
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    ends = ends / ends[-1] if ends[-1] > 0.0 else np.zeros_like(ends)
    return np.column_stack([ends[:-1], ends[1:]])


@frozen
class Tube(Shape, abstract=True):
    """A round tube along curves, whose radius may change: all balls along them. The distance is exact outside."""

    exactness = BOUND

    data: Table = dataclasses.field(metadata=dict(description="its segments, see ``tube_table``"))

    @classmethod
    def of(cls, paths: Sequence[tuple[np.ndarray, np.ndarray | float, bool]]) -> "Tube":
        """The tube along paths: points (n, 3), their radii (n,) or one radius, and whether the path is closed."""
        parts, along = [], []
        for points, radii, closed in paths:
            ends = np.column_stack([points, np.broadcast_to(radii, len(points))])
            if closed and len(ends) > 2:
                ends = np.concatenate([ends, ends[:1]])
            parts.append(np.column_stack([ends[:-1], ends[1:]] if len(ends) > 1 else [ends, ends]))
            along.append(_along(np.linalg.norm(parts[-1][:, 4:7] - parts[-1][:, :3], axis=1)))
        if not parts:
            return cls(tube_table(np.zeros((0, 8))))
        return cls(tube_table(np.concatenate(parts), np.concatenate(along)))

    @property
    def exact_outside(self) -> bool:
        return True

    @cached_property
    def balls(self) -> np.ndarray:
        """Centres and radii (n, 4) of the balls at the ends of all segments."""
        numbers = self.data.array
        rows = numbers[int(numbers[1]) :][: 4 * _ROW * int(numbers[0])].reshape(-1, _ROW)
        ends = rows[:, :3] + rows[:, 7:8] * rows[:, 4:7]
        return np.unique(
            np.concatenate([rows[:, :4], np.column_stack([ends, rows[:, 3] - rows[:, 8] * rows[:, 7]])]), axis=0
        )

    def build(self, p: Vector, slot: Slots) -> Formula:
        (distance,) = call(TUBE, slot(self.data.address), *p)
        return distance

    def along(self, p: Vector, slot: Slots) -> Formula:
        (along,) = call(TUBE_ALONG, slot(self.data.address), *p)
        return along

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        matrix = np.eye(4) if matrix is None else matrix
        centers = self.balls[:, :3] @ matrix[:3, :3].T + matrix[:3, 3]
        reach = self.balls[:, 3:] * np.linalg.norm(matrix[:3, :3], axis=1)
        return (centers - reach).min(axis=0), (centers + reach).max(axis=0)

    def relation(self) -> str:
        if not (np.isfinite(self.balls).all() and np.abs(self.balls).max() <= LARGEST):
            return f"Tube: a point is not within {LARGEST:g} m of the origin: move it nearer."
        if not self.balls[:, 3].max() >= SMALLEST:
            return "Tube: its radius is zero everywhere: give the curve a bevel depth, or the lamp a radius."
        return ""


def with_gap(points: np.ndarray, gap: float) -> np.ndarray:
    """A closed path (n, 3), opened where it begins: what is left (m, 3) when ``gap`` of its length is taken out there.

    All of it but the gap, as sign makers bend a tube; a tenth of it stays where the gap would be longer.
    """
    ends = np.concatenate([points, points[:1]])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    gap = min(gap, 0.9 * lengths[-1])
    start, stop = 0.5 * gap, lengths[-1] - 0.5 * gap
    inner = (lengths > start) & (lengths < stop)
    cut = np.array([[np.interp(place, lengths, ends[:, axis]) for axis in range(3)] for place in (start, stop)])
    return np.concatenate([cut[:1], ends[inner], cut[1:]])
