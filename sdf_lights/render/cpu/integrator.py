# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer: camera to film, with next event estimation and BSDF sampling joined by the balance heuristic.

Each emitter (an SDF lamp, a Blender light, an emissive triangle, the world) is an integral of its own over the sphere
of directions. It is estimated twice at every vertex of a path: once by a ray towards a point of an emitter that
``lights.select`` drew, once by the ray that continues the path, which adds the line integral of every lamp it crosses
before its hit (Huang et al. 2026, equations 1 and 2). Veach 1997, chapter 9, for the weights.
"""

from __future__ import annotations

import math

import numpy as np

from ... import emitter as lamps
from ...emitter import cut as cuts
from ...jit import block_dtype, kernel, table
from ...vec import add, average, dot, largest, length, madd, mul, negate, put, scale, sub, vec
from ..scene import Ray
from . import lights
from .accumulate import add_sample, branches_before, branches_of, is_active, pixel_index, samples_due
from .camera import camera_ray, filter_offset, view_depth
from .geometry import find_shadow_surface, find_surface, instance_table, shading_material_table, surface_table
from .lamp_tree import WORKSPACE_TABLES as LAMP_TREE_TABLES
from .lamp_tree import found_table, lamps_along
from .path import FIRST_BRANCH, FIRST_BRANCH_RAY, TABLES, WAITING, clear_sample, contribute, path_table, sample_table
from .rays import RAY, SHADOW_OPAQUE, SHADOW_TRANSPARENT, intersect, occluded, ray_table
from .sampler import draw1, draw2, draw3, draw4, pixel_seed
from .shading import evaluate, sample as sample_surface, shade, transmits, transparency
from .shading.records import WORKSPACE_TABLES as SHADING_TABLES
from .shading.records import DIFFUSE, GLOSSY, HAS_TRANSPARENCY, SINGULAR, TRANSMISSION, TRANSPARENT

CAMERA, ANY = int(Ray.CAMERA), int(Ray.ALL)
SCATTERED = DIFFUSE | GLOSSY | TRANSMISSION

SCALARS = [
    ("seed", np.int64), ("max_bounces", np.int64), ("diffuse_bounces", np.int64), ("glossy_bounces", np.int64),
    ("transmission_bounces", np.int64), ("transparent_bounces", np.int64), ("clamp_direct", np.float64),
    ("clamp_indirect", np.float64), ("caustics", np.int64), ("transparent_film", np.int64),
    ("emitters_hit", np.int64),  # 1: rays can meet emission other than that of SDF lamps
    ("transparent_shadows", np.int64), ("lamp_count", np.int64),
    ("finite_lights", np.int64),  # 1: there are Blender lights that rays can meet
    ("lamp_cuts", np.int64),  # 1: lamps are sampled by cuts
    ("lamp_slot", np.int64),  # without cuts: ``cuts.PROJECTION``, ``SURFACE`` or ``BOUNDING``
    ("lamp_beta", np.float64),  # without cuts: what the density of a BSDF counts in the balance heuristic
]

# Sets of random numbers: two for the camera, then so many for each vertex of a path.
CAMERA_SETS, VERTEX_SETS = 2, 4
LIGHT_SET, SCATTER_SET, ROULETTE_SET, EMISSION_SET = range(4)

# Relative step off a surface: some tens of float32 roundings, as Embree sees the scene in float32.
OFFSET = 2.0**-18
FIRST_ROULETTE = 3  # bounces: chance disturbs the even spread of samples more than the paths before that cost

LEAST_SURVIVAL = 0.1  # of a branch: estimates know nothing of what shadows, and of light by other ways

BLACK = (0.0, 0.0, 0.0)

ENDS, GOES_ON, DIVIDES = range(3)  # what becomes of a path at a surface

WORKSPACE_TABLES = {
    "ray": RAY, "spans": np.dtype(np.float64), "light_hits": lights.HIT, **lights.WORKSPACE_TABLES, **TABLES,
    **SHADING_TABLES, **cuts.WORKSPACE_TABLES, **LAMP_TREE_TABLES}
# ``aside`` is a second workspace, to shade what a light ray has hit while the path's own surface waits.
WORKSPACE = block_dtype({**WORKSPACE_TABLES, "aside": None})

control_table = table("control", np.int64)
span_table = table("spans", np.float64)
hit_table = table("light_hits", lights.HIT)
aside_table = table("aside", WORKSPACE)
region_table = table("lamp_regions", cuts.KEYS)
box_table = table("lamp_boxes", cuts.BOXES)
cut_table = table("lamp_cuts", cuts.CUT)


@kernel
def spans_of(workspace):
    """Scratch rows (c, h) for the intervals of a lamp along a ray."""
    flat = span_table(workspace)
    return flat.reshape(len(flat) // 2, 2)


@kernel
def step_size(position):
    return max(abs(position[0]), abs(position[1]), abs(position[2]), 1e-3) * OFFSET


@kernel
def leave(position, ng, direction):
    """``position`` moved off its surface to the side of ``direction``."""
    size = step_size(position)
    return madd(position, size if dot(ng, direction) > 0.0 else -size, ng)


@kernel
def aim(x, start, wi, distance):
    """Direction and length of a shadow ray from ``start`` to just before the point at ``distance`` from x along wi.

    From x itself it would end before that point; from a start beside x, along the same direction, it could end behind
    the surface of an emissive triangle and be shadowed by the light.
    """
    if distance == np.inf:
        return wi, np.inf
    target = madd(x, distance, wi)
    way = sub(target, start)
    reach = length(way)
    if reach <= 0.0:
        return wi, 0.0
    return scale(way, 1.0 / reach), max(reach * (1.0 - OFFSET) - 4.0 * step_size(target), 0.0)


@kernel
def transmittance(block, workspace, start, direction, t_max):
    """Part of the light (RGB) that comes to ``start`` from ``t_max`` along ``direction``, past transparent surfaces."""
    if occluded(block, workspace, start, direction, 0.0, t_max, SHADOW_OPAQUE):
        return BLACK
    result = (1.0, 1.0, 1.0)
    if block.transparent_shadows:
        t_min = 0.0
        for _ in range(block.transparent_bounces + 1):
            if not intersect(block, workspace, start, direction, t_min, t_max, SHADOW_TRANSPARENT):
                return result
            result = mul(result, _pass_through(block, workspace, direction))
            if largest(result) <= 0.0:
                return BLACK
            t_min = _beyond(ray_table(workspace)[0].t_far)
        return BLACK
    return result


@kernel
def _pass_through(block, workspace, direction):
    """Transparency (RGB) of the surface that a shadow ray has hit."""
    material = find_shadow_surface(block, workspace, negate(direction))
    if shading_material_table(block)[material].flags & HAS_TRANSPARENCY:
        return transparency(block, workspace)
    return BLACK


@kernel
def _beyond(t_hit):
    return t_hit + max(abs(t_hit), 1e-3) * OFFSET


@kernel
def visible_lamp(block, workspace, lamp, x, direction, spans, count, start, u):
    """Radiance (RGB) of a lamp along a ray from x, as far as no surface hides it: surfaces may stand inside a lamp.

    ``start`` is x moved off its surface; u is for ``lamps.radiance``.
    """
    t_end = spans[count - 1, 0] + spans[count - 1, 1]
    total, weight, t_from = BLACK, (1.0, 1.0, 1.0), 0.0
    for _ in range(block.transparent_bounces + 1):
        mask = SHADOW_OPAQUE | SHADOW_TRANSPARENT if block.transparent_shadows else SHADOW_OPAQUE
        found = intersect(block, workspace, start, direction, t_from, t_end, mask)
        t_to = float(ray_table(workspace)[0].t_far) if found else t_end
        total = add(total, mul(weight, lamps.radiance(block, lamp, x, direction, spans, count, t_from, t_to, u)))
        if not found or not block.transparent_shadows:
            break
        weight = mul(weight, _pass_through(block, workspace, direction))
        if largest(weight) <= 0.0:
            break
        t_from = _beyond(t_to)
    return total


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
def cut_of(workspace):
    """The cut of the surface where the path scattered last; that of the first one is kept, for all branches."""
    return cut_table(workspace)[1 if path_table(workspace)[0].scattered > 0 else 0]


@kernel
def light_cut_of(workspace):
    """As ``cut_of``: the cut of the light tree."""
    return lights.light_cut_table(workspace)[1 if path_table(workspace)[0].scattered > 0 else 0]


@kernel
def prepare_lamp(block, workspace, lamp, chance, x, n, both):
    """Make the workspace's cut that of the lamp, which is chosen with probability ``chance``, for the point x with normal n."""
    cut = cut_of(workspace)
    if block.lamp_cuts and path_table(workspace)[0].scattered > 0:
        cuts.project(block, lamp, x, cut)
    elif block.lamp_cuts:
        cuts.prepare(block, lamp, x, n, both, cuts.tolerance_for(chance), cuts.LIMIT, region_table(workspace),
                     box_table(workspace), cut)
    elif block.lamp_slot < cuts.PROJECTION:
        cuts.compare(lamp, x, block.lamp_slot, block.lamp_beta, cut)
    else:
        cut.lamp, cut.slot, cut.beta = lamp, cuts.PROJECTION, block.lamp_beta


