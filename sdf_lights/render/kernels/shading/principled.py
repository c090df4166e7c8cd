# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the Principled BSDF.

They are stacked from the top, as in Cycles: each gets the light that the albedo of the layer above leaves.
"""

import math

from ....jit import kernel
from ....vec import dot, madd, mul, normalize, put, put_sum, scale, vec
from . import dispatch, energy, fresnel
from .closures import (
    NO_FILM,
    WHITE,
    add_diffuse,
    add_fibers,
    add_glass,
    add_transparency,
    begin_metal,
    begin_microfacet,
    finish,
    finish_metal,
    positive,
    refined_albedo,
    saturate,
    saturated,
    specular_normal,
)
from .material_records import (
    ALPHA,
    BASE_COLOR,
    COAT_IOR,
    COAT_NORMAL,
    COAT_ROUGHNESS,
    COAT_TINT,
    COAT_WEIGHT,
    DIFFUSE_ROUGHNESS,
    EMISSION_COLOR,
    EMISSION_STRENGTH,
    IOR,
    METALLIC,
    MULTISCATTER,
    NORMAL,
    ROUGHNESS,
    SHEEN_ROUGHNESS,
    SHEEN_TINT,
    SHEEN_WEIGHT,
    SPECULAR_IOR_LEVEL,
    SPECULAR_TINT,
    SUBSURFACE_WEIGHT,
    THIN_FILM_THICKNESS,
    THIN_WALL,
    TRANSMISSION_WEIGHT,
    WITH_ALPHA,
    WITH_BASE,
    WITH_COAT,
    WITH_EMISSION,
    WITH_METAL,
    WITH_SHEEN,
    WITH_TRANSMISSION,
)
from .operands import normal, number, vector
from .records import (
    DIFFUSE,
    FRESNEL_DIELECTRIC,
    GLOSSY,
    NEGLIGIBLE,
    THINNEST_FILM,
    closure_table,
    surface_table,
)
from .special_lobes import WITH_FACETS, WITH_SUBSURFACE, WITH_THIN_SCATTERING, WITH_THIN_WALL


@kernel
def _below(weight, albedo):
    """The rest of ``weight`` below a layer that reflects ``albedo`` (with its weight): the same for all colours, so a
    white base looks white."""
    worst = 0.0
    for i in range(3):
        if weight[i] > 0.0:
            worst = max(worst, albedo[i] / weight[i])
    return scale(weight, saturate(1.0 - worst))


@kernel
def _add_dielectric_layer(block, workspace, compensated, refined, weight, n, roughness, ior, f0):
    """A clear reflecting layer. Returns the weight of the layers below it."""
    if surface_table(workspace)[0].ray_kind == DIFFUSE and block.caustics & GLOSSY == 0:
        return weight  # as in Cycles, layers that reflect no caustics take nothing from those below
    index = begin_microfacet(workspace, weight, n, roughness, ior)
    if index < 0:
        return weight
    closure = closure_table(workspace)[index]
    closure.fresnel = FRESNEL_DIELECTRIC
    f0 = saturated(f0)
    put(closure.f0, f0)
    put(closure.reflection_tint, WHITE)
    cosine = dot(n, vec(surface_table(workspace)[0].wo))
    roughness, film = refined_albedo(block, workspace, refined, index, roughness, NO_FILM)
    e = energy.reflection_albedo(block, cosine, roughness)
    albedo, taken = scale(film, e), film
    if film[0] < 0.0:
        albedo = energy.mixed(f0, e, energy.dielectric_albedo(block, ior, cosine, roughness))
        taken = energy.mixed(f0, 1.0, energy.cycles_dielectric(block, ior, cosine, roughness))
    if compensated:
        s = fresnel.remapped(fresnel.dielectric_average(ior), ior)
        energy.compensate_reflection(block, closure, e, roughness, energy.mixed(f0, 1.0, s))
        taken = scale(taken, e)
    finish(workspace, index, mul(vec(closure.weight), albedo))
    # The layers below lose what Cycles' coarse table says, and a layer that loses energy takes as much from them as one
    # that does not.
    return _below(weight, mul(vec(closure.weight), taken))


@kernel
def _add_metal(block, workspace, features, refined, weight, n, roughness, color, tint):
    index = begin_metal(workspace, weight, n, roughness, color, tint)
    if index >= 0:
        roughness, film = refined_albedo(block, workspace, refined, index, roughness, NO_FILM)
        finish_metal(block, workspace, features & MULTISCATTER != 0, index, roughness, film)


@kernel
def _add_sheen(block, workspace, lobe, weight, n, coat_weight):
    """Sheen on top of everything. Returns the weight of the layers below it."""
    args = lobe.args
    amount = max(number(block, workspace, args[SHEEN_WEIGHT]), 0.0)
    tint = positive(vector(block, workspace, args[SHEEN_TINT]))
    blend = saturate(coat_weight)
    if args[COAT_NORMAL] != args[NORMAL] and blend > 0.0:
        above = normal(block, workspace, args[COAT_NORMAL])
        n = normalize(madd(scale(n, 1.0 - blend), blend, above))
    roughness = number(block, workspace, args[SHEEN_ROUGHNESS])
    return _below(weight, add_fibers(block, workspace, scale(mul(weight, tint), amount), n, roughness))


@kernel
def _add_coat(block, workspace, lobe, weight):
    args = lobe.args
    surface = surface_table(workspace)[0]
    amount = saturate(number(block, workspace, args[COAT_WEIGHT]))
    if amount <= NEGLIGIBLE:
        return weight
    ior = max(number(block, workspace, args[COAT_IOR]), 1.0)
    n = specular_normal(surface, normal(block, workspace, args[COAT_NORMAL]))
    f0 = fresnel.f0_of_ior(ior)
    coat = scale(weight, amount)
    below = _add_dielectric_layer(
        block, workspace, True, -1, coat, n, saturate(number(block, workspace, args[COAT_ROUGHNESS])), ior, (f0, f0, f0)
    )
    # The coated part determines the loss of the whole.
    weight = madd(scale(weight, 1.0 - amount), 1.0, below)
    tint = positive(vector(block, workspace, args[COAT_TINT]))
    if tint != WHITE:
        # Beer's law along the refracted ray; the tint is that of perpendicular incidence.
        cosine = dot(n, vec(surface.wo))
        depth = 1.0 / math.sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior))
        weight = (
            weight[0] * (1.0 - amount + amount * tint[0] ** depth),
            weight[1] * (1.0 - amount + amount * tint[1] ** depth),
            weight[2] * (1.0 - amount + amount * tint[2] ** depth),
        )
    return weight


@kernel
def add_principled(block, workspace, lobe, index, share):
    """Add the closures of a Principled BSDF: lobe number ``index``, of weight ``share``."""
    surface = surface_table(workspace)[0]
    features, args = lobe.features, lobe.args
    refined = index if features & WITH_FACETS else -1
    weight = (share, share, share)
    if features & WITH_ALPHA:
        alpha = saturate(number(block, workspace, args[ALPHA]))
        if alpha < 1.0:
            add_transparency(workspace, scale(weight, 1.0 - alpha))
            weight = scale(weight, alpha)
    n = normal(block, workspace, args[NORMAL])
    if features & WITH_SHEEN:
        weight = _add_sheen(block, workspace, lobe, weight, n, number(block, workspace, args[COAT_WEIGHT]))
    if features & WITH_COAT:
        weight = _add_coat(block, workspace, lobe, weight)
    if features & WITH_EMISSION:
        radiance = scale(
            vector(block, workspace, args[EMISSION_COLOR]), number(block, workspace, args[EMISSION_STRENGTH])
        )
        put_sum(surface.emission, mul(weight, radiance))

    base = positive(vector(block, workspace, args[BASE_COLOR]))
    color = (min(base[0], 1.0), min(base[1], 1.0), min(base[2], 1.0))
    roughness = saturate(number(block, workspace, args[ROUGHNESS]))
    tint = positive(vector(block, workspace, args[SPECULAR_TINT]))
    mirror = specular_normal(surface, n)
    if features & WITH_METAL:
        metallic = saturate(number(block, workspace, args[METALLIC]))
        if metallic > NEGLIGIBLE:
            edge = (min(tint[0], 1.0), min(tint[1], 1.0), min(tint[2], 1.0))
            _add_metal(block, workspace, features, refined, scale(weight, metallic), mirror, roughness, color, edge)
            weight = scale(weight, 1.0 - metallic)
    if not features & (WITH_TRANSMISSION | WITH_BASE):
        return
    ior = max(number(block, workspace, args[IOR]), 1e-5)
    f0 = fresnel.f0_of_ior(ior)
    if features & WITH_TRANSMISSION:
        transmission = saturate(number(block, workspace, args[TRANSMISSION_WEIGHT]))
        if transmission > NEGLIGIBLE:
            below = scale(weight, transmission)
            if features & WITH_THIN_WALL and number(block, workspace, args[THIN_WALL]) > 0.0:
                dispatch.thin_wall(block, workspace, index, below[0], below[1], below[2])
            else:
                # A ray crosses the surface twice, so each crossing takes the square root of the colour.
                add_glass(
                    block,
                    workspace,
                    features,
                    refined,
                    below,
                    mirror,
                    roughness,
                    ior,
                    scale(tint, f0),
                    WHITE,
                    (math.sqrt(color[0]), math.sqrt(color[1]), math.sqrt(color[2])),
                )
            weight = scale(weight, 1.0 - transmission)
    if not features & WITH_BASE:
        return
    level = max(number(block, workspace, args[SPECULAR_IOR_LEVEL]), 0.0)
    if level != 0.5:
        f0 *= 2.0 * level
        adjusted = fresnel.ior_of_f0(f0)
        ior = 1.0 / adjusted if ior < 1.0 else adjusted
    if ior != 1.0 or features & WITH_FACETS and number(block, workspace, args[THIN_FILM_THICKNESS]) > THINNEST_FILM:
        compensated = features & MULTISCATTER != 0
        weight = _add_dielectric_layer(
            block, workspace, compensated, refined, weight, mirror, roughness, ior, scale(tint, f0)
        )
    if features & (WITH_SUBSURFACE | WITH_THIN_SCATTERING):
        amount = saturate(number(block, workspace, args[SUBSURFACE_WEIGHT]))
        if amount > NEGLIGIBLE:
            below = mul(scale(weight, amount), color)
            dispatch.subsurface(block, workspace, index, below[0], below[1], below[2], ior)
        weight = scale(weight, 1.0 - amount)
    add_diffuse(workspace, mul(weight, base), base, saturate(number(block, workspace, args[DIFFUSE_ROUGHNESS])), n)
