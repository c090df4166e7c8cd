# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Origins of rays that leave a surface, without self-intersection.

As in Cycles, a ray ignores the triangle, curve or sphere on which it starts, its *self primitive*: Embree asks at every
hit of such a ray. So the origin of a ray lies exactly on its triangle, and the ray meets another triangle in the same
place. Where rounding forbids that, the origin is offset along the normal, as in pbrt. Where no other face is in the
same place, the ray does not look at its first roundings (``LEAST``): they lie in the box of its triangle, which for a
level face is flat, and Embree need not open it. Plain scenes render up to 1.15 times as fast.
"""

from __future__ import annotations

import numpy as np

from ...jit import Callback, kernel, table
from ...replaced import replaced_on_gpu
from ...vec import cross, dot, madd, sub, vec
from .rays import NONE, OFFSET, ray_table

# RTCFilterFunctionNArguments (rtcore_geometry.h): addresses, and how many rays there are. A table has its length after
# its address, which is never asked for here: the number of rays stands in for all.
_TABLES = ("valid", "shape", "context", "ray", "hit")
ARGUMENTS = np.dtype(
    {
        "names": [f"{name}_{end}" for name in _TABLES for end in ("address", "count")] + ["rays"],
        "formats": [np.int64, np.int64] * len(_TABLES) + [np.uint32],
        "offsets": [place for index in range(len(_TABLES)) for place in (8 * index, 40)] + [40],
        "itemsize": 48,
    }
)
# What the address "shape" of curves and spheres points at: the number of the curve of each segment.
SHAPE = np.dtype([("strand_of_address", np.int64), ("strand_of_count", np.int64)])
# Of RTCRayN and RTCHitN: fields of one number for each ray.
_RAY_ID, _RAY_FLAGS, _PRIMITIVE, _GEOMETRY, _INSTANCE = 10, 11, 5, 6, 7

_valid_table, _shape_table = table("valid", np.int32), table("shape", SHAPE)
_ray_words, _hit_words = table("ray", np.uint32), table("hit", np.uint32)
_strand_of = table("strand_of", np.int32)
_callbacks: list[Callback] = []

_INSTANCES_APART = 0x9E3779B1  # 2^32 over the golden ratio
# A triangle's point is this many roundings of Embree's numbers or more from its edges, or the origin of a ray is
# offset.
_ROUNDINGS = 8.0
OFFSET_ORIGIN, EXACT, ALONE = range(3)  # how rays leave a point: ``spawn_ray``
# Of ``step_size``: a rounding of Embree's positions, or more, and half of the distance to the edges of the triangle.
LEAST = 2.0**-4


@replaced_on_gpu
@kernel
def number_of(instance, primitive):
    """A number of 32 bits for a triangle, curve or sphere of an instance. Those of instances are far apart, so two are
    hardly ever the same."""
    return (instance * _INSTANCES_APART + primitive + 1) & NONE


@kernel
def clear_self_primitive(ray):
    """The next rays have no self primitive: they may hit everything."""
    ray.id = np.uint32(0)
    ray.least = 0.0


@kernel
def refuse(arguments):
    """Refuse hits of the triangle, curve or sphere whose number is the ID, or the flags, of the ray."""
    count = np.int64(arguments.rays)
    valid, shape = _valid_table(arguments), _shape_table(arguments)
    rays, hits = _ray_words(arguments), _hit_words(arguments)
    for lane in range(count):
        left = np.int64(rays[_RAY_ID * count + lane])
        passed = np.int64(rays[_RAY_FLAGS * count + lane])
        instance = np.int64(hits[_INSTANCE * count + lane])
        if instance == NONE:
            instance = np.int64(hits[_GEOMETRY * count + lane])
        primitive = np.int64(hits[_PRIMITIVE * count + lane])
        if arguments.shape_address != 0:
            primitive = np.int64(_strand_of(shape[0])[primitive])
        number = number_of(instance, primitive)
        if number == left or number == passed:
            valid[lane] = 0


def filter_address() -> int:
    """Address of ``refuse``, as Embree calls it."""
    if not _callbacks:
        _callbacks.append(Callback(refuse, ARGUMENTS))
    return _callbacks[0].address


@kernel
def step_size(position):
    """Length of a step off a surface at this position, for float32 of Embree."""
    return max(abs(position[0]), abs(position[1]), abs(position[2]), 1e-3) * OFFSET


@kernel
def offset_ray_origin(position, ng, direction):
    """``position`` (world space) moved off its surface, along the geometric normal, to the side of ``direction``. As
    pbrt's ``OffsetRayOrigin``."""
    size = step_size(position)
    return madd(position, size if dot(ng, direction) > 0.0 else -size, ng)


@kernel
def least_of(surface):
    """Distance from which a ray from a surface meets anything."""
    return LEAST * step_size(vec(surface.position)) if surface.exact_origin == ALONE else 0.0


@kernel
def origin_of(surface, direction):
    """The origin (world space) of a ray from a surface along ``direction``: see ``exact_origin``."""
    position = vec(surface.position)
    return position if surface.exact_origin else offset_ray_origin(position, vec(surface.ng), direction)


@kernel
def spawn_ray(workspace, surface, direction):
    """``origin_of``. The triangle, curve or sphere of the surface becomes the self primitive of the next rays."""
    ray = ray_table(workspace)[0]
    ray.id, ray.least = surface.number, least_of(surface)
    return origin_of(surface, direction)


@kernel
def exact_origin(position, edge1, edge2, u, v):
    """Whether rays from a point of a triangle start exactly there (1). Their origin is offset (0) where rounding to
    float32 could carry it past an edge. ``u`` and ``v`` are the weights of the corners at the ends of both edges."""
    normal, edge3 = cross(edge1, edge2), sub(edge2, edge1)
    longest = max(dot(edge1, edge1), dot(edge2, edge2), dot(edge3, edge3))
    # Embree subtracts the ray's origin from the corners, so a long edge is rounded as a far position is.
    far = step_size(position) * step_size(position)
    rounding2 = _ROUNDINGS * _ROUNDINGS * 2.0**-12 * max(far, OFFSET * OFFSET * longest)
    least = min(u, v, 1.0 - u - v)
    return 1 if least > 0.0 and rounding2 * longest < least * least * dot(normal, normal) else 0
