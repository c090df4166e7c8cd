# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrivals: surfaces that branches have found, and that all paths of their group look at.

The light of an arrival y that is not diffuse differs for the points x_k that see it. Together they are a mixture: a
branch of any of them may have found y, and may go on from there in any direction ω. So y scatters as the mean of what
the points see, weighed by their parts in the density of y,

    w_k = b_k p_k(y) / Σ_j b_j p_j(y),     f̄(ω) = Σ_k w_k f_k(ω),     p̄(ω) = Σ_k w_k p_k(ω),

and light rays from y compete with p̄. The point x_i then takes f_i(ω) / f̄(ω) of what is found from ω: by the balance
heuristic over all points that see y (Veach 1997, equation 9.8). That is at most 1 / w_i, however sharp the lobes are.
"""

from __future__ import annotations

import math

from ....jit import kernel
from ....vec import ZERO, dot, largest, length, madd, negate, put, scale, sub, vec
from ..caustic_paths.lobes import left_by_lobe
from ..caustic_paths.weights import rival_of
from ..geometry import TRIANGLES, instance_table, shading_material_table, surface_at
from ..light_paths.connections import left_by_lobes
from ..light_paths.records import CONNECTS, material_table
from ..path import MIXED, REUSED, UNSHARED, WHITE, path_table, sample_table
from ..ray_packets import LANES, find_occluded, is_occluded, packet_table, put_ray
from ..rays import start_anew
from ..shading import evaluate, has_lobes, shade, transmits
from ..shading.caustics import blur_lobes, darken_microfacets
from ..shading.records import (
    DEPENDS_ON_VIEW,
    DIFFUSE,
    GLOSSY,
    LAMBERT,
    MICROFACET,
    NEEDS_RAY,
    SCATTERED,
    SUBSURFACE,
    TRACES_RAYS,
    TRANSMISSION,
    VELVET,
    closure_table,
    surface_table,
)
from ..visibility import ray_towards
from ..workspace import point_workspaces, secondary_table
from .records import BY_LAMP, BY_LIGHT, GROUP, GROUP_SAMPLE, arrival_table, point_table

# Times, in surfaces that rays meet: of a point that looks at an arrival, and of shading that for the point.
LOOK_COST, SHADE_COST = 0.12, 0.38
PER_PI = 1.0 / math.pi  # a product takes less time than a quotient


@kernel
def is_reusable(workspace):
    """Whether all that the surface of the workspace scatters is known for any pair of directions: no light passes
    straight, and no closure is compiled separately."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    for index in range(surface.closure_count):
        kind = closures[index].kind
        if kind > MICROFACET or kind == VELVET or kind == SUBSURFACE:
            return False
    return surface.closure_count > 0 and largest(vec(surface.transparency)) <= 0.0


@kernel
def is_shareable(workspace):
    """Whether a surface that a branch has met ``is_reusable``, and has no mirrors or clear glass."""
    surface = surface_table(workspace)[0]
    return surface.evaluable >= surface.closure_count and is_reusable(workspace)


@kernel
def is_even(workspace, flags):
    """Whether the surface of the workspace, whose material has these ``flags``, scatters the same light in all
    directions."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    if flags & (DEPENDS_ON_VIEW | NEEDS_RAY | TRACES_RAYS) or not is_shareable(workspace):
        return False
    even = True
    for index in range(surface.closure_count):
        even = even and closures[index].kind == LAMBERT
    return even


@kernel
def copy_surface(workspace, other):
    """Copy the surface of a workspace, with its closures, to another."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    surface_table(other)[0] = surface
    for i in range(surface.closure_count):
        closure_table(other)[i] = closures[i]


@kernel
def arrive(block, workspace, _):
    """Let a branch that has met the surface of the workspace bring its light as an arrival, if all can share it.

    Its sample, as it is now, goes to row ``path.row``. The path goes on as if the camera saw the surface, so its sample
    will be the radiance from there: towards the point of the branch (REUSED), or of the mixture of all points (MIXED).
    """
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    path.reused = UNSHARED
    if path.last or not is_shareable(workspace):
        return 0.0
    if instance_table(block)[surface.instance].primitive != TRIANGLES:
        return 0.0
    flags = shading_material_table(block)[surface.material].flags
    if flags & (NEEDS_RAY | TRACES_RAYS):
        return 0.0
    arrival, samples = arrival_table(workspace)[0], sample_table(workspace)
    arrival.connected = 0.0
    arrival.even = int(is_even(workspace, flags))
    arrival.connects = int(block.light_paths and material_table(block)[surface.material] & CONNECTS != 0)
    put(arrival.position, vec(surface.position))
    put(arrival.normal, vec(surface.ng))
    arrival.u, arrival.v = surface.barycentric[0], surface.barycentric[1]
    arrival.instance, arrival.primitive, arrival.kind = surface.instance, surface.primitive, path.kind
    if not arrival.even and not mix(block, workspace, path.row - GROUP_SAMPLE):
        return 0.0
    arrival.scale = largest(vec(path.throughput)) / path.scale
    put(arrival.throughput, scale(vec(path.throughput), path.branch_weight / arrival.scale))
    samples[path.row] = samples[0]
    put(path.throughput, WHITE)
    path.branch_weight, path.reused = 1.0, REUSED if arrival.even else MIXED
    return 0.0


