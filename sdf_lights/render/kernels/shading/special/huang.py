# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Principled Hair by Huang, Hullin and Hanika 2022, "A microfacet-based hair scattering model": a fiber of rough glass
with an elliptical cross-section. Light is reflected by it (R), crosses it (TT), is reflected inside once (TRT), or more
often.

The scattering of a fiber is an integral over the fiber, because a ray may hit it anywhere. For R it is a sum over the
fiber. For the rest it is also over microfacets, which are drawn at random from the bits of the queried direction. So
the value is an estimate with the right mean. Directions are drawn from simple distributions similar to the lobes, so
their density is exact.

Fields of the closure: the tangent; f0 is (the factors of R, TT, TRT), edge the absorption, alpha
the roughness, a the minor axis relative to the major one, c the tilt of the scales, ior the index.

Vectors are in the frame (across the view, along the fiber, towards the viewer), unless stated otherwise. Angles around
the fiber count from the last axis to the first; γ is the parameter of the ellipse (a sin γ, cos γ) of its normals.
"""

import math

from .....emitter import hashing
from .....jit import kernel
from .....vec import add, cross, dot, frame, length, luminance, madd, negate, normalize, put, scale, sub, to_world, vec
from .. import energy, fresnel, microfacet
from ..closures import add_transparency, begin, finish, lobe_table
from ..material_records import NONE
from ..operands import number, vector
from ..records import GLOSSY, HUANG, TRANSMISSION, closure_table, surface_table
from ..special_lobes import lobe_kind
from .fibers import (
    ASPECT_RATIO,
    AXIS,
    IOR,
    OFFSET,
    R_LOBE,
    RANDOM_ROUGHNESS,
    RIBBONS,
    ROUGHNESS,
    TRT_LOBE,
    TT_LOBE,
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
_STEP = 0.6  # step of the integral over the fiber, in roughnesses
_MOST_STEPS = 512
_TOTAL = 1e-5  # how close to total reflection a ray may leave
# Of the lobes from which directions are drawn: standard deviations along the fiber in roughnesses, widths around it.
_R_ALONG, _TT_ALONG, _TRT_ALONG, _TT_ABOUT, _TRT_ABOUT = 1.7, 1.1, 2.2, 0.38, 0.3
_ANYWHERE = 0.12  # fraction drawn uniformly from all directions
_CERTAIN = 2.0  # density that approximates the certainty which Cycles assigns to all directions


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, Principled Hair, with this weight."""
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    r, tt = max(number(block, workspace, args[R_LOBE]), 0.0), max(number(block, workspace, args[TT_LOBE]), 0.0)
    trt = max(number(block, workspace, args[TRT_LOBE]), 0.0)
    if r + tt + trt <= 0.0:
        return 0.0
    tangent = normalize(vec(surface.dpdu))
    aspect = max(number(block, workspace, args[ASPECT_RATIO]), 1e-3)
    if surface.strand and _is_missed(block, workspace, args[AXIS], min(aspect, 1.0 / aspect)):
        add_transparency(workspace, (weight, weight, weight))
        return 0.0
    index = begin(workspace, (weight, weight, weight), vec(surface.n))
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    roughness = number(block, workspace, args[ROUGHNESS]) * random_factor(
        block, workspace, lobe, number(block, workspace, args[RANDOM_ROUGHNESS])
    )
    closure.kind = HUANG
    closure.reflects = closure.transmits = 1
    closure.distribution = int(cuts_light_rays(surface, lobe))
    put(closure.tangent, tangent)
    put(closure.f0, (r, tt, trt))
    put(closure.edge, absorption(block, workspace, lobe, roughness))
    closure.alpha = min(max(roughness, 0.001), 1.0)
    closure.a = aspect
    closure.c = -number(block, workspace, args[OFFSET])
    closure.ior = number(block, workspace, args[IOR])
    first, second, third, _ = _attenuations(closure, vec(surface.wo))
    finish(workspace, index, scale(add(add(first, second), third), weight))
    return 0.0


