# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compensation of the energy that single scattering loses; albedos for stacking layers; and the table of sheen.

Turquin 2019, "Practical multiple scattering compensation for microfacet models": the lobe is scaled by one over its
albedo without Fresnel. The colour of light that bounced between microfacets follows Kulla and Conty 2017.
"""

import math

import numpy as np

from ....jit import kernel, table
from ...tables import sheen as sheen_table
from ...tables.albedo import CYCLES_SIZE, OFFSETS, SIZE

TABLES = {"albedo": np.dtype("f8"), "sheen": np.dtype("f8")}
_albedo = table("albedo", TABLES["albedo"])
_sheen = table("sheen", TABLES["sheen"])

_REFLECTION, _REFLECTION_AVERAGE = OFFSETS["reflection"], OFFSETS["reflection_average"]
_GLASS, _GLASS_AVERAGE = OFFSETS["glass"], OFFSETS["glass_average"]
_INSIDE, _INSIDE_AVERAGE = OFFSETS["glass_inside"], OFFSETS["glass_inside_average"]
_DIELECTRIC, _SCHLICK = OFFSETS["dielectric"], OFFSETS["schlick"]
_CYCLES_DIELECTRIC, _CYCLES_SCHLICK = OFFSETS["cycles_dielectric"], OFFSETS["cycles_schlick"]
_SHEEN_SIZE, _LOWEST_SHEEN = sheen_table.SIZE, sheen_table.LOWEST_ROUGHNESS
_SHEEN_ALBEDO, _SHEEN_A, _SHEEN_B = (_SHEEN_SIZE * _SHEEN_SIZE * term for term in range(len(sheen_table.TERMS)))
_RELEVANT = 1e-4  # lost energy that is not worth compensating


@kernel
def _cell(x, size):
    x = min(max(x, 0.0), 1.0) * (size - 1)
    i = min(int(x), size - 2)
    return i, x - i


@kernel
def _line(values, offset, i, t):
    return values[offset + i] + t * (values[offset + i + 1] - values[offset + i])


@kernel
def _plane(values, offset, x, y, size):
    i, s = _cell(x, size)
    j, t = _cell(y, size)
    low = _line(values, offset + j * size, i, s)
    return low + t * (_line(values, offset + (j + 1) * size, i, s) - low)


@kernel
def _space(values, offset, x, y, z, size):
    k, t = _cell(z, size)
    low = _plane(values, offset + k * size * size, x, y, size)
    return low + t * (_plane(values, offset + (k + 1) * size * size, x, y, size) - low)


@kernel
def _axis_of_ior(ior):
    return math.sqrt(abs((ior - 1.0) / (ior + 1.0)))


@kernel
def _axis_of_cosine(cosine):
    return math.sqrt(max(cosine, 0.0))


@kernel
def _compensate(closure, e, mean, single):
    """Scale the closure's weight so that a lossless surface loses nothing.

    ``e``: albedo for this wo if every microfacet were lossless, ``mean`` its average over wo; ``single`` (RGB): the
    average fraction kept by one bounce.
    """
    missing = (1.0 - e) / e
    if missing >= _RELEVANT:
        closure.multiscatter[0] = e
        for i in range(3):
            f = min(single[i], 1.0)
            closure.weight[i] *= 1.0 + missing * f * mean / (1.0 - f * (1.0 - mean))


@kernel
def glass_albedo(block, cosine, roughness, ior):
    """Albedo of GGX single scattering that reflects and refracts."""
    offset = _INSIDE if ior < 1.0 else _GLASS
    return _space(_albedo(block), offset, roughness, _axis_of_cosine(cosine), _axis_of_ior(ior), SIZE)


@kernel
def compensate_glass(block, closure, cosine, roughness, single):
    """For a closure that reflects and refracts; ``single`` is the fraction kept when crossing the surface."""
    values = _albedo(block)
    mean = _plane(
        values, _INSIDE_AVERAGE if closure.ior < 1.0 else _GLASS_AVERAGE, roughness, _axis_of_ior(closure.ior), SIZE
    )
    _compensate(closure, glass_albedo(block, cosine, roughness, closure.ior), mean, single)


@kernel
def compensate_reflection(block, closure, e, roughness, single):
    """For a closure that reflects only; ``e`` is ``reflection_albedo``."""
    i, t = _cell(roughness, SIZE)
    _compensate(closure, e, _line(_albedo(block), _REFLECTION_AVERAGE, i, t), single)


@kernel
def reflection_albedo(block, cosine, roughness):
    """Albedo of GGX single scattering off microfacets that reflect everything."""
    return _plane(_albedo(block), _REFLECTION, roughness, _axis_of_cosine(cosine), SIZE)


@kernel
def dielectric_albedo(block, ior, cosine, roughness):
    """Albedo of GGX single scattering if a microfacet reflects (F − F0) / (1 − F0) of a dielectric."""
    return _space(_albedo(block), _DIELECTRIC, roughness, _axis_of_cosine(cosine), _axis_of_ior(ior), SIZE)


@kernel
def schlick_albedo(block, cosine, roughness):
    """Albedo of GGX single scattering if a microfacet reflects Schlick's (1 − cosθ)⁵."""
    return _plane(_albedo(block), _SCHLICK, roughness, _axis_of_cosine(cosine), SIZE)


@kernel
def cycles_dielectric(block, ior, cosine, roughness):
    """What Cycles takes for ``dielectric_albedo`` over ``reflection_albedo``: for layers below, and passes of
    colour."""
    return _space(_albedo(block), _CYCLES_DIELECTRIC, roughness, cosine, _axis_of_ior(ior), CYCLES_SIZE)


@kernel
def cycles_schlick(block, cosine, roughness):
    """What Cycles takes for ``schlick_albedo`` over ``reflection_albedo``."""
    return _plane(_albedo(block), _CYCLES_SCHLICK, roughness, cosine, CYCLES_SIZE)


@kernel
def sheen(block, cosine, roughness):
    """Albedo of sheen, and the coefficients A and B of its inverse linear transform."""
    values, y = _sheen(block), max(roughness, _LOWEST_SHEEN)
    return (
        _plane(values, _SHEEN_ALBEDO, y, cosine, _SHEEN_SIZE),
        _plane(values, _SHEEN_A, y, cosine, _SHEEN_SIZE),
        _plane(values, _SHEEN_B, y, cosine, _SHEEN_SIZE),
    )


@kernel
def mixed(f0, e, s):
    """Albedo (RGB) of reflectances f0 + (1 − f0) x, from the albedos e of 1 and s of x."""
    return (
        f0[0] * e + (1.0 - f0[0]) * s,
        f0[1] * e + (1.0 - f0[1]) * s,
        f0[2] * e + (1.0 - f0[2]) * s,
    )
