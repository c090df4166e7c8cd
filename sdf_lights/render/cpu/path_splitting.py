# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of pixels: paths that divide into branches at the first surface that scatters light."""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel, table
from ...vec import largest, madd, put, scale, vec
from ..kernels import lights
from ..kernels.film import add_sample, branches_before, branches_of, is_active, pixel_index, samples_due
from ..kernels.integrator import (
    GOES_ON,
    intersect_and_gather,
    prepare_ray,
    scatter,
    shade_and_scatter,
    start_path,
    trace_path,
)
from ..kernels.light_paths import dispatch as light_paths
from ..kernels.media.records import inside_table
from ..kernels.motion import block_at, draw_time
from ..kernels.outputs import dispatch as outputs
from ..kernels.outputs.records import CATCHERS
from ..kernels.outputs.state import keep_first_scattering, use_first_scattering
from ..kernels.path import (
    AT_EXIT,
    AT_SURFACE,
    BEFORE,
    EMISSION_SET,
    FIRST_BRANCH,
    FIRST_BRANCH_RAY,
    VERTEX_SETS,
    WAITING,
    WHITE,
    clear_sample,
    path_table,
    sample_table,
)
from ..kernels.rays import hit_instance, ray_table
from ..kernels.samplers import get_1d, pixel_seed
from ..kernels.workspace import cut_table

# Figures are error × time without a constant, over that with it: see the tables of docs/sampling.md.
# Of a branch: estimates know nothing of what shadows, and of light by other ways. Without it: 1.0 to 1.3. Without
# any Russian roulette of branches: 1.0 to 1.5.
LEAST_SURVIVAL = 0.3
# Times, in surfaces that rays meet: of a connection, and of the weights that a ray beside connections needs at its next
# hit.
CONNECTION_COST, WEIGHTS_COST = 0.6, 0.4
LEAST_PATH_WEIGHT = 0.02  # of a branch: no estimate may remove what connections do not find. Without: 1.0 to 1.3

control_table = table("control", np.int64)


@kernel
def save_state(block, workspace, row):
    """Keep what the path is inside of, and how it was scattered first, with the other state of a branch."""
    if block.has_media:
        inside_table(workspace)[row] = inside_table(workspace)[0]
    keep_first_scattering(block, workspace, row)


@kernel
def restore_state(block, workspace, row):
    """Give the path itself what ``save_state`` has kept of path number ``row``."""
    if block.has_media:
        inside_table(workspace)[0] = inside_table(workspace)[row]
    use_first_scattering(block, workspace, row)


@kernel
def brightness(sample):
    """What a sample has so far, as a sum of RGB."""
    return sample.combined[0] + sample.combined[1] + sample.combined[2]


@kernel
def trace_branches(block, workspace, x, y, branches, first_branch):
    """One sample of the pixel (x, y), in ``sample``. Its path divides into ``branches`` at the first surface that
    scatters light.

    What comes before is sampled once, and the branches, numbered from ``first_branch`` on, as evenly as all of a pixel.
    """
    if begin_sample(block, workspace, x, y, branches):
        follow_branches(block, workspace, branches, first_branch)


@kernel
def begin_sample(block, workspace, x, y, branches):
    """Follow a new path through the pixel (x, y) to where it should divide: True there."""
    sample = sample_table(workspace)[0]
    sample.branches = branches
    start_path(block, workspace, x, y)
    if not trace_path(block, workspace, True):
        return False
    sample.divided = 1
    put(sample.before, vec(sample.combined))
    put(sample.lamps_before, vec(sample.lamps))
    return True


@kernel
def follow_branches(block, workspace, branches, first_branch):
    """Follow the path of the workspace from where it divides to the ends of its branches."""
    paths, sample = path_table(workspace), sample_table(workspace)[0]
    if branches == 1 and not block.light_paths:
        follow_only_branch(block, workspace, first_branch)
        return
    divide_path(block, workspace, branches, first_branch, block.light_paths != 0)
    light = brightness(sample)
    for branch in range(branches):
        if paths[FIRST_BRANCH + branch].alive:
            follow_divided(block, workspace, branch)
        paths[FIRST_BRANCH + branch].brought += brightness(sample) - light
        light = brightness(sample)
    add_spread(workspace, branches)


