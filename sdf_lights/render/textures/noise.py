# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Noise Texture: octaves of Perlin noise, as in Ebert et al. 2003, "Texturing and modeling", chapter 16.

    value(dimensions)(kind, normalize, x, y, z, w, detail, roughness, lacunarity, offset, gain, distortion) -> value
    color(dimensions)(…the same…) -> (r, g, b); r is the value

``kind`` is one of ``KINDS``, ``normalize`` 0 or 1. Coordinates beyond the dimensions are not read.
"""

import functools
import math

from ...jit import kernel, specialised
from .hashing import bits, point_1, unit_2
from .perlin import SIGNED_NOISE

MULTIFRACTAL, FBM, HYBRID, RIDGED, TERRAIN = range(5)
KINDS = {
    "MULTIFRACTAL": MULTIFRACTAL,
    "FBM": FBM,
    "HYBRID_MULTIFRACTAL": HYBRID,
    "RIDGED_MULTIFRACTAL": RIDGED,
    "HETERO_TERRAIN": TERRAIN,
}

MOST_DETAIL = 15.0
MOST_OCTAVES = 1000.0  # of a detail without limits, whose sum does not change any more

# The dimensions of a copy of the kernels: see the end of the file.
DIMENSIONS, signed_noise = 3, SIGNED_NOISE[3]


@kernel
def _fractal(kind, normalize, p, detail, roughness, lacunarity, offset, gain):
    """The last octave is weighted by the fractional part of ``detail``; ridges have no such octave."""
    whole = int(detail)
    rest = detail - math.floor(detail)
    octaves = whole + 2 if rest > 0.0 and kind != RIDGED else whole + 1
    scale, amplitude, weight, total, most = 1.0, 1.0, 1.0, 0.0, 0.0
    value = 1.0 if kind == MULTIFRACTAL else 0.0
    for octave in range(octaves):
        share = 1.0 if octave <= whole else rest
        signal = signed_noise(p, scale)
        if kind == MULTIFRACTAL:
            value *= share * amplitude * signal + 1.0
        elif kind == FBM:
            total += amplitude * signal
            most += amplitude
            value += share * ((0.5 * total / most + 0.5 if normalize else total) - value)
        elif kind == HYBRID:
            if weight <= 0.001:
                break
            weight = min(weight, 1.0)
            signal = (signal + offset) * amplitude
            value += share * weight * signal
            weight *= gain * signal
        elif kind == RIDGED:
            signal = offset - abs(signal)
            signal *= signal * weight
            value += signal * amplitude
            weight = min(max(0.0, signal * gain), 1.0)
        elif octave == 0:
            value = signal + offset
        else:
            value += share * (signal + offset) * amplitude * value
        scale *= lacunarity
        amplitude *= roughness
    return value


@kernel
def _offset(seed, axis):
    """Offset along an axis of the noise for another colour, or for a direction of the distortion."""
    if DIMENSIONS == 1:
        return 100.0 + 100.0 * point_1(bits(seed))
    return 100.0 + 100.0 * unit_2(bits(seed), bits(axis))


@kernel
def _shifted(p, seed):
    x, y, z, w = p
    x += _offset(seed, 0.0)
    if DIMENSIONS > 1:
        y += _offset(seed, 1.0)
    if DIMENSIONS > 2:
        z += _offset(seed, 2.0)
    if DIMENSIONS > 3:
        w += _offset(seed, 3.0)
    return x, y, z, w


@kernel
def _distorted(p, distortion):
    x, y, z, w = p
    if distortion != 0.0:
        x += distortion * signed_noise(_shifted(p, 0.0), 1.0)
        if DIMENSIONS > 1:
            y += distortion * signed_noise(_shifted(p, 1.0), 1.0)
        if DIMENSIONS > 2:
            z += distortion * signed_noise(_shifted(p, 2.0), 1.0)
        if DIMENSIONS > 3:
            w += distortion * signed_noise(_shifted(p, 3.0), 1.0)
    return x, y, z, w


@kernel
def _value(kind, normalize, x, y, z, w, detail, roughness, lacunarity, offset, gain, distortion):
    roughness, detail = max(0.0, roughness), min(max(0.0, detail), MOST_DETAIL)
    return _fractal(kind, normalize, _distorted((x, y, z, w), distortion), detail, roughness, lacunarity, offset, gain)


@kernel
def _free_value(kind, normalize, x, y, z, w, detail, roughness, lacunarity, offset, gain):
    return _fractal(kind, normalize, (x, y, z, w), min(detail, MOST_OCTAVES), roughness, lacunarity, offset, gain)


@kernel
def _color(kind, normalize, x, y, z, w, detail, roughness, lacunarity, offset, gain, distortion):
    roughness, detail = max(0.0, roughness), min(max(0.0, detail), MOST_DETAIL)
    p = _distorted((x, y, z, w), distortion)
    q, r = _shifted(p, float(DIMENSIONS)), _shifted(p, DIMENSIONS + 1.0)
    return (
        _fractal(kind, normalize, p, detail, roughness, lacunarity, offset, gain),
        _fractal(kind, normalize, q, detail, roughness, lacunarity, offset, gain),
        _fractal(kind, normalize, r, detail, roughness, lacunarity, offset, gain),
    )


@functools.cache
def _copies(dimensions: int) -> dict:
    given = {"DIMENSIONS": dimensions, "signed_noise": SIGNED_NOISE[dimensions]}
    for part in (_fractal, _offset, _shifted, _distorted, _value, _free_value, _color):
        given[part.__name__] = specialised(part, f"noise{part.__name__}_{dimensions}d", **given)
    return given


def value(dimensions: int):
    """Kernel of the noise texture's value, for a point of so many dimensions."""
    return _copies(dimensions)["_value"]


def free_value(dimensions: int):
    """Kernel of noise without limits of its detail and roughness, and without distortion."""
    return _copies(dimensions)["_free_value"]


def color(dimensions: int):
    """Kernel of the noise texture's colour, for a point of so many dimensions."""
    return _copies(dimensions)["_color"]
