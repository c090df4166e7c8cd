# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light rays and the visibility of lamps in a scene with media."""

from __future__ import annotations

from .... import emitter as lamps
from ....jit import kernel
from ....vec import add, is_zero, mul, vec
from .. import lights
from ..path import path_table
from ..ray_continuation import continue_past_hit
from ..rays import TRANSPARENT_PLACES, intersect, ray_table
from ..visibility import BLACK, pass_through, surfaces_left
from ..workspace import spans_of
from .beams import attenuation
from .records import LIGHT_RAY, MOST_BOUNDS, bounds_table, inside_table
from .stack import cross_hit, met_bounds

WHITE = (1.0, 1.0, 1.0)


@kernel
def through(block, workspace, start, direction, t_from, t_to):
    """Transmittance (RGB) of the media around a light ray between two distances."""
    return attenuation(vec(inside_table(workspace)[LIGHT_RAY].extinction), t_to - t_from)


@kernel
def lamp_through(block, workspace, row, index, x, direction, count, t_from, t_to, u):
    """``lamps.radiance`` of lamp ``index``, whose ``count`` intervals are in the workspace, through the media of this
    row from ``t_from`` on."""
    return lamps.attenuated_radiance(
        block,
        index,
        x,
        direction,
        spans_of(workspace),
        count,
        t_from,
        t_to,
        u,
        vec(inside_table(workspace)[row].extinction),
    )


@kernel
def _passed(block, workspace, direction, left):
    """The transmittance (RGB) of a light ray at the surface that it has hit, and the number of further surfaces that it
    may pass; less than 0 for none. ``left`` is the number before."""
    ray, weight = ray_table(workspace)[0], WHITE
    if not bounds_table(block)[met_bounds(block, ray)].only:
        left -= 1
        weight = pass_through(block, workspace, direction)
    cross_hit(block, inside_table(workspace)[LIGHT_RAY], ray, direction)
    return weight, left


@kernel
def shadow(block, workspace, x, y, z, dx, dy, dz, t_max, blockers):
    """``visibility.transmittance`` from (x, y, z) along (dx, dy, dz), if nothing opaque is in the way. ``stack.bounds``
    must know where the light ray begins."""
    start, direction = (x, y, z), (dx, dy, dz)
    result, t_min, left, mask = WHITE, 0.0, surfaces_left(block, workspace), int(blockers) << TRANSPARENT_PLACES
    for _ in range(MOST_BOUNDS):
        found = block.transparent_shadows != 0 and intersect(block, workspace, start, direction, t_min, t_max, mask)
        t_to = float(ray_table(workspace)[0].t_far) if found else t_max
        result = mul(result, through(block, workspace, start, direction, t_min, t_to))
        if not found or is_zero(result):
            return result
        weight, left = _passed(block, workspace, direction, left)
        if left < 0:
            return BLACK
        result = mul(result, weight)
        t_min = continue_past_hit(block, workspace, t_min)
    return BLACK


@kernel
def lamp(block, workspace, index, x, y, z, dx, dy, dz, count, start_x, start_y, start_z, u):
    """``visibility.visible_lamp`` of lamp ``index``, whose ``count`` intervals are in the workspace."""
    position, direction, start = (x, y, z), (dx, dy, dz), (start_x, start_y, start_z)
    index, count, spans = int(index), int(count), spans_of(workspace)
    t_end = spans[count - 1, 0] + spans[count - 1, 1]
    mask = lights.blockers(block, index)
    if block.transparent_shadows:
        mask |= mask << TRANSPARENT_PLACES
    total, weight, t_from, left = BLACK, WHITE, 0.0, surfaces_left(block, workspace)
    for _ in range(MOST_BOUNDS):
        found = intersect(block, workspace, start, direction, t_from, t_end, mask)
        t_to = float(ray_table(workspace)[0].t_far) if found else t_end
        radiance = lamp_through(block, workspace, LIGHT_RAY, index, position, direction, count, t_from, t_to, u)
        total = add(total, mul(weight, radiance))
        if not found or not block.transparent_shadows:
            break
        weight = mul(weight, through(block, workspace, position, direction, t_from, t_to))
        own, left = _passed(block, workspace, direction, left)
        weight = mul(weight, own)
        if left < 0 or is_zero(weight):
            break
        t_from = continue_past_hit(block, workspace, t_from)
    return total


@kernel
def seen_lamp(block, workspace, index, count, t_to, u):
    """``lamps.radiance`` of lamp ``index`` along the path's ray up to ``t_to``, through the present media of the
    path."""
    path = path_table(workspace)[0]
    return lamp_through(
        block, workspace, 0, int(index), vec(path.origin), vec(path.direction), int(count), path.t_min, t_to, u
    )