@kernel
def pdf_of_kinds(kinds, pdf, glossy_pdf):
    """The part of a density ``pdf`` that rays of these kinds have: DIFFUSE, GLOSSY, or both."""
    return (glossy_pdf if kinds & GLOSSY else 0.0) + (pdf - glossy_pdf if kinds & DIFFUSE else 0.0)


@kernel
def _begin_look(block, workspace, number, lane):
    """Let a point of the group note what it would scatter of the light of the arrival, and put its ray there in a lane
    of the packet: False if it scatters nothing."""
    arrival, point = arrival_table(workspace)[0], point_table(workspace)[number]
    y, start = vec(arrival.position), vec(point.start)
    way = sub(y, vec(point.position))
    facing = -dot(vec(arrival.normal), way)
    if not (facing > 0.0 and dot(vec(point.ng), way) > 0.0):
        return False
    inverse = 1.0 / length(way)
    wi, geometry = scale(way, inverse), facing * inverse * inverse * inverse
    if point.lambert:
        pdf, part = dot(vec(point.lambert_normal), wi) * PER_PI, 0.0
        if not (pdf > 0.0 and arrival.kind & DIFFUSE):
            return False
        area_pdf = pdf * geometry
        put(point.value, scale(vec(point.lambert_weight), area_pdf))
    else:
        value, pdf, glossy_pdf = evaluate(block, point_workspaces(workspace)[number], wi, SCATTERED)
        of_kind = pdf_of_kinds(arrival.kind, pdf, glossy_pdf)
        if not of_kind > 0.0:
            return False
        part, area_pdf = glossy_pdf / pdf, of_kind * geometry
        put(point.value, scale(value, of_kind / pdf * geometry))
    direction, t_max = ray_towards(start, y, wi)
    put_ray(workspace, lane, number, start, direction, t_max, arrival.kind, point.number, point.least)
    put(point.direction, wi)
    if block.caustic_paths:
        point.rival = rival_of(block, vec(point.ng), point.area, wi, pdf)
    point.pdf, point.area_pdf, point.part = pdf, area_pdf, part
    return True


@kernel
def look_at_arrival(block, workspace, first, step):
    """Let every ``step``-th point of the group, that number ``first`` among them, look at the arrival. What it would
    scatter of its light is noted where it sees it.

    What blocks its view is what a ray of the arrival's kind meets, be it transparent or not: of behind that, no branch
    brings anything to share.
    """
    arrival, points = arrival_table(workspace)[0], point_table(workspace)
    packet, lanes = packet_table(workspace)[0], 0
    start_anew(block, workspace)
    for number in range(arrival.points):
        points[number].visible = 0
        if number % step == first % step and _begin_look(block, workspace, number, lanes):
            lanes += 1
        if lanes == LANES or (lanes > 0 and number == arrival.points - 1):
            find_occluded(block, workspace, lanes)
            for lane in range(lanes):
                points[packet.owner[lane]].visible = int(not is_occluded(workspace, lane))
            lanes = 0


@kernel
def look_from_all(block, workspace, source, step):
    """Let every ``step``-th point of the group look at the arrival from a branch of the point ``source``: whether that
    one sees it. Within rounding, at an edge, it may not."""
    arrival, points = arrival_table(workspace)[0], point_table(workspace)
    sample_table(workspace)[0].met += LOOK_COST * arrival.points / step
    arrival.density = 0.0
    look_at_arrival(block, workspace, source, step)
    for number in range(arrival.points):
        point = points[number]
        if point.visible:
            arrival.density += point.branches * point.area_pdf
    return points[source].visible != 0


