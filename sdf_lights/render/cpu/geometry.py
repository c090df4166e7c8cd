# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and instances as tables, and the surface that a ray has hit.

Positions of a baked instance (one whose mesh is used once, see rays.py) are in world space already; all other corner
data stay in the mesh's local space and are brought to world space at the hit.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, table
from ...vec import add, cross, dot, largest, length, madd, negate, normalize, scale, sub, transform_normal
from ...vec import transform_point, transform_vector, vec
from ..material import Material, Node
from ..scene import Scene
from .rays import world_positions

INSTANCE = np.dtype(
    [("matrix", np.float64, (3, 4)), ("inverse", np.float64, (3, 4)), ("mesh", np.int64), ("materials", np.int64),
     ("slots", np.int64), ("baked", np.int64), ("holdout", np.int64)], align=True)

# Offsets into the tables below, in rows; −1: the mesh has none.
MESH = np.dtype(
    [("positions", np.int64), ("triangles", np.int64), ("triangle_count", np.int64), ("normals", np.int64),
     ("uvs", np.int64), ("tangents", np.int64), ("slots", np.int64)], align=True)

TABLES = {
    "instances": INSTANCE, "meshes": MESH, "instance_materials": np.int32,
    "positions": np.dtype((np.float32, 3)), "triangles": np.dtype((np.int32, 3)),
    "corner_normals": np.dtype((np.float32, 9)), "corner_uvs": np.dtype((np.float32, 6)),
    "corner_tangents": np.dtype((np.float32, 12)), "slots": np.int32,
}
