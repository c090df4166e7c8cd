# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels of ``code_table.VARYING``: as in ``travel``, ``in_scattering`` and ``light_rays``, where media vary in
space. Where none around a ray does, they call those.

Light rays leave a medium from one place of the path's ray. If the medium is thin, the place is drawn from the means of
the cells, or uniformly over the angle under which the light sees the ray (Kulla and Fajardo 2012), half and half. If it
is dense, the place is a collision: only these follow the density inside of cells.
"""

from __future__ import annotations

import math

from .... import emitter as lamps
from ....emitter.emission.varying import COLOUR_STACK, LANES, colours, density, place_colour
from ....emitter.lamps import lamps as lamp_table
from ....jit import kernel, specialised, stack_array
from ....replaced import replaced_on_gpu
from ....vec import add, average, dot, is_zero, largest, length, madd, mul, put, scale, sub, vec
from ...scene import Ray
from .. import lights
from ..outputs.state import LIGHT_RAY as LIGHT_RAY_OUTPUT
from ..outputs.state import scattered_in_medium
from ..path import KEPT_RAY, LIGHT_SET, MEDIA_SETS, PLACE_SET, contribute, path_table
from ..ray_origins import clear_self_primitive
from ..rays import ray_table
from ..samplers import get_2d, get_4d
from ..workspace import spans_of
from . import light_rays, travel
from .beams import facing_density, facing_distance, view_angle
from .cells import LOCAL_RAYS, SECTION, enter_cells, integrate_cells
from .in_scattering import (
    BLACK,
    FEW_PAIRS,
    PAIRS,
    STEPS,
    add_light,
    choose,
    light_between,
    place_of_light,
    to_point,
)
from .phase import phase, sample_phase
from .point import (
    FADE_SEED,
    GLOW_SEED,
    LAMP_SEED,
    LIGHT_SEED,
    SHADOW_SEED,
    TRAVEL_SEED,
    begin,
    coefficients,
    draw,
    set_ray,
    weight_here,
)
from .records import LIGHT_RAY, inside_table
from .stack import receiver
from .tracking import collide, faded, glow, transmittance

VOLUME, SHADOW = int(Ray.VOLUME), int(Ray.SHADOW)
WHITE = (1.0, 1.0, 1.0)
THIN = 1.5  # optical depth up to which places follow the means of cells: weights stay below e to the power of this
_CLOSEST = 1e-9  # as in ``beams``
_LEAST_EXTINCTION = 1e-9
_LEAST_TOTAL = 1e-20  # part of the light: so little is not looked for, because its densities could be 0 by rounding
NO_PLACE = -1.0

phase_here = specialised(phase, "phase_here", part_weight=weight_here)
sample_phase_here = specialised(sample_phase, "sample_phase_here", part_weight=weight_here)
_scatter_here = specialised(travel.scatter, "scatter_here", phase=phase_here, sample_phase=sample_phase_here)


@replaced_on_gpu
@kernel
def none_varies(inside):
    """Whether all media around a ray are homogeneous."""
    return inside.varies == 0


@kernel
def _draw_place(block, inside, rays, found, ray_length, total, near, height, u):
    """A place on a ray of which a light is seen, and its density: ``height`` < 0: the light is not at one point.
    ``total`` is S of ``cells.integrate_cells`` for the whole ray."""
    if height < 0.0:
        _, _, place, slope, _ = integrate_cells(block, inside, rays, found, ray_length, u * total, -1.0)
        return place, slope / total
    height = max(height, _CLOSEST * (1.0 + abs(near)))
    angle = view_angle(near, height, ray_length)
    if u < 0.5:
        place = min(facing_distance(near, height, angle, 2.0 * u), ray_length)
        _, _, _, slope, _ = integrate_cells(block, inside, rays, found, ray_length, -1.0, place)
    else:
        _, _, place, slope, _ = integrate_cells(block, inside, rays, found, ray_length, (2.0 * u - 1.0) * total, -1.0)
    return place, 0.5 * (facing_density(near, height, angle, place) + slope / total)


@kernel
def _light_ray(block, workspace, rays, found, ray_length, depth, total):
    """As ``in_scattering.light_ray``. ``depth`` and ``total`` are the optical depth and S of
    ``cells.integrate_cells``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    d = vec(path.direction)
    start = madd(vec(path.start), path.t_min, d)
    u = get_4d(path.index, path.seed, MEDIA_SETS + path.dimension + LIGHT_SET)
    v = get_2d(path.index, path.seed, MEDIA_SETS + path.dimension + PLACE_SET)
    number = receiver(block, inside)
    extinction = depth / ray_length
    if ray_length == math.inf:
        _, _, half, _, _ = integrate_cells(block, inside, rays, found, ray_length, 0.5 * total, -1.0)
        extinction = math.log(2.0) / half if half > 0.0 else _LEAST_EXTINCTION
    extinction = max(extinction, _LEAST_EXTINCTION)
    emitter, pmf, _, finite, center = lights.select_along(block, number, start, d, ray_length, extinction, u[0])
    if not pmf > 0.0 or lights.visibility(block, emitter) & VOLUME == 0:
        return
    if not lights.may_light(block, emitter, path.bounce):
        return
    begin(workspace, LIGHT_SEED)
    place, weight = NO_PLACE, WHITE
    if depth > THIN:
        place, weight = collide(block, workspace, inside, start, d, ray_length, WHITE, rays, found)
        if place < 0.0:
            return
    scattered_in_medium(block, workspace, LIGHT_RAY_OUTPUT)
    if emitter < block.lamp_count:
        _light_by_lamp(
            block,
            workspace,
            emitter,
            pmf,
            start,
            ray_length,
            rays,
            found,
            extinction,
            total,
            place,
            weight,
            (u[1], u[2], u[3], v[0]),
            v[1],
        )
        return
    by = 1.0
    if place < 0.0:
        near, height = place_of_light(block, emitter, finite, center, start, d, ray_length, u[1], u[2])
        place, by = _draw_place(block, inside, rays, found, ray_length, total, near, height, v[0])
        if not by > 0.0:
            return
    x = madd(start, place, d)
    wi, distance, radiance, pdf, singular = lights.sample_light(block, emitter, x, BLACK, u[1], u[2])
    if pdf <= 0.0 or largest(radiance) <= 0.0:
        return
    if depth <= THIN:
        weight = _scattering_seen(block, workspace, inside, start, d, place, rays, found)
    value, phase_density = phase_here(block, workspace, inside, dot(d, wi))
    weight = scale(weight, value / by)
    if is_zero(weight):
        return
    add_light(block, workspace, emitter, pmf, number, x, wi, distance, radiance, pdf, singular, weight, phase_density)


