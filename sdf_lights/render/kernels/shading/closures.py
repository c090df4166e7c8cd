# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds closures to a surface: weights, albedos and normals of diffuse, microfacet, transparent and sheen closures.

A closure is added in two steps: ``begin`` finds a free one, the caller fills it, and ``finish`` counts it.
"""

import math

from ....jit import kernel, table
from ....vec import ZERO, add, average, dot, madd, mul, normalize, put, put_sum, scale, vec
from . import diffuse, dispatch, energy, fresnel, microfacet
from .material_records import LOBE, MULTISCATTER
from .operands import normal, number
from .records import (
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    FRESNEL_NONE,
    LAMBERT,
    MICROFACET,
    NEGLIGIBLE,
    OREN_NAYAR,
    SHEEN,
    STRAIGHT,
    TRANSLUCENT,
    VELVET,
    closure_table,
    surface_table,
)

lobe_table = table("lobes", LOBE)

WHITE = (1.0, 1.0, 1.0)
NO_FILM = (-1.0, -1.0, -1.0)
_SMOOTH_DIFFUSE = 1e-5  # below this roughness, Oren–Nayar is Lambert's


@kernel
def saturate(x):
    """x limited to [0, 1]."""
    return min(max(x, 0.0), 1.0)


@kernel
def positive(v):
    """Components below 0 become 0."""
    return (max(v[0], 0.0), max(v[1], 0.0), max(v[2], 0.0))


@kernel
def saturated(v):
    """Components limited to [0, 1]."""
    return (saturate(v[0]), saturate(v[1]), saturate(v[2]))


@kernel
def begin(workspace, weight, n):
    """Index of the next free closure; the caller must set its kind. −1 if the weight is negligible or no closure is
    free. It counts only after ``finish``."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    index = surface.closure_count
    # Written so that a NaN weight is left out too.
    if not (average(weight) >= NEGLIGIBLE) or index == len(closures):
        return -1
    closure = closures[index]
    closure.singular = 0
    put(closure.weight, weight)
    put(closure.normal, n)
    smooth = surface.n
    # As in Cycles, bumps hide nothing of a curve.
    closure.bumped = int(surface.strand == 0 and (n[0] != smooth[0] or n[1] != smooth[1] or n[2] != smooth[2]))
    return index


@kernel
def finish(workspace, index, albedo):
    """Count closure ``index``, whose directional albedo with its weight is about ``albedo`` (RGB)."""
    surface, closure = surface_table(workspace)[0], closure_table(workspace)[index]
    closure.pick = max(average(albedo), NEGLIGIBLE)  # never 0, for their sum divides them
    surface.pick_total += closure.pick
    surface.closure_count += 1
    if closure.singular == 0:
        surface.evaluable += 1
    if closure.kind != STRAIGHT:
        put_sum(surface.albedo, albedo)
        if closure.kind < MICROFACET and closure.kind != VELVET:  # as in Cycles
            put_sum(surface.diffuse_albedo, albedo)


@kernel
def add_lambert(workspace, weight, n, through):
    """Add a Lambert closure of this RGB weight about a unit normal."""
    index = begin(workspace, weight, n)
    if index >= 0:
        closure_table(workspace)[index].kind = TRANSLUCENT if through else LAMBERT
        finish(workspace, index, weight)


@kernel
def add_diffuse(workspace, weight, color, roughness, n):
    """Add a diffuse closure: Lambert, or Oren–Nayar if it has a roughness."""
    if roughness < _SMOOTH_DIFFUSE:
        add_lambert(workspace, weight, n, False)
        return
    index = begin(workspace, weight, n)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.kind = OREN_NAYAR
        diffuse.oren_nayar_setup(closure, dot(n, vec(surface_table(workspace)[0].wo)), roughness, color)
        finish(workspace, index, weight)


@kernel
def add_transparency(workspace, weight):
    """Add a closure that lets light straight through, with this weight (RGB)."""
    surface = surface_table(workspace)[0]
    index = begin(workspace, weight, vec(surface.n))
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.kind = STRAIGHT
        closure.singular = 1
        put_sum(surface.transparency, weight)
        finish(workspace, index, weight)


@kernel
def begin_microfacet(workspace, weight, n, roughness, ior):
    """``begin`` for a reflecting GGX closure without Fresnel term."""
    index = begin(workspace, weight, n)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.alpha = roughness * roughness
        closure.ior = ior
        closure.kind = MICROFACET
        closure.fresnel = FRESNEL_NONE
        closure.reflects = 1
        closure.transmits = 0
        closure.singular = int(microfacet.is_singular(closure.alpha))
        closure.multiscatter[0] = 1.0
    return index