@kernel
def renew_lamp(block, workspace, lamp):
    """Make the workspace's cut that of the lamp for the point where the path scattered last, unless it is."""
    path = path_table(workspace)[0]
    if cut_of(workspace).lamp != lamp:
        origin, normal = vec(path.origin), vec(path.normal)
        chance = lights.selection_probability(block, origin, facing(path, normal), lamp, light_cut_of(workspace))
        prepare_lamp(block, workspace, lamp, chance, origin, normal, path.both)


@kernel
def _rival(cut, pdf, narrow):
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
    prepare_lamp(block, workspace, lamp, chance, x, n, path.both)
    if cut.beta == np.inf:
        return
    if cut.slot == cuts.POINT:
        way = lamps.way_inside(block, lamp, x, u1, u2, u3)
        distance = length(way)
        wi = scale(way, 1.0 / distance)
    else:
        wi, distance = cuts.sample(block, lamp, x, spans, store, cut, u1, u2, u3), 0.0
    weight, pdf, narrow = evaluate(workspace, wi)
    if largest(weight) <= 0.0:
        return
    if distance > 0.0 and narrow == 0.0:
        # No ray of the BSDF competes, so no intervals are needed: the point is a light by itself.
        start = leave(x, vec(surface.ng), wi)
        to_point, reach = aim(x, start, wi, distance)
        weight = mul(weight, transmittance(block, workspace, start, to_point, reach))
        if largest(weight) > 0.0:
            contribute(block, workspace, mul(weight, lamps.intensity(block, lamp)), 1.0 / (chance * distance * distance),
                       True, path.bounce + 1)
        return
    count = lamps.trace(block, lamp, x, wi, spans)
    if count == 0:
        return
    rival = _rival(cut, pdf, narrow) if competes(block, lamp) else 0.0
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
    path.both, path.scattered = int(transmits(workspace)), path.bounce
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