@kernel
def _is_missed(block, workspace, axis, aspect):
    """Whether a ray that hits a round strand misses the ellipse in it, whose axes have the ratio ``aspect``."""
    surface = surface_table(workspace)[0]
    tangent, wo = vec(surface.dpdu), vec(surface.wo)
    major = (0.0, 0.0, 0.0)
    if axis != NONE:
        given = vector(block, workspace, axis)
        major = normalize(cross(tangent, normalize(cross(given, tangent))))
    if dot(major, major) < 0.5:
        y = normalize(tangent)
        side = normalize((y[2] - y[1], y[0] - y[2], y[1] - y[0]))
        major = cross(y, side)
    x, z = dot(wo, major), dot(wo, normalize(cross(major, tangent)))
    radius = math.sqrt(1.0 - (1.0 - aspect * aspect) * x * x / max(x * x + z * z, 1e-30))
    place = surface.barycentric[1]
    if surface.strand != RIBBONS:
        place = dot(normalize(cross(tangent, wo)), vec(surface.n))
    return abs(place) >= radius


@kernel
def _attenuations(closure, wo):
    """Approximate fractions (RGB each) of light that R, TT, TRT keep, and the sine of the inclination of wo, which is
    in world space."""
    sine = min(max(dot(vec(closure.tangent), wo), -1.0), 1.0)
    cosine = cosine_of(sine)
    f, _ = fresnel.dielectric(0.8 * cosine, closure.ior)
    path = 1.7 / max(cosine_of(sine / closure.ior), 1e-6)
    sigma, factors = vec(closure.edge), closure.f0
    t = (math.exp(-sigma[0] * path), math.exp(-sigma[1] * path), math.exp(-sigma[2] * path))
    out = (1.0 - f) * (1.0 - f)
    r, tt, trt = factors[0] * f, factors[1] * out, factors[2] * out * f
    return (r, r, r), scale(t, tt), (trt * t[0] * t[0], trt * t[1] * t[1], trt * t[2] * t[2]), sine


# -- the fiber ---------------------------------------------------------------------------------------------------------


@kernel
def _normal(tilt, gamma, b):
    """The normal of the fiber at γ, tilted by its scales."""
    s, c = b * math.sin(gamma), math.cos(gamma)
    inverse = math.cos(tilt) / math.sqrt(s * s + c * c)
    return (s * inverse, math.sin(tilt), c * inverse)


@kernel
def _chord(first, second, b):
    """Length of a chord of the cross-section, whose major half-axis is 1."""
    x, z = math.sin(first) - math.sin(second), b * (math.cos(first) - math.cos(second))
    return math.sqrt(x * x + z * z)


@kernel
def _arc(b, gamma):
    """Length of an arc of the cross-section per unit of γ."""
    s = math.sin(gamma)
    return math.sqrt(max(1.0 - (1.0 - b * b) * s * s, 0.0))


@kernel
def _about_of(w):
    return math.atan2(w[0], w[2])


@kernel
def _on_ellipse(phi, b):
    return math.atan2(b * math.sin(phi), math.cos(phi))


@kernel
def _facet(w, m, alpha, u1, u2):
    """The normal of a microfacet around m, drawn in proportion to its area as seen from w."""
    t, s = frame(m)
    return to_world(microfacet.visible_normal((dot(t, w), dot(s, w), dot(m, w)), alpha, alpha, u1, u2), t, s, m)


@kernel
def _seen(w, m, h):
    return dot(w, h) > 0.0 and dot(w, m) > 0.0


@kernel
def _gain(block, cosine, alpha, ior):
    """Factor that compensates the energy loss of microfacets."""
    return 1.0 / energy.glass_albedo(block, cosine, math.sqrt(alpha), ior)


