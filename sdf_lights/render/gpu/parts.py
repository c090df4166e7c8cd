# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a union, each with its box: a ray is followed through the parts whose boxes it meets.

On the CPU rays walk through the interior tree. Here threads that go together take as many steps as the longest of their
walks, and a step is all that any of them may do; to test a box is a small part of that.
"""

from __future__ import annotations

import numpy as np

from ...affine import inverse
from ...emitter.intervals import _combine, solve
from ...emitter.lamps import instructions
from ...emitter.membership import UNION
from ...emitter.primitives import box_span
from ...jit import kernel, table
from ...sdf.program import Op
from ...vec import sub, vec

# A part of a closed lamp: its instructions, which follow one another, and its box in tree space.
PART = np.dtype([("first", np.int64), ("count", np.int64), ("center", np.float64, (3,)), ("half", np.float64, (3,))])

MANY = 4  # parts from which on boxes pay
ROOM = 1e-5  # by which boxes are larger, of their own size and of that of all: for float32

# How to read a lamp's field: a formula, its first parameter, the origin of tree space in the formula's, a bound of the
# slope, and the least step of a ray; and the parts of a closed lamp.
FIELD = np.dtype([
    ("formula", np.int64), ("parameters", np.int64), ("center", np.float64, (3,)), ("lipschitz", np.float64),
    ("least", np.float64), ("first_part", np.int64), ("part_count", np.int64)])

part_table = table("lamp_parts", PART)
field_table = table("lamp_fields", FIELD)


def _box(row) -> np.ndarray:
    """(2, 3) corners of a primitive's box; infinite for a half space."""
    op, size = Op(row["op"]), row["parameters"]
    if op == Op.HALF_SPACE:
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    wide = size[0]
    if op == Op.BOX:
        half = size[:3]
    elif op in (Op.SPHERE, Op.SPONGE):
        half = np.full(3, wide)
    elif op == Op.TORUS:
        half = np.array([wide + size[1], wide + size[1], size[1]])
    elif op == Op.FRUSTUM:
        half = np.array([max(size[:2]), max(size[:2]), 0.5 * size[2]])
    else:
        half = np.array([wide, wide, 0.5 * size[1] + (wide if op == Op.CAPSULE else 0.0)])
    matrix = inverse(np.vstack([row["inverse"], [0.0, 0.0, 0.0, 1.0]]))
    center, reach = matrix[:3, 3], np.abs(matrix[:3, :3]) @ half
    return np.array([center - reach, center + reach])


def _together(op: Op, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Corners of a box around the combination of what two boxes hold."""
    if op == Op.DIFFERENCE:
        return a
    if op == Op.INTERSECTION:
        return np.array([np.maximum(a[0], b[0]), np.maximum(np.minimum(a[1], b[1]), np.maximum(a[0], b[0]))])
    return np.array([np.minimum(a[0], b[0]), np.maximum(a[1], b[1])])


def parts_of(program: np.ndarray) -> np.ndarray:
    """``PART`` of each operand of the unions that are last in a program; none where they are few."""
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
    rows["center"], rows["half"] = corners.mean(axis=1), 0.5 * (corners[:, 1] - corners[:, 0]) * (1.0 + ROOM) + ROOM * reach
    return rows


@kernel
def solve_all(block, row, p, d, spans):
    """In the place of ``emitter.lamps.solve_all``: what the ray does not come near is left out."""
    program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
    field = field_table(block)[row.first_term]
    if field.part_count == 0:
        return solve(program, p, d, spans)
    parts = part_table(block)[field.first_part:]
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
        more = solve(program[part.first:part.first + part.count], p, d, spans[count:])
        if more > 0:
            merged = _combine(spans, 0, count, count, more, UNION, count + more)
            for k in range(merged):
                spans[k, 0], spans[k, 1] = spans[count + more + k, 0], spans[count + more + k, 1]
            count = merged
    return count
