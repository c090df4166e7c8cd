# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer: a path from the camera on, with next event estimation and BSDF sampling joined by MIS.

Each emitter (an SDF lamp, a Blender light, an emissive triangle, the world) is an integral of its own over the sphere
of directions. It is estimated twice at every vertex of a path: once by a ray towards a point of an emitter that
``lights.select`` drew (``next_event``), once by the ray that continues the path (``gather``), which adds the line
integral of every lamp it crosses before its hit (Huang et al. 2026, equations 1 and 2).
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ...replaced import replaced_on_gpu
from ...vec import absolute, average, dot, largest, mul, negate, put, put_sum, scale, sub, vec
from . import lights
from .camera import camera_ray, filter_offset, view_depth
from .caustic_paths import dispatch as caustic_paths
from .gather import gather_lamps, gather_lights, gather_surface, gather_world, last_lamp_exit
from .geometry import find_surface, instance_table, shading_material_table, surface_table
from .light_paths import dispatch as light_paths
from .light_paths.records import FOLLOW_ALL
from .media import dispatch as media
from .media.records import inside_table
from .next_event import sample_direct_light
from .outputs import dispatch as outputs
from .outputs.records import CATCHERS, DATA, LOBES
from .path import (
    ARRIVES,
    AT_EXIT,
    AT_SURFACE,
    BEFORE,
    BEYOND,
    CAMERA,
    CAMERA_SETS,
    IN_MEDIUM,
    MIXED,
    NOWHERE,
    REUSED,
    ROULETTE_SET,
    SCATTER_SET,
    VERTEX_SETS,
    WHITE,
    path_table,
    put_depths,
    sample_table,
    subtract_alpha,
)
from .path_reuse import dispatch as path_reuse
from .ray_continuation import continue_past_surface
from .ray_origins import clear_self_primitive, offset_ray_origin, spawn_ray
from .rays import intersect, ray_table, start_anew
from .samplers import get_1d, get_2d, get_3d
from .shading import sample as sample_surface
from .shading import shade
from .shading.caustics import blur_lobes, darken_microfacets
from .shading.records import (
    BENDS_EXITS,
    DIFFUSE,
    GLOSSY,
    INTO_SUBSURFACE,
    NEEDS_RAY,
    SCATTERED,
    SINGULAR,
    STOPS_LIGHT_RAYS,
    THROUGH_PORTAL,
    TRANSMISSION,
    TRANSPARENT,
)
from .subsurface import dispatch as subsurface
from .visibility import BLACK
from .workspace import cut_of

SCALARS = [
    ("seed", np.int64),
    ("sample_offset", np.int64),  # samples of the seed that others take
    ("max_bounces", np.int64),
    ("diffuse_bounces", np.int64),
    ("glossy_bounces", np.int64),
    ("transmission_bounces", np.int64),
    ("volume_bounces", np.int64),
    ("transparent_bounces", np.int64),
    ("clamp_direct", np.float64),
    ("clamp_indirect", np.float64),
    ("clearest", np.float64),  # of a surface that has data: ``Scene.clearest``
    ("transparent_film", np.int64),
    ("shows_environment", np.int64),  # 1: a pass has what a transparent film hides
    ("emitters_hit", np.int64),  # 1: rays can meet emission other than that of SDF lamps
    ("transparent_shadows", np.int64),
    ("stops_light_rays", np.int64),  # 1: there are transparent surfaces that stop light rays
    ("lamp_count", np.int64),
    ("finite_lights", np.int64),  # 1: there are Blender lights that rays can meet
]

FIRST_ROULETTE = 3  # bounces: chance disturbs the even spread of samples more than the paths before that cost

SAME_PLACE = 1e-9  # square of the distance in metres within which a portal leads nowhere else

AGAIN_COST = 1.0  # time of a connection of a surface after the one where the path split, in surfaces that rays meet

ESCAPE = 0.5  # time of a ray that meets nothing, in surfaces that rays meet: measured with materials of many nodes

