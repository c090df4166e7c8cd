# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Uniform points in the boxes of an interior tree.

One point of the unit cube is warped down the tree. At each node, the coordinate of the node's axis chooses the side and
is stretched back to [0, 1), which keeps stratified numbers stratified. Points outside the shape are then drawn again,
so the result is *exactly* uniform in the interior, whatever the boxes are.
"""

from __future__ import annotations

from ...jit import kernel


@kernel
def _warp(u, share):
    """Side that u chooses, and u stretched back to the unit interval."""
    if u < share:
        return 0, u / share
    return 1, (u - share) / (1.0 - share)


@kernel
def tree_point(nodes, low, high, u1, u2, u3):
    """Uniform point in the boxes that are not empty, and its leaf; low and high are the root's corners."""
    x0, y0, z0 = low[0], low[1], low[2]
    x1, y1, z1 = high[0], high[1], high[2]
    index = 0
    while nodes[index].first >= 0:
        node = nodes[index]
        share = nodes[node.first].mass / node.mass
        if node.axis == 0:
            side, u1 = _warp(u1, share)
            x0, x1 = (node.split, x1) if side else (x0, node.split)
        elif node.axis == 1:
            side, u2 = _warp(u2, share)
            y0, y1 = (node.split, y1) if side else (y0, node.split)
        else:
            side, u3 = _warp(u3, share)
            z0, z1 = (node.split, z1) if side else (z0, node.split)
        index = node.first + side
    return (x0 + u1 * (x1 - x0), y0 + u2 * (y1 - y0), z0 + u3 * (z1 - z0)), index
