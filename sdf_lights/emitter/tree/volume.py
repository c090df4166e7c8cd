# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume of a shape from its interior tree: full boxes exactly, jittered points on the surface.

The leaves on the boundary are split further, without storing the parts. Parts that turn out to be empty or full count
exactly; the rest is sampled, in parts of about the same size. If a field is close to linear across eight parts, only
its difference from a linear field is sampled, because the volume on one side of a plane is known. The error falls in
proportion to the number of evaluations or faster. The error of jittered points in the whole bounding box falls with the
power 2/3, because they spend most evaluations away from the surface.

The estimate is unbiased. Its variance comes from the differences of neighbouring points. These also contain the
differences of their surroundings, so the estimated variance is rather too large.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...interruption import SLICE, check
from ...jit import kernel, stack_array
from ..hashing import following, uniform_point
from ..intersection.fields import LANES, STACK, VALUES, run_terms
from ..intersection.membership import classify, contains
from .interior import Tree
from .parallel import TASKS, in_parallel

SAFETY = 4.0  # standard errors in the stated bound
BUDGET = 2.8e7  # rough ns of the estimate …
POOR, LARGER = 3e-3, 4.0  # … or so many times more, if the relative bound would be worse than this
OVERHEAD = 150.0  # rough ns of an evaluation, in addition to the field
PROGRAM_COST = 250.0  # rough ns for each instruction of a list, for LANES boxes
MOST_DIVISIONS = 16  # of each leaf
LINEAR = 1.0  # largest nonlinearity of a field, relative to its change from the centre of a cell to a corner
LEAST_SLOPE = 1e-3  # along an axis, relative to the greatest
GOLDEN = 0.6180339887498949  # (√5 − 1) / 2: the fractional parts of its multiples fill the unit interval evenly
BINS = 16  # of sizes of leaves, for each split
SEED = 1


@frozen
class Volume:
    """``value`` in m³ is off by ``error`` or more with a probability of one in 10,000; ``low`` and ``high`` are
    certain."""

    value: float
    error: float
    low: float
    high: float


@kernel
def _corner(lane, k):
    """Side of the part ``lane`` of eight along the axis k: −1 or 1."""
    return 2.0 * (lane >> k & 1) - 1.0


@kernel(forceinline=True)
def _classify_parts(program, terms, parameters, lists, node, cell, half, stack, states):
    """States of the eight parts of a cell: 1 inside, 0 outside, 2 neither. The values of a field stay in ``stack``."""
    size = (0.5 * half[0], 0.5 * half[1], 0.5 * half[2])
    for lane in range(LANES):
        for k in range(3):
            stack[k * LANES + lane] = cell[k] + _corner(lane, k) * size[k]
    if len(terms) == 0:
        chosen = lists[node.row_first : node.row_first + node.row_count]
        for lane in range(LANES):
            c = (stack[lane], stack[LANES + lane], stack[2 * LANES + lane])
            inside, outside = classify(program, c, size, chosen)
            states[lane] = 1 if inside else 0 if outside else 2
        return
    run_terms(terms, parameters, lists, node.row_first, node.row_count, LANES, stack)
    margin = node.lipschitz * math.sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2])
    for lane in range(LANES):
        value = stack[VALUES + lane]
        states[lane] = 0 if value > margin else 1 if value < -margin else 2


@kernel(forceinline=True)
def _slopes(stack):
    """Least-squares change, over half of a part along each axis, of a linear field with the values in ``stack`` at the
    centres of a cell's eight parts. Zeros if the values are far from linear.

    None is less than ``LEAST_SLOPE`` of the greatest, as ``_below`` requires.
    """
    mean, x, y, z = 0.0, 0.0, 0.0, 0.0
    for lane in range(LANES):
        value = stack[VALUES + lane]
        mean += 0.125 * value
        x += 0.125 * _corner(lane, 0) * value
        y += 0.125 * _corner(lane, 1) * value
        z += 0.125 * _corner(lane, 2) * value
    off = 0.0
    for lane in range(LANES):
        linear = mean + _corner(lane, 0) * x + _corner(lane, 1) * y + _corner(lane, 2) * z
        off = max(off, abs(stack[VALUES + lane] - linear))
    if not off < LINEAR * (abs(x) + abs(y) + abs(z)):
        return 0.0, 0.0, 0.0
    least = LEAST_SLOPE * max(abs(x), abs(y), abs(z))
    return (
        math.copysign(max(abs(x), least), x),
        math.copysign(max(abs(y), least), y),
        math.copysign(max(abs(z), least), z),
    )


