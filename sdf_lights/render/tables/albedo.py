# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedos of GGX closures, tabulated: what they lose to multiple scattering, and what a layer on top reflects.

``albedo.npz`` beside this file is made by ``python -m sdf_lights.render.tables.generate``. Axes, each equidistant from 0
to 1 with both ends: roughness (√α), the cosine of wo, and for dielectrics z = |(ior − 1) / (ior + 1)|^½, which
spreads out the indices of everyday materials (Cycles uses the same axis).
"""

from __future__ import annotations

import functools
import pathlib

import numpy as np

SIZE = 32  # of the axes roughness and cosine of the reflection tables
SIZE3 = 16  # of the three axes of the dielectric tables

# name -> shape, in the order in which they are laid out in one flat array. The last axis is roughness.
SHAPES = {
    "reflection": (SIZE, SIZE),  # GGX reflecting everything: [cosine, roughness]
    "reflection_average": (SIZE,),  # ∫ 2 μ E dμ
    "glass": (SIZE3, SIZE3, SIZE3),  # GGX reflecting and refracting, entering (ior > 1): [z, cosine, roughness]
    "glass_average": (SIZE3, SIZE3),
    "glass_inside": (SIZE3, SIZE3, SIZE3),  # leaving (ior < 1)
    "glass_inside_average": (SIZE3, SIZE3),
    "dielectric": (SIZE3, SIZE3, SIZE3),  # reflected by ior > 1, as fraction between F0 and 1 of its GGX albedo
    "schlick": (SIZE3, SIZE3),  # the same of Schlick's (1 − cosθ)⁵: [cosine, roughness]
}
OFFSETS = dict(zip(SHAPES, np.cumsum([0] + [int(np.prod(shape)) for shape in SHAPES.values()])))


@functools.lru_cache(maxsize=None)
def load() -> np.ndarray:
    """All tables in one flat float64 array, at ``OFFSETS``."""
    with np.load(pathlib.Path(__file__).with_name("albedo.npz")) as tables:
        return np.concatenate([tables[name].astype(np.float64).ravel() for name in SHAPES])
