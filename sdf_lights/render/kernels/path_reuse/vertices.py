# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices of light paths that all points of a group look at.

Four points of the group draw vertices, a quarter of them each, as single paths do: see ``light_paths.connections``.
The vertex y then scatters its light to every point that sees it. Arrivals of branches estimate the same light. Both
share it by weights that depend on the points and on y alone, so any are right:

    w₁ = min(1, α/β),   α = Σ_r n_r p_r(y),   β = RELIEF Σ_k b_k p_k(y).

n_r is the number of vertices that the point r draws, with the density p_r(y), as the tree estimates it. b_k is the
number of branches of the point k, and p_k(y) the density by area with which its BSDF draws y, for rays of one kind. Of
w₁, a vertex that r has drawn brings the part n_r p_r(y) / α. Only surfaces that scatter the same light in all
directions are connected: others are left to arrivals.
"""

from __future__ import annotations

from ....jit import kernel
from ....vec import ZERO, average, dot, mul, put, put_sum, scale, vec
from ..geometry import TRIANGLES, instance_table, shading_material_table, surface_at
from ..light_paths import tree
from ..light_paths.connections import CONNECTION_SETS, left_if_shared, reaches
from ..light_paths.records import FIRST_OF_GROUP, REPRESENTATIVES, node_table, vertex_table
from ..path import path_table, sample_table
from ..samplers import get_2d
from ..shading import evaluate, shade
from ..shading.records import DIFFUSE, GLOSSY, NEEDS_RAY, SCATTERED, TRACES_RAYS, surface_table
from ..workspace import point_workspaces, secondary_table
from .arrivals import LOOK_COST, is_even, is_reusable, look_at_arrival, shade_arrival
from .records import GROUP_SAMPLE, GROUP_START, arrival_table, point_table

VERTICES = 32  # that a group draws for each branch of a point
RELIEF = 0.5
EVEN, UNEVEN, OTHER = range(3)
VERTEX_COST = 2.0  # time of a vertex beside that of the points that look at it, in surfaces that rays meet


@kernel
def part_of(alpha, density):
    """w₁."""
    return min(alpha / (RELIEF * density), 1.0)


@kernel
def representative(workspace, number):
    """The surface of the point of the group that draws every fourth vertex."""
    point = number * arrival_table(workspace)[0].points // REPRESENTATIVES
    return surface_table(point_workspaces(workspace)[point])[0]


@kernel
def drawn_density(block, workspace, number, y, normal):
    """p_r(y) of a representative."""
    surface = representative(workspace, number)
    return tree.density(
        block, workspace, FIRST_OF_GROUP + number, vec(surface.position), vec(surface.n), y, normal
    )


@kernel
def vertices_of_group(block, workspace):
    """How many vertices each representative draws."""
    arrival, points, branches = arrival_table(workspace)[0], point_table(workspace), 0
    for number in range(arrival.points):
        branches += points[number].branches
    return block.light_path_connections * max(branches // arrival.points, 1)


@kernel
def density_of_vertices(block, workspace, _):
    """α / RELIEF of the arrival: w₁ is this over the arrival's density, 1 at most."""
    arrival, total = arrival_table(workspace)[0], 0.0
    for number in range(REPRESENTATIVES):
        total += drawn_density(block, workspace, number, vec(arrival.position), vec(arrival.normal))
    return total * vertices_of_group(block, workspace)


@kernel
def connect_points(block, workspace, _):
    """Give all points of the group the light of vertices of light paths."""
    paths, arrival, samples = path_table(workspace), arrival_table(workspace)[0], sample_table(workspace)
    start, each, some = paths[GROUP_START], vertices_of_group(block, workspace), False
    for number in range(REPRESENTATIVES):
        surface = representative(workspace, number)
        some |= tree.expect(block, workspace, FIRST_OF_GROUP + number, vec(surface.position), vec(surface.n)) > 0.0
    if not some:
        return 0.0
    count = each * REPRESENTATIVES
    for draw in range(count):
        number = draw // each
        surface = representative(workspace, number)
        u, v = get_2d(start.index * count + draw, start.seed, start.dimension + CONNECTION_SETS)
        at, probability = tree.draw(
            block, workspace, FIRST_OF_GROUP + number, vec(surface.position), vec(surface.n), u
        )
        node = node_table(block)[at]
        if probability > 0.0 and node.count > 0:
            vertex = vertex_table(block)[node.first + min(int(v * node.count), node.count - 1)]
            _show_vertex(block, workspace, number, each, vertex, node.count / (probability * each), draw)
    for number in range(arrival.points):
        samples[GROUP_SAMPLE + number].met += count * (LOOK_COST + VERTEX_COST / arrival.points)
        point = point_table(workspace)[number]
        point.connected_noise = max(point.squares - point.sum * point.sum / count, 0.0) * count / (count - 1.0)
        point.sum = point.squares = 0.0
    return 0.0


