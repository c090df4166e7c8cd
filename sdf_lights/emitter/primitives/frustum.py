# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A frustum along z: radii at −height/2 and +height/2, height; centred. Either radius may be 0."""

import math

import numpy as np

from ...jit import kernel
from ...vec import dot, madd
from .disk import disk_point
from .regions import end_face, round_bar
from .spans import MISS, one, overlap, slab

MOST_SPANS = 1


@kernel
def frustum_span(o, d, bottom, top, half_height):
    """Solid between the circles of radius ``bottom`` at z = −half_height and ``top`` at z = +half_height.

    The side is x² + y² = r(z)², where r is the radius at height z, which is linear. Within the slab of the height only
    one of its two nappes is left, and the solid is convex. Equal radii make it a cylinder; a radius of zero makes it a
    cone.
    """
    side = slab(o[2], d[2], half_height)
    if side[0] > side[1]:
        return MISS
    middle = -dot(o, d) / dot(d, d)
    p = madd(o, middle, d)
    # Weighted ends keep the digits of the radius near an apex, at either end.
    radius = (bottom * (half_height - p[2]) + top * (half_height + p[2])) / (2.0 * half_height)
    rate = (top - bottom) / (2.0 * half_height) * d[2]
    across = d[0] * d[0] + d[1] * d[1]
    a = across - rate * rate
    b = p[0] * d[0] + p[1] * d[1] - radius * rate
    c = p[0] * p[0] + p[1] * p[1] - radius * radius
    # b² − a·c without its cancellation: the Gram determinant of p and d in the cone's indefinite metric.
    turn = abs(p[0] * d[1] - p[1] * d[0])
    swing = math.hypot(p[0] * rate - radius * d[0], p[1] * rate - radius * d[1])
    discriminant = (swing - turn) * (swing + turn)
    if a == 0.0 and b == 0.0:  # the side has the same distance all along the ray
        return side if c < 0.0 else MISS
    if discriminant <= 0.0:
        # A line steeper than the cone always meets both nappes; at the limit both at the apex.
        if a >= 0.0:
            return MISS
        discriminant = 0.0
    q = -(b + math.copysign(math.sqrt(discriminant), b))
    other = c / q if q != 0.0 else 0.0
    if a == 0.0:
        # Parallel to a line of the cone: one crossing; inside where the linear function 2b·s + c is negative.
        first = middle - c / (2.0 * b)
        return overlap(side, (first, math.inf) if b < 0.0 else (-math.inf, first))
    near, far = middle + min(q / a, other), middle + max(q / a, other)
    if a > 0.0:
        return overlap(side, (near, far))
    if rate > 0.0:
        return overlap(side, (far, math.inf))
    return overlap(side, (-math.inf, near))


@kernel
def spans(size, o, d):
    """See the package."""
    return one(frustum_span(o, d, size[0], size[1], 0.5 * size[2]))


@kernel
def classify_frustum(c, h, bottom, top, half_height):
    """Flags (inside, outside) for the box with centre c and half sizes h."""
    # The radius is linear in z: in the part of the box between the ends, it is least and greatest at two heights.
    low = min(max(0.5 + (c[2] - h[2]) / (2.0 * half_height), 0.0), 1.0)
    high = min(max(0.5 + (c[2] + h[2]) / (2.0 * half_height), 0.0), 1.0)
    at_low, at_high = (1.0 - low) * bottom + low * top, (1.0 - high) * bottom + high * top
    return round_bar(c, h, min(at_low, at_high), max(at_low, at_high), half_height)


@kernel
def classify(size, c, h):
    """See the package."""
    return classify_frustum(c, h, size[0], size[1], 0.5 * size[2])


@kernel
def frustum_point(u1, u2, u3, bottom, top, height):
    """Uniform point in a frustum of the radii ``bottom`` at z = −height/2 and ``top`` at +height/2.

    The volume below grows with the cube of the radius. The quotient of two differences of cubes gives the height, and
    needs no special case for equal radii.
    """
    first, last = bottom * bottom * bottom, top * top * top
    radius = (first + u1 * (last - first)) ** (1.0 / 3.0)
    square = bottom * bottom + bottom * radius + radius * radius
    part = u1 * (bottom * bottom + bottom * top + top * top) / square if square > 0.0 else 0.0
    x, y = disk_point(u2, u3)
    return (radius * x, radius * y, height * (part - 0.5))


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    return frustum_point(u1, u2, u3, size[0], size[1], size[2])


@kernel
def face(size, axis, c, h):
    """See the package."""
    return end_face(0.5 * size[2], axis)


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array([max(size[:2]), max(size[:2]), 0.5 * size[2]])
