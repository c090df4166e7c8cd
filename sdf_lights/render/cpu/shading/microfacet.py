# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""GGX microfacet closures: reflection, refraction and both.

Walter et al. 2007, "Microfacet models for refraction through rough surfaces"; masking and shadowing correlated by
height, Heitz 2014, "Understanding the masking-shadowing function in microfacet-based BRDFs"; visible normals by
spherical caps, Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps".
"""

import math

from ....jit import kernel
from ....vec import add, average, dot, frame, madd, negate, scale, sub, to_world, vec
from . import fresnel
from .records import FRESNEL_DIELECTRIC, FRESNEL_F82

_BLACK = (0.0, 0.0, 0.0)
_SINGULAR_ALPHA2 = 2e-10  # below, GGX in Cycles is a perfect mirror too


@kernel
def is_singular(alpha):
    return alpha * alpha <= _SINGULAR_ALPHA2


@kernel
def distribution(alpha2, cosine):
    """GGX distribution of normals D."""
    square = min(cosine * cosine, 1.0)
    root = 1.0 - square + alpha2 * square
    return alpha2 / (math.pi * root * root)


@kernel
def masking(alpha2, cosine):
    """Smith's Λ of GGX."""
    return 0.5 * (math.sqrt(1.0 + alpha2 * max(1.0 / (cosine * cosine) - 1.0, 0.0)) - 1.0)


@kernel
def visible_normal(wo, alpha, u1, u2):
    """A microfacet normal, drawn in proportion to its area as seen from wo; both in the frame of the normal z."""
    x, y, z = alpha * wo[0], alpha * wo[1], wo[2]
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * inverse, y * inverse, z * inverse
    height = (1.0 - u2) * (1.0 + z) - z
    radius = math.sqrt(min(max(1.0 - height * height, 0.0), 1.0))
    phi = 2.0 * math.pi * u1
    hx, hy, hz = alpha * (radius * math.cos(phi) + x), alpha * (radius * math.sin(phi) + y), height + z
    norm = hx * hx + hy * hy + hz * hz
    if norm == 0.0:
        return (0.0, 0.0, 1.0)
    inverse = 1.0 / math.sqrt(norm)
    return (hx * inverse, hy * inverse, hz * inverse)


@kernel
def reflectance(closure, cosine):
    """Reflectance, transmittance (RGB) and cosine of refraction of one microfacet."""
    if closure.fresnel == FRESNEL_F82:
        return (
            (
                fresnel.f82(cosine, closure.f0[0], closure.edge[0]),
                fresnel.f82(cosine, closure.f0[1], closure.edge[1]),
                fresnel.f82(cosine, closure.f0[2], closure.edge[2]),
            ),
            _BLACK,
            0.0,
        )
    if closure.fresnel == FRESNEL_DIELECTRIC:
        real, cosine_t = fresnel.dielectric(cosine, closure.ior)
        s = fresnel.remapped(real, fresnel.f0_of_ior(closure.ior))
        f0, tint = closure.f0, closure.reflection_tint
        f = (f0[0] + (1.0 - f0[0]) * s, f0[1] + (1.0 - f0[1]) * s, f0[2] + (1.0 - f0[2]) * s)
        r = (f[0] * tint[0], f[1] * tint[1], f[2] * tint[2])
        if not closure.transmits or cosine_t == 0.0:
            return r, _BLACK, cosine_t
        tint = closure.transmission_tint
        return r, ((1.0 - f[0]) * tint[0], (1.0 - f[1]) * tint[1], (1.0 - f[2]) * tint[2]), cosine_t
    if closure.reflects:
        return (1.0, 1.0, 1.0), _BLACK, 0.0
    real, cosine_t = fresnel.dielectric(cosine, closure.ior)
    if cosine_t == 0.0:
        return _BLACK, _BLACK, 0.0
    return _BLACK, (1.0, 1.0, 1.0), cosine_t


@kernel
def reflection_probability(r, t):
    return average(r) / average(add(r, t))


