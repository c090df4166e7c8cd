# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From spectra and CIE XYZ to scene-linear Rec. 709."""

from __future__ import annotations

import numpy as np

WAVELENGTHS = np.arange(380.0, 781.0, 20.0)  # nanometres

CIE_1931 = np.array(
    [
        (0.001368, 0.000039, 0.006450001),
        (0.01431, 0.000396, 0.06785001),
        (0.13438, 0.004, 0.6456),
        (0.34828, 0.023, 1.74706),
        (0.2908, 0.06, 1.6692),
        (0.09564, 0.13902, 0.8129501),
        (0.0049, 0.323, 0.272),
        (0.06327, 0.71, 0.07824999),
        (0.2904, 0.954, 0.0203),
        (0.5945, 0.995, 0.0039),
        (0.9163, 0.87, 0.001650001),
        (1.0622, 0.631, 0.0008),
        (0.8544499, 0.381, 0.00019),
        (0.4479, 0.175, 0.00002),
        (0.1649, 0.061, 0.0),
        (0.04677, 0.017, 0.0),
        (0.01135916, 0.004102, 0.0),
        (0.002899327, 0.001047, 0.0),
        (0.0006900786, 0.0002492, 0.0),
        (0.0001661505, 0.00006, 0.0),
        (0.00004150994, 0.00001499, 0.0),
    ]
)
"""The colour matching functions of CIE's standard observer of 2° at ``WAVELENGTHS``, (21, 3)."""

REC709_FROM_XYZ = np.array(
    [
        (3.24096994, -1.53738318, -0.49861076),
        (-0.96924364, 1.8759675, 0.04155506),
        (0.05563008, -0.20397696, 1.05697151),
    ]
)
"""ITU-R BT.709's primaries and D65; colours outside its gamut have negative components."""


def planck(temperature: float, wavelengths: np.ndarray) -> np.ndarray:
    """Radiance (n,) of a black body (kelvin) at wavelengths (n,) in nanometres, in W/(m² sr nm)."""
    metres = 1e-9 * wavelengths
    first, second = 1.1910429723971884e-16, 1.438776877503933e-2  # 2hc², hc/k (CODATA 2018)
    return 1e-9 * first / metres**5 / np.expm1(second / (metres * temperature))
