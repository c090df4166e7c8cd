# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that reaches a surface along a light ray: through transparent surfaces, and from a lamp with surfaces inside
it."""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...jit import kernel
from ...vec import add, largest, length, madd, mul, negate, scale, sub
from . import lights
from .geometry import find_shadow_surface, shading_material_table
from .media import dispatch
from .path import path_table, put_depths
from .ray_continuation import continue_past_hit
from .ray_origins import step_size
from .rays import OFFSET, TRANSPARENT_PLACES, intersect, occluded, ray_table, start_anew
from .shading import transparency
from .shading.records import HAS_TRANSPARENCY, NEEDS_RAY, surface_table
from .workspace import secondary_table

BLACK = (0.0, 0.0, 0.0)


@kernel
def shadow_ray(x, start, wi, distance):
    """Direction and length of a shadow ray from ``start`` to just before the point at ``distance`` from x along wi.

    From x itself it would end before that point. From a start beside x, along the same direction, it could end behind
    the surface of an emissive triangle, and the light would be in its own shadow.
    """
    if distance == np.inf:
        return wi, np.inf
    return ray_towards(start, madd(x, distance, wi), wi)


@kernel
def ray_towards(start, target, wi):
    """Direction, nearly ``wi``, and length of a shadow ray from ``start`` to just before the ``target``."""
    way = sub(target, start)
    t_max = length(way)
    if t_max <= 0.0:
        return wi, 0.0
    return scale(way, 1.0 / t_max), max(t_max * (1.0 - OFFSET) - 4.0 * step_size(target), 0.0)


@kernel
def surfaces_left(block, workspace):
    """Number of transparent surfaces that light to the workspace's path may pass: those before count, too."""
    return max(block.transparent_bounces - path_table(workspace)[0].transparent, 0)


@kernel
def transmittance(block, workspace, start, direction, t_max, blockers):
    """Fraction of the light (RGB) from ``t_max`` along ``direction`` that reaches ``start`` through transparent
    surfaces.

    ``blockers``: the kind of ray, see ``lights.blockers``.
    """
    start_anew(block, workspace)
    if occluded(block, workspace, start, direction, 0.0, t_max, blockers):
        return BLACK
    if block.has_media:
        return dispatch.shadow(block, workspace, start, direction, t_max, blockers)
    result = (1.0, 1.0, 1.0)
    if block.transparent_shadows:
        t_min = 0.0
        for _ in range(surfaces_left(block, workspace) + 1):
            if not intersect(block, workspace, start, direction, t_min, t_max, blockers << TRANSPARENT_PLACES):
                return result
            result = mul(result, pass_through(block, workspace, direction))
            if largest(result) <= 0.0:
                return BLACK
            t_min = continue_past_hit(block, workspace, t_min)
        return BLACK
    return result


@kernel
def pass_through(block, workspace, direction):
    """Transparency (RGB) of the surface that a shadow ray has hit."""
    secondary = secondary_table(workspace)[0]  # the path's own surface is still needed
    material = find_shadow_surface(block, workspace, secondary, negate(direction))
    flags = shading_material_table(block)[material].flags
    if not flags & HAS_TRANSPARENCY:
        return BLACK
    if flags & NEEDS_RAY:
        surface = surface_table(secondary)[0]
        surface.ray_length = float(ray_table(workspace)[0].t_far)
        surface.ray_singular = 0
        put_depths(path_table(workspace)[0], surface)
    return transparency(block, secondary)


@kernel
def visible_lamp(block, workspace, lamp, x, direction, spans, count, start, u):
    """Radiance (RGB) of a lamp along a ray from x, up to the first surface: surfaces may stand inside a lamp.

    ``start`` is x moved off its surface; u is for ``lamps.radiance``.
    """
    start_anew(block, workspace)
    if block.has_media:
        return dispatch.lamp(block, workspace, lamp, x, direction, count, start, u)
    t_end = spans[count - 1, 0] + spans[count - 1, 1]
    total, weight, t_from = BLACK, (1.0, 1.0, 1.0), 0.0
    mask = lights.blockers(block, lamp)
    if block.transparent_shadows:
        mask |= mask << TRANSPARENT_PLACES
    for _ in range(surfaces_left(block, workspace) + 1):
        found = intersect(block, workspace, start, direction, t_from, t_end, mask)
        t_to = float(ray_table(workspace)[0].t_far) if found else t_end
        total = add(total, mul(weight, lamps.radiance(block, lamp, x, direction, spans, count, t_from, t_to, u)))
        if not found or not block.transparent_shadows:
            break
        weight = mul(weight, pass_through(block, workspace, direction))
        if largest(weight) <= 0.0:
            break
        t_from = continue_past_hit(block, workspace, t_from)
    return total
