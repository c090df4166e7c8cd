# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance to triangles, and which side of them a point is on, by a tree of boxes.

Sides are told by the generalised winding number (Jacobson, Kavan and Sorkine 2013), which holes, cracks, doubled and
crossing faces hardly disturb. Far parts of the tree count as dipoles and quadrupoles (Barill, Dickson, Schmidt, Levin
and Jacobson 2018).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...jit import kernel, stack_array
from . import boxes

FAR = 2.5  # radii of a part, from which on its moments stand for it: errors of some hundredths of a winding at most
SLACK = 1.0 + 1e-9  # of what is searched, so that rounding leaves the nearest triangle in it


class Triangles(NamedTuple):
    """Triangles in the order of a tree (see ``boxes.tree``), without those that have no area."""

    corners: np.ndarray  # (LEAF · leaves, 10): three corners, and 1, or 0 of a triangle that is there again
    nodes: np.ndarray  # (2 leaves, 6)
    moments: np.ndarray
    """(2 leaves, 13) of the nodes: the centre, the square of ``FAR`` radii, the sum of areas times normals, and xx, xy, xz, yy,
    yz, zz of the symmetric part, without trace, of the sum of places from the centre times areas times normals."""
    closed: bool  # whether each edge has as many triangles on one side as on the other


def triangles(vertices: np.ndarray, faces: np.ndarray) -> Triangles:
    """The tree of a mesh with vertices (n, 3) and triangles (m, 3). Raises ValueError if no triangle has an area."""
    found = vertices[faces].astype(np.float64)
    normals = 0.5 * np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    kept = areas > 0.0
    if not kept.any():
        raise ValueError("no triangle has an area")
    closed = bool(kept.all()) and _is_closed(faces)
    found, normals = found[kept], normals[kept]
    order, nodes = boxes.tree(found.min(axis=1), found.max(axis=1))
    leaves = len(nodes) // 2
    once = np.zeros(len(order))
    once[np.unique(order, return_index=True)[1]] = 1.0  # a triangle that is there again has no weight
    corners = np.column_stack([found[order].reshape(-1, 9), once])
    moments = np.empty((2 * leaves, 13))
    _find_moments(corners, normals[order], nodes, np.zeros((2 * leaves, 16)), moments)
    return Triangles(corners, nodes, moments, closed)


