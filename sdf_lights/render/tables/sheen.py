# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sheen of Zeltner, Burley and Chiang 2022, "Practical multiple-scattering sheen using linearly transformed
cosines": its albedo, and the coefficients A and B of the inverse transform.

``sheen.npz`` beside this file is measured from renders of Cycles; ``scripts/measure_sheen.py`` does that. The axes are
those of Cycles: the cosine of wo, and the roughness, equidistant from 0 to 1 with both ends. Between the entries,
values are bilinear.
"""

from __future__ import annotations

import functools
import pathlib

import numpy as np

SIZE = 32  # of both axes
TERMS = ("albedo", "a", "b")
SCALE = 1e5  # of the stored integers: measured values are that close to numbers of five decimals
LOWEST_ROUGHNESS = 1e-3  # smoother is the same in Cycles
PATH = pathlib.Path(__file__).with_suffix(".npz")


@functools.cache
def load() -> np.ndarray:
    """(terms, cosines, roughnesses), float64."""
    with np.load(PATH) as tables:
        return np.stack([tables[term] / SCALE for term in TERMS])
