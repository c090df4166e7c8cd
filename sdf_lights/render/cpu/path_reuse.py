# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of groups of pixels whose paths share their branches (Bekaert, Sbert and Halton 2002, "Accelerating path
tracing by re-using paths").

The paths of a group divide at the points x_i. A branch from x_m arrives at y, a surface. The light that y scatters is
estimated once, and every point that sees y takes of it

    T_i f_i |cos| G L(y → x_i) / Σ_k b_k p_k(y),     G = cos_y / d².

T_i is the throughput of the path to x_i, b_k the number of branches of the point k, and p_k(y) the density by area with
which its BSDF draws y. The sum has the points that see y (balance heuristic). Where y is not diffuse, L depends on the
direction: see ``kernels.path_reuse.arrivals``.

A point shares an arrival if a ray of it meets that first. What is found behind a transparent surface, or behind one
that bounds a medium, belongs to the branch alone. So does all that the density is not known of: see ``can_share`` and
``arrivals.is_shareable``.

Diffuse and glossy rays have limits of bounces of their own, so p_k(y) is the density of rays of the arrival's kind, and
the point scatters by the part of f_i that this kind has of the density.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel
from ...vec import ZERO, add, dot, is_zero, largest, mul, put, put_sum, scale, sub, vec
from ..kernels.caustic_paths.weights import area_of_pixel
from ..kernels.film import (
    add_sample,
    branches_before,
    branches_of,
    end_sample,
    is_active,
    pixel_index,
    samples_due,
    samples_had,
)
from ..kernels.film import begin_sample as count_sample
from ..kernels.geometry import TRIANGLES, instance_table
from ..kernels.integrator import DIVIDES, GOES_ON, connect_later, scatter, shade_and_scatter, trace_path
from ..kernels.light_paths.connections import ROULETTE_SETS
from ..kernels.light_paths.records import FOLLOW_ALL
from ..kernels.media import dispatch as media
from ..kernels.media.records import NOTHING, inside_table
from ..kernels.motion import NOT_ROLLING, block_at, draw_time
from ..kernels.next_event import sample_direct_light
from ..kernels.outputs import dispatch as outputs
from ..kernels.outputs.records import CATCHERS
from ..kernels.path import (
    ARRIVES,
    BEYOND,
    CAMERA,
    FIRST_BRANCH,
    FIRST_BRANCH_RAY,
    MIXTURE_SETS,
    ONWARD,
    UNSHARED,
    VERTEX_SETS,
    WAITING,
    WHITE,
    clear_sample,
    path_table,
    sample_table,
)
from ..kernels.path_reuse import dispatch as path_reuse
from ..kernels.path_reuse.arrivals import LOOK_COST, SHADE_COST, copy_surface, is_reusable, look_from_all
from ..kernels.path_reuse.records import (
    GROUP,
    GROUP_PATH,
    GROUP_RAY,
    GROUP_SAMPLE,
    GROUP_START,
    SIDE,
    arrival_table,
    point_table,
)
from ..kernels.path_reuse.vertices import part_of
from ..kernels.ray_origins import least_of, origin_of
from ..kernels.rays import ray_table
from ..kernels.samplers import get_1d, pixel_seed
from ..kernels.shading.records import LAMBERT, TRANSMISSION, closure_table, surface_table
from ..kernels.workspace import cut_table, point_workspaces
from ..scene import Scene
from ..settings import PathReuse
from .block import PackedScene
from .light_paths import clamps_strongly
from .path_splitting import (
    add_spread,
    begin_sample,
    brightness,
    control_table,
    divide_path,
    follow_branches,
    follow_divided,
    restore_state,
    save_state,
    trace_catchers,
)

# Arrivals that are not diffuse are shaded for each point, which takes time. Where most are so, every eighth point
# shares one. MOST_TIME: for an arrival on average, in surfaces that rays meet, up to which all points of the group do.
# Where no arrival is diffuse, every eighth point costs 4. With that limit, some seeds of S2 share an arrival with every
# second point only: 1.07 times the error × time.
MOST_STEP, MOST_TIME = 8, 5.0
# Path splitting at such a surface: so many paths go on, each with a light ray. They take less time than its points, if
# all share it.
SPLITS = 2
# If fewer pixels of a block's group are due, they join a group of the tile. With twice this number, the rows of the
# pilot would do so, and promise 0.7 times as much.
FEWEST_POINTS = GROUP // 4
LEAST_CHANCE = 0.1  # of an arrival to go on, where vertices of light paths should bring nearly all of its light


