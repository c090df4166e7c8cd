# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A capsule along z: radius; height of its segment without the caps; centred."""

import math

import numpy as np

from ...jit import kernel
from .cylinder import cylinder_span
from .disk import disk_point
from .regions import axis_squares, distance_flags, far, near
from .spans import one
from .sphere import ball_point, sphere_span

MOST_SPANS = 1


@kernel
def capsule_span(o, d, radius, half_height):
    """All points within ``radius`` of the segment |z| ≤ half_height of the z axis.

    The capsule is convex and the union of a cylinder and two spheres, so the interval is the hull of theirs.
    """
    tube = cylinder_span(o, d, radius, half_height)
    upper = sphere_span((o[0], o[1], o[2] - half_height), d, radius)
    lower = sphere_span((o[0], o[1], o[2] + half_height), d, radius)
    start, end = math.inf, -math.inf
    if tube[0] <= tube[1]:
        start, end = tube
    if upper[0] <= upper[1]:
        start, end = min(start, upper[0]), max(end, upper[1])
    if lower[0] <= lower[1]:
        start, end = min(start, lower[0]), max(end, lower[1])
    return (start, end)


@kernel
def spans(size, o, d):
    """See the package."""
    return one(capsule_span(o, d, size[0], 0.5 * size[1]))


@kernel
def classify(size, c, h):
    """See the package."""
    near_square, far_square = axis_squares(c, h)
    half_height = 0.5 * size[1]
    above, top = max(near(c[2], h[2]) - half_height, 0.0), max(far(c[2], h[2]) - half_height, 0.0)
    return distance_flags(near_square + above * above, far_square + top * top, size[0])


@kernel
def capsule_point(u1, u2, u3, radius, height):
    """Uniform point in a capsule: its two ends are the halves of one ball, moved apart."""
    straight = height / (height + 4.0 / 3.0 * radius)
    if u1 < straight:
        x, y = disk_point(u2, u3)
        return (radius * x, radius * y, height * (u1 / straight - 0.5))
    x, y, z = ball_point((u1 - straight) / (1.0 - straight), u2, u3)
    return (radius * x, radius * y, radius * z + math.copysign(0.5 * height, z))


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    return capsule_point(u1, u2, u3, size[0], size[1])


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array([size[0], size[0], 0.5 * size[1] + size[0]])