@kernel
def follow_divided(block, workspace, branch):
    """Follow a branch from its first surface to its end."""
    path_table(workspace)[0] = path_table(workspace)[FIRST_BRANCH + branch]
    restore_state(block, workspace, FIRST_BRANCH + branch)
    ray_table(workspace)[0] = ray_table(workspace)[FIRST_BRANCH_RAY + branch]
    cut_table(workspace)[1].lamp = -1  # the branch before has left one of another point there
    if block.has_subsurface:
        cut_table(workspace)[0].lamp = -1  # or one of its exit here
    if shade_and_scatter(block, workspace, False) == GOES_ON:
        trace_path(block, workspace, False)


@kernel
def add_spread(workspace, branches):
    """Add to ``spread`` of the sample how what its branches have brought scatters. Each has brought its part of the
    sample: the mean over branches."""
    paths, sample, total = path_table(workspace), sample_table(workspace)[0], 0.0
    for branch in range(branches):
        total += paths[FIRST_BRANCH + branch].brought
    for branch in range(branches):
        sample.spread += (branches * paths[FIRST_BRANCH + branch].brought - total) ** 2


@kernel
def divide_path(block, workspace, branches, first_branch, connects):
    """Scatter the path of the workspace as so many branches, follow them to their next surfaces, and end some of
    them. ``connects``: whether it is connected to vertices of light paths."""
    paths, sample = path_table(workspace), sample_table(workspace)[0]
    paths[WAITING] = paths[0]
    save_state(block, workspace, WAITING)
    if connects:
        paths[WAITING].choice, paths[WAITING].connections = 0, block.light_path_connections
        light_paths.choose(block, workspace)
        sample.cuts += 1  # that takes as long as the boxes of a lamp
    for branch in range(branches):
        light = brightness(sample)
        paths[0] = paths[WAITING]
        restore_state(block, workspace, WAITING)
        paths[0].index, paths[0].branch_weight = first_branch + branch, 1.0 / branches
        if connects:
            light_paths.connect(block, workspace)
            sample.met += CONNECTION_COST * block.light_path_connections + WEIGHTS_COST
        paths[0].alive = int(scatter(block, workspace))
        paths[0].scale = largest(vec(paths[0].throughput))
        if connects and paths[0].alive and paths[0].pdf > 0.0 and paths[0].event != AT_EXIT:
            paths[0].connects = BEFORE
            put(paths[0].connection_weight, WHITE)
        paths[0].brought = brightness(sample) - light
        if block.has_subsurface:
            ray_table(workspace)[FIRST_BRANCH_RAY + branch] = ray_table(workspace)[0]
        paths[FIRST_BRANCH + branch] = paths[0]
        save_state(block, workspace, FIRST_BRANCH + branch)
    intersect_branches(block, workspace, branches)
    roulette_branches(workspace, branches)


@kernel
def follow_only_branch(block, workspace, first_branch):
    """Follow a path that does not split on from where it could: as with several branches, without keeping them."""
    path = path_table(workspace)[0]
    path.index = first_branch
    if scatter(block, workspace):
        path.dimension += VERTEX_SETS
        trace_path(block, workspace, False)