@kernel
def _masked(alpha2, cosine_o, cosine_i):
    """Masking and shadowing of both directions."""
    return 1.0 / (1.0 + microfacet.masking(alpha2, cosine_o) + microfacet.masking(alpha2, cosine_i))


@kernel
def _shadowed(alpha2, cosine_o, cosine_i):
    """The same, relative to the masking of the first."""
    masking = microfacet.masking(alpha2, cosine_o)
    return (1.0 + masking) / (1.0 + masking + microfacet.masking(alpha2, cosine_i))


@kernel
def _refracted(w, h, cosine, cosine_t, ior):
    """w, on the side of h, refracted to the other side, with ``ior`` relative to its own index."""
    eta = 1.0 / ior
    return sub(scale(h, eta * cosine - cosine_t), scale(w, eta))


@kernel
def _kept(sigma, path):
    return (math.exp(-sigma[0] * path), math.exp(-sigma[1] * path), math.exp(-sigma[2] * path))


@kernel
def _reflected_by(block, closure, wo, wi, gamma):
    """The part of R that is reflected at γ, without Fresnel's term."""
    b, alpha = closure.a, closure.alpha
    alpha2 = alpha * alpha
    h = normalize(add(wo, wi))
    m = _normal(closure.c, gamma, b)
    plain = (m[0], 0.0, m[2])
    if not (_seen(wo, plain, h) and _seen(wi, plain, h)):
        return 0.0
    cosine = dot(m, wo)
    return (
        microfacet.distribution(alpha2, dot(m, h))
        * _masked(alpha2, cosine, dot(m, wi))
        * _arc(b, gamma)
        * _gain(block, cosine, alpha, closure.ior)
    )


@kernel
def _left_by(block, closure, inside, m, wi):
    """Light along −``inside`` at the fiber's inner normal m that leaves the fiber towards wi there, without masking of
    ``inside`` by itself, and with the gain of m."""
    alpha2 = closure.alpha * closure.alpha
    inverse = 1.0 / closure.ior
    h = madd(inside, inverse, wi)
    size = length(h)
    if size < 1e-9:
        return 0.0
    h = scale(h, 1.0 / size)
    cosine_m = dot(m, h)
    if cosine_m < 0.0:
        return 0.0
    cosine_h, cosine = dot(inside, h), dot(inside, m)
    f, _ = fresnel.dielectric(cosine_h, inverse)
    return (
        (1.0 - f)
        * _gain(block, cosine, closure.alpha, inverse)
        * microfacet.distribution(alpha2, cosine_m)
        * _masked(alpha2, cosine, -dot(wi, m))
        * cosine_h
        * -dot(wi, h)
        / (size * size)
    )


@kernel
def _more(out, kept, again):
    """Light of one channel that leaves the fiber after several inner reflections: a geometric series, from the
    fractions that both inner segments keep."""
    part = math.sqrt(kept * again)
    return kept * again * part * out / max(1.0 - part * (1.0 - out), 1e-9)