def supports_path_reuse(scene: Scene, packed: PackedScene) -> bool:
    """Whether paths may share branches, and whether that is asked for.

    - No medium fills the world, and the time of a path does not depend on its pixel.
    - No pass wants parts of the light.
    - Indirect light is not clamped strongly. A clamp changes the brightness of a picture, and by how much depends on
      how its paths are sampled.

    All else is decided for each point and each arrival: see ``can_share``, and ``arrivals.arrive``.
    """
    settings, block = scene.settings, packed.block[0]
    light_columns = 3 if block["outputs"] & CATCHERS else 0  # of what shadow catchers catch
    return bool(
        settings.path_reuse is not PathReuse.NEVER
        and not (settings.path_reuse is PathReuse.AUTOMATIC and settings.denoise)
        and settings.max_bounces > 0
        and not clamps_strongly(scene)
        and block["world_medium"] == NOTHING
        and block["rolling_shutter"] == NOT_ROLLING
        and block["light_columns"] == light_columns
    )


def step_for(arrivals: np.ndarray) -> int:
    """Of so many points of a group, one shares an arrival that is not diffuse. ``arrivals``: (n,) ``ARRIVAL`` of
    workspaces that have counted them."""
    part = arrivals["uneven"].sum() / max(arrivals["number"].sum(), 1)
    step = 1
    while step < MOST_STEP and part * GROUP * (LOOK_COST + SHADE_COST) / step > MOST_TIME:
        step *= 2
    return step


@kernel
def keep_point(block, workspace, number, pixel, index, branches):
    """Keep the surface of the workspace, where its path divides, as a point of the group."""
    path, point = path_table(workspace)[0], point_table(workspace)[number]
    surface, closure = surface_table(workspace)[0], closure_table(workspace)[0]
    copy_surface(workspace, point_workspaces(workspace)[number])
    put(point.position, vec(surface.position))
    put(point.ng, vec(surface.ng))
    put(point.start, origin_of(surface, vec(surface.ng)))
    point.number, point.least = surface.number, least_of(surface)
    point.lambert = int(surface.closure_count == 1 and closure.kind == LAMBERT and closure.bumped == 0)
    put(point.lambert_normal, vec(closure.normal))
    put(point.lambert_weight, vec(closure.weight))
    put(point.throughput, vec(path.throughput))
    point.least_pdf = path.least_pdf
    point.branches, point.pixel, point.index = branches, pixel, index
    if block.caustic_paths:
        seen = path.kind == CAMERA and path.transparent == 0
        point.area = area_of_pixel(block, vec(path.direction), path.length, vec(surface.ng)) if seen else 0.0
    point.sum = point.squares = point.brought = point.connected_noise = 0.0


@kernel
def same_bounces(a, b):
    """Whether two paths have scattered as often, in each way."""
    return (
        a.bounce == b.bounce
        and a.diffuse == b.diffuse
        and a.glossy == b.glossy
        and a.transmission == b.transmission
        and a.volume == b.volume
        and a.transparent == b.transparent
    )


@kernel
def can_share(block, workspace):
    """Whether the path of the workspace, where it should divide, can be a point of a group: on a triangle that scatters
    all of its light there and then, outside of all media, and not on its way from a shadow catcher."""
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    if path.catches or instance_table(block)[surface.instance].primitive != TRIANGLES:
        return False
    if block.has_media and inside_table(workspace)[0].count > 0:
        return False
    return is_reusable(workspace)


@kernel
def follow_into_media(block, workspace, branches):
    """Follow those branches of a point to their ends that a medium surrounds where they have arrived. So nothing
    surrounds those that are kept, and this need not be kept."""
    paths, sample = path_table(workspace), sample_table(workspace)[0]
    for branch in range(branches):
        if paths[FIRST_BRANCH + branch].alive and inside_table(workspace)[FIRST_BRANCH + branch].count > 0:
            light = brightness(sample)
            follow_divided(block, workspace, branch)
            paths[FIRST_BRANCH + branch].brought += brightness(sample) - light
            paths[FIRST_BRANCH + branch].alive = 0


@kernel
def keep_branches(workspace, number, branches, stored):
    """Keep the branches of a point that go on, from row ``stored`` on: the number of rows then."""
    paths, rays = path_table(workspace), ray_table(workspace)
    for branch in range(branches):
        if paths[FIRST_BRANCH + branch].alive:
            paths[GROUP_PATH + stored] = paths[FIRST_BRANCH + branch]
            paths[GROUP_PATH + stored].row = GROUP_SAMPLE + number
            rays[GROUP_RAY + stored] = rays[FIRST_BRANCH_RAY + branch]
            stored += 1
    return stored


