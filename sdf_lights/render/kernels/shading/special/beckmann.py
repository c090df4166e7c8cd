# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Visible normals of Beckmann's distribution, as in Jakob 2014, "An improved visible normal sampling routine for the
Beckmann distribution"."""

import math

from .....jit import kernel
from .....vec import normalize

_SMALLEST = 1e-6  # limit for values that may be a random number 0 or 1
_STEPS = 4  # of Newton's method


@kernel
def _erf(x):
    """Abramowitz and Stegun 1964, 7.1.26; the error is at most 1.5e-7."""
    t = 1.0 / (1.0 + 0.3275911 * abs(x))
    y = ((((1.061405429 * t - 1.453152027) * t + 1.421413741) * t - 0.284496736) * t + 0.254829592) * t
    return math.copysign(1.0 - y * math.exp(-x * x), x)


@kernel
def _erf_inverse(x):
    """Giles 2010, "Approximating the erfinv function"."""
    w = -math.log(max((1.0 - x) * (1.0 + x), 1e-30))
    if w < 5.0:
        w -= 2.5
        p = 2.81022636e-08
        p = 3.43273939e-07 + p * w
        p = -3.5233877e-06 + p * w
        p = -4.39150654e-06 + p * w
        p = 0.00021858087 + p * w
        p = -0.00125372503 + p * w
        p = -0.00417768164 + p * w
        p = 0.246640727 + p * w
        p = 1.50140941 + p * w
    else:
        w = math.sqrt(w) - 3.0
        p = -0.000200214257
        p = 0.000100950558 + p * w
        p = 0.00134934322 + p * w
        p = -0.00367342844 + p * w
        p = 0.00573950773 + p * w
        p = -0.0076224613 + p * w
        p = 0.00943887047 + p * w
        p = 1.00167406 + p * w
        p = 2.83297682 + p * w
    return p * x


@kernel
def _beckmann_slope(cosine, u):
    """A slope along the view of a surface of roughness 1 seen under ``cosine``.

    The cumulative distribution of e = erf(slope) is proportional to 1 + e + tan θ · exp(−erf⁻¹(e)²) / √π. Newton's
    method inverts it, inside an interval that contains the root.
    """
    tangent = math.sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine
    cotangent = 1.0 / max(tangent, 1e-12)
    factor = tangent / math.sqrt(math.pi)
    low, high = -1.0, _erf(cotangent)
    wanted = u * (1.0 + high + factor * math.exp(-cotangent * cotangent))
    # With the exponential approximated by 1 − e², the equation is quadratic.
    e = wanted - 1.0
    if factor > 1e-6:
        e = (0.5 - math.sqrt(max(factor * (factor - wanted + 1.0) + 0.25, 0.0))) / factor
    slope = 0.0
    for _ in range(_STEPS):
        if not low <= e <= high:
            e = 0.5 * (low + high)
        slope = _erf_inverse(e)
        value = 1.0 + e + factor * math.exp(-slope * slope) - wanted
        if value > 0.0:
            high = e
        else:
            low = e
        e -= value / (1.0 - slope * tangent)
    return slope


@kernel
def beckmann_normal(wo, along, across, u1, u2):
    """As ``microfacet.visible_normal``, for Beckmann's distribution."""
    u1, u2 = min(max(u1, _SMALLEST), 1.0 - _SMALLEST), min(max(u2, _SMALLEST), 1.0 - _SMALLEST)
    view = normalize((along * wo[0], across * wo[1], wo[2]))
    sine = math.sqrt(view[0] * view[0] + view[1] * view[1])
    if sine < 1e-4:
        radius, phi = math.sqrt(-math.log(u1)), 2.0 * math.pi * u2
        x, y = radius * math.cos(phi), radius * math.sin(phi)
    else:
        p, q = _beckmann_slope(view[2], u1), _erf_inverse(2.0 * u2 - 1.0)
        c, s = view[0] / sine, view[1] / sine
        x, y = c * p - s * q, s * p + c * q
    return normalize((-along * x, -across * y, 1.0))
