# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Uniform points in the unit disk."""

import math

from ...jit import kernel


@kernel
def disk_point(u1, u2):
    """Uniform point (x, y) in the unit disk. Shirley and Chiu 1997, "A low distortion map between disk and square"."""
    a, b = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0
    if abs(a) > abs(b):
        radius, angle = a, math.pi / 4.0 * (b / a)
    else:
        radius, angle = b, math.pi / 2.0 - math.pi / 4.0 * (a / b)
    return radius * math.cos(angle), radius * math.sin(angle)