@kernel
def _mis(block, workspace, emitter, pdf):
    """Weight of emission met by a ray: balance heuristic against light sampling where the path last scattered.

    Paths from the camera and from singular scattering have pdf 0: nothing else can find that emission.
    """
    path = path_table(workspace)[0]
    if path.pdf <= 0.0:
        return 1.0
    if not competes(block, emitter):
        return 0.0
    chance = lights.selection_probability(
        block, vec(path.origin), facing(path, vec(path.normal)), emitter, light_cut_of(workspace))
    return path.pdf / (path.pdf + chance * pdf)


@kernel
def _lamp_mis(block, workspace, lamp, spans, count):
    """As ``_mis``, for a lamp: against the cut where the path last scattered."""
    path = path_table(workspace)[0]
    if path.pdf <= 0.0:
        return 1.0
    if not competes(block, lamp):
        return 0.0
    cut = cut_of(workspace)
    origin, normal = vec(path.origin), vec(path.normal)
    renew_lamp(block, workspace, lamp)
    if cut.beta == np.inf:
        return 1.0
    chance = lights.selection_probability(
        block, origin, facing(path, normal), lamp, light_cut_of(workspace))
    density = cuts.density(block, lamp, vec(path.direction), box_table(workspace), cut, spans, count)
    rival = _rival(cut, path.pdf, path.narrow)
    return rival / (rival + chance * density) if rival > 0.0 else 0.0


