# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Principled Hair by Chiang et al. 2016, "A practical and controllable hair and fur model for production path tracing":
light is reflected by a fiber (R), crosses it (TT), is reflected inside once (TRT), or more often.

Fields of the closure: the tangent; f0 is (the offset of the ray from the middle of the fiber, in radii; unused;
unused), edge the absorption, a the variance along the fiber, alpha that of R, b the width around it, c the tilt of its
scales, ior its index.
"""

import math

from .....jit import kernel
from .....vec import add, cross, dot, luminance, madd, mul, normalize, put, scale, vec
from .. import fresnel
from ..closures import begin, finish, lobe_table
from ..operands import number
from ..records import CHIANG, GLOSSY, TRANSMISSION, closure_table, surface_table
from ..special_lobes import lobe_kind
from .fibers import (
    COAT,
    IOR,
    OFFSET,
    RADIAL_ROUGHNESS,
    RANDOM_ROUGHNESS,
    RIBBONS,
    ROUGHNESS,
    TWO_PI,
    absorption,
    across,
    azimuthal,
    cosine_of,
    cut,
    cuts_light_rays,
    longitudinal,
    random_factor,
    sample_azimuthal,
    sample_longitudinal,
    tilted,
)

_NO_DIRECTION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0)
_WIDTH = math.sqrt(math.pi / 8.0)


@kernel
def _clamped(roughness):
    return min(max(roughness, 0.001), 1.0)


@kernel
def _variance(roughness):
    """Equation 7."""
    root = 0.726 * roughness + 0.812 * roughness * roughness + 3.7 * roughness**20
    return root * root


@kernel
def _width(roughness):
    """Equation 8, for a logistic distribution."""
    return (0.265 * roughness + 1.194 * roughness * roughness + 5.372 * roughness**22) * _WIDTH


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, Principled Hair, with this weight."""
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    tangent = normalize(vec(surface.dpdu))
    _, z = across(tangent, vec(surface.wo))
    index = begin(workspace, (weight, weight, weight), vec(surface.n))
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    varied = random_factor(block, workspace, lobe, number(block, workspace, args[RANDOM_ROUGHNESS]))
    roughness = number(block, workspace, args[ROUGHNESS]) * varied
    radial = number(block, workspace, args[RADIAL_ROUGHNESS]) * varied
    sigma = absorption(block, workspace, lobe, radial)
    closure.kind = CHIANG
    closure.reflects = closure.transmits = 1
    closure.distribution = int(cuts_light_rays(surface, lobe))
    put(closure.edge, sigma)
    rough = _clamped(roughness)
    coat = min(max(number(block, workspace, args[COAT]), 0.0), 1.0)
    closure.a = _variance(rough)
    closure.b = _width(_clamped(radial))
    closure.alpha = _variance(_clamped((1.0 - coat) * rough))
    closure.c = -number(block, workspace, args[OFFSET])
    closure.ior = number(block, workspace, args[IOR])
    put(closure.tangent, tangent)
    place = dot(cross(vec(surface.ng), tangent), z)
    if surface.strand == RIBBONS:
        place = -surface.barycentric[1]
    closure.f0[0] = min(max(place, -1.0), 1.0)
    closure.f0[1] = closure.f0[2] = 0.0
    r, tt, trt, more, _, _, _ = _attenuations(closure, vec(surface.wo))
    finish(workspace, index, scale(add(add(r, tt), add(trt, more)), weight))
    return 0.0


@kernel
def _attenuations(closure, wo):
    """Fractions (RGB each) of light that R, TT, TRT and all later orders keep; the sine of the inclination of wo; the
    angles of the ray with the normals of the fiber outside and inside."""
    sine_o = min(max(dot(vec(closure.tangent), wo), -1.0), 1.0)
    cosine_o = cosine_of(sine_o)
    sine_t = sine_o / closure.ior
    h = closure.f0[0]
    inside = min(max(h * cosine_o / math.sqrt(max(closure.ior * closure.ior - sine_o * sine_o, 1e-12)), -1.0), 1.0)
    path = 2.0 * cosine_of(inside) / max(cosine_of(sine_t), 1e-6)
    sigma = vec(closure.edge)
    t = (math.exp(-sigma[0] * path), math.exp(-sigma[1] * path), math.exp(-sigma[2] * path))
    f, _ = fresnel.dielectric(cosine_o * cosine_of(h), closure.ior)
    tt = scale(t, (1.0 - f) * (1.0 - f))
    again = scale(t, f)
    trt = mul(tt, again)
    more = (
        trt[0] * again[0] / max(1.0 - again[0], 1e-9),
        trt[1] * again[1] / max(1.0 - again[1], 1e-9),
        trt[2] * again[2] / max(1.0 - again[2], 1e-9),
    )
    return (f, f, f), tt, trt, more, sine_o, math.asin(h), math.asin(inside)


