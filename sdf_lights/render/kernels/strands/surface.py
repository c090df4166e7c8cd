# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a curve or a sphere at the hit of a ray, as in Cycles."""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel, table
from ....vec import (
    add,
    cross,
    dot,
    madd,
    negate,
    normalize,
    put,
    scale,
    sub,
    transform_normal,
    transform_point,
    transform_vector,
    vec,
)
from ...scene import Primitive
from ..geometry import (
    BUMP_DISTANCE,
    BUMP_FILTER,
    hit_material,
    instance_at,
    moving_vertex,
    surface_table,
    triangle_table,
)
from ..ray_origins import number_of
from ..rays import hit_instance, ray_table
from ..workspace import secondary_table

_CONES, _SPHERES, _RIBBONS = int(Primitive.CONES), int(Primitive.SPHERES), int(Primitive.RIBBONS)
_strand_of = table("strand_of", np.int32)


@kernel
def vertex(block, instance, index):
    """A vertex at the time of the path, as stored."""
    return moving_vertex(block, instance, index + instance.positions)


@kernel
def curve_at(block, instance, segment, u):
    """The point and the tangent of a curve at u, by Catmull and Rom 1974, or on a straight line."""
    rows = triangle_table(block)
    row = instance.triangles + segment
    k1, k2 = np.int64(rows[row].v[0]), np.int64(rows[row].v[1])
    p1, p2 = vertex(block, instance, k1), vertex(block, instance, k2)
    if instance.primitive == _CONES:
        way = sub(p2, p1)
        return madd(p1, u, way), way
    k0, k3 = k1, k2
    if segment > 0 and rows[row - 1].v[1] == k1:
        k0 = np.int64(rows[row - 1].v[0])
    if segment + 1 < instance.triangle_count and rows[row + 1].v[0] == k2:
        k3 = np.int64(rows[row + 1].v[1])
    p0, p3 = vertex(block, instance, k0), vertex(block, instance, k3)
    t, s = u, 1.0 - u
    point = add(
        add(scale(p0, -0.5 * t * s * s), scale(p1, 1.0 + 0.5 * t * t * (3.0 * t - 5.0))),
        add(scale(p2, 1.0 + 0.5 * s * s * (3.0 * s - 5.0)), scale(p3, -0.5 * s * t * t)),
    )
    tangent = add(
        add(scale(p0, 0.5 * s * (2.0 * t - s)), scale(p1, t * (4.5 * t - 5.0))),
        add(scale(p2, s * (5.0 - 4.5 * s)), scale(p3, 0.5 * t * (t - 2.0 * s))),
    )
    return point, tangent


@kernel
def _normal(kind, position, middle, tangent, wo, across):
    """Unit normal at the hit of a ray along −wo with a curve, whose middle is given."""
    if kind == _RIBBONS:
        along = normalize(tangent)
        side = normalize(cross(along, wo))
        return madd(scale(side, across), -math.sqrt(max(1.0 - across * across, 0.0)), normalize(cross(along, side)))
    n = normalize(sub(position, middle))
    return n if dot(n, n) > 0.5 else normalize(wo)


@kernel
def fill(block, workspace, secondary, x, y, z, ray_kind, footprint):
    """Fill ``SURFACE`` of the workspace, or of its ``secondary`` one, from the hit in the workspace of a ray along −wo.
    Rays that leave the workspace's surface, or continue behind the other one, do not hit the same curve or sphere
    again."""
    ray = ray_table(workspace)[0]
    instance = instance_at(block, hit_instance(ray))
    segment = np.int64(ray.primitive)
    if secondary > 0.0:
        surface = surface_table(secondary_table(workspace)[0])[0]
        _fill(block, surface, ray, instance, segment, (x, y, z), ray_kind, footprint)
        ray.flags = surface.number
    else:
        surface = surface_table(workspace)[0]
        _fill(block, surface, ray, instance, segment, (x, y, z), ray_kind, footprint)
        ray.id = surface.number
    return 0.0


@kernel
def _fill(block, surface, ray, instance, segment, wo, ray_kind, footprint):
    position = madd(vec(ray.origin), float(ray.t_far), vec(ray.direction))
    u, v, kind = float(ray.u), float(ray.v), instance.primitive
    tangent = (0.0, 0.0, 0.0)
    surface.number = number_of(hit_instance(ray), np.int64(_strand_of(block)[instance.strands + segment]))
    surface.strand = surface.exact_origin = 0
    surface.terminator = 0.0
    if kind == _SPHERES:
        u, v = 0.0, 0.0
        middle = vertex(block, instance, np.int64(triangle_table(block)[instance.triangles + segment].v[0]))
        if instance.baked == 0:
            middle = transform_point(instance.matrix, middle)
        n = normalize(sub(position, middle))
    else:
        surface.strand = np.int32(kind)
        if kind != _RIBBONS:
            v = 0.0
        middle, tangent = curve_at(block, instance, segment, u)
        if instance.baked:
            n = _normal(kind, position, middle, tangent, wo, v)
        else:
            there, seen = transform_point(instance.inverse, position), transform_vector(instance.inverse, wo)
            n = normalize(transform_normal(instance.inverse, _normal(kind, there, middle, tangent, seen, v)))
            tangent = transform_vector(instance.matrix, tangent)
    surface.backfacing = 0
    if dot(n, wo) < 0.0 and kind != _RIBBONS:
        surface.backfacing = 1
        n, tangent = negate(n), negate(tangent)
    put(surface.position, position)
    put(surface.wo, wo)
    # In Cycles, ribbons face the incoming ray, but this normal is still the rounded one.
    put(surface.ng, n)
    put(surface.n, n)
    put(surface.dpdu, tangent)
    put(surface.dpdv, cross(tangent, wo if kind == _RIBBONS else n))
    put(surface.radial, tangent)
    object_normal = transform_normal(instance.matrix, n if surface.backfacing == 0 else negate(n))
    put(surface.object_normal, normalize(object_normal))
    surface.instance = hit_instance(ray)
    surface.primitive = segment
    surface.barycentric[0] = u
    surface.barycentric[1] = v
    surface.ray_kind = int(ray_kind)
    surface.material = hit_material(instance, block, segment)
    surface.bump_step = BUMP_FILTER * footprint if footprint > 0.0 else BUMP_DISTANCE
