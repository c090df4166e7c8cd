# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A ball: radius, centre at the origin."""

import math

import numpy as np

from ...jit import kernel
from ...vec import dot, length, madd
from .regions import axis_squares, distance_flags, far, near
from .spans import MISS, one

MOST_SPANS = 1


@kernel
def sphere_span(o, d, radius):
    """Interval (start, end) of the ray o + t d in a sphere about the origin; ``MISS`` if there is none."""
    square = dot(d, d)
    middle = -dot(o, d) / square
    distance = length(madd(o, middle, d))
    if distance >= radius:
        return MISS
    # The product keeps the digits of a grazing ray that radius² − distance² would cancel.
    half = math.sqrt((radius - distance) * (radius + distance) / square)
    return (middle - half, middle + half)


@kernel
def spans(size, o, d):
    """See the package."""
    return one(sphere_span(o, d, size[0]))


@kernel
def classify(size, c, h):
    """See the package."""
    near_square, far_square = axis_squares(c, h)
    near_z, far_z = near(c[2], h[2]), far(c[2], h[2])
    return distance_flags(near_square + near_z * near_z, far_square + far_z * far_z, size[0])


@kernel
def ball_point(u1, u2, u3):
    """Uniform point in the unit ball."""
    radius = u1 ** (1.0 / 3.0)
    z = 1.0 - 2.0 * u2
    ring = math.sqrt(max(1.0 - z * z, 0.0))
    angle = 2.0 * math.pi * u3
    return (radius * ring * math.cos(angle), radius * ring * math.sin(angle), radius * z)


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    x, y, z = ball_point(u1, u2, u3)
    return (size[0] * x, size[0] * y, size[0] * z)


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.full(3, size[0])
