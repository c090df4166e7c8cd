# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Microfacets that ``microfacet.py`` lacks: anisotropic ones, Beckmann's distribution, and thin films.

Heitz 2014, "Understanding the masking-shadowing function in microfacet-based BRDFs", for the anisotropic forms; Walter
et al. 2007, "Microfacet models for refraction through rough surfaces", for Beckmann's.
"""

import math

from .....jit import kernel
from .....vec import add, cross, dot, frame, madd, mul, normalize, put, scale, to_world, vec
from .. import energy, fresnel, microfacet
from ..closures import (
    begin_glass,
    begin_microfacet,
    begin_refraction,
    finish,
    lobe_table,
    positive,
    saturate,
    specular_normal,
)
from ..material_records import (
    ANISOTROPIC,
    ANISOTROPIC_ROTATION,
    MULTISCATTER,
    NONE,
    NORMAL,
    TANGENT_INPUT,
    THIN_FILM_IOR,
    THIN_FILM_THICKNESS,
)
from ..microfacet import chosen, half_vector, is_singular, scattered, spread
from ..operands import normal, number, vector
from ..records import (
    BECKMANN,
    FACETS,
    FRESNEL_CONDUCTOR,
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    GGX,
    GLOSSY,
    SINGULAR,
    THINNEST_FILM,
    TRANSMISSION,
    closure_table,
    surface_table,
)
from ..special_lobes import (
    BARE_METAL,
    LOBE_ROUGH_GLASS,
    LOBE_ROUGH_GLOSSY,
    LOBE_ROUGH_REFRACTION,
    WITH_BECKMANN,
)
from . import thin_film
from .beckmann import beckmann_normal

_BLACK = (0.0, 0.0, 0.0)
_NOTHING = (0.0, 0.0, 0.0, 0.0)
_NO_DIRECTION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0)


# What a closure is made of


@kernel
def turned(v, axis, angle):
    """v rotated about a unit vector (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    return add(madd(scale(v, c), s, cross(axis, v)), scale(axis, dot(axis, v) * (1.0 - c)))


@kernel
def tangent_of(block, workspace, operand, axis, turns):
    """The tangent of an input, or one around the object's z axis, rotated about ``axis`` by so many turns."""
    surface = surface_table(workspace)[0]
    if operand == NONE:
        n = vec(surface.n)
        t = cross(n, normalize(cross(vec(surface.radial), n)))
    else:
        t = vector(block, workspace, operand)
    return turned(t, axis, 2.0 * math.pi * turns) if turns != 0.0 else t


@kernel
def frame_about(n, t):
    """Two unit vectors that complete n to a right-handed frame (t', b, n), with t' as near to t as possible."""
    b = normalize(cross(n, t))
    if not dot(b, b) > 0.5:
        return frame(n)
    return cross(b, n), b


@kernel
def begin_facets(closure, distribution):
    """Make a closure of ``begin_microfacet`` one of this module, still isotropic and without a film."""
    closure.kind = FACETS
    closure.distribution = distribution
    closure.a = closure.alpha
    closure.b = 0.0
    closure.c = 1.0


@kernel
def stretch(closure, along, across, tangent):
    """Set other roughnesses of microfacets. Returns the roughness for the look-up of their albedo."""
    closure.alpha, closure.a = saturate(along), saturate(across)
    put(closure.tangent, tangent)
    alpha_product = closure.alpha * closure.a
    closure.singular = int(is_singular(math.sqrt(alpha_product)))
    return math.sqrt(math.sqrt(alpha_product))


@kernel
def aspect(anisotropy):
    """Ratio by which Principled divides the roughness along the tangent, and multiplies that across (Burley 2012)."""
    return math.sqrt(1.0 - 0.9 * anisotropy)


@kernel
def cover(closure, thickness, ior):
    """Put a film on microfacets, if it is thick enough. Returns whether it is."""
    if not thickness > THINNEST_FILM:
        return False
    closure.b, closure.c = thickness, max(ior, 1e-5)
    return True


# What it does


@kernel
def _metal_under_film(block, closure, channel, cosine):
    n, k, at_82 = closure.f0[channel], closure.edge[channel], -1.0
    if closure.fresnel == FRESNEL_F82:
        at_82 = fresnel.f82(1.0 / 7.0, n, k)
        n, k = thin_film.index_of_metal(n, at_82)
    return thin_film.conductor(block, channel, cosine, n, k, at_82, closure.c, closure.b)


@kernel
def reflectance(block, closure, cosine):
    """As ``microfacet.reflectance``."""
    if closure.b == 0.0:
        if closure.fresnel != FRESNEL_CONDUCTOR:
            return microfacet.reflectance(closure, cosine)
        n, k = closure.f0, closure.edge
        return (
            (
                fresnel.conductor(cosine, n[0], k[0]),
                fresnel.conductor(cosine, n[1], k[1]),
                fresnel.conductor(cosine, n[2], k[2]),
            ),
            _BLACK,
            0.0,
        )
    if closure.fresnel != FRESNEL_DIELECTRIC:
        return (
            (
                _metal_under_film(block, closure, 0, cosine),
                _metal_under_film(block, closure, 1, cosine),
                _metal_under_film(block, closure, 2, cosine),
            ),
            _BLACK,
            0.0,
        )
    f = thin_film.dielectric(block, cosine, closure.ior, closure.c, closure.b)
    bottom = fresnel.f0_of_ior(closure.ior)
    if bottom > 1e-5 and f != (1.0, 1.0, 1.0):
        f = (
            _tinted(f[0], closure.f0[0], bottom),
            _tinted(f[1], closure.f0[1], bottom),
            _tinted(f[2], closure.f0[2], bottom),
        )
    tint = closure.reflection_tint
    r = (f[0] * tint[0], f[1] * tint[1], f[2] * tint[2])
    _, cosine_t = fresnel.dielectric(cosine, closure.ior)
    if not closure.transmits or cosine_t == 0.0:
        return r, _BLACK, cosine_t
    tint = closure.transmission_tint
    return r, ((1.0 - f[0]) * tint[0], (1.0 - f[1]) * tint[1], (1.0 - f[2]) * tint[2]), cosine_t


@kernel
def _tinted(f, f0, bottom):
    """Reflectance f in the artist's terms, where that at normal incidence is f0 instead of ``bottom``: fully applied if
    f is ``bottom`` or less, not at all if f is 1."""
    return f * (1.0 + saturate((1.0 - f) / (1.0 - bottom)) * (f0 / bottom - 1.0))


@kernel
def _slope(closure, w):
    """tan² of the angle between w and the normal in the space where roughnesses along and across are 1, times cos²; for
    a normal ``w``, that of the distribution of normals."""
    t, b = frame_about(vec(closure.normal), vec(closure.tangent))
    x, y = dot(t, w) / closure.alpha, dot(b, w) / closure.a
    return x * x + y * y


@kernel
def density(closure, h):
    """Distribution of normals D."""
    z = dot(vec(closure.normal), h)
    square = min(z * z, 1.0)
    slope = (1.0 - square) / (closure.alpha * closure.alpha) if closure.alpha == closure.a else _slope(closure, h)
    scale_ = 1.0 / (math.pi * closure.alpha * closure.a)
    if closure.distribution == GGX:
        root = slope + square
        return scale_ / (root * root)
    if square < 1e-12:
        return 0.0
    return scale_ * math.exp(-slope / square) / (square * square)


@kernel
def masking(closure, w):
    """Smith's Λ."""
    z = dot(vec(closure.normal), w)
    square = z * z
    if closure.alpha == closure.a:
        x = closure.alpha * closure.alpha * max(1.0 / square - 1.0, 0.0)
    else:
        t, b = frame_about(vec(closure.normal), vec(closure.tangent))
        p, q = closure.alpha * dot(t, w), closure.a * dot(b, w)
        x = (p * p + q * q) / square
    if closure.distribution == GGX:
        return 0.5 * (math.sqrt(1.0 + x) - 1.0)
    if x < 0.39:  # a rational fit from here on
        return 0.0
    a = 1.0 / math.sqrt(x)
    return (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a)


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| of a rough closure without its weight, and the pdf of ``sample``."""
    closure = closure_table(workspace)[int(index)]
    wo, wi = vec(surface_table(workspace)[0].wo), (x, y, z)
    h, inverse = half_vector(closure, wo, wi)
    if inverse == 0.0:
        return _NOTHING
    r, t, _ = reflectance(block, closure, abs(dot(h, wo)))
    value, pdf = scattered(
        closure, wo, wi, h, inverse, r, t, density(closure, h), masking(closure, wo), masking(closure, wi)
    )
    return value[0], value[1], value[2], pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure = closure_table(workspace)[int(index)]
    wo, n = vec(surface_table(workspace)[0].wo), vec(closure.normal)
    cosine_o = dot(n, wo)
    if cosine_o <= 0.0:
        return _NO_DIRECTION
    h = n
    if closure.singular == 0:
        t, b = frame(n) if closure.alpha == closure.a else frame_about(n, vec(closure.tangent))
        view = (dot(t, wo), dot(b, wo), cosine_o)
        if closure.distribution == GGX:
            local = microfacet.visible_normal(view, closure.alpha, closure.a, u1, u2)
        else:
            local = beckmann_normal(view, closure.alpha, closure.a, u1, u2)
        h = to_world(local, t, b, n)
    r, tr, cosine_t = reflectance(block, closure, dot(h, wo))
    wi, value, pdf, through = chosen(closure, wo, h, r, tr, cosine_t, u3)
    if pdf <= 0.0:
        return _NO_DIRECTION
    side = TRANSMISSION if through else GLOSSY
    if closure.singular != 0 or through and closure.ior == 1.0:
        return wi[0], wi[1], wi[2], value[0], value[1], value[2], pdf, side | SINGULAR
    value, pdf = spread(
        closure, wo, h, cosine_t, value, pdf, through, density(closure, h), masking(closure, wo), masking(closure, wi)
    )
    return wi[0], wi[1], wi[2], value[0], value[1], value[2], pdf, side


# Lobes


@kernel
def smooth_albedo(block, closure, cosine):
    """Reflectance and transmittance of a smooth surface. Keeps the reflectance for passes."""
    r, t, _ = reflectance(block, closure, cosine)
    put(closure.thin_film, r)
    return add(r, t)


@kernel
def refine(block, workspace, lobe, index, roughness):
    """For microfacets of Principled: see ``dispatch.refine``."""
    features, args = lobe_table(block)[int(lobe)].features, lobe_table(block)[int(lobe)].args
    closure, surface = closure_table(workspace)[int(index)], surface_table(workspace)[0]
    anisotropy = 0.0 if closure.transmits else saturate(number(block, workspace, args[ANISOTROPIC]))
    thickness = number(block, workspace, args[THIN_FILM_THICKNESS])
    if features & BARE_METAL and closure.fresnel == FRESNEL_F82:
        thickness = 0.0
    if anisotropy > 0.0 or thickness > THINNEST_FILM:
        begin_facets(closure, GGX)
    if anisotropy > 0.0:
        ratio = aspect(anisotropy)
        tangent = tangent_of(
            block,
            workspace,
            args[TANGENT_INPUT],
            normal(block, workspace, args[NORMAL]),
            number(block, workspace, args[ANISOTROPIC_ROTATION]),
        )
        roughness = stretch(closure, closure.alpha / ratio, closure.alpha * ratio, tangent)
    ior = number(block, workspace, args[THIN_FILM_IOR])
    if closure.transmits and surface.backfacing:
        ior *= closure.ior
    if not cover(closure, thickness, ior):
        return roughness, -1.0, -1.0, -1.0
    albedo = smooth_albedo(block, closure, dot(vec(closure.normal), vec(surface.wo)))
    return roughness, albedo[0], albedo[1], albedo[2]


@kernel
def begin_glossy(block, workspace, lobe, weight, distribution):
    """Index of a new closure of Glossy (−1: none), and the roughness for the look-up of its albedo."""
    surface, args = surface_table(workspace)[0], lobe.args
    roughness = saturate(number(block, workspace, args[1]))
    n = specular_normal(surface, normal(block, workspace, args[2]))
    index = begin_microfacet(workspace, weight, n, roughness, 1.0)
    if index < 0:
        return index, roughness
    closure = closure_table(workspace)[index]
    begin_facets(closure, distribution)
    anisotropy = min(max(number(block, workspace, args[3]), -0.99), 0.99)
    if abs(anisotropy) > 1e-4:
        tangent = tangent_of(block, workspace, args[5], n, number(block, workspace, args[4]))
        along, across = 1.0 - anisotropy, 1.0 / (1.0 - anisotropy)
        if anisotropy < 0.0:
            along, across = 1.0 / (1.0 + anisotropy), 1.0 + anisotropy
        roughness = stretch(closure, closure.alpha * along, closure.alpha * across, tangent)
    return index, roughness


@kernel
def add_glossy(block, workspace, lobe, weight):
    """Glossy BSDF with Beckmann's distribution, or an anisotropic one."""
    lobe = lobe_table(block)[int(lobe)]
    color = positive(vector(block, workspace, lobe.args[0]))
    index, roughness = begin_glossy(
        block, workspace, lobe, scale(color, weight), BECKMANN if lobe.features & WITH_BECKMANN else GGX
    )
    if index >= 0:
        closure = closure_table(workspace)[index]
        cosine = dot(vec(closure.normal), vec(surface_table(workspace)[0].wo))
        e = energy.reflection_albedo(block, cosine, roughness)
        if lobe.features & MULTISCATTER:
            energy.compensate_reflection(block, closure, e, roughness, color)
        finish(workspace, index, scale(vec(closure.weight), e))
    return 0.0


@kernel
def add_glass(block, workspace, lobe, weight):
    """Glass BSDF with Beckmann's distribution, or under a film."""
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    color = positive(vector(block, workspace, args[0]))
    roughness = saturate(number(block, workspace, args[1]))
    ior = max(number(block, workspace, args[2]), 1e-5)
    n = specular_normal(surface, normal(block, workspace, args[3]))
    f0 = fresnel.f0_of_ior(ior)
    index = begin_glass(workspace, (weight, weight, weight), n, roughness, ior, (f0, f0, f0), color, color)
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    begin_facets(closure, BECKMANN if lobe.features & WITH_BECKMANN else GGX)
    film_ior = max(number(block, workspace, args[5]), 1e-5)
    cover(closure, number(block, workspace, args[4]), film_ior / ior if surface.backfacing else film_ior)
    cosine = dot(n, vec(surface.wo))
    if lobe.features & MULTISCATTER:
        energy.compensate_glass(block, closure, cosine, roughness, color)
    finish(workspace, index, mul(vec(closure.weight), smooth_albedo(block, closure, cosine)))
    return 0.0


@kernel
def add_refraction(block, workspace, lobe, weight):
    """Refraction BSDF with Beckmann's distribution."""
    lobe = lobe_table(block)[int(lobe)]
    color = scale(positive(vector(block, workspace, lobe.args[0])), weight)
    index = begin_refraction(block, workspace, lobe, color)
    if index >= 0:
        begin_facets(closure_table(workspace)[index], BECKMANN)
        finish(workspace, index, color)
    return 0.0


LOBES = {
    LOBE_ROUGH_GLOSSY: (add_glossy, (FACETS,)),
    LOBE_ROUGH_GLASS: (add_glass, (FACETS,)),
    LOBE_ROUGH_REFRACTION: (add_refraction, (FACETS,)),
}
CLOSURES = (FACETS,)
