# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents of each box of an interior tree, for sampling: volume and emission, their centroids and variances.

The tree is copied without its empty boxes. A box with only one part left becomes that part. So boxes fit closely around
their contents, and the tree is shallow.

Boxes that are full have closed forms. Those on the boundary are sampled, with one random point in each of their parts.
Then one common factor scales all of them to the volume of the shape, which is known better.

If the emission varies, full boxes are sampled too. Leaves are split further until the emission is nearly uniform in
each, as far as that matters to the whole.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...interruption import SLICE, check
from ...jit import kernel, stack_array, table
from ..emission.varying import COLOUR, COLOUR_STACK, CompiledEmission, run_colour
from ..hashing import following, uniform_point
from ..intersection.fields import LANES, STACK, VALUES, run_terms
from ..intersection.membership import contains
from .interior import Tree
from .nodes import BOUNDARY, INSIDE, NODE
from .volume import leaf_costs

CELL = np.dtype(
    [
        ("first", np.int32),  # index of the two children, below the split and above it; −1 for a leaf
        ("axis", np.int32),  # that the children divide
        ("state", np.int32),  # INSIDE or BOUNDARY
        ("direct", np.int32),  # 1: points are drawn from the box itself, not from its children
        ("row_first", np.int32),  # the list of what matters in a leaf on the boundary, as in ``interior.NODE``
        ("row_count", np.int32),
        ("low", np.float64, (3,)),  # corners of the box, in tree space
        ("high", np.float64, (3,)),
        ("volume", np.float64),  # m³ of the interior
        ("centroid", np.float64, (3,)),  # of the interior
        ("spread", np.float64, (3,)),  # m², variance of each coordinate, of the leaves below together
        # The same, weighted by the emission; equal to the values above if it is uniform.
        ("mass", np.float64),  # m³: the integral of the emission, divided by its mean over the shape
        ("mass_centroid", np.float64, (3,)),
        ("mass_spread", np.float64, (3,)),
    ],
    align=True,
)

TABLES = {"lamp_cells": CELL}

FILL = 0.95  # interior fraction of a box from which points are drawn directly
# Parts, along each axis, of boxes on the boundary and of full ones, with a sample in each; even.
SIDES = 6, 0
COARSE_SIDES = 4, 0  # greatest leaf if the emission is uniform …
FEW = 2000
GLOW_SIDES = 4, 4  # if the emission varies: there are more boxes then, and samples cost more …
TRIAL_SIDES = 2, 4  # … and for finding where it varies
COARSEST = 1.0 / 8.0  # greatest leaf, relative to the longest side of the root box, if the emission varies
ROUGH = 2e-4  # greatest integral of the emission's deviation in a leaf, relative to the integral of all emission
MOST_PARTS = 1 << 14  # leaves that are split because of it
SAFETY = 4.0  # standard errors in a bound

# Sums over the contents of a box: volume and its first moments; red, green and blue; then, of the mean of these: its
# first and second moments, its square, and the variance of its sum.
VOLUME, RGB, FIRST, SECOND, SQUARE, VARIANCE, SUMS = 0, 4, 7, 10, 13, 14, 15

lamp_cells = table("lamp_cells", CELL)


@kernel
def _sample_colours(glow, offset, points, inside, part, total, colours):
    """Add the emission of ``LANES`` points to the sums ``total``: those that are ``inside``, each for a volume
    ``part``.

    ``points`` are in tree space; ``offset`` shifts them to the shape's local space. ``colours`` is scratch.
    """
    for k in range(3):
        for lane in range(LANES):
            colours[k * LANES + lane] = points[k * LANES + lane] + offset[k]
    run_colour(glow[0], glow[1], colours)
    previous = 0.0
    for lane in range(LANES):
        mean = 0.0
        for channel in range(3):
            value = colours[COLOUR + channel * LANES + lane] if inside[lane] else 0.0
            total[RGB + channel] += part * value
            mean += value / 3.0
        for k in range(3):
            moment = part * mean * points[k * LANES + lane]
            total[FIRST + k] += moment
            total[SECOND + k] += moment * points[k * LANES + lane]
        total[SQUARE] += part * mean * mean
        if lane % 2 == 1:  # neighbours: the variance of two strata is at most the square of the difference, on average
            total[VARIANCE] += (part * (mean - previous)) ** 2
        previous = mean


