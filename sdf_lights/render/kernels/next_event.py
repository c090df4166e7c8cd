# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Next event estimation: one ray from a surface towards one emitter, weighed against the rays that scatter there.

Veach 1997, chapter 9, for the weights.
"""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...emitter.sampling import cut as cuts
from ...emitter.sampling import cut_points, external
from ...emitter.sampling.strategies import BOXES, EXTERNAL, NO_LIGHT_RAYS, WHOLE_RAYS
from ...jit import kernel
from ...replaced import replaced_on_gpu
from ...vec import dot, is_zero, largest, length, mul, negate, scale, vec
from . import lights
from .caustic_paths.lobes import is_source, left_by_lobe
from .emission_graphs import NO_RAY, modulated
from .geometry import surface_at, surface_table
from .light_paths import dispatch as light_paths
from .light_paths.records import source_table as light_path_sources
from .media import dispatch as media
from .outputs import dispatch as outputs
from .outputs.records import LOBES
from .outputs.state import LIGHT_RAY
from .path import BEYOND, LIGHT_SET, MIXED, contribute, path_table, put_depths, sample_table
from .path_reuse import dispatch as path_reuse
from .path_reuse.records import BY_LAMP, BY_LIGHT, arrival_table
from .samplers import get_4d
from .shading import evaluate, has_lobes, shade, transmits
from .shading.records import SCATTERED
from .terminator import light_start
from .visibility import BLACK, shadow_ray, transmittance, visible_lamp
from .workspace import box_table, cut_of, light_cut_of, region_table, secondary_table, spans_of


@kernel
def mis_applies(block, emitter):
    """Whether rays that scatter in any way can meet the emitter, so that both estimates share its light by MIS.

    One that is hidden from some kinds of rays is left to light sampling, and to singular scattering; so is one whose
    shadows not all cast.
    """
    return lights.can_be_hit(block, emitter, SCATTERED)


@kernel
def shade_triangle(block, workspace, emitter, x, wi, distance):
    """Radiance (RGB) of a textured emissive triangle, shaded where the ray from x along wi meets it: transparent
    surfaces may be in front of it."""
    secondary = secondary_table(workspace)[0]
    surface = surface_table(secondary)[0]
    instance, primitive, u, v = lights.triangle_point(block, x, emitter, wi)
    surface_at(block, surface, np.int64(instance), np.int64(primitive), u, v, negate(wi), NO_RAY, 0.0)
    surface.ray_length = distance
    surface.ray_singular = 0
    put_depths(path_table(workspace)[0], surface)
    shade(block, secondary)
    return vec(surface.emission)


@kernel
def selection_normal(path, n):
    """The normal by which emitters are chosen: none where light counts that falls on either side."""
    return BLACK if path.two_sided else n


@replaced_on_gpu
@kernel
def prepare_lamp_cut(block, workspace, lamp, pmf, x, n):
    """Make the cut of the workspace that of a lamp, chosen with probability ``pmf``, for the lit point x with normal
    n."""
    cut, path = cut_of(workspace), path_table(workspace)[0]
    if block.lamp_strategy != BOXES:
        cut.lamp, cut.strategy, cut.points = lamp, block.lamp_strategy, WHOLE_RAYS
        cut.bsdf_mis_scale = block.lamp_bsdf_mis_scale
    elif path.scattered > 0:
        cut_points.project_afar(block, lamp, x, path.has_glossy, cut)
    else:
        sample_table(workspace)[0].cuts += 1 - sample_table(workspace)[0].divided
        cuts.prepare(
            block,
            lamp,
            x,
            n,
            path.two_sided,
            path.has_glossy,
            cuts.tolerance_for(pmf),
            cuts.LIMIT,
            region_table(workspace),
            box_table(workspace),
            cut,
        )


@replaced_on_gpu
@kernel
def restore_lamp_cut(block, workspace, lamp):
    """Make the workspace's cut that of the lamp for the point where the path scattered last, unless it is."""
    path = path_table(workspace)[0]
    if cut_of(workspace).lamp != lamp:
        origin, normal = vec(path.origin), vec(path.normal)
        pmf = lights.selection_probability(
            block, path.light_tree, origin, selection_normal(path, normal), lamp, light_cut_of(workspace)
        )
        prepare_lamp_cut(block, workspace, lamp, pmf, origin, normal)


