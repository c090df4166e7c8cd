# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where light rays start on triangles with smooth normals.

Such a triangle stands for a curved surface that it does not follow, so its shadows end at its edges: the shadow
terminator (Hanika 2021, "Hacking the shadow terminator", Ray Tracing Gems II, chapter 4). As in Cycles with its
geometry offset, light rays near the horizon start on a parabola above the triangle.
"""

from __future__ import annotations

from ...jit import kernel
from ...vec import add, dot, madd, scale, sub, vec
from .geometry import corner_position, instance_at, surface_table, world_corner_normal
from .ray_origins import clear_self_primitive, spawn_ray
from .rays import ray_table


@kernel
def light_start(block, workspace, wi):
    """Where a light ray along ``wi`` from the workspace's surface starts. It may meet the surface's own triangle if
    light comes from behind that."""
    surface = surface_table(workspace)[0]
    start, cutoff = spawn_ray(workspace, surface, wi), surface.terminator
    if cutoff <= 0.0:
        return start
    cosine, flat = dot(vec(surface.n), wi), dot(vec(surface.ng), wi)
    side = 1.0
    if cosine < 0.0:
        cosine, flat, side = -cosine, -flat, -1.0
    amount = min((2.0 - (flat + cosine) / cutoff) if cosine < cutoff else (1.0 - flat / cutoff), 1.0)
    if amount <= 0.0:
        return start
    ray_table(workspace)[0].least = 0.0  # nothing is known of what is around the start
    if flat <= 0.0:
        clear_self_primitive(ray_table(workspace)[0])  # the triangle hides what is below it
    return madd(start, amount, _lift(block, surface, side))


@kernel
def _lift(block, surface, side):
    """The way from a point of a triangle to the curved surface that its normals stand for;
    ``side``: 1 where light comes from the side of ``surface.ng``, else -1."""
    instance, triangle = instance_at(block, surface.instance), surface.primitive
    v, w = surface.barycentric[0], surface.barycentric[1]
    u = 1.0 - v - w
    p0, p1, p2 = (
        corner_position(block, instance, triangle, 0),
        corner_position(block, instance, triangle, 1),
        corner_position(block, instance, triangle, 2),
    )
    n0, n1, n2 = (
        world_corner_normal(block, instance, triangle, 0),
        world_corner_normal(block, instance, triangle, 1),
        world_corner_normal(block, instance, triangle, 2),
    )
    p = vec(surface.position)
    n = add(add(scale(n0, u), scale(n1, v)), scale(n2, w))
    a, b, c = dot(sub(n2, n0), sub(p0, p2)), dot(sub(n2, n1), sub(p1, p2)), dot(sub(n1, n0), sub(p1, p0))
    height = a * u * (u - 1.0) + (a + b + c) * u * v + b * v * (v - 1.0)
    # The planes through the corners bound it, from above or, where the normals are turned, from below.
    above = 1.0 if side * dot(n, vec(surface.ng)) > 0.0 else -1.0
    bound = min(
        _to_plane(p, p0, p1, p2, n0, above), _to_plane(p, p1, p2, p0, n1, above), _to_plane(p, p2, p0, p1, n2, above)
    )
    return scale(n, above * max(bound, above * 0.5 * height))


@kernel
def _to_plane(p, corner, second, third, normal, above):
    """How far the plane of a corner's normal, moved past the other two corners, is ``above`` a point; at least 0."""
    reach = max(above * dot(sub(second, corner), normal), above * dot(sub(third, corner), normal), 0.0)
    return max(above * dot(sub(corner, p), normal) + reach, 0.0)
