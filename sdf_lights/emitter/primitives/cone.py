# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A cone along z: radius of its base at −height/2, height to its apex at +height/2. It is a frustum that ends in a
point."""

import numpy as np

from ...jit import kernel
from .frustum import classify_frustum, frustum_point, frustum_span
from .regions import end_face
from .spans import one

MOST_SPANS = 1


@kernel
def spans(size, o, d):
    """See the package."""
    return one(frustum_span(o, d, size[0], 0.0, 0.5 * size[1]))


@kernel
def classify(size, c, h):
    """See the package."""
    return classify_frustum(c, h, size[0], 0.0, 0.5 * size[1])


@kernel
def point(size, u1, u2, u3):
    """See the package."""
    return frustum_point(u1, u2, u3, size[0], 0.0, size[1])


@kernel
def face(size, axis, c, h):
    """See the package."""
    return end_face(0.5 * size[1], axis)


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array([size[0], size[0], 0.5 * size[1]])
