# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of the interior tree and their boxes: the table, and kernels that divide and settle them."""

from __future__ import annotations

import numpy as np

from ...jit import kernel, table
from ..hashing import bits, following

NODE = np.dtype(
    [  # 64 bytes: a cache line
        ("split", np.float64),  # where the two children meet, in tree space
        ("first", np.int32),  # index of the children, below the split and above it; −1 for a leaf
        ("row_first", np.int32),  # the list of what matters in this box; empty if the state is certain
        ("row_count", np.int32),
        ("axis", np.int8),  # of the split
        ("state", np.int8),
        ("turns", np.int8),  # whether the bounds of the gradient allow any direction: no ray is known to be monotonic
        ("lipschitz", np.float64),  # bound of the field of the list in this box; unused for programs
        ("gradient", np.float32, (2, 3)),  # bounds of the field's gradient in this box, see ``slopes``; as lipschitz
        ("mass", np.float64),  # m³ of the boxes below that are not certainly outside
    ],
    align=True,
)

OUTSIDE, INSIDE, BOUNDARY = 0, 1, 2  # state of a node: of all points of its box, or uncertain

TABLES = {"lamp_nodes": NODE}
ENOUGH = 0.85  # fraction of the volume of the boxes that must be interior before small boxes stay unsplit
MOST_LEVELS = 60  # maximum depth of nodes

lamp_nodes = table("lamp_nodes", NODE)


@kernel
def volume_of_box(box):
    """Volume of a box: its low corner, then its high one."""
    return (box[3] - box[0]) * (box[4] - box[1]) * (box[5] - box[2])


@kernel
def half_area(box):
    """Half of the surface area of a box."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@kernel
def longest_side(box):
    """Longest side of a box, and its axis."""
    axis = 0
    for k in range(1, 3):
        if box[3 + k] - box[k] > box[3 + axis] - box[axis]:
            axis = k
    return box[3 + axis] - box[axis], axis


@kernel
def halve(boxes, index, axis, position, place):
    """Write the parts of a box, cut at ``position``, to rows ``place`` and ``place + 1``."""
    for side in range(2):
        for k in range(6):
            boxes[place + side, k] = boxes[index, k]
    boxes[place, 3 + axis] = position
    boxes[place + 1, axis] = position


@kernel
def divide(nodes, boxes, levels, used, index, axis, position):
    """Give a node two children, still empty. Returns the index of the first."""
    place = used[0]
    used[0] += 2
    halve(boxes, index, axis, position, place)
    levels[place] = levels[place + 1] = levels[index] + 1
    node = nodes[index]
    node.first, node.axis, node.split = place, axis, position
    for side in range(2):
        child = nodes[place + side]
        child.first, child.axis, child.split = -1, 0, 0.0
        child.state, child.lipschitz = BOUNDARY, node.lipschitz
        child.row_first, child.row_count = node.row_first, node.row_count
    return place


@kernel
def store_list(nodes, index, lists, known, used, parts, count):
    """Give a node the list ``parts`` of ``count`` rows. Equal lists are stored once, so the position identifies a list.

    ``known`` is a hash table with open addressing: its size is a power of two, each slot −1 or a node that has a list.
    """
    node = nodes[index]
    node.row_count = count
    state = np.uint64(count)
    for row in range(count):
        state = following(state) ^ np.uint64(parts[row])
    place = np.int64(bits(state) & np.uint64(len(known) - 1))
    while known[place] >= 0:
        other = nodes[known[place]]
        same = other.row_count == count
        row = 0
        while same and row < count:
            same = lists[other.row_first + row] == parts[row]
            row += 1
        if same:
            node.row_first = other.row_first
            return
        place = (place + 1) & (len(known) - 1)
    known[place] = index
    node.row_first = used[1]
    lists[used[1] : used[1] + count] = parts[:count]
    used[1] += count


@kernel
def settle(nodes, boxes, index, state, mass):
    """Set the state of a leaf; ``mass`` counts the volume of all full leaves and of all on the boundary."""
    node = nodes[index]
    node.state = state
    if state != BOUNDARY:
        node.row_count = 0
    if state != OUTSIDE:
        mass[state - 1] += volume_of_box(boxes[index])


@kernel
def small_enough(box, level, smallest, mass):
    """Whether a box on the boundary stays unsplit."""
    if level > MOST_LEVELS - 3:
        return True
    return longest_side(box)[0] <= smallest and mass[0] + 0.5 * mass[1] >= ENOUGH * (mass[0] + mass[1])


@kernel
def middle_of(box, axis):
    """The coordinate of the centre of a box along an axis."""
    return 0.5 * (box[axis] + box[3 + axis])


@kernel
def finish(nodes, boxes, count, kept_nodes, kept_boxes):
    """Join children that are both empty or both full, sum the masses, and copy the reachable nodes depth first: so the
    nodes that a ray visits in sequence are close in memory. Returns the number of nodes."""
    for index in range(count - 1, -1, -1):
        node = nodes[index]
        if node.first < 0:
            node.mass = 0.0 if node.state == OUTSIDE else volume_of_box(boxes[index])
            continue
        left, right = nodes[node.first], nodes[node.first + 1]
        node.mass = left.mass + right.mass
        node.lipschitz = min(node.lipschitz, max(left.lipschitz, right.lipschitz))
        if left.first < 0 and right.first < 0 and left.state == right.state and left.state != BOUNDARY:
            node.first, node.state, node.row_count = -1, left.state, 0
    waiting = np.empty(MOST_LEVELS + 2, np.int64)
    kept_nodes[0], kept_boxes[0] = nodes[0], boxes[0]
    waiting[0] = 0
    kept, depth = 1, 1
    while depth > 0:
        depth -= 1
        node = kept_nodes[waiting[depth]]
        if node.first < 0:
            continue
        for side in range(2):
            kept_nodes[kept + side], kept_boxes[kept + side] = nodes[node.first + side], boxes[node.first + side]
            waiting[depth + side] = kept + 1 - side
        node.first = kept
        kept += 2
        depth += 2
    return kept
