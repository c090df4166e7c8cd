# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a material's lobes to closures: ``shade``, and ``transparency`` for shadow rays."""

from ....jit import kernel, table
from ....vec import ZERO, dot, madd, put, put_sum, scale, vec
from . import dispatch, energy, fresnel
from .closures import (
    WHITE,
    add_diffuse,
    add_glass,
    add_lambert,
    add_transparency,
    begin_microfacet,
    begin_refraction,
    finish,
    lobe_table,
    positive,
    saturate,
    specular_normal,
)
from .material_records import (
    LOBE_ALPHA,
    LOBE_DIFFUSE,
    LOBE_EMISSION,
    LOBE_GLASS,
    LOBE_GLOSSY,
    LOBE_HOLDOUT,
    LOBE_PRINCIPLED,
    LOBE_REFRACTION,
    LOBE_TRANSLUCENT,
    LOBE_TRANSPARENT,
    MATERIAL,
    MULTISCATTER,
    NO_GRAPH,
    NONE,
)
from .operands import normal, number, run, vector
from .principled import add_principled
from .records import (
    HAS_TRANSPARENCY,
    SHADES_SHADOWS,
    UNCORRECTED,
    closure_table,
    surface_table,
)

_materials = table("materials", MATERIAL)


@kernel
def _glossy(block, workspace, lobe, weight, color):
    """Glossy BSDF: a metal of reflectance ``color`` at every angle."""
    surface = surface_table(workspace)[0]
    roughness = saturate(number(block, workspace, lobe.args[1]))
    n = specular_normal(surface, normal(block, workspace, lobe.args[2]))
    index = begin_microfacet(workspace, scale(color, weight), n, roughness, 1.0)
    if index >= 0:
        closure = closure_table(workspace)[index]
        e = energy.reflection_albedo(block, dot(n, vec(surface.wo)), roughness)
        if lobe.features & MULTISCATTER:
            energy.compensate_reflection(block, closure, e, roughness, color)
        finish(workspace, index, scale(vec(closure.weight), e))


@kernel
def _add_lobe(block, workspace, lobe, index, weight):
    surface = surface_table(workspace)[0]
    kind, args = lobe.kind, lobe.args
    if kind == LOBE_PRINCIPLED:
        add_principled(block, workspace, lobe, index, weight)
        return
    if kind > LOBE_ALPHA:
        dispatch.add(block, workspace, kind, index, weight)
        return
    if kind == LOBE_HOLDOUT:
        surface.holdout += weight
        return
    color = vector(block, workspace, args[0])
    if kind == LOBE_EMISSION:
        put_sum(surface.emission, scale(color, weight * number(block, workspace, args[1])))
        return
    color = positive(color)
    white = (weight, weight, weight)
    if kind == LOBE_DIFFUSE:
        roughness = number(block, workspace, args[1])
        add_diffuse(workspace, scale(color, weight), color, roughness, normal(block, workspace, args[2]))
    elif kind == LOBE_TRANSPARENT:
        add_transparency(workspace, scale(color, weight))
    elif kind == LOBE_TRANSLUCENT:
        # Nothing is mirrored here, but Cycles raises the normal all the same.
        n = specular_normal(surface, normal(block, workspace, args[1]))
        add_lambert(workspace, scale(color, weight), n, True)
    elif kind == LOBE_GLOSSY:
        _glossy(block, workspace, lobe, weight, color)
    elif kind == LOBE_REFRACTION:
        color = scale(color, weight)
        place = begin_refraction(block, workspace, lobe, color)
        if place >= 0:
            finish(workspace, place, color)
    elif kind == LOBE_GLASS:
        ior = max(number(block, workspace, args[2]), 1e-5)
        f0 = fresnel.f0_of_ior(ior)
        n = specular_normal(surface, normal(block, workspace, args[3]))
        roughness = saturate(number(block, workspace, args[1]))
        add_glass(block, workspace, lobe.features, -1, white, n, roughness, ior, (f0, f0, f0), color, color)


@kernel
def shade(block, workspace):
    """Run the material of ``workspace.surface``: fill its closures, emission, transparency, albedos and holdout."""
    surface = surface_table(workspace)[0]
    material = _materials(block)[surface.material]
    surface.uncorrected = material.flags & UNCORRECTED
    surface.closure_count = 0
    surface.evaluable = 0
    surface.portal = 0
    surface.subsurface = 0
    surface.pick_total = 0.0
    surface.holdout = 0.0
    put(surface.emission, ZERO)
    put(surface.transparency, ZERO)
    put(surface.albedo, ZERO)
    put(surface.diffuse_albedo, ZERO)
    if material.graph != NO_GRAPH:
        run(block, workspace, material.graph, material.slots)
    if material.normal != NONE:
        put(surface.n, normal(block, workspace, material.normal))
    lobes = lobe_table(block)
    for i in range(material.lobes[0], material.lobes[1]):
        lobe = lobes[i]
        _add_lobe(block, workspace, lobe, i, number(block, workspace, lobe.weight))
    if surface.closure_count > 0:
        closures = closure_table(workspace)
        inverse = 1.0 / surface.pick_total
        for i in range(surface.closure_count):
            closures[i].pick *= inverse


@kernel
def transparency(block, workspace):
    """RGB that passes straight through ``workspace.surface``. Unless the material has SHADES_SHADOWS, only the
    registers change."""
    surface = surface_table(workspace)[0]
    material = _materials(block)[surface.material]
    if not material.flags & HAS_TRANSPARENCY:
        return ZERO
    if material.flags & SHADES_SHADOWS:
        return dispatch.transparency(block, workspace)
    if material.shadow_graph != NO_GRAPH:
        run(block, workspace, material.shadow_graph, material.shadow_slots)
    lobes = lobe_table(block)
    total = ZERO
    for i in range(material.shadow_lobes[0], material.shadow_lobes[1]):
        lobe = lobes[i]
        weight = number(block, workspace, lobe.weight)
        if lobe.kind == LOBE_ALPHA:
            clear = weight * (1.0 - saturate(number(block, workspace, lobe.args[0])))
            total = madd(total, clear, WHITE)
        else:
            total = madd(total, weight, positive(vector(block, workspace, lobe.args[0])))
    return total
