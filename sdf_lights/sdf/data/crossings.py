# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How often the lines of a lattice of points cross triangles.

The winding number changes by one at a face, and smoothly elsewhere: fast near open edges only. So one winding number
and the crossings between points give those of many points.
"""

from __future__ import annotations

import math

from ...jit import kernel, stack_array
from .triangles import begin


@kernel
def _of_triangle(places, axis, crossings):
    """Count crossings of a triangle with lines along an axis, at whole numbers of the others. Coordinates of its
    corners are ``places`` (9): three along x, three along y, three along z."""
    m, u, v, w = crossings.shape[1], 3 * axis, 3 * ((axis + 1) % 3), 3 * ((axis + 2) % 3)
    low = min(min(places[v], places[v + 1]), places[v + 2])
    high = max(max(places[v], places[v + 1]), places[v + 2])
    # A corner at j belongs to the side above it, for all triangles: so a line passes each closed mesh once.
    for j in range(int(max(math.ceil(low), 0.0)), int(min(math.ceil(high), float(m)))):
        up_w, up_u, down_w, down_u = 0.0, 0.0, 0.0, 0.0
        for p in range(3):
            q = (p + 1) % 3
            is_up = places[v + p] <= j
            if is_up != (places[v + q] <= j):
                # The same numbers for both triangles of an edge.
                first, second = (p, q) if is_up else (q, p)
                t = (j - places[v + first]) / (places[v + second] - places[v + first])
                at_w = places[w + first] + t * (places[w + second] - places[w + first])
                at_u = places[u + first] + t * (places[u + second] - places[u + first])
                if is_up:
                    up_w, up_u = at_w, at_u
                else:
                    down_w, down_u = at_w, at_u
        sign = -1 if up_w < down_w else 1
        least, most = min(up_w, down_w), max(up_w, down_w)
        for k in range(int(max(math.ceil(least), 0.0)), int(min(math.ceil(most), float(m)))):
            place = up_u + (k - up_w) / (down_w - up_w) * (down_u - up_u)
            if 0.0 <= place < m - 1.0:
                i = int(place) + 1
                if axis == 0:
                    crossings[0, k, j, i] += sign
                elif axis == 1:
                    crossings[1, j, i, k] += sign
                else:
                    crossings[2, i, k, j] += sign


@kernel
def find_crossings(corners, nodes, x, y, z, spacing, crossings):
    """Fill ``crossings`` (3, m, m, m): by how much faces between the first point of a line of the lattice and another
    one make the winding number greater, for lines along x, y and z. Points are [.., z, y, x].

    The lattice begins at x, y, z.
    """
    m = crossings.shape[1]
    crossings[:] = 0
    stack, places = stack_array(96), stack_array(9)
    leaves, side, any_faces = len(corners), (m - 1) * spacing, False
    depth = begin(leaves, stack, 1)
    while depth > 0:
        depth -= 1
        node = int(stack[depth])
        if node < leaves:
            for t in range(4):
                if (
                    nodes[node, 0, t] <= x + side and nodes[node, 3, t] >= x
                    and nodes[node, 1, t] <= y + side and nodes[node, 4, t] >= y
                    and nodes[node, 2, t] <= z + side and nodes[node, 5, t] >= z
                ):  # fmt: skip
                    stack[depth] = 4 * node + t
                    depth += 1
            continue
        leaf = node - leaves
        for t in range(4):
            if corners[leaf, 9, t] > 0.0:
                any_faces = True
                for p in range(3):
                    places[p] = (corners[leaf, 3 * p, t] - x) / spacing
                    places[3 + p] = (corners[leaf, 3 * p + 1, t] - y) / spacing
                    places[6 + p] = (corners[leaf, 3 * p + 2, t] - z) / spacing
                for axis in range(3):
                    _of_triangle(places, axis, crossings)
    if any_faces:
        for k in range(m):
            for j in range(m):
                for i in range(1, m):
                    crossings[0, k, j, i] += crossings[0, k, j, i - 1]
                    crossings[1, k, i, j] += crossings[1, k, i - 1, j]
                    crossings[2, i, k, j] += crossings[2, i - 1, k, j]


@kernel(forceinline=True)
def crossed(crossings, k, j, i, c, b, a):
    """By how much faces make the winding number greater between two points of the lattice."""
    total = crossings[0, k, j, a] - crossings[0, k, j, i]
    total += crossings[1, k, b, a] - crossings[1, k, j, a]
    return total + crossings[2, c, b, a] - crossings[2, k, b, a]
