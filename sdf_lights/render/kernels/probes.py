# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that the nodes of a material trace: ambient occlusion, bevel, and hits in a given direction.

The models are those of Cycles. Formulas call these kernels; each is compiled separately, if a scene has its node. Rays
are traced where a path has hit a surface, not for transparency or light sampling.
"""

import math

import numpy as np

from ...jit import kernel
from ...vec import ZERO, add, dot, frame, length, madd, negate, normalize, scale, sub, vec
from ..scene import Ray
from .geometry import _fill_surface, surface_table
from .path import path_table
from .ray_origins import clear_self_primitive, spawn_ray
from .rays import SHADOW_OPAQUE, SHADOW_TRANSPARENT, beyond, hit_instance, intersect, occluded, ray_table
from .samplers import get_2d
from .workspace import secondary_table

# Sets of random numbers, in addition to those of ``path.VERTEX_SETS``. All nodes of a kind share them, as in Cycles.
OCCLUSION_SET = 1 << 25
BEVEL_SET = OCCLUSION_SET + 1

SHADOW = int(Ray.SHADOW)
NO_RAY = 0  # light sampling evaluates emission
ANY = int(Ray.ALL) | SHADOW_TRANSPARENT

SHARP = 8.0  # density from which on a scattered ray sees a bevel
PAST_SHIFT = 1.1  # a ray from a bump's shifted point begins this many times the shift away
_ITERATIONS, _PRECISION = 10, 1e-6


@kernel
def _is_met(surface):
    """Whether a path has met the surface."""
    return surface.ray_kind != NO_RAY and surface.ray_kind != SHADOW


@kernel
def _disk(u, v):
    """A point of the unit disk that keeps neighbours together (Shirley and Chiu 1997, "A low distortion map between
    disk and square")."""
    a, b = 2.0 * u - 1.0, 2.0 * v - 1.0
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0
    if abs(a) > abs(b):
        radius, angle = a, 0.25 * math.pi * (b / a)
    else:
        radius, angle = b, 0.5 * math.pi - 0.25 * math.pi * (a / b)
    return radius * math.cos(angle), radius * math.sin(angle)


@kernel
def _next_own(block, workspace, o, d, t_from, t_to):
    """Distance along a ray to the next triangle of the surface's own object, whose hit is left in the workspace;
    infinite: there is none."""
    own = surface_table(workspace)[0].instance
    start = t_from
    while intersect(block, workspace, o, d, start, t_to, ANY):
        ray = ray_table(workspace)[0]
        distance = float(ray.t_far)
        if hit_instance(ray) == own:
            return distance
        start = beyond(distance)
    return np.inf


@kernel
def occlusion(block, workspace, local, distance, samples, x, y, z):
    """Fraction of so many rays, cosine-distributed around the direction (x, y, z), that hit nothing up to ``distance``;
    with ``local`` only the surface's own object counts."""
    surface = surface_table(workspace)[0]
    count = int(samples)
    if not _is_met(surface) or distance <= 0.0 or count < 1:
        return 1.0
    path = path_table(workspace)[0]
    n = normalize((x, y, z))
    t, b = frame(n)
    free = 0
    for index in range(count):
        u = get_2d(path.index * count + index, path.seed, path.dimension + OCCLUSION_SET)
        side = _disk(u[0], u[1])
        up = math.sqrt(max(1.0 - side[0] * side[0] - side[1] * side[1], 0.0))
        d = add(add(scale(t, side[0]), scale(b, side[1])), scale(n, up))
        start = spawn_ray(workspace, surface, d)
        if local:
            met = _next_own(block, workspace, start, d, 0.0, distance) < np.inf
        else:
            met = occluded(block, workspace, start, d, 0.0, distance, SHADOW_OPAQUE | SHADOW_TRANSPARENT)
        if not met:
            free += 1
    return float(free) / float(count)


@kernel
def _falloff(radius, r):
    """Density (R − r)³ · 10 / (π R⁵) of a point at distance r on the disk of ``radius`` R."""
    rest = max(radius - r, 0.0) / radius
    return 10.0 * rest * rest * rest / (math.pi * radius * radius)


@kernel
def _falloff_radius(u):
    """Distance on the unit disk within which the fraction u of ``_falloff`` lies: 10 x² − 20 x³ + 15 x⁴ − 4 x⁵ = u, by
    Newton's method."""
    x = 0.25
    for _ in range(_ITERATIONS):
        square, rest = x * x, 1.0 - x
        error = square * (10.0 + x * (-20.0 + x * (15.0 - 4.0 * x))) - u
        slope = 20.0 * x * rest * rest * rest
        if abs(error) < _PRECISION or slope == 0.0:
            break
        x = min(max(x - error / slope, 0.0), 1.0)
    return x


@kernel
def _is_blurred(path):
    """Whether the path comes from a surface that scattered it too widely for a bevel."""
    return path.diffuse > 0 or path.volume > 0 or 0.0 < path.pdf < SHARP


@kernel
def bevel(block, workspace, radius, samples, x, y, z):
    """Mean normal of the object around the surface, up to ``radius``; its own normal (x, y, z) if no search is made.

    Probe rays along three axes find points of the surface (King et al. 2013, "BSSRDF importance sampling"), combined by
    the power heuristic.
    """
    surface, path, own = surface_table(workspace)[0], path_table(workspace)[0], (x, y, z)
    count = int(samples)
    if not _is_met(surface) or radius <= 0.0 or count < 1 or _is_blurred(path):
        return own
    other = surface_table(secondary_table(workspace)[0])[0]
    p, ng = vec(surface.position), vec(surface.ng)
    tangent, bitangent = frame(ng)
    ray = ray_table(workspace)[0]
    left = ray.id
    clear_self_primitive(ray)  # a probe may meet the triangle that it is for
    total = ZERO
    for index in range(count):
        u = get_2d(path.index * count + index, path.seed, path.dimension + BEVEL_SET)
        # Half of the probes go along the normal, a quarter along each tangent.
        along, first, second, place = ng, tangent, bitangent, 2.0 * u[0]
        pick, pick_first = 0.5, 0.25
        if u[0] >= 0.5:
            pick, pick_first = 0.25, 0.5
            if u[0] < 0.75:
                along, first, second, place = tangent, ng, bitangent, 4.0 * u[0] - 2.0
            else:
                along, first, second, place = bitangent, ng, tangent, 4.0 * u[0] - 3.0
        distance = radius * _falloff_radius(u[1])
        height = math.sqrt(max(radius * radius - distance * distance, 0.0))
        angle = 2.0 * math.pi * place
        aside = add(scale(first, distance * math.cos(angle)), scale(second, distance * math.sin(angle)))
        start, way = add(madd(p, height, along), aside), negate(along)
        drawn = _falloff(radius, distance)
        t = _next_own(block, workspace, start, way, 0.0, 2.0 * height)
        while t < np.inf:
            _fill_surface(block, ray_table(workspace)[0], other, along, NO_RAY, 0.0)
            normal = vec(other.ng)
            probability = pick * abs(dot(along, normal))
            rival, third = pick_first * abs(dot(first, normal)), 0.25 * abs(dot(second, normal))
            squares = probability * probability + rival * rival + third * third
            if squares > 0.0 and drawn > 0.0:
                weight = probability / squares * _falloff(radius, length(sub(vec(other.position), p))) / drawn
                total = madd(total, -weight if other.backfacing else weight, vec(other.n))
            t = _next_own(block, workspace, start, way, beyond(t), 2.0 * height)
    ray.id = left
    square = dot(total, total)
    if not square > 0.0:
        return own
    return scale(total, (-1.0 if surface.backfacing else 1.0) / math.sqrt(square))


@kernel
def raycast(block, workspace, local, x, y, z, dx, dy, dz, distance, at_x, at_y, at_z):
    """The hit of the ray from (x, y, z) along (dx, dy, dz): 1 if anything, 1 if it is the surface's own object,
    distance, normal (x, y, z) on the ray's side, instance, triangle, and barycentric coordinates of its second and
    third vertex.

    (at_x, at_y, at_z) is the surface's point, which bumps shift.
    """
    surface = surface_table(workspace)[0]
    if not _is_met(surface) or distance <= 0.0:
        return 0.0, 0.0, distance, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    start, d, p = (x, y, z), (dx, dy, dz), vec(surface.position)
    near = PAST_SHIFT * length(sub((at_x, at_y, at_z), p))
    ray = ray_table(workspace)[0]
    left = ray.id
    if near == 0.0 and x == p[0] and y == p[1] and z == p[2]:
        start = spawn_ray(workspace, surface, d)
    else:
        clear_self_primitive(ray)  # from elsewhere it may meet the triangle that it is for
    if local:
        found = _next_own(block, workspace, start, d, near, distance) < np.inf
    else:
        found = intersect(block, workspace, start, d, near, distance, ANY)
    ray.id = left
    if not found:
        return 0.0, 0.0, distance, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    other = surface_table(secondary_table(workspace)[0])[0]
    _fill_surface(block, ray, other, negate(d), NO_RAY, 0.0)
    same = 1.0 if other.instance == surface.instance else 0.0
    return (
        1.0,
        same,
        float(ray.t_far),
        other.n[0],
        other.n[1],
        other.n[2],
        float(other.instance),
        float(other.primitive),
        other.barycentric[0],
        other.barycentric[1],
    )