@kernel
def _scattering_seen(block, workspace, inside, start, d, place, rays, found):
    """The part of the light (RGB, 1/m) that a medium scatters at a place of the path's ray and that reaches its start;
    and the weights of the phase functions there, in the workspace."""
    set_ray(workspace, d, path_table(workspace)[0].kind)
    part = faded(block, workspace, inside, start, d, place, rays, found)
    scattering, _, _ = coefficients(block, workspace, inside, madd(start, place, d))
    return mul(scattering, part)


@kernel
def _light_by_lamp(
    block,
    workspace,
    lamp,
    pmf,
    start,
    ray_length,
    rays,
    found,
    extinction,
    total_scattering,
    collision,
    weight,
    u,
    choice,
):
    """As ``in_scattering._light_by_lamp``: from one place, if the distance ``collision`` is not negative, which the
    path's light reaches with the ``weight``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    row, d = lamp_table(block)[lamp], vec(path.direction)
    places, weights, stack = stack_array(PAIRS), stack_array(LANES), stack_array(COLOUR_STACK)
    origin = sub(start, vec(row.center))
    count = LANES if path.bounce == 0 else FEW_PAIRS
    for lane in range(count):
        u1, u2, u3 = (u[0] + lane * STEPS[0]) % 1.0, (u[1] + lane * STEPS[1]) % 1.0, (u[2] + lane * STEPS[2]) % 1.0
        way = lamps.interior_offset(block, lamp, start, u1, u2, u3)
        place, by = collision, 1.0
        if collision < 0.0:
            near = dot(way, d)
            height = math.sqrt(max(dot(way, way) - near * near, 0.0))
            v = (u[3] + lane * STEPS[3]) % 1.0
            place, by = _draw_place(block, inside, rays, found, ray_length, total_scattering, near, height, v)
        places[lane] = place
        places[LANES + lane], places[2 * LANES + lane], places[3 * LANES + lane] = way
        weights[lane] = 1.0 / by if by > 0.0 else 0.0
        if row.glow >= 0:
            place_colour(block, row.glow, add(origin, way), lane, stack)
    if row.glow >= 0:
        for lane in range(count, LANES):
            place_colour(block, row.glow, origin, lane, stack)
        colours(block, row.glow, stack)
    total = 0.0
    for lane in range(count):
        to = to_point(places, lane, d)
        square = dot(to, to)
        if not square > 0.0:
            weights[lane] = 0.0
            continue
        emission = density(block, row.glow, stack, lane) if row.glow >= 0 else vec(row.emission)
        # An estimate is enough: what is chosen by it is divided by it.
        far = places[lane] if collision < 0.0 else 0.0
        weights[lane] *= average(emission) * math.exp(-min(extinction * far, THIN)) / square
        total += weights[lane]
    if not 0.0 < total < math.inf:
        return
    chosen = choose(weights, count, choice * total)
    if not weights[chosen] > 0.0:
        return
    place = places[chosen]
    to = to_point(places, chosen, d)
    distance = length(to)
    wi = scale(to, 1.0 / distance)
    emission = density(block, row.glow, stack, chosen) if row.glow >= 0 else vec(row.emission)
    far = place if collision < 0.0 else 0.0
    by = average(emission) * math.exp(-min(extinction * far, THIN))
    if not by > 0.0:
        return
    if collision < 0.0:
        weight = _scattering_seen(block, workspace, inside, start, d, place, rays, found)
    value, _ = phase_here(block, workspace, inside, dot(wi, d))
    x = madd(start, place, d)
    weight = scale(mul(weight, light_between(block, workspace, lamp, x, wi, distance)), value)
    if not is_zero(weight):
        contribute(
            block, workspace, mul(weight, emission), row.volume * total / (count * pmf * by), lamp, path.bounce + 1
        )


@kernel
def enter_varying(block, workspace, ray_length):
    """As ``travel.enter``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    if none_varies(inside):
        return travel.enter(block, workspace, ray_length)
    rays, found = stack_array(LOCAL_RAYS), stack_array(SECTION)
    d = vec(path.direction)
    start = madd(vec(path.start), path.t_min, d)
    set_ray(workspace, d, path.kind)
    enter_cells(block, workspace, inside, start, d, ray_length, rays)
    depth, total, _, _, glows = integrate_cells(block, inside, rays, found, ray_length, -1.0, -1.0)
    if glows:
        begin(workspace, GLOW_SEED)
        travel.add_glow(block, workspace, glow(block, workspace, inside, start, d, ray_length, rays, found))
    scatters = _LEAST_TOTAL < total < math.inf
    if scatters and not path.last:
        kept = ray_table(workspace)
        kept[KEPT_RAY] = kept[0]
        clear_self_primitive(kept[0])
        _light_ray(block, workspace, rays, found, ray_length, depth, total)
        kept[0] = kept[KEPT_RAY]
    begin(workspace, TRAVEL_SEED)
    set_ray(workspace, d, path.kind)  # light rays have set theirs
    throughput = vec(path.throughput)
    if not scatters or path.last or not travel.can_find_light(block, path):
        put(path.throughput, mul(throughput, faded(block, workspace, inside, start, d, ray_length, rays, found)))
        return 0.0
    place, throughput = collide(block, workspace, inside, start, d, ray_length, throughput, rays, found)
    put(path.throughput, throughput)
    if place < 0.0:
        return 0.0
    path.length = path.t_min + place
    return 1.0


