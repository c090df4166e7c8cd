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
_SINGULAR_ALPHA2 = 2e-10  # below this, GGX in Cycles is a perfect mirror too


@kernel
def is_singular(alpha):
    """Whether the roughness is so small that the closure is a perfect mirror."""
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
def visible_normal(wo, alpha, across, u1, u2):
    """A microfacet normal, drawn in proportion to its area as seen from wo; both in the frame of the normal z.
    ``alpha`` is the roughness along x, ``across`` that along y."""
    x, y, z = alpha * wo[0], across * wo[1], wo[2]
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * inverse, y * inverse, z * inverse
    height = (1.0 - u2) * (1.0 + z) - z
    radius = math.sqrt(min(max(1.0 - height * height, 0.0), 1.0))
    phi = 2.0 * math.pi * u1
    hx, hy, hz = alpha * (radius * math.cos(phi) + x), across * (radius * math.sin(phi) + y), height + z
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
        s = fresnel.remapped(real, closure.ior)
        f0, tint = closure.f0, closure.reflection_tint
        f = (f0[0] + (1.0 - f0[0]) * s, f0[1] + (1.0 - f0[1]) * s, f0[2] + (1.0 - f0[2]) * s)
        r = (f[0] * tint[0], f[1] * tint[1], f[2] * tint[2])
        if not closure.transmits or cosine_t == 0.0:
            return r, _BLACK, 0.0
        tint = closure.transmission_tint
        return r, ((1.0 - f[0]) * tint[0], (1.0 - f[1]) * tint[1], (1.0 - f[2]) * tint[2]), cosine_t
    if closure.reflects:
        return (1.0, 1.0, 1.0), _BLACK, 0.0
    real, cosine_t = fresnel.dielectric(cosine, closure.ior)
    if cosine_t == 0.0:
        return _BLACK, _BLACK, 0.0
    return _BLACK, (1.0, 1.0, 1.0), cosine_t


@kernel
def half_vector(closure, wo, wi):
    """Normal of the microfacets that scatter wo to wi, with any sign, and one over its length before normalisation; 0
    if there are none.

    As in Cycles, directions count as refracted that no microfacet refracts, because it would face away or reflect
    totally. Light rays find light there, by which rough glass is brighter; ``sample`` never draws them.
    """
    n = vec(closure.normal)
    cosine_o, cosine_i = dot(n, wo), dot(n, wi)
    through = cosine_i < 0.0
    if cosine_o <= 0.0 or cosine_i == 0.0 or (through and not closure.transmits) or not (through or closure.reflects):
        return wo, 0.0
    h = madd(wo, closure.ior, wi) if through else add(wo, wi)
    square = dot(h, h)
    if square < 1e-16:  # equal indices refract without bending: that refraction is singular
        return wo, 0.0
    inverse = 1.0 / math.sqrt(square)
    h = scale(h, inverse)
    return h, inverse


@kernel
def scattered(closure, wo, wi, h, inverse, r, t, density, masking_o, masking_i):
    """f · |cos| without its weight, and pdf, for microfacets with the normal h and this ``density`` (D) that reflect r
    and transmit t; ``inverse`` is that of ``half_vector``."""
    n = vec(closure.normal)
    total = average(add(r, t))
    if total <= 0.0:
        return _BLACK, 0.0
    below, both = 1.0 + masking_o, 1.0 + masking_o + masking_i
    common = density / (dot(n, wo) * total * below * both)  # divisions take long, so there is one
    part = r
    if dot(n, wi) < 0.0:
        part = t
        common *= closure.ior * closure.ior * inverse * inverse * abs(dot(h, wo) * dot(h, wi))
    else:
        common *= 0.25
    return scale(part, common * total * below), common * average(part) * both


@kernel
def evaluate(closure, wo, wi):
    """f · |cos| of a rough closure without its weight, and the pdf of ``sample``."""
    h, inverse = half_vector(closure, wo, wi)
    if inverse == 0.0:
        return _BLACK, 0.0
    n = vec(closure.normal)
    alpha2 = closure.alpha * closure.alpha
    r, t, _ = reflectance(closure, abs(dot(h, wo)))
    return scattered(
        closure,
        wo,
        wi,
        h,
        inverse,
        r,
        t,
        distribution(alpha2, dot(h, n)),
        masking(alpha2, dot(n, wo)),
        masking(alpha2, dot(n, wi)),
    )


@kernel
def chosen(closure, wo, h, r, t, cosine_t, u):
    """wi, the scattered fraction in that direction, the probability of the choice (0: no direction), and whether wi is
    refracted."""
    cosine_ho = dot(h, wo)
    total = average(add(r, t))
    if total <= 0.0:
        return wo, _BLACK, 0.0, False
    probability = average(r) / total
    through = u >= probability
    if through:
        if closure.ior == 1.0:
            wi = negate(wo)
        else:
            eta = 1.0 / closure.ior
            wi = sub(scale(h, eta * cosine_ho - cosine_t), scale(wo, eta))
        value, probability = t, 1.0 - probability
    else:
        wi = sub(scale(h, 2.0 * cosine_ho), wo)
        value = r
    cosine_i = dot(vec(closure.normal), wi)
    if cosine_i == 0.0 or (cosine_i < 0.0) != through:
        return wo, _BLACK, 0.0, False
    return wi, value, probability, through


@kernel
def spread(closure, wo, h, cosine_t, value, probability, through, density, masking_o, masking_i):
    """f · |cos| and pdf of the result of ``chosen``."""
    below, both = 1.0 + masking_o, 1.0 + masking_o + masking_i
    common = density / (dot(vec(closure.normal), wo) * below * both)
    if through:
        cosine_ho = dot(h, wo)
        denominator = cosine_ho - closure.ior * cosine_t
        if denominator == 0.0:
            return _BLACK, 0.0
        common *= closure.ior * closure.ior * cosine_ho * cosine_t / (denominator * denominator)
    else:
        common *= 0.25
    return scale(value, common * below), common * probability * both


@kernel
def sample(closure, wo, u1, u2, u3):
    """A direction (pdf 0: none), f · |cos|, pdf, whether it is refracted, and whether it is singular."""
    n = vec(closure.normal)
    cosine_o = dot(n, wo)
    if cosine_o <= 0.0:
        return wo, _BLACK, 0.0, False, False
    h, cosine_h = n, 1.0
    if closure.singular == 0:
        t, b = frame(n)
        local = visible_normal((dot(t, wo), dot(b, wo), cosine_o), closure.alpha, closure.alpha, u1, u2)
        h, cosine_h = to_world(local, t, b, n), local[2]
    r, tr, cosine_t = reflectance(closure, dot(h, wo))
    wi, value, pdf, through = chosen(closure, wo, h, r, tr, cosine_t, u3)
    if pdf <= 0.0:
        return wo, _BLACK, 0.0, False, False
    if closure.singular != 0 or through and closure.ior == 1.0:
        return wi, value, pdf, through, True
    alpha2 = closure.alpha * closure.alpha
    value, pdf = spread(
        closure,
        wo,
        h,
        cosine_t,
        value,
        pdf,
        through,
        distribution(alpha2, cosine_h),
        masking(alpha2, cosine_o),
        masking(alpha2, dot(n, wi)),
    )
    return wi, value, pdf, through, False