@kernel
def sample_leaf(program, terms, parameters, lists, glow, offset, side, node, box, state, stack, total):
    """Add the sums (see ``VOLUME`` …) over the interior of a leaf to ``total``. Returns the state of the random
    numbers.

    ``glow`` holds the addresses of the emission's code and of its parameters; 0: the emission is uniform. There are
    ``side``³ samples.
    """
    size = ((box[3] - box[0]) / side, (box[4] - box[1]) / side, (box[5] - box[2]) / side)
    part = size[0] * size[1] * size[2]
    chosen = lists[node.row_first : node.row_first + node.row_count]
    colours = stack_array(COLOUR_STACK)
    inside = np.empty(LANES, np.bool_)
    total[:] = 0.0
    for first in range(0, side**3, LANES):
        for lane in range(LANES):
            state = following(state)
            u = uniform_point(state)
            cell = first + lane
            place = (cell % side, cell // side % side, cell // (side * side))
            for k in range(3):
                stack[k * LANES + lane] = box[k] + (place[k] + u[k]) * size[k]
        if node.state == INSIDE:
            inside[:] = True
        elif len(terms) > 0:
            run_terms(terms, parameters, lists, node.row_first, node.row_count, LANES, stack)
            for lane in range(LANES):
                inside[lane] = stack[VALUES + lane] <= 0.0
        else:
            for lane in range(LANES):
                inside[lane] = contains(program, (stack[lane], stack[LANES + lane], stack[2 * LANES + lane]), chosen)
        for lane in range(LANES):
            if inside[lane]:
                total[VOLUME] += part
                for k in range(3):
                    total[VOLUME + 1 + k] += part * stack[k * LANES + lane]
        if glow[0] != 0 and inside.any():
            _sample_colours(glow, offset, stack, inside, part, total, colours)
    if node.state == INSIDE:
        _fill(box, total)
    return state


@kernel
def _fill(box, total):
    """Volume and first moments of a full box."""
    volume = (box[3] - box[0]) * (box[4] - box[1]) * (box[5] - box[2])
    total[VOLUME] = volume
    for k in range(3):
        total[VOLUME + 1 + k] = volume * 0.5 * (box[k] + box[3 + k])


@kernel
def sample_leaves(program, terms, parameters, lists, glow, offset, sides, nodes, boxes, totals, first, last, state):
    """``sample_leaf`` for the leaves from ``first`` to ``last``; the closed form for full and uniform ones.

    ``sides`` are those of boxes on the boundary and of full ones, ``totals`` is (nodes, ``SUMS``). Returns the state of
    the random numbers.
    """
    stack = stack_array(STACK)
    for index in range(first, last):
        node = nodes[index]
        if node.first >= 0:
            continue
        if node.state == BOUNDARY or node.state == INSIDE and glow[0] != 0:
            side = sides[0] if node.state == BOUNDARY else sides[1]
            state = sample_leaf(
                program, terms, parameters, lists, glow, offset, side, node, boxes[index], state, stack, totals[index]
            )
        elif node.state == INSIDE:
            _fill(boxes[index], totals[index])
    return state


@kernel
def _halve(nodes, boxes, index, used):
    """Give a leaf two children along the longest side of its box."""
    axis = 0
    for k in range(1, 3):
        if boxes[index, 3 + k] - boxes[index, k] > boxes[index, 3 + axis] - boxes[index, axis]:
            axis = k
    middle = 0.5 * (boxes[index, axis] + boxes[index, 3 + axis])
    for side in range(2):
        nodes[used + side] = nodes[index]
        boxes[used + side] = boxes[index]
    boxes[used, 3 + axis] = boxes[used + 1, axis] = middle
    node = nodes[index]
    node.first, node.axis, node.split = used, axis, middle


@kernel
def divide(program, terms, parameters, lists, glow, offset, sides, nodes, boxes, totals, used, state):
    """Split leaves that are too large, or in which the emission differs too much. Returns the new number of nodes, and
    the state of the random numbers.

    The sums found so far are then discarded. Reusing them would keep boxes whose contents samples missed, and bias the
    whole downwards.
    """
    longest = 0.0
    for k in range(3):
        longest = max(longest, boxes[0, 3 + k] - boxes[0, k])
    index = 0
    while index < used and used + 2 <= len(nodes):
        size = max(
            boxes[index, 3] - boxes[index, 0], boxes[index, 4] - boxes[index, 1], boxes[index, 5] - boxes[index, 2]
        )
        if nodes[index].first < 0 and nodes[index].state == INSIDE and size > COARSEST * longest:
            _halve(nodes, boxes, index, used)
            used += 2
        index += 1
    state = sample_leaves(program, terms, parameters, lists, glow, offset, sides, nodes, boxes, totals, 0, used, state)
    whole = 0.0
    for index in range(used):
        whole += _mean(totals[index])
    index = 0
    while index < used and used + 2 <= len(nodes):
        total = totals[index]
        if nodes[index].first < 0 and total[VOLUME] > 0.0:
            # By Cauchy's inequality no less than ∫|e − mean| over the box.
            deviation = math.sqrt(max(total[VOLUME] * total[SQUARE] - _mean(total) ** 2, 0.0))
            if deviation > ROUGH * whole:
                _halve(nodes, boxes, index, used)
                state = sample_leaves(
                    program, terms, parameters, lists, glow, offset, sides, nodes, boxes, totals, used, used + 2, state
                )
                used += 2
        index += 1
    return used, state


@kernel
def _mean(total):
    """Integral of the mean of the channels."""
    return (total[RGB] + total[RGB + 1] + total[RGB + 2]) / 3.0


@kernel
def _find(nodes, index):
    """The node itself, or its only non-empty descendant."""
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
def _joined(a, a_spread, b, b_spread, share):
    """Mean and variance of two distributions together; the second has a ``share``."""
    apart = b - a
    return a + share * apart, a_spread + share * (b_spread - a_spread) + share * (1.0 - share) * apart * apart


@kernel
def gather(nodes, boxes, totals, brightness, least_fill, cells):
    """Fill in ``cells`` from the sums of the leaves. Returns their number.

    ``brightness`` is the mean of the emission over the shape; 0: it is uniform.
    """
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
            cell.volume = cell.mass = total[VOLUME]
            cell.direct = 1
            emission = _mean(total)
            if brightness > 0.0:
                cell.mass = emission / brightness
            for k in range(3):
                size = box[3 + k] - box[k]
                cell.low[k], cell.high[k] = box[k], box[3 + k]
                cell.spread[k] = size * size / 12.0
                cell.centroid[k] = (
                    total[VOLUME + 1 + k] / total[VOLUME] if total[VOLUME] > 0.0 else 0.5 * (box[k] + box[3 + k])
                )
                cell.mass_spread[k], cell.mass_centroid[k] = cell.spread[k], cell.centroid[k]
                if brightness > 0.0 and emission > 0.0:
                    cell.mass_centroid[k] = total[FIRST + k] / emission
                    cell.mass_spread[k] = max(total[SECOND + k] / emission - cell.mass_centroid[k] ** 2, 0.0)
            continue
        a, b = cells[cell.first], cells[cell.first + 1]
        cell.volume, cell.mass = a.volume + b.volume, a.mass + b.mass
        share = b.volume / cell.volume if cell.volume > 0.0 else 0.5
        mass_share = b.mass / cell.mass if cell.mass > 0.0 else 0.5
        for k in range(3):
            cell.low[k], cell.high[k] = min(a.low[k], b.low[k]), max(a.high[k], b.high[k])
            cell.centroid[k], cell.spread[k] = _joined(a.centroid[k], a.spread[k], b.centroid[k], b.spread[k], share)
            cell.mass_centroid[k], cell.mass_spread[k] = _joined(
                a.mass_centroid[k], a.mass_spread[k], b.mass_centroid[k], b.mass_spread[k], mass_share
            )
        size = (cell.high[0] - cell.low[0]) * (cell.high[1] - cell.low[1]) * (cell.high[2] - cell.low[2])
        if cell.volume >= least_fill * size:
            cell.direct = 1
    return used


class EmissionMoments(NamedTuple):
    """``cells`` are ``CELL``, for each non-empty box of a tree."""

    cells: np.ndarray
    mean: np.ndarray  # (3,) mean of the emission over the shape
    error: float  # bound of the relative error of its integral, apart from that of the volume
    rough: float  # relative variance of the emission at a point of a leaf, if leaves are chosen by their emission


def cells(tree: Tree, volume: float) -> np.ndarray:
    """``CELL`` for each non-empty box of the tree; ``volume`` is that of the shape, in its local space.

    A shape without interior in any box has none.
    """
    return emission_moments(tree, volume, None).cells


def _sample_all(tree: Tree, arrays, glow, offset, sides, nodes, boxes, totals, used: int, state) -> None:
    """``sample_leaves`` for the first ``used`` nodes, some of them at a time."""
    leaves = tree.boundary
    cost = float(leaf_costs(tree, leaves).mean()) / LANES * max(sides) ** 3 if len(leaves) else 1.0  # of a leaf
    together = max(int(SLICE / cost), 1)
    for first in range(0, used, together):
        check()
        last = min(first + together, used)
        state = np.uint64(
            sample_leaves(*arrays, glow, offset, sides, nodes, boxes, totals, first, last, np.uint64(state))
        )


def emission_moments(tree: Tree, volume: float, emission: CompiledEmission | None) -> EmissionMoments:
    """As ``cells``, for a varying emission. If it is dark everywhere, its ``mean`` is zero, and the cells are
    useless."""
    if tree.nodes["mass"][0] == 0.0:
        return EmissionMoments(np.zeros(0, CELL), np.ones(3), 0.0, 0.0)
    arrays = (tree.program, *tree.arrays, tree.lists)
    used, room = len(tree.nodes), 2 * MOST_PARTS if emission else 0
    nodes, boxes = np.zeros(used + room, NODE), np.zeros((used + room, 6))
    nodes[:used], boxes[:used] = tree.nodes, tree.boxes
    totals = np.zeros((used + room, SUMS))
    offset, state = tuple(tree.center.tolist()), np.uint64(1)
    if emission is None:
        leaves = np.count_nonzero((tree.nodes["first"] < 0) & (tree.nodes["state"] == BOUNDARY))
        sides = SIDES if leaves < FEW else COARSE_SIDES
        _sample_all(tree, arrays, (0, 0), offset, sides, nodes, boxes, totals, used, state)
    else:
        glow = emission.address, emission.parameters.ctypes.data
        used, state = divide(*arrays, glow, offset, TRIAL_SIDES, nodes, boxes, totals, used, state)
        totals[:] = 0.0
        _sample_all(tree, arrays, glow, offset, GLOW_SIDES, nodes, boxes, totals, used, np.uint64(state))
    nodes, boxes, totals = nodes[:used], boxes[:used], totals[:used]
    on_boundary = (nodes["first"] < 0) & (nodes["state"] == BOUNDARY)
    sampled, certain = totals[on_boundary, VOLUME].sum(), totals[~on_boundary, VOLUME].sum()
    if sampled > 0.0 and volume > certain:
        totals[on_boundary] *= (volume - certain) / sampled
    mean, error, rough = np.ones(3), 0.0, 0.0
    if emission is not None:
        mean = totals[:, RGB : RGB + 3].sum(axis=0) / volume
        light = totals[:, RGB : RGB + 3].mean(axis=1)
        lit = light > 0.0
        second = (totals[lit, VOLUME] * totals[lit, SQUARE] / light[lit]).sum()
        rough = max(second / light.sum() - 1.0, 0.0) if lit.any() else 0.0
        error = SAFETY * math.sqrt(totals[:, VARIANCE].sum()) / max(mean.mean() * volume, 1e-300)
    found = np.zeros(used, CELL)
    count = gather(nodes, boxes, totals, mean.mean() if emission else 0.0, FILL, found)
    return EmissionMoments(found[:count].copy(), mean, error, rough)