@kernel
def counts(block, workspace, lamp):
    """Whether a lamp that the path's ray may cross counts there: at broad lobes the cut may be all that is needed."""
    path = path_table(workspace)[0]
    if path.pdf <= 0.0 or path.narrow > 0.0:
        return True
    cut = cut_of(workspace)
    renew_lamp(block, workspace, lamp)
    return cut.beta > 0.0 and competes(block, lamp)


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
        u = draw1(path.index, path.seed, path.dimension + EMISSION_SET) if lamps.varies(block, lamp) else 0.5
        radiance = lamps.radiance(block, lamp, origin, direction, spans, count, path.t_min, t_to, u)
        if largest(radiance) <= 0.0:
            continue
        contribute(block, workspace, radiance, _lamp_mis(block, workspace, lamp, spans, count), True, path.bounce)


@kernel
def lamp_reach(block, workspace, path):
    """Distance at which the path's ray leaves the last lamp that it crosses; 0 if it crosses none.

    The lamps are kept for ``gather_lamps``, and the intervals of a single one.
    """
    spans, found = spans_of(workspace), found_table(workspace)
    origin, direction = vec(path.origin), vec(path.direction)
    reach = 0.0
    path.found = 0
    candidates = lamps_along(block, workspace, origin, direction, path.t_max, path.kind)
    for index in range(candidates):
        lamp = found[index]
        if not counts(block, workspace, lamp):
            continue
        count = lamps.trace(block, lamp, origin, direction, spans)
        path.kept, path.kept_count = lamp, count
        if count > 0:
            reach = max(reach, spans[count - 1, 0] + spans[count - 1, 1])
            found[path.found] = lamp
            path.found += 1
    if candidates > 1:
        path.kept = -1
    return reach


@kernel
def gather_lights(block, workspace, t_to):
    """Add Blender lights of finite size that the path's ray meets before ``t_to``."""
    path = path_table(workspace)[0]
    hits = hit_table(workspace)
    origin, direction = vec(path.origin), vec(path.direction)
    count = lights.light_hits(block, origin, direction, t_to, path.kind, hits)
    for index in range(count):
        hit = hits[index]
        if hit.distance <= path.t_min:
            continue
        weight = _mis(block, workspace, hit.emitter, hit.pdf)
        contribute(block, workspace, vec(hit.radiance), weight, False, path.bounce)


@kernel
def uncover(workspace, part):
    """Take from the sample's alpha what the camera sees through to nothing."""
    sample = sample_table(workspace)[0]
    alpha = sample.alpha - part * average(vec(path_table(workspace)[0].throughput))
    sample.alpha = alpha if alpha > 1e-12 else 0.0  # three thirds may round to less than one


@kernel
def gather_world(block, workspace):
    """Add the background, and end the path in the alpha channel."""
    path = path_table(workspace)[0]
    if path.kind == CAMERA and block.transparent_film:
        uncover(workspace, 1.0)
        return
    world = lights.world_emitter(block)
    if not lights.visibility(block, world) & path.kind:
        return
    direction = vec(path.direction)
    radiance = lights.world_radiance(block, direction)
    if largest(radiance) <= 0.0:
        return
    pdf = lights.world_pdf(block, vec(path.normal), direction) if path.pdf > 0.0 else 0.0
    contribute(block, workspace, radiance, _mis(block, workspace, world, pdf), False, path.bounce)


