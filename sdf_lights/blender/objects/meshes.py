# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and metaballs as lamps: what they enclose after all modifiers, by a signed distance grid."""

from __future__ import annotations

import collections
import hashlib

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.shapes import Shape
from . import reads

_KEPT = 16  # grids of meshes, the last ones used; each is some megabytes

_grids: collections.OrderedDict[tuple, Shape] = collections.OrderedDict()


@reads(MESH="Mesh", META="Metaball")
def _read(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, lamp) -> Shape:
    try:
        # With all layers Blender applies the modifiers also of an object that is hidden in renders.
        mesh = obj.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    except RuntimeError as error:
        raise RenderError(f"{_named(obj)} cannot be read: {error}") from None
    try:
        vertices, faces = _arrays(mesh)
    finally:
        obj.to_mesh_clear()
    if not len(faces) and any(modifier.type == "NODES" for modifier in obj.modifiers):
        raise RenderError(
            f"{_named(obj)} has no faces, so it has no inside: end its geometry nodes with meshes, and instances with Realize "
            "Instances."
        )
    return _grid(obj, vertices, faces, lamp.voxel_size, depsgraph.mode == "RENDER")


def _named(obj: bpy.types.Object) -> str:
    return f"{'Mesh' if obj.type == 'MESH' else 'Metaball'} '{obj.name}'"


def _arrays(mesh: bpy.types.Mesh | None) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3)."""
    if mesh is None:
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32)
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    faces = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.vertices.foreach_get("co", vertices)
    mesh.loop_triangles.foreach_get("vertices", faces)
    return vertices.reshape(-1, 3), faces.reshape(-1, 3)


def _grid(obj: bpy.types.Object, vertices: np.ndarray, faces: np.ndarray, voxel_size: float, is_render: bool) -> Shape:
    from ...sdf.data.voxels import (  # they need Numba, whose import takes a second
        FINENESS,
        PREVIEW,
        GridError,
        mesh_grid,
    )

    fineness = FINENESS if is_render else PREVIEW
    key = hashlib.sha256(vertices.tobytes()).digest(), hashlib.sha256(faces.tobytes()).digest(), voxel_size, fineness
    if key not in _grids:
        try:
            _grids[key] = mesh_grid(vertices, faces, voxel_size, fineness)
        except GridError as error:
            raise RenderError(f"{_named(obj)} {error}") from None
        while len(_grids) > _KEPT:
            _grids.popitem(last=False)
    _grids.move_to_end(key)
    return _grids[key]
