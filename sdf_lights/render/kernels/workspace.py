# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scratch memory of a thread of the path tracer, for kernels."""

from __future__ import annotations

import numpy as np

from ...emitter.sampling import cut as cuts
from ...jit import block_dtype, kernel, table
from ...replaced import replaced_on_gpu
from . import lights
from .lamp_tree import WORKSPACE_TABLES as LAMP_TREE_TABLES
from .light_paths.records import WORKSPACE_TABLES as LIGHT_PATH_TABLES
from .media.records import WORKSPACE_TABLES as MEDIA_TABLES
from .outputs.records import WORKSPACE_TABLES as OUTPUT_TABLES
from .path import TABLES, path_table
from .path_reuse.records import WORKSPACE_TABLES as REUSE_TABLES
from .rays import RAY
from .shading.records import WORKSPACE_TABLES as SHADING_TABLES

WORKSPACE_TABLES = {
    "ray": RAY,
    "spans": np.dtype(np.float64),
    "light_hits": lights.HIT,
    **lights.WORKSPACE_TABLES,
    **TABLES,
    **SHADING_TABLES,
    **cuts.WORKSPACE_TABLES,
    **LAMP_TREE_TABLES,
    **LIGHT_PATH_TABLES,
    **MEDIA_TABLES,
    **OUTPUT_TABLES,
    **REUSE_TABLES,
}
# ``secondary`` is a second workspace for shading the hit of a light ray while the path's own surface waits. The points
# of path reuse have workspaces with surfaces and closures alone, and so has the arrival as each of them sees it.
WORKSPACE = block_dtype({**WORKSPACE_TABLES, "secondary": None, "points": None})

_rows_of_spans = table("spans", np.float64, 2)
hit_table = table("light_hits", lights.HIT)
secondary_table = table("secondary", WORKSPACE)
point_workspaces = table("points", WORKSPACE)
region_table = table("lamp_regions", cuts.KEYS)
box_table = table("lamp_boxes", cuts.BOXES)
cut_table = table("lamp_cuts", cuts.CUT)


@replaced_on_gpu
@kernel
def spans_of(workspace):
    """Scratch rows (c, h) for the intervals of a lamp along a ray."""
    return _rows_of_spans(workspace)


@replaced_on_gpu
@kernel
def cut_of(workspace):
    """The cut of the surface of the last scattering; that of the first one is kept, for all branches."""
    return cut_table(workspace)[1 if path_table(workspace)[0].scattered > 0 else 0]


@replaced_on_gpu
@kernel
def light_cut_of(workspace):
    """As ``cut_of``: the cut of the light tree."""
    return lights.light_cut_table(workspace)[1 if path_table(workspace)[0].scattered > 0 else 0]
