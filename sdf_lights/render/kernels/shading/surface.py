# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a material's lobes to closures: ``shade``, and ``transparency`` for shadow rays.

Layers of Principled are stacked from the top, as in Cycles: each gets the light that the albedo of the layer above
leaves.
"""

import math

from ....jit import kernel, table
from ....vec import ZERO, add, average, dot, madd, mul, normalize, put, put_sum, scale, vec
from . import apart, diffuse, energy, fresnel, microfacet
from .material_compiler import (
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
    LOBE,
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
    METALLIC,
    MULTISCATTER,
    NO_GRAPH,
    NONE,
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
from .operands import normal, number, run, vector
from .records import (
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    FRESNEL_NONE,
    HAS_TRANSPARENCY,
    LAMBERT,
    MICROFACET,
    NEGLIGIBLE,
    OREN_NAYAR,
    SHADES_SHADOWS,
    SHEEN,
    STRAIGHT,
    THINNEST_FILM,
    TRANSLUCENT,
    VELVET,
    closure_table,
    surface_table,
)
from .special_lobes import WITH_FACETS, WITH_SUBSURFACE, WITH_THIN_SCATTERING, WITH_THIN_WALL

_materials = table("materials", MATERIAL)
lobe_table = table("lobes", LOBE)

_WHITE = (1.0, 1.0, 1.0)
NO_FILM = (-1.0, -1.0, -1.0)
_SMOOTH_DIFFUSE = 1e-5  # below this roughness, Oren–Nayar is Lambert's
_LOWEST_SHEEN = 1e-2  # roughness below which the fits of sheen do not hold


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
    closure.pick = max(average(albedo), 0.0)
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
    return index


@kernel
def specular_normal(surface, n):
    """The normal raised towards the geometric one until the mirror direction of wo leaves the surface.

    With g = ng, o = wo and t the least cosine of the mirror direction r = 2 (n'·o) n' − o, the wanted normal lies in
    the plane of n and g: n' = sin a · x + cos a · g. Then r·g = t is cos 2a (o·g) + sin 2a (o·x) = t, solved for the
    angle nearest to g.
    """
    if surface.strand:  # as in Cycles
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
def _below(weight, albedo):
    """The rest of ``weight`` below a layer that reflects ``albedo`` (with its weight): the same for all colours, so a
    white base looks white."""
    worst = 0.0
    for i in range(3):
        if weight[i] > 0.0:
            worst = max(worst, albedo[i] / weight[i])
    return scale(weight, saturate(1.0 - worst))


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
def _refined(block, workspace, refined, index, roughness, albedo):
    """The roughness for the look-up of the microfacets' albedo, and their albedo after lobe number ``refined`` has made
    closure ``index`` anisotropic and covered it with a film; −1: no such lobe."""
    if refined >= 0:
        roughness, r, g, b = apart.refine(block, workspace, refined, index, roughness)
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
def _glass(block, workspace, features, refined, weight, n, roughness, ior, f0, reflection, transmission):
    """Reflection and refraction, as in ``begin_glass``."""
    index = begin_glass(workspace, weight, n, roughness, ior, f0, reflection, transmission)
    if index < 0:
        return
    closure = closure_table(workspace)[index]
    cosine = dot(n, vec(surface_table(workspace)[0].wo))
    if features & MULTISCATTER:
        energy.compensate_glass(block, closure, cosine, roughness, transmission)
    r, t, _ = microfacet.reflectance(closure, cosine)
    _, albedo = _refined(block, workspace, refined, index, roughness, add(r, t))
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
def _add_dielectric_layer(block, workspace, compensated, refined, weight, n, roughness, ior, f0):
    """A clear reflecting layer. Returns the weight of the layers below it."""
    index = begin_microfacet(workspace, weight, n, roughness, ior)
    if index < 0:
        return weight
    closure = closure_table(workspace)[index]
    closure.fresnel = FRESNEL_DIELECTRIC
    f0 = saturated(f0)
    put(closure.f0, f0)
    put(closure.reflection_tint, _WHITE)
    cosine = dot(n, vec(surface_table(workspace)[0].wo))
    roughness, film = _refined(block, workspace, refined, index, roughness, NO_FILM)
    e = energy.reflection_albedo(block, cosine, roughness)
    albedo = scale(film, e)
    if film[0] < 0.0:
        albedo = energy.mixed(f0, e, energy.dielectric_albedo(block, ior, cosine, roughness))
    if compensated:
        s = fresnel.remapped(fresnel.dielectric_average(ior), fresnel.f0_of_ior(ior))
        energy.compensate_reflection(block, closure, e, roughness, energy.mixed(f0, 1.0, s))
    albedo = mul(vec(closure.weight), albedo)
    finish(workspace, index, albedo)
    # As in Cycles, a layer that loses energy takes as much from the layers below as one that does not.
    return _below(weight, albedo if compensated else scale(albedo, 1.0 / e))


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
def _add_metal(block, workspace, features, refined, weight, n, roughness, color, tint):
    index = begin_metal(workspace, weight, n, roughness, color, tint)
    if index >= 0:
        roughness, film = _refined(block, workspace, refined, index, roughness, NO_FILM)
        finish_metal(block, workspace, features & MULTISCATTER != 0, index, roughness, film)


@kernel
def add_fibers(workspace, weight, n, roughness):
    """Sheen of fibers. Returns what it reflects of ``weight``."""
    roughness = min(max(roughness, _LOWEST_SHEEN), 1.0)
    cosine = saturate(dot(n, vec(surface_table(workspace)[0].wo)))
    albedo = diffuse.sheen_albedo(cosine, roughness)
    a, b = diffuse.sheen_transform(cosine, roughness)
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
    return _below(weight, add_fibers(workspace, scale(mul(weight, tint), amount), n, roughness))


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
    if tint != _WHITE:
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
def _principled(block, workspace, lobe, index, share):
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
                apart.thin_wall(block, workspace, index, below[0], below[1], below[2])
            else:
                # A ray crosses the surface twice, so each crossing takes the square root of the colour.
                _glass(
                    block,
                    workspace,
                    features,
                    refined,
                    below,
                    mirror,
                    roughness,
                    ior,
                    scale(tint, f0),
                    _WHITE,
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
            apart.subsurface(block, workspace, index, below[0], below[1], below[2], ior)
        weight = scale(weight, 1.0 - amount)
    add_diffuse(workspace, mul(weight, base), base, saturate(number(block, workspace, args[DIFFUSE_ROUGHNESS])), n)


@kernel
def _add_lobe(block, workspace, lobe, index, weight):
    surface = surface_table(workspace)[0]
    kind, args = lobe.kind, lobe.args
    if kind == LOBE_PRINCIPLED:
        _principled(block, workspace, lobe, index, weight)
        return
    if kind > LOBE_ALPHA:
        apart.add(block, workspace, kind, index, weight)
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
        _glass(block, workspace, lobe.features, -1, white, n, roughness, ior, (f0, f0, f0), color, color)


@kernel
def shade(block, workspace):
    """Run the material of ``workspace.surface``: fill its closures, emission, transparency, albedos and holdout."""
    surface = surface_table(workspace)[0]
    material = _materials(block)[surface.material]
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
        return apart.transparency(block, workspace)
    if material.shadow_graph != NO_GRAPH:
        run(block, workspace, material.shadow_graph, material.shadow_slots)
    lobes = lobe_table(block)
    total = ZERO
    for i in range(material.shadow_lobes[0], material.shadow_lobes[1]):
        lobe = lobes[i]
        weight = number(block, workspace, lobe.weight)
        if lobe.kind == LOBE_ALPHA:
            clear = weight * (1.0 - saturate(number(block, workspace, lobe.args[0])))
            total = madd(total, clear, _WHITE)
        else:
            total = madd(total, weight, positive(vector(block, workspace, lobe.args[0])))
    return total
