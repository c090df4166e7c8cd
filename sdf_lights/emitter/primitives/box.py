# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A block: half sizes along x, y and z, centre at the origin."""

import numpy as np

from ...jit import kernel
from .regions import far, near
from .spans import one, overlap, slab

MOST_SPANS = 1


@kernel
def box_span(o, d, half_x, half_y, half_z):
    """Interval (start, end) of the ray o + t d in a box about the origin, of these half sizes."""
    return overlap(overlap(slab(o[0], d[0], half_x), slab(o[1], d[1], half_y)), slab(o[2], d[2], half_z))


@kernel
def spans(size, o, d):
    """See the package."""
    return one(box_span(o, d, size[0], size[1], size[2]))


@kernel
def classify(size, c, h):
    """See the package."""
    inside = far(c[0], h[0]) <= size[0] and far(c[1], h[1]) <= size[1] and far(c[2], h[2]) <= size[2]
    outside = near(c[0], h[0]) >= size[0] or near(c[1], h[1]) >= size[1] or near(c[2], h[2]) >= size[2]
    return (1 if inside else 0), (1 if outside else 0)


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    return (size[0] * (2.0 * u1 - 1.0), size[1] * (2.0 * u2 - 1.0), size[2] * (2.0 * u3 - 1.0))


@kernel
def face(size, axis, c, h):
    """See the package."""
    return size[axis]


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array(size[:3])
