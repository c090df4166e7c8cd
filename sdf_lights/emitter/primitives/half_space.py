# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The half space z ≤ 0. It has no parameters."""

import math

import numpy as np

from ...jit import kernel
from .regions import end_face
from .spans import MISS, one

MOST_SPANS = 1


@kernel
def half_space_span(o, d):
    """The interval in z ≤ 0: one end, or both, is infinite."""
    if d[2] == 0.0:
        return (-math.inf, math.inf) if o[2] <= 0.0 else MISS
    crossing = -o[2] / d[2]
    return (-math.inf, crossing) if d[2] > 0.0 else (crossing, math.inf)


@kernel
def spans(size, o, d):
    """See the package."""
    return one(half_space_span(o, d))


@kernel
def classify(size, c, h):
    """See the package."""
    return (1 if c[2] + h[2] <= 0.0 else 0), (1 if c[2] - h[2] >= 0.0 else 0)


@kernel
def face(size, axis, c, h):
    """See the package."""
    return end_face(0.0, axis)


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.full(3, math.inf)
