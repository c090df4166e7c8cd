# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which operands matter in a box: lists of terms or instructions without those that certainly change nothing there.

For fields this is the Lipschitz pruning of Barbier, Sanchez, Paris, Michel, Lambert, Boubekeur, Paulin and Thonat 2025
("Lipschitz pruning: hierarchical simplification of primitive-based SDFs"). If two operands differ at the centre by more
than their operator's blend width, and by so much that no point of the box can make up for it, one of them is the
result. Where only the sign of the result matters, as in the end it does, more can be left out: for example a part of a
union that does not enter the box, even if it is close. So the field of a pruned list has the sign of the whole field in
its box, but not its value.

For closed-form programs, the flags of ``membership`` tell which sets contain all or nothing of the box.
"""

from __future__ import annotations

from ...jit import call_field, kernel
from ...sdf.shapes.base import Family
from ..intersection.fields import LANES, NEGATED, VALUES
from ..intersection.membership import INTERSECTION, UNION, classify_primitive, combined

LESSER, GREATER, WITHOUT = int(Family.UNION), int(Family.INTERSECTION), int(Family.DIFFERENCE)


@kernel
def _negated(out, used):
    """The list that ends at ``used``, with its sign changed. Returns its new end."""
    if out[used - 1] == NEGATED:
        return used - 1
    out[used] = NEGATED
    return used + 1


@kernel
def _relevant_operand(family, a, b, change_a, change_b, blend_width, near_field):
    """Operand that a join reduces to in a box: 1 or 2, −1 or −2 with its sign changed, 0 if both may matter.

    a and b are the operands' values at the centre, which change by at most ``change_a`` and ``change_b`` in the box.
    For values of the join farther than ``near_field`` from zero, only the sign counts. For example, a union is known
    from b if a is greater than ``near_field`` and the blend width.
    """
    margin, far = blend_width + change_a + change_b, blend_width + near_field
    above_a, below_a = a - change_a > far, -a - change_a > far
    above_b, below_b = b - change_b > far, -b - change_b > far
    if family == LESSER:
        if b - a > margin or above_b and b >= a:
            return 1
        return 2 if a - b > margin or above_a else 0
    if family == GREATER:
        if a - b > margin or below_b and b <= a:
            return 1
        return 2 if b - a > margin or below_a else 0
    if family == WITHOUT:
        if a + b > margin or above_b and a + b >= 0.0:
            return 1
        return -2 if -a - b > margin or below_a else 0
    if abs(b) - abs(a) > margin or (above_b or below_b) and abs(b) >= abs(a):
        return 1 if b > 0.0 else -1
    if abs(a) - abs(b) > margin or above_a or below_a:
        return 2 if a > 0.0 else -2
    return 0


@kernel
def _keep_operand(out, used, start, middle, relevant):
    """Keep the operand ``relevant`` of two consecutive lists in ``out``. Returns the new end."""
    if abs(relevant) == 1:
        used = middle
    else:
        for index in range(middle, used):
            out[start + index - middle] = out[index]
        used += start - middle
    return used if relevant > 0 else _negated(out, used)


@kernel
def prune_field(
    terms,
    parameters,
    near_fields,
    gains,
    columns,
    bounds,
    lists,
    first,
    count,
    radius,
    stack,
    out,
    used,
    slopes,
    starts,
    steepness,
):
    """Evaluate a list at the centres of ``LANES`` boxes of half diagonal ``radius``, and prune it for each of them.

    ``stack`` holds the centres and gets the values, as in ``fields.run_terms``. Row i of ``out`` (LANES, count) gets
    the list of box i, ``used[i]`` its length, and ``slopes[i]`` a Lipschitz bound of the field of that list there. That
    field is as far from zero as the whole one, or farther. ``near_fields`` and ``gains`` are those of
    ``fields.CompiledField``. A term without a Lipschitz bound for all of space has one for these boxes in the column
    ``columns[term]`` of ``bounds``. ``starts`` and ``steepness`` are scratch, (LANES, DEEPEST).
    """
    points = stack.ctypes.data
    numbers = parameters.ctypes.data
    used[:] = 0
    depth = 0
    for index in range(first, first + count):
        number = lists[index]
        if number == NEGATED:
            for lane in range(LANES):
                place = VALUES + (depth - 1) * LANES + lane
                stack[place] = -stack[place]
                used[lane] = _negated(out[lane], used[lane])
            continue
        term = terms[number]
        depth -= term.arity
        for lane in range(LANES):
            chosen, slope = 0, term.lipschitz
            if columns[number] >= 0:
                slope = bounds[columns[number]]
            if term.arity == 1:
                slope = min(slope, gains[number] * steepness[lane, depth])
            elif term.arity == 2:
                place = VALUES + depth * LANES + lane
                slope_a, slope_b = steepness[lane, depth], steepness[lane, depth + 1]
                chosen = _relevant_operand(
                    term.family,
                    stack[place],
                    stack[place + LANES],
                    radius * slope_a,
                    radius * slope_b,
                    term.blend_width,
                    near_fields[number],
                )
                slope = min(slope, gains[number] * max(slope_a, slope_b))
                if chosen != 0:
                    slope = slope_a if abs(chosen) == 1 else slope_b
                    used[lane] = _keep_operand(
                        out[lane], used[lane], starts[lane, depth], starts[lane, depth + 1], chosen
                    )
            else:
                starts[lane, depth] = used[lane]
            if chosen == 0:
                out[lane, used[lane]] = number
                used[lane] += 1
            steepness[lane, depth] = slope
        place = points + 8 * (VALUES + depth * LANES)
        call_field(term.address, LANES, points if term.arity == 0 else place, numbers + 8 * term.parameters, place)
        depth += 1
    for lane in range(LANES):
        slopes[lane] = steepness[lane, 0]


@kernel(forceinline=True)
def prune_program(program, lists, first, count, c, h, out, starts):
    """Prune a list for the box with centre c and half sizes h into ``out``, which is as long as the list.

    Returns the length of the new list and the flags (inside, outside) of the whole box, as ``membership.classify``; the
    list is empty if one of them is set. ``starts`` is scratch, (DEEPEST,).
    """
    inside, outside = 0, 0
    used, depth = 0, 0
    for index in range(first, first + count):
        number = lists[index]
        if number == NEGATED:
            inside, outside = inside >> 1 << 1 | outside & 1, outside >> 1 << 1 | inside & 1
            if (inside | outside) & 1 == 0:
                used = _negated(out, used)
            continue
        row = program[number]
        if row.arity == 0:
            starts[depth] = used
            depth += 1
            now_in, now_out = classify_primitive(row, c, h)
            inside, outside = inside << 1 | now_in, outside << 1 | now_out
            if now_in | now_out == 0:
                out[used] = number
                used += 1
            continue
        depth -= 1
        second_in, second_out = inside & 1, outside & 1
        inside, outside = inside >> 1, outside >> 1
        first_in, first_out = inside & 1, outside & 1
        now_in, now_out = combined(row.op, first_in, first_out, second_in, second_out)
        if now_in | now_out:
            used = starts[depth - 1]
        elif first_in | first_out | second_in | second_out == 0:
            out[used] = number
            used += 1
        elif first_in | second_in and row.op != UNION and row.op != INTERSECTION:
            used = _negated(out, used)  # the set that contains all of the box, from which the other is subtracted
        inside, outside = inside >> 1 << 1 | now_in, outside >> 1 << 1 | now_out
    return used, inside, outside