ENDS, GOES_ON, DIVIDES = range(3)  # what becomes of a path at a surface


@kernel
def record_first_surface(block, workspace):
    """Data passes: the first surface that the camera sees and that is solid enough."""
    sample = sample_table(workspace)[0]
    surface = surface_table(workspace)[0]
    sample.found = 1
    sample.depth = view_depth(block, vec(surface.position))
    for axis in range(3):
        sample.position[axis] = surface.position[axis]
        sample.normal[axis] = surface.n[axis]
        sample.albedo[axis] = surface.albedo[axis]


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
def _leave_portal(workspace, path, surface, kind, wi):
    """Go on from a surface that has a portal, straight or through it. As in Cycles, what is found then counts in
    full."""
    path.pdf = 0.0
    if kind & THROUGH_PORTAL:
        position = vec(surface.exit)
        way = sub(position, vec(surface.position))
        put(path.origin, position)
        if dot(way, way) > SAME_PLACE:
            clear_self_primitive(ray_table(workspace)[0])
            put(path.start, position)
        else:
            put(path.start, offset_ray_origin(position, vec(surface.ng), wi))
        put(path.direction, wi)
        path.t_min, path.t_max, path.near = 0.0, np.inf, 0.0


@kernel
def _leave_to_light_paths(block, workspace, path, wi, kind):
    """Note what connections estimate of the light from the new direction of a path; or scale the path down by that, if
    nothing else is found there. What is scattered into a single direction at the first hit is left to the path."""
    if kind & SINGULAR and path.follow & FOLLOW_ALL == 0:
        path.connects = NOWHERE
        return
    light_paths.record_connected(block, workspace, wi)
    if block.light_path_all:
        put(path.throughput, mul(vec(path.throughput), sub(WHITE, vec(path.connection_weight))))
        path.connects = NOWHERE
    elif block.light_path_follows:
        path.unconnected *= 1.0 - path.connection_weight[0]
        path.connects = NOWHERE


@replaced_on_gpu
@kernel
def may_connect_again(block, path):
    """Whether connections may take light from a path at a surface after the one where it split."""
    return block.light_path_follows


@kernel
def connect_later(block, workspace):
    """Connect the path's surface, one after the first, with light paths, if these have much of its light."""
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    if may_connect_again(block, path) and path.bounce < block.max_bounces:
        if largest(vec(surface.transparency)) <= 0.0:
            light_paths.connect_again(block, workspace)
            sample_table(workspace)[0].met += AGAIN_COST * path.connects_again


