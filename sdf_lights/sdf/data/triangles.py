# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance to triangles, and which side of them a point is on, by a tree of boxes.

Sides are told by the generalised winding number (Jacobson, Kavan and Sorkine 2013), which holes, cracks, doubled and
crossing faces hardly disturb. Far parts of the tree count as dipoles and quadrupoles (Barill, Dickson, Schmidt, Levin
and Jacobson 2018).
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ...jit import kernel, stack_array
from . import boxes
from .open_edges import open_edges

FAR = 2.5  # radii of a part, from which on its moments stand for it: errors of some hundredths of a winding at most
NO_AREA = 1e-32  # squares of areas over those of edges that are not distinct from rounding
SLACK = 1.0 + 1e-9  # of what is searched, so that rounding leaves the nearest triangle in it


class Triangles(NamedTuple):
    """Triangles in the order of a tree (see ``boxes.tree``), without those that have no area.

    Four triangles of a leaf, and four nodes, are lanes of the processor's vectors: they are last in these arrays. Row n
    of ``nodes`` and ``moments`` has the nodes 4 n to 4 n + 3, the grandchildren of node n.
    """

    corners: np.ndarray
    """(leaves, 14, LEAF): three corners; 1, or 0 of a triangle that is there again; one over the squares of the edges
    from the first corner to the second and third, of that between these, and of twice the area."""
    nodes: np.ndarray  # (leaves / 2, 6, 4): boxes
    moments: np.ndarray
    """(leaves / 2, 13, 4): the centre, the square of ``FAR`` radii, the sum of areas times normals, and xx, xy, xz, yy,
    yz, zz of the symmetric part, without trace, of the sum of places from the centre times areas times normals."""
    disks: np.ndarray
    """(leaves / 4, 8, 4): what encloses a leaf more closely, as it is nearly flat: a cylinder's middle, axis, half
    height and radius. Row n is for the leaves 4 n to 4 n + 3."""
    rim: np.ndarray  # open edges as triangles without area, like ``corners``; there may be none
    rim_nodes: np.ndarray  # their boxes, like ``nodes``
    rim_disks: np.ndarray  # like ``disks``


def triangles(vertices: np.ndarray, faces: np.ndarray) -> Triangles:
    """The tree of a mesh with vertices (n, 3) and triangles (m, 3). Raises ValueError if no triangle has an area."""
    vertices = np.ascontiguousarray(vertices, np.float64)
    with ThreadPoolExecutor(1) as pool:  # kernels let another thread run
        rim = pool.submit(_rim, vertices, faces)
        corners, normals, nodes = _in_a_tree(vertices, faces, True)
        moments = np.empty((len(nodes), 13))
        _find_moments(corners, normals, nodes, np.zeros((len(nodes), 16)), moments)
        return Triangles(corners, _in_lanes(nodes), _in_lanes(moments), _disks(corners), *rim.result())


