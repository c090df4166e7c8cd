# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of groups of pixels whose paths share their branches (Bekaert, Sbert and Halton 2002, "Accelerating path
tracing by re-using paths").

The paths of a group divide at the points x_i. A branch from x_m arrives at y, a surface. The light that y scatters is
estimated once, and every point that sees y takes of it

    T_i f_i |cos| G L(y → x_i) / Σ_k b_k p_k(y),     G = cos_y / d².

T_i is the throughput of the path to x_i, b_k the number of branches of the point k, and p_k(y) the density by area with
which its BSDF draws y. The sum has the points that see y (balance heuristic). L depends on the direction where y is not
diffuse: light that y receives from ω counts by f_y(ω → x_i) / f_y(ω → x_m). That is noisy where the lobe of y is
sharp, so there only points share an arrival whose directions are closer than the lobe is wide.

Diffuse and glossy rays have limits of bounces of their own, so p_k(y) is the density of rays of the arrival's kind, and
the point scatters by the part of f_i that this kind has of the density.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel
from ...vec import ZERO, add, dot, largest, length, mul, negate, put, put_sum, scale, sub, vec
from ..kernels.film import add_sample, branches_before, branches_of, is_active, pixel_index, samples_due, samples_had
from ..kernels.geometry import surface_at
from ..kernels.integrator import GOES_ON, shade_and_scatter, trace_path
from ..kernels.path import (
    ARRIVES,
    FIRST_BRANCH,
    FIRST_BRANCH_RAY,
    ONWARD,
    REUSED,
    UNSHARED,
    clear_sample,
    path_table,
    sample_table,
)
from ..kernels.path_reuse import (
    GROUP,
    GROUP_PATH,
    GROUP_RAY,
    GROUP_SAMPLE,
    GROUP_START,
    SIDE,
    arrival_table,
    is_reusable,
    point_table,
)
from ..kernels.ray_origins import spawn_ray
from ..kernels.rays import SHADOW_OPAQUE, occluded, ray_table
from ..kernels.samplers import pixel_seed
from ..kernels.shading import evaluate, shade
from ..kernels.shading.caustics import blur_lobes
from ..kernels.shading.records import GLOSSY, MICROFACET, SCATTERED, TRANSMISSION, closure_table, surface_table
from ..kernels.visibility import shadow_ray
from ..kernels.workspace import cut_table, point_workspaces, secondary_table
from ..scene import Scene
from ..settings import PathReuse
from .block import PackedScene
from .light_paths import is_alike
from .path_splitting import add_spread, begin_sample, brightness, control_table, divide_path, follow_branches

# Arrivals that are not diffuse are shaded for each point, which takes time. Where most are so, every eighth point
# shares one. MOST_TIME: for an arrival on average, in surfaces that rays meet, up to which all points of the group do.
MOST_STEP, MOST_TIME = 8, 4.0
BROAD = 2.0  # roughness of a surface without lobes: all directions are alike
# Times, in surfaces that rays meet: of a point that looks at an arrival, and of shading that for the point.
LOOK_COST, SHADE_COST = 0.12, 0.38