@kernel
def _find_moments(corners, normals, nodes, sums, moments):
    """Fill ``moments`` of ``Triangles``. ``normals`` (LEAF · leaves, 3) are as long as the areas of the triangles.
    ``sums`` (2 leaves, 16), zero, is for each node the area; area times centre; area times normal; and centre times
    area times normal."""
    leaves = len(nodes) // 2
    for row in range(len(corners)):
        if corners[row, 9] == 0.0:
            continue
        into = sums[leaves + row // boxes.LEAF]
        a, b, c, flux = corners[row, 0:3], corners[row, 3:6], corners[row, 6:9], normals[row]
        area = math.sqrt(flux[0] * flux[0] + flux[1] * flux[1] + flux[2] * flux[2])
        into[0] += area
        for i in range(3):
            place = (a[i] + b[i] + c[i]) / 3.0
            into[1 + i] += area * place
            into[4 + i] += flux[i]
            for j in range(3):
                into[7 + 3 * i + j] += place * flux[j]
    for node in range(leaves - 1, 0, -1):
        for k in range(16):
            sums[node, k] = sums[2 * node, k] + sums[2 * node + 1, k]
    for node in range(2 * leaves):
        own, found, area, farthest, trace = sums[node], moments[node], sums[node, 0], 0.0, 0.0
        for i in range(3):
            low, high = nodes[node, i], nodes[node, 3 + i]
            found[i], found[4 + i] = own[1 + i] / area if area > 0.0 else 0.5 * (low + high), own[4 + i]
            reach = max(abs(low - found[i]), abs(high - found[i]))
            farthest += reach * reach
            trace += (own[7 + 4 * i] - found[i] * own[4 + i]) / 3.0
        found[3] = FAR * FAR * farthest if area > 0.0 else -1.0  # parts without triangles add nothing
        place = 7
        for i in range(3):
            for j in range(i, 3):
                first, second = own[7 + 3 * i + j] - found[i] * own[4 + j], own[7 + 3 * j + i] - found[j] * own[4 + i]
                found[place] = 0.5 * (first + second) - (trace if i == j else 0.0)
                place += 1


def _is_closed(faces: np.ndarray) -> bool:
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, edges = np.unique(low * (int(ends.max()) + 1) + high, return_inverse=True)
    return not np.bincount(edges.ravel(), np.where(ends[:, 0] == low, 1.0, -1.0)).any()


@kernel
def _to_box(nodes, node, x, y, z):
    """Square of the distance to a node's box."""
    dx = max(max(nodes[node, 0] - x, x - nodes[node, 3]), 0.0)
    dy = max(max(nodes[node, 1] - y, y - nodes[node, 4]), 0.0)
    dz = max(max(nodes[node, 2] - z, z - nodes[node, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@kernel
def _to_triangle(corners, row, x, y, z):
    """Square of the distance to a triangle (Ericson, Real-Time Collision Detection, section 5.1.5)."""
    ax, ay, az = corners[row, 0], corners[row, 1], corners[row, 2]
    ux, uy, uz = corners[row, 3] - ax, corners[row, 4] - ay, corners[row, 5] - az
    vx, vy, vz = corners[row, 6] - ax, corners[row, 7] - ay, corners[row, 8] - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        s, t = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        s, t = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        s, t = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s, t = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s, t = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - t
    else:
        whole = va + vb + vc
        s, t = vb / whole, vc / whole
    px, py, pz = px - s * ux - t * vx, py - s * uy - t * vy, pz - s * uz - t * vz
    return px * px + py * py + pz * pz


@kernel
def nearest(corners, nodes, x, y, z, most, guess):
    """Distance to the nearest triangle, and its row; the distance is above ``most`` where none is as near.

    ``guess`` is the row of a triangle that may be near.
    """
    stack = stack_array(96)
    leaves = len(nodes) // 2
    best, found = _to_triangle(corners, guess, x, y, z), guess
    if best > most * most:
        best = most * most * 1.000001
    depth, node = 0, 1
    distance = _to_box(nodes, 1, x, y, z)
    while True:
        if distance < best * SLACK:
            if node < leaves:
                near, far = 2 * node, 2 * node + 1
                d_near, d_far = _to_box(nodes, near, x, y, z), _to_box(nodes, far, x, y, z)
                if d_far < d_near:
                    near, far, d_near, d_far = far, near, d_far, d_near
                if d_far < best * SLACK:
                    stack[depth], stack[depth + 1] = far, d_far
                    depth += 2
                node, distance = near, d_near
                continue
            row = 4 * (node - leaves)
            for index in range(row, row + 4):
                square = _to_triangle(corners, index, x, y, z)
                if square < best:
                    best, found = square, index
        if depth == 0:
            return math.sqrt(best), found
        depth -= 2
        node, distance = int(stack[depth]), stack[depth + 1]


@kernel(forceinline=True)
def _angle(corners, row, x, y, z):
    """A complex number, as two, whose phase is half of the solid angle of a triangle, with the sign of its side
    (Van Oosterom and Strackee 1983)."""
    ax, ay, az = corners[row, 0] - x, corners[row, 1] - y, corners[row, 2] - z
    bx, by, bz = corners[row, 3] - x, corners[row, 4] - y, corners[row, 5] - z
    cx, cy, cz = corners[row, 6] - x, corners[row, 7] - y, corners[row, 8] - z
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    rest = a * b * c
    rest += (ax * bx + ay * by + az * bz) * c + (bx * cx + by * cy + bz * cz) * a + (cx * ax + cy * ay + cz * az) * b
    return rest, volume


@kernel
def winding(corners, nodes, moments, x, y, z):
    """How often the triangles wind around a point."""
    stack = stack_array(96)
    leaves = len(nodes) // 2
    stack[0] = 1.0
    depth, total = 1, 0.0
    while depth > 0:
        depth -= 1
        node = int(stack[depth])
        reach = moments[node, 3]
        if reach < 0.0:
            continue
        dx, dy, dz = moments[node, 0] - x, moments[node, 1] - y, moments[node, 2] - z
        square = dx * dx + dy * dy + dz * dz
        if square > reach:
            flux = dx * moments[node, 4] + dy * moments[node, 5] + dz * moments[node, 6]
            second = dx * (dx * moments[node, 7] + 2.0 * (dy * moments[node, 8] + dz * moments[node, 9]))
            second += dy * (dy * moments[node, 10] + 2.0 * dz * moments[node, 11]) + dz * dz * moments[node, 12]
            total += 0.5 * (flux - 3.0 * second / square) / (square * math.sqrt(square))
        elif node < leaves:
            stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
            depth += 2
        else:
            row = 4 * (node - leaves)
            real, imaginary = 1.0, 0.0
            for index in range(row, row + 4):
                if corners[index, 9] > 0.0:
                    rest, volume = _angle(corners, index, x, y, z)
                    # The phases of four such small ones, as of most, add up within half a turn.
                    if rest > abs(volume):
                        slope = volume / rest
                        real, imaginary = real - imaginary * slope, real * slope + imaginary
                    else:
                        total += math.atan2(volume, rest)
            total += math.atan2(imaginary, real)
    return total / (2.0 * math.pi)
