# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against triangles: the record of a ray, the kinds of rays that a surface is visible to, and the two queries.

On the CPU the queries call Embree by address (``cpu.accelerator``). The GPU traverses its own hierarchy.
"""

from __future__ import annotations

import numpy as np

from ...jit import call_address3, kernel, table
from ...replaced import replaced_on_gpu
from ...vec import vec
from ..scene import Instance, Ray

NONE = 0xFFFFFFFF

# RTCRayHit of Embree 4 (rtcore_ray.h), and padding so that a version with longer hits has room.
RAY = np.dtype(
    [
        ("origin", np.float32, (3,)),
        ("t_near", np.float32),
        ("direction", np.float32, (3,)),
        ("time", np.float32),
        ("t_far", np.float32),
        ("mask", np.uint32),
        ("id", np.uint32),  # what it starts on, and does not meet: ``ray_origins.number_of``
        ("flags", np.uint32),  # of the one that it has gone through last; none of Embree's uses this field
        ("normal", np.float32, (3,)),
        ("u", np.float32),
        ("v", np.float32),
        ("primitive", np.uint32),
        ("geometry", np.uint32),
        ("instance", np.uint32),
        ("least", np.float32),  # from which it meets anything: ``ray_origins.spawn_ray``; none of Embree's, too
        ("padding", np.uint32, (11,)),
    ]
)

# A geometry is visible to shadow rays through one of two bits, so the opaque part of a scene is tested first, with the
# cheaper any-hit query.
SHADOW_OPAQUE = int(Ray.SHADOW)
SHADOW_TRANSPARENT = 64

# The part that casts the shadows of all emitters except those with shadow linking. Such an emitter has a separate bit
# for opaque geometry, and, two bits higher, as here, one for transparent geometry.
TRANSPARENT_PLACES = 2
SHADOW_BITS = tuple(1 << place for place in (7, 8, 11, 12, 15, 16, 19, 20, 23, 24, 27, 28))

# Relative step off a surface: some tens of float32 roundings, as Embree sees the scene in float32.
OFFSET = 2.0**-18

# RTCIntersectArguments and RTCOccludedArguments (rtcore_scene.h), which have the same fields, and padding so that a
# version with more of them has room.
QUERY = np.dtype(
    [
        ("flags", np.uint32),
        ("features", np.uint32),
        ("context", np.int64),
        ("filter", np.int64),
        ("own_geometry", np.int64),
        ("padding", np.int64, (4,)),
    ]
)

# ``filtered_query``: address of the ``QUERY`` of rays that do not meet all that they cross.
SCALARS = [
    (name, np.int64) for name in ("embree_scene", "rtc_intersect", "rtc_occluded", "rtc_occluded8", "filtered_query")
]
ray_table = table("ray", RAY)


_IN_CACHE = 1 << 13  # positions whose float64 values fit the processor's cache


def world_positions(positions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(V, 3) float32 world positions, rounded once, after the transform."""
    result = np.empty(positions.shape, np.float32)
    for start in range(0, len(positions), _IN_CACHE):
        part = slice(start, start + _IN_CACHE)
        result[part] = positions[part].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return result


def masks_of(
    instances: list[Instance], transparent: np.ndarray, shadow_bits: dict[int, int] | None = None
) -> list[int]:
    """Kinds of rays that each instance is visible to; ``transparent``: (materials,) bool, True if a material lets some
    light straight through; ``shadow_bits``: bits of ``SHADOW_BITS`` by the sets of instances that cast these
    shadows."""
    known: dict[tuple, int] = {}
    found = []
    for instance in instances:
        key = int(instance.visibility), instance.shadow_set, instance.materials
        if key not in known:
            known[key] = _mask(*key, transparent, shadow_bits or {})
        found.append(known[key])
    return found


def _mask(visibility: int, shadow_set: int, materials: tuple[int, ...], transparent, shadow_bits) -> int:
    if not visibility & SHADOW_OPAQUE:
        return visibility
    own = SHADOW_OPAQUE
    for sets, bit in shadow_bits.items():
        own |= bit if sets >> shadow_set & 1 else 0
    if any(transparent[material] for material in materials):
        own <<= TRANSPARENT_PLACES
    return visibility & ~SHADOW_OPAQUE | own


@kernel
def _set_ray(ray, o, d, t_min, t_max, mask):
    # Its time stays as set by ``motion.set_time``, its ID and least distance by ``ray_origins``, its flags by strands.
    ray.origin[0] = o[0]
    ray.origin[1] = o[1]
    ray.origin[2] = o[2]
    ray.t_near = max(np.float32(t_min), ray.least)
    ray.direction[0] = d[0]
    ray.direction[1] = d[1]
    ray.direction[2] = d[2]
    ray.t_far = t_max
    ray.mask = mask


@kernel
def _query(block, ray):
    """Address of the arguments of Embree's query. Most rays do without: a call at each hit would cost time."""
    return block.filtered_query if ray.id != 0 or ray.flags != 0 else 0


@replaced_on_gpu
@kernel
def intersect(block, workspace, o, d, t_min, t_max, mask):
    """Nearest triangle: True if there is one, with the hit left in ``ray_table(workspace)[0]``."""
    return intersect_scene(block, workspace, block.embree_scene, o, d, t_min, t_max, mask)


@kernel
def intersect_scene(block, workspace, scene, o, d, t_min, t_max, mask):
    """As ``intersect``, with an Embree scene."""
    ray = ray_table(workspace)[0]
    _set_ray(ray, o, d, t_min, t_max, mask)
    ray.geometry = NONE
    ray.instance = NONE
    call_address3(block.rtc_intersect, scene, workspace.ray_address, _query(block, ray))
    return ray.geometry != NONE


@replaced_on_gpu
@kernel
def occluded(block, workspace, o, d, t_min, t_max, mask):
    """True if any triangle lies between t_min and t_max."""
    ray = ray_table(workspace)[0]
    _set_ray(ray, o, d, t_min, t_max, mask)
    call_address3(block.rtc_occluded, block.embree_scene, workspace.ray_address, _query(block, ray))
    return ray.t_far < 0.0


@kernel
def start_anew(block, workspace):
    """The next rays have not passed through a curve or sphere yet."""
    if block.has_strands:
        ray_table(workspace)[0].flags = 0


@kernel
def hit_instance(ray):
    """Index of the instance that was hit, whether it is in the top level itself or by reference."""
    return np.int64(ray.geometry) if ray.instance == NONE else np.int64(ray.instance)


@kernel
def hit_normal(ray):
    """Geometric normal of the hit from Embree: in the space of the mesh, not of unit length."""
    return vec(ray.normal)


@kernel
def beyond(t_hit):
    """Distance along a ray that is behind a surface at ``t_hit``."""
    return t_hit + max(abs(t_hit), 1e-3) * OFFSET
