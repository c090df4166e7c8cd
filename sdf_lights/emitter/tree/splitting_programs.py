# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Splits the boxes of a closed-form program's tree in two: along flat faces, or where it saves rays the most work."""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel
from .. import primitives
from ..intersection.fields import DEEPEST, LIST
from ..intersection.membership import place
from .nodes import (
    BOUNDARY,
    INSIDE,
    OUTSIDE,
    divide,
    half_area,
    halve,
    longest_side,
    middle_of,
    settle,
    small_enough,
    store_list,
    volume_of_box,
)
from .pruning import prune_program

SHORT_PROGRAM = 4  # rows of a list of instructions for which rays need no smaller boxes
PLANES = 7  # candidates along each axis for the cut of a box with more than that
FACE = 0.7  # factor on the remaining work of a cut along a flat face, because the face is then settled


@kernel
def _center_and_half(box):
    c = (0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5]))
    return c, (0.5 * (box[3] - box[0]), 0.5 * (box[4] - box[1]), 0.5 * (box[5] - box[2]))


@kernel
def _flat_face(program, lists, node, box):
    """Axis and position of a flat face, perpendicular to an axis, of a primitive whose surface crosses the box; axis
    −1: none.

    Boxes cut along such faces become certain at once, while halving would approach the face for ever. Among several
    faces, the one closest to the middle of the box is used.
    """
    best, best_axis, best_position = 0.5 - 1e-6, -1, 0.0
    for entry in range(node.row_first, node.row_first + node.row_count):
        if lists[entry] < 0:
            continue
        row = program[lists[entry]]
        c, h = _center_and_half(box)
        c, h = place(row, c, h)
        for local in range(3):
            size = primitives.face(row.op, row.parameters, local, c, h)
            if size == math.inf:
                continue
            m = row.inverse[local]
            for axis in range(3):
                slope = m[axis]
                if slope == 0.0 or m[(axis + 1) % 3] != 0.0 or m[(axis + 2) % 3] != 0.0:
                    continue
                for sign in range(2):
                    position = ((size if sign else -size) - m[3]) / slope
                    aside = abs(position - middle_of(box, axis)) / (box[3 + axis] - box[axis])
                    if aside < best:
                        best, best_axis, best_position = aside, axis, position
    return best_axis, best_position


@kernel(forceinline=True)
def _pruned(program, lists, node, box, out, starts):
    """``pruning.prune_program`` for a box."""
    c, h = _center_and_half(box)
    return prune_program(program, lists, node.row_first, node.row_count, c, h, out, starts)


@kernel
def _work(program, lists, nodes, boxes, index, axis, position, place, out, starts):
    """Remaining work of a ray that meets the box, after a cut: the sum over both parts of area times what matters
    there. Rows of ``boxes`` from ``place`` are scratch."""
    halve(boxes, index, axis, position, place)
    work = 0.0
    for side in range(2):
        count, _, _ = _pruned(program, lists, nodes[index], boxes[place + side], out, starts)
        work += count * half_area(boxes[place + side])
    return work


@kernel
def _best_plane(program, lists, nodes, boxes, index, place, shortest, axis, position, out, starts):
    """Axis and position of the plane that cuts a box in which much matters. Sides below ``shortest`` are not cut; if
    all are, the axis is −1. ``axis`` and ``position`` are those of a flat face, if there is one.

    A ray that meets a box meets a part of it with a probability proportional to its area, and then works on what
    matters in it (J. D. MacDonald and K. S. Booth, "Heuristics for ray tracing using space subdivision", 1990).
    """
    best, best_axis, best_position = math.inf, axis, position
    if axis >= 0:
        best = FACE * _work(program, lists, nodes, boxes, index, axis, position, place, out, starts)
    for k in range(3):
        low, size = boxes[index, k], boxes[index, 3 + k] - boxes[index, k]
        if size < shortest:
            continue
        for step in range(1, PLANES + 1):
            cut = low + size * step / (PLANES + 1)
            work = _work(program, lists, nodes, boxes, index, k, cut, place, out, starts)
            if work < best:
                best, best_axis, best_position = work, k, cut
    return best_axis, best_position


@kernel
def _best_axis(program, lists, nodes, boxes, index, place, out, starts):
    """Axis whose halves are certain, or else the longest one. Rows of ``boxes`` from ``place`` are scratch."""
    longest = longest_side(boxes[index])[0]
    best, axis = -1.0, 0
    for k in range(3):
        halve(boxes, index, k, middle_of(boxes[index], k), place)
        score = (boxes[index, 3 + k] - boxes[index, k]) / longest
        for side in range(2):
            _, inside, outside = _pruned(program, lists, nodes[index], boxes[place + side], out, starts)
            score += inside | outside
        if score > best:
            best, axis = score, k
    return axis


@kernel
def grow_program(program, nodes, boxes, levels, lists, known, used, mass, index, rows, smallest):
    """Split the boxes of a program's tree in two, in turn from ``index`` on. If much matters in a box, the cut leaves
    the least work for rays. Otherwise it follows a flat face, if there is one, or the middle of the axis that makes the
    most volume certain. Returns the index to continue from once the lists of the split boxes have so many ``rows``, −1
    at the end. Other arguments are those of ``grow_field``."""
    out, starts = np.empty(len(program), LIST), np.empty(DEEPEST, np.int64)
    while index < used[0] and used[0] + 2 <= len(nodes):
        if rows <= 0:
            return index
        node, box = nodes[index], boxes[index]
        parent = index
        index += 1
        if node.state != BOUNDARY or small_enough(box, levels[parent], smallest, mass):
            continue
        if used[1] + 2 * node.row_count > len(lists):
            return -1
        rows -= node.row_count
        axis, position = _flat_face(program, lists, node, box)
        if node.row_count > SHORT_PROGRAM:
            axis, position = _best_plane(
                program, lists, nodes, boxes, parent, used[0], smallest / PLANES, axis, position, out, starts
            )
        if axis < 0:
            axis = _best_axis(program, lists, nodes, boxes, parent, used[0], out, starts)
            position = middle_of(box, axis)
        mass[1] -= volume_of_box(box)
        place = divide(nodes, boxes, levels, used, parent, axis, position)
        for side in range(2):
            child = place + side
            count, inside, outside = _pruned(program, lists, node, boxes[child], out, starts)
            settle(nodes, boxes, child, INSIDE if inside else OUTSIDE if outside else BOUNDARY, mass)
            if nodes[child].state == BOUNDARY:
                store_list(nodes, child, lists, known, used, out, count)
    return -1
