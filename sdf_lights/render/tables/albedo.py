# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedos of GGX closures, tabulated: the loss to multiple scattering, and the reflection of a layer on
top.

``python -m sdf_lights.render.tables.generate`` makes ``albedo.npz`` beside this file, which stores them as 16-bit
fractions. The axes are equidistant from 0 to 1 with both ends: roughness (√α); the square root of the cosine of wo,
because grazing views change fastest; and for dielectrics z = |(ior − 1) / (ior + 1)|^½, which spreads out the indices
of everyday materials.
"""

from __future__ import annotations

import functools
import pathlib

import numpy as np

SIZE = 24  # of every axis
CYCLES_SIZE = 16  # of every axis of tables that Cycles has, too

SCALE = 65535.0  # of the 16-bit fractions

# name -> shape, in the order of one flat array. The last axis is roughness.
SHAPES = {
    "reflection": (SIZE, SIZE),  # GGX reflecting everything: [cosine, roughness]
    "reflection_average": (SIZE,),  # ∫ 2 μ E dμ
    "glass": (SIZE, SIZE, SIZE),  # GGX reflecting and refracting, entering (ior > 1): [z, cosine, roughness]
    "glass_average": (SIZE, SIZE),
    "glass_inside": (SIZE, SIZE, SIZE),  # leaving (ior < 1)
    "glass_inside_average": (SIZE, SIZE),
    "dielectric": (SIZE, SIZE, SIZE),  # GGX reflecting (F − F0) / (1 − F0) of the dielectric F, ior > 1
    "schlick": (SIZE, SIZE),  # GGX reflecting Schlick's (1 − cosθ)⁵: [cosine, roughness]
    # What Cycles takes for "dielectric" and "schlick" of a lossless GGX, in its passes of colour and for the layers
    # below: the mean over visible normals, without shadowing, of what reflects above the surface. The axes are as
    # coarse, and have the cosine itself.
    "cycles_dielectric": (CYCLES_SIZE, CYCLES_SIZE, CYCLES_SIZE),
    "cycles_schlick": (CYCLES_SIZE, CYCLES_SIZE),
}
OFFSETS = dict(zip(SHAPES, np.cumsum([0] + [int(np.prod(shape)) for shape in SHAPES.values()])))


@functools.cache
def load() -> np.ndarray:
    """All tables in one flat float64 array, at ``OFFSETS``."""
    with np.load(pathlib.Path(__file__).with_name("albedo.npz")) as tables:
        return np.concatenate([tables[name].ravel() / SCALE for name in SHAPES])
