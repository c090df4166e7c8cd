# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a box, or a point as a box of no size, is inside or outside each primitive and a whole program.

A box is given by its centre and half sizes in the primitive's own space. The answer is conservative: (inside, outside)
as 1 or 0, both 0 where the surface may pass through the box.
"""

import math

from ...jit import kernel
from ...sdf.program import Op
from .fields import NEGATED
from .sponge import classify_sponge

SPHERE, BOX, TORUS = int(Op.SPHERE), int(Op.BOX), int(Op.TORUS)
CAPSULE, CYLINDER, CONE = int(Op.CAPSULE), int(Op.CYLINDER), int(Op.CONE)
HALF_SPACE, FRUSTUM, SPONGE = int(Op.HALF_SPACE), int(Op.FRUSTUM), int(Op.SPONGE)
UNION, INTERSECTION = int(Op.UNION), int(Op.INTERSECTION)
DIFFERENCE, EXCLUSIVE = int(Op.DIFFERENCE), int(Op.EXCLUSIVE)

DEEPEST = 62  # bits of an int64 that hold one flag for each set on the stack

# What is called for every point or box with whole arrays is inlined: each array that is passed on costs an atomic
# reference count, which took four times as long as the rest.


@kernel
def _near(centre, half):
    return max(abs(centre) - half, 0.0)


@kernel
def _far(centre, half):
    return abs(centre) + half


@kernel
def _beside(low, high, radius):
    """Flags of a region whose squared distances to a skeleton are all within [low, high]."""
    return (1 if high <= radius * radius else 0), (1 if low >= radius * radius else 0)


@kernel
def place(row, c, h):
    """Centre and half sizes of the axis-aligned box round the image, in the primitive's space, of a box."""
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
    """Flags (inside, outside) of one primitive's instruction for a box of the shape's space."""
    c, h = place(row, c, h)
    op, size = row.op, row.parameters
    if op == HALF_SPACE:
        return (1 if c[2] + h[2] <= 0.0 else 0), (1 if c[2] - h[2] >= 0.0 else 0)
    if op == SPONGE:
        return classify_sponge(c, h, size[0], int(size[1]))
    near_x, near_y, near_z = _near(c[0], h[0]), _near(c[1], h[1]), _near(c[2], h[2])
    far_x, far_y, far_z = _far(c[0], h[0]), _far(c[1], h[1]), _far(c[2], h[2])
    if op == BOX:
        inside = far_x <= size[0] and far_y <= size[1] and far_z <= size[2]
        outside = near_x >= size[0] or near_y >= size[1] or near_z >= size[2]
        return (1 if inside else 0), (1 if outside else 0)
    near_square = near_x * near_x + near_y * near_y
    far_square = far_x * far_x + far_y * far_y
    if op == SPHERE:
        return _beside(near_square + near_z * near_z, far_square + far_z * far_z, size[0])
    if op == TORUS:
        near_ring, far_ring = math.sqrt(near_square), math.sqrt(far_square)
        near_tube = max(near_ring - size[0], size[0] - far_ring, 0.0)
        far_tube = max(far_ring - size[0], size[0] - near_ring)
        return _beside(near_tube * near_tube + near_z * near_z, far_tube * far_tube + far_z * far_z, size[1])
    half_height = 0.5 * (size[2] if op == FRUSTUM else size[1])
    if op == CAPSULE:
        above, top = max(near_z - half_height, 0.0), max(far_z - half_height, 0.0)
        return _beside(near_square + above * above, far_square + top * top, size[0])
    narrow, wide = size[0], size[0]
    if op != CYLINDER:
        # The radius is linear in z: of the part of the box between the ends, it is least and greatest at two heights.
        end = size[1] if op == FRUSTUM else 0.0
        low = min(max(0.5 + (c[2] - h[2]) / (2.0 * half_height), 0.0), 1.0)
        high = min(max(0.5 + (c[2] + h[2]) / (2.0 * half_height), 0.0), 1.0)
        at_low, at_high = (1.0 - low) * size[0] + low * end, (1.0 - high) * size[0] + high * end
        narrow, wide = min(at_low, at_high), max(at_low, at_high)
    inside = far_z <= half_height and far_square <= narrow * narrow
    outside = near_z >= half_height or near_square >= wide * wide
    return (1 if inside else 0), (1 if outside else 0)


@kernel(forceinline=True)
def combined(op, first_in, first_out, second_in, second_out):
    """Flags (inside, outside) of the combination of two sets by their flags."""
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

    ``chosen`` are the indices of the instructions that count, and ``NEGATED``; None for all of them. The stack of sets
    is a stack of bits, so a program may hold at most ``DEEPEST`` sets at a time.
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
    """Whether the point p of the shape's space is inside."""
    return classify(program, p, (0.0, 0.0, 0.0), chosen)[0] == 1
