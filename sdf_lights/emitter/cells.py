# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of boxes around the interior of a program, and uniform points in it.

Boxes that are certainly outside (see ``membership``) are left out, and those certainly inside need no test. A point is
drawn uniformly from the boxes that are left, by warping one point of the unit cube down the tree: at each node the
coordinate of the node's axis chooses the side and is stretched back to [0, 1), which keeps stratified numbers
stratified. Where the point falls outside the shape everything is drawn again, so it is *exactly* uniform in the
interior, whatever the boxes are: the volume of the interior is not used.
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel
from .membership import BOX, CONE, CYLINDER, classify, classify_primitive

CELL = np.dtype([
    ("first", np.int64),  # index of the two children, from the root; −1 for a leaf
    ("axis", np.int64),  # that the children divide
    ("share", np.float64),  # of the left child in the volume of the boxes
    ("inside", np.int64),  # 1 where the whole box is
    ("low", np.float64, (3,)),
    ("high", np.float64, (3,)),
    ("mass", np.float64),  # volume of the boxes below
])

LIMIT = 16_384  # nodes of a tree
ENOUGH = 0.85  # part of the boxes' volume that is interior at which building stops
ATTEMPTS = 4096  # draws before giving up; the least acceptance that lamps allow makes that a chance of 1e-9


@kernel
def _flat_face(program, low, high):
    """Axis and position of a flat face, square to an axis, of a primitive whose surface crosses the box; axis −1: none.

    Boxes cut along such faces become certain at once, where halving would close in on the face for ever.
    """
    centre = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    half = (0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2]))
    for index in range(len(program)):
        row = program[index]
        if row.arity != 0 or not (row.op == BOX or row.op == CYLINDER or row.op == CONE):
            continue
        is_inside, is_outside = classify_primitive(row, centre, half)
        if is_inside + is_outside > 0:
            continue
        for local in range(0 if row.op == BOX else 2, 3):
            size = row.parameters[local] if row.op == BOX else 0.5 * row.parameters[1]
            for axis in range(3):
                m = row.inverse[local]
                slope = m[axis]
                if slope == 0.0 or m[(axis + 1) % 3] != 0.0 or m[(axis + 2) % 3] != 0.0:
                    continue
                for sign in range(2):
                    position = ((size if sign else -size) - m[3]) / slope
                    margin = 1e-6 * (high[axis] - low[axis])
                    if low[axis] + margin < position < high[axis] - margin:
                        return axis, position
    return -1, 0.0


@kernel
def _certain(program, cell):
    """Sets ``inside`` of a new leaf; returns True if it is certainly inside or outside."""
    low, high = cell.low, cell.high
    centre = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    half = (0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2]))
    is_inside, is_outside = classify(program, centre, half)
    cell.first = -1
    cell.inside = is_inside
    cell.mass = 0.0 if is_outside else 8.0 * half[0] * half[1] * half[2]
    return is_inside + is_outside > 0


@kernel
def _divide(cells, index, axis, position, place):
    """Write the halves of a cell, cut at ``position``, to rows ``place`` and ``place + 1``."""
    for side in range(2):
        child = cells[place + side]
        for k in range(3):
            child.low[k], child.high[k] = cells[index].low[k], cells[index].high[k]
        if side == 0:
            child.high[axis] = position
        else:
            child.low[axis] = position


@kernel
def build(program, low, high, volume, cells):
    """Build the tree of a program with a known volume and bounding box into ``cells``; returns the number of nodes.

    Breadth first, so the largest boxes are divided first: along a flat face where there is one, else in the middle of
    the axis that makes the most volume certain, or of the longest one relative to the bounding box.
    """
    for k in range(3):
        cells[0].low[k], cells[0].high[k] = low[k], high[k]
    _certain(program, cells[0])
    count, index = 1, 0
    occupied = cells[0].mass
    while index < count and count + 2 <= len(cells) and volume < ENOUGH * occupied:
        cell = cells[index]
        index += 1
        if cell.inside or cell.mass == 0.0:
            continue
        axis, position = _flat_face(program, cell.low, cell.high)
        if axis < 0:
            best = -1.0
            for k in range(3):
                middle = 0.5 * (cell.low[k] + cell.high[k])
                _divide(cells, index - 1, k, middle, count)
                decided = 0.0
                for side in range(2):
                    if _certain(program, cells[count + side]):
                        decided += 1.0
                score = decided + (cell.high[k] - cell.low[k]) / (high[k] - low[k])
                if score > best:
                    best, axis, position = score, k, middle
        _divide(cells, index - 1, axis, position, count)
        occupied -= cell.mass
        for side in range(2):
            _certain(program, cells[count + side])
            occupied += cells[count + side].mass
        cell.first, cell.axis = count, axis
        count += 2
    for index in range(count - 1, -1, -1):
        cell = cells[index]
        if cell.first >= 0:
            left, right = cells[cell.first].mass, cells[cell.first + 1].mass
            cell.mass = left + right
            cell.share = left / cell.mass if cell.mass > 0.0 else 0.5
    return count


@kernel
def _warp(u, share):
    """Side that u chooses, and u stretched back to the unit interval."""
    if u < share:
        return 0, u / share
    return 1, (u - share) / (1.0 - share)


@kernel
def cell_point(cells, u1, u2, u3):
    """Uniform point in the boxes of a tree, and whether it is certainly inside the shape."""
    index = 0
    while cells[index].first >= 0:
        cell = cells[index]
        if cell.axis == 0:
            side, u1 = _warp(u1, cell.share)
        elif cell.axis == 1:
            side, u2 = _warp(u2, cell.share)
        else:
            side, u3 = _warp(u3, cell.share)
        index = cell.first + side
    low, high = cells[index].low, cells[index].high
    return (
        low[0] + u1 * (high[0] - low[0]),
        low[1] + u2 * (high[1] - low[1]),
        low[2] + u3 * (high[2] - low[2]),
    ), cells[index].inside == 1
