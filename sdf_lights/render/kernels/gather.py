# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that the ray of a path meets, weighed by the balance heuristic against light rays from where it
scattered."""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...emitter.sampling.strategies import NO_BSDF_RAYS, NO_LIGHT_RAYS
from ...jit import kernel
from ...replaced import replaced_on_gpu
from ...vec import is_zero, mul, put_sum, scale, sub, vec
from . import lights
from .caustic_paths import dispatch as caustic_paths
from .caustic_paths.lobes import is_source
from .caustic_paths.records import BY_LOBE
from .emission_graphs import modulated
from .geometry import surface_table
from .lamp_tree import found_table, lamps_along
from .media import dispatch as media
from .media.records import inside_table
from .next_event import bsdf_mis_pdf, lamp_pdf, mis_applies, restore_lamp_cut, selection_normal
from .path import (
    CAMERA,
    EMISSION_SET,
    ONWARD,
    contribute,
    leave_connected,
    of_instance,
    path_table,
    sample_table,
    show_environment,
    subtract_alpha,
)
from .path_reuse.records import arrival_table
from .samplers import get_1d
from .workspace import cut_of, hit_table, light_cut_of, spans_of


@kernel
def _missed_by_light_rays(block, path, emitter):
    """Whether no light rays find the emission that the path's ray meets: they stop at a surface that it has passed, or
    the light's bounces are used up. As in Cycles, it counts as if light rays added the rest."""
    return (block.stops_light_rays != 0 and path.stopped != 0) or not lights.may_light(block, emitter, path.bounce - 1)


@kernel
def _mis(block, workspace, emitter, pdf):
    """Weight of emission met by a ray: balance heuristic against light sampling where the path last scattered.

    Paths from the camera and from singular scattering have pdf 0: nothing else can find that emission.
    """
    path = path_table(workspace)[0]
    if path.pdf <= 0.0:
        return 1.0
    if not mis_applies(block, emitter):
        return 0.0
    pmf = lights.selection_probability(
        block,
        path.light_tree,
        vec(path.origin),
        selection_normal(path, vec(path.normal)),
        emitter,
        light_cut_of(workspace),
    )
    if _missed_by_light_rays(block, path, emitter):  # the power heuristic of Cycles
        return path.pdf * path.pdf / (path.pdf * path.pdf + pmf * pmf * pdf * pdf)
    return path.pdf / (path.pdf + pmf * pdf)


@kernel
def _lamp_mis(block, workspace, lamp, count):
    """As ``_mis``, for a lamp: against the cut where the path last scattered."""
    path = path_table(workspace)[0]
    if path.pdf <= 0.0:
        return 1.0
    if not mis_applies(block, lamp) or not lights.may_light(block, lamp, path.bounce - 1):
        return 0.0
    cut = cut_of(workspace)
    origin, normal = vec(path.origin), vec(path.normal)
    restore_lamp_cut(block, workspace, lamp)
    if cut.strategy == NO_LIGHT_RAYS:
        return 1.0
    pmf = lights.selection_probability(
        block, path.light_tree, origin, selection_normal(path, normal), lamp, light_cut_of(workspace)
    )
    density = lamp_pdf(block, workspace, lamp, origin, vec(path.direction), count)
    rival = bsdf_mis_pdf(cut, path.pdf, path.glossy_pdf)
    return rival / (rival + pmf * density) if rival > 0.0 else 0.0


@kernel
def counts(block, workspace, lamp):
    """Whether a lamp that the path's ray may cross counts there: at broad lobes the cut may be all that is needed."""
    path = path_table(workspace)[0]
    if block.has_media and path.in_medium or not lights.is_in_light_tree(block, path.light_tree, lamp):
        return False
    if path.pdf <= 0.0 or path.glossy_pdf > 0.0:
        return True
    cut = cut_of(workspace)
    restore_lamp_cut(block, workspace, lamp)
    return cut.bsdf_mis_scale > NO_BSDF_RAYS and mis_applies(block, lamp)


