# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of a field's gradient in the boxes of its interior tree.

They tell how fast the field can fall and rise along a ray through a box, which is less than its Lipschitz bound unless
the ray is perpendicular to the surface. In most boxes on the surface they prove that the field is monotonic along a
ray, so that only the values at both ends are needed (see ``cover``).

For that, bounds at the zeros of the field alone are enough: between two zeros through which it falls, there is one
through which it rises. Functions of tables know these, which are closer, so boxes that have parts get them.

The terms of a box's list are bounded in turn (see ``graph.interval_interpreter``), with a stack of operands. A join
f(a, b) has the gradient f_a ∇a + f_b ∇b. If the signs of f_a and f_b are certain, that is |f_a| + |f_b| times an
average of ±∇a and ±∇b. The derivative of f(a + z, b ± z) along z is that sum, without the cancelling parts. So both
operands may have any share in a smooth union, and the bounds are still no wider than those of the two.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from ...graph.interval_interpreter import BOXES, DEEPEST_LOOP, SIZE, enclose
from ...graph.interval_kernels import ROUNDING, margin_of_rounding, product_bounds
from ...graph.interval_tape import Tape, tape, with_zero_bounds
from ...graph.lipschitz import discontinuous, may_be_discontinuous
from ...jit import kernel
from ...sdf.shapes.base import Family
from ..intersection.fields import DEEPEST, NEGATED, CompiledField
from .parallel import TASKS, in_parallel

# operations on boxes, about 40 ms, times ``boxes`` of the field; below that, boxes have no bounds of their own
WORK = 2_500_000
OVERHEAD = 10.0  # fixed cost of a box, in operations
TAPES = 1024  # formulas in the cache
CASES = 4  # parts that a box may be divided into, to find where it jumps

_WITHOUT, _EXCLUSIVE = int(Family.DIFFERENCE), int(Family.EXCLUSIVE)

_tape = functools.lru_cache(maxsize=TAPES)(tape)


def _tapes(field: CompiledField, at_zeros: bool) -> tuple[np.ndarray, np.ndarray, int]:
    """Instructions of all terms, with the number and result of those of each (terms, 3), and the registers that the
    longest needs."""
    tapes: list[Tape] = [_tape(term.formula, at_zeros) for term in field.source]
    first, total, parts = {}, 0, []
    for found in tapes:
        if id(found) not in first:
            first[id(found)] = total
            total += len(found.instructions)
            parts.append(found.instructions)
    places = np.array([(first[id(found)], len(found.instructions), found.result) for found in tapes], np.int64)
    return np.concatenate(parts), places, max(found.registers for found in tapes)


@kernel
def _seed(registers, axis, low, high, x, y, z):
    """Write bounds (BOXES,) of a coordinate, and its gradient."""
    for box in range(BOXES):
        registers[axis, 0, box], registers[axis, 1, box] = low[box], high[box]
        registers[axis, 2, box] = registers[axis, 3, box] = x
        registers[axis, 4, box] = registers[axis, 5, box] = y
        registers[axis, 6, box] = registers[axis, 7, box] = z


@kernel
def _joined(slopes, box, sign, a, b, row, out):
    """Write the bounds of f_a ∇a + f_b ∇b along one axis, whose bounds begin at ``row``, to ``out``.

    ``slopes`` has the bounds of f_a, f_b and f_a ± f_b; ``sign`` is that sign, 0 if it is unknown.
    """
    low, high = 0.0, 0.0
    for operand in range(2):
        values = a if operand == 0 else b
        product = product_bounds(
            slopes[2 + 2 * operand, box], slopes[3 + 2 * operand, box], values[row, box], values[row + 1, box]
        )
        low += product[0]
        high += product[1]
    least_b = slopes[4, box] if sign > 0.0 else -slopes[5, box]
    if sign != 0.0 and slopes[2, box] >= -ROUNDING and least_b >= -ROUNDING:
        b_low, b_high = (b[row, box], b[row + 1, box]) if sign > 0.0 else (-b[row + 1, box], -b[row, box])
        average = product_bounds(
            max(slopes[6, box], 0.0), max(slopes[7, box], 0.0), min(a[row, box], b_low), max(a[row + 1, box], b_high)
        )
        low, high = max(low, average[0]), min(high, average[1])
    if not low <= high:
        low, high = -math.inf, math.inf
    out[row, box], out[row + 1, box] = low, high