@kernel
def shade_arrival(block, workspace, number):
    """Shade the arrival as the point sees it, in the second workspace."""
    arrival, point = arrival_table(workspace)[0], point_table(workspace)[number]
    secondary = secondary_table(workspace)[0]
    footprint = (
        length(sub(vec(arrival.position), vec(point.position))) * block.camera_pixel_angle + block.camera_pixel_width
    )
    surface_at(
        block,
        surface_table(secondary)[0],
        arrival.instance,
        arrival.primitive,
        arrival.u,
        arrival.v,
        negate(vec(point.direction)),
        arrival.kind,
        footprint,
    )
    shade(block, secondary)
    if arrival.kind == DIFFUSE and block.caustics != GLOSSY | TRANSMISSION:
        darken_microfacets(secondary, block.caustics)
    blur_lobes(block, secondary, min(point.least_pdf, point.pdf))


@kernel
def mix(block, workspace, source):
    """Shade the arrival from a branch of the point ``source`` as all points see it: False if that one does not.

    A point may see a surface that cannot be shared, such as one that is transparent at a grazing angle. It leaves the
    arrival to the others then.
    """
    arrival, points, step = arrival_table(workspace)[0], point_table(workspace), int(block.reuse_step)
    arrival.two_sided = arrival.has_glossy = 0
    if not look_from_all(block, workspace, source, step):
        return False
    sample_table(workspace)[0].met += SHADE_COST * arrival.points / step
    left_out = False
    for number in range(arrival.points):
        point = points[number]
        if point.visible:
            seen = point_workspaces(workspace)[GROUP + number]
            if number == source:
                copy_surface(workspace, seen)
            else:
                shade_arrival(block, workspace, number)
                copy_surface(secondary_table(workspace)[0], seen)
                if not is_shareable(seen):
                    point.visible, left_out = 0, True
    if left_out:
        arrival.density = 0.0
        for number in range(arrival.points):
            if points[number].visible:
                arrival.density += points[number].branches * points[number].area_pdf
    for number in range(arrival.points):
        point = points[number]
        if point.visible:
            seen = point_workspaces(workspace)[GROUP + number]
            point.part = point.branches * point.area_pdf / arrival.density
            arrival.two_sided |= int(transmits(seen))
            arrival.has_glossy |= int(has_lobes(seen))
    return True


@kernel
def part_of_kind(kind, pdf, glossy_pdf):
    """The part of a density ``pdf`` that rays of this kind have; all of it for light rays."""
    if kind <= BY_LIGHT or kind & TRANSMISSION or pdf <= 0.0:
        return 1.0
    return glossy_pdf / pdf if kind & GLOSSY else 1.0 - glossy_pdf / pdf


@kernel
def evaluate_arrival(block, workspace, x, y, z, kinds, ray):
    """As ``shading.evaluate`` for the direction (x, y, z), of the mixture: f̄ |cos| (RGB), p̄, and the part of that
    from lobes.

    ``ray`` is BY_LIGHT or BY_LAMP for a light ray, or the kind of the ray that goes on. Rays of each kind share among
    themselves, as each has limits of its own: as much of f̄ as they are of p̄.
    """
    arrival, points, path = arrival_table(workspace)[0], point_table(workspace), path_table(workspace)[0]
    shares = block.caustic_paths and path.caustic == 1 and path.lines > 0.0
    wi, kind, total, density, glossy, of_kind = (x, y, z), int(ray), ZERO, 0.0, 0.0, 0.0
    for number in range(arrival.points):
        point = points[number]
        if point.visible:
            value, pdf, glossy_pdf = evaluate(block, point_workspaces(workspace)[GROUP + number], wi, int(kinds))
            part = part_of_kind(kind, pdf, glossy_pdf)
            value = scale(value, part)
            if arrival.connected > 0.0:
                value = scale(value, 1.0 - arrival.connected * left_by_lobes(pdf))
            if shares and kind != BY_LIGHT:
                own = point_workspaces(workspace)[GROUP + number]
                point.left = left_by_lobe(own, path.lines, path.lamp_pdf, pdf, point.rival)
                if kind == BY_LAMP:
                    value = scale(value, point.left)
            if kind <= BY_LIGHT:
                put(point.by_light, value)
            else:
                put(point.onward, value)
            total = madd(total, point.part, value)
            density += point.part * pdf
            glossy += point.part * glossy_pdf
            of_kind += point.part * pdf * part
    if kind <= BY_LIGHT:
        put(arrival.by_light, total)
    else:
        put(arrival.onward, total)
    if of_kind > 0.0:
        total = scale(total, density / of_kind)
    return total[0], total[1], total[2], density, glossy
