# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances of a box to planes and to the z axis; primitives use them to classify the box."""

import math

from ...jit import kernel


@kernel
def near(centre, half):
    """Least distance of an interval from zero."""
    return max(abs(centre) - half, 0.0)


@kernel
def far(centre, half):
    """Greatest distance of an interval from zero."""
    return abs(centre) + half


@kernel
def axis_squares(c, h):
    """Least and greatest squared distance of a box (centre, half sizes) from the z axis."""
    near_x, near_y = near(c[0], h[0]), near(c[1], h[1])
    far_x, far_y = far(c[0], h[0]), far(c[1], h[1])
    return near_x * near_x + near_y * near_y, far_x * far_x + far_y * far_y


@kernel
def distance_flags(low, high, radius):
    """Flags of a region whose squared distances to a skeleton are all within [low, high]."""
    return (1 if high <= radius * radius else 0), (1 if low >= radius * radius else 0)


@kernel
def round_bar(c, h, least_radius, greatest_radius, half_height):
    """Flags of a box in a solid of revolution between |z| = ``half_height``, whose radius beside the box is from
    ``least_radius`` to ``greatest_radius``."""
    near_square, far_square = axis_squares(c, h)
    inside = far(c[2], h[2]) <= half_height and far_square <= least_radius * least_radius
    outside = near(c[2], h[2]) >= half_height or near_square >= greatest_radius * greatest_radius
    return (1 if inside else 0), (1 if outside else 0)


@kernel
def end_face(half_height, axis):
    """``face`` of a primitive that is flat only at its ends, z = ±half_height."""
    return half_height if axis == 2 else math.inf