@kernel
def specular_normal(surface, n):
    """The normal raised towards the geometric one until the mirror direction of wo leaves the surface.

    With g = ng, o = wo and t the least cosine of the mirror direction r = 2 (n'·o) n' − o, the wanted normal lies in
    the plane of n and g: n' = sin a · x + cos a · g. Then r·g = t is cos 2a (o·g) + sin 2a (o·x) = t, solved for the
    angle nearest to g.
    """
    if surface.strand or surface.uncorrected:  # as in Cycles
        return n
    g, o = vec(surface.ng), vec(surface.wo)
    height = dot(g, o)
    least = min(0.9 * height, 0.01)  # a grazing view may be mirrored as flat as it arrived
    if 2.0 * dot(n, o) * dot(n, g) - height >= least:
        return n
    x = normalize(madd(n, -dot(n, g), g))
    if dot(x, x) < 0.5:
        return n
    side = dot(o, x)
    # cos(2a − phase) = t / amplitude; tilting away from o (side < 0) lowers r from the start, towards it later.
    amplitude, phase = math.hypot(height, side), math.atan2(side, height)
    angle = 0.5 * (phase + math.acos(min(max(least / amplitude, -1.0), 1.0)))
    return madd(scale(x, math.sin(angle)), math.cos(angle), g)


@kernel
def refined_albedo(block, workspace, refined, index, roughness, albedo):
    """The roughness for the look-up of the microfacets' albedo, and their albedo after lobe number ``refined`` has made
    closure ``index`` anisotropic and covered it with a film; −1: no such lobe."""
    if refined >= 0:
        roughness, r, g, b = dispatch.refine(block, workspace, refined, index, roughness)
        if r >= 0.0:
            albedo = (r, g, b)
    return roughness, albedo


@kernel
def begin_glass(workspace, weight, n, roughness, ior, f0, reflection, transmission):
    """``begin_microfacet`` for a closure that reflects and refracts, tinted ``reflection`` and ``transmission``; ``f0``
    is that from outside."""
    surface = surface_table(workspace)[0]
    relative = 1.0 / ior if surface.backfacing else ior
    index = begin_microfacet(workspace, weight, n, roughness, relative)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.fresnel = FRESNEL_DIELECTRIC
        closure.transmits = 1
        put(closure.f0, saturated(f0))
        put(closure.reflection_tint, reflection)
        put(closure.transmission_tint, transmission)
    return index


@kernel
def add_glass(block, workspace, features, refined, weight, n, roughness, ior, f0, reflection, transmission):
    """Reflection and refraction, as in ``begin_glass``."""
    index = begin_glass(workspace, weight, n, roughness, ior, f0, reflection, transmission)
    if index < 0:
        return
    closure = closure_table(workspace)[index]
    cosine = dot(n, vec(surface_table(workspace)[0].wo))
    if features & MULTISCATTER:
        energy.compensate_glass(block, closure, cosine, roughness, transmission)
    r, t, _ = microfacet.reflectance(closure, cosine)
    _, albedo = refined_albedo(block, workspace, refined, index, roughness, add(r, t))
    finish(workspace, index, mul(vec(closure.weight), albedo))


@kernel
def begin_refraction(block, workspace, lobe, weight):
    """``begin_microfacet`` for the Refraction BSDF."""
    surface, args = surface_table(workspace)[0], lobe.args
    ior = max(number(block, workspace, args[2]), 1e-5)
    n = specular_normal(surface, normal(block, workspace, args[3]))
    index = begin_microfacet(
        workspace, weight, n, saturate(number(block, workspace, args[1])), 1.0 / ior if surface.backfacing else ior
    )
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.reflects = 0
        closure.transmits = 1
    return index


@kernel
def finish_metal(block, workspace, compensated, index, roughness, film):
    """Finish closure ``index`` of a metal, from its ``f0`` and ``edge``; ``film``: its reflectance (RGB) if it has a
    film."""
    closure = closure_table(workspace)[index]
    color, edge = vec(closure.f0), vec(closure.edge)
    cosine = dot(vec(closure.normal), vec(surface_table(workspace)[0].wo))
    e = energy.reflection_albedo(block, cosine, roughness)
    if compensated:
        energy.compensate_reflection(
            block,
            closure,
            e,
            roughness,
            (
                fresnel.f82_average(color[0], edge[0]),
                fresnel.f82_average(color[1], edge[1]),
                fresnel.f82_average(color[2], edge[2]),
            ),
        )
    albedo = film
    if film[0] < 0.0:
        albedo = energy.mixed(color, e, energy.schlick_albedo(block, cosine, roughness))
    finish(workspace, index, mul(vec(closure.weight), albedo))


@kernel
def begin_metal(workspace, weight, n, roughness, color, tint):
    """``begin_microfacet`` for a metal of reflectance ``color`` at normal incidence, and that times ``tint`` at 82°."""
    index = begin_microfacet(workspace, weight, n, roughness, 1.0)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.fresnel = FRESNEL_F82
        put(closure.f0, color)
        put(
            closure.edge,
            (
                fresnel.f82_edge(color[0], tint[0]),
                fresnel.f82_edge(color[1], tint[1]),
                fresnel.f82_edge(color[2], tint[2]),
            ),
        )
    return index


@kernel
def add_fibers(block, workspace, weight, n, roughness):
    """Sheen of fibers. Returns what it reflects of ``weight``."""
    albedo, a, b = energy.sheen(block, dot(n, vec(surface_table(workspace)[0].wo)), roughness)
    if not (albedo > NEGLIGIBLE) or abs(a) < NEGLIGIBLE:
        return ZERO
    own = scale(weight, albedo)
    index = begin(workspace, own, n)
    if index < 0:
        return ZERO
    closure = closure_table(workspace)[index]
    closure.kind = SHEEN
    closure.a = a
    closure.b = b
    finish(workspace, index, own)
    return own