@kernel
def _crossed(block, closure, wo, wi, gamma, u, v, w):
    """Scattering of TT and TRT (RGB) by a ray that hits the fiber at γ, and the light of all later orders; u, v and w
    are three random numbers each."""
    b, alpha, ior, tilt = closure.a, closure.alpha, closure.ior, closure.c
    alpha2, sigma, none = alpha * alpha, vec(closure.edge), (0.0, 0.0, 0.0)
    m = _normal(tilt, gamma, b)
    h = _facet(wo, m, alpha, u[0], u[1])
    cosine_h, cosine = dot(wo, h), dot(wo, m)
    if not cosine_h > 0.0:
        return none, none
    r, cosine_t = fresnel.dielectric(cosine_h, ior)
    inside = _refracted(wo, h, cosine_h, cosine_t, ior)
    back = negate(inside)
    plain = _normal(0.0, gamma, b)
    if not (_seen(wo, m, h) and _seen(back, m, h) and _seen(wo, plain, h) and _seen(back, plain, h)):
        return none, none
    phi = _about_of(inside)
    second = 2.0 * _on_ellipse(phi, b) - gamma
    n = _normal(-tilt, second, b)
    entered = dot(back, m)
    kept = _kept(
        sigma, _chord(gamma, second + math.pi, b) / max(math.sqrt(inside[0] * inside[0] + inside[2] * inside[2]), 1e-6)
    )
    t = (1.0 - r) * _gain(block, cosine, alpha, ior) * _shadowed(alpha2, cosine, entered)
    total = none
    if closure.f0[1] > 0.0 and dot(wi, inside) >= 1.0 / ior - _TOTAL:
        left = _left_by(block, closure, back, n, wi)
        total = scale(kept, closure.f0[1] * t * left * cosine / entered * _arc(b, second))
    if not closure.f0[2] > 0.0:
        return total, none
    # Reflected inside.
    h2 = _facet(back, n, alpha, v[0], v[1])
    cosine_h2, cosine2 = dot(back, h2), dot(back, n)
    plain2 = _normal(0.0, second, b)
    if not (cosine_h2 > 0.0 and cosine2 > 0.0 and dot(back, plain2) > 0.0):
        return total, none
    r2, _ = fresnel.dielectric(cosine_h2, 1.0 / ior)
    reflected = sub(scale(h2, 2.0 * cosine_h2), back)
    away = negate(reflected)
    third = gamma - 2.0 * (_on_ellipse(phi, b) - _on_ellipse(_about_of(away), b)) + math.pi
    k, plain3 = _normal(-tilt, third, b), _normal(0.0, third, b)
    cosine3, left2 = dot(away, k), dot(n, reflected)
    if not cosine3 > 0.0:
        return total, none
    again = _kept(
        sigma,
        _chord(third, second, b) / max(math.sqrt(reflected[0] * reflected[0] + reflected[2] * reflected[2]), 1e-6),
    )
    t *= r2 * _gain(block, cosine2, alpha, 1.0 / ior) * _shadowed(alpha2, cosine2, left2)
    h4 = _facet(away, k, alpha, w[0], w[1])
    cosine_h4 = dot(away, h4)
    r3, _ = fresnel.dielectric(cosine_h4, 1.0 / ior)
    stays = (
        t
        * r3
        * _gain(block, cosine3, alpha, 1.0 / ior)
        * _shadowed(alpha2, cosine3, dot(k, sub(scale(h4, 2.0 * cosine_h4), away)))
    )
    out = max(1.0 - 0.5 * (r2 + r3), 1e-5)
    beyond = (
        stays * _more(out, kept[0], again[0]),
        stays * _more(out, kept[1], again[1]),
        stays * _more(out, kept[2], again[2]),
    )
    if dot(reflected, wi) < 1.0 / ior - _TOTAL or not (_seen(reflected, n, h2) and dot(reflected, plain2) > 0.0):
        return total, beyond
    h3 = normalize(madd(away, 1.0 / ior, wi))
    front = negate(wi)
    if dot(k, h3) < 0.0 or not (
        _seen(away, k, h3) and _seen(front, k, h3) and dot(away, plain3) > 0.0 and dot(front, plain3) > 0.0
    ):
        return total, beyond
    amount = (
        closure.f0[2]
        * t
        * _left_by(block, closure, away, k, wi)
        * cosine
        * cosine2
        / (entered * left2)
        * _arc(b, third)
    )
    return (
        total[0] + amount * kept[0] * again[0],
        total[1] + amount * kept[1] * again[1],
        total[2] + amount * kept[2] * again[2],
    ), beyond


