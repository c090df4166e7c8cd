# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How rays are traced through a closed lamp of several parts.

On the CPU, rays walk through the interior tree. On the GPU, threads of one group take as many steps as the longest walk
among them, and every step costs all possible operations. So for a union with many parts, a thread tests all their
boxes, which is cheap, and traces the ray through the parts whose boxes it hits. A short program is unrolled.
"""

from __future__ import annotations

import numpy as np

from ...affine import inverse
from ...emitter import primitives
from ...emitter.intersection.intervals import _combine, _write_spans, solve
from ...emitter.intersection.membership import DIFFERENCE, INTERSECTION, UNION
from ...emitter.lamps import instructions
from ...emitter.primitives.box import box_span
from ...jit import kernel, table
from ...sdf.program import INSTRUCTION, Op
from ...vec import sub, vec
from .layout import layout_of
from .translate import INT, Native, Value, known

# A part of a closed lamp: its consecutive instructions, and its box in tree space.
PART = np.dtype([("first", np.int64), ("count", np.int64), ("center", np.float64, (3,)), ("half", np.float64, (3,))])

MANY = 4  # number of parts from which on boxes pay
ROOM = 1e-5  # growth of boxes, relative to their own size and to that of all: for float32

# How to evaluate a lamp's field: a formula, its first parameter, and the origin of tree space in the formula's space;
# and the parts of a closed lamp.
FIELD = np.dtype(
    [
        ("formula", np.int64),
        ("parameters", np.int64),
        ("center", np.float64, (3,)),
        ("first_part", np.int64),
        ("part_count", np.int64),
    ]
)

part_table = table("lamp_parts", PART)
field_table = table("lamp_fields", FIELD)


def _box(row) -> np.ndarray:
    """(2, 3) corners of a primitive's box; infinite for a half space."""
    half = primitives.half_size(row["op"], row["parameters"])
    if not np.isfinite(half).all():
        return np.array([-half, half])
    matrix = inverse(np.vstack([row["inverse"], [0.0, 0.0, 0.0, 1.0]]))
    center, reach = matrix[:3, 3], np.abs(matrix[:3, :3]) @ half
    return np.array([center - reach, center + reach])


