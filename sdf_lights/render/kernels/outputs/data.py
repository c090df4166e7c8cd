# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the surfaces that the camera sees, directly and through transparent ones."""

from __future__ import annotations

import math

from ....jit import kernel, table
from ....vec import ZERO, add, average, dot, frame, length, madd, mul, normalize, scale, sub, to_world, vec
from ...nodes.lookups import attribute_here
from .. import lights
from ..camera import ORTHOGRAPHIC, camera_table, view_depth
from ..emission_graphs import emission_table, run_world_aovs
from ..geometry import NO_DOMAIN, attribute_table, instance_table, shading_material_table
from ..next_event import begin_light_ray
from ..path import CAMERA, OCCLUSION_SETS, path_table, sample_table
from ..ray_origins import spawn_ray
from ..rays import SHADOW_OPAQUE
from ..samplers import get_2d
from ..shading import energy, fresnel, microfacet
from ..shading.diffuse import cosine_hemisphere
from ..shading.material_records import AOV
from ..shading.operands import number, vector
from ..shading.records import (
    FACETS,
    FRESNEL_CONDUCTOR,
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    HAIR,
    MICROFACET,
    PORTAL,
    STRAIGHT,
    SUBSURFACE,
    THIN_GLASS,
    closure_table,
    surface_table,
)
from ..visibility import transmittance
from ..workspace import secondary_table
from . import dispatch
from .light import is_diffuse
from .records import (
    DATA_NAMES,
    MATTES,
    MOST_HITS,
    VECTORS,
    aov_place_table,
    data_place_table,
    matte_hit_table,
    output_sum_table,
)

_MIST, _UV = DATA_NAMES["mist"], DATA_NAMES["uv"]
_OBJECT_INDEX, _MATERIAL_INDEX = DATA_NAMES["object_index"], DATA_NAMES["material_index"]
_GLOSSY, _TRANSMISSION = DATA_NAMES["glossy_albedo"], DATA_NAMES["transmission_albedo"]

_OCCLUSION = DATA_NAMES["occlusion"]
_aovs = table("aovs", AOV)

_WHITE = (1.0, 1.0, 1.0)


@kernel
def _place(block, index):
    """Index in the sums of a sample; −1: the film lacks it."""
    place = data_place_table(block)[index]
    return 2 * block.light_columns + place if place >= 0 else -1


@kernel
def _add(sums, place, value):
    if place >= 0:
        for axis in range(3):
            sums[place + axis] += value[axis]


@kernel
def _number(block, sums, name, value):
    place = _place(block, name)
    if place >= 0:
        sums[place] = value


@kernel
def _mist(block, position):
    """Factor of the mist on a surface."""
    camera = camera_table(block)[0]
    distance = view_depth(block, position)
    if camera.projection != ORTHOGRAPHIC:
        m = camera.matrix
        distance = length(sub(position, (m[0, 3], m[1, 3], m[2, 3])))
    mist = min(max((distance - block.mist_start) * block.mist_inverse_depth, 0.0), 1.0)
    return 1.0 - mist**block.mist_power


@kernel
def _as_counted(surface, closure):
    """The albedo (RGB) that ``shading.closures.finish`` got for a closure, in the colour of its weight."""
    mean = average(vec(closure.weight))
    return scale(vec(closure.weight), closure.pick * surface.pick_total / mean) if mean > 0.0 else ZERO


@kernel
def _microfacet_albedos(block, closure, cosine):
    """Albedos (RGB) of reflection and of refraction by a closure's microfacets, without its weight. As in Cycles,
    single scattering loses no light, and what is not reflected by a smooth surface is refracted."""
    f0, roughness = vec(closure.f0), math.sqrt(closure.alpha)
    if closure.kind == FACETS:
        roughness = math.sqrt(math.sqrt(closure.alpha * closure.a))
        if closure.b > 0.0:
            return vec(closure.thin_film), ZERO
    if closure.fresnel == FRESNEL_CONDUCTOR:
        k = closure.edge
        return (
            fresnel.conductor(cosine, f0[0], k[0]),
            fresnel.conductor(cosine, f0[1], k[1]),
            fresnel.conductor(cosine, f0[2], k[2]),
        ), ZERO
    r, t, _ = microfacet.reflectance(closure, cosine)
    if closure.fresnel == FRESNEL_F82:
        return energy.mixed(f0, 1.0, energy.cycles_schlick(block, cosine, roughness)), ZERO
    if closure.fresnel == FRESNEL_DIELECTRIC and (closure.ior > 1.0 or not closure.transmits):
        f = energy.mixed(f0, 1.0, energy.cycles_dielectric(block, closure.ior, cosine, roughness))
        r = mul(f, vec(closure.reflection_tint))
        t = mul(sub(_WHITE, f), vec(closure.transmission_tint)) if closure.transmits else ZERO
    return r, t


