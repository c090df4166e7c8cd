# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume of a shape from its interior tree: full boxes exactly, jittered points where the surface is.

The leaves on the boundary are divided further, without being kept. Parts that turn out to be empty or full count
exactly; what is left is sampled, one point in each eighth of each part, where all parts are of about the same size. The
error falls in proportion to the number of evaluations, where that of jittered points in the whole bounding box falls
with its 2/3rd power, since nothing is spent where the surface is not. So a trial tells how much work an error needs.

The estimate is unbiased. Its variance is made of the differences of neighbouring points, which also hold what their
surroundings differ by, so it errs on the large side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..jit import kernel, stack_array
from .fields import LANES, STACK, VALUES, run_terms
from .hashing import following, uniform_point
from .interior import Tree
from .membership import classify, contains

SAFETY = 4.0  # standard errors that the stated bound is made of
ACCURACY = 2e-4  # relative bound on the error at which it is good enough
BUDGET = 2.5e7  # rough ns that the estimate may take …
POOR, LARGER = 3e-3, 4.0  # … or so many times more, where the relative bound would be worse than this
TRIAL = 0.1  # of the budget, for a trial
OVERHEAD = 100.0  # rough ns of an evaluation, besides the field
PROGRAM_COST = 800.0  # rough ns for each instruction of a list, for LANES boxes
MOST_DIVISIONS = 16  # of each leaf
SEED = 1


@dataclass(frozen=True)
class Volume:
    """``value`` in m³ is off by ``error`` or more with a chance of one in 10,000; ``low`` and ``high`` are certain."""

    value: float
    error: float
    low: float
    high: float


@kernel
def _corner(lane, k):
    """Side of the part ``lane`` of eight along the axis k: −1 or 1."""
    return 2.0 * (lane >> k & 1) - 1.0


@kernel
def _classify_parts(program, terms, parameters, lists, node, cell, half, stack, states):
    """States of the eight parts of a cell: 1 inside, 0 outside, 2 neither."""
    size = (0.5 * half[0], 0.5 * half[1], 0.5 * half[2])
    for lane in range(LANES):
        for k in range(3):
            stack[k * LANES + lane] = cell[k] + _corner(lane, k) * size[k]
    if len(terms) == 0:
        chosen = lists[node.row_first:node.row_first + node.row_count]
        for lane in range(LANES):
            c = (stack[lane], stack[LANES + lane], stack[2 * LANES + lane])
            inside, outside = classify(program, c, size, chosen)
            states[lane] = 1 if inside else 0 if outside else 2
        return
    run_terms(terms, parameters, lists, node.row_first, node.row_count, stack)
    margin = node.lipschitz * math.sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2])
    for lane in range(LANES):
        value = stack[VALUES + lane]
        states[lane] = 0 if value > margin else 1 if value < -margin else 2


@kernel
def _sample_parts(program, terms, parameters, lists, node, cell, half, state, stack, states):
    """Whether a random point of each of the eight parts of a cell is inside: 1 or 0. Returns the generator's state."""
    for lane in range(LANES):
        state = following(state)
        u = uniform_point(state)
        for k in range(3):
            stack[k * LANES + lane] = cell[k] + (u[k] + 0.5 * _corner(lane, k) - 0.5) * half[k]
    if len(terms) == 0:
        chosen = lists[node.row_first:node.row_first + node.row_count]
        for lane in range(LANES):
            p = (stack[lane], stack[LANES + lane], stack[2 * LANES + lane])
            states[lane] = 1 if contains(program, p, chosen) else 0
        return state
    run_terms(terms, parameters, lists, node.row_first, node.row_count, stack)
    for lane in range(LANES):
        states[lane] = 1 if stack[VALUES + lane] <= 0.0 else 0
    return state


