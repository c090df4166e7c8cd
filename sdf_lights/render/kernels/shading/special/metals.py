# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Metallic BSDF: conductors with F82 tint, and physical conductors."""

import math

from .....jit import kernel
from .....vec import dot, mul, put, scale, vec
from .. import energy, fresnel
from ..closures import (
    NO_FILM,
    begin_metal,
    begin_microfacet,
    finish,
    finish_metal,
    lobe_table,
    positive,
    saturate,
    saturated,
    specular_normal,
)
from ..material_records import MULTISCATTER
from ..operands import normal, number, vector
from ..records import BECKMANN, FACETS, FRESNEL_CONDUCTOR, FRESNEL_F82, GGX, THINNEST_FILM, closure_table, surface_table
from ..special_lobes import LOBE_CONDUCTOR, LOBE_METALLIC, WITH_BECKMANN
from .facets import aspect, begin_facets, cover, smooth_albedo, stretch, tangent_of


@kernel
def _shape_metal(block, workspace, lobe, index, given):
    """Make closure ``index`` of Metallic as its lobe says, from the input normal ``given`` on. Returns the roughness
    for the look-up of its albedo, and its reflectance where it is smooth; negative if that is not needed."""
    args, closure = lobe.args, closure_table(workspace)[index]
    roughness = math.sqrt(closure.alpha)
    anisotropy = saturate(number(block, workspace, args[4]))
    thickness = number(block, workspace, args[7])
    plain = closure.fresnel == FRESNEL_F82 and not thickness > THINNEST_FILM
    if plain and anisotropy <= 0.0 and not lobe.features & WITH_BECKMANN:
        return roughness, NO_FILM
    begin_facets(closure, BECKMANN if lobe.features & WITH_BECKMANN else GGX)
    if anisotropy > 0.0:
        ratio = aspect(anisotropy)
        tangent = tangent_of(block, workspace, args[6], given, number(block, workspace, args[5]))
        roughness = stretch(closure, closure.alpha / ratio, closure.alpha * ratio, tangent)
    cover(closure, thickness, number(block, workspace, args[8]))
    if plain:
        return roughness, NO_FILM
    return roughness, smooth_albedo(block, closure, dot(vec(closure.normal), vec(surface_table(workspace)[0].wo)))


@kernel
def _normal_and_roughness(block, workspace, lobe):
    """The input normal of Metallic, the normal for its closure, and its roughness."""
    given = normal(block, workspace, lobe.args[3])
    roughness = saturate(number(block, workspace, lobe.args[2]))
    return given, specular_normal(surface_table(workspace)[0], given), roughness


@kernel
def add_metallic(block, workspace, lobe, weight):
    """Metallic BSDF by its colours."""
    lobe = lobe_table(block)[int(lobe)]
    args = lobe.args
    given, shading, roughness = _normal_and_roughness(block, workspace, lobe)
    index = begin_metal(
        workspace,
        (weight, weight, weight),
        shading,
        roughness,
        saturated(vector(block, workspace, args[0])),
        saturated(vector(block, workspace, args[1])),
    )
    if index >= 0:
        roughness, smooth = _shape_metal(block, workspace, lobe, index, given)
        finish_metal(block, workspace, lobe.features & MULTISCATTER != 0, index, roughness, smooth)
    return 0.0


@kernel
def _mean_of_conductor(n, k):
    """Approximate ∫ 2 μ F(μ) dμ: that of F82 with the same reflectance at normal incidence and at 82°."""
    f0 = fresnel.conductor(1.0, n, k)
    edge = fresnel.f82_edge_through(f0, fresnel.conductor(1.0 / 7.0, n, k))
    return saturate(fresnel.f82_average(f0, edge))


@kernel
def add_conductor(block, workspace, lobe, weight):
    """Metallic BSDF by its indices."""
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    given, shading, roughness = _normal_and_roughness(block, workspace, lobe)
    index = begin_microfacet(workspace, (weight, weight, weight), shading, roughness, 1.0)
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    closure.fresnel = FRESNEL_CONDUCTOR
    n, k = positive(vector(block, workspace, args[0])), positive(vector(block, workspace, args[1]))
    put(closure.f0, n)
    put(closure.edge, k)
    roughness, smooth = _shape_metal(block, workspace, lobe, index, given)
    e = energy.reflection_albedo(block, dot(vec(closure.normal), vec(surface.wo)), roughness)
    if lobe.features & MULTISCATTER:
        energy.compensate_reflection(
            block,
            closure,
            e,
            roughness,
            (_mean_of_conductor(n[0], k[0]), _mean_of_conductor(n[1], k[1]), _mean_of_conductor(n[2], k[2])),
        )
    finish(workspace, index, scale(mul(vec(closure.weight), smooth), e))
    return 0.0


LOBES = {
    LOBE_METALLIC: (add_metallic, (FACETS,)),
    LOBE_CONDUCTOR: (add_conductor, (FACETS,)),
}
