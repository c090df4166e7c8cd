# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the media of a scene, and the state of the media around a ray."""

from __future__ import annotations

import numpy as np

from ....jit import table
from ..path import COUNTS as PATH_COUNTS
from . import dispatch

NOTHING = -1  # means: no medium, no owner
WORLD = -2  # owner of the world's medium

MOST_MEDIA = 8  # media that may surround a point; more are left out, as in Cycles
MOST_BOUNDS = 1024  # surfaces along a ray

# Coefficients in 1/m; ``emission`` is radiance gained per metre.
MEDIUM = np.dtype(
    [
        ("extinction", "f8", 3),
        ("scattering", "f8", 3),
        ("emission", "f8", 3),
        ("first_part", "i4"),
        ("part_count", "i4"),
    ],
    align=True,
)
# One way of scattering: ``medium.Scattering``, with the mean of its coefficient.
PART = np.dtype([("weight", "f8"), ("g", "f8"), ("alpha", "f8")], align=True)
# The medium of each material, and whether its surfaces only bound it.
BOUNDS = np.dtype([("medium", "i4"), ("only", "i4")], align=True)

# The media around a ray: ``count`` of them, each with its ``owner``, the instance that bounds it, and the material with
# this medium; and the sums of their coefficients. ``across`` is the medium behind the surface that the path has hit,
# which the path ``enters`` or leaves if it passes through.
INSIDE = np.dtype(
    [
        ("count", "i8"),
        ("medium", "i4", MOST_MEDIA),
        ("owner", "i4", MOST_MEDIA),
        ("extinction", "f8", 3),
        ("scattering", "f8", 3),
        ("emission", "f8", 3),
        ("scatters", "i8"),
        ("glows", "i8"),
        ("across", "i4"),
        ("across_owner", "i4"),
        ("enters", "i8"),
    ],
    align=True,
)

TABLES = {**dispatch.TABLES, "media": MEDIUM, "media_parts": PART, "media_bounds": BOUNDS}
SCALARS = [
    ("has_media", np.int64),
    ("world_medium", np.int64),  # NOTHING: there is none
    ("camera_in_media", np.int64),  # 1: the camera may be inside a mesh that bounds one
]

# Rows of a workspace: as those of ``path``, and one for a light ray.
WORKSPACE_TABLES = {"inside": INSIDE}
LIGHT_RAY = PATH_COUNTS["path"]
WORKSPACE_COUNTS = {"inside": LIGHT_RAY + 1}

medium_table = table("media", MEDIUM)
part_table = table("media_parts", PART)
bounds_table = table("media_bounds", BOUNDS)
inside_table = table("inside", INSIDE)