@kernel
def _albedos(block, workspace):
    """Albedos (RGB) of reflection and of refraction, separated as in Cycles."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    glossy, transmission = ZERO, ZERO
    for index in range(surface.closure_count):
        closure = closures[index]
        kind, weight = closure.kind, vec(closure.weight)
        if kind >= STRAIGHT or kind == PORTAL or is_diffuse(kind):
            continue
        if kind == MICROFACET or kind == FACETS and not (closure.transmits and closure.b > 0.0):
            r, t = _microfacet_albedos(block, closure, dot(vec(closure.normal), vec(surface.wo)))
            weight = scale(weight, closure.multiscatter[0])
            glossy, transmission = add(glossy, mul(weight, r)), add(transmission, mul(weight, t))
        elif kind == THIN_GLASS or kind == HAIR and closure.transmits:
            transmission = add(transmission, _as_counted(surface, closure))
        else:
            glossy = add(glossy, _as_counted(surface, closure))
    return glossy, transmission


@kernel
def _visible_sky(block, workspace, surface):
    """Fraction (RGB) of the sky that nearby surfaces leave visible in one direction, drawn about the normal of diffuse
    closures."""
    closures, normal = closure_table(workspace), ZERO
    for index in range(surface.closure_count):
        closure = closures[index]
        if is_diffuse(closure.kind) and closure.kind != SUBSURFACE:
            normal = madd(normal, abs(average(vec(closure.weight))), vec(closure.normal))
    normal = vec(surface.n) if dot(normal, normal) == 0.0 else normalize(normal)
    path, ng = path_table(workspace)[0], vec(surface.ng)
    u = get_2d(path.index, path.seed, OCCLUSION_SETS + path.dimension)
    t, b = frame(normal)
    wi = to_world(cosine_hemisphere(u[0], u[1]), t, b, normal)
    if block.has_media:
        begin_light_ray(block, workspace, ng, wi)
    start = spawn_ray(workspace, surface, wi)
    return transmittance(block, workspace, start, wi, block.occlusion_distance, SHADOW_OPAQUE)


@kernel
def _add_matte(workspace, surface, weight):
    if weight > 0.0:
        hits = matte_hit_table(workspace)
        if hits[0].instance < MOST_HITS:
            hits[0].instance += 1
        hit = hits[hits[0].instance]
        hit.instance, hit.material, hit.weight = surface.instance, surface.material, weight


@kernel
def _add_aovs(block, workspace, range_, sums):
    """Add the values of shader AOVs: the workspace's registers hold them."""
    for index in range(range_[0], range_[1]):
        row = _aovs(block)[index]
        place = aov_place_table(block)[row.aov]
        if place < 0:
            continue
        place += 2 * block.light_columns
        if row.width == 1:
            sums[place] += number(block, workspace, row.operand)
        else:
            _add(sums, place, vector(block, workspace, row.operand))
            sums[place + 3] += 1.0


@kernel
def add_surface(block, workspace, first):
    """Add the properties of the surface that the camera sees. ``first``: whether it is the first that is solid
    enough."""
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    sums, throughput = output_sum_table(workspace), vec(path.throughput)
    transparency = vec(surface.transparency)
    alpha = (
        min(max(1.0 - transparency[0], 0.0), 1.0),
        min(max(1.0 - transparency[1], 0.0), 1.0),
        min(max(1.0 - transparency[2], 0.0), 1.0),
    )
    place = _place(block, _OCCLUSION)
    if place >= 0:
        _add(sums, place, mul(mul(throughput, alpha), _visible_sky(block, workspace, surface)))
    place = _place(block, _MIST)
    if place >= 0:
        sums[place] += _mist(block, vec(surface.position)) * average(mul(throughput, alpha))
    glossy, transmission = _place(block, _GLOSSY), _place(block, _TRANSMISSION)
    if glossy >= 0 or transmission >= 0:
        reflected, refracted = _albedos(block, workspace)
        _add(sums, glossy, mul(throughput, reflected))
        _add(sums, transmission, mul(throughput, refracted))
    if block.outputs & MATTES:
        _add_matte(workspace, surface, average(throughput) * (1.0 - average(vec(surface.transparency))))
    if not first and sample_table(workspace)[0].found:
        return 0.0
    _number(block, sums, _OBJECT_INDEX, instance_table(block)[surface.instance].index)
    _number(block, sums, _MATERIAL_INDEX, shading_material_table(block)[surface.material].index)
    _add_aovs(block, workspace, shading_material_table(block)[surface.material].aovs, sums)
    if first and block.outputs & VECTORS:
        dispatch.add_vector(block, workspace)
    place = _place(block, _UV)
    if first and place >= 0:
        attributes = instance_table(block)[surface.instance].attributes
        if attribute_table(block)[attributes + block.uv_attribute].domain != NO_DOMAIN:
            found = attribute_here(block, workspace, block.uv_attribute)
            _add(sums, place, (found[0], found[1], 1.0))
    return 0.0


@kernel
def _add_world_aovs(block, workspace, sums):
    """Add the shader AOVs of the world, where it is part of the picture."""
    range_, world = emission_table(block)[0].aovs, lights.world_emitter(block)
    if range_[1] == range_[0] or not lights.visibility(block, world) & CAMERA:
        return
    if block.transparent_film and not block.shows_environment:
        return
    run_world_aovs(block, workspace, vec(path_table(workspace)[0].direction), CAMERA)
    _add_aovs(block, secondary_table(workspace)[0], range_, sums)


@kernel
def add_miss(block, workspace, unused):
    """Drop the numbers of surfaces that are too transparent, because nothing is behind them. The background moves as
    the camera turns."""
    if not sample_table(workspace)[0].found:
        sums = output_sum_table(workspace)
        _number(block, sums, _OBJECT_INDEX, 0)
        _number(block, sums, _MATERIAL_INDEX, 0)
        if block.outputs & VECTORS and block.background_moves:
            dispatch.add_background_vector(block, workspace)
        _add_world_aovs(block, workspace, sums)
    return 0.0