@kernel
def intersect_branches(block, workspace, branches):
    """Follow all branches to the next surface, and estimate how much light they will bring from there."""
    paths, rays = path_table(workspace), ray_table(workspace)
    sample = sample_table(workspace)[0]
    for branch in range(branches):
        if not paths[FIRST_BRANCH + branch].alive:
            continue
        light = brightness(sample)
        paths[0] = paths[FIRST_BRANCH + branch]
        restore_state(block, workspace, FIRST_BRANCH + branch)
        if block.has_subsurface:
            rays[0] = rays[FIRST_BRANCH_RAY + branch]
        path = paths[0]
        path.dimension += VERTEX_SETS
        path.alive = int(prepare_ray(block, workspace) and intersect_and_gather(block, workspace))
        if path.alive:
            position, number = vec(path.start), path.light_tree
            if path.event == AT_SURFACE:
                number = lights.tree_of(block, hit_instance(rays[0]))
            if path.event != AT_EXIT:
                position = madd(position, path.length, vec(path.direction))
            if block.light_paths and path.connects:
                path.path_weight = light_paths.estimated_path_weight(block, workspace)
            path.expected = largest(vec(path.throughput)) * lights.irradiance(block, number, position)
            rays[FIRST_BRANCH_RAY + branch] = rays[0]
        path.brought += brightness(sample) - light
        paths[FIRST_BRANCH + branch] = paths[0]
        save_state(block, workspace, FIRST_BRANCH + branch)


@kernel
def roulette_branches(workspace, branches):
    """Russian roulette: branches that are expected to bring less than their mean survive in proportion to that.

    One number decides on all of them, so how many do is nearly always the same (systematic sampling).
    """
    paths = path_table(workspace)
    waiting = paths[WAITING]
    total, count = 0.0, 0
    for branch in range(branches):
        path = paths[FIRST_BRANCH + branch]
        if path.alive:
            total += path.expected * max(path.path_weight, LEAST_SURVIVAL)
            count += 1
    if count < 2 or not 0.0 < total < np.inf:
        for branch in range(branches):
            paths[FIRST_BRANCH + branch].path_weight = 1.0
        return
    # The emission along the ray that came here may take this number, too: it is added to what branches bring.
    passed = get_1d(waiting.index, waiting.seed, waiting.dimension + EMISSION_SET)
    for branch in range(branches):
        path = paths[FIRST_BRANCH + branch]
        if path.alive:
            path.path_weight = max(path.path_weight, LEAST_PATH_WEIGHT)
            survival = min(path.path_weight * max(path.expected * count / total, LEAST_SURVIVAL), 1.0)
            path.alive = int(math.floor(passed + survival) > math.floor(passed))
            passed += survival
            path.path_weight = min(path.path_weight, survival)
            put(path.throughput, scale(vec(path.throughput), 1.0 / survival))


@kernel
def trace_catchers(blocks, block, workspace):
    """Follow the path of a sample that has met a shadow catcher, in the scene of only these: see ``render_tile``.
    ``block``: that of the sample."""
    if not outputs.release(block, workspace):
        return
    first = block.segments
    bare = blocks[block_at(blocks, first, block.time) if block.moves else first]
    invalidate_cuts(workspace)
    if bare.has_media:
        inside_table(workspace)[0].count = 0
    if shade_and_scatter(bare, workspace, False) == GOES_ON:
        trace_path(bare, workspace, False)
    invalidate_cuts(workspace)
    outputs.add_bare(block, workspace)


@kernel
def invalidate_cuts(workspace):
    """What light sampling has prepared is of another scene."""
    for row in range(2):
        cut_table(workspace)[row].lamp = -1
        lights.light_cut_table(workspace)[row].count = 0


@kernel
def render_tile(blocks, workspaces, x0, y0, x1, y1, samples):
    """Add samples to the active pixels of the tile [x0, x1) × [y0, y1), until those with the rate 1 have ``samples``.

    ``blocks`` has the scene, and then that of its shadow catchers alone where there are any: each once for each segment
    of the shutter.
    """
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
                path.index = block.sample_offset + index
                clear_sample(workspace)
                if block.moves:
                    time = draw_time(block, workspace, y)
                    block = blocks[block_at(blocks, 0, time)]
                if block.outputs:
                    outputs.clear(block, workspace)
                before = block.sample_offset * branches + branches_before(block, pixel)
                trace_branches(block, workspace, x, y, branches, before)
                if block.outputs & CATCHERS:
                    trace_catchers(blocks, block, workspace)
                add_sample(block, workspace, pixel, index)