@kernel
def lamp_direction(block, workspace, lamp, x, u1, u2, u3):
    """Unit direction from x to the lamp, by the workspace's cut; its density is ``lamp_pdf``."""
    if block.lamp_strategy == EXTERNAL:
        return external.sample(block, workspace, lamp, x, u1, u2, u3)
    return cuts.sample(block, lamp, x, box_table(workspace), cut_of(workspace), u1, u2, u3)


@kernel
def lamp_pdf(block, workspace, lamp, x, d, count):
    """Density per solid angle of ``lamp_direction`` giving d, from the ``count`` intervals of that ray in the
    workspace."""
    if block.lamp_strategy == EXTERNAL:
        return external.density(block, workspace, lamp, x, d, count)
    return cuts.density(block, lamp, d, box_table(workspace), cut_of(workspace), spans_of(workspace), count)


@kernel
def bsdf_mis_pdf(cut, pdf, glossy_pdf):
    """What the density of a BSDF counts against that of a cut.

    The cut follows the cosine, so it needs little help with broad lobes. It knows nothing of those of microfacets.
    """
    return cut.bsdf_mis_scale * (pdf - glossy_pdf) + max(cut.bsdf_mis_scale, 1.0) * glossy_pdf


@kernel
def record_scattering_lobes(block, workspace, wi, emitter):
    """Tell passes which lobes scatter the light of a light ray along wi, where it is the first to scatter it."""
    if block.outputs & LOBES and path_table(workspace)[0].bounce == 0:
        outputs.divide(block, workspace, wi, 0, lights.visibility(block, emitter), LIGHT_RAY)


@kernel
def leave_to_connections(block, workspace, wi, emitter):
    """Leave to connections what they estimate of the light of a light ray along wi, where they do so."""
    if block.light_paths and path_table(workspace)[0].connects == BEYOND and light_path_sources(block)[emitter]:
        light_paths.record_connected(block, workspace, wi)


@kernel
def scattered(block, workspace, wi, kinds, emitter):
    """``shading.evaluate`` for a light ray: of all paths that share the surface, if they do; and of the light of lamps,
    what caustic paths leave."""
    path, ray = path_table(workspace)[0], BY_LIGHT
    if block.caustic_paths and path.caustic == 1 and path.lines > 0.0:
        ray = BY_LAMP if is_source(block, emitter) else BY_LIGHT
    if block.reuses_paths and path.reused == MIXED:
        return path_reuse.evaluate_arrival(block, workspace, wi, kinds, ray)
    value, pdf, glossy_pdf = evaluate(block, workspace, wi, kinds)
    if ray == BY_LAMP:
        value = scale(value, left_by_lobe(workspace, path.lines, path.lamp_pdf, pdf, path.rival))
    return value, pdf, glossy_pdf


@kernel
def begin_light_ray(block, workspace, n, wi):
    """Tell the media that a light ray starts at the surface along wi. Below its shading normal n is inside, as in
    Cycles: smooth surfaces are lit from directions below their triangles, too."""
    media.bounds(block, workspace, media.LOOK_THROUGH if dot(n, wi) < 0.0 else media.LOOK)


