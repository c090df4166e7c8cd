# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel terms: the dielectric, and the F82-Tint metal of Kutz, Hasan and Edmondson 2021, "Novel aspects of the
Adobe Standard Material"."""

import math

from ....jit import kernel

# F82-Tint defines its tint at the cosine 1/7, where the factor cosθ (1 − cosθ)⁶ is largest.
_EDGE = 6.0 / 7.0
_EDGE5 = _EDGE**5
_EDGE_SCALE = 7.0 / _EDGE**6


@kernel
def dielectric(cosine, ior):
    """Unpolarised reflectance and the cosine of the refracted ray (positive; 0 for total internal reflection).

    ``ior`` is that of the far side relative to the side of the ray; the sign of ``cosine`` does not matter.
    """
    cosine = min(abs(cosine), 1.0)
    square = ior * ior - 1.0 + cosine * cosine
    if square <= 0.0:
        return 1.0, 0.0
    g = math.sqrt(square)  # ior · cosine of the refracted ray
    # The amplitudes are (cosine − g) / (cosine + g) and (dense − g) / (dense + g): one division for both.
    dense = ior * ior * cosine
    inverse = 1.0 / ((cosine + g) * (dense + g))
    s, p = (cosine - g) * (dense + g) * inverse, (dense - g) * (cosine + g) * inverse
    return 0.5 * (s * s + p * p), g / ior


@kernel
def polarized(cosine, ior):
    """Reflected amplitudes of light polarised perpendicularly (s) and parallel (p) to the plane of incidence, and the
    cosine of the refracted ray; 1, 1 and 0 for total internal reflection. As ``dielectric``."""
    cosine = min(abs(cosine), 1.0)
    square = ior * ior - 1.0 + cosine * cosine
    if square <= 0.0:
        return 1.0, 1.0, 0.0
    g = math.sqrt(square)
    cosine_t = g / ior
    return (cosine - g) / (cosine + g), (ior * cosine - cosine_t) / (ior * cosine + cosine_t), cosine_t


@kernel
def conductor_amplitudes(cosine, outside, n, k):
    """Real and imaginary part of the amplitudes that a conductor of index n + ik reflects, for light polarised
    perpendicularly (s), then parallel (p); ``outside`` is the index of the medium in front of it.

    Born and Wolf 1999, "Principles of Optics", section 14.4.1.
    """
    e, ek = n * n - k * k, 2.0 * n * k  # the square of the index
    a = e - outside * outside * (1.0 - cosine * cosine)
    size = math.sqrt(a * a + ek * ek)
    # u + iv is the index times the cosine of the refracted ray.
    u, v = math.sqrt(max(0.5 * (size + a), 0.0)), math.sqrt(max(0.5 * (size - a), 0.0))
    c = outside * cosine
    s_norm = max((c + u) * (c + u) + v * v, 1e-30)
    x, y, p, q = e * cosine, ek * cosine, outside * u, outside * v
    p_norm = max((x + p) * (x + p) + (y + q) * (y + q), 1e-30)
    return (
        (c * c - u * u - v * v) / s_norm,
        -2.0 * c * v / s_norm,
        (x * x + y * y - p * p - q * q) / p_norm,
        2.0 * (y * p - x * q) / p_norm,
    )


@kernel
def conductor(cosine, n, k):
    """Unpolarised reflectance of a conductor of index n + ik in air."""
    a, b, c, d = conductor_amplitudes(cosine, 1.0, n, k)
    return min(0.5 * (a * a + b * b + c * c + d * d), 1.0)


@kernel
def f0_of_ior(ior):
    """Reflectance at normal incidence."""
    ratio = (ior - 1.0) / (ior + 1.0)
    return ratio * ratio


@kernel
def ior_of_f0(f0):
    """The index above 1 with this reflectance at normal incidence."""
    root = math.sqrt(min(max(f0, 0.0), 0.99))
    return (1.0 + root) / (1.0 - root)


@kernel
def dielectric_average(ior):
    """Cosine-weighted average reflectance, ∫ 2 μ F(μ) dμ.

    Fits of Kulla and Conty 2017, "Revisiting physically based shading at Imageworks".
    """
    if ior < 1.0:
        return 0.997118 + ior * (0.1014 - ior * (0.965241 + ior * 0.130607))
    return (ior - 1.0) / (4.08567 + 1.00071 * ior)


@kernel
def remapped(reflectance, ior):
    """Position of a real dielectric's reflectance between its own F0 (0), which is that of ``f0_of_ior``, and 1 (1)."""
    above, below = ior + 1.0, ior - 1.0
    return min(max((reflectance * above * above - below * below) / (4.0 * ior), 0.0), 1.0)


@kernel
def f82_edge(f0, tint):
    """The factor B of F = Schlick − B cosθ (1 − cosθ)⁶ for which the tint multiplies Schlick's value at 82°."""
    return (f0 + (1.0 - f0) * _EDGE5) * _EDGE_SCALE * (1.0 - tint)


@kernel
def f82_edge_through(f0, value):
    """The factor B for which the reflectance at 82° is ``value``."""
    return (f0 + (1.0 - f0) * _EDGE5 - value) * _EDGE_SCALE


@kernel
def f82(cosine, f0, edge):
    """Reflectance of a metal: Schlick's, minus ``edge`` times the term that lowers it near 82°."""
    s = min(max(1.0 - cosine, 0.0), 1.0)
    s5 = s * s * s * s * s
    return min(max(f0 + (1.0 - f0) * s5 - edge * cosine * s5 * s, 0.0), 1.0)


@kernel
def f82_average(f0, edge):
    """∫ 2 μ F(μ) dμ in closed form: Schlick's 1/21 and ∫ 2 μ² (1 − μ)⁶ dμ = 1/126."""
    return f0 + (1.0 - f0) / 21.0 - edge / 126.0
