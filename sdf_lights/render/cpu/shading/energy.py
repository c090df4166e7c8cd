# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Energy that single scattering loses, given back; and albedos by which layers are stacked.

Turquin 2019, "Practical multiple scattering compensation for microfacet models": the lobe is scaled by one over its
albedo without Fresnel. The colour of light that bounced between microfacets follows Kulla and Conty 2017.
"""

import math

import numpy as np

from ....jit import kernel, table
from ...tables.albedo import OFFSETS, SIZE, SIZE3

TABLES = {"albedo": np.dtype("f8")}
_albedo = table("albedo", TABLES["albedo"])

_REFLECTION, _REFLECTION_AVERAGE = OFFSETS["reflection"], OFFSETS["reflection_average"]
_GLASS, _GLASS_AVERAGE = OFFSETS["glass"], OFFSETS["glass_average"]
_INSIDE, _INSIDE_AVERAGE = OFFSETS["glass_inside"], OFFSETS["glass_inside_average"]
_DIELECTRIC, _SCHLICK = OFFSETS["dielectric"], OFFSETS["schlick"]
_RELEVANT = 1e-4


@kernel
def _cell(x, size):
    x = min(max(x, 0.0), 1.0) * (size - 1)
    i = min(int(x), size - 2)
    return i, x - i


@kernel
def _line(values, offset, i, t):
    return values[offset + i] + t * (values[offset + i + 1] - values[offset + i])


@kernel
def _plane(values, offset, size, x, y):
    i, s = _cell(x, size)
    j, t = _cell(y, size)
    low = _line(values, offset + j * size, i, s)
    return low + t * (_line(values, offset + (j + 1) * size, i, s) - low)


@kernel
def _space(values, offset, size, x, y, z):
    k, t = _cell(z, size)
    low = _plane(values, offset + k * size * size, size, x, y)
    return low + t * (_plane(values, offset + (k + 1) * size * size, size, x, y) - low)


@kernel
def _axis_of_ior(ior):
    return math.sqrt(abs((ior - 1.0) / (ior + 1.0)))


@kernel
def compensate(block, closure, cosine, roughness, single):
    """Scale the closure's weight so that a lossless surface loses nothing.

    ``single`` (RGB) is the average reflectance (of glass: transmittance) of one bounce off a microfacet.
    """
    values = _albedo(block)
    if closure.transmits:
        z = _axis_of_ior(closure.ior)
        if closure.ior < 1.0:
            e = _space(values, _INSIDE, SIZE3, roughness, cosine, z)
            mean = _plane(values, _INSIDE_AVERAGE, SIZE3, roughness, z)
        else:
            e = _space(values, _GLASS, SIZE3, roughness, cosine, z)
            mean = _plane(values, _GLASS_AVERAGE, SIZE3, roughness, z)
    else:
        e = _plane(values, _REFLECTION, SIZE, roughness, cosine)
        i, t = _cell(roughness, SIZE)
        mean = _line(values, _REFLECTION_AVERAGE, i, t)
    missing = (1.0 - e) / e
    if missing < _RELEVANT:
        return
    for i in range(3):
        f = min(single[i], 1.0)
        closure.weight[i] *= 1.0 + missing * f * mean / (1.0 - f * (1.0 - mean))


@kernel
def dielectric_albedo(block, ior, f0, cosine, roughness):
    """Albedo (one channel) of dielectric reflection from outside, remapped to start at f0."""
    s = _space(_albedo(block), _DIELECTRIC, SIZE3, roughness, cosine, _axis_of_ior(ior))
    return f0 + (1.0 - f0) * s


@kernel
def schlick_albedo(block, f0, cosine, roughness):
    return f0 + (1.0 - f0) * _plane(_albedo(block), _SCHLICK, SIZE3, roughness, cosine)
