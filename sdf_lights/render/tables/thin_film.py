# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of interfering light: the Fourier transform of the eye's sensitivity to wave numbers.

Belcour and Barla 2017, "A practical extension to microfacet theory for the modeling of varying iridescence".
"""

from __future__ import annotations

import functools

import numpy as np

from . import cie

SIZE = 512
LONGEST = 60000.0 / (2.0 * np.pi)  # nanometres of path difference of the last column


@functools.cache
def load() -> np.ndarray:
    """(6 · SIZE,) means of cos 2πΔ/λ, then of sin 2πΔ/λ, over the wavelengths of red, green and blue.

    Δ goes from 0 to ``LONGEST`` in equal steps.
    """
    points = np.arange(cie.wavelengths()[0], cie.wavelengths()[-1] + 0.5)
    matching = np.stack([np.interp(points, cie.wavelengths(), column) for column in cie.MATCHING.T])
    weights = cie.RGB_OF_XYZ @ matching
    weights /= weights.sum(axis=1, keepdims=True)
    phase = 2.0 * np.pi / points[:, None] * np.linspace(0.0, LONGEST, SIZE)
    return np.concatenate([weights @ np.cos(phase), weights @ np.sin(phase)]).ravel()