def _rim(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The last fields of ``Triangles``."""
    edges = open_edges(vertices, faces)
    if not len(edges):
        return np.empty((0, 14, boxes.LEAF)), np.empty((0, 6, 4)), np.empty((0, 8, 4))
    rim, _, nodes = _in_a_tree(edges.reshape(-1, 3), 2 * np.arange(len(edges))[:, None] + [0, 1, 0], False)
    return rim, _in_lanes(nodes), _disks(rim)


def _in_a_tree(vertices: np.ndarray, faces: np.ndarray, with_area: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``corners`` of ``Triangles``, of all triangles or those ``with_area``; normals (LEAF · leaves, 3) as long as
    areas, and the boxes of nodes (2 leaves, 6)."""
    found = np.empty((len(faces), 3, 3))
    normals, low, high = (np.empty((len(faces), 3)) for _ in range(3))
    count = _gather(vertices, np.ascontiguousarray(faces, np.int64), with_area, found, normals, low, high)
    if not count:
        raise ValueError("no triangle has an area")
    order, nodes = boxes.tree(low[:count], high[:count])
    corners = np.empty((len(order) // boxes.LEAF, 14, boxes.LEAF))
    _find_corners(found, normals, order, np.ones(count), corners)
    return corners, normals[order], nodes


@kernel
def _gather(vertices, faces, with_area, found, normals, low, high):
    """Fill corners (n, 3, 3), normals as long as areas, and boxes of triangles; their number."""
    count = 0
    for row in range(len(faces)):
        for i in range(3):
            a, b, c = vertices[faces[row, 0], i], vertices[faces[row, 1], i], vertices[faces[row, 2], i]
            found[count, 0, i], found[count, 1, i], found[count, 2, i] = a, b, c
            low[count, i], high[count, i] = min(min(a, b), c), max(max(a, b), c)
        own, area, uu, vv = found[count], 0.0, 0.0, 0.0
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            normals[count, i] = 0.5 * (own[1, j] - own[0, j]) * (own[2, k] - own[0, k])
            normals[count, i] -= 0.5 * (own[1, k] - own[0, k]) * (own[2, j] - own[0, j])
            area += normals[count, i] * normals[count, i]
            uu += (own[1, i] - own[0, i]) * (own[1, i] - own[0, i])
            vv += (own[2, i] - own[0, i]) * (own[2, i] - own[0, i])
        if not with_area or area > NO_AREA * uu * vv:
            count += 1
    return count


def _disks(corners: np.ndarray) -> np.ndarray:
    rows = np.empty((len(corners), 8))
    _find_disks(corners, rows)
    return _in_lanes(rows)


def _in_lanes(rows: np.ndarray) -> np.ndarray:
    """Rows (n, k) of nodes as (n / 4, k, 4)."""
    whole = 4 * (len(rows) // 4)
    return np.ascontiguousarray(rows[:whole].reshape(whole // 4, 4, rows.shape[1]).transpose(0, 2, 1))


@kernel
def _find_corners(found, normals, order, once, corners):
    """Fill ``corners`` of ``Triangles``. ``once`` has a 1 for each triangle."""
    for row in range(len(order)):
        own, leaf, t, squares = order[row], row // boxes.LEAF, row % boxes.LEAF, stack_array(4)
        squares[0], squares[1], squares[2], squares[3] = 0.0, 0.0, 0.0, 0.0
        for i in range(3):
            a, b, c = found[own, 0, i], found[own, 1, i], found[own, 2, i]
            corners[leaf, i, t], corners[leaf, 3 + i, t], corners[leaf, 6 + i, t] = a, b, c
            squares[0] += (b - a) * (b - a)
            squares[1] += (c - a) * (c - a)
            squares[2] += (c - b) * (c - b)
            squares[3] += 4.0 * normals[own, i] * normals[own, i]
        for i in range(4):
            inverse = 1.0 / squares[i]
            # Where there is no length, the foot of a perpendicular is the edge's first end.
            corners[leaf, 10 + i, t] = inverse if inverse < 1e300 else 0.0
        corners[leaf, 9, t], once[own] = once[own], 0.0  # one that is there again has no weight


@kernel
def _find_disks(corners, disks):
    """``disks`` (leaves, 8) of ``Triangles``. The axis is that of the sum of the normals; without one, the cylinder is
    a ball."""
    low, high, axis = stack_array(3), stack_array(3), stack_array(3)
    for leaf in range(len(corners)):
        own, disk = corners[leaf], disks[leaf]
        for i in range(3):
            low[i], high[i], axis[i] = math.inf, -math.inf, 0.0
        for t in range(boxes.LEAF):
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                axis[i] += (own[3 + j, t] - own[j, t]) * (own[6 + k, t] - own[k, t])
                axis[i] -= (own[3 + k, t] - own[k, t]) * (own[6 + j, t] - own[j, t])
                for corner in range(3):
                    place = own[3 * corner + i, t]
                    low[i], high[i] = min(low[i], place), max(high[i], place)
        length = math.sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2])
        for i in range(3):
            disk[i], disk[3 + i] = 0.5 * (low[i] + high[i]), axis[i] / length if length > 0.0 else 0.0
        height, radius = 0.0, 0.0
        for t in range(boxes.LEAF):
            for corner in range(3):
                along, square = 0.0, 0.0
                for i in range(3):
                    d = own[3 * corner + i, t] - disk[i]
                    along, square = along + d * disk[3 + i], square + d * d
                height, radius = max(height, abs(along)), max(radius, square - along * along)
        disk[6], disk[7] = height, math.sqrt(radius)


@kernel
def _find_moments(corners, normals, nodes, sums, moments):
    """Moments (2 leaves, 13) of the nodes (2 leaves, 6). ``normals`` (LEAF · leaves, 3) are as long as the areas of the
    triangles. ``sums`` (2 leaves, 16), zero, is for each node the area; area times centre; area times normal; and
    centre times area times normal."""
    leaves = len(nodes) // 2
    for row in range(len(normals)):
        leaf, t = row // boxes.LEAF, row % boxes.LEAF
        if corners[leaf, 9, t] == 0.0:
            continue
        into, own, flux = sums[leaves + leaf], corners[leaf], normals[row]
        area = math.sqrt(flux[0] * flux[0] + flux[1] * flux[1] + flux[2] * flux[2])
        into[0] += area
        for i in range(3):
            place = (own[i, t] + own[3 + i, t] + own[6 + i, t]) / 3.0
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


@kernel(forceinline=True)
def _to_boxes(nodes, row, x, y, z, squares):
    """Squares of the distances to the boxes of four nodes."""
    for t in range(4):
        dx = max(max(nodes[row, 0, t] - x, x - nodes[row, 3, t]), 0.0)
        dy = max(max(nodes[row, 1, t] - y, y - nodes[row, 4, t]), 0.0)
        dz = max(max(nodes[row, 2, t] - z, z - nodes[row, 5, t]), 0.0)
        squares[t] = dx * dx + dy * dy + dz * dz


@kernel(forceinline=True)
def _to_disks(disks, row, x, y, z, squares):
    """Squares of the distances to the cylinders of four leaves, where these are greater than ``squares``."""
    for t in range(4):
        dx, dy, dz = x - disks[row, 0, t], y - disks[row, 1, t], z - disks[row, 2, t]
        along = dx * disks[row, 3, t] + dy * disks[row, 4, t] + dz * disks[row, 5, t]
        across = math.sqrt(max(dx * dx + dy * dy + dz * dz - along * along, 0.0))
        above, beside = max(abs(along) - disks[row, 6, t], 0.0), max(across - disks[row, 7, t], 0.0)
        squares[t] = max(squares[t], above * above + beside * beside)


@kernel(forceinline=True)
def _to_leaf(corners, leaf, x, y, z, squares):
    """Squares of the distances to four triangles: each the least of those to the edges, and to the plane if the foot of
    the perpendicular is within. So rounding in a thin triangle leaves the distance to one of its points."""
    for t in range(4):
        ax, ay, az = corners[leaf, 0, t], corners[leaf, 1, t], corners[leaf, 2, t]
        ux, uy, uz = corners[leaf, 3, t] - ax, corners[leaf, 4, t] - ay, corners[leaf, 5, t] - az
        vx, vy, vz = corners[leaf, 6, t] - ax, corners[leaf, 7, t] - ay, corners[leaf, 8, t] - az
        px, py, pz = x - ax, y - ay, z - az
        pu, pv = px * ux + py * uy + pz * uz, px * vx + py * vy + pz * vz
        uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
        s = min(max(pu * corners[leaf, 10, t], 0.0), 1.0)
        dx, dy, dz = px - s * ux, py - s * uy, pz - s * uz
        square = dx * dx + dy * dy + dz * dz
        s = min(max(pv * corners[leaf, 11, t], 0.0), 1.0)
        dx, dy, dz = px - s * vx, py - s * vy, pz - s * vz
        square = min(square, dx * dx + dy * dy + dz * dz)
        s = min(max((pv - pu + uu - uv) * corners[leaf, 12, t], 0.0), 1.0)
        dx, dy, dz = px - ux - s * (vx - ux), py - uy - s * (vy - uy), pz - uz - s * (vz - uz)
        square = min(square, dx * dx + dy * dy + dz * dz)
        s, r = (vv * pu - uv * pv) * corners[leaf, 13, t], (uu * pv - uv * pu) * corners[leaf, 13, t]
        dx, dy, dz = px - s * ux - r * vx, py - s * uy - r * vy, pz - s * uz - r * vz
        plane = dx * dx + dy * dy + dz * dz
        squares[t] = min(square, plane) if min(min(s, r), 1.0 - s - r) >= 0.0 else square


@kernel(forceinline=True)
def begin(leaves, stack, step):
    """Put the first nodes, of whose grandchildren all others are, on a stack with ``step`` numbers for each; how many
    numbers that are."""
    levels, left = 0, leaves
    while left > 1:
        left //= 2
        levels += 1
    if levels % 2 == 0:
        stack[0] = 1.0
        return step
    stack[0], stack[step] = 3.0, 2.0
    return 2 * step


@kernel
def nearest(corners, nodes, disks, x, y, z, most, guess):
    """Distance to the nearest triangle, and its leaf; the distance is above ``most`` where none is as near.

    ``guess`` is a leaf that may be near.
    """
    stack, squares = stack_array(192), stack_array(4)
    leaves = len(corners)
    best, found = most * most * 1.000001, guess
    _to_leaf(corners, guess, x, y, z, squares)
    for t in range(4):
        best = min(best, squares[t])
    depth = begin(leaves, stack, 2)
    stack[1], stack[3] = 0.0, 0.0
    while depth > 0:
        depth -= 2
        if not stack[depth + 1] < best * SLACK:
            continue
        node = int(stack[depth])
        if node < leaves:
            _to_boxes(nodes, node, x, y, z, squares)
            if 4 * node >= leaves:
                _to_disks(disks, node - leaves // 4, x, y, z, squares)
            first = depth
            for t in range(4):
                square = squares[t]
                if square < best * SLACK:
                    # The nearest one is on top.
                    at = depth
                    while at > first and stack[at - 1] < square:
                        stack[at], stack[at + 1] = stack[at - 2], stack[at - 1]
                        at -= 2
                    stack[at], stack[at + 1] = 4 * node + t, square
                    depth += 2
        else:
            _to_leaf(corners, node - leaves, x, y, z, squares)
            for t in range(4):
                if squares[t] < best:
                    best, found = squares[t], node - leaves
    return math.sqrt(best), found


@kernel(forceinline=True)
def _angles(corners, leaf, x, y, z, real, imaginary):
    """For each of four triangles a complex number, whose phase is half of its solid angle, with the sign of its side
    (Van Oosterom and Strackee 1983)."""
    for t in range(4):
        ax, ay, az = corners[leaf, 0, t] - x, corners[leaf, 1, t] - y, corners[leaf, 2, t] - z
        bx, by, bz = corners[leaf, 3, t] - x, corners[leaf, 4, t] - y, corners[leaf, 5, t] - z
        cx, cy, cz = corners[leaf, 6, t] - x, corners[leaf, 7, t] - y, corners[leaf, 8, t] - z
        a = math.sqrt(ax * ax + ay * ay + az * az)
        b = math.sqrt(bx * bx + by * by + bz * bz)
        c = math.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        rest = a * b * c
        rest += (
            (ax * bx + ay * by + az * bz) * c + (bx * cx + by * cy + bz * cz) * a + (cx * ax + cy * ay + cz * az) * b
        )
        weight = corners[leaf, 9, t]
        real[t], imaginary[t] = rest * weight + (1.0 - weight), volume * weight


@kernel(forceinline=True)
def _far_parts(moments, row, x, y, z, share, parts, near):
    """For each of four nodes 4 π times how often it winds around a point, and whether it is too near for that (1)."""
    for t in range(4):
        dx, dy, dz = moments[row, 0, t] - x, moments[row, 1, t] - y, moments[row, 2, t] - z
        square, reach = dx * dx + dy * dy + dz * dz, moments[row, 3, t]
        flux = dx * moments[row, 4, t] + dy * moments[row, 5, t] + dz * moments[row, 6, t]
        second = dx * (dx * moments[row, 7, t] + 2.0 * (dy * moments[row, 8, t] + dz * moments[row, 9, t]))
        second += dy * (dy * moments[row, 10, t] + 2.0 * dz * moments[row, 11, t]) + dz * dz * moments[row, 12, t]
        part = (flux * square - 3.0 * second) / (square * square * math.sqrt(square))
        is_far = square > share * reach
        parts[t] = part if is_far and reach >= 0.0 else 0.0
        near[t] = 0.0 if is_far else 1.0


@kernel
def winding(corners, moments, x, y, z, share):
    """How often the triangles wind around a point. Moments stand for nodes from a ``share`` of the square of ``FAR``
    radii on."""
    stack, first, second = stack_array(96), stack_array(4), stack_array(4)
    leaves = len(corners)
    depth, total = begin(leaves, stack, 1), 0.0
    while depth > 0:
        depth -= 1
        node = int(stack[depth])
        if node < leaves:
            _far_parts(moments, node, x, y, z, share, first, second)
            for t in range(4):
                total += 0.5 * first[t]
                if second[t] > 0.0:
                    stack[depth] = 4 * node + t
                    depth += 1
        else:
            _angles(corners, node - leaves, x, y, z, first, second)
            real, imaginary = 1.0, 0.0
            for t in range(4):
                # The phases of four such small ones, as of most, add up within half a turn.
                if first[t] > abs(second[t]):
                    slope = second[t] / first[t]
                    real, imaginary = real - imaginary * slope, real * slope + imaginary
                else:
                    total += math.atan2(second[t], first[t])
            total += math.atan2(imaginary, real)
    return total / (2.0 * math.pi)