@kernel
def gather_surface(block, workspace):
    """Add the emission of the surface that was hit."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    radiance = vec(surface.emission)
    if largest(radiance) <= 0.0:
        return
    weight = 1.0
    if path.pdf > 0.0:
        emitter = lights.triangle_emitter(block, surface.instance, surface.primitive)
        if emitter >= 0:
            pdf = lights.triangle_pdf(block, vec(path.origin), emitter, vec(path.direction), path.length)
            weight = _mis(block, workspace, emitter, pdf)
    contribute(block, workspace, radiance, weight, False, path.bounce)


@kernel
def record_first_surface(block, workspace):
    """Data passes: the first surface that the camera sees and that is more solid than transparent."""
    sample = sample_table(workspace)[0]
    surface = surface_table(workspace)[0]
    sample.found = 1
    sample.depth = view_depth(block, vec(surface.position))
    for axis in range(3):
        sample.position[axis] = surface.position[axis]
        sample.normal[axis] = surface.n[axis]
        sample.albedo[axis] = surface.albedo[axis]
        sample.diffuse_albedo[axis] = surface.diffuse_albedo[axis]


@kernel
def _count_bounce(block, path, kind):
    """Count a bounce; once a limit is reached the next ray only gathers emission."""
    path.bounce += 1
    last = path.bounce > block.max_bounces
    if kind & DIFFUSE:
        path.diffuse += 1
        last = last or path.diffuse > block.diffuse_bounces
    elif kind & GLOSSY:
        path.glossy += 1
        last = last or path.glossy > block.glossy_bounces
    elif kind & TRANSMISSION:
        path.transmission += 1
        last = last or path.transmission > block.transmission_bounces
    path.last = last


@kernel
def scatter(block, workspace):
    """Continue the path from ``workspace.surface``. False if it ends there."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    u = draw3(path.index, path.seed, path.dimension + SCATTER_SET)
    wi, weight, pdf, narrow, kind = sample_surface(workspace, u[0], u[1], u[2])
    if pdf <= 0.0 or largest(weight) <= 0.0:
        return False
    throughput = scale(mul(vec(path.throughput), weight), 1.0 / pdf)
    if kind & TRANSPARENT:
        # The ray goes on as the same ray: its origin, pdf and kind stay, so MIS still compares what it should.
        path.transparent += 1
        if path.transparent > block.transparent_bounces:
            return False
        path.t_min = _beyond(path.length)
        put(path.throughput, throughput)
        return True
    if not block.caustics and path.diffuse > 0 and not kind & DIFFUSE:
        return False
    _count_bounce(block, path, kind)
    position = vec(surface.position)
    put(path.throughput, throughput)
    put(path.origin, position)
    put(path.normal, vec(surface.n))
    put(path.start, leave(position, vec(surface.ng), wi))
    put(path.direction, wi)
    path.t_min, path.t_max = 0.0, np.inf
    path.pdf = 0.0 if kind & SINGULAR else pdf
    path.narrow = narrow
    path.kind = kind & (DIFFUSE | GLOSSY | TRANSMISSION)
    return True


@kernel
def survives(path):
    """Russian roulette, by what the path can still carry.

    It comes after the lamps along the ray were gathered: they are half of an estimate whose other half is a light ray.
    """
    if path.bounce < FIRST_ROULETTE or path.last:
        return True
    survival = min(1.0, largest(vec(path.throughput)))
    if draw1(path.index, path.seed, path.dimension + ROULETTE_SET) >= survival:
        return False
    put(path.throughput, scale(vec(path.throughput), 1.0 / survival))
    return True


@kernel
def nothing_left(block, surface):
    """Whether no ray from here can find light, once only emission counts: all of it is left to light sampling."""
    return not block.emitters_hit and block.lamp_count == 0 and largest(vec(surface.transparency)) <= 0.0


@kernel
def start_path(block, workspace, x, y):
    """Camera ray through a point of the pixel drawn from the pixel filter."""
    path = path_table(workspace)[0]
    u = draw2(path.index, path.seed, 0)
    dx, dy = filter_offset(block, u[0], u[1])
    lens = draw2(path.index, path.seed, 1) if block.camera_aperture > 0.0 else (0.5, 0.5)
    origin, direction, t_min, t_max = camera_ray(block, x + 0.5 + dx, y + 0.5 + dy, lens[0], lens[1])
    put(path.origin, origin)
    put(path.start, origin)
    put(path.normal, BLACK)
    put(path.direction, direction)
    put(path.throughput, (1.0, 1.0, 1.0))
    path.t_min, path.t_max = t_min, t_max
    path.pdf = 0.0
    path.kind = CAMERA
    path.bounce = path.diffuse = path.glossy = path.transmission = path.transparent = path.last = 0
    path.dimension = CAMERA_SETS
    path.share, path.scattered = 1.0, 0
    path.kept = path.found = -1


