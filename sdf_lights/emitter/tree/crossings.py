# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals of a ray inside a shape with an interior tree: a walk through its boxes, front to back.

Boxes that are certainly empty or full cost nothing. In the others, a closed-form program is solved (``intervals``), or
the zeros of a field are covered (``cover``), each with the list of what matters in that box. Consecutive boxes with the
same list are merged. If the list is short, a box is handled as a whole instead of its parts.

Everything is in tree space. Lengths are in units of the ray's parameter, whose unit is |d|.
"""

from __future__ import annotations

import math

from ...jit import kernel, stack_array, table
from ...replaced import replaced_on_gpu
from ...sdf.program import INSTRUCTION
from ...vec import length
from ..intersection.cover import (
    AT_END,
    COLUMNS,
    END,
    FALL,
    OPEN,
    PENDING,
    PENDING_SIZE,
    PRECISION,
    RESOLUTION,
    RISE,
    SIGN,
    UNKNOWN,
    add,
    cover,
    insert,
)
from ..intersection.fields import STACK, lamp_lists, lamp_terms, zeros
from ..intersection.intervals import solve
from .nodes import BOUNDARY, INSIDE, lamp_nodes
from .splitting_programs import SHORT_PROGRAM

WAITING = 2 * 64  # float64 for the boxes that wait on the way down a tree, which is never deeper than 64
SHORT_FIELD = 13  # rows of a list of terms that needs no smaller boxes, if the field is monotonic along the ray
TOGETHER = PENDING // 4  # maximum number of merged boxes of a field

instructions = table("lamp_instructions", INSTRUCTION)


@kernel
def _clip(spans, first, count, start, end, inside, limit, found):
    """Insert the changes of state of the intervals in rows from ``first``, between ``start``, with the state
    ``inside``, and ``end``.

    Returns (changes found so far, the state at ``end``).
    """
    before, after = False, False
    for index in range(first, first + count):
        before = before or spans[index, 0] <= start < spans[index, 1]
    if before != inside:
        found = insert(spans, limit, found, start)
    for index in range(first, first + count):
        low, high = spans[index, 0], spans[index, 1]
        if high <= start or low >= end:
            continue
        if low > start:
            found = insert(spans, limit, found, low)
        if high < end:
            found = insert(spans, limit, found, high)
        else:
            after = True
    return found, after


@kernel(forceinline=True)
def down(first, axis, split, ray, low, high, waiting, depth):
    """Go from a box, split in two, to the part that a ray enters first between ``low`` and ``high``. The other part
    waits, if the ray enters it. Returns (index of the part, where the ray leaves it, number of waiting boxes)."""
    position, rate = ray[axis], ray[3 + axis]
    if rate == 0.0:
        return first + (0 if position < split else 1), high, depth
    crossing = (split - position) * ray[6 + axis]
    near = 0 if rate > 0.0 else 1
    if crossing >= high:
        return first + near, high, depth
    if crossing <= low:
        return first + 1 - near, high, depth
    waiting[2 * depth], waiting[2 * depth + 1] = first + 1 - near, high
    return first + near, crossing, depth + 1


@kernel(forceinline=True)
def rates(low, high, d):
    """Largest rates at which the field can fall and rise along a ray, per unit of its parameter, if its gradient is
    between two vectors."""
    ax, ay, az = low[0] * d[0], low[1] * d[1], low[2] * d[2]
    bx, by, bz = high[0] * d[0], high[1] * d[1], high[2] * d[2]
    least = min(ax, bx) + min(ay, by) + min(az, bz)
    most = max(ax, bx) + max(ay, by) + max(az, bz)
    return (-least, most) if least <= most else (math.inf, math.inf)


@kernel(forceinline=True)
def _rates(node, ray):
    """``rates`` in a box."""
    gradient = node.gradient
    return rates(
        (gradient[0, 0], gradient[0, 1], gradient[0, 2]),
        (gradient[1, 0], gradient[1, 1], gradient[1, 2]),
        (ray[3], ray[4], ray[5]),
    )


@kernel(forceinline=True)
def _in_pairs(spans, limit, found, end, unresolved, evaluations):
    """What ``walk`` returns, for so many ``found`` zeros."""
    if found % 2 == 1:
        found = insert(spans, limit, found, end)
    if found > 2 * limit:
        unresolved += end - spans[limit - 1, 1]
        found = 2 * limit
    return found // 2, unresolved, evaluations


@kernel
def walk(block, row, o, d, start, end, spans):
    """``crossings``, with the number of evaluations of the field: (count, unresolved, evaluations)."""
    nodes, lists = lamp_nodes(block)[row.first_node :], lamp_lists(block)[row.first_list :]
    closed, limit = row.instruction_count > 0, row.rows
    if not closed and nodes[0].row_count == 1:
        term = lamp_terms(block)[row.first_term + lists[nodes[0].row_first]]
        if term.zeros != 0:
            found, steps = zeros(block, term, o, d, start, end, spans, limit)
            return _in_pairs(spans, limit, found, end, 0.0, steps)
    speed = length(d)
    size = length((row.high[0], row.high[1], row.high[2])) / speed
    ray, waiting = stack_array(9), stack_array(WAITING)
    pending, stack = stack_array(PENDING_SIZE), stack_array(STACK)
    for axis in range(3):
        ray[axis], ray[3 + axis], ray[6 + axis] = o[axis], d[axis], 1.0 / d[axis]

    # ``value`` is the field at the end of the last box, or its sign; it is unknown until ``pending`` is covered.
    value, found, unresolved, evaluations = SIGN, 0, 0.0, 0
    used, list_first, list_count, since = 0, -1, 0, start
    solved_first, solved_count, solved = -1, 0, 0
    index, low, high, depth, first = 0, start, end, 0, True
    while True:
        boundary = False
        while index >= 0:
            node = nodes[index]
            boundary = node.state == BOUNDARY
            if not boundary or node.first < 0:
                break
            if closed:
                if node.row_count <= SHORT_PROGRAM:
                    break
            elif node.turns == 0 and node.row_count <= SHORT_FIELD:
                fall, rise = _rates(node, ray)
                if fall <= 0.0 or rise <= 0.0:
                    break
            index, high, depth = down(node.first, node.axis, node.split, ray, low, high, waiting, depth)
        if used > 0:
            same = boundary and node.row_first == list_first and node.row_count == list_count
            if closed and not same:
                if list_first != solved_first or list_count != solved_count:
                    program = instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count]
                    solved = solve(program, o, d, spans[limit:], lists[list_first : list_first + list_count])
                    solved_first, solved_count = list_first, list_count
                found, inside = _clip(spans, limit, solved, since, low, value < 0.0, limit, found)
                value, used = (-SIGN if inside else SIGN), 0
            elif not closed and (index < 0 or boundary and not same or used >= TOGETHER):
                found, last, left, more = cover(
                    block,
                    row,
                    list_first,
                    list_count,
                    o,
                    d,
                    pending,
                    used,
                    RESOLUTION * size,
                    PRECISION * size,
                    spans,
                    limit,
                    found,
                    stack,
                )
                unresolved += left
                evaluations += more
                if math.isnan(value):  # fields of different lists agree in their signs, not in their values
                    value = last if same else math.copysign(SIGN, last)
                used = 0
        if index < 0:
            break
        if not boundary:
            certain = -SIGN if node.state == INSIDE else SIGN
            if math.isnan(value):
                pending[(used - 1) * COLUMNS + AT_END] = certain
            elif (value > 0.0) != (certain > 0.0):
                found = insert(spans, limit, found, low)
            value = certain
        elif closed:
            if used == 0:
                list_first, list_count, since, used = node.row_first, node.row_count, low, 1
        else:
            fall, rise = _rates(node, ray)
            fall, rise = min(fall, node.lipschitz * speed), min(rise, node.lipschitz * speed)
            if used == 0:
                list_first, list_count = node.row_first, node.row_count
                if first:  # the sign at the start is unknown: a part of zero length evaluates it
                    used = add(pending, used, low, SIGN, low, UNKNOWN, fall, rise, OPEN)
                    value = UNKNOWN
            place = (used - 1) * COLUMNS
            both_fall, both_rise = max(fall, pending[place + FALL]), max(rise, pending[place + RISE])
            if math.isnan(value) and not first and (both_fall <= 0.0 or both_rise <= 0.0):  # monotonic together
                pending[place + END], pending[place + FALL], pending[place + RISE] = high, both_fall, both_rise
            else:
                used = add(pending, used, low, value, high, UNKNOWN, fall, rise, OPEN)
            value = UNKNOWN
        first = False
        low = high
        index = -1
        if depth > 0:
            depth -= 1
            index, high = int(waiting[2 * depth]), waiting[2 * depth + 1]
    return _in_pairs(spans, limit, found, end, unresolved, evaluations)


@replaced_on_gpu
@kernel
def crossings(block, row, o, d, start, end, spans):
    """All intervals of the ray o + s·d, start ≤ s ≤ end, in the lamp ``row``: (start, end) in the rows of ``spans``.

    o, d and the part of the ray, which lies in the tree's box, are in tree space; d may have any length but zero.
    Returns (count, unresolved): the number of intervals, at most ``row.rows`` and sorted, and the length that was
    uncertain or had no row. If the lamp is a program, ``spans`` has ``intervals.rows_needed`` additional rows.
    """
    count, unresolved, _ = walk(block, row, o, d, start, end, spans)
    return count, unresolved
