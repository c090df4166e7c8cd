# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow rays of many points to one place, eight at a time: Embree takes half as long for them as for single ones.

On the CPU alone, as Embree is (``rays``).
"""

from __future__ import annotations

import numpy as np

from ...jit import call_address4, kernel, table
from .rays import ray_table

LANES = 8
EMPTY, FILLED = 0, -1  # of ``filled``, as Embree wants it

# Which lanes have a ray, and RTCRay8 of Embree 4 (rtcore_ray.h) with the fields of ``rays.RAY``. ``owner`` is for who
# asks: whose ray it is.
PACKET = np.dtype(
    [
        ("filled", np.int32, (LANES,)),
        ("origin", np.float32, (3, LANES)),
        ("t_near", np.float32, (LANES,)),
        ("direction", np.float32, (3, LANES)),
        ("time", np.float32, (LANES,)),
        ("t_far", np.float32, (LANES,)),
        ("mask", np.uint32, (LANES,)),
        ("id", np.uint32, (LANES,)),
        ("flags", np.uint32, (LANES,)),
        ("owner", np.int32, (LANES,)),
    ]
)
RAYS_OFFSET = 4 * LANES  # bytes: behind ``filled``

packet_table = table("ray_packet", PACKET)


@kernel
def put_ray(workspace, lane, owner, o, d, t_max, mask, number, least):
    """Put a shadow ray in a lane of the packet: from o along d, up to ``t_max``. ``number`` is that of its self
    primitive, and it meets nothing before ``least``. ``owner`` is a number that the caller finds again there."""
    packet, ray = packet_table(workspace)[0], ray_table(workspace)[0]
    for axis in range(3):
        packet.origin[axis, lane] = o[axis]
        packet.direction[axis, lane] = d[axis]
    packet.t_near[lane], packet.t_far[lane] = least, t_max
    packet.time[lane], packet.mask[lane], packet.id[lane], packet.flags[lane] = ray.time, mask, number, ray.flags
    packet.owner[lane] = owner


@kernel
def find_occluded(block, workspace, count):
    """Ask Embree about the rays in the first ``count`` lanes: see ``is_occluded``."""
    packet, filtered = packet_table(workspace)[0], False
    for lane in range(LANES):
        packet.filled[lane] = FILLED if lane < count else EMPTY
        if lane < count and (packet.id[lane] != 0 or packet.flags[lane] != 0):
            filtered = True
    address = workspace.ray_packet_address
    query = block.filtered_query if filtered else 0
    call_address4(block.rtc_occluded8, address, block.embree_scene, address + RAYS_OFFSET, query)


@kernel
def is_occluded(workspace, lane):
    """Whether the ray in a lane meets anything, once ``find_occluded`` has asked."""
    return packet_table(workspace)[0].t_far[lane] < 0.0