@kernel
def scatter(block, workspace):
    """Continue the path from ``workspace.surface``. False if it ends there."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    u = get_3d(path.index, path.seed, path.dimension + SCATTER_SET)
    wi, weight, pdf, glossy_pdf, kind = sample_surface(block, workspace, u[0], u[1], u[2])
    if block.reuses_paths and path.reused == MIXED and pdf > 0.0:
        weight, pdf, glossy_pdf = path_reuse.evaluate_arrival(block, workspace, wi, SCATTERED, kind)
    if pdf <= 0.0 or largest(weight) <= 0.0:
        return False
    throughput = scale(mul(vec(path.throughput), weight), 1.0 / pdf)
    if block.outputs & LOBES and path.bounce == 0 and not kind & TRANSPARENT:
        outputs.divide(block, workspace, wi, kind, DIFFUSE | GLOSSY | TRANSMISSION, 0)
    if block.has_subsurface and kind & INTO_SUBSURFACE:
        path.connects = NOWHERE
        path.caustic = 0
        put(path.throughput, throughput)
        put(path.direction, wi)
        return subsurface.scatter(block, workspace)
    if block.has_media and kind & (TRANSPARENT | TRANSMISSION):
        media.bounds(block, workspace, media.CROSS)
    if kind & TRANSPARENT:
        # The ray goes on as the same ray: its origin, pdf and kind stay, so MIS still compares what it should.
        path.transparent += 1
        if block.stops_light_rays:
            path.stopped |= shading_material_table(block)[surface.material].flags & STOPS_LIGHT_RAYS
        if path.transparent >= block.transparent_bounces:
            path.last = 1  # as in Cycles: the surface behind the last one only shows its emission
        path.t_min = continue_past_surface(workspace, path.length, path.t_min)
        put(path.throughput, throughput)
        if surface.portal:
            path.connects = NOWHERE
            _leave_portal(workspace, path, surface, kind, wi)
        return True
    _count_bounce(block, path, kind)
    position = vec(surface.position)
    put(path.throughput, throughput)
    if block.light_paths and path.connects == BEYOND:
        _leave_to_light_paths(block, workspace, path, wi, kind)
    if block.light_paths and path.connects_again and kind & SINGULAR == 0:
        path.connects = BEFORE
        put(path.connection_weight, WHITE)
    if block.caustic_paths:
        caustic_paths.follow(block, workspace, wi, pdf, kind)
    put(path.origin, position)
    put(path.normal, vec(surface.n))
    put(path.start, spawn_ray(workspace, surface, wi))
    put(path.direction, wi)
    path.t_min, path.t_max, path.near = 0.0, np.inf, 0.0
    path.pdf = 0.0 if kind & SINGULAR else pdf
    if not kind & SINGULAR:
        path.least_pdf = min(path.least_pdf, pdf)
    path.glossy_pdf = glossy_pdf
    path.kind = kind & (DIFFUSE | GLOSSY | TRANSMISSION)
    path.in_medium, path.stopped, path.light_tree = 0, 0, lights.tree_of(block, surface.instance)
    return True


@kernel
def survives(path):
    """Russian roulette, by what the path can still carry.

    It comes after the lamps along the ray were gathered: they are half of an estimate whose other half is a light ray.
    """
    if path.bounce < FIRST_ROULETTE or path.last:
        return True
    survival = min(1.0, largest(absolute(vec(path.throughput))))  # negative where a medium is denser than its majorant
    if get_1d(path.index, path.seed, path.dimension + ROULETTE_SET) >= survival:
        return False
    put(path.throughput, scale(vec(path.throughput), 1.0 / survival))
    return True


@kernel
def finds_no_light(block, surface):
    """Whether no ray from here can find light, once only emission counts: all of it is left to light sampling."""
    if block.has_subsurface and surface.subsurface > 0:
        return False
    return not block.emitters_hit and block.lamp_count == 0 and largest(vec(surface.transparency)) <= 0.0


@kernel
def start_path(block, workspace, x, y):
    """Camera ray through a point of the pixel drawn from the pixel filter."""
    path = path_table(workspace)[0]
    u = get_2d(path.index, path.seed, 0)
    dx, dy = filter_offset(block, u[0], u[1])
    lens = get_2d(path.index, path.seed, 1) if block.camera_aperture > 0.0 else (0.5, 0.5)
    origin, direction, t_min, t_max = camera_ray(block, x + 0.5 + dx, y + 0.5 + dy, lens[0], lens[1])
    put(path.origin, origin)
    put(path.start, origin)
    put(path.normal, BLACK)
    put(path.direction, direction)
    # Where a panorama shows nothing the path finds nothing, and its pixel stays black.
    put(path.throughput, (1.0, 1.0, 1.0) if t_max >= 0.0 else BLACK)
    path.t_min, path.t_max, path.near = t_min, t_max, t_min
    path.pdf, path.least_pdf = 0.0, np.inf
    path.kind = CAMERA
    path.bounce = path.diffuse = path.glossy = path.transmission = path.volume = path.transparent = path.last = 0
    path.event, path.in_medium, path.crossed, path.catches, path.connects = AT_SURFACE, 0, 0, 0, NOWHERE
    path.stopped = 0
    path.path_weight = path.unconnected = 1.0
    path.connects_again = path.reused = path.caustic = 0
    path.dimension = CAMERA_SETS
    path.branch_weight, path.scattered, path.light_tree = 1.0, 0, 0
    path.kept = path.found = -1
    clear_self_primitive(ray_table(workspace)[0])
    if block.has_media:
        media.bounds(block, workspace, media.BEGIN)


@kernel
def divides(block, workspace):
    """Whether a path should go on in several directions here: light is scattered, and more than once."""
    path = path_table(workspace)[0]
    surface = surface_table(workspace)[0]
    return surface.evaluable > 0 and path.bounce < block.max_bounces and largest(vec(surface.transparency)) <= 0.0


@kernel
def trace_path(block, workspace, whole):
    """Follow the workspace's path to its end, or where it should divide if it is ``whole``: True there."""
    state = GOES_ON
    while state == GOES_ON and prepare_ray(block, workspace):
        state = advance(block, workspace, whole)
    return state == DIVIDES


