# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections from a surface to vertices of light paths, and what they leave to paths.

Light that a place y scatters to a point x, which scatters it on, is estimated twice. Strategy 1 connects x with
vertices of light paths; all earlier bounces are in these. Strategy 2 is the path, whose ray from x meets y. What a
mirror scatters at either end is left to it. The weights w₁ and w₂ = 1 − w₁ do not depend on the vertices, so any are
right:

    w₁ = min(1, α/β) · s(y),   α = n₁ p(y|x),   β = RELIEF · n₂ · p(ω|x) cos_y / d².

p(y|x) is an estimate of the density of strategy 1 at y, and β that of strategy 2, with the density p(ω|x) of its BSDF
ray. A connection is worth as much as RELIEF rays, which need light rays and more bounces at y. As w₁ falls with d², no
connection is bright because it is short (Kollig and Keller 2004, "Illumination in the presence of weak singularities").
s is less than 1 where y scatters light from its direction by a sharp lobe: see ``left_by_lobes``.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel
from ....vec import ZERO, average, dot, length, madd, mul, negate, normalize, put, scale, sub, transform_normal, vec
from .. import lights
from ..caustic_paths import dispatch as caustic_paths
from ..caustic_paths.lobes import is_source
from ..geometry import TRIANGLES, hit_material, instance_at, instance_table, surface_at
from ..path import BEYOND, CAMERA, NOWHERE, contribute, path_table
from ..ray_origins import spawn_ray
from ..rays import hit_instance, hit_normal, ray_table
from ..samplers import get_1d, get_2d
from ..shading import evaluate, shade
from ..shading.caustics import blur_lobes
from ..shading.records import DIFFUSE, MICROFACET, SCATTERED, closure_table, surface_table
from ..visibility import shadow_ray, transmittance
from ..workspace import secondary_table
from . import tree
from .records import (
    AT_VERTEX,
    CONNECTS,
    CONNECTS_ALL,
    FOLLOW_ALL,
    FOLLOW_DIFFUSE,
    choice_table,
    material_table,
    node_table,
    vertex_table,
)

RELIEF = 0.125
LEAST_LEFT = 0.3  # part of the light that connections before have left, from which on a path is connected again
LATER = 1  # row of choices of a surface after the one where the path split
BROAD = 1.0  # density (1/sr) of scattering up to which connections take all light; of diffuse scattering it is 1/π
CONNECTION_SETS, KIND_SETS, ROULETTE_SETS = 1 << 25, 1 << 26, 1 << 27  # of random numbers, beside those of path.py


@kernel
def weight(block, workspace, x, n, pdf, y, normal, wi, distance):
    """w₁ without s, for the light that y, with the geometric ``normal`` on the side of x, scatters to x. x has the
    shading normal n, and its BSDF draws wi with the density ``pdf``."""
    path, cosine = path_table(workspace)[0], -dot(normal, wi)
    if dot(n, wi) <= 0.0 or cosine <= 0.0 or not pdf > 0.0:
        return 0.0
    alpha = path.connections * tree.density(block, workspace, path.choice, x, n, y, normal)
    return min(alpha * distance * distance / (RELIEF * pdf * cosine), 1.0)


@kernel
def left_by_lobes(density):
    """s, where y scatters light with this density: sharp lobes are left to paths, which sample them."""
    return BROAD / max(density, BROAD)


@kernel
def breadth(closure):
    """About ``left_by_lobes`` for what a closure scatters: a microfacet lobe has the density 1 / (4 π α²) at most."""
    if closure.singular:
        return 0.0
    return min(BROAD * 4.0 * math.pi * closure.alpha * closure.alpha, 1.0) if closure.kind >= MICROFACET else 1.0


@kernel
def connect(block, workspace, _):
    """Connect the surface of the workspace with the path's number of vertices, for one branch of the path there."""
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    count = path.connections
    if not choice_table(workspace)[path.choice].total > 0.0:
        return 0.0
    x, n = vec(surface.position), vec(surface.n)
    for number in range(count):
        u, v = get_2d(path.index * count + number, path.seed, path.dimension + CONNECTION_SETS)
        at, probability = tree.draw(block, workspace, path.choice, x, n, u)
        node = node_table(block)[block.light_path_first_node + at]
        if probability > 0.0 and node.count > 0:
            index = node.first + min(int(v * node.count), node.count - 1)
            kinds = get_2d(path.index * count + number, path.seed, path.dimension + KIND_SETS)
            factor = node.count / (probability * count)
            _connect_with(block, workspace, x, n, vertex_table(block)[index], factor, kinds)
    return 0.0


