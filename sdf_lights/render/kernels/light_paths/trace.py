# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths: from points of lamps, lights and emissive triangles on, and from the world, by emission, with a vertex
wherever a surface scatters light.

A path carries flux. A surface scatters it by the BSDF that a path from the camera would meet, so a surface is shaded
once more for the direction that was drawn, with the light where that came from (Veach 1997, section 5.3: adjoint
BSDFs). With E = f · |cos| of the way back,

    flux' = flux · E(ω', ω) |ng · ω'| / (|ng · ω| p(ω')).

Filter Glossy blurs lobes by the least density with which the path from the camera was scattered before. A light path
does not know that path yet. It has been scattered diffusely at both ends of a connection at least, by the densities
cosine / π. So lobes are blurred by the mean of the lesser one, which is ``_expected_density``.
"""

from __future__ import annotations

import math

import numpy as np

from .... import emitter as lamps
from ....emitter.lamps import lamps as lamp_table
from ....emitter.sampling.cut_points import uniform_intensity
from ....jit import kernel
from ....vec import ZERO, add, average, dot, frame, largest, length, mul, negate, put, scale, sub, to_world, vec
from .. import lights
from ..emission_graphs import NO_RAY, modulated
from ..geometry import TRIANGLES, find_surface, instance_table, surface_at, surface_table
from ..motion import stop_at
from ..ray_continuation import continue_past_surface
from ..ray_origins import clear_self_primitive, offset_ray_origin, spawn_ray
from ..rays import SHADOW_OPAQUE, hit_instance, intersect, occluded, ray_table, start_anew
from ..samplers import get_2d, get_4d, pixel_seed
from ..shading import sample, shade
from ..shading.caustics import blur_lobes
from ..shading.microfacet import reflectance
from ..shading.records import (
    DIFFUSE,
    MICROFACET,
    SINGULAR,
    TRANSLUCENT,
    TRANSPARENT,
    closure_table,
)
from ..visibility import shadow_ray
from ..workspace import secondary_table
from .connections import breadth
from .distant import leave_distant
from .mirrors import mirrored, scattered_flux
from .records import CONNECTS, FOLLOW_ALL, FOLLOW_DIFFUSE, PLACE, material_table, power_table

VISIBILITY_RAYS, LEAST_VISIBILITY = 4, 0.02  # rays from a vertex to pilots; what it counts where none of these see it
# What a side of a rough surface counts at least, if light may leave there: microfacets that are turned away scatter
# some where the smooth surface has total reflection.
LEAST_SIDE = 0.05
NEARLY = 0.999  # of the way to a pilot, whose surface is not in the way
FIRST_SETS, BOUNCE_SETS = 2, 2  # sets of random numbers of a path, and of each surface that it meets
MEAN_DENSITY = 8.0 / (15.0 * math.pi)  # of ``_expected_density``, for all cosines
LONGER = 1.0 + 1e-6  # factor of a distance that is the same but for rounding


@kernel
def _leave_triangle(block, workspace, emitter, u1, u2, u3, u4):
    """As ``lights.leave_light``: a uniform point of an emissive triangle, whose material tells what it emits to either
    side, and a direction by the cosine."""
    instance, primitive, area = lights.triangle_place(block, emitter)
    root = math.sqrt(u1)
    side = 1.0 if u3 < 0.5 else -1.0
    square, turn = 2.0 * u3 if u3 < 0.5 else 2.0 * u3 - 1.0, 2.0 * math.pi * u4
    surface = surface_table(secondary_table(workspace)[0])[0]
    corner = 1.0 - root, root * u2
    surface_at(block, surface, instance, primitive, corner[0], corner[1], (0.0, 0.0, 1.0), DIFFUSE, 0.0)
    ng, s = vec(surface.ng), math.sqrt(square)
    t, b = frame(ng)
    around = (s * math.cos(turn), s * math.sin(turn), side * math.sqrt(1.0 - square))
    direction = to_world(around, t, b, ng)
    surface_at(block, surface, instance, primitive, corner[0], corner[1], direction, DIFFUSE, 0.0)
    shade(block, secondary_table(workspace)[0])
    flux = scale(vec(surface.emission), 2.0 * math.pi * area)
    return spawn_ray(workspace, surface, direction), direction, flux, np.inf


@kernel
def leave_lamp(block, lamp, u1, u2, u3):
    """A uniform point of an SDF lamp, and the radiant intensity (RGB, W/sr) with which it stands for the whole lamp."""
    center = vec(lamp_table(block)[lamp].center)
    offset = lamps.interior_offset(block, lamp, center, u1, u2, u3)
    return add(center, offset), uniform_intensity(block, lamp, offset)


@kernel
def any_direction(u1, u2):
    """A uniform direction."""
    z, around = 1.0 - 2.0 * u1, 2.0 * math.pi * u2
    s = math.sqrt(max(1.0 - z * z, 0.0))
    return s * math.cos(around), s * math.sin(around), z


@kernel
def _start(block, workspace, index, total, seed):
    """Emitter, start, direction and flux (RGB, W) of a light path, and how far from there its light begins to be
    scattered at most. The emitter is −1 if there is no light."""
    u, powers = get_4d(index, seed, 0), power_table(block)
    sum_of_powers = powers[len(powers) - 1]
    emitter = min(np.searchsorted(powers, u[0] * sum_of_powers, side="right"), len(powers) - 1)
    power = powers[emitter] - (powers[emitter - 1] if emitter > 0 else 0.0)
    if not power > 0.0:
        return -1, ZERO, ZERO, ZERO, 0.0
    part, v = sum_of_powers / (power * total), get_2d(index, seed, 1)
    if lights.is_triangle(block, emitter):
        origin, direction, flux, reach = _leave_triangle(block, workspace, emitter, u[1], u[2], v[0], v[1])
        return emitter, origin, direction, scale(flux, part), reach
    if lights.is_distant(block, emitter):
        origin, direction, flux = leave_distant(block, workspace, emitter, u[1], u[2], u[3], v[0], v[1])
        return emitter, origin, direction, scale(flux, part), np.inf
    if emitter >= block.lamp_count:
        origin, direction, flux, reach = lights.leave_light(block, emitter, u[1], u[2], v[0], v[1])
        if block.emission_graphs:
            back = negate(direction)
            flux = modulated(block, workspace, emitter, flux, add(origin, direction), back, 1.0, NO_RAY)
        return emitter, origin, direction, scale(flux, part), reach
    origin, intensity = leave_lamp(block, emitter, u[1], u[2], u[3])
    return emitter, origin, any_direction(v[0], v[1]), scale(intensity, 4.0 * math.pi * part), np.inf


@kernel
def _is_singular(block, emitter, position, wi):
    """Whether the light that an emitter sends to a position comes from one direction alone. Rays of a mirror do not
    find it."""
    if emitter < block.lamp_count or lights.is_triangle(block, emitter):
        return False
    return lights.sample_light(block, emitter, position, wi, 0.5, 0.5)[4]


@kernel
def _is_lit(block, workspace, emitter, origin, direction, position, distance):
    """Whether the light of a light path that started at ``origin`` reaches the ``position`` at this distance. A disk
    that faces the lit point begins nearer to it or farther."""
    if emitter < block.lamp_count or lights.is_triangle(block, emitter) or lights.is_distant(block, emitter):
        return True
    way = negate(direction)
    begins = lights.distance_to_light(block, emitter, position, way)
    if not begins > 0.0:
        return False
    if begins <= distance * LONGER:
        return True
    start_anew(block, workspace)
    return not occluded(block, workspace, origin, way, 0.0, begins - distance, SHADOW_OPAQUE)


@kernel
def _expected_density(cosine):
    """Mean of the lesser of c / π and cosine / π, for a random c of the density 2 c in (0, 1)."""
    return (cosine - cosine * cosine * cosine / 3.0) / math.pi


@kernel
def _importance(workspace, flux):
    """Estimates of the power that the surface of the workspace scatters to this side and to the other, as far as
    connections find it."""
    surface, closures, here, beyond_it = surface_table(workspace)[0], closure_table(workspace), 0.0, 0.0
    for index in range(surface.closure_count):
        closure = closures[index]
        power = breadth(closure) * average(mul(vec(closure.weight), flux))
        if closure.kind == TRANSLUCENT:
            beyond_it += power
        elif closure.kind == MICROFACET and power > 0.0:
            r, t, _ = reflectance(closure, abs(dot(vec(closure.normal), vec(surface.wo))))
            here += power * max(average(r), LEAST_SIDE * closure.reflects)
            beyond_it += power * max(average(t), LEAST_SIDE * closure.transmits)
        else:
            here += power
    return here, beyond_it


@kernel
def _trace(block, workspace, index, total, seed, raw, first, width):
    """Follow one light path, and write its vertices into ``raw`` from ``first`` on, ``width`` at most; returns how
    many."""
    surface, secondary = surface_table(workspace)[0], secondary_table(workspace)[0]
    clear_self_primitive(ray_table(workspace)[0])
    emitter, origin, direction, flux, reach = _start(block, workspace, index, total, seed)
    if emitter < 0:
        return 0
    count, scatters, diffuse, glossy, transmission, transparent = 0, 1, 0, 0, 0, 0
    t_min, pdf, kind, dimension, first_ones = 0.0, 0.0, 0, FIRST_SETS, 0
    instance, primitive, u, v, wi, waits = np.int64(0), np.int64(0), 0.0, 0.0, ZERO, False
    while True:
        start_anew(block, workspace)
        if not intersect(block, workspace, origin, direction, t_min, reach, DIFFUSE):
            return count
        ray = ray_table(workspace)[0]
        distance = float(ray.t_far)
        find_surface(block, workspace, negate(direction), DIFFUSE, 0.0)
        if waits:
            footprint = distance * block.camera_pixel_angle + block.camera_pixel_width
            surface_at(block, surface_table(secondary)[0], instance, primitive, u, v, direction, DIFFUSE, footprint)
            shade(block, secondary)
            blur_lobes(block, secondary, _expected_density(abs(dot(vec(surface.n), direction))))
            before = largest(flux)
            factor, gloss = scattered_flux(block, secondary, wi, kind, pdf)
            flux = mul(flux, factor)
            u = get_2d(index, seed, dimension + 1)
            survival = min(largest(flux) / before, 1.0)
            if not survival > 0.0 or u[0] >= survival:
                return count
            flux = scale(flux, 1.0 / survival)
            # A path from the camera does not count how its light rays are scattered.
            if scatters > 2 and not kind & TRANSPARENT:
                through = dot(vec(surface_table(secondary)[0].ng), wi) < 0.0
                transmission += int(through)
                glossy += int(not through and u[1] < gloss)
                diffuse += int(not through and u[1] >= gloss)
            dimension += BOUNCE_SETS
        instance, primitive, u, v = hit_instance(ray), np.int64(ray.primitive), float(ray.u), float(ray.v)
        wi = negate(direction)
        shade(block, workspace)
        triangle = instance_table(block)[instance].primitive == TRIANGLES
        flags = material_table(block)[surface.material] if triangle else 0
        position, ng = vec(surface.position), vec(surface.ng)
        lit, alone = True, False
        if scatters == 1:
            alone = _is_singular(block, emitter, position, wi)
            lit = alone or _is_lit(block, workspace, emitter, origin, direction, position, distance)
        blur_lobes(block, workspace, MEAN_DENSITY)
        here, beyond_it = _importance(workspace, flux) if lit and flags & CONNECTS else (0.0, 0.0)
        numbers = get_4d(index, seed, dimension)
        if here + beyond_it > 0.0:
            # One vertex stands for what leaves on either side.
            vertex, chance = raw[first + count], here / (here + beyond_it)
            on_this_side = numbers[3] < chance
            put(vertex.position, position)
            put(vertex.normal, ng if on_this_side else negate(ng))
            put(vertex.wi, wi)
            put(vertex.flux, scale(flux, 1.0 / (chance if on_this_side else 1.0 - chance)))
            vertex.importance, vertex.u, vertex.v = here + beyond_it, u, v
            vertex.instance, vertex.primitive, vertex.emitter = instance, primitive, emitter
            vertex.scatters, vertex.diffuse, vertex.glossy = scatters, diffuse, glossy
            vertex.transmission = transmission
            # A path from the camera scatters nowhere behind its last transparent surface; light rays pass one more.
            vertex.transparent = transparent + int((transparent if scatters == 1 else first_ones) == 0)
            count += 1
            if count == width:
                return count
        direction, _, pdf, _, kind = sample(block, workspace, numbers[0], numbers[1], numbers[2])
        if pdf <= 0.0:
            return count
        if kind & TRANSPARENT:
            transparent += 1
            if surface.portal or transparent > block.transparent_bounces:
                return count
            t_min = continue_past_surface(workspace, distance, t_min)
        else:
            if not lit or alone and kind & SINGULAR:
                return count
            if flags & FOLLOW_ALL == 0 and (flags & FOLLOW_DIFFUSE == 0 or kind & SINGULAR):
                return count
            if kind & SINGULAR:
                _, pdf, _ = mirrored(workspace, direction)
                if pdf <= 0.0:
                    return count
            if scatters == 1:
                first_ones = transparent
            scatters += 1
            if scatters > block.max_bounces:
                return count
            origin, t_min, reach = spawn_ray(workspace, surface, direction), 0.0, np.inf
        waits = True


@kernel
def trace_light_paths(block, workspace, first, last, total, number, times, width, raw, lengths):
    """Trace the light paths ``first`` to before ``last`` of ``total``, of pass ``number``, into ``width`` rows of
    ``raw`` each. The first of them are of the first of the ``times``, and so on; without these, nothing moves."""
    scratch, seed, at, now = workspace[0], pixel_seed(PLACE + number, PLACE, block[0].seed), 0, -1
    each = total // max(len(times), 1)
    for index in range(first, last):
        if len(times) > 0 and now != index // each:
            now = index // each
            at = stop_at(block, workspace, times[now])
        lengths[index] = _trace(block[at], scratch, index, each, seed, raw, index * width, width)


@kernel
def weight_by_visibility(block, workspace, vertices, pilots):
    """Lower the importance of vertices that none or few of the ``pilots`` (count, 3) see: choices count on what is
    left."""
    scene, scratch = block[0], workspace[0]
    clear_self_primitive(ray_table(scratch)[0])
    for index in range(len(vertices)):
        vertex = vertices[index]
        normal, place, seen = vec(vertex.normal), vec(vertex.position), 0
        for look in range(VISIBILITY_RAYS):
            at = (index * VISIBILITY_RAYS + look) % len(pilots)
            way = sub((pilots[at, 0], pilots[at, 1], pilots[at, 2]), place)
            distance = length(way)
            wi = scale(way, 1.0 / distance) if distance > 0.0 else normal
            if dot(normal, wi) > 0.0:
                start = offset_ray_origin(place, normal, wi)
                direction, t_max = shadow_ray(place, start, wi, distance * NEARLY)
                start_anew(scene, scratch)
                seen += int(not occluded(scene, scratch, start, direction, 0.0, t_max, SHADOW_OPAQUE))
        vertex.importance *= max(seen / VISIBILITY_RAYS, LEAST_VISIBILITY)