@kernel
def quotient(a, b):
    """a / b (RGB), and 0 where b is 0."""
    return (
        a[0] / b[0] if b[0] > 0.0 else 0.0,
        a[1] / b[1] if b[1] > 0.0 else 0.0,
        a[2] / b[2] if b[2] > 0.0 else 0.0,
    )


@kernel
def clamped(block, factor, light, alone):
    """``factor`` (RGB), so that it times the ``light`` (RGB) is what a clamp leaves, if a path of the point alone had
    brought it, ``alone`` times as bright."""
    value, limit = mul(factor, light), block.clamp_indirect / alone
    brought = value[0] + value[1] + value[2]
    return scale(factor, limit / brought) if 0.0 < limit < brought else factor


@kernel
def add_to_point(block, workspace, number, factor, direct, rest, alone):
    """Add the light of an arrival, times ``factor`` (RGB), to a point's sample. ``direct`` and ``rest`` are RGB, and
    RGB of lamps. ``alone``: see ``clamped``."""
    point, sample = point_table(workspace)[number], sample_table(workspace)[GROUP_SAMPLE + number]
    one, other = clamped(block, factor, direct[0], alone), clamped(block, factor, rest[0], alone)
    value = add(mul(one, direct[0]), mul(other, rest[0]))
    put_sum(sample.combined, value)
    put_sum(sample.lamps, add(mul(one, direct[1]), mul(other, rest[1])))
    point.brought += value[0] + value[1] + value[2]


@kernel
def note_brought(workspace, number):
    """Note what an arrival has brought a point."""
    point = point_table(workspace)[number]
    point.sum += point.brought
    point.squares += point.brought * point.brought
    point.brought = 0.0


@kernel
def share_light(block, workspace, direct, rest, splits):
    """Give light of the arrival to all points that see it: ``direct``, by a light ray there, and the ``rest``, by the
    path that goes on, one of so many ``splits``. Each is RGB, and RGB of lamps."""
    points, arrival = point_table(workspace), arrival_table(workspace)[0]
    by_light, onward = vec(arrival.by_light), vec(arrival.onward)
    crossed = block.caustic_paths and not is_zero(vec(arrival.crossed))
    for number in range(arrival.points):
        point = points[number]
        if not point.visible:
            continue
        factor = scale(mul(vec(point.throughput), vec(point.value)), 1.0 / arrival.density)
        alone = splits * arrival.density / point.area_pdf
        if arrival.even:
            add_to_point(block, workspace, number, factor, direct, rest, alone)
            continue
        first, second = quotient(vec(point.by_light), by_light), quotient(vec(point.onward), onward)
        found, found_of_lamps = rest
        if crossed:
            taken = scale(vec(arrival.crossed), (1.0 - point.left) * arrival.scale)
            found, found_of_lamps = sub(found, taken), sub(found_of_lamps, taken)
        add_to_point(
            block,
            workspace,
            number,
            factor,
            (mul(direct[0], first), mul(direct[1], first)),
            (mul(found, second), mul(found_of_lamps, second)),
            alone,
        )


@kernel
def choose_lobes(workspace, u):
    """Let the surface of the workspace be the arrival as one of the points sees it, chosen by ``u`` in proportion to
    their parts in its density."""
    points, chosen = point_table(workspace), -1
    for number in range(arrival_table(workspace)[0].points):
        if points[number].visible and (chosen < 0 or u >= 0.0):
            chosen = number
            u -= points[number].part
    copy_surface(point_workspaces(workspace)[GROUP + chosen], workspace)


@kernel
def follow_split(block, workspace):
    """Light of the arrival, by a light ray and by the path that goes on from there: ``direct`` and ``rest`` of
    ``share_light``."""
    path, sample, arrival = path_table(workspace)[0], sample_table(workspace)[0], arrival_table(workspace)[0]
    put(sample.combined, ZERO)
    put(sample.lamps, ZERO)
    put(arrival.crossed, ZERO)
    sample_direct_light(block, workspace)
    direct, direct_lamps = vec(sample.combined), vec(sample.lamps)
    if arrival.even and arrival.connects:
        connect_later(block, workspace)
    if scatter(block, workspace):
        path.dimension += VERTEX_SETS
        path.reused = ONWARD
        trace_path(block, workspace, False)
    rest, rest_lamps = sub(vec(sample.combined), direct), sub(vec(sample.lamps), direct_lamps)
    factor = arrival.scale
    return (scale(direct, factor), scale(direct_lamps, factor)), (scale(rest, factor), scale(rest_lamps, factor))


