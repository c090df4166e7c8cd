# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preetham, Shirley and Smits 1999, "A practical analytic model for daylight": Perez's distribution for Y, x and y,
with coefficients that are linear in the turbidity. Its luminance is scaled as in Blender."""

from __future__ import annotations

import numpy as np

# Of Y, x and y: slope and offset of Perez's A to E in the turbidity.
_PEREZ = np.array(
    [
        [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
        [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
        [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
    ]
)
# Of x and y at the zenith: powers 2, 1, 0 of the turbidity by powers 3, 2, 1, 0 of the sun's angle from the zenith.
_ZENITH = np.array(
    [
        [
            (0.00166, -0.00375, 0.00209, 0.0),
            (-0.02903, 0.06377, -0.03202, 0.00394),
            (0.11693, -0.21196, 0.06052, 0.25886),
        ],
        [
            (0.00275, -0.00610, 0.00317, 0.0),
            (-0.04214, 0.08970, -0.04153, 0.00516),
            (0.15346, -0.26756, 0.06670, 0.26688),
        ],
    ]
)
_SCALE = 0.06  # of luminance, from kcd/m²


def coefficients(sun_direction, turbidity: float) -> np.ndarray:
    """For Y, x and y: Perez's A to E and the factor on his distribution, (3, 6). The direction is a unit vector."""
    theta = np.arccos(np.clip(sun_direction[2], -1.0, 1.0))
    perez = _PEREZ @ (turbidity, 1.0)
    chi = (4.0 / 9.0 - turbidity / 120.0) * (np.pi - 2.0 * theta)
    luminance = _SCALE * ((4.0453 * turbidity - 4.9710) * np.tan(chi) - 0.2155 * turbidity + 2.4192)
    zenith = np.concatenate(([luminance], (turbidity**2, turbidity, 1.0) @ _ZENITH @ (theta**3, theta**2, theta, 1.0)))
    a, b, c, d, e = perez.T
    at_zenith = (1.0 + a * np.exp(b)) * (1.0 + c * np.exp(d * theta) + e * np.cos(theta) ** 2)
    return np.column_stack((perez, zenith / at_zenith))
