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

# Coefficients in 1/m; ``emission`` is radiance gained per metre. If ``varies`` is not NOTHING, it is the row of its
# formulas in "volumes", and the coefficients here are 0.
MEDIUM = np.dtype(
    [
        ("extinction", "f8", 3),
        ("scattering", "f8", 3),
        ("emission", "f8", 3),
        ("first_part", "i4"),
        ("part_count", "i4"),
        ("varies", "i4"),
    ],
    align=True,
)
# One way of scattering: ``medium.Scattering``, with the mean of its coefficient.
PART = np.dtype([("weight", "f8"), ("g", "f8"), ("alpha", "f8")], align=True)
# The medium of each material, and whether its surfaces only bound it.
BOUNDS = np.dtype([("medium", "i4"), ("only", "i4")], align=True)

# The media around a ray: ``count`` of them, each with its ``owner``, the instance that bounds it, and the material with
# this medium; and the sums of their coefficients. ``across`` is the medium behind the surface that the path has hit,
# which the path ``enters`` or leaves if it passes through. ``passed`` is the medium that it has entered
# (``passed_enters``) or left at the last surface that only bounds one; NOTHING: none. ``varies``: how many of them vary
# in space; the sums leave them out.
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
        ("passed", "i4"),
        ("passed_owner", "i4"),
        ("passed_enters", "i8"),
        ("varies", "i8"),
    ],
    align=True,
)

# What is known of a medium that varies in an instance: a box of ``side``³ cells from ``low`` on with the edges
# ``size``, in the space of the instance. ``first`` is the row of the first cell.
GRID = np.dtype(
    [
        ("low", "f8", 3),
        ("size", "f8", 3),
        ("first", "i8"),
        ("medium", "i4"),
        ("side", "i4"),
    ],
    align=True,
)
# Estimates in a cell, from the values at some points. ``majorant`` of the extinction in all channels, ``least`` and
# ``mean`` extinction (RGB), ``spread``: the majorant of what extinction is above the least; ``scattering``: the
# mean of RGB, never 0 if the medium scatters anywhere; ``glow``: more than 0 if it glows anywhere.
CELL = np.dtype(
    [
        ("majorant", "f4"),
        ("spread", "f4"),
        ("least", "f4", 3),
        ("mean", "f4", 3),
        ("scattering", "f4"),
        ("glow", "f4"),
    ]
)

TABLES = {
    **dispatch.TABLES,
    "media": MEDIUM,
    "media_parts": PART,
    "media_bounds": BOUNDS,
    "media_grids": GRID,
    "media_first_grid": np.dtype("i8"),  # by instance, then the number of grids
    "media_cells": CELL,
}
SCALARS = [
    ("has_media", np.int64),
    ("world_medium", np.int64),  # NOTHING: there is none
    ("camera_in_media", np.int64),  # 1: the camera may be inside a mesh that bounds one
    ("media_step", np.float64),  # metres: the least section of rays in a medium of the world that varies
]

# Rows of a workspace: as those of ``path``, and one for a light ray.
# ``media_weights``: of each row of "media_parts", its scattering at the last point in media that vary;
# ``media_random``: the state of the random numbers there.
WORKSPACE_TABLES = {"inside": INSIDE, "media_weights": np.dtype("f8"), "media_random": np.dtype("u8")}
LIGHT_RAY = PATH_COUNTS["path"]
WORKSPACE_COUNTS = {"inside": LIGHT_RAY + 1}

medium_table = table("media", MEDIUM)
part_table = table("media_parts", PART)
bounds_table = table("media_bounds", BOUNDS)
inside_table = table("inside", INSIDE)
grid_table = table("media_grids", GRID)
first_grid_table = table("media_first_grid", np.int64)
cell_table = table("media_cells", CELL)
weight_table = table("media_weights", np.float64)
random_table = table("media_random", np.uint64)


def workspace_counts(tables: dict[str, np.ndarray]) -> dict[str, int]:
    """Elements of the workspace's tables for a scene with these tables."""
    return {**WORKSPACE_COUNTS, "media_weights": max(len(tables["media_parts"]), 1), "media_random": 1}