@kernel
def sample(program, terms, parameters, nodes, lists, boxes, leaves, coarsest, seed):
    """Divide every leaf of ``leaves`` into parts of the volume ``coarsest`` at most, and sample what is still unsure.

    Returns the volume that is certainly inside, the volume of what was sampled, the estimate of its part inside, the
    variance of that, and how many times the list of each leaf was evaluated.
    """
    stack = stack_array(STACK)
    pending = np.empty((LANES * MOST_DIVISIONS, 6))
    states = np.empty(LANES, np.int64)
    random = np.uint64(seed)
    full, unsure, inside, variance = 0.0, 0.0, 0.0, 0.0
    calls = np.zeros(len(leaves))
    for index in range(len(leaves)):
        node, box = nodes[leaves[index]], boxes[leaves[index]]
        for k in range(3):
            pending[0, k], pending[0, 3 + k] = 0.5 * (box[k] + box[3 + k]), 0.5 * (box[3 + k] - box[k])
        top = 1
        while top > 0:
            top -= 1
            cell = (pending[top, 0], pending[top, 1], pending[top, 2])
            half = (pending[top, 3], pending[top, 4], pending[top, 5])
            volume = half[0] * half[1] * half[2]  # of an eighth
            calls[index] += 1.0
            if LANES * volume <= coarsest or top + LANES > len(pending):
                random = _sample_parts(program, terms, parameters, lists, node, cell, half, random, stack, states)
                unsure += LANES * volume
                for lane in range(LANES):
                    inside += volume * states[lane]
                for lane in range(0, LANES, 2):
                    variance += (volume * (states[lane] - states[lane + 1])) ** 2
                continue
            _classify_parts(program, terms, parameters, lists, node, cell, half, stack, states)
            for lane in range(LANES):
                if states[lane] == 1:
                    full += volume
                elif states[lane] == 2:
                    for k in range(3):
                        pending[top, k] = cell[k] + 0.5 * _corner(lane, k) * half[k]
                        pending[top, 3 + k] = 0.5 * half[k]
                    top += 1
    return full, unsure, inside, variance, calls


def measure(tree: Tree) -> Volume:
    """Volume of the interior of a tree, in the shape's own space."""
    leaves = tree.boundary
    sizes = np.prod(tree.boxes[:, 3:] - tree.boxes[:, :3], axis=1)
    certain = float(sizes[tree.inside].sum())
    if not len(leaves):
        return Volume(certain, 0.0, certain, certain)
    costs = _costs(tree, leaves)

    def estimate(work: float) -> tuple[Volume, float]:
        """The volume, and the work that it took: about as much as is asked for, but no leaf is left out."""
        full, unsure, inside, variance, calls = sample(
            tree.program, *tree.arrays, tree.nodes, tree.lists, tree.boxes, leaves, _coarsest(sizes[leaves], costs, work),
            SEED)
        found = Volume(certain + full + inside, SAFETY * math.sqrt(variance), certain + full, certain + full + unsure)
        return found, float(calls @ costs)

    found, work = estimate(TRIAL * BUDGET)
    if found.error <= ACCURACY * found.value:
        return found

    def needed(accuracy: float) -> float:
        return work * found.error / (accuracy * found.value) if found.value > 0.0 else math.inf

    return estimate(min(needed(ACCURACY), max(BUDGET, min(needed(POOR), LARGER * BUDGET))))[0]


def _coarsest(sizes: np.ndarray, costs: np.ndarray, work: float) -> float:
    """Volume of parts of leaves of ``sizes`` at which at most ``work`` is done, if that is possible.

    Of the eight parts that a division makes of a box, the surface enters about four.
    """
    low, high = sizes.max() * float(LANES) ** -MOST_DIVISIONS, sizes.max()
    for _ in range(40):
        middle = math.sqrt(low * high)
        divisions = np.maximum(np.ceil(np.log(sizes / middle) / math.log(LANES)), 0.0)
        if costs @ 4.0**divisions > work:
            low = middle
        else:
            high = middle
    return high


def _costs(tree: Tree, leaves: np.ndarray) -> np.ndarray:
    """Rough ns of an evaluation of each leaf's list."""
    rows = tree.nodes[leaves]
    if tree.field is None:
        return PROGRAM_COST * rows["row_count"]
    entries = np.concatenate([[0.0], np.cumsum(np.where(tree.lists < 0, 0.0, tree.field.costs[tree.lists]))])
    return OVERHEAD + entries[rows["row_first"] + rows["row_count"]] - entries[rows["row_first"]]
