# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices of light paths that all points of a group look at.

Four points of the group draw vertices, a quarter of them each, as single paths do: see ``light_paths.connections``.
The vertex y then scatters its light to every point that sees it. Arrivals of branches estimate the same light. Both
share it by weights that depend on the points and on y, so any are right:

    w₁ = min(1, α/β),   α = Σ_r n_r p_r(y),   β = RELIEF Σ_k b_k p_k(y).

n_r is the number of vertices that the point r draws, with the density p_r(y), as the tree estimates it. b_k is the
number of branches of the point k, and p_k(y) the density by area with which its BSDF draws y, for rays of one kind. Of
w₁, a vertex that r has drawn brings the part n_r p_r(y) / α. Where y does not scatter the same light in all directions,
w₁ is less by ``left_by_lobes``, for each point and the direction from where the light of the vertex came.
"""

from __future__ import annotations

from ....jit import kernel
from ....vec import ZERO, average, dot, length, mul, put, put_sum, scale, sub, vec
from ..caustic_paths.lobes import is_source, left_by_lobe
from ..caustic_paths.weights import lines_of
from ..geometry import TRIANGLES, instance_table, shading_material_table, surface_at
from ..light_paths import tree
from ..light_paths.connections import CONNECTION_SETS, left_by_lobes, reaches
from ..light_paths.records import FIRST_OF_GROUP, REPRESENTATIVES, node_table, vertex_table
from ..path import path_table, sample_table
from ..samplers import get_2d
from ..shading import evaluate, shade
from ..shading.records import DIFFUSE, GLOSSY, NEEDS_RAY, SCATTERED, TRACES_RAYS, surface_table
from ..workspace import point_workspaces, secondary_table
from .arrivals import LOOK_COST, SHADE_COST, copy_surface, is_even, is_shareable, look_at_arrival, shade_arrival
from .records import GROUP, GROUP_SAMPLE, GROUP_START, arrival_table, point_table

RELIEF = 0.5  # what an arrival is worth beside vertices
VERTICES = 4  # that each representative draws for each branch of a point
VERTEX_COST = 2.0  # time of a vertex beside that of the points that look at it, in surfaces that rays meet
EVEN, UNEVEN, UNSHARED = range(3)


@kernel
def part_of(alpha, density):
    """w₁ of a place, by α and the density of branches there."""
    return min(alpha / (RELIEF * density), 1.0) if density > 0.0 else 0.0


@kernel
def representative(workspace, number):
    """The surface of the point of the group that draws a quarter of the vertices."""
    point = number * arrival_table(workspace)[0].points // REPRESENTATIVES
    return surface_table(point_workspaces(workspace)[point])[0]


@kernel
def drawn_density(block, workspace, number, y, normal, place):
    """p_r(y) of a representative. ``place``: of y, by ``tree.find``."""
    surface = representative(workspace, number)
    x, n, (top, finest) = vec(surface.position), vec(surface.n), place
    return tree.density_at(block, workspace, FIRST_OF_GROUP + number, x, n, y, normal, top, finest)


@kernel
def vertices_each(workspace):
    """How many vertices each representative draws."""
    arrival = arrival_table(workspace)[0]
    return VERTICES * max(arrival.branches // arrival.points, 1)


@kernel
def density_of_vertices(block, workspace, _):
    """α of the arrival."""
    arrival, total = arrival_table(workspace)[0], 0.0
    y, normal = vec(arrival.position), vec(arrival.normal)
    place = tree.find(block, y, normal)
    for number in range(REPRESENTATIVES):
        total += drawn_density(block, workspace, number, y, normal, place)
    return total * vertices_each(workspace)


@kernel
def connect_points(block, workspace, _):
    """Give all points of the group the light of vertices of light paths."""
    start, arrival, some = path_table(workspace)[GROUP_START], arrival_table(workspace)[0], False
    each = vertices_each(workspace)
    for number in range(REPRESENTATIVES):
        surface = representative(workspace, number)
        some |= tree.expect(block, workspace, FIRST_OF_GROUP + number, vec(surface.position), vec(surface.n)) > 0.0
    if not some:
        return 0.0
    count = each * REPRESENTATIVES
    for draw in range(count):
        # Neighbours in the sampling pattern belong to one representative: all of these draw evenly.
        number = draw // each
        surface = representative(workspace, number)
        u, v = get_2d(start.index * count + draw, start.seed, start.dimension + CONNECTION_SETS)
        at, probability = tree.draw(block, workspace, FIRST_OF_GROUP + number, vec(surface.position), vec(surface.n), u)
        node = node_table(block)[at]
        if probability > 0.0 and node.count > 0:
            vertex = vertex_table(block)[node.first + min(int(v * node.count), node.count - 1)]
            _show_vertex(block, workspace, number, each, draw, vertex, node.count / (probability * each))
    for number in range(arrival.points):
        sample_table(workspace)[GROUP_SAMPLE + number].met += count * (LOOK_COST + VERTEX_COST / arrival.points)
        point = point_table(workspace)[number]
        point.connected_noise = max(point.squares - point.sum * point.sum / count, 0.0) * count / (count - 1.0)
        point.sum = point.squares = 0.0
    return 0.0


@kernel
def _show_vertex(block, workspace, number, each, turn, vertex, factor):
    """Let all points look at a vertex that a representative has drawn with the density 1 / ``factor``. If it is not
    even, one of so many does, as with arrivals: the ``turn`` says which."""
    start, arrival, points = path_table(workspace)[GROUP_START], arrival_table(workspace)[0], point_table(workspace)
    if start.bounce + vertex.scatters > block.max_bounces:
        return
    if block.transparent_shadows and start.transparent + vertex.transparent > block.transparent_bounces:
        return
    y, normal, wi = vec(vertex.position), vec(vertex.normal), vec(vertex.wi)
    alpha, own, place = 0.0, 0.0, tree.find(block, y, normal)
    for other in range(REPRESENTATIVES):
        density = each * drawn_density(block, workspace, other, y, normal, place)
        alpha += density
        if other == number:
            own = density
    if not own > 0.0:
        return
    put(arrival.position, y)
    put(arrival.normal, normal)
    arrival.u, arrival.v, arrival.instance, arrival.primitive = vertex.u, vertex.v, vertex.instance, vertex.primitive
    arrival.kind = DIFFUSE | GLOSSY
    x = vec(representative(workspace, number).position)
    sharing, even = _sharing(block, workspace, length(sub(y, x))), ZERO
    if sharing == EVEN:
        even, _, _ = evaluate(block, secondary_table(workspace)[0], wi, SCATTERED)
    if not (average(even) > 0.0 if sharing == EVEN else sharing == UNEVEN and block.light_path_all):
        return
    step = block.reuse_step if sharing == UNEVEN else 1
    diffuse, glossy = _look(block, workspace, step, turn, sharing == UNEVEN)
    # The flux through the surface is its irradiance by area.
    light = scale(vec(vertex.flux), factor * own / alpha * step / abs(dot(normal, wi)))
    of_diffuse, of_glossy = part_of(alpha / step, diffuse), part_of(alpha / step, glossy)
    lines = lamp_pdf = 0.0
    if block.caustic_paths and vertex.scatters == 1 and is_source(block, vertex.emitter):
        lines, lamp_pdf = lines_of(block, surface_table(secondary_table(workspace)[0])[0])
    for at in range(arrival.points):
        point = points[at]
        if not point.visible:
            continue
        one, other = of_diffuse * (1.0 - point.part), of_glossy * point.part
        part = one * int(reaches(block, start, vertex, 0, 0)) + other * int(reaches(block, start, vertex, 1, 0))
        scattered = even
        if sharing == UNEVEN:
            scattered, density, lobes = evaluate(block, point_workspaces(workspace)[GROUP + at], wi, SCATTERED)
            if not density > 0.0:
                continue
            lobes /= density
            by_lobes = one * int(reaches(block, start, vertex, 0, 1)) + other * int(reaches(block, start, vertex, 1, 1))
            part = (part * (1.0 - lobes) + by_lobes * lobes) * left_by_lobes(density)
            if lines > 0.0:
                part *= left_by_lobe(point_workspaces(workspace)[GROUP + at], lines, lamp_pdf, density, point.rival)
        _give(block, workspace, at, scale(mul(scattered, light), part), vertex.emitter < block.lamp_count)


@kernel
def _look(block, workspace, step, turn, shades):
    """Let every ``step``-th point look at the place of the arrival, which it ``shades`` or not. Returns the densities
    by area of their branches there, of diffuse and of glossy rays."""
    arrival, points, diffuse, glossy = arrival_table(workspace)[0], point_table(workspace), 0.0, 0.0
    samples = sample_table(workspace)
    look_at_arrival(block, workspace, turn, step)
    for at in range(arrival.points):
        point = points[at]
        if shades and point.visible:
            samples[GROUP_SAMPLE + at].met += SHADE_COST
            shade_arrival(block, workspace, at)
            copy_surface(secondary_table(workspace)[0], point_workspaces(workspace)[GROUP + at])
            point.visible = int(is_shareable(point_workspaces(workspace)[GROUP + at]))
        if point.visible:
            density = point.branches * point.area_pdf
            diffuse += density * (1.0 - point.part)
            glossy += density * point.part
    return diffuse, glossy


@kernel
def _give(block, workspace, number, light, of_lamp):
    """Add the ``light`` (RGB) from the place of the arrival to the sample of a point."""
    point, sample = point_table(workspace)[number], sample_table(workspace)[GROUP_SAMPLE + number]
    value = mul(mul(vec(point.throughput), vec(point.value)), light)
    brought = value[0] + value[1] + value[2]
    if 0.0 < block.clamp_indirect < brought:
        value, brought = scale(value, block.clamp_indirect / brought), block.clamp_indirect
    put_sum(sample.combined, value)
    if of_lamp:
        put_sum(sample.lamps, value)
    point.sum += brought
    point.squares += brought * brought


@kernel
def _sharing(block, workspace, distance):
    """Whether the place of the arrival, which is shaded in the second workspace from its normal and this distance,
    scatters the same light in all directions (EVEN), may be shared nevertheless (UNEVEN), or not at all."""
    arrival, secondary = arrival_table(workspace)[0], secondary_table(workspace)[0]
    surface = surface_table(secondary)[0]
    if instance_table(block)[arrival.instance].primitive != TRIANGLES:
        return UNSHARED
    surface_at(
        block,
        surface,
        arrival.instance,
        arrival.primitive,
        arrival.u,
        arrival.v,
        vec(arrival.normal),
        DIFFUSE,
        distance * block.camera_pixel_angle + block.camera_pixel_width,
    )
    shade(block, secondary)
    flags = shading_material_table(block)[surface.material].flags
    if is_even(secondary, flags):
        return EVEN
    return UNSHARED if flags & (NEEDS_RAY | TRACES_RAYS) else UNEVEN
