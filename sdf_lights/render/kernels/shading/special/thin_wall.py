# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A pane of glass too thin to bend light, like thin walls of OpenPBR 1.1: reflected and transmitted light have bounced
any number of times between its sides. Transmitted light leaves as if mirrored at the surface, and spread.

Fields of the closure: those of ``microfacet``. Its normal is on the far side.
"""

import math

from .....jit import kernel
from .....vec import dot, mul, negate, put, scale, sub, vec
from ....scene import Ray
from .. import energy, fresnel, microfacet
from ..closures import (
    add_transparency,
    begin_microfacet,
    finish,
    lobe_table,
    positive,
    saturate,
    saturated,
    specular_normal,
)
from ..material_records import BASE_COLOR, IOR, NORMAL, ROUGHNESS, SPECULAR_TINT, THIN_FILM_IOR, THIN_FILM_THICKNESS
from ..microfacet import is_singular
from ..operands import normal, number, vector
from ..records import FRESNEL_DIELECTRIC, GGX, SINGULAR, THIN_GLASS, TRANSMISSION, closure_table, surface_table
from .facets import begin_facets, cover, reflectance

_CAMERA = int(Ray.CAMERA)
_WHITE = (1.0, 1.0, 1.0)


@kernel
def _pane(front, back, passed_front, passed_back, kept):
    """Reflection and transmission of a pane in one channel. ``front``, ``back``: reflectances of its sides from outside
    and inside; ``passed_…``: their transmittances; ``kept``: the fraction that a crossing keeps."""
    inside = back * kept
    transmitted = kept * passed_front * passed_back / max(1.0 - inside * inside, 1e-9)
    return front + transmitted * inside, transmitted


@kernel
def _fresnel(block, closure, cosine, color):
    """Reflection and transmission of a pane (RGB); ``closure`` describes its side."""
    r, t, cosine_t = reflectance(block, closure, cosine)
    if cosine_t == 0.0:
        return r, (0.0, 0.0, 0.0)
    back, out = r, t
    if closure.b > 0.0:
        ior = closure.ior
        closure.ior, closure.c = 1.0 / ior, closure.c / ior
        back, out, _ = reflectance(block, closure, cosine_t)
    length = 1.0 / cosine_t
    r0, t0 = _pane(r[0], back[0], t[0], out[0], color[0] ** length)
    r1, t1 = _pane(r[1], back[1], t[1], out[1], color[1] ** length)
    r2, t2 = _pane(r[2], back[2], t[2], out[2], color[2] ** length)
    return (r0, r1, r2), (t0, t1, t2)


@kernel
def _spread(alpha, ior):
    """Roughness after crossing two rough sides: Kulla and Conty 2017, "Revisiting physically based shading at
    Imageworks"."""
    return saturate(alpha * math.sqrt(max(3.4 * (ior - 1.0) * (ior - 0.5) * (ior - 0.5) / (ior * ior * ior), 0.0)))


@kernel
def _add_transmission(block, workspace, weight, n, alpha):
    surface = surface_table(workspace)[0]
    if is_singular(alpha) and surface.ray_kind != _CAMERA:
        add_transparency(workspace, weight)
        return
    roughness = math.sqrt(alpha)
    index = begin_microfacet(workspace, weight, negate(n), roughness, 1.0)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.kind = THIN_GLASS
        closure.transmits = 1
        e = energy.reflection_albedo(block, dot(n, vec(surface.wo)), roughness)
        energy.compensate_reflection(block, closure, e, roughness, _WHITE)
        finish(workspace, index, weight)


@kernel
def add_lobe(block, workspace, lobe, r, g, b):
    """Transmission of Principled as a thin wall, with this weight."""
    args = lobe_table(block)[int(lobe)].args
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    if surface.closure_count == len(closures):
        return 0.0
    n = specular_normal(surface, normal(block, workspace, args[NORMAL]))
    roughness = saturate(number(block, workspace, args[ROUGHNESS]))
    ior = max(number(block, workspace, args[IOR]), 1e-5)
    tint = positive(vector(block, workspace, args[SPECULAR_TINT]))
    # The next closure temporarily describes its side.
    side = closures[surface.closure_count]
    side.fresnel, side.transmits, side.ior = FRESNEL_DIELECTRIC, 1, ior
    begin_facets(side, GGX)
    cover(side, number(block, workspace, args[THIN_FILM_THICKNESS]), number(block, workspace, args[THIN_FILM_IOR]))
    put(side.f0, saturated(scale(tint, fresnel.f0_of_ior(ior))))
    put(side.reflection_tint, _WHITE)
    put(side.transmission_tint, _WHITE)
    cosine = dot(n, vec(surface.wo))
    reflected, transmitted = _fresnel(block, side, cosine, saturated(vector(block, workspace, args[BASE_COLOR])))
    index = begin_microfacet(workspace, mul((r, g, b), reflected), n, roughness, 1.0)
    if index >= 0:
        closure = closures[index]
        e = energy.reflection_albedo(block, cosine, roughness)
        energy.compensate_reflection(block, closure, e, roughness, tint)
        finish(workspace, index, scale(vec(closure.weight), e))
    _add_transmission(block, workspace, mul((r, g, b), transmitted), n, _spread(roughness * roughness, ior))
    return 0.0


@kernel
def _mirrored(closure, wo):
    """wo on the far side of the surface."""
    n = vec(closure.normal)
    return sub(wo, scale(n, 2.0 * dot(n, wo)))


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    value, pdf = microfacet.evaluate(closure, _mirrored(closure, vec(surface_table(workspace)[0].wo)), (x, y, z))
    return value[0], value[1], value[2], pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure = closure_table(workspace)[int(index)]
    wo = _mirrored(closure, vec(surface_table(workspace)[0].wo))
    wi, value, pdf, _, singular = microfacet.sample(closure, wo, u1, u2, u3)
    kind = TRANSMISSION | SINGULAR if singular else TRANSMISSION
    return wi[0], wi[1], wi[2], value[0], value[1], value[2], pdf, kind


CLOSURES = (THIN_GLASS,)