@kernel
def trace_branches(block, workspace, x, y, branches, first_branch):
    """One sample of the pixel (x, y), in ``sample``. Its path divides into ``branches`` at the first surface that scatters
    light.

    What comes before is sampled once, and the branches, numbered from ``first_branch`` on, as evenly as all of a pixel.
    """
    paths, sample = path_table(workspace), sample_table(workspace)[0]
    sample.branches = branches
    start_path(block, workspace, x, y)
    if not follow(block, workspace, True):
        return
    sample.divided = 1
    put(sample.before, vec(sample.combined))
    put(sample.lamps_before, vec(sample.lamps))
    paths[WAITING] = paths[0]
    for branch in range(branches):
        paths[0] = paths[WAITING]
        paths[0].index, paths[0].share = first_branch + branch, 1.0 / branches
        paths[0].alive = int(scatter(block, workspace))
        paths[FIRST_BRANCH + branch] = paths[0]
    reach_branches(block, workspace, branches)
    choose_branches(workspace, branches)
    for branch in range(branches):
        if paths[FIRST_BRANCH + branch].alive:
            paths[0] = paths[FIRST_BRANCH + branch]
            ray_table(workspace)[0] = ray_table(workspace)[FIRST_BRANCH_RAY + branch]
            cut_table(workspace)[1].lamp = -1  # the branch before has left one of another point there
            if turn(block, workspace, False) == GOES_ON:
                follow(block, workspace, False)


@kernel
def reach_branches(block, workspace, branches):
    """Follow all branches to the next surface, and estimate what they promise to bring from there."""
    paths, rays = path_table(workspace), ray_table(workspace)
    for branch in range(branches):
        if not paths[FIRST_BRANCH + branch].alive:
            continue
        paths[0] = paths[FIRST_BRANCH + branch]
        path = paths[0]
        path.dimension += VERTEX_SETS
        path.alive = int(expects(block, workspace) and reach(block, workspace))
        if path.alive:
            position = madd(vec(path.start), path.length, vec(path.direction))
            path.promises = largest(vec(path.throughput)) * lights.irradiance(block, position)
            rays[FIRST_BRANCH_RAY + branch] = rays[0]
        paths[FIRST_BRANCH + branch] = paths[0]


@kernel
def choose_branches(workspace, branches):
    """Russian roulette: of branches that promise less than their mean, as many go on as they are worth.

    One number decides on all of them, so how many do is nearly always the same (systematic sampling). What it costs to
    find out where a branch leads is a fraction of what it costs to light a surface there.
    """
    paths = path_table(workspace)
    waiting = paths[WAITING]
    total, count = 0.0, 0
    for branch in range(branches):
        path = paths[FIRST_BRANCH + branch]
        if path.alive:
            total += path.promises
            count += 1
    if count < 2 or not 0.0 < total < np.inf:
        return
    # The emission along the ray that came here may take this number, too: it is added to what branches bring.
    passed = draw1(waiting.index, waiting.seed, waiting.dimension + EMISSION_SET)
    for branch in range(branches):
        path = paths[FIRST_BRANCH + branch]
        if path.alive:
            survival = min(max(path.promises * count / total, LEAST_SURVIVAL), 1.0)
            path.alive = int(math.floor(passed + survival) > math.floor(passed))
            passed += survival
            put(path.throughput, scale(vec(path.throughput), 1.0 / survival))


@kernel
def divides(block, workspace):
    """Whether a path should go on in several directions here: light is scattered, and more than once."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    return surface.evaluable > 0 and path.bounce < block.max_bounces and largest(vec(surface.transparency)) <= 0.0


@kernel
def follow(block, workspace, whole):
    """Follow the workspace's path to its end, or where it should divide if it is ``whole``: True there."""
    state = GOES_ON
    while state == GOES_ON and expects(block, workspace):
        state = advance(block, workspace, whole)
    return state == DIVIDES


