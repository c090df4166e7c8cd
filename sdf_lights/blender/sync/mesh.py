# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes as arrays, in bulk: no Python loop goes over vertices, corners or faces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy
import numpy as np

from ...render.scene import Mesh, Scene
from .common import Warnings


def read(collection, name: str, dtype, width: int = 1) -> np.ndarray:
    """Property ``name`` of every item of a bpy collection: (items,) or (items, width)."""
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


@dataclass
class _Known:
    """A mesh that is in the scene already, with what is needed to add texture coordinates to it later."""

    index: int
    corners: np.ndarray  # (T, 3) corner of Blender's mesh for each corner of each triangle


class Meshes:
    """Puts each evaluated mesh into the scene once, however many instances show it."""

    def __init__(self, scene: Scene, warn: Warnings):
        self._scene, self._warn = scene, warn
        self._known: dict[int, _Known | None] = {}

    def index(self, data: bpy.types.Mesh, slots: int, uv_maps: Iterable[str], tangents: Iterable[str]) -> int | None:
        """Index of the mesh in the scene, with at least these UV maps and tangents; None where there are no triangles.

        Faces whose slot is past the number of ``slots`` use the last one, as in Blender.
        Evaluated data stays where it is as long as its dependency graph, so its address tells it apart; names do not.
        """
        key = data.as_pointer()
        if key not in self._known:
            self._known[key] = self._add(data, slots)
        known = self._known[key]
        if known is None:
            return None
        mesh = self._scene.meshes[known.index]
        for name in {*uv_maps, *tangents} - mesh.uvs.keys():
            layer = uv_layer(data, name)
            if layer is not None:
                mesh.uvs[name] = read(layer.uv, "vector", np.float32, 2)[known.corners]
        for name in set(tangents) - mesh.tangents.keys():
            if name in mesh.uvs:
                mesh.tangents[name] = self._tangents(data, mesh, known.corners, name)
        return known.index

    def _add(self, data: bpy.types.Mesh, slot_count: int) -> _Known | None:
        data.calc_loop_triangles()
        if not data.loop_triangles:
            return None
        corners = read(data.loop_triangles, "loops", np.int32, 3)
        # Reading an attribute is one copy of memory; reading `vertices` or `co` visits every item.
        positions = read(data.attributes["position"].data, "vector", np.float32, 3)
        triangles = read(data.attributes[".corner_vert"].data, "value", np.int32)[corners]
        faces = read(data.loop_triangle_polygons, "value", np.int32)

        finite = np.isfinite(positions).all(axis=1)
        if not finite.all():
            self._warn(f"Mesh '{data.name}' has vertices whose coordinates are not finite numbers: "
                       "the faces at them are left out; delete those vertices.")
            whole = finite[triangles].all(axis=1)
            corners, triangles, faces = corners[whole], triangles[whole], faces[whole]
            positions = np.where(finite[:, None], positions, np.float32(0.0))
            if not len(triangles):
                return None

        mesh = Mesh(data.name, positions, triangles)
        if data.normals_domain == "POINT":
            mesh.normals = read(data.vertex_normals, "vector", np.float32, 3)[triangles]
        elif data.normals_domain == "CORNER":
            mesh.normals = read(data.corner_normals, "vector", np.float32, 3)[corners]
        slots = data.attributes.get("material_index")
        if slots is not None and slots.domain == "FACE" and slots.data_type == "INT":
            mesh.slots = read(slots.data, "value", np.int32)[faces]
            np.clip(mesh.slots, 0, slot_count - 1, out=mesh.slots)
        self._scene.meshes.append(mesh)
        return _Known(len(self._scene.meshes) - 1, corners)

    def _tangents(self, data: bpy.types.Mesh, mesh: Mesh, corners: np.ndarray, name: str) -> np.ndarray:
        """(T, 3, 4) tangents of a UV map, by Blender's MikkTSpace where all faces have three or four corners."""
        try:
            data.calc_tangents(uvmap=uv_layer(data, name).name)
        except RuntimeError:  # faces of more than four corners
            return triangle_tangents(mesh, name)
        tangents = np.empty((len(data.loops), 4), np.float32)
        tangents[:, :3] = read(data.loops, "tangent", np.float32, 3)
        tangents[:, 3] = read(data.loops, "bitangent_sign", np.float32)
        data.free_tangents()
        return tangents[corners]


def uv_layer(data: bpy.types.Mesh, name: str):
    """UV map by name, the one that is active for rendering for an empty name; None where there is none."""
    if name:
        return data.uv_layers.get(name)
    return next((layer for layer in data.uv_layers if layer.active_render), None)


def triangle_tangents(mesh: Mesh, name: str) -> np.ndarray:
    """(T, 3, 4) tangents constant over each triangle: the direction in which u grows, and the sign of the bitangent."""
    a, b, c = mesh.positions[mesh.triangles].transpose(1, 0, 2)
    uv = mesh.uvs[name]
    (u1, v1), (u2, v2) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    area = u1 * v2 - u2 * v1
    tangent = ((b - a) * v2[:, None] - (c - a) * v1[:, None]) * np.sign(area)[:, None]
    size = np.linalg.norm(tangent, axis=1, keepdims=True)
    result = np.zeros((len(a), 3, 4), np.float32)
    result[..., :3] = (tangent / np.where(size > 0.0, size, 1.0))[:, None]
    result[..., 3] = np.where(area < 0.0, -1.0, 1.0)[:, None]
    return result