@kernel
def bound(instructions, places, terms, parameters, lists, first, count, boxes, chosen, registers, stack, out, values):
    """Bounds ``out`` (n, 2, 3) of the gradient of a list of terms, and ``values`` (n, 2) of it, in up to ``BOXES`` of
    the ``boxes`` (n, 6)."""
    rounds = np.empty((DEEPEST_LOOP, 2), np.int64)
    corners = np.empty((6, BOXES))
    for box in range(BOXES):
        corners[:, box] = boxes[chosen[min(box, len(chosen) - 1)]]
    nothing = np.zeros(BOXES)
    depth = 0
    for index in range(first, first + count):
        number = lists[index]
        if number == NEGATED:
            top = stack[depth - 1]
            for row in range(0, SIZE, 2):
                for box in range(BOXES):
                    top[row, box], top[row + 1, box] = -top[row + 1, box], -top[row, box]
            continue
        term, place = terms[number], places[number]
        depth -= term.arity
        sign = 0.0 if term.family == _EXCLUSIVE else -1.0 if term.family == _WITHOUT else 1.0
        if term.arity == 0:
            for axis in range(3):
                _seed(
                    registers,
                    axis,
                    corners[axis],
                    corners[3 + axis],
                    1.0 if axis == 0 else 0.0,
                    1.0 if axis == 1 else 0.0,
                    1.0 if axis == 2 else 0.0,
                )
        else:
            _seed(registers, 0, stack[depth, 0], stack[depth, 1], 1.0, 0.0, 1.0)
            _seed(registers, 1, nothing, nothing, 0.0, 0.0, 0.0)
            if term.arity == 2:
                _seed(registers, 1, stack[depth + 1, 0], stack[depth + 1, 1], 0.0, 1.0, sign)
            _seed(registers, 2, nothing, nothing, 0.0, 0.0, 0.0)
        enclose(instructions, place[0], place[1], parameters, term.parameters, registers, rounds)
        found = registers[place[2]]
        if term.arity == 0:
            stack[depth] = found
        else:
            for box in range(BOXES):
                for row in range(2, SIZE, 2):
                    if term.arity == 2:
                        _joined(found, box, sign, stack[depth], stack[depth + 1], row, stack[depth])
                    else:
                        product = product_bounds(
                            found[2, box], found[3, box], stack[depth, row, box], stack[depth, row + 1, box]
                        )
                        stack[depth, row, box], stack[depth, row + 1, box] = product
                stack[depth, 0, box], stack[depth, 1, box] = found[0, box], found[1, box]
        depth += 1
    for box in range(len(chosen)):
        for axis in range(3):
            low, high = stack[0, 2 + 2 * axis, box], stack[0, 3 + 2 * axis, box]
            margin = margin_of_rounding(low, high)
            out[chosen[box], 0, axis], out[chosen[box], 1, axis] = low - margin, high + margin
        low, high = stack[0, 0, box], stack[0, 1, box]
        margin = margin_of_rounding(low, high)
        values[chosen[box], 0], values[chosen[box], 1] = low - margin, high + margin


@kernel
def bound_all(
    instructions, places, terms, parameters, lists, first, count, boxes, chosen, registers, stack, out, values
):
    """As ``bound``, for any number of boxes i with the lists from first[i] to first[i] + count[i], in the order of
    ``chosen``, in which equal lists are neighbours."""
    start = 0
    while start < len(chosen):
        head, stop = chosen[start], start + 1
        while (
            stop < len(chosen)
            and stop - start < BOXES
            and first[chosen[stop]] == first[head]
            and count[chosen[stop]] == count[head]
        ):
            stop += 1
        bound(
            instructions,
            places,
            terms,
            parameters,
            lists,
            first[head],
            count[head],
            boxes,
            chosen[start:stop],
            registers,
            stack,
            out,
            values,
        )
        start = stop