@kernel
def scatter_varying(block, workspace, unused):
    """As ``travel.scatter``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    if none_varies(inside):
        return travel.scatter(block, workspace, unused)
    # Other branches may have been elsewhere since the collision.
    d = vec(path.direction)
    set_ray(workspace, d, path.kind)
    coefficients(block, workspace, inside, madd(vec(path.start), path.length, d))
    return _scatter_here(block, workspace, unused)


@kernel
def fade_varying(block, workspace, distance):
    """As ``travel.fade``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    if none_varies(inside):
        return travel.fade(block, workspace, distance)
    begin(workspace, FADE_SEED)
    start, d = vec(path.origin), vec(path.direction)
    return transmittance(block, workspace, inside, start, d, path.t_min, distance, path.kind)


@kernel
def _through(block, workspace, start, direction, t_from, t_to):
    """As ``light_rays.through``."""
    inside = inside_table(workspace)[LIGHT_RAY]
    if inside.varies == 0:
        return light_rays.through(block, workspace, start, direction, t_from, t_to)
    return transmittance(block, workspace, inside, start, direction, t_from, t_to, SHADOW)


@kernel
def _lamp_through(block, workspace, row, index, x, direction, count, t_from, t_to, u):
    """As ``light_rays.lamp_through``: from one point of the lamp."""
    inside, spans = inside_table(workspace)[row], spans_of(workspace)
    if inside.varies == 0:
        return light_rays.lamp_through(block, workspace, row, index, x, direction, count, t_from, t_to, u)
    total = 0.0
    for span in range(count):
        c, h = spans[span, 0], spans[span, 1]
        total += max(min(c + h, t_to) - max(c - h, t_from), 0.0)
    if not total > 0.0:
        return BLACK
    left, t = draw(workspace) * total, t_from
    for span in range(count):
        c, h = spans[span, 0], spans[span, 1]
        first = max(c - h, t_from)
        own = min(c + h, t_to) - first
        if own > 0.0 and left >= 0.0:
            t = first + min(left, own)
            left -= own
    lamp = lamp_table(block)[index]
    emission = vec(lamp.emission)
    if lamp.glow >= 0:
        stack = stack_array(COLOUR_STACK)
        offset = sub(madd(x, t, direction), vec(lamp.center))
        for lane in range(LANES):
            place_colour(block, lamp.glow, offset, lane, stack)
        colours(block, lamp.glow, stack)
        emission = density(block, lamp.glow, stack, 0)
    kind = SHADOW if row == LIGHT_RAY else path_table(workspace)[0].kind
    return scale(mul(emission, transmittance(block, workspace, inside, x, direction, t_from, t, kind)), total)


_shadow = specialised(light_rays.shadow, "shadow_through", through=_through)
_lamp = specialised(light_rays.lamp, "lamp_between", through=_through, lamp_through=_lamp_through)
_seen_lamp = specialised(light_rays.seen_lamp, "seen_lamp_through", lamp_through=_lamp_through)


@kernel
def shadow_varying(block, workspace, x, y, z, dx, dy, dz, t_max, blockers):
    """As ``light_rays.shadow``."""
    begin(workspace, SHADOW_SEED)
    return _shadow(block, workspace, x, y, z, dx, dy, dz, t_max, blockers)


@kernel
def lamp_varying(block, workspace, index, x, y, z, dx, dy, dz, count, start_x, start_y, start_z, u):
    """As ``light_rays.lamp``."""
    begin(workspace, LAMP_SEED)
    return _lamp(block, workspace, index, x, y, z, dx, dy, dz, count, start_x, start_y, start_z, u)


@kernel
def seen_lamp_varying(block, workspace, index, count, t_to, u):
    """As ``light_rays.seen_lamp``."""
    begin(workspace, LAMP_SEED)
    return _seen_lamp(block, workspace, index, count, t_to, u)