def supports_path_reuse(scene: Scene, packed: PackedScene) -> bool:
    """Whether paths may share branches, and whether that is asked for.

    - Nothing moves, scatters in a volume or below surfaces, or catches shadows. There are no strands, and nothing is
      transparent: a path may pass that by chance.
    - Each object is met by all kinds of rays but the camera's, or by none, and no caustics are off: see ``is_alike``.
    - No pass wants parts of the light, or surface properties.
    """
    settings, block = scene.settings, packed.block[0]
    return bool(
        settings.path_reuse is not PathReuse.NEVER
        and not (settings.path_reuse is PathReuse.AUTOMATIC and settings.denoise)
        and settings.max_bounces > 0
        and not block["has_subsurface"]
        and not block["has_strands"]
        and not block["transparent_shadows"]
        and not block["outputs"]
        and is_alike(scene, packed)
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
def keep_point(workspace, number, pixel, index, branches):
    """Keep the surface of the workspace, where its path divides, as a point of the group."""
    surface, closures, path = surface_table(workspace)[0], closure_table(workspace), path_table(workspace)[0]
    own, point = point_workspaces(workspace)[number], point_table(workspace)[number]
    surface_table(own)[0] = surface
    for i in range(surface.closure_count):
        closure_table(own)[i] = closures[i]
    put(point.throughput, vec(path.throughput))
    point.least_pdf = path.least_pdf
    point.branches, point.pixel, point.index = branches, pixel, index
    point.sum = point.squares = 0.0


@kernel
def same_bounces(a, b):
    """Whether two paths have scattered as often, in each way."""
    return (
        a.bounce == b.bounce
        and a.diffuse == b.diffuse
        and a.glossy == b.glossy
        and a.transmission == b.transmission
        and a.transparent == b.transparent
    )


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
def look_at_arrival(block, workspace, number):
    """Let a point of the group look at the arrival, and note what it would scatter of its light."""
    arrival, point = arrival_table(workspace)[0], point_table(workspace)[number]
    own = point_workspaces(workspace)[number]
    surface = surface_table(own)[0]
    x = vec(surface.position)
    way = sub(vec(arrival.position), x)
    distance = length(way)
    if distance <= 0.0:
        return
    wi = scale(way, 1.0 / distance)
    cosine = -dot(vec(arrival.normal), wi)
    if cosine <= 0.0 or dot(vec(surface.ng), wi) <= 0.0:
        return
    value, pdf, glossy_pdf = evaluate(block, own, wi, SCATTERED)
    of_kind = glossy_pdf if arrival.kind == GLOSSY else pdf - glossy_pdf
    if not of_kind > 0.0:
        return
    start = spawn_ray(workspace, surface, wi)
    direction, t_max = shadow_ray(x, start, wi, distance)
    if occluded(block, workspace, start, direction, 0.0, t_max, SHADOW_OPAQUE):
        return
    geometry = cosine / (distance * distance)
    put(point.direction, wi)
    put(point.value, scale(value, of_kind / pdf * geometry))
    point.pdf, point.area_pdf, point.visible = pdf, of_kind * geometry, 1


@kernel
def are_alike(a, b, roughness):
    """Whether two directions from a surface are closer than its lobe is wide."""
    way = sub(a, b)
    return roughness >= BROAD or dot(way, way) <= roughness * roughness


@kernel
def shade_arrival(block, workspace, number):
    """Shade the arrival in the second workspace as the point sees it: the roughness of its sharpest lobe."""
    arrival, point = arrival_table(workspace)[0], point_table(workspace)[number]
    secondary = secondary_table(workspace)[0]
    surface, closures = surface_table(secondary)[0], closure_table(secondary)
    x = vec(surface_table(point_workspaces(workspace)[number])[0].position)
    footprint = length(sub(vec(arrival.position), x)) * block.camera_pixel_angle + block.camera_pixel_width
    surface_at(
        block,
        surface,
        arrival.instance,
        arrival.primitive,
        arrival.u,
        arrival.v,
        negate(vec(point.direction)),
        arrival.kind,
        footprint,
    )
    shade(block, secondary)
    blur_lobes(block, secondary, min(point.least_pdf, point.pdf))
    roughness = BROAD
    for i in range(surface.closure_count):
        if closures[i].kind == MICROFACET:
            roughness = min(roughness, closures[i].alpha)
    return roughness


@kernel
def density_of_group(workspace, number, count, roughness):
    """Σ b_k p_k(y) over the points that share the arrival with this one."""
    points, total = point_table(workspace), 0.0
    direction = vec(points[number].direction)
    for k in range(count):
        if points[k].visible and (k == number or are_alike(direction, vec(points[k].direction), roughness)):
            total += points[k].branches * points[k].area_pdf
    return total


@kernel
def spread_of_group(workspace, source, count):
    """The greatest distance between the directions of the point ``source`` and of another that sees the arrival."""
    points, greatest = point_table(workspace), 0.0
    for k in range(count):
        if points[k].visible:
            greatest = max(greatest, length(sub(vec(points[k].direction), vec(points[source].direction))))
    return greatest


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
    brought = value[0] + value[1] + value[2]
    point.sum += brought
    point.squares += brought * brought


@kernel
def relative_to(block, workspace, wi, whole):
    """f |cos| (RGB) of the arrival in the second workspace for light from wi, over ``whole`` (RGB)."""
    value, _, _ = evaluate(block, secondary_table(workspace)[0], wi, SCATTERED)
    return quotient(value, whole)


@kernel
def share_arrival(block, workspace, source, count, direct, rest, toward, onward):
    """Give the light of the arrival from a branch of the point ``source`` to all points that see it: ``direct``, by a
    light ray ``toward`` there, and the ``rest``, from ``onward``. Each is RGB, and RGB of lamps."""
    points, arrival, secondary = point_table(workspace), arrival_table(workspace)[0], secondary_table(workspace)[0]
    sample = sample_table(workspace)[GROUP_SAMPLE + source]
    step = 1 if arrival.even else int(block.reuse_step)
    sample.met += (LOOK_COST if arrival.even else LOOK_COST + SHADE_COST) * count / step
    arrival.number += 1
    arrival.uneven += 1 - arrival.even
    for number in range(count):
        points[number].visible = 0
        if number % step == source % step:
            look_at_arrival(block, workspace, number)
    if not points[source].visible:  # within rounding, at an edge: what no other point may count on
        add_to_point(block, workspace, source, vec(arrival.throughput), direct, rest, float(points[source].branches))
        return
    whole = density_of_group(workspace, source, count, BROAD)
    if arrival.even:
        for number in range(count):
            point = points[number]
            if point.visible:
                factor = scale(mul(vec(point.throughput), vec(point.value)), 1.0 / whole)
                add_to_point(block, workspace, number, factor, direct, rest, whole / point.area_pdf)
        return
    spread = spread_of_group(workspace, source, count)
    shade_arrival(block, workspace, source)
    by_light, _, _ = evaluate(block, secondary, toward, SCATTERED)
    by_path, _, _ = evaluate(block, secondary, onward, SCATTERED)
    for number in range(count):
        point = points[number]
        if not point.visible:
            continue
        roughness = shade_arrival(block, workspace, number)
        if number != source and not are_alike(vec(point.direction), vec(points[source].direction), roughness):
            continue
        # Where all directions are alike, no pair needs to be looked at.
        total = whole if 2.0 * spread <= roughness else density_of_group(workspace, number, count, roughness)
        factor = scale(mul(vec(point.throughput), vec(point.value)), 1.0 / total)
        by_ray = relative_to(block, workspace, toward, by_light) if largest(direct[0]) > 0.0 else ZERO
        by_onward = relative_to(block, workspace, onward, by_path) if largest(rest[0]) > 0.0 else ZERO
        first, second = (
            (mul(direct[0], by_ray), mul(direct[1], by_ray)),
            (mul(rest[0], by_onward), mul(rest[1], by_onward)),
        )
        add_to_point(block, workspace, number, factor, first, second, total / point.area_pdf)


@kernel
def follow_branch(block, workspace, at, count):
    """Follow the stored branch number ``at``, and share what it brings among the ``count`` points of the group."""
    paths, samples, arrival = path_table(workspace), sample_table(workspace), arrival_table(workspace)[0]
    path, row = paths[0], paths[GROUP_PATH + at].row
    samples[0], paths[0] = samples[row], paths[GROUP_PATH + at]
    ray_table(workspace)[0] = ray_table(workspace)[GROUP_RAY + at]
    cut_table(workspace)[0].lamp = cut_table(workspace)[1].lamp = -1  # those are of other points
    path.reused = UNSHARED if path.pdf <= 0.0 or path.kind == TRANSMISSION else ARRIVES
    before = brightness(samples[0])
    goes_on = shade_and_scatter(block, workspace, False) == GOES_ON
    if path.reused != REUSED:
        if goes_on:
            trace_path(block, workspace, False)
        point, brought = point_table(workspace)[row - GROUP_SAMPLE], brightness(samples[0]) - before
        point.sum += brought
        point.squares += brought * brought
        samples[row] = samples[0]
        return
    direct = scale(vec(samples[0].combined), arrival.scale)
    direct_lamps = scale(vec(samples[0].lamps), arrival.scale)
    toward, onward = vec(arrival.light_direction), vec(path.direction)
    if goes_on:
        path.reused = ONWARD
        trace_path(block, workspace, False)
    samples[row].met = samples[0].met
    light, lamps = scale(vec(samples[0].combined), arrival.scale), scale(vec(samples[0].lamps), arrival.scale)
    if not brightness(samples[0]) < math.inf:
        put_sum(samples[row].combined, light)  # this sample is left out, and those of others are not
    elif largest(light) > 0.0:
        rest = (sub(light, direct), sub(lamps, direct_lamps))
        share_arrival(block, workspace, row - GROUP_SAMPLE, count, (direct, direct_lamps), rest, toward, onward)


@kernel
def cell_turn(x, y, number):
    """A number that differs between cells and samples."""
    mixed = (x * 0x9E3779B1 + y * 0x85EBCA77 + number * 0xC2B2AE3D) & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 15)) * 0x2C1B3C6D & 0xFFFFFFFF
    return mixed >> 13


