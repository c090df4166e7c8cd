# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps that a ray may hit: a bounding volume hierarchy over the boxes of all SDF lamps in the world.

A node holds the boxes of up to eight children, which a ray tests together with vector instructions (Dammertz, Hanika
and Keller 2008, "Shallow bounding volume hierarchies for fast SIMD ray tracing of incoherent rays"). They are in single
precision, rounded outwards, and the test allows for its own rounding (Ize 2013, "Robust BVH ray traversal"). So a lamp
that the ray hits is never missed. A lamp that it misses may be found; ``emitter.trace`` decides.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, stack_array, table
from ...replaced import replaced_on_gpu
from .lights.tree_build import Bounds, build_tree

WIDTH = 8
LANES = 4  # boxes that one vector instruction tests
HALVINGS = 3  # binary levels of a cluster, with WIDTH children
NOTHING = -1  # in ``slots``: no child

NODE = np.dtype(
    [
        ("low", np.float32, (3, WIDTH)),  # corners of each child's box; the first axis is the coordinate
        ("high", np.float32, (3, WIDTH)),
        ("visibility", np.int32, WIDTH),  # bits of scene.Ray: kinds of rays that see any lamp below
        ("child", np.int32, WIDTH),  # the node below, or ~lamp
        ("count", np.int64),  # children, the first ones
    ],
    align=True,
)

TABLES = {"lamp_tree": NODE}
WORKSPACE_TABLES = {"lamps_found": np.dtype(np.int64)}

ROUNDING = 1.0 + 2.0**-50  # of the distances to the sides of a box, doubled

tree_table = table("lamp_tree", NODE)
found_table = table("lamps_found", np.int64)


def workspace_counts(lamps: int) -> dict[str, int]:
    """Rows of the tables of ``WORKSPACE_TABLES``: the lamps that a ray may hit, and nodes that wait to be visited."""
    return {"lamps_found": 2 * max(lamps, 1)}


def pack_lamp_tree(low: np.ndarray, high: np.ndarray, visibility: np.ndarray) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps with the corners (lamps, 3) of their boxes and their visibility (lamps,)."""
    count = len(low)
    if not count:
        return {"lamp_tree": np.zeros(0, NODE)}
    binary = build_tree(
        Bounds(
            np.arange(count),
            low,
            high,
            np.zeros((count, 3)),
            np.full(count, -1.0),
            np.zeros(count),
            np.ones(count),
            np.zeros(count, bool),
        )
    )
    child = binary.nodes["child"]
    seen = np.zeros(len(child), np.int32)
    seen[binary.leaf] = visibility
    for node in np.flatnonzero(child >= 0)[::-1]:
        seen[node] = seen[child[node]] | seen[child[node] + 1]
    outer_low = np.nextafter(binary.lo.astype(np.float32), np.float32(-np.inf))
    outer_high = np.nextafter(binary.hi.astype(np.float32), np.float32(np.inf))

    levels, first, frontier = [], 0, np.zeros(1, np.int64)
    while len(frontier):
        slots = _descendants(child, frontier)
        slots = np.take_along_axis(slots, np.argsort(slots == NOTHING, axis=1, kind="stable"), axis=1)
        used = slots != NOTHING
        rows = np.zeros(len(frontier), NODE)
        rows["low"] = np.where(used[:, None, :], outer_low[slots].transpose(0, 2, 1), 0.0)
        rows["high"] = np.where(used[:, None, :], outer_high[slots].transpose(0, 2, 1), 0.0)
        rows["visibility"] = np.where(used, seen[slots], 0)
        rows["count"] = used.sum(axis=1)
        inner = used & (child[slots] >= 0)
        first += len(frontier)
        rows["child"] = child[slots]
        rows["child"][inner] = first + np.arange(inner.sum())
        levels.append(rows)
        frontier = slots[inner]
    return {"lamp_tree": np.concatenate(levels)}


def _descendants(child: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """(nodes, WIDTH) descendants ``HALVINGS`` levels below nodes of a binary tree, leaves above that level, or
    ``NOTHING``."""
    slots = nodes[:, None]
    for _ in range(HALVINGS):
        inner = (slots != NOTHING) & (child[slots] >= 0)
        slots = np.stack([np.where(inner, child[slots], slots), np.where(inner, child[slots] + 1, NOTHING)], axis=2)
        slots = slots.reshape(len(nodes), -1)
    return slots


@kernel
def _inverse(v):
    """1/v, finite for zero."""
    return 1.0 / v if abs(v) > 1e-30 else 1e30


@replaced_on_gpu
@kernel
def lamps_along(block, workspace, o, d, t_max, kind):
    """Write the lamps that the ray o + t·d may hit in 0 < t < t_max to ``lamps_found``. Returns their number.

    ``kind`` holds bits of ``scene.Ray``: lamps visible to none of them are left out. The order is that of the tree.
    """
    nodes, found = tree_table(block), found_table(workspace)
    if len(nodes) == 0:
        return 0
    enter, leave = stack_array(WIDTH), stack_array(WIDTH)
    ox, oy, oz = o
    sx, sy, sz = _inverse(d[0]), _inverse(d[1]), _inverse(d[2])
    # Waiting nodes are at the end. They and the found lamps are at most as many as all nodes and lamps.
    waiting, count = len(found) - 1, 0
    found[waiting] = 0
    while waiting < len(found):
        node = nodes[found[waiting]]
        waiting += 1
        low_x, low_y, low_z = node.low[0], node.low[1], node.low[2]
        high_x, high_y, high_z = node.high[0], node.high[1], node.high[2]
        # Unsigned: indices that may be negative would keep LLVM from vector instructions.
        for lanes in range(np.uint64(0), np.uint64(node.count), np.uint64(LANES)):
            for lane in range(np.uint64(LANES)):
                k = lanes + lane
                ax, bx = (low_x[k] - ox) * sx, (high_x[k] - ox) * sx
                ay, by = (low_y[k] - oy) * sy, (high_y[k] - oy) * sy
                az, bz = (low_z[k] - oz) * sz, (high_z[k] - oz) * sz
                enter[k] = max(max(min(ax, bx), min(ay, by)), max(min(az, bz), 0.0))
                leave[k] = min(min(max(ax, bx), max(ay, by)), max(az, bz))
        for k in range(node.count):
            if enter[k] <= leave[k] * ROUNDING and enter[k] < t_max and node.visibility[k] & kind:
                child = node.child[k]
                if child < 0:
                    found[count] = ~child
                    count += 1
                else:
                    waiting -= 1
                    found[waiting] = child
    return count
