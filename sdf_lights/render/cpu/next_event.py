# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Next event estimation: one ray from a surface towards one emitter, weighed against the rays that scatter there.

Veach 1997, chapter 9, for the weights.
"""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...emitter import cut as cuts
from ...emitter import cut_points
from ...jit import kernel
from ...vec import largest, length, mul, negate, scale, vec
from ..scene import Ray
from . import lights
from .geometry import find_surface, surface_table
from .path import LIGHT_SET, contribute, path_table
from .rays import intersect
from .sampler import draw4
from .shading import evaluate, has_lobes, shade, transmits
from .shading.records import DIFFUSE, GLOSSY, TRANSMISSION
from .visibility import BLACK, OFFSET, aim, leave, step_size, transmittance, visible_lamp
from .workspace import aside_table, box_table, cut_of, light_cut_of, region_table, spans_of

SCATTERED = DIFFUSE | GLOSSY | TRANSMISSION
ANY = int(Ray.ALL)


@kernel
def competes(block, emitter):
    """Whether rays that scatter in any way can meet the emitter, so that both estimates share its light by MIS.

    One that is hidden from some kinds of rays is left to light sampling, and to singular scattering.
    """
    return lights.visibility(block, emitter) & SCATTERED == SCATTERED


@kernel
def shade_triangle(block, workspace, start, wi, distance):
    """Radiance (RGB) of a textured emissive triangle, shaded where the ray meets it."""
    aside = aside_table(workspace)[0]
    if not intersect(block, aside, start, wi, 0.0, distance * (1.0 + OFFSET) + 8.0 * step_size(start), ANY):
        return BLACK
    find_surface(block, aside, negate(wi), DIFFUSE, 0.0)
    shade(block, aside)
    return vec(surface_table(aside)[0].emission)


@kernel
def facing(path, n):
    """The normal by which emitters are chosen: none where light counts that falls on either side."""
    return BLACK if path.both else n


@kernel
def prepare_lamp(block, workspace, lamp, chance, x, n):
    """Make the workspace's cut that of the lamp, which is chosen with probability ``chance``, for the point x with normal n,
    where the path is lit."""
    cut, path = cut_of(workspace), path_table(workspace)[0]
    if block.lamp_cuts and path.scattered > 0:
        cut_points.project_afar(block, lamp, x, path.lobes, cut)
    elif block.lamp_cuts:
        cuts.prepare(block, lamp, x, n, path.both, path.lobes, cuts.tolerance_for(chance), cuts.LIMIT,
                     region_table(workspace), box_table(workspace), cut)
    elif block.lamp_slot < cuts.PROJECTION:
        cuts.compare(lamp, x, block.lamp_slot, block.lamp_beta, cut)
    else:
        cut.lamp, cut.slot, cut.points, cut.beta = lamp, cuts.PROJECTION, 0, block.lamp_beta


@kernel
def renew_lamp(block, workspace, lamp):
    """Make the workspace's cut that of the lamp for the point where the path scattered last, unless it is."""
    path = path_table(workspace)[0]
    if cut_of(workspace).lamp != lamp:
        origin, normal = vec(path.origin), vec(path.normal)
        chance = lights.selection_probability(block, origin, facing(path, normal), lamp, light_cut_of(workspace))
        prepare_lamp(block, workspace, lamp, chance, origin, normal)


@kernel
def rival_density(cut, pdf, narrow):
    """What the density of a BSDF counts against that of a cut.

    The cut follows the cosine, so it needs little help with broad lobes. It knows nothing of those of microfacets.
    """
    return cut.beta * (pdf - narrow) + max(cut.beta, 1.0) * narrow


@kernel
def light_lamp(block, workspace, lamp, chance, u, u1, u2, u3):
    """One ray towards a lamp that was chosen with probability ``chance``."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    x, n = vec(surface.position), vec(surface.n)
    spans, cut, store = spans_of(workspace), cut_of(workspace), box_table(workspace)
    prepare_lamp(block, workspace, lamp, chance, x, n)
    if cut.beta == np.inf:
        return
    if cut.points:
        way, intensity = cut_points.sample_point(block, lamp, x, store, cut, u1, u2, u3)
        distance = length(way)
        if distance <= 0.0 or largest(intensity) <= 0.0:
            return
        wi = scale(way, 1.0 / distance)
        weight, _, _ = evaluate(workspace, wi)
        if largest(weight) <= 0.0:
            return
        start = leave(x, vec(surface.ng), wi)
        to_point, reach = aim(x, start, wi, distance)
        weight = mul(weight, transmittance(block, workspace, start, to_point, reach))
        if largest(weight) > 0.0:
            contribute(
                block, workspace, mul(weight, intensity), 1.0 / (chance * distance * distance), True, path.bounce + 1)
        return
    wi = cuts.sample(block, lamp, x, spans, store, cut, u1, u2, u3)
    weight, pdf, narrow = evaluate(workspace, wi)
    if largest(weight) <= 0.0:
        return
    count = lamps.trace(block, lamp, x, wi, spans)
    if count == 0:
        return
    rival = rival_density(cut, pdf, narrow) if competes(block, lamp) else 0.0
    both = chance * cuts.density(block, lamp, wi, store, cut, spans, count) + rival
    radiance = visible_lamp(block, workspace, lamp, x, wi, spans, count, leave(x, vec(surface.ng), wi), u)
    if largest(radiance) > 0.0:
        contribute(block, workspace, mul(weight, radiance), 1.0 / both, True, path.bounce + 1)


@kernel
def light_vertex(block, workspace):
    """Next event estimation at ``workspace.surface``: one ray towards one emitter."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    x, n, ng = vec(surface.position), vec(surface.n), vec(surface.ng)
    path.both, path.lobes, path.scattered = int(transmits(workspace)), int(has_lobes(workspace)), path.bounce
    cut_of(workspace).lamp = -1
    u = draw4(path.index, path.seed, path.dimension + LIGHT_SET)
    emitter, chance, u0 = lights.select(block, x, facing(path, n), u[0], light_cut_of(workspace))
    if chance <= 0.0:
        return
    scatters = path.bounce + 1
    if emitter < block.lamp_count:
        light_lamp(block, workspace, emitter, chance, u0, u[1], u[2], u[3])
        return
    wi, distance, radiance, pdf, singular = lights.sample_light(block, emitter, x, n, u[1], u[2])
    if pdf <= 0.0 or largest(radiance) <= 0.0:
        return
    weight, scatter_pdf, _ = evaluate(workspace, wi)
    if largest(weight) <= 0.0:
        return
    start = leave(x, ng, wi)
    if lights.casts_shadow(block, emitter):
        to_light, reach = aim(x, start, wi, distance)
        weight = mul(weight, transmittance(block, workspace, start, to_light, reach))
        if largest(weight) <= 0.0:
            return
    if lights.triangle_textured(block, emitter):
        radiance = shade_triangle(block, workspace, start, wi, distance)
    radiance = mul(weight, radiance)
    if singular or not competes(block, emitter):
        scatter_pdf = 0.0
    contribute(block, workspace, radiance, 1.0 / (chance * pdf + scatter_pdf), False, scatters)