@kernel
def evaluate(closure, wo, wi):
    """f · |cos| of a rough closure without its weight, and the pdf of ``sample``."""
    n = vec(closure.normal)
    cosine_o, cosine_i = dot(n, wo), dot(n, wi)
    through = cosine_i < 0.0
    if cosine_o <= 0.0 or cosine_i == 0.0 or (through and not closure.transmits) or not (through or closure.reflects):
        return _BLACK, 0.0
    ior = closure.ior
    h = madd(wo, ior, wi) if through else add(wo, wi)
    square = dot(h, h)
    if square < 1e-16:  # nothing bends where the indices match: that refraction is singular
        return _BLACK, 0.0
    inverse = 1.0 / math.sqrt(square)
    h = scale(h, inverse)
    cosine_ho, cosine_hi = dot(h, wo), dot(h, wi)
    cosine_h = dot(h, n)
    if through and (cosine_ho * cosine_hi >= 0.0 or cosine_ho * cosine_h <= 0.0):
        return _BLACK, 0.0  # no microfacet that faces wo refracts it to wi
    r, t, _ = reflectance(closure, cosine_ho)
    total = average(add(r, t))
    if total <= 0.0:
        return _BLACK, 0.0
    alpha2 = closure.alpha * closure.alpha
    masking_o, masking_i = masking(alpha2, cosine_o), masking(alpha2, cosine_i)
    common = distribution(alpha2, cosine_h) / cosine_o
    if through:
        common *= ior * ior * inverse * inverse * abs(cosine_ho * cosine_hi)
        return scale(t, common / (1.0 + masking_o + masking_i)), common * average(t) / (total * (1.0 + masking_o))
    common *= 0.25
    return scale(r, common / (1.0 + masking_o + masking_i)), common * average(r) / (total * (1.0 + masking_o))


@kernel
def sample(closure, wo, u1, u2, u3):
    """A direction (pdf 0: none), f · |cos|, pdf, whether it is refracted, and whether it is singular."""
    n = vec(closure.normal)
    cosine_o = dot(n, wo)
    if cosine_o <= 0.0:
        return wo, _BLACK, 0.0, False, False
    singular = closure.singular != 0
    alpha = closure.alpha
    if singular:
        h, cosine_h = n, 1.0
    else:
        t, b = frame(n)
        local = visible_normal((dot(t, wo), dot(b, wo), cosine_o), alpha, u1, u2)
        h, cosine_h = to_world(local, t, b, n), local[2]
    cosine_ho = dot(h, wo)
    r, tr, cosine_t = reflectance(closure, cosine_ho)
    total = average(add(r, tr))
    if total <= 0.0:
        return wo, _BLACK, 0.0, False, False
    probability = average(r) / total
    through = u3 >= probability
    if through:
        if closure.ior == 1.0:
            wi, singular = negate(wo), True
        else:
            eta = 1.0 / closure.ior
            wi = sub(scale(h, eta * cosine_ho - cosine_t), scale(wo, eta))
        value, pdf = tr, 1.0 - probability
    else:
        wi = sub(scale(h, 2.0 * cosine_ho), wo)
        value, pdf = r, probability
    cosine_i = dot(n, wi)
    if cosine_i == 0.0 or (cosine_i < 0.0) != through:
        return wo, _BLACK, 0.0, False, False
    if singular:
        return wi, value, pdf, through, True
    alpha2 = alpha * alpha
    masking_o, masking_i = masking(alpha2, cosine_o), masking(alpha2, cosine_i)
    common = distribution(alpha2, cosine_h) / cosine_o
    if through:
        denominator = cosine_ho - closure.ior * cosine_t
        if denominator == 0.0:
            return wo, _BLACK, 0.0, False, False
        common *= closure.ior * closure.ior * cosine_ho * cosine_t / (denominator * denominator)
    else:
        common *= 0.25
    return wi, scale(value, common / (1.0 + masking_o + masking_i)), common * pdf / (1.0 + masking_o), through, False