@kernel
def leave_to_vertices(block, workspace, source):
    """Leave to vertices of light paths what these bring of the light of the arrival, from a branch of the point
    ``source``: whether that one sees it. The path that waits goes on with what is left, or ends, by the ``scale`` of
    the arrival, with the chance that this is expected to leave over."""
    arrival, path = arrival_table(workspace)[0], path_table(workspace)[WAITING]
    found = path_reuse.density_of_vertices(block, workspace)
    if not found > 0.0:
        return look_from_all(block, workspace, source, 1)
    way = sub(vec(arrival.position), vec(path.origin))
    square = dot(way, way)
    expected = arrival.branches * path.pdf * abs(dot(vec(arrival.normal), way)) / (square * math.sqrt(square))
    survival = max(1.0 - part_of(found, expected), block.light_path_roulette, LEAST_CHANCE) if expected > 0.0 else 1.0
    if survival < 1.0:
        goes_on = get_1d(path.index, path.seed, path.dimension + ROULETTE_SETS) < survival
        arrival.scale *= 1.0 / survival if goes_on else 0.0
        if not goes_on:
            return False
    if not look_from_all(block, workspace, source, 1):
        return False
    path.connects, path.follow = BEYOND, FOLLOW_ALL
    put(path.followed_weight, scale(WHITE, part_of(found, arrival.density)))
    return True


@kernel
def share_arrival(block, workspace, source):
    """Share the light of the arrival from a branch of the point ``source``."""
    paths, samples, arrival = path_table(workspace), sample_table(workspace), arrival_table(workspace)[0]
    point, own = point_table(workspace)[source], samples[GROUP_SAMPLE + source]
    paths[WAITING] = paths[0]
    save_state(block, workspace, WAITING)
    splits, looked = 1 if arrival.even or block.reuse_step > 1 else SPLITS, not arrival.even
    offset = 0.0 if arrival.even else get_1d(paths[0].index, paths[0].seed, paths[0].dimension + MIXTURE_SETS)
    arrival.number += 1
    arrival.uneven += 1 - arrival.even
    if arrival.connects and arrival.even:
        looked = leave_to_vertices(block, workspace, source)
    elif arrival.connects and block.light_path_all:
        found = path_reuse.density_of_vertices(block, workspace) / block.reuse_step
        arrival.connected = part_of(found, arrival.density)
    for split in range(splits if arrival.scale > 0.0 else 0):
        paths[0] = paths[WAITING]
        restore_state(block, workspace, WAITING)
        paths[0].index, paths[0].branch_weight = paths[WAITING].index * splits + split, 1.0 / splits
        if not arrival.even:
            choose_lobes(workspace, (split + offset) / splits)
        direct, rest = follow_split(block, workspace)
        light = add(direct[0], rest[0])
        if not light[0] + light[1] + light[2] < math.inf:
            put_sum(own.combined, light)  # this sample is left out, and those of others are not
        elif largest(light) > 0.0:
            if not looked and not look_from_all(block, workspace, source, 1):
                add_to_point(block, workspace, source, vec(arrival.throughput), direct, rest, float(point.branches))
                break
            looked = True
            share_light(block, workspace, direct, rest, float(splits))
    for number in range(arrival.points):
        note_brought(workspace, number)


@kernel
def follow_branch(block, workspace, at):
    """Follow the stored branch number ``at``, and share what it brings among the points of the group."""
    paths, samples = path_table(workspace), sample_table(workspace)
    path, row = paths[0], paths[GROUP_PATH + at].row
    samples[0], paths[0] = samples[row], paths[GROUP_PATH + at]
    ray_table(workspace)[0] = ray_table(workspace)[GROUP_RAY + at]
    cut_table(workspace)[0].lamp = cut_table(workspace)[1].lamp = -1  # those are of other points
    if block.has_media:
        media.bounds(block, workspace, media.ESCAPE)  # none surrounds it: see ``follow_into_media``
    path.reused = UNSHARED if path.pdf <= 0.0 or path.kind == TRANSMISSION else ARRIVES
    before = brightness(samples[0])
    state = shade_and_scatter(block, workspace, False)
    if state == DIVIDES:
        share_arrival(block, workspace, row - GROUP_SAMPLE)
        samples[row].met = samples[0].met
        return
    if state == GOES_ON:
        path.reused = UNSHARED  # of what is behind a surface that only bounds a medium, nothing is shared
        trace_path(block, workspace, False)
    point_table(workspace)[row - GROUP_SAMPLE].brought = brightness(samples[0]) - before
    note_brought(workspace, row - GROUP_SAMPLE)
    samples[row] = samples[0]