@kernel
def prepare_ray(block, workspace):
    """Whether there is anything for the path's next ray to find, which is made ready for ``advance``."""
    path = path_table(workspace)[0]
    path.kept = path.found = -1
    if path.last and not block.emitters_hit:
        path.t_max = min(path.t_max, last_lamp_exit(block, workspace, path))
        return path.t_max > path.t_min
    return True


@kernel
def advance(block, workspace, whole):
    """Follow the workspace's path along its ray, and scatter it where that meets a surface: as
    ``shade_and_scatter``."""
    return shade_and_scatter(block, workspace, whole) if intersect_and_gather(block, workspace) else ENDS


@kernel
def intersect_and_gather(block, workspace):
    """Follow the workspace's path along its ray, and add the emission on the way: True if it ends at a surface, or
    where a medium scatters it."""
    path = path_table(workspace)[0]
    if block.has_subsurface and path.event == AT_EXIT:
        return True
    start_anew(block, workspace)
    found = intersect(block, workspace, vec(path.start), vec(path.direction), path.t_min, path.t_max, path.kind)
    t_to = float(ray_table(workspace)[0].t_far) if found else path.t_max
    if block.has_media and not found and (path.t_max == np.inf or path.kind == CAMERA):
        media.bounds(block, workspace, media.ESCAPE)
    if block.lamp_count > 0:
        gather_lamps(block, workspace, t_to)
    if block.finite_lights > 0:
        gather_lights(block, workspace, t_to)
    path.event = AT_SURFACE
    if block.has_media and inside_table(workspace)[0].count > 0:
        length = np.inf if not found and path.kind == CAMERA else t_to - path.t_min
        if media.enter(block, workspace, length):
            path.event = IN_MEDIUM
            return True
    if not found:
        sample = sample_table(workspace)[0]
        sample.met += ESCAPE * sample.divided
        if block.outputs & DATA and path.kind == CAMERA:
            outputs.add_miss(block, workspace)
        gather_world(block, workspace)
        return False
    path.length = t_to
    return True


@kernel
def describe_ray(path, surface):
    """Tell the surface of the ray that has met it, as the Light Path node asks for it."""
    surface.ray_length = path.length - path.near
    surface.ray_singular = int(path.pdf <= 0.0 and path.kind != CAMERA)
    put_depths(path, surface)