@kernel
def expects(block, workspace):
    """Whether there is anything for the path's next ray to find, which is made ready for ``advance``."""
    path = path_table(workspace)[0]
    path.kept = path.found = -1
    if path.last and not block.emitters_hit:
        path.t_max = min(path.t_max, lamp_reach(block, workspace, path))
        return path.t_max > path.t_min
    return True


@kernel
def advance(block, workspace, whole):
    """Follow the workspace's path along its ray, and scatter it where that meets a surface: as ``turn``."""
    return turn(block, workspace, whole) if reach(block, workspace) else ENDS


@kernel
def reach(block, workspace):
    """Follow the workspace's path along its ray, and add the emission on the way: True if it ends at a surface."""
    path = path_table(workspace)[0]
    found = intersect(block, workspace, vec(path.start), vec(path.direction), path.t_min, path.t_max, path.kind)
    t_to = float(ray_table(workspace)[0].t_far) if found else path.t_max
    if block.lamp_count > 0:
        gather_lamps(block, workspace, t_to)
    if block.finite_lights > 0:
        gather_lights(block, workspace, t_to)
    if not found:
        gather_world(block, workspace)
        return False
    path.length = t_to
    return True


@kernel
def turn(block, workspace, whole):
    """Scatter the workspace's path at the surface that its ray has met, unless it is ``whole`` and should divide there:
    ENDS, GOES_ON or DIVIDES."""
    path = path_table(workspace)[0]
    sample = sample_table(workspace)[0]
    surface = surface_table(workspace)[0]
    t_to = path.length
    if not survives(path):
        return ENDS
    wo = negate(vec(path.direction))
    find_surface(block, workspace, wo, path.kind, t_to * block.camera_pixel_angle)
    if instance_table(block)[surface.instance].holdout:
        if path.kind == CAMERA:
            uncover(workspace, 1.0)
        return ENDS
    shade(block, workspace)
    sample.met += sample.divided
    gather_surface(block, workspace)
    if path.kind == CAMERA:
        uncover(workspace, surface.holdout)
        if not sample.found and average(vec(surface.transparency)) < 0.5:
            record_first_surface(block, workspace)
    if path.last:
        # A transparent surface does not end a ray that gathers emission: light sampling sees through it too.
        transparent = vec(surface.transparency)
        if largest(transparent) <= 0.0 or path.transparent >= block.transparent_bounces:
            return ENDS
        path.transparent += 1
        path.t_min = _beyond(t_to)
        put(path.throughput, mul(vec(path.throughput), transparent))
        return GOES_ON
    both, scattered, passed = path.both, path.scattered, path.transparent
    if surface.evaluable > 0:
        light_vertex(block, workspace)
    if surface.closure_count == 0 or (path.bounce >= block.max_bounces and nothing_left(block, surface)):
        return ENDS
    if whole and divides(block, workspace):
        return DIVIDES
    if not scatter(block, workspace):
        return ENDS
    if path.transparent > passed:
        # The ray that goes on is the one that came: what it meets competes with the light sampling at its origin.
        path.both, path.scattered = both, scattered
        cut_of(workspace).lamp = -1
    path.dimension += VERTEX_SETS
    return GOES_ON


@kernel
def render_tile(blocks, workspaces, x0, y0, x1, y1, samples):
    """Add samples to the active pixels of the tile [x0, x1) × [y0, y1), until those with the rate 1 have ``samples``."""
    block, workspace = blocks[0], workspaces[0]
    path = path_table(workspace)[0]
    for y in range(y0, y1):
        if control_table(block)[0] != 0:
            return
        for x in range(x0, x1):
            pixel = pixel_index(block, x, y)
            if not is_active(block, pixel):
                continue
            path.seed, branches = pixel_seed(x, y, block.seed), branches_of(block, pixel)
            start, end = samples_due(block, pixel, samples)
            for index in range(start, end):
                path.index = index
                clear_sample(workspace)
                trace_branches(block, workspace, x, y, branches, branches_before(block, pixel))
                add_sample(block, workspace, pixel, index)