@kernel
def _value(block, closure, wo, wi):
    """f · |cos|, RGB."""
    tilt, b = closure.c, closure.a
    cosine_o, cosine_i = math.sqrt(wo[0] * wo[0] + wo[2] * wo[2]), math.sqrt(wi[0] * wi[0] + wi[2] * wi[2])
    slope = math.tan(tilt)
    total = (0.0, 0.0, 0.0)
    if cosine_o < 1e-6 or cosine_i < 1e-6 or slope * wi[1] / cosine_i < -1.0:
        return total
    limit = max(-slope * wo[1] / cosine_o, 0.0)
    if limit > 1.0:
        return total
    half = math.acos(limit)
    last = math.atan2(math.sin(half), b * math.cos(half))
    steps = min(max(int(math.ceil(2.0 * last / (_STEP * closure.alpha))), 1), _MOST_STEPS)
    size = 2.0 * last / steps
    state = hashing.seeded(0.5 + 0.499 * wi[0], 0.5 + 0.499 * wi[1], 0.5 + 0.499 * wi[2])
    f, _ = fresnel.dielectric(dot(wo, normalize(add(wo, wi))), closure.ior)
    mirror, crossed, more = 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(steps):
        u = hashing.uniform_point(state)
        state = hashing.following(state)
        v = hashing.uniform_point(state)
        state = hashing.following(state)
        w = hashing.uniform_point(state)
        state = hashing.following(state)
        gamma = (i + u[2]) * size - last
        if closure.f0[0] > 0.0:
            mirror += _reflected_by(block, closure, wo, wi, gamma)
        if closure.f0[1] > 0.0 or closure.f0[2] > 0.0:
            through, beyond = _crossed(block, closure, wo, wi, gamma, u, v, w)
            if through[0] + through[1] + through[2] < math.inf:  # NaN fails this test too
                crossed = add(crossed, through)
            if beyond[0] + beyond[1] + beyond[2] < math.inf:
                more = madd(more, math.cos(gamma), beyond)
    inverse = 1.0 / closure.ior
    r = 0.25 * closure.f0[0] * f * mirror
    total = scale(madd((r, r, r), inverse * inverse, crossed), size / (2.0 * cosine_o))
    # Orders beyond TRT are spread as in Chiang et al. 2016.
    return madd(total, 0.5 * size * longitudinal(wo[1], cosine_o, wi[1], cosine_i, 4.0 * closure.alpha) / TWO_PI, more)


# -- directions --------------------------------------------------------------------------------------------------------


@kernel
def _lobe_probabilities(closure, wo):
    """Probabilities of the lobes for sampling a direction, and the sine of the inclination of wo."""
    r, tt, trt, sine = _attenuations(closure, wo)
    a, b, c = luminance(r), luminance(tt), luminance(trt)
    total = a + b + c
    if total <= 0.0:
        return 0.0, 0.0, 0.0, sine
    part = (1.0 - _ANYWHERE) / total
    return part * a, part * b, part * c, sine


@kernel
def _variance(alpha, deviation):
    return deviation * deviation * alpha * alpha


@kernel
def _density(closure, wo, sine_i, phi):
    """Density of directions with this inclination and angle around the fiber."""
    first, second, third, sine_o = _lobe_probabilities(closure, wo)
    cosine_o, cosine_i, tilt, alpha = cosine_of(sine_o), cosine_of(sine_i), closure.c, closure.alpha
    around = max(math.cos(0.5 * phi), 0.0) * 0.25
    total = (1.0 - first - second - third) / (4.0 * math.pi)
    sine, cosine = tilted(sine_o, cosine_o, 2.0 * tilt)
    total += first * around * longitudinal(sine_i, cosine_i, sine, cosine, _variance(alpha, _R_ALONG))
    sine, cosine = tilted(sine_o, cosine_o, -tilt)
    total += (
        second
        * azimuthal(phi - math.pi, _TT_ABOUT)
        * longitudinal(sine_i, cosine_i, sine, cosine, _variance(alpha, _TT_ALONG))
    )
    sine, cosine = tilted(sine_o, cosine_o, -4.0 * tilt)
    total += (
        third
        * 0.5
        * (around + azimuthal(phi, _TRT_ABOUT))
        * longitudinal(sine_i, cosine_i, sine, cosine, _variance(alpha, _TRT_ALONG))
    )
    return total


