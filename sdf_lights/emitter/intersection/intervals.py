# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals of a ray inside a program of primitives and set operations.

Roth 1982, "Ray casting for modeling solids": every primitive gives its intervals in closed form, and set operations
merge sorted lists of them. This finds all crossings, to rounding error, without marching.

The stack of lists lies in the rows of ``spans``: the (start, end) rows of a list, then one row that holds their number.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ...replaced import replaced_on_gpu
from ...sdf.program import Op
from ...vec import transform_point, transform_vector
from .. import primitives
from .fields import NEGATED
from .membership import DIFFERENCE, INTERSECTION, UNION


def rows_needed(program: np.ndarray) -> tuple[int, int]:
    """Maximum number of rows of ``spans`` that ``solve`` uses for a program (instructions,), and the maximum number of
    sets on its stack."""
    stack, rows, deepest = [], 0, 0
    for op, arity, parameters in zip(program["op"], program["arity"], program["parameters"]):
        if arity == 0:
            stack.append(primitives.most_spans(op, parameters))
        else:
            both = stack[-2] + stack[-1]
            rows = max(rows, sum(stack) + len(stack) + both)  # the merged list is written above its operands
            # Every interval of the result lies between two ends of its operands' intervals, and shares none of them
            # with another. An intersection starts at the later one of two starts.
            stack[-2:] = [both - 1 if op == Op.INTERSECTION else both]
        deepest = max(deepest, len(stack))
        rows = max(rows, sum(stack) + len(stack))
    return rows, deepest


@kernel
def primitive_spans(row, o, d):
    """Number of intervals inside the primitive of one instruction, 0 to 2, and their ends. Not for primitives that may
    have more."""
    return primitives.spans(row.op, row.parameters, transform_point(row.inverse, o), transform_vector(row.inverse, d))


@kernel
def _write_spans(row, o, d, spans, first):
    """Write the intervals inside the primitive of one instruction to rows from ``first``. Returns their number."""
    p, v = transform_point(row.inverse, o), transform_vector(row.inverse, d)
    return primitives.write_spans(row.op, row.parameters, p, v, spans, first)


@kernel
def _combine(spans, first, count_first, second, count_second, op, out):
    """Merge two sorted lists (rows from ``first`` and from ``second``) into rows from ``out``. Returns their number."""
    i, j = 0, 0
    in_first, in_second, inside = False, False, False
    count = 0
    while i < 2 * count_first or j < 2 * count_second:
        t_first = spans[first + i // 2, i % 2] if i < 2 * count_first else np.inf
        t_second = spans[second + j // 2, j % 2] if j < 2 * count_second else np.inf
        if t_first <= t_second and i < 2 * count_first:  # an end may itself be infinite
            t = t_first
            in_first = not in_first
            i += 1
        else:
            t = t_second
            in_second = not in_second
            j += 1
        if op == UNION:
            now = in_first or in_second
        elif op == DIFFERENCE:
            now = in_first and not in_second
        elif op == INTERSECTION:
            now = in_first and in_second
        else:
            now = in_first != in_second
        if now and not inside:
            spans[out + count, 0] = t
        elif inside and not now and t > spans[out + count, 0]:
            spans[out + count, 1] = t
            count += 1
        inside = now
    return count


@kernel
def _complement(spans, first, count):
    """Replace a sorted list by the gaps between its intervals, before and after them. Returns their number."""
    kept, start = 0, -np.inf
    for index in range(first, first + count):
        low, high = spans[index, 0], spans[index, 1]
        if low > start:
            spans[first + kept, 0], spans[first + kept, 1] = start, low
            kept += 1
        start = high
    if start < np.inf:
        spans[first + kept, 0], spans[first + kept, 1] = start, np.inf
        kept += 1
    return kept


@replaced_on_gpu
@kernel
def solve(program, o, d, spans, chosen=None):
    """Write the sorted, disjoint intervals (start, end) of the ray o + s·d inside the program to rows from 0. Returns
    their number.

    ``chosen`` are the indices of the active instructions, and ``NEGATED``; None for all of them. o and d are in the
    space where the instructions' ``inverse`` starts. d may have any length but zero. o should be near the shape
    (``lamps.trace`` moves it there), because the ends are as precise as |o| allows. ``spans`` has at least
    ``rows_needed(program)`` rows. Slivers of rounding size are left to ``regularize``.
    """
    length = len(program)
    if chosen is not None:
        length = len(chosen)
    top, step, missed = 0, 0, False
    while step < length:
        index = step
        if chosen is not None:
            index = chosen[step]
        step += 1
        if missed:
            missed = False
            if index != NEGATED and program[index].arity > 0 and program[index].op != INTERSECTION:
                continue  # leaves the set below it on the stack unchanged
            spans[top, 0] = 0
            top += 1
        if index == NEGATED:
            count = int(spans[top - 1, 0])
            first = top - 1 - count
            count = _complement(spans, first, count)
            top = first + count
            spans[top, 0] = count
            top += 1
            continue
        row = program[index]
        if row.arity == 0:
            count = _write_spans(row, o, d, spans, top)
            if count == 0 and step < length:
                missed = True
                continue
            top += count
            spans[top, 0] = count
            top += 1
            continue
        count_second = int(spans[top - 1, 0])
        second = top - 1 - count_second
        count_first = int(spans[second - 1, 0])
        first = second - 1 - count_first
        if count_second == 0 and row.op != INTERSECTION:
            count = count_first
        elif count_first == 0 and (row.op == INTERSECTION or row.op == DIFFERENCE):
            count = 0
        else:
            count = _combine(spans, first, count_first, second, count_second, row.op, top)
            for k in range(count):
                spans[first + k, 0], spans[first + k, 1] = spans[top + k, 0], spans[top + k, 1]
        top = first + count
        spans[top, 0] = count
        top += 1
    return int(spans[top - 1, 0])


@kernel
def regularize(spans, count, smallest):
    """Close gaps shorter than ``smallest`` between the sorted (start, end) rows, then drop intervals shorter than that.

    Where faces coincide, rounding leaves slivers of either sign. This computes the interior of the regularised set
    operation.
    """
    merged = 0
    for index in range(count):
        if merged > 0 and spans[index, 0] - spans[merged - 1, 1] < smallest:
            spans[merged - 1, 1] = max(spans[merged - 1, 1], spans[index, 1])
        else:
            spans[merged, 0], spans[merged, 1] = spans[index, 0], spans[index, 1]
            merged += 1
    kept = 0
    for index in range(merged):
        if spans[index, 1] - spans[index, 0] >= smallest:
            spans[kept, 0], spans[kept, 1] = spans[index, 0], spans[index, 1]
            kept += 1
    return kept