@kernel
def reaches(block, path, vertex, here, there):
    """Whether a path from the camera would have come from here to the light beyond the vertex, by its limits:
    ``here`` and ``there`` are 1 where it would have counted the bounce at either end as glossy, 0 as diffuse. All that
    a surface passes on counts as transmission."""
    glossy, diffuse, transmission = here, 1 - here, 0
    if vertex.scatters > 1:  # how light rays are scattered does not count
        transmission = int(dot(vec(vertex.normal), vec(vertex.wi)) < 0.0)
        glossy, diffuse = glossy + there * (1 - transmission), diffuse + (1 - there) * (1 - transmission)
    return (
        path.diffuse + vertex.diffuse + diffuse <= block.diffuse_bounces
        and path.glossy + vertex.glossy + glossy <= block.glossy_bounces
        and path.transmission + vertex.transmission + transmission <= block.transmission_bounces
    )


@kernel
def _connect_with(block, workspace, x, n, vertex, factor, kinds):
    """Add what one vertex gives, times ``factor``. ``kinds``: two random numbers."""
    path = path_table(workspace)[0]
    if path.bounce + vertex.scatters > block.max_bounces:
        return
    y = vec(vertex.position)
    way = sub(y, x)
    distance = length(way)
    if distance <= 0.0:
        return
    wi = scale(way, 1.0 / distance)
    normal = vec(vertex.normal)
    cosine = -dot(normal, wi)
    if cosine <= 0.0:
        return
    value, density, glossy_pdf = evaluate(block, workspace, wi, SCATTERED)
    if average(value) <= 0.0:
        return
    part = weight(block, workspace, x, n, density, y, normal, wi, distance)
    if part <= 0.0:
        return
    secondary = secondary_table(workspace)[0]
    footprint = distance * block.camera_pixel_angle + block.camera_pixel_width
    surface_at(
        block,
        surface_table(secondary)[0],
        vertex.instance,
        vertex.primitive,
        vertex.u,
        vertex.v,
        negate(wi),
        DIFFUSE,
        footprint,
    )
    shade(block, secondary)
    blur_lobes(block, secondary, min(path.least_pdf, density))
    scattered, density_there, glossy_there = evaluate(block, secondary, vec(vertex.wi), SCATTERED)
    value = mul(mul(value, scattered), vec(vertex.flux))
    if average(value) <= 0.0:
        return
    u, v = kinds
    if not reaches(block, path, vertex, int(u * density < glossy_pdf), int(v * density_there < glossy_there)):
        return
    start = spawn_ray(workspace, surface_table(workspace)[0], wi)
    direction, t_max = shadow_ray(x, start, wi, distance)
    passed = path.transparent
    if block.transparent_shadows:
        path.transparent += vertex.transparent
        if path.transparent > block.transparent_bounces:
            path.transparent = passed
            return
    value = mul(value, transmittance(block, workspace, start, direction, t_max, lights.blockers(block, vertex.emitter)))
    path.transparent = passed
    # The flux through the surface is its irradiance by area.
    geometry = cosine / (distance * distance * abs(dot(vec(vertex.normal), vec(vertex.wi))))
    factor *= part * left_by_lobes(density_there)
    if block.caustic_paths and path.kind == CAMERA and path.transparent == 0 and vertex.scatters == 1:
        if is_source(block, vertex.emitter):
            factor *= caustic_paths.left_to_vertex(block, workspace, wi, density, density_there)
    if path.connects == BEYOND:
        put(path.connection_weight, scale(vec(path.followed_weight), left_by_lobes(density)))
    contribute(block, workspace, value, factor * geometry, vertex.emitter, path.bounce + 1 + vertex.scatters)


