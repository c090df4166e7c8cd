# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse closures: energy-preserving Oren–Nayar and the sheen of linearly transformed cosines.

Oren–Nayar: Fujii 2012, "Improved Oren–Nayar" (the qualitative form), with multiple scattering as OpenPBR 1.1
specifies. Sheen: Zeltner, Burley and Chiang 2022, "Practical multiple-scattering sheen using linearly transformed
cosines"; the terms of its closure are from ``energy.sheen``.
"""

import math

from ....jit import kernel
from ....vec import cross, dot, frame, madd, normalize, to_world, vec

_HALF_PI = 0.5 * math.pi


@kernel
def cosine_hemisphere(u1, u2):
    """A direction about z with pdf cosθ/π (Malley's method), by Shirley and Chiu's 1997 concentric map of the disk."""
    a, b = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    if a == 0.0 and b == 0.0:
        return (0.0, 0.0, 1.0)
    if abs(a) > abs(b):
        radius, phi = a, 0.25 * math.pi * b / a
    else:
        radius, phi = b, _HALF_PI - 0.25 * math.pi * a / b
    return (radius * math.cos(phi), radius * math.sin(phi), math.sqrt(max(1.0 - radius * radius, 0.0)))


@kernel
def _oren_nayar_g(cosine):
    if cosine < 1e-6:  # the limit, where tan θ overflows
        return (_HALF_PI - 2.0 / 3.0) - cosine
    cosine = min(cosine, 1.0)
    sine = math.sqrt(1.0 - cosine * cosine)
    return sine * (math.acos(cosine) - 2.0 / 3.0 - sine * cosine) + 2.0 / 3.0 * (sine / cosine) * (1.0 - sine**3)


@kernel
def oren_nayar_setup(closure, cosine, roughness, color):
    """Fill A, B and the multiple scattering of an Oren–Nayar closure; ``cosine`` is that of wo."""
    sigma = min(max(roughness, 0.0), 1.0)
    a = 1.0 / (math.pi + sigma * (_HALF_PI - 2.0 / 3.0))
    b = sigma * a
    mean = a * math.pi + (2.0 * math.pi - 5.6) / 3.0 * b
    lost = 1.0 - (a * math.pi + b * _oren_nayar_g(max(cosine, 0.0)))
    closure.a = a
    closure.b = b
    for i in range(3):
        albedo = min(max(color[i], 0.0), 1.0)
        closure.multiscatter[i] = albedo * albedo / math.pi * mean / (1.0 - mean) / (1.0 - albedo * (1.0 - mean)) * lost


@kernel
def oren_nayar(closure, wo, wi):
    """f · cos; black below the surface. The closure's weight holds the colour once."""
    n = vec(closure.normal)
    cosine_i, cosine_o = dot(n, wi), max(dot(n, wo), 0.0)
    if cosine_i <= 0.0:
        return (0.0, 0.0, 0.0)
    t = dot(wi, wo) - cosine_i * cosine_o
    if t > 0.0:
        t /= max(cosine_i, cosine_o)
    single = closure.a + closure.b * t
    lost = 1.0 - (closure.a * math.pi + closure.b * _oren_nayar_g(cosine_i))
    m = closure.multiscatter
    return (cosine_i * (single + m[0] * lost), cosine_i * (single + m[1] * lost), cosine_i * (single + m[2] * lost))


@kernel
def _sheen_frame(n, wo):
    t = madd(wo, -dot(n, wo), n)
    if dot(t, t) < 1e-12:
        return frame(n)
    t = normalize(t)
    return t, cross(n, t)


@kernel
def sheen(closure, wo, wi):
    """f · cos of sheen with an albedo of 1, which is its pdf too."""
    n = vec(closure.normal)
    z = dot(n, wi)
    if z <= 0.0:
        return 0.0
    t, b = _sheen_frame(n, wo)
    x = closure.a * dot(t, wi) + closure.b * z
    y = closure.a * dot(b, wi)
    ratio = closure.a / (x * x + y * y + z * z)
    return z * ratio * ratio / math.pi


@kernel
def sheen_sample(closure, wo, u1, u2):
    """Direction wi by the linearly transformed cosine of sheen."""
    n = vec(closure.normal)
    t, b = _sheen_frame(n, wo)
    d = cosine_hemisphere(u1, u2)
    return to_world(normalize((d[0] - d[2] * closure.b, d[1], d[2] * closure.a)), t, b, n)