@kernel
def _evaluated(block, closure, wo, wi):
    """f · |cos| (RGB) and pdf; directions are in world space."""
    y = vec(closure.tangent)
    x, _ = across(y, wo)
    z = cross(x, y)
    local_o, local_i = (0.0, dot(y, wo), dot(z, wo)), (dot(x, wi), dot(y, wi), dot(z, wi))
    value = _value(block, closure, local_o, local_i)
    return value, _density(closure, wo, min(max(local_i[1], -1.0), 1.0), _about_of(local_i))


@kernel
def _about_fiber(closure, x, wi):
    return math.atan2(dot(x, wi), dot(cross(x, vec(closure.tangent)), wi))


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure, surface = closure_table(workspace)[int(index)], surface_table(workspace)[0]
    wo, wi = vec(surface.wo), (x, y, z)
    n, _ = across(vec(closure.tangent), wo)
    if cut(surface, closure, n, wi):
        return (
            0.0,
            0.0,
            0.0,
            _density(closure, wo, min(max(dot(vec(closure.tangent), wi), -1.0), 1.0), _about_fiber(closure, n, wi)),
        )
    value, pdf = _evaluated(block, closure, wo, wi)
    return value[0], value[1], value[2], pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure, surface = closure_table(workspace)[int(index)], surface_table(workspace)[0]
    wo = vec(surface.wo)
    first, second, third, sine_o = _lobe_probabilities(closure, wo)
    tilt, deviation, phi, u = 0.0, 0.0, TWO_PI * u1, u3
    around = 2.0 * math.asin(min(max(2.0 * u1 - 1.0, -1.0), 1.0))
    if u < first:
        tilt, deviation, phi, u = 2.0 * closure.c, _R_ALONG, around, u / first
    elif u < first + second:
        tilt, deviation, phi, u = -closure.c, _TT_ALONG, math.pi + sample_azimuthal(_TT_ABOUT, u1), (u - first) / second
    elif u < first + second + third:
        tilt, deviation, phi, u = -4.0 * closure.c, _TRT_ALONG, around, 2.0 * (u - first - second) / third
        if u >= 1.0:
            phi, u = sample_azimuthal(_TRT_ABOUT, u1), u - 1.0
    sine_i = 2.0 * u2 - 1.0
    if deviation > 0.0:
        sine, cosine = tilted(sine_o, cosine_of(sine_o), tilt)
        sine_i = sample_longitudinal(sine, cosine, _variance(closure.alpha, deviation), min(u, 1.0), u2)
    cosine_i = cosine_of(sine_i)
    y = vec(closure.tangent)
    x, _ = across(y, wo)
    wi = add(scale(y, sine_i), add(scale(x, cosine_i * math.sin(phi)), scale(cross(x, y), cosine_i * math.cos(phi))))
    value, pdf = _evaluated(block, closure, wo, wi)
    if not pdf > 0.0:
        return _NO_DIRECTION
    # Cycles counts all scattering of curves as reflection.
    kind = TRANSMISSION if surface.strand == 0 and dot(vec(surface.ng), wi) < 0.0 else GLOSSY
    if surface.closure_count == 1 and cut(surface, closure, x, wi):
        # Light rays find nothing here. As in Cycles, which does not know the density, sampled directions get most of
        # the weight.
        more = max(_CERTAIN / pdf, 1.0)
        value, pdf = scale(value, more), pdf * more
    return wi[0], wi[1], wi[2], value[0], value[1], value[2], pdf, kind


LOBES = {lobe_kind("huang"): (add_lobe, (HUANG,))}
CLOSURES = (HUANG,)