@kernel
def cell_turn(x, y, number):
    """A number that differs between cells and samples."""
    mixed = (x * 0x9E3779B1 + y * 0x85EBCA77 + number * 0xC2B2AE3D) & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 15)) * 0x2C1B3C6D & 0xFFFFFFFF
    return mixed >> 13


@kernel
def begin_pixel(blocks, block, workspace, x, y, pixel, index, count, stored):
    """The next sample of a pixel, as point number ``count`` of the group if its path can be: the new number of stored
    branches; −1 if the sample is complete, and in the film."""
    paths, samples = path_table(workspace), sample_table(workspace)
    branches = branches_of(block, pixel)
    before = block.sample_offset * branches + branches_before(block, pixel)
    paths[0].seed, paths[0].index = pixel_seed(x, y, block.seed), block.sample_offset + index
    clear_sample(workspace)
    if block.outputs:
        outputs.clear(block, workspace)
    if begin_sample(block, workspace, x, y, branches):
        if count == 0:
            paths[GROUP_START] = paths[0]
        if can_share(block, workspace) and same_bounces(paths[0], paths[GROUP_START]):
            keep_point(block, workspace, count, pixel, index, branches)
            if block.outputs & CATCHERS:
                trace_catchers(blocks, block, workspace)
            count_sample(block, workspace, pixel)
            divide_path(block, workspace, branches, before, False)
            if block.has_media:
                follow_into_media(block, workspace, branches)
            add_spread(workspace, branches)
            samples[GROUP_SAMPLE + count] = samples[0]
            return keep_branches(workspace, count, branches, stored)
        follow_branches(block, workspace, branches, before)
    if block.outputs & CATCHERS:
        trace_catchers(blocks, block, workspace)
    add_sample(block, workspace, pixel, index)
    return -1


@kernel
def finish_group(block, workspace, count, branches):
    """Add the samples of the points of a group to the film. They had so many ``branches`` together."""
    samples, points = sample_table(workspace), point_table(workspace)
    for number in range(count):
        samples[0], point = samples[GROUP_SAMPLE + number], points[number]
        # The scatter of the group's arrivals, as if so many branches of the pixel itself had left that noise.
        noise = max(point.squares - point.sum * point.sum / branches, 0.0) * branches / max(branches - 1.0, 1.0)
        samples[0].spread += (point.branches - 1.0) * point.branches * (noise + point.connected_noise)
        end_sample(block, workspace, point.pixel, point.index)


@kernel
def pixel_of_cell(x0, y0, wide, group, cell, number):
    """The pixel (x, y) of a group in one of its cells, a pair of neighbours, for sample ``number``. The block of pixels
    at (x0, y0) is ``wide``, or else high, and has two groups."""
    across, along = 2 * (cell % SIDE), cell // SIDE
    x, y = (x0 + across, y0 + along) if wide else (x0 + along, y0 + across)
    place = (group + cell_turn(x, y, number)) & 1
    return (x + place, y) if wide else (x, y + place)


@kernel
def is_due(block, tile, x, y, number):
    """Whether a pixel is to have one more sample by sample ``number`` of pixels of rate 1. ``tile``: the corners of
    what is rendered, x0, y0, x1 and y1."""
    if x >= tile[2] or y >= tile[3]:
        return False
    pixel = pixel_index(block, x, y)
    index, end = samples_due(block, pixel, number + 1)
    return index < end and is_active(block, pixel)


@kernel
def add_pixel(blocks, block, workspace, x, y, number, counts):
    """Let a pixel that is due take its next sample in the open group: the new ``counts``. These are the number of the
    group's points, of their branches that go on and are stored, and of all their branches. ``blocks``: see
    ``path_splitting.render_tile``; ``block`` is that of the group's time."""
    count, stored, branches = counts
    pixel = pixel_index(block, x, y)
    index, _ = samples_due(block, pixel, number + 1)
    kept = begin_pixel(blocks, block, workspace, x, y, pixel, index, count, stored)
    if kept < 0:
        return counts
    return count + 1, kept, branches + point_table(workspace)[count].branches