@kernel(forceinline=True)
def _below(value, x, y, z):
    """Fraction of the cube |r|, |s|, |t| ≤ 1 where value + r x + s y + t z ≤ 0; the three are positive.

    From the distribution of a sum of uniform numbers.
    """
    least = x + y + z - value
    total = 0.0
    for lane in range(LANES):
        cut = max(least - 2.0 * ((lane & 1) * x + (lane >> 1 & 1) * y + (lane >> 2) * z), 0.0)
        total += (1.0 - 2.0 * ((lane ^ lane >> 1 ^ lane >> 2) & 1)) * cut * cut * cut
    return min(max(total / (48.0 * x * y * z), 0.0), 1.0)


@kernel(forceinline=True)
def _sample_program(program, lists, node, cell, half, state, states):
    """As ``_sample_field``, for one random point in each of the eight parts of a cell. ``states`` is scratch."""
    chosen = lists[node.row_first : node.row_first + node.row_count]
    total, variance = 0.0, 0.0
    for lane in range(LANES):
        state = following(state)
        u = uniform_point(state)
        p = (
            cell[0] + (u[0] + 0.5 * _corner(lane, 0) - 0.5) * half[0],
            cell[1] + (u[1] + 0.5 * _corner(lane, 1) - 0.5) * half[1],
            cell[2] + (u[2] + 0.5 * _corner(lane, 2) - 0.5) * half[2],
        )
        states[lane] = 1 if contains(program, p, chosen) else 0
        total += states[lane]
    for lane in range(0, LANES, 2):
        variance += (states[lane] - states[lane + 1]) ** 2
    return state, total, variance


