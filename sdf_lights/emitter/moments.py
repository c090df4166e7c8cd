# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is inside each box of an interior tree, for sampling: its volume, its centroid and how far it spreads.

The tree is copied without its empty boxes. A box that has one part left is that part, so boxes also close in on what
they hold, and the way down the tree is short.

Boxes that are full have closed forms. Those on the boundary are sampled, one random point in each of ``SIDE``³ parts;
then all of them are scaled by the one factor that makes the whole the volume of the shape, which is known better.
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel, stack_array, table
from .fields import LANES, STACK, VALUES, run_terms
from .hashing import following, uniform_point
from .interior import BOUNDARY, INSIDE, Tree
from .membership import contains

CELL = np.dtype([
    ("first", np.int32),  # index of the two children, below the split and above it; −1 for a leaf
    ("axis", np.int32),  # that the children divide
    ("state", np.int32),  # INSIDE or BOUNDARY
    ("direct", np.int32),  # 1: points are drawn from the box itself, not from what is below
    ("row_first", np.int32),  # the list of what matters in a leaf on the boundary, as of ``interior.NODE``
    ("row_count", np.int32),
    ("low", np.float64, (3,)),  # corners of the box, in tree space
    ("high", np.float64, (3,)),
    ("volume", np.float64),  # m³ of the interior
    ("centroid", np.float64, (3,)),  # of the interior
    ("spread", np.float64, (3,)),  # m², variance of each coordinate, of the leaves below as a whole
    # The same, weighted by the emission: equal to those above where it is the same everywhere.
    ("mass", np.float64),  # m³: the integral of the emission, divided by its mean over the shape
    ("mass_centroid", np.float64, (3,)),
    ("mass_spread", np.float64, (3,)),
], align=True)

TABLES = {"lamp_cells": CELL}

FILL = 0.7  # interior of a box from which points are drawn without going down to its leaves
SIDE = 6  # parts of a box on the boundary along each axis, with a sample in each

lamp_cells = table("lamp_cells", CELL)


@kernel
def sample_leaf(program, terms, parameters, lists, node, box, state, stack, total):
    """Volume of the interior in a box, and the integrals of the three coordinates over it, to ``total`` (4).

    Returns the state of the random numbers.
    """
    size = ((box[3] - box[0]) / SIDE, (box[4] - box[1]) / SIDE, (box[5] - box[2]) / SIDE)
    part = size[0] * size[1] * size[2]
    chosen = lists[node.row_first:node.row_first + node.row_count]
    total[:] = 0.0
    for first in range(0, SIDE**3, LANES):
        count = min(LANES, SIDE**3 - first)
        for lane in range(LANES):
            state = following(state)
            u = uniform_point(state)
            cell = min(first + lane, SIDE**3 - 1)
            place = (cell % SIDE, cell // SIDE % SIDE, cell // (SIDE * SIDE))
            for k in range(3):
                stack[k * LANES + lane] = box[k] + (place[k] + u[k]) * size[k]
        if len(terms) > 0:
            run_terms(terms, parameters, lists, node.row_first, node.row_count, stack)
        for lane in range(count):
            p = (stack[lane], stack[LANES + lane], stack[2 * LANES + lane])
            inside = stack[VALUES + lane] <= 0.0 if len(terms) > 0 else contains(program, p, chosen)
            if inside:
                total[0] += part
                for k in range(3):
                    total[1 + k] += part * p[k]
    return state


@kernel
def sample_leaves(program, terms, parameters, nodes, lists, boxes, totals):
    """``sample_leaf`` for all leaves on the boundary; the closed form for those that are full. ``totals`` is (nodes, 4)."""
    stack = stack_array(STACK)
    state = np.uint64(1)
    for index in range(len(nodes)):
        node, box = nodes[index], boxes[index]
        if node.first >= 0:
            continue
        if node.state == BOUNDARY:
            state = sample_leaf(program, terms, parameters, lists, node, box, state, stack, totals[index])
        elif node.state == INSIDE:
            volume = (box[3] - box[0]) * (box[4] - box[1]) * (box[5] - box[2])
            totals[index, 0] = volume
            for k in range(3):
                totals[index, 1 + k] = volume * 0.5 * (box[k] + box[3 + k])


@kernel
def _find(nodes, index):
    """The node itself, or what is left of it where all else is empty."""
    while nodes[index].first >= 0:
        first = nodes[index].first
        if nodes[first].mass == 0.0:
            index = first + 1
        elif nodes[first + 1].mass == 0.0:
            index = first
        else:
            break
    return index


@kernel
def gather(nodes, boxes, totals, least_fill, cells):
    """Fill in ``cells`` from what is in the leaves; returns how many there are."""
    source = np.empty(len(nodes), np.int64)
    source[0], used, index = _find(nodes, 0), 1, 0
    while index < used:
        node, cell = nodes[source[index]], cells[index]
        cell.first, cell.axis, cell.state = -1, node.axis, node.state
        cell.row_first, cell.row_count = node.row_first, node.row_count
        if node.first >= 0:
            cell.first = used
            source[used], source[used + 1] = _find(nodes, node.first), _find(nodes, node.first + 1)
            used += 2
        index += 1
    for index in range(used - 1, -1, -1):
        cell = cells[index]
        if cell.first < 0:
            box, total = boxes[source[index]], totals[source[index]]
            cell.volume = cell.mass = total[0]
            cell.direct = 1
            for k in range(3):
                size = box[3 + k] - box[k]
                cell.low[k], cell.high[k] = box[k], box[3 + k]
                cell.spread[k] = size * size / 12.0
                cell.centroid[k] = total[1 + k] / total[0] if total[0] > 0.0 else 0.5 * (box[k] + box[3 + k])
                cell.mass_spread[k], cell.mass_centroid[k] = cell.spread[k], cell.centroid[k]
            continue
        a, b = cells[cell.first], cells[cell.first + 1]
        cell.volume = cell.mass = a.volume + b.volume
        share = b.volume / cell.volume if cell.volume > 0.0 else 0.5
        for k in range(3):
            cell.low[k], cell.high[k] = min(a.low[k], b.low[k]), max(a.high[k], b.high[k])
            apart = b.centroid[k] - a.centroid[k]
            cell.spread[k] = a.spread[k] + share * (b.spread[k] - a.spread[k]) + share * (1.0 - share) * apart * apart
            cell.centroid[k] = a.centroid[k] + share * apart
            cell.mass_spread[k], cell.mass_centroid[k] = cell.spread[k], cell.centroid[k]
        size = (cell.high[0] - cell.low[0]) * (cell.high[1] - cell.low[1]) * (cell.high[2] - cell.low[2])
        if cell.volume >= least_fill * size:
            cell.direct = 1
    return used


def cells(tree: Tree, volume: float) -> np.ndarray:
    """``CELL`` for each box of the tree that is not empty; ``volume`` is that of the shape, in its own space.

    A shape of which nothing is inside any box has none.
    """
    if tree.nodes["mass"][0] == 0.0:
        return np.zeros(0, CELL)
    totals = np.zeros((len(tree.nodes), 4))
    terms, parameters = tree.arrays
    sample_leaves(tree.program, terms, parameters, tree.nodes, tree.lists, tree.boxes, totals)
    leaves = tree.boundary
    sampled, certain = totals[leaves, 0].sum(), totals[tree.inside, 0].sum()
    if sampled > 0.0 and volume > certain:
        totals[leaves] *= (volume - certain) / sampled
    found = np.zeros(len(tree.nodes), CELL)
    return found[:gather(tree.nodes, tree.boxes, totals, FILL, found)].copy()