@kernel
def gather_lamps(block, workspace, t_to):
    """Add the line integral of each lamp along the path's ray up to the distance ``t_to``."""
    path = path_table(workspace)[0]
    spans, found = spans_of(workspace), found_table(workspace)
    origin, direction = vec(path.origin), vec(path.direction)
    if path.found < 0:
        path.found = lamps_along(block, workspace, origin, direction, t_to, path.kind)
    for index in range(path.found):
        lamp = found[index]
        if not counts(block, workspace, lamp):
            continue
        count = path.kept_count if path.kept == lamp else lamps.trace(block, lamp, origin, direction, spans)
        if count == 0:
            continue
        u = get_1d(path.index, path.seed, path.dimension + EMISSION_SET) if lamps.varies(block, lamp) else 0.5
        if block.has_media and inside_table(workspace)[0].count > 0:
            radiance = media.seen_lamp(block, workspace, lamp, count, t_to, u)
        else:
            radiance = lamps.radiance(block, lamp, origin, direction, spans, count, path.t_min, t_to, u)
        if path.kind == CAMERA:
            radiance = scale(radiance, lights.camera_brightness(block, lamp))
        if is_zero(radiance):
            continue
        weight = _lamp_mis(block, workspace, lamp, count)
        shared = False
        if block.caustic_paths and path.transparent == 0 and (path.caustic > 1 or path.caustic == BY_LOBE):
            if block.reuses_paths and path.reused == ONWARD:
                shared = is_source(block, lamp)
            if not shared:
                weight *= caustic_paths.left_to_path(block, workspace, lamp, count, t_to)
        before = vec(sample_table(workspace)[0].combined)
        contribute(block, workspace, radiance, weight, lamp, path.bounce)
        if block.caustic_paths and block.reuses_paths and shared:
            # Each point of the group leaves another part of it to caustic paths.
            put_sum(arrival_table(workspace)[0].crossed, sub(vec(sample_table(workspace)[0].combined), before))


@replaced_on_gpu
@kernel
def last_lamp_exit(block, workspace, path):
    """Distance at which the path's ray leaves the last lamp that it crosses; 0 if it crosses none.

    The lamps are kept for ``gather_lamps``, and the intervals of a single one.
    """
    spans, found = spans_of(workspace), found_table(workspace)
    origin, direction = vec(path.origin), vec(path.direction)
    t_exit = 0.0
    path.found = 0
    candidates = lamps_along(block, workspace, origin, direction, path.t_max, path.kind)
    for index in range(candidates):
        lamp = found[index]
        if not counts(block, workspace, lamp):
            continue
        count = lamps.trace(block, lamp, origin, direction, spans)
        path.kept, path.kept_count = lamp, count
        if count > 0:
            t_exit = max(t_exit, spans[count - 1, 0] + spans[count - 1, 1])
            found[path.found] = lamp
            path.found += 1
    if candidates > 1:
        path.kept = -1
    return t_exit


@kernel
def gather_lights(block, workspace, t_to):
    """Add Blender lights of finite size that the path's ray meets before ``t_to``."""
    path = path_table(workspace)[0]
    hits = hit_table(workspace)
    origin, direction = vec(path.origin), vec(path.direction)
    count = lights.light_hits(block, path.light_tree, origin, direction, t_to, path.kind, hits)
    for index in range(count):
        hit = hits[index]
        if hit.distance <= path.t_min:
            continue
        weight = _mis(block, workspace, hit.emitter, hit.pdf)
        radiance = vec(hit.radiance)
        if block.emission_graphs:
            radiance = modulated(block, workspace, hit.emitter, radiance, origin, direction, hit.distance, path.kind)
        if block.has_media and inside_table(workspace)[0].count > 0:
            radiance = mul(radiance, media.fade(block, workspace, hit.distance))
        contribute(block, workspace, radiance, weight, hit.emitter, path.bounce)


@kernel
def gather_world(block, workspace):
    """Add the background, and end the path in the alpha channel."""
    path = path_table(workspace)[0]
    hidden = path.kind == CAMERA and block.transparent_film != 0
    if hidden:
        subtract_alpha(workspace, 1.0)
        if not block.shows_environment:
            return
    world = lights.world_emitter(block)
    if not lights.visibility(block, world) & path.kind:
        return
    direction = vec(path.direction)
    radiance = lights.world_radiance(block, direction)
    if block.emission_graphs:
        radiance = modulated(block, workspace, world, radiance, vec(path.origin), direction, np.inf, path.kind)
    if is_zero(radiance):  # that of materials may be negative, as in Cycles
        return
    if hidden:  # from Combined alone
        show_environment(workspace, radiance)
        return
    pdf = 0.0
    if path.pdf > 0.0:
        if _missed_by_light_rays(block, path, world):
            pdf = lights.pdf_in_cycles(block, vec(path.origin), direction)
        else:
            pdf = lights.world_pdf(block, vec(path.origin), vec(path.normal), direction)
    contribute(block, workspace, radiance, _mis(block, workspace, world, pdf), world, path.bounce)


@kernel
def gather_surface(block, workspace):
    """Add the emission of the surface that was hit."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    radiance = vec(surface.emission)
    if is_zero(radiance) or not lights.emission_is_linked(block, path.light_tree, surface.instance):
        return
    weight = 1.0
    if path.pdf > 0.0 or block.light_paths:
        emitter = lights.triangle_emitter(block, surface.instance, surface.primitive)
        if emitter >= 0:
            radiance = leave_connected(block, path, radiance, emitter)
            if path.pdf > 0.0:
                pdf = lights.triangle_pdf(block, vec(path.origin), emitter, vec(path.direction), path.length)
                weight = _mis(block, workspace, emitter, pdf)
    contribute(block, workspace, radiance, weight, of_instance(surface.instance), path.bounce)
