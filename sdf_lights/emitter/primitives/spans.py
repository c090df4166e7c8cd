# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals of a ray in slabs and tubes, from which those in primitives are made.

A ray is o + s·d in the primitive's local space, where d has any length but zero. Intervals are in the ray's parameter
s. An affine map keeps them, so they are world distances if the world direction had unit length. Each is solved around
the ray's closest approach, so the distance of o costs no digits. An interval is (start, end); start > end means that
the ray misses.
"""

import math

from ...jit import kernel

MISS = (math.inf, -math.inf)
NO_SPANS = (0, 0.0, 0.0, 0.0, 0.0)


@kernel
def one(span):
    """The result of ``spans`` for a primitive with one interval."""
    return (1 if span[0] < span[1] else 0), span[0], span[1], 0.0, 0.0


@kernel
def overlap(a, b):
    """Intersection of two intervals."""
    return (max(a[0], b[0]), min(a[1], b[1]))


@kernel
def slab(o, d, half):
    """The interval with |o + s·d| ≤ half, for scalars."""
    if d == 0.0:
        if abs(o) > half:
            return MISS
        return (-math.inf, math.inf)
    centre, reach = -o / d, abs(half / d)
    return (centre - reach, centre + reach)


@kernel
def tube_span(o, d, radius):
    """Infinite cylinder around the z axis."""
    square = d[0] * d[0] + d[1] * d[1]
    if square == 0.0:
        if o[0] * o[0] + o[1] * o[1] > radius * radius:
            return MISS
        return (-math.inf, math.inf)
    middle = -(o[0] * d[0] + o[1] * d[1]) / square
    # The distance of the two lines from a cross product: o + middle·d would cancel for rays along the axis.
    distance = abs(o[0] * d[1] - o[1] * d[0]) / math.sqrt(square)
    if distance >= radius:
        return MISS
    half = math.sqrt((radius - distance) * (radius + distance) / square)
    return (middle - half, middle + half)