@kernel
def _deflection(order, outside, inside):
    """Angle by which a smooth fiber would turn a ray around itself."""
    return 2.0 * order * inside - 2.0 * outside + order * math.pi


@kernel
def _scattered(closure, wo, sine_i, phi):
    """f · |cos| and pdf for an inclination and an angle around the fiber from wo."""
    r, tt, trt, more, sine_o, outside, inside = _attenuations(closure, wo)
    cosine_o, cosine_i, tilt, v, s = cosine_of(sine_o), cosine_of(sine_i), closure.c, closure.a, closure.b
    sine, cosine = tilted(sine_o, cosine_o, 2.0 * tilt)
    p0 = longitudinal(sine_i, cosine_i, sine, cosine, closure.alpha) * azimuthal(
        phi - _deflection(0, outside, inside), s
    )
    sine, cosine = tilted(sine_o, cosine_o, -tilt)
    p1 = longitudinal(sine_i, cosine_i, sine, cosine, 0.25 * v) * azimuthal(phi - _deflection(1, outside, inside), s)
    sine, cosine = tilted(sine_o, cosine_o, -4.0 * tilt)
    p2 = longitudinal(sine_i, cosine_i, sine, cosine, 4.0 * v) * azimuthal(phi - _deflection(2, outside, inside), s)
    p3 = longitudinal(sine_i, cosine_i, sine_o, cosine_o, 4.0 * v) / TWO_PI
    value = madd(madd(madd(scale(r, p0), p1, tt), p2, trt), p3, more)
    total = luminance(r) + luminance(tt) + luminance(trt) + luminance(more)
    return value, luminance(value) / max(total, 1e-30)


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    surface = surface_table(workspace)[0]
    wo, wi = vec(surface.wo), (x, y, z)
    first, second = across(vec(closure.tangent), wo)
    phi = math.atan2(dot(second, wi), dot(first, wi)) - math.atan2(dot(second, wo), dot(first, wo))
    value, pdf = _scattered(closure, wo, min(max(dot(vec(closure.tangent), wi), -1.0), 1.0), phi)
    if cut(surface, closure, first, wi):
        return 0.0, 0.0, 0.0, pdf
    return value[0], value[1], value[2], pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure, surface = closure_table(workspace)[int(index)], surface_table(workspace)[0]
    wo = vec(surface.wo)
    r, tt, trt, more, sine_o, outside, inside = _attenuations(closure, wo)
    a, b, c, d = luminance(r), luminance(tt), luminance(trt), luminance(more)
    u = u3 * (a + b + c + d)
    order, v, tilt = 3, 4.0 * closure.a, 0.0
    if u < a:
        order, v, tilt, u = 0, closure.alpha, 2.0 * closure.c, u / a
    elif u < a + b:
        order, v, tilt, u = 1, 0.25 * closure.a, -closure.c, (u - a) / b
    elif u < a + b + c:
        order, tilt, u = 2, -4.0 * closure.c, (u - a - b) / c
    else:
        u = (u - a - b - c) / max(d, 1e-30)
    sine, cosine = tilted(sine_o, cosine_of(sine_o), tilt)
    sine_i = sample_longitudinal(sine, cosine, v, min(u, 1.0), u2)
    phi = TWO_PI * u1
    if order < 3:
        phi = _deflection(order, outside, inside) + sample_azimuthal(closure.b, u1)
    value, pdf = _scattered(closure, wo, sine_i, phi)
    first, second = across(vec(closure.tangent), wo)
    place = phi + math.atan2(dot(second, wo), dot(first, wo))
    cosine_i = cosine_of(sine_i)
    wi = add(
        scale(vec(closure.tangent), sine_i),
        add(scale(first, cosine_i * math.cos(place)), scale(second, cosine_i * math.sin(place))),
    )
    if not pdf > 0.0:
        return _NO_DIRECTION
    through = dot(vec(surface.ng), wi) < 0.0
    if surface.strand:
        through = order > 0  # as Cycles counts it
    kind = TRANSMISSION if through else GLOSSY
    return wi[0], wi[1], wi[2], value[0], value[1], value[2], pdf, kind


LOBES = {lobe_kind("chiang"): (add_lobe, (CHIANG,))}
CLOSURES = (CHIANG,)