@kernel
def _show_vertex(block, workspace, number, each, vertex, factor, turn):
    """Let all points look at a vertex that a representative has drawn, with 1 / ``factor`` as its density. If it is not
    even, every so manieth does, by ``turn``."""
    start, arrival, points = path_table(workspace)[GROUP_START], arrival_table(workspace)[0], point_table(workspace)
    if start.bounce + vertex.scatters > block.max_bounces:
        return
    y, normal = vec(vertex.position), vec(vertex.normal)
    alpha, own = 0.0, 0.0
    for each_one in range(REPRESENTATIVES):
        found = each * drawn_density(block, workspace, each_one, y, normal)
        alpha += found
        if each_one == number:
            own = found
    if not own > 0.0:
        return
    put(arrival.position, y)
    put(arrival.normal, normal)
    arrival.u, arrival.v, arrival.instance, arrival.primitive = vertex.u, vertex.v, vertex.instance, vertex.primitive
    arrival.kind = DIFFUSE | GLOSSY
    kind = _kind_of(block, workspace)
    if kind == OTHER or kind == UNEVEN and not block.light_path_all:
        return
    step = block.reuse_step if kind == UNEVEN else 1
    light = scale(vec(vertex.flux), factor * own / alpha * step / abs(dot(normal, vec(vertex.wi))))
    even = ZERO
    if kind == EVEN:
        even, _, _ = evaluate(block, secondary_table(workspace)[0], vec(vertex.wi), SCATTERED)
        if average(even) <= 0.0:
            return
    diffuse = glossy = 0.0
    for at in range(arrival.points):
        point = points[at]
        point.visible = 0
        if at % step == turn % step:
            look_at_arrival(block, workspace, at)
            if point.visible:
                density = point.branches * point.area_pdf
                diffuse += density * (1.0 - point.part)
                glossy += density * point.part
    one = part_of(alpha / step, diffuse) if diffuse > 0.0 else 0.0
    other = part_of(alpha / step, glossy) if glossy > 0.0 else 0.0
    one_diffuse, other_diffuse = (
        one * int(reaches(block, start, vertex, 0, 0)), other * int(reaches(block, start, vertex, 1, 0))
    )
    one_glossy, other_glossy = (
        one * int(reaches(block, start, vertex, 0, 1)), other * int(reaches(block, start, vertex, 1, 1))
    )
    for at in range(arrival.points):
        point = points[at]
        if not point.visible:
            continue
        part = one_diffuse * (1.0 - point.part) + other_diffuse * point.part
        scattered = even
        if kind == UNEVEN:
            shade_arrival(block, workspace, at)
            scattered, density, lobes = evaluate(block, secondary_table(workspace)[0], vec(vertex.wi), SCATTERED)
            if not density > 0.0:
                continue
            lobes /= density
            of_lobes = one_glossy * (1.0 - point.part) + other_glossy * point.part
            part = (part * (1.0 - lobes) + of_lobes * lobes) * left_if_shared(density)
        value = scale(mul(mul(vec(point.throughput), vec(point.value)), mul(scattered, light)), part)
        brought = value[0] + value[1] + value[2]
        if 0.0 < block.clamp_indirect < brought:
            value, brought = scale(value, block.clamp_indirect / brought), block.clamp_indirect
        sample = sample_table(workspace)[GROUP_SAMPLE + at]
        put_sum(sample.combined, value)
        if vertex.emitter < block.lamp_count:
            put_sum(sample.lamps, value)
        point.sum += brought
        point.squares += brought * brought


@kernel
def _kind_of(block, workspace):
    """Whether the place of the arrival, which is shaded in the second workspace from its normal, scatters the same
    light in all directions (EVEN), or may be shared at least (UNEVEN)."""
    arrival, secondary = arrival_table(workspace)[0], secondary_table(workspace)[0]
    surface = surface_table(secondary)[0]
    if instance_table(block)[arrival.instance].primitive != TRIANGLES:
        return OTHER
    surface_at(
        block,
        surface,
        arrival.instance,
        arrival.primitive,
        arrival.u,
        arrival.v,
        vec(arrival.normal),
        DIFFUSE,
        block.camera_pixel_width,
    )
    shade(block, secondary)
    flags = shading_material_table(block)[surface.material].flags
    if is_even(block, secondary, flags):
        return EVEN
    if flags & (NEEDS_RAY | TRACES_RAYS) or surface.evaluable < surface.closure_count or not is_reusable(secondary):
        return OTHER
    return UNEVEN
