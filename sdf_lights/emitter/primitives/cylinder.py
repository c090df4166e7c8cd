# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A round bar along z: radius, height; centred."""

import numpy as np

from ...jit import kernel
from .disk import disk_point
from .regions import end_face, round_bar
from .spans import MISS, one, overlap, slab, tube_span

MOST_SPANS = 1


@kernel
def cylinder_span(o, d, radius, half_height):
    """Capped cylinder along z, |z| ≤ half_height."""
    side = slab(o[2], d[2], half_height)
    if side[0] > side[1]:
        return MISS
    return overlap(side, tube_span(o, d, radius))


@kernel
def spans(size, o, d):
    """See the package."""
    return one(cylinder_span(o, d, size[0], 0.5 * size[1]))


@kernel
def classify(size, c, h):
    """See the package."""
    return round_bar(c, h, size[0], size[0], 0.5 * size[1])


@kernel
def cylinder_point(u1, u2, u3, radius, height):
    """Uniform point in a cylinder about the z axis, centred at the origin."""
    x, y = disk_point(u2, u3)
    return (radius * x, radius * y, height * (u1 - 0.5))


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    return cylinder_point(u1, u2, u3, size[0], size[1])


@kernel
def face(size, axis, c, h):
    """See the package."""
    return end_face(0.5 * size[1], axis)


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array([size[0], size[0], 0.5 * size[1]])
