# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a box, or a point as a box of zero size, is inside or outside each primitive and a whole program.

A box is given by its centre and half sizes in the primitive's local space. The answer is conservative: (inside,
outside) as 1 or 0, both 0 if the surface may pass through the box.
"""

from ...jit import kernel
from ...sdf.program import Op
from .. import primitives
from .fields import NEGATED

UNION, INTERSECTION = int(Op.UNION), int(Op.INTERSECTION)
DIFFERENCE, EXCLUSIVE = int(Op.DIFFERENCE), int(Op.EXCLUSIVE)

DEEPEST = 62  # bits of an int64, which holds one flag for each set on the stack

# Functions called for every point or box with whole arrays are inlined: passing an array costs an atomic reference
# count, which took four times as long as the rest.


@kernel
def place(row, c, h):
    """Centre and half sizes of the axis-aligned box around the image of a box in the primitive's space."""
    m = row.inverse
    centre = (
        m[0, 0] * c[0] + m[0, 1] * c[1] + m[0, 2] * c[2] + m[0, 3],
        m[1, 0] * c[0] + m[1, 1] * c[1] + m[1, 2] * c[2] + m[1, 3],
        m[2, 0] * c[0] + m[2, 1] * c[1] + m[2, 2] * c[2] + m[2, 3],
    )
    half = (
        abs(m[0, 0]) * h[0] + abs(m[0, 1]) * h[1] + abs(m[0, 2]) * h[2],
        abs(m[1, 0]) * h[0] + abs(m[1, 1]) * h[1] + abs(m[1, 2]) * h[2],
        abs(m[2, 0]) * h[0] + abs(m[2, 1]) * h[1] + abs(m[2, 2]) * h[2],
    )
    return centre, half


@kernel
def classify_primitive(row, c, h):
    """Flags (inside, outside) of one primitive's instruction for a box in the shape's space."""
    c, h = place(row, c, h)
    return primitives.classify(row.op, row.parameters, c, h)


@kernel(forceinline=True)
def combined(op, first_in, first_out, second_in, second_out):
    """Flags (inside, outside) of the combination of two sets, from their flags."""
    if op == UNION:
        return first_in | second_in, first_out & second_out
    if op == INTERSECTION:
        return first_in & second_in, first_out | second_out
    if op == DIFFERENCE:
        return first_in & second_out, first_out | second_in
    return first_in & second_out | first_out & second_in, first_in & second_in | first_out & second_out


@kernel(forceinline=True)
def classify(program, c, h, chosen=None):
    """Flags (inside, outside) of a program for the box with centre c and half sizes h.

    ``chosen`` are the indices of the active instructions, and ``NEGATED``; None for all of them. The stack of sets is a
    stack of bits, so a program may hold at most ``DEEPEST`` sets at a time.
    """
    count = len(program)
    if chosen is not None:
        count = len(chosen)
    inside, outside = 0, 0
    for step in range(count):
        index = step
        if chosen is not None:
            index = chosen[step]
        if index == NEGATED:
            inside, outside = inside >> 1 << 1 | outside & 1, outside >> 1 << 1 | inside & 1
            continue
        row = program[index]
        if row.arity == 0:
            is_inside, is_outside = classify_primitive(row, c, h)
            inside, outside = inside << 1 | is_inside, outside << 1 | is_outside
            continue
        second_in, second_out = inside & 1, outside & 1
        inside, outside = inside >> 1, outside >> 1
        now_in, now_out = combined(row.op, inside & 1, outside & 1, second_in, second_out)
        inside, outside = inside >> 1 << 1 | now_in, outside >> 1 << 1 | now_out
    return inside, outside


@kernel(forceinline=True)
def contains(program, p, chosen=None):
    """Whether the point p in the shape's space is inside."""
    return classify(program, p, (0.0, 0.0, 0.0), chosen)[0] == 1
