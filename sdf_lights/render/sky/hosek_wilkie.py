# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hosek and Wilkie 2012, "An analytic model for full spectral sky-dome radiance", in its version for CIE XYZ, as in
Cycles.

``hosek_wilkie.npz`` beside this file holds the authors' published coefficients; ``hosek_wilkie.npz.license`` has their
licence.
"""

from __future__ import annotations

import functools
import math
import pathlib

import numpy as np

from .colour import REC709_FROM_XYZ


@functools.cache
def _published() -> tuple[np.ndarray, np.ndarray]:
    """(XYZ, albedo 0 and 1, turbidity 1 to 10, control point, coefficient); radiances, without the last axis."""
    with np.load(pathlib.Path(__file__).with_name("hosek_wilkie.npz")) as tables:
        return tables["coefficients"], tables["radiances"]


def coefficients(sun_direction, turbidity: float, albedo: float) -> np.ndarray:
    """For each of X, Y and Z: the nine coefficients A to I, the factor on the distribution, and its contribution to
    red, green and blue, (3, 13).

    The direction is a unit vector that does not point below the horizon.
    """
    elevation = max(0.5 * np.pi - np.arccos(np.clip(sun_direction[2], -1.0, 1.0)), 0.0)
    x = (elevation / (0.5 * np.pi)) ** (1.0 / 3.0)
    bezier = np.array([math.comb(5, i) * x**i * (1.0 - x) ** (5 - i) for i in range(6)])
    turbidity = min(max(turbidity, 1.0), 10.0)
    below = min(int(turbidity), 9) - 1
    part = turbidity - 1.0 - below
    weights = np.outer((1.0 - albedo, albedo), (1.0 - part, part))
    shapes, radiances = _published()
    shape = np.einsum("at,c,natck->nk", weights, bezier, shapes[:, :, below : below + 2])
    factor = 2.0 * np.pi / 683.0 * np.einsum("at,c,natc->n", weights, bezier, radiances[:, :, below : below + 2])
    return np.column_stack((shape, factor, REC709_FROM_XYZ.T))
