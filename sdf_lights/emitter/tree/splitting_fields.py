# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Splits the boxes of a field's tree, into eight parts at a time."""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel, stack_array
from ..intersection.fields import DEEPEST, LANES, LIST, STACK, VALUES
from .nodes import BOUNDARY, INSIDE, OUTSIDE, divide, middle_of, settle, small_enough, store_list, volume_of_box
from .pruning import prune_field


@kernel
def _certainty(states, first, count):
    """The common state of ``count`` leaves from ``first``, or ``BOUNDARY``."""
    for index in range(first + 1, first + count):
        if states[index] != states[first]:
            return BOUNDARY
    return states[first]


@kernel
def _eighths(box, axes, position):
    """Centre of each of the eight parts that three halvings along ``axes`` make of a box, and their half diagonal."""
    size = np.empty(3)
    for k in range(3):
        size[k] = box[3 + k] - box[k]
    low = np.empty((LANES, 3))
    for lane in range(LANES):
        for k in range(3):
            low[lane, k] = box[k]
    for turn in range(3):
        axis = np.argmax(size)
        axes[turn] = axis
        size[axis] *= 0.5
        for lane in range(LANES):
            if lane >> (2 - turn) & 1:
                low[lane, axis] += size[axis]
    for lane in range(LANES):
        for k in range(3):
            position[k * LANES + lane] = low[lane, k] + 0.5 * size[k]
    return 0.5 * math.sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2])


@kernel
def grow_field(
    terms,
    parameters,
    near_fields,
    gains,
    columns,
    bounds,
    nodes,
    boxes,
    levels,
    lists,
    known,
    used,
    mass,
    first,
    last,
    smallest,
):
    """Split the leaves on the boundary among the nodes from ``first`` to ``last`` into eight parts each.

    ``levels`` holds the depth of each node, ``known`` the lists (see ``store_list``), ``used`` the numbers of nodes and
    of rows of lists in use, ``mass`` the volumes of all leaves that are full and of those on the boundary.
    ``near_fields``, ``gains``, ``columns`` and the rows of ``bounds``, one for each node, are those of
    ``pruning.prune_field``.
    """
    stack = stack_array(STACK)
    axes = np.empty(3, np.int64)
    states = np.empty(LANES, np.int64)
    lengths = np.empty(LANES, np.int64)
    slopes = np.empty(LANES)
    out = np.empty((LANES, len(terms)), LIST)
    starts, steepness = np.empty((LANES, DEEPEST), np.int64), np.empty((LANES, DEEPEST))
    for index in range(first, last):
        node = nodes[index]
        if node.state != BOUNDARY or node.first >= 0 or small_enough(boxes[index], levels[index], smallest, mass):
            continue
        if used[0] + 14 > len(nodes) or used[1] + LANES * node.row_count > len(lists):
            return
        radius = _eighths(boxes[index], axes, stack)
        prune_field(
            terms,
            parameters,
            near_fields,
            gains,
            columns,
            bounds[index],
            lists,
            node.row_first,
            node.row_count,
            radius,
            stack,
            out,
            lengths,
            slopes,
            starts,
            steepness,
        )
        for lane in range(LANES):
            value = stack[VALUES + lane]
            margin = slopes[lane] * radius
            states[lane] = OUTSIDE if value > margin else INSIDE if value < -margin else BOUNDARY
        mass[1] -= volume_of_box(boxes[index])
        common = _certainty(states, 0, LANES)
        if common != BOUNDARY:
            node.lipschitz = max(slopes.max(), 0.0)
            settle(nodes, boxes, index, common, mass)
            continue
        begin = used[0]
        half = divide(nodes, boxes, levels, used, index, axes[0], middle_of(boxes[index], axes[0]))
        for lane in range(0, LANES, 4):
            part = half + lane // 4
            common = _certainty(states, lane, 4)
            if common != BOUNDARY:
                settle(nodes, boxes, part, common, mass)
                continue
            quarter = divide(nodes, boxes, levels, used, part, axes[1], middle_of(boxes[part], axes[1]))
            for pair in range(lane, lane + 4, 2):
                part = quarter + (pair - lane) // 2
                common = _certainty(states, pair, 2)
                if common != BOUNDARY:
                    settle(nodes, boxes, part, common, mass)
                    continue
                eighth = divide(nodes, boxes, levels, used, part, axes[2], middle_of(boxes[part], axes[2]))
                for side in range(2):
                    leaf = eighth + side
                    settle(nodes, boxes, leaf, states[pair + side], mass)
                    nodes[leaf].lipschitz = slopes[pair + side]
                    if states[pair + side] == BOUNDARY:
                        store_list(nodes, leaf, lists, known, used, out[pair + side], lengths[pair + side])
        for child in range(begin, used[0]):
            bounds[child] = bounds[index]
