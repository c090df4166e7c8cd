# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a lamp on a surface without occlusion, in closed form.

A lamp with emission ρ neither absorbs nor scatters. So a point with normal n that has all of it above its horizon
receives E = ∫ ρ n·(y − x) / |y − x|³ dV: the attraction of a body of that density by Newton's law. It has closed forms
for ellipsoids, and so for every affine image of a ball, and for boxes.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.special import elliprd


def of_ellipsoid(matrix: np.ndarray, points: np.ndarray, normal) -> np.ndarray:
    """Irradiance at ``points`` (n, 3), in 1/m², from the unit ball under an affine ``matrix`` (4 × 4) with 1 W/sr in
    total.

    O. D. Kellogg 1929, "Foundations of potential theory", chapter VII.6; the integral is Carlson's R_D.
    """
    axes, lengths, _ = np.linalg.svd(matrix[:3, :3])
    offset = (points - matrix[:3, 3]) @ axes
    squares, a = offset**2, lengths**2
    # The confocal ellipsoid through a point: Σ y²/(a² + u) = 1 falls and is convex, so Newton's method stays to its
    # left.
    u = np.maximum(squares.sum(axis=1) - a[0], 0.0)
    for _ in range(200):
        terms = squares / (a + u[:, None])
        step = (terms.sum(axis=1) - 1.0) / (terms / (a + u[:, None])).sum(axis=1)
        u = np.maximum(u + step, 0.0)
        if np.all(np.abs(step) <= 1e-15 * (a[0] + u)):
            break
    x, y, z = (a + u[:, None]).T
    pull = np.stack([elliprd(y, z, x), elliprd(z, x, y), elliprd(x, y, z)], axis=1)
    return -(offset * pull) @ (np.asarray(normal, float) @ axes)


def of_box(low, high, points: np.ndarray, density: float) -> np.ndarray:
    """Irradiance from above, in W/m², at ``points`` (n, 3) by a box with corners ``low`` and ``high``.

    The ``density`` is in W/(sr m³). D. Nagy 1966, "The gravitational attraction of a right rectangular prism".
    """
    total = np.zeros(len(points))
    corners = np.array([low, high], float)
    for which in itertools.product((0, 1), repeat=3):
        x, y, z = (corners[which, (0, 1, 2)] - points).T
        r = np.sqrt(x * x + y * y + z * z)
        sign = 1.0 if sum(which) % 2 == 0 else -1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = x * np.log(y + r), y * np.log(x + r), -z * np.arctan2(x * y, z * r)
        # Each tends to zero where it is undefined: on an edge's line, and at a corner.
        total += sign * sum(np.where(np.isfinite(part), part, 0.0) for part in parts)
    return density * total


def intensity(power: float) -> float:
    """W/sr of a lamp of ``power`` watts."""
    return power / (4.0 * math.pi)