@replaced_on_gpu
@kernel
def sample_lamp_light(block, workspace, lamp, pmf, u, u1, u2, u3):
    """One ray towards a lamp that was chosen with probability ``pmf``."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    x, n = vec(surface.position), vec(surface.n)
    spans, cut, store = spans_of(workspace), cut_of(workspace), box_table(workspace)
    prepare_lamp_cut(block, workspace, lamp, pmf, x, n)
    if cut.strategy == NO_LIGHT_RAYS:
        return
    if cut.points != WHOLE_RAYS:
        way, intensity = cut_points.sample_point(block, lamp, x, store, cut, u1, u2, u3)
        distance = length(way)
        if distance <= 0.0 or largest(intensity) <= 0.0:
            return
        wi = scale(way, 1.0 / distance)
        weight, _, _ = scattered(block, workspace, wi, lights.visibility(block, lamp), lamp)
        if largest(weight) <= 0.0:
            return
        start = light_start(block, workspace, wi)
        if block.has_media:
            begin_light_ray(block, workspace, n, wi)
        to_point, t_max = shadow_ray(x, start, wi, distance)
        weight = mul(weight, transmittance(block, workspace, start, to_point, t_max, lights.blockers(block, lamp)))
        if not is_zero(weight):
            record_scattering_lobes(block, workspace, wi, lamp)
            leave_to_connections(block, workspace, wi, lamp)
            contribute(
                block, workspace, mul(weight, intensity), 1.0 / (pmf * distance * distance), lamp, path.bounce + 1
            )
        return
    wi = lamp_direction(block, workspace, lamp, x, u1, u2, u3)
    weight, pdf, glossy_pdf = scattered(block, workspace, wi, lights.visibility(block, lamp), lamp)
    if largest(weight) <= 0.0:
        return
    count = lamps.trace(block, lamp, x, wi, spans)
    if count == 0:
        return
    rival = bsdf_mis_pdf(cut, pdf, glossy_pdf) if mis_applies(block, lamp) else 0.0
    pdf_sum = pmf * lamp_pdf(block, workspace, lamp, x, wi, count) + rival
    if block.has_media:
        begin_light_ray(block, workspace, n, wi)
    radiance = visible_lamp(block, workspace, lamp, x, wi, spans, count, light_start(block, workspace, wi), u)
    if not is_zero(radiance):
        record_scattering_lobes(block, workspace, wi, lamp)
        leave_to_connections(block, workspace, wi, lamp)
        contribute(block, workspace, mul(weight, radiance), 1.0 / pdf_sum, lamp, path.bounce + 1)


@kernel
def sample_direct_light(block, workspace):
    """Next event estimation at ``workspace.surface``: one ray towards one emitter."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    x, n = vec(surface.position), vec(surface.n)
    path.two_sided, path.has_glossy, path.scattered = int(transmits(workspace)), int(has_lobes(workspace)), path.bounce
    if block.reuses_paths and path.reused == MIXED:
        path.two_sided, path.has_glossy = arrival_table(workspace)[0].two_sided, arrival_table(workspace)[0].has_glossy
    path.light_tree = lights.tree_of(block, surface.instance)
    cut_of(workspace).lamp = -1
    u = get_4d(path.index, path.seed, path.dimension + LIGHT_SET)
    emitter, pmf, u0 = lights.select(
        block, path.light_tree, x, selection_normal(path, n), u[0], light_cut_of(workspace)
    )
    if pmf <= 0.0 or not lights.may_light(block, emitter, path.bounce):
        return
    scatters = path.bounce + 1
    if emitter < block.lamp_count:
        sample_lamp_light(block, workspace, emitter, pmf, u0, u[1], u[2], u[3])
        return
    if lights.is_this_triangle(block, emitter, surface.instance, surface.primitive):
        return  # a plane does not light itself, but for the rounding of x it would
    wi, distance, radiance, pdf, singular = lights.sample_light(block, emitter, x, n, u[1], u[2])
    if pdf <= 0.0 or largest(radiance) <= 0.0:
        return
    weight, scatter_pdf, _ = scattered(block, workspace, wi, lights.visibility(block, emitter), emitter)
    if largest(weight) <= 0.0:
        return
    start = light_start(block, workspace, wi)
    if lights.casts_shadow(block, emitter):
        if block.has_media:
            begin_light_ray(block, workspace, n, wi)
        to_light, t_max = shadow_ray(x, start, wi, distance)
        weight = mul(weight, transmittance(block, workspace, start, to_light, t_max, lights.blockers(block, emitter)))
        if is_zero(weight):
            return
    if lights.triangle_textured(block, emitter):
        radiance = shade_triangle(block, workspace, emitter, x, wi, distance)
    elif block.emission_graphs:
        radiance = modulated(block, workspace, emitter, radiance, x, wi, distance, NO_RAY)
    radiance = mul(weight, radiance)
    if singular or not mis_applies(block, emitter):
        scatter_pdf = 0.0
    record_scattering_lobes(block, workspace, wi, emitter)
    leave_to_connections(block, workspace, wi, emitter)
    contribute(block, workspace, radiance, 1.0 / (pmf * pdf + scatter_pdf), emitter, scatters)
