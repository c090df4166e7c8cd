# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A ray that starts on a curve or a sphere does not hit it again: the filter that Embree calls at every hit."""

from __future__ import annotations

import numpy as np

from ....jit import kernel, table
from ..rays import NONE

# RTCFilterFunctionNArguments (rtcore_geometry.h): addresses, and the number of rays. A table has its length after its
# address, which is never read here: the number of rays replaces all lengths.
_TABLES = ("valid", "shape", "context", "ray", "hit")
ARGUMENTS = np.dtype(
    {
        "names": [f"{name}_{end}" for name in _TABLES for end in ("address", "count")] + ["rays"],
        "formats": [np.int64, np.int64] * len(_TABLES) + [np.uint32],
        "offsets": [place for index in range(len(_TABLES)) for place in (8 * index, 40)] + [40],
        "itemsize": 48,
    }
)
# The table at the address "shape": the curve number of each segment, and the first number of each instance.
SHAPE = np.dtype(
    [
        ("strand_of_address", np.int64),
        ("strand_of_count", np.int64),
        ("first_strands_address", np.int64),
        ("first_strands_count", np.int64),
    ]
)
# Of RTCRayN and RTCHitN: fields of one number for each ray.
_RAY_ID, _RAY_FLAGS, _PRIMITIVE, _GEOMETRY, _INSTANCE = 10, 11, 5, 6, 7

_valid_table, _shape_table = table("valid", np.int32), table("shape", SHAPE)
_ray_words, _hit_words = table("ray", np.uint32), table("hit", np.uint32)
_strand_of, _first_strands = table("strand_of", np.int32), table("first_strands", np.int64)


@kernel
def refuse(arguments):
    """Reject hits of the curve or sphere whose number is the ID, or the flags, of the ray."""
    count = np.int64(arguments.rays)
    valid, shape = _valid_table(arguments), _shape_table(arguments)[0]
    rays, hits = _ray_words(arguments), _hit_words(arguments)
    for lane in range(count):
        left = np.int64(rays[_RAY_ID * count + lane])
        passed = np.int64(rays[_RAY_FLAGS * count + lane])
        if left == 0 and passed == 0:
            continue
        instance = np.int64(hits[_INSTANCE * count + lane])
        if instance == NONE:
            instance = np.int64(hits[_GEOMETRY * count + lane])
        strand = np.int64(_strand_of(shape)[np.int64(hits[_PRIMITIVE * count + lane])])
        number = _first_strands(shape)[instance] + strand
        if number == left or number == passed:
            valid[lane] = 0
