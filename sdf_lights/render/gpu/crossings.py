# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals of a ray inside a field lamp, on the GPU: a walk through its interior tree, as on the CPU.

Threads of one group take as many iterations of a loop as the slowest of them, and every operation in an iteration costs
time for all. So there are three loops in sequence, each with one task. The first goes down the tree, to the parts of
the ray in boxes on the boundary. The second goes along these, with one evaluation of the field per iteration. The third
finds the zeros between two values.

The field is evaluated as a whole. It has the signs of a box's list (``intersection.fields``), and is nowhere farther
from zero, so the bounds of the list's slopes are valid for its zeros. A box in which the field is monotonic along the
ray is handled as a whole. Everything is in tree space. Lengths are in units of the ray's parameter, whose unit is |d|.
"""

from __future__ import annotations

import math

import numpy as np

from ...emitter.intersection.cover import SIGN, estimate, first_estimate, refine_bracket, signed
from ...emitter.tree.crossings import WAITING, down, rates
from ...emitter.tree.interior import BOUNDARY, INSIDE
from ...jit import kernel, stack_array, table
from ...vec import length, madd

INTERVALS = 64  # of a ray
STRETCHES = 32  # of a ray in boxes on the boundary, found before the march along them
LEAST_STEP = 2e-4  # along a ray, relative to the size of the lamp
PRECISION = 1e-7  # of a zero, likewise: the resolution of float32
PATIENCE = 1500  # evaluations before the shortest step grows …
GROWTH = 1.1  # … by this factor each time
MOST_ROUNDS = 24  # of narrowing a bracket
RELAXATION = 0.95  # fraction of the step at which the balls around two points would touch at the present slope
LARGEST_HALF = 6e4  # larger bounds of the gradient are not stored

# Of a part of a ray. BEFORE: the state of the boxes between it and the previous part; −1 if there are none.
START, END, FALL, RISE, BEFORE, COLUMNS = range(6)
FROM, AT_FROM, TO, AT_TO, BRACKET = range(5)  # of a bracket of one zero
NOTHING, SIDE, VALUE = 0, 1, 2  # known facts about the field at the end of the ray so far

# A node of an interior tree in few words, because GPUs wait for memory. ``what``: state, axis, whether the gradient is
# bounded, and the index of the children plus one. ``slopes``: for each axis two float16, bounds of the gradient.
FLAT_NODE = np.dtype(
    [("what", np.int64), ("split", np.float64), ("lipschitz", np.float64), ("slopes", np.uint32, (3,))]
)
BOUNDED, SHIFT = 16, 5
PLACE = 1 << SHIFT  # from this bit on: the index of the children

lamp_walk = table("lamp_walk", FLAT_NODE)


@kernel
def halves(word):
    """Two float16 of a word; written in GLSL."""


@kernel
def choose(block, row):
    """Make ``field_at`` that of a lamp; written in GLSL."""


@kernel
def field_at(p):
    """The field at a point of tree space; written in GLSL."""


@kernel
def _locate(o, d, brackets, found, precision, spans):
    """Write the zeros in brackets to ``spans``, in order."""
    index, fresh, rounds = 0, True, 0
    start, at_start, end, at_end, third, at_third = 0.0, 0.0, 0.0, 0.0, math.nan, 0.0
    while index < found:
        if fresh:
            place = index * BRACKET
            start, at_start = brackets[place + FROM], brackets[place + AT_FROM]
            end, at_end = brackets[place + TO], brackets[place + AT_TO]
            third, rounds, fresh = math.nan, 0, False
        t = start
        if math.isnan(third):
            t = first_estimate(start, at_start, end, at_end, 0.0, 0.0)
        else:
            t = estimate(start, at_start, end, at_end, third, at_third, precision)
        value = signed(field_at(madd(o, t, d)))
        zero, end, at_end, third, at_third = refine_bracket(start, at_start, end, at_end, third, t, value, precision)
        if min(abs(at_end), abs(at_third)) <= SIGN:
            third = math.nan
        start, at_start = t, value
        rounds += 1
        if abs(end - start) <= precision or rounds == MOST_ROUNDS:
            zero = 0.5 * (start + end)
        if not math.isnan(zero):
            spans[index >> 1, index & 1] = zero
            index += 1
            fresh = True


@kernel
def crossings(block, row, o, d, start, end, spans):
    """Replaces ``tree.crossings.crossings``."""
    nodes = lamp_walk(block)[row.first_node :]
    speed = length(d)
    size = length((row.high[0], row.high[1], row.high[2])) / speed
    least = LEAST_STEP * size
    ray, waiting = stack_array(9), stack_array(WAITING)
    stretches, brackets = stack_array(STRETCHES * COLUMNS), stack_array(2 * INTERVALS * BRACKET)
    for axis in range(3):
        # A component so slow that its inverse could overflow does not move through a box.
        moving = abs(d[axis]) > 1e-20 * speed
        ray[axis], ray[3 + axis], ray[6 + axis] = o[axis], d[axis] if moving else 0.0, 1.0 / d[axis] if moving else 0.0
    choose(block, row)

    index, low, high, depth, walking = 0, start, end, 0, True
    certain = -1  # state of the boxes since the last one on the boundary
    t, value, known, inside = start, SIGN, NOTHING, False
    slope, careful = -math.inf, False
    found, unresolved, evaluations = 0, 0.0, 0
    while walking:
        count, first, falls, rises, before = 0, start, math.inf, math.inf, -1
        while walking and count < STRETCHES:
            node = nodes[index]
            what, bound = node.what, node.lipschitz * speed
            state = what & 3
            x, y, z = halves(node.slopes[0]), halves(node.slopes[1]), halves(node.slopes[2])
            fall, rise = rates((x[0], y[0], z[0]), (x[1], y[1], z[1]), d)
            if what & BOUNDED == 0:
                fall, rise = math.inf, math.inf
            if state == BOUNDARY and what >= PLACE and fall > 0.0 and rise > 0.0:
                index, high, depth = down(
                    (what >> SHIFT) - 1, what >> 2 & 3, node.split, ray, low, high, waiting, depth
                )
                continue
            torn = state != BOUNDARY and certain >= 0 and certain != state
            if state == BOUNDARY or torn:
                last, fall, rise = high, min(fall, bound), min(rise, bound)
                if torn:  # between a full box and an empty one
                    last, fall, rise = low, 0.0, 0.0
                both_fall, both_rise = max(fall, falls), max(rise, rises)
                if certain < 0 and count > 0 and (both_fall <= 0.0 or both_rise <= 0.0):  # monotonic together
                    falls, rises = both_fall, both_rise
                    count -= 1
                else:
                    first, falls, rises, before = low, fall, rise, certain
                place = count * COLUMNS
                stretches[place + START], stretches[place + END] = first, last
                stretches[place + FALL], stretches[place + RISE], stretches[place + BEFORE] = falls, rises, before
                count += 1
                certain = -1
            if state != BOUNDARY:
                certain = state
            low = high
            if depth > 0:
                depth -= 1
                index, high = int(waiting[2 * depth]), waiting[2 * depth + 1]
            else:
                walking = False

        current, fresh = 0, True
        stop, fall, rise, side = start, 0.0, 0.0, inside
        while current < count:
            if fresh:
                place = current * COLUMNS
                first, stop = stretches[place + START], stretches[place + END]
                fall, rise, before = stretches[place + FALL], stretches[place + RISE], int(stretches[place + BEFORE])
                fresh, side = False, inside
                if before >= 0:
                    side = before == INSIDE
                    known, value = SIDE, -SIGN if side else SIGN
                if side == inside:
                    t = first
            turning = side != inside  # start of the boxes before this part
            monotonic = fall <= 0.0 or rise <= 0.0
            ahead, behind = (fall, rise) if value > 0.0 else (rise, fall)
            distance = abs(value)
            safe = max(distance / ahead, least) if ahead > 0.0 else math.inf
            asked, longer = stop, False
            if turning or known == NOTHING or known == SIDE and not monotonic:
                asked = t
            elif not monotonic:
                step = safe
                if not careful:
                    # The ball around the next point touches the one around this, if |field| continues linearly.
                    falling = max(min(slope, 0.9 * behind), -ahead)
                    step = max(safe, RELAXATION * distance * (1.0 + behind / ahead) / (behind - falling))
                longer, asked = step > safe, min(t + step, stop)
            g = signed(field_at(madd(o, asked, d)))
            evaluations += 1
            if evaluations > PATIENCE:
                least *= GROWTH
            step, careful = asked - t, False
            differ = turning or (g < 0.0) != inside
            if step > 0.0 and not monotonic:
                reach = distance / ahead + (g / rise if g > 0.0 else -g / fall)
                careful = longer and (differ or reach < step)
                if not careful:
                    unresolved += max(step - reach, 0.0)
                    slope = 0.3 * max(slope, -ahead) + 0.7 * (abs(g) - distance) / step
            if not careful:
                if differ:
                    if found < 2 * INTERVALS:
                        place = found * BRACKET
                        brackets[place + FROM], brackets[place + AT_FROM] = t, value
                        brackets[place + TO], brackets[place + AT_TO] = asked, g
                    found += 1
                    slope = -math.inf
                if turning:
                    t, inside = first, side
                else:
                    t, value, known, inside = asked, g, VALUE, g < 0.0
                    side = inside
                    if t >= stop:
                        current += 1
                        fresh = True
                if found > 2 * INTERVALS:
                    unresolved += end - t
                    current, walking = count, False
    if certain >= 0 and (certain == INSIDE) != inside and found < 2 * INTERVALS:
        place = found * BRACKET
        brackets[place + FROM], brackets[place + AT_FROM] = t, SIGN
        brackets[place + TO], brackets[place + AT_TO] = t, SIGN
        found += 1
    found = min(found, 2 * INTERVALS)
    _locate(o, d, brackets, found, PRECISION * size, spans)
    if found % 2 == 1:
        spans[found >> 1, 1] = end
        found += 1
    return found >> 1, unresolved


def flat_nodes(nodes: np.ndarray) -> np.ndarray:
    """Records ``FLAT_NODE`` (n,) of records ``NODE`` (n,)."""
    found = np.zeros(len(nodes), FLAT_NODE)
    found["split"], found["lipschitz"] = nodes["split"], nodes["lipschitz"]
    bounds = nodes["gradient"]
    bounded = (np.abs(bounds) < LARGEST_HALF).all(axis=(1, 2)) & (bounds[:, 0] <= bounds[:, 1]).all(axis=1)
    halves = np.stack(
        [
            _half(np.where(bounded[:, None], sign * bounds[:, side], 0.0)) * np.float16(sign)
            for side, sign in ((0, -1), (1, 1))
        ],
        axis=2,
    )  # nodes, axes, sides
    found["slopes"] = np.ascontiguousarray(halves).view(np.uint32)[:, :, 0]
    children = nodes["first"].astype(np.int64) + 1 << SHIFT
    found["what"] = children + bounded * BOUNDED + (nodes["axis"] << 2) + nodes["state"]
    return found


def _half(numbers: np.ndarray) -> np.ndarray:
    """The least float16 numbers that are not below the given ones, and not so small that a GPU may treat them as
    zero."""
    with np.errstate(over="ignore"):
        rounded = numbers.astype(np.float16)
    rounded = np.where(rounded < numbers, np.nextafter(rounded, np.float16(np.inf)), rounded)
    least = np.finfo(np.float16).tiny
    return np.where(np.abs(rounded) < least, np.where(numbers > 0.0, least, np.float16(0.0)), rounded)