@kernel
def shade_and_scatter(block, workspace, whole):
    """Scatter the workspace's path at the surface that its ray has met, unless it is ``whole`` and should divide there:
    ENDS, GOES_ON or DIVIDES."""
    path = path_table(workspace)[0]
    sample = sample_table(workspace)[0]
    surface = surface_table(workspace)[0]
    t_to = path.length
    exits = block.has_subsurface != 0 and path.event == AT_EXIT  # light leaves from below a surface
    if not exits and not survives(path):
        return ENDS
    if block.has_media and not exits:
        if path.event == IN_MEDIUM:
            path.dimension += VERTEX_SETS
            clear_self_primitive(ray_table(workspace)[0])
            return GOES_ON if media.scatter(block, workspace) else ENDS
        if media.bounds(block, workspace, media.PASS):
            path.dimension += VERTEX_SETS
            return GOES_ON
    wo = vec(path.direction) if exits else negate(vec(path.direction))
    find_surface(block, workspace, wo, path.kind, t_to * block.camera_pixel_angle + block.camera_pixel_width)
    if path.kind == CAMERA and instance_table(block)[surface.instance].holdout:
        subtract_alpha(workspace, 1.0)
        return ENDS
    if block.outputs & CATCHERS and path.kind == CAMERA and instance_table(block)[surface.instance].catcher:
        outputs.catch(block, workspace)
    flags = shading_material_table(block)[surface.material].flags
    if flags & NEEDS_RAY:
        describe_ray(path, surface)
    if block.has_media:
        media.bounds(block, workspace, media.NOTE)
    if not exits or flags & BENDS_EXITS:
        shade(block, workspace)
    if block.has_subsurface and exits:
        path.event = AT_SURFACE
        subsurface.emerge(block, workspace)
    if path.kind == DIFFUSE and block.caustics != GLOSSY | TRANSMISSION:
        darken_microfacets(workspace, block.caustics)
    blur_lobes(block, workspace, path.least_pdf)
    sample.met += sample.divided
    if not exits:
        gather_surface(block, workspace)
    if block.caustic_paths and path.caustic == 1:
        caustic_paths.meet(block, workspace)
    if block.reuses_paths and path.reused == ARRIVES:
        path_reuse.arrive(block, workspace)
        if path.reused >= REUSED:
            return DIVIDES
    if path.kind == CAMERA:
        subtract_alpha(workspace, surface.holdout)
        put_sum(sample.diffuse_albedo, mul(vec(path.throughput), vec(surface.diffuse_albedo)))
        first = not sample.found and average(vec(surface.transparency)) <= block.clearest
        if first:
            record_first_surface(block, workspace)
        if block.outputs & DATA:
            outputs.add_surface(block, workspace, first)
    if path.last:
        # A transparent surface does not end a ray that gathers emission: light sampling sees through it too.
        transparent = vec(surface.transparency)
        if largest(transparent) <= 0.0 or path.transparent >= max(block.transparent_bounces, 1):  # as in Cycles
            return ENDS
        if not surface.portal:
            path.transparent += 1
            path.stopped |= flags & STOPS_LIGHT_RAYS
            path.t_min = continue_past_surface(workspace, t_to, path.t_min)
            put(path.throughput, mul(vec(path.throughput), transparent))
            if block.has_media:
                media.bounds(block, workspace, media.CROSS)
            return GOES_ON
    two_sided, has_glossy, scattered, light_tree = path.two_sided, path.has_glossy, path.scattered, path.light_tree
    passed, last, connects, weight = path.transparent, path.last, path.connects, vec(path.connection_weight)
    if block.light_paths and path.connects and not light_paths.apply_path_weight(block, workspace):
        return ENDS
    if surface.evaluable > 0 and not last:
        sample_direct_light(block, workspace)
        if block.light_paths:
            path.connects_again = 0
            if not whole:
                connect_later(block, workspace)
    if surface.closure_count == 0 or (path.bounce >= block.max_bounces and finds_no_light(block, surface)):
        return ENDS
    if whole and divides(block, workspace):
        return DIVIDES
    if not scatter(block, workspace) or last and path.transparent == passed:
        return ENDS
    if path.transparent > passed:
        # The ray that goes on is the one that came: what it meets competes with the light sampling at its origin.
        path.two_sided, path.has_glossy, path.scattered, path.light_tree = two_sided, has_glossy, scattered, light_tree
        if block.light_paths and not surface.portal:
            path.connects = connects
            put(path.connection_weight, weight)
        cut_of(workspace).lamp = -1
    path.dimension += VERTEX_SETS
    return GOES_ON
