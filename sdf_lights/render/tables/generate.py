# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute ``albedo.npz`` from the closures of the CPU back end: ``python -m sdf_lights.render.tables.generate``.

Each entry is an integral over visible normals by a two-dimensional lattice. Reflection and refraction of every normal
are both summed, so the only error is that of the lattice.
"""

from __future__ import annotations

import math
import pathlib

import numpy as np

from ...jit import kernel
from ..kernels.shading import fresnel, microfacet
from .albedo import CYCLES_SIZE, SCALE, SHAPES

_LOWEST = 1e-4  # of roughness and cosine, which are singular at 0
_HIGHEST_Z = 0.99  # of the axis of ior, infinite at 1
_COLUMNS = (
    "reflection",
    "glass",
    "dielectric",
    "schlick",
    "cycles_dielectric",
    "cycles_schlick",
)  # results of _albedos
# Cycles' table has reflectances (1 − cosθ)ⁿ for n = 5 / z − 5. The n of Schlick, z = ½, is between two entries.
_EXPONENTS = tuple(5.0 * (CYCLES_SIZE - 1) / entry - 5.0 for entry in (CYCLES_SIZE // 2 - 1, CYCLES_SIZE // 2))
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@kernel
def _albedos(roughness, cosine, ior, count):
    """Albedos of GGX with microfacets that reflect everything; reflect and refract; reflect as "dielectric" and
    "schlick" in ``SHAPES``; and what Cycles has for the last two; summed over ``count`` visible normals."""
    alpha = roughness * roughness
    alpha2 = alpha * alpha
    wo = (math.sqrt(1.0 - cosine * cosine), 0.0, cosine)
    masking_o = microfacet.masking(alpha2, cosine)
    everything, glass, dielectric, schlick, cycles_dielectric, cycles_schlick = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        h = microfacet.visible_normal(wo, alpha, alpha, (i * _GOLDEN) % 1.0, (i + 0.5) / count)
        cosine_h = wo[0] * h[0] + wo[2] * h[2]
        f, cosine_t = fresnel.dielectric(cosine_h, ior)
        up = 2.0 * cosine_h * h[2] - cosine
        if up > 0.0:
            value = (1.0 + masking_o) / (1.0 + masking_o + microfacet.masking(alpha2, up))
            everything += value
            dielectric += value * fresnel.remapped(f, ior)
            glass += value * f
            schlick += value * (1.0 - cosine_h) ** 5
            cycles_dielectric += fresnel.remapped(f, ior)
            cycles_schlick += 0.5 * ((1.0 - cosine_h) ** _EXPONENTS[0] + (1.0 - cosine_h) ** _EXPONENTS[1])
        down = (cosine_h / ior - cosine_t) * h[2] - cosine / ior
        if cosine_t > 0.0 and down < 0.0:
            glass += (1.0 - f) * (1.0 + masking_o) / (1.0 + masking_o + microfacet.masking(alpha2, down))
    return (
        everything / count,
        glass / count,
        dielectric / count,
        schlick / count,
        cycles_dielectric / count,
        cycles_schlick / count,
    )


def axis(size: int) -> np.ndarray:
    """Roughnesses of the entries of an axis, (size,)."""
    return np.clip(np.linspace(0.0, 1.0, size), _LOWEST, 1.0)


def cosine_of_axis(t: float) -> float:
    """Cosine at a position in [0, 1] on its axis."""
    return max(t * t, _LOWEST)


def ior_of_axis(z: float) -> float:
    """Index of refraction at a position in [0, 1] on its axis."""
    return float(fresnel.ior_of_f0(min(max(z, _LOWEST), _HIGHEST_Z) ** 4))


def entry(name: str, index: tuple[int, ...], count: int = 1 << 13) -> float:
    """One entry of the table ``name``."""
    shape = SHAPES[name]
    roughness = axis(shape[-1])[index[-1]]
    base = name.removesuffix("_average")
    ior = 1.0
    if base in ("glass", "glass_inside", "dielectric", "cycles_dielectric"):
        ior = ior_of_axis(index[0] / (shape[0] - 1))
        if base == "glass_inside":
            ior = 1.0 / ior
    column = _COLUMNS.index(base.removesuffix("_inside"))
    if base == name:
        place = index[-2] / (shape[-2] - 1)
        cosine = max(place, _LOWEST) if name.startswith("cycles_") else cosine_of_axis(place)
        return _albedos(roughness, cosine, ior, count)[column]
    nodes, weights = np.polynomial.legendre.leggauss(64)
    cosines = 0.5 + 0.5 * nodes
    values = [_albedos(roughness, cosine, ior, count >> 3)[column] for cosine in cosines]
    return float(np.sum(weights * cosines * values))


def generate() -> dict[str, np.ndarray]:
    """All tables, by name, as uint16; ``SCALE`` represents 1."""
    tables = {}
    for name, shape in SHAPES.items():
        values = [entry(name, index) for index in np.ndindex(shape)]
        tables[name] = np.round(SCALE * np.clip(values, 0.0, 1.0)).astype(np.uint16).reshape(shape)
    return tables


if __name__ == "__main__":
    np.savez_compressed(pathlib.Path(__file__).with_name("albedo.npz"), **generate())