@kernel
def begin_pixel(block, workspace, x, y, pixel, index, count, stored):
    """The next sample of a pixel, as point number ``count`` of the group if its path can be: the new number of stored
    branches; −1 if the sample is complete, and in the film."""
    paths, samples = path_table(workspace), sample_table(workspace)
    branches = branches_of(block, pixel)
    before = block.sample_offset * branches + branches_before(block, pixel)
    paths[0].seed, paths[0].index = pixel_seed(x, y, block.seed), block.sample_offset + index
    clear_sample(workspace)
    if begin_sample(block, workspace, x, y, branches):
        if count == 0:
            paths[GROUP_START] = paths[0]
        if is_reusable(workspace) and same_bounces(paths[0], paths[GROUP_START]):
            keep_point(workspace, count, pixel, index, branches)
            divide_path(block, workspace, branches, before)
            add_spread(workspace, branches)
            samples[GROUP_SAMPLE + count] = samples[0]
            return keep_branches(workspace, count, branches, stored)
        follow_branches(block, workspace, branches, before)
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
        samples[0].spread += (point.branches - 1.0) * point.branches * noise
        add_sample(block, workspace, point.pixel, point.index)


@kernel
def render_group(block, workspace, tile, x0, y0, wide, group, number):
    """One more sample of each pixel of a group, as far as it is to have one by sample ``number`` of pixels of rate 1:
    False if none is. ``tile``: its corners, x0, y0, x1 and y1. The block of pixels at (x0, y0) is ``wide``, or else
    high, and has two groups."""
    points, count, stored, branches, some = point_table(workspace), 0, 0, 0, False
    for cell in range(GROUP):
        across, along = 2 * (cell % SIDE), cell // SIDE
        x, y = (x0 + across, y0 + along) if wide else (x0 + along, y0 + across)
        place = (group + cell_turn(x, y, number + block.sample_offset)) & 1
        x, y = (x + place, y) if wide else (x, y + place)
        if x >= tile[2] or y >= tile[3]:
            continue
        pixel = pixel_index(block, x, y)
        index, end = samples_due(block, pixel, number + 1)
        if index >= end or not is_active(block, pixel):
            continue
        some = True
        kept = begin_pixel(block, workspace, x, y, pixel, index, count, stored)
        if kept >= 0:
            branches += points[count].branches
            count, stored = count + 1, kept
    for at in range(stored):
        follow_branch(block, workspace, at, count)
    finish_group(block, workspace, count, branches)
    return some


@kernel
def render_tile_reusing(blocks, workspaces, x0, y0, x1, y1, samples):
    """As ``path_splitting.render_tile``, where all pixels of a group take a sample together. The blocks of pixels are
    wide and high in turn, so their borders do not show."""
    block, workspace = blocks[0], workspaces[0]
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
                for group in range(2):
                    while render_group(block, workspace, (x0, y0, x1, y1), x, y, wide, group, number):
                        pass
