# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by both scattering models: rays in a spherical atmosphere, and the table of a sky.

A table is (ROWS, COLUMNS, 3): RGB without the sun's disc; components are below zero for colours outside the gamut. Row
r is for the elevation ±(π/2) l², with l = 2 (r + ½) / ROWS − 1; so rows are dense at the horizon. Column c is for the
azimuth π (1 − (c + ½) / COLUMNS) from the sun, to either side. Values in between are interpolated. This is Cycles'
table, without its mirrored half.
"""

from __future__ import annotations

import numpy as np

ROWS, COLUMNS = 256, 256


def distance_to_shell(radius, sine, shell: float):
    """Distance from a point at ``radius`` from the planet's centre, inside a shell, to that shell along a ray whose
    elevation has this sine."""
    rise = radius * sine
    return np.sqrt(rise * rise + (shell - radius) * (shell + radius)) - rise


def heights_along(radius, height, sine, distance):
    """Radius and height of points along rays from a point at ``radius`` and ``height``; all lengths in one unit.

    The height comes from a difference of squares: that of two radii would lose digits.
    """
    gained = distance * (2.0 * radius * sine + distance)
    reached = np.sqrt(radius * radius + gained)
    ground = radius - height
    return reached, (height * (radius + ground) + gained) / (reached + ground)