@kernel
def record_connected(block, workspace, x, y, z):
    """Note what part of the light from the direction (x, y, z) connections estimate, once the path's surface has
    scattered that: ``followed_weight`` of what closures scatter that light paths ``follow`` there."""
    path, wi = path_table(workspace)[0], (x, y, z)
    if path.follow & FOLLOW_ALL:
        put(path.connection_weight, vec(path.followed_weight))
    elif path.follow & AT_VERTEX:
        _, density, _ = evaluate(block, workspace, wi, SCATTERED)
        put(path.connection_weight, scale(vec(path.followed_weight), left_by_lobes(density)))
    elif path.follow & FOLLOW_DIFFUSE == 0:
        put(path.connection_weight, ZERO)
    else:
        diffuse, _, _ = evaluate(block, workspace, wi, DIFFUSE)
        total, _, _ = evaluate(block, workspace, wi, SCATTERED)
        for axis in range(3):
            part = diffuse[axis] / total[axis] if total[axis] > 0.0 else 0.0
            path.connection_weight[axis] = path.followed_weight[axis] * part
    return 0.0


@kernel
def estimated_path_weight(block, workspace, _):
    """The part of the light from where the path's ray has met a surface that connections leave to it, as far as known
    before that is shaded."""
    path, ray = path_table(workspace)[0], ray_table(workspace)[0]
    instance = instance_at(block, hit_instance(ray))
    if block.light_path_roulette >= 1.0 or instance.primitive != TRIANGLES:
        return 1.0
    if material_table(block)[hit_material(instance, block, np.int64(ray.primitive))] & CONNECTS_ALL == 0:
        return 1.0
    x, wi = vec(path.origin), vec(path.direction)
    normal = hit_normal(ray)
    normal = normalize(normal if instance.baked else transform_normal(instance.inverse, normal))
    if dot(normal, wi) > 0.0:
        normal = negate(normal)
    y = madd(x, path.length, wi)
    return 1.0 - average(vec(path.connection_weight)) * weight(
        block, workspace, x, vec(path.normal), path.pdf, y, normal, wi, path.length
    )


@kernel
def apply_path_weight(block, workspace, _):
    """Leave to connections what they find of the light that the surface of the workspace scatters. 0 if the path ends.

    They find w₁ of what is scattered where the ray from x arrives, and later what light paths follow. The
    path ends with the chance that this leaves over, but where other light may come that way. Closures are drawn as
    often as before: limits of bounces depend on what is drawn.
    """
    path, surface, closures = path_table(workspace)[0], surface_table(workspace)[0], closure_table(workspace)
    triangle = instance_table(block)[surface.instance].primitive == TRIANGLES
    flags = material_table(block)[surface.material] if triangle else 0
    if path.connects == BEYOND:
        path.follow = flags
        put(path.followed_weight, vec(path.connection_weight))
        return 1.0
    path.connects, path.follow = BEYOND, AT_VERTEX
    x, y = vec(path.origin), vec(surface.position)
    way = sub(y, x)
    distance = length(way)
    part = 0.0
    if flags & CONNECTS and distance > 0.0:
        wi = scale(way, 1.0 / distance)
        part = weight(block, workspace, x, vec(path.normal), path.pdf, y, vec(surface.ng), wi, distance)
    if part <= 0.0:
        path.connects = NOWHERE
        return 1.0
    put(path.followed_weight, scale(vec(path.connection_weight), part))
    connected, total = average(vec(path.followed_weight)), 0.0
    for index in range(surface.closure_count):
        total += closures[index].pick * (1.0 - connected * breadth(closures[index]))
    survival = min(max(total / path.path_weight, block.light_path_roulette), 1.0)
    path.path_weight = 1.0
    if survival < 1.0:
        if get_1d(path.index, path.seed, path.dimension + ROULETTE_SETS) >= survival:
            return 0.0
        put(path.throughput, scale(vec(path.throughput), 1.0 / survival))
    return 1.0


@kernel
def connect_again(block, workspace, _):
    """Connect the surface of the workspace, which is not the one where the path split, where connections before have
    left most of the light to the path: behind mirrors, in sharp lobes, and near the surface before.
    """
    path = path_table(workspace)[0]
    left = path.unconnected
    if path.connects == BEYOND:
        left *= 1.0 - path.followed_weight[0]
    if left < LEAST_LEFT:
        return 0.0
    path.connects_again, path.choice, path.connections = 1, LATER, 1
    tree.choose(block, workspace, float(LATER))
    connect(block, workspace, 0.0)
    return 0.0