@kernel
def close_group(block, workspace, counts):
    """Follow the branches of the open group, and add its samples to the film."""
    count, stored, branches = counts
    arrival_table(workspace)[0].points, arrival_table(workspace)[0].branches = count, branches
    if block.light_paths and count > 0:
        path_reuse.connect_points(block, workspace)
    for at in range(stored):
        follow_branch(block, workspace, at)
    finish_group(block, workspace, count, branches)


@kernel
def block_of_group(blocks, workspace, x, y, number, turn):
    """Index of the block of a moving scene, at a time that is drawn for groups of the square or tile at (x, y): all
    rays of a group see one world. ``turn``: 0 in a square, or how often the tile has had groups for this ``number``.

    All groups of a square of two blocks have the time in common, as each pixel belongs to one after the other. So the
    times of its samples are spread as evenly as those of a pixel by itself.
    """
    block, path = blocks[0], path_table(workspace)[0]
    path.seed, path.index = pixel_seed(x, y + (turn << 20), block.seed), block.sample_offset + number
    return block_at(blocks, 0, draw_time(block, workspace, y))


@kernel
def render_block(blocks, workspace, tile, x0, y0, wide, number):
    """One more sample of each pixel of the block at (x0, y0), if it is due; none of a group that would have few."""
    block, side = blocks[0], 2 * SIDE
    for group in range(2):
        due = 0
        for cell in range(GROUP):
            x, y = pixel_of_cell(x0, y0, wide, group, cell, number + block.sample_offset)
            due += int(is_due(block, tile, x, y, number))
        if due < FEWEST_POINTS:
            continue
        if block.moves:
            x, y = tile[0] + (x0 - tile[0]) // side * side, tile[1] + (y0 - tile[1]) // side * side
            block = blocks[block_of_group(blocks, workspace, x, y, number, 0)]
        counts = (0, 0, 0)
        for cell in range(GROUP):
            x, y = pixel_of_cell(x0, y0, wide, group, cell, number + block.sample_offset)
            if is_due(block, tile, x, y, number):
                counts = add_pixel(blocks, block, workspace, x, y, number, counts)
        close_group(block, workspace, counts)


@kernel
def render_rest(blocks, workspace, tile, wide, number, turn):
    """One more sample of each pixel of the tile that is still due, in groups as large as can be: False if none is.
    ``turn``: 1 or more, how often this is done for this ``number``."""
    block, some, counts = blocks[0], False, (0, 0, 0)
    width, height = (2 * SIDE, SIDE) if wide else (SIDE, 2 * SIDE)
    if block.moves:
        block = blocks[block_of_group(blocks, workspace, tile[0], tile[1], number, turn)]
    for group in range(2):
        for y0 in range(tile[1], tile[3], height):
            for x0 in range(tile[0], tile[2], width):
                if counts[0] == 0 and control_table(block)[0] != 0:  # else counted samples would be lost
                    return False
                for cell in range(GROUP):
                    x, y = pixel_of_cell(x0, y0, wide, group, cell, number + block.sample_offset)
                    if not is_due(block, tile, x, y, number):
                        continue
                    some = True
                    counts = add_pixel(blocks, block, workspace, x, y, number, counts)
                    if counts[0] == GROUP:
                        close_group(block, workspace, counts)
                        counts = (0, 0, 0)
    close_group(block, workspace, counts)
    return some


@kernel
def render_tile_reusing(blocks, workspaces, x0, y0, x1, y1, samples):
    """As ``path_splitting.render_tile``, where all pixels of a group take a sample together. The blocks of pixels are
    wide and high in turn, so their borders do not show. Pixels that take more samples than others form groups of the
    whole tile, and so do pixels few of whose neighbours are due."""
    block, workspace, tile = blocks[0], workspaces[0], (x0, y0, x1, y1)
    first = samples
    for y in range(y0, y1):
        for x in range(x0, x1):
            pixel = pixel_index(block, x, y)
            if is_active(block, pixel):
                first = min(first, samples_had(block, pixel))
    for number in range(first, samples):
        wide = (number + block.sample_offset) & 1
        width, height = (2 * SIDE, SIDE) if wide else (SIDE, 2 * SIDE)
        for y in range(y0, y1, height):
            for x in range(x0, x1, width):
                if control_table(block)[0] != 0:
                    return
                render_block(blocks, workspace, tile, x, y, wide, number)
        turn = 1
        while render_rest(blocks, workspace, tile, wide, number, turn):
            turn += 1
