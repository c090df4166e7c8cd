# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel terms: the dielectric, and the F82-Tint metal of Kutz, Hasan and Edmondson 2021, "Novel aspects of the
Adobe Standard Material"."""

import math

from ....jit import kernel

# F82-Tint states its tint at the cosine 1/7, where the factor cosθ (1 − cosθ)⁶ is largest.
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
    cosine_t = g / ior
    s = (cosine - g) / (cosine + g)
    p = (ior * cosine - cosine_t) / (ior * cosine + cosine_t)
    return 0.5 * (s * s + p * p), cosine_t


@kernel
def f0_of_ior(ior):
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
def remapped(reflectance, f0_real):
    """Where a real dielectric's reflectance lies between its own F0 (0) and 1 (1)."""
    if f0_real >= 1.0:
        return 1.0
    return min(max((reflectance - f0_real) / (1.0 - f0_real), 0.0), 1.0)


@kernel
def f82_edge(f0, tint):
    """The factor B of F = Schlick − B cosθ (1 − cosθ)⁶ for which the tint multiplies Schlick's value at 82°."""
    return (f0 + (1.0 - f0) * _EDGE5) * _EDGE_SCALE * (1.0 - tint)


@kernel
def f82(cosine, f0, edge):
    s = min(max(1.0 - cosine, 0.0), 1.0)
    s5 = s * s * s * s * s
    return min(max(f0 + (1.0 - f0) * s5 - edge * cosine * s5 * s, 0.0), 1.0)


@kernel
def f82_average(f0, edge):
    """∫ 2 μ F(μ) dμ in closed form: Schlick's 1/21 and ∫ 2 μ² (1 − μ)⁶ dμ = 1/126."""
    return f0 + (1.0 - f0) / 21.0 - edge / 126.0