def _together(op: Op, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Corners of a box around the combination of the contents of two boxes."""
    if op == Op.DIFFERENCE:
        return a
    if op == Op.INTERSECTION:
        return np.array([np.maximum(a[0], b[0]), np.maximum(np.minimum(a[1], b[1]), np.maximum(a[0], b[0]))])
    return np.array([np.minimum(a[0], b[0]), np.maximum(a[1], b[1])])


def parts_of(program: np.ndarray) -> np.ndarray:
    """``PART`` (operands,) of each operand of the last unions in a program (instructions,); none if there are few."""
    stack: list[list[tuple]] = []  # of each set the parts: first instruction, number, box
    for index, row in enumerate(program):
        if row["arity"] == 0:
            stack.append([(index, 1, _box(row))])
            continue
        second, first = stack.pop(), stack.pop()
        if row["op"] == Op.UNION:
            stack.append(first + second)
            continue
        boxes = []
        for parts in (first, second):
            box = parts[0][2]
            for _, _, other in parts[1:]:
                box = _together(Op.UNION, box, other)
            boxes.append(box)
        start = first[0][0]
        stack.append([(start, index + 1 - start, _together(Op(row["op"]), *boxes))])
    found = stack[0]
    if len(found) < MANY:
        return np.zeros(0, PART)
    rows = np.zeros(len(found), PART)
    corners = np.array([box for _, _, box in found])
    reach = np.abs(corners[np.isfinite(corners)]).max(initial=0.0)
    corners = np.clip(corners, -4.0 * reach - 1.0, 4.0 * reach + 1.0)  # of a half space
    rows["first"], rows["count"] = [first for first, _, _ in found], [count for _, count, _ in found]
    rows["center"] = corners.mean(axis=1)
    rows["half"] = 0.5 * (corners[:, 1] - corners[:, 0]) * (1.0 + ROOM) + ROOM * reach
    return rows


@kernel
def solve_all(block, row, p, d, spans):
    """Replaces ``emitter.lamps.solve_all``: parts that the ray does not approach are left out."""
    program = instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count]
    field = field_table(block)[row.first_term]
    if field.part_count == 0:
        return solve(program, p, d, spans)
    parts = part_table(block)[field.first_part :]
    near = 0
    for index in range(field.part_count):
        part = parts[index]
        start, end = box_span(sub(p, vec(part.center)), d, part.half[0], part.half[1], part.half[2])
        if start <= end:
            spans[row.rows + near, 0] = index
            near += 1
    count = 0
    for place in range(near):
        part = parts[int(spans[row.rows + place, 0])]
        more = solve(program[part.first : part.first + part.count], p, d, spans[count:])
        if more > 0:
            merged = _combine(spans, 0, count, count, more, UNION, count + more)
            for k in range(merged):
                spans[k, 0], spans[k, 1] = spans[count + more + k, 0], spans[count + more + k, 1]
            count = merged
    return count


@kernel
def combine_two(spans, first, count_first, second, count_second, op, out):
    """``intervals._combine`` of two sets of at most one interval each, without a loop; not for ``EXCLUSIVE``."""
    a, b = (spans[first, 0], spans[first, 1]) if count_first > 0 else (np.inf, np.inf)
    c, d = (spans[second, 0], spans[second, 1]) if count_second > 0 else (np.inf, np.inf)
    if op == INTERSECTION:
        spans[out, 0], spans[out, 1] = max(a, c), min(b, d)
        return 1 if count_first > 0 and count_second > 0 and max(a, c) < min(b, d) else 0
    if op == DIFFERENCE:
        left, right = a < min(b, c), max(a, d) < b
        spans[out, 0], spans[out, 1] = a if left else max(a, d), min(b, c) if left else b
        spans[out + 1, 0], spans[out + 1, 1] = max(a, d), b
        return (1 if left else 0) + (1 if right else 0)
    apart = b < c or d < a
    low, high = (b, d) if a < c else (d, b)
    spans[out, 0], spans[out, 1] = min(a, c), low if apart else max(b, d)
    spans[out + 1, 0], spans[out + 1, 1] = max(a, c), high
    if count_first > 0 and count_second > 0:
        return 2 if apart else 1
    return 1 if count_first > 0 or count_second > 0 else 0


def rows_written_out(program: np.ndarray) -> tuple[int, list[tuple[int, int]]]:
    """Rows of ``spans`` for an unrolled program (instructions,), and for each instruction its first row and maximum
    number of intervals."""
    places, stack, used = [], [], 0
    for index, row in enumerate(program):
        if row["arity"] == 0:
            most = primitives.most_spans(row["op"], row["parameters"])
        else:
            second, first = stack.pop(), stack.pop()
            most = first + second - (1 if row["op"] == Op.INTERSECTION else 0)
        stack.append(most)
        places.append((used, most))
        used += most
    # The result is in the same rows as that of ``solve``.
    first, most = places[-1]
    places = [(place + most, count) for place, count in places[:-1]] + [(0, most)]
    return used, places


class WrittenOut:
    """A short program without the loop of ``intervals.solve``: each step does only what its instruction says."""

    MOST = 8  # instructions: compilers inline the function wherever a ray is traced

    def __init__(self, program: np.ndarray):
        self.program = program
        self.rows, self._places = rows_written_out(program)

    @classmethod
    def of(cls, built: list) -> WrittenOut | None:
        """For a scene with only one program, which is short; of a single primitive, or of primitives that a ray crosses
        in two intervals at most."""
        programs = [lamp.program for lamp in built if len(lamp.program) and lamp.tree is not None]
        if len(programs) != 1:
            return None
        (program,) = programs
        if len(program) == 1:
            return cls(program)
        ops = set(program["op"].tolist())
        many = any(op < Op.UNION and not primitives.has_two_spans_at_most(op) for op in ops)
        few = len(program) <= cls.MOST and not len(parts_of(program)) and not many and Op.EXCLUSIVE not in ops
        return cls(program) if few else None

    def native(self, first: int) -> Native:
        """For the translator. ``first``: index of the first instruction in the table of the scene."""

        def call(function, arguments):
            program, o, d, spans = arguments

            def said(kernel, *given) -> Value:
                name, result = function.translator.function(kernel, list(given))
                return Value(INT, function.temporary(INT, f"{name}({', '.join(function.passed(list(given)))})"))

            size, stack = layout_of(INSTRUCTION, "").size, []
            for index, (row, (place, most)) in enumerate(zip(self.program, self._places)):
                if row["arity"] == 0:
                    own = function.translator.tables.row(
                        "lamp_instructions", first + index, f"{program.text} + {size * index}"
                    )
                    count = said(_write_spans, own, o, d, spans, known(place))
                else:
                    (second, count_second, most_second), (one, count_one, most_one) = stack.pop(), stack.pop()
                    combine = combine_two if max(most_one, most_second) == 1 else _combine
                    count = said(
                        combine,
                        spans,
                        known(one),
                        count_one,
                        known(second),
                        count_second,
                        known(int(row["op"])),
                        known(place),
                    )
                stack.append((place, count, most))
            return stack[0][1]

        return Native(call)