def bounds_of(
    field: CompiledField,
    boxes: np.ndarray,
    lists: np.ndarray,
    first: np.ndarray,
    count: np.ndarray,
    at_zeros: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n, 2, 3), low and high, of the gradient of the lists lists[first:first + count] in boxes (n, 6), and
    bounds (n, 2) of their values. With ``at_zeros``, the gradient is bounded only where a field ``with_zero_bounds`` is
    zero."""
    instructions, places, registers = _tapes(field, at_zeros)
    first, count = first.astype(np.int64), count.astype(np.int64)
    out, values = np.empty((len(boxes), 2, 3)), np.empty((len(boxes), 2))
    order = np.lexsort((count, first))

    def find(chosen: np.ndarray) -> None:
        scratch, stack = np.empty((registers, SIZE, BOXES)), np.empty((DEEPEST, SIZE, BOXES))
        bound_all(
            instructions,
            places,
            field.terms,
            field.parameters,
            lists,
            first,
            count,
            boxes,
            chosen,
            scratch,
            stack,
            out,
            values,
        )

    find(order[:BOXES])  # compiles
    in_parallel(lambda share: find(np.array_split(order, TASKS)[share]))
    return out, values


def _selected(nodes: np.ndarray, boundary: np.ndarray, work: np.ndarray, most: float) -> np.ndarray:
    """Nodes of the deepest level whose work stays within ``most``, and leaves above it; all on the boundary."""
    level = np.zeros(1, np.int64)
    while True:
        leaf = nodes["first"][level] < 0
        below = (nodes["first"][level[~leaf]][:, None] + (0, 1)).ravel()
        below = np.concatenate([level[leaf], below[boundary[below]]])
        if leaf.all() or work[below].sum() > most:
            return level
        level = below


@kernel
def _spread(nodes, boundary, known, at_zeros):
    """Give the parts of boxes the bounds of the whole, if they have the same list; give wholes the bounds of all their
    parts on the boundary, those ``at_zeros`` (nodes, 2, 3)."""
    for index in range(len(nodes)):
        node = nodes[index]
        if node.first >= 0 and known[index]:
            for part in range(node.first, node.first + 2):
                known[part] = True
                if nodes[part].row_first == node.row_first and nodes[part].row_count == node.row_count:
                    nodes[part].gradient[:] = node.gradient
                    at_zeros[part] = at_zeros[index]
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        if node.first < 0 or known[index]:
            continue
        for axis in range(3):
            low, high = np.inf, -np.inf
            for part in range(node.first, node.first + 2):
                if boundary[part]:
                    low = min(low, at_zeros[part, 0, axis])
                    high = max(high, at_zeros[part, 1, axis])
            node.gradient[0, axis], node.gradient[1, axis] = low, high
            at_zeros[index, 0, axis], at_zeros[index, 1, axis] = low, high


def _discontinuous(
    field: CompiledField, boxes: np.ndarray, lists: np.ndarray, first: np.ndarray, count: np.ndarray
) -> np.ndarray:
    """The boxes (n, 6) in which a term of their lists may jump, which the bounds of gradients do not show."""
    found = np.zeros(len(boxes), bool)
    for number, term in enumerate(field.source):
        if term.arity == 0 and not math.isfinite(term.lipschitz) and may_be_discontinuous(term.formula):
            matters = [number in lists[start : start + size] for start, size in zip(first, count)]
            places = np.flatnonzero(matters)
            corners = boxes[places]
            found[places] |= discontinuous(term.formula, corners[:, :3], corners[:, 3:], term.parameters, CASES)
    return found


def fill_gradients(
    field: CompiledField, nodes: np.ndarray, boundary: np.ndarray, boxes: np.ndarray, lists: np.ndarray
) -> None:
    """Write bounds of the gradient, as ``nodes["gradient"]``, to the nodes of a tree that are on its boundary.

    They bound the field of the node's own list. Large boxes are not bounded as a whole: they get the bounds of all
    their parts on the boundary together. These belong to other lists, with the same sign but not the same field. So
    they show only how the sign can change. Children come after their parents in ``nodes``; ``boundary`` (nodes,) marks
    the nodes on it.
    """
    nodes["gradient"] = [[-np.inf], [np.inf]]
    total = np.append(0.0, np.cumsum(np.append(field.operations, 0.0)[lists]))  # NEGATED is the last
    work = OVERHEAD + total[nodes["row_first"] + nodes["row_count"]] - total[nodes["row_first"]]
    chosen = _selected(nodes, boundary, work, WORK * field.boxes)
    rows = nodes[chosen]
    discontinuous_boxes = _discontinuous(field, boxes[chosen], lists, rows["row_first"], rows["row_count"])

    def found(at_zeros: bool) -> np.ndarray:
        bounds, _ = bounds_of(field, boxes[chosen], lists, rows["row_first"], rows["row_count"], at_zeros)
        bounds[discontinuous_boxes] = [[-np.inf], [np.inf]]
        with np.errstate(over="ignore"):
            return np.nextafter(bounds.astype(np.float32), np.array([[-np.inf], [np.inf]], np.float32))

    nodes["gradient"][chosen] = found(False)
    at_zeros = nodes["gradient"].copy()
    if len(field.source) == 1 and with_zero_bounds(field.source[0].formula) is not None:
        at_zeros[chosen] = found(True)
    known = np.zeros(len(nodes), bool)
    known[chosen] = True
    _spread(nodes, boundary, known, at_zeros)