@kernel(forceinline=True)
def _sample_field(
    terms, parameters, lists, node, cell, half, slopes, count, state, stack, states, points, values, found
):
    """Sample the ``count`` parts of a cell that are unsure by their ``states``.

    Unless ``slopes`` are zeros, the values at the centres of the parts are in ``stack``. Each unsure part gets an equal
    number of random points. Returns the generator's state, an estimate of how many of the parts are inside, and its
    variance. The rest is scratch.
    """
    reach = abs(slopes[0]) + abs(slopes[1]) + abs(slopes[2])
    part = 0
    for lane in range(LANES):
        if states[lane] == 2:
            found[part] = lane
            values[part] = stack[VALUES + lane]
            part += 1
    each = LANES // count
    for lane in range(LANES):
        part = found[lane // each % count]
        state = following(state)
        u = uniform_point(state)
        for k in range(3):
            points[k, lane] = 2.0 * u[k] - 1.0
            stack[k * LANES + lane] = cell[k] + 0.5 * (points[k, lane] + _corner(part, k)) * half[k]
    run_terms(terms, parameters, lists, node.row_first, node.row_count, LANES, stack)
    total, used = 0.0, count * each
    for lane in range(used):
        value = values[lane // each]
        inside = 1.0 if stack[VALUES + lane] <= 0.0 else 0.0
        if reach > 0.0 and value < reach:
            # If the field were linear: of the part, and at the point.
            expected, linear = 1.0, 1.0
            if value > -reach:
                expected = _below(value, abs(slopes[0]), abs(slopes[1]), abs(slopes[2]))
                for k in range(3):
                    value += points[k, lane] * slopes[k]
                linear = 1.0 if value <= 0.0 else 0.0
            inside -= linear
            total += expected
        points[0, lane] = inside
        total += inside
    variance = 0.0
    for lane in range(0, used, 2):
        variance += (points[0, lane] - points[0, (lane + 1) % used]) ** 2
    return state, total / each, variance / (each * each)


@kernel
def sample(program, terms, parameters, nodes, lists, boxes, leaves, coarsest, randoms, sums, calls):
    """Split the ``leaves`` into parts of at most the volumes ``coarsest`` (leaves,), and sample the parts that are
    still unsure.

    Adds to ``sums`` (4,) the volume that is certainly inside, the sampled volume, the estimate of its part inside, and
    the variance of that. ``randoms`` (1,) is the seed, and then that of the next leaves. Adds to ``calls``
    (leaves,) how many times the list of each leaf was evaluated.
    """
    stack = stack_array(STACK)
    # Centre and half sizes of cells, and whether the field is close to linear around them, as far as is known.
    pending = np.empty((LANES * MOST_DIVISIONS, 7))
    states, chosen = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    points, values = np.empty((3, LANES)), np.empty(LANES)
    random = randoms[0]
    full, unsure, inside, variance = sums[0], sums[1], sums[2], sums[3]
    for index in range(len(leaves)):
        node, box = nodes[leaves[index]], boxes[leaves[index]]
        for k in range(3):
            pending[0, k], pending[0, 3 + k] = 0.5 * (box[k] + box[3 + k]), 0.5 * (box[3 + k] - box[k])
        pending[0, 6] = 1.0 if len(terms) > 0 else 0.0
        top = 1
        while top > 0:
            top -= 1
            cell = (pending[top, 0], pending[top, 1], pending[top, 2])
            half = (pending[top, 3], pending[top, 4], pending[top, 5])
            linear = pending[top, 6]
            volume = half[0] * half[1] * half[2]  # of an eighth
            last = LANES * volume <= coarsest[index] or top + LANES > len(pending)
            slopes = (0.0, 0.0, 0.0)
            if last and linear == 0.0:
                states[:] = 2
            else:
                calls[index] += 1.0
                _classify_parts(program, terms, parameters, lists, node, cell, half, stack, states)
                if len(terms) > 0:
                    slopes = _slopes(stack)
            count = 0
            for lane in range(LANES):
                if states[lane] == 1:
                    full += volume
                elif states[lane] == 2:
                    count += 1
            if last and count > 0:
                calls[index] += 1.0
                if len(terms) > 0:
                    random, part, spread = _sample_field(
                        terms,
                        parameters,
                        lists,
                        node,
                        cell,
                        half,
                        slopes,
                        count,
                        random,
                        stack,
                        states,
                        points,
                        values,
                        chosen,
                    )
                else:
                    random, part, spread = _sample_program(program, lists, node, cell, half, random, states)
                unsure += count * volume
                inside += part * volume
                variance += spread * volume * volume
            if last:
                continue
            for lane in range(LANES):
                if states[lane] == 2:
                    for k in range(3):
                        pending[top, k] = cell[k] + 0.5 * _corner(lane, k) * half[k]
                        pending[top, 3 + k] = 0.5 * half[k]
                    pending[top, 6] = 1.0 if slopes[0] != 0.0 else 0.0
                    top += 1
    randoms[0] = random
    sums[0], sums[1], sums[2], sums[3] = full, unsure, inside, variance


def measure(tree: Tree) -> Volume:
    """Volume of the interior of a tree, in the shape's local space."""
    leaves = tree.boundary
    sizes = np.prod(tree.boxes[:, 3:] - tree.boxes[:, :3], axis=1)
    certain = float(sizes[tree.inside].sum())
    if not len(leaves):
        return Volume(certain, 0.0, certain, certain)
    costs = leaf_costs(tree, leaves)

    def sampled(coarsest: np.ndarray, share: slice, seed: int, parts: int = 1) -> np.ndarray:
        random, sums = np.array([seed], np.uint64), np.zeros(4)
        # The parts are handled in sequence, so their number changes no bit.
        for part in zip(np.array_split(leaves[share], parts), np.array_split(coarsest[share], parts)):
            check()
            calls = np.zeros(len(part[0]))
            sample(tree.program, *tree.arrays, tree.nodes, tree.lists, tree.boxes, *part, random, sums, calls)
        return sums

    def estimate(work: float) -> Volume:
        """The volume, for about so much work; no leaf is left out."""
        coarsest = _coarsest(sizes[leaves], costs, work)
        parts = math.ceil(max(work, costs.sum()) / TASKS / SLICE)
        found = in_parallel(lambda share: sampled(coarsest, slice(share, None, TASKS), SEED + share, parts))
        full, unsure, inside, variance = map(sum, zip(*found))
        low, high = certain + full, certain + full + unsure
        return Volume(min(max(low + inside, low), high), SAFETY * math.sqrt(variance), low, high)

    sampled(sizes, slice(0), SEED)  # compiles
    found = estimate(BUDGET)
    return found if found.error <= POOR * found.value else estimate(LARGER * BUDGET)


def _coarsest(sizes: np.ndarray, costs: np.ndarray, work: float) -> np.ndarray:
    """Greatest volume of the parts of each of the leaves of ``sizes``, for about ``work`` in total.

    It is the same for all, except for a factor of 8^u, where u runs evenly through [0, 1) from leaf to leaf. Otherwise
    leaves of one size would all be split once more, or none. Of the eight parts of a split, the surface enters about
    four.
    """
    levels = np.log(sizes) / math.log(LANES)
    bins = np.rint(BINS * (levels - levels.min())).astype(np.int64)
    weights = np.bincount(bins, costs)
    levels = levels.min() + np.arange(len(weights)) / BINS
    low, high = levels[-1] - MOST_DIVISIONS, levels[-1]
    for _ in range(40):
        middle = 0.5 * (low + high)
        whole, rest = np.divmod(np.maximum(levels - middle, 0.0), 1.0)
        if weights @ (4.0**whole * (1.0 + 3.0 * rest)) > work:
            low = middle
        else:
            high = middle
    return float(LANES) ** (high + GOLDEN * np.arange(len(sizes)) % 1.0)


def leaf_costs(tree: Tree, leaves: np.ndarray) -> np.ndarray:
    """Rough ns (leaves,) of what ``sample`` evaluates at the end of each leaf's list: a field twice, a program once."""
    rows = tree.nodes[leaves]
    if tree.field is None:
        return PROGRAM_COST * rows["row_count"]
    entries = np.concatenate([[0.0], np.cumsum(np.where(tree.lists < 0, 0.0, tree.field.costs[tree.lists]))])
    return 2.0 * (OVERHEAD + entries[rows["row_first"] + rows["row_count"]] - entries[rows["row_first"]])
