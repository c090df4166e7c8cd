# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes as arrays, in bulk: no Python loop goes over vertices, corners or faces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import bpy
import numpy as np

from ...render.material import Attribute
from ...render.scene import Mesh, Scene
from ...render.tangents import on_sphere, tangents
from .attributes import READERS, read
from .common import Warnings
from .kept import Entry, Kept


@dataclass
class _Known:
    """A mesh already in the scene, with the data needed to add texture coordinates later."""

    index: int
    corners: np.ndarray  # (T, 3) corner of Blender's mesh for each corner of each triangle
    faces: np.ndarray  # (T,) face of Blender's mesh that each triangle belongs to


class Form(NamedTuple):
    """The geometry at one time: positions (V, 3), corner normals (T, 3, 3) and radii (V,), each if it exists."""

    positions: np.ndarray
    normals: np.ndarray | None = None
    radii: np.ndarray | None = None


class Readable(Protocol):
    """Geometry that can be read again at another time."""

    def read(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Form | None:
        """The geometry of an evaluated object, or of an instance; None if its vertices or corners have changed."""
        ...


class Forms(NamedTuple):
    """Reads the positions and normals of a mesh again, at another time."""

    vertices: int
    corners_in_all: int
    corners: np.ndarray  # as in ``_Known``
    triangles: np.ndarray  # (T, 3)
    smooth: bool

    def read(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Form | None:
        """See ``Readable``."""
        data = obj.data
        if len(data.vertices) != self.vertices or len(data.loops) != self.corners_in_all:
            return None
        positions = read(data.attributes["position"].data, "vector", np.float32, 3)
        if not np.isfinite(positions).all():
            return None
        if not self.smooth:
            return Form(positions)
        normals = normals_of(data, self.triangles, self.corners)
        if normals is None:  # now flat
            a, b, c = positions[self.triangles].transpose(1, 0, 2)
            flat = np.cross(b - a, c - a)
            length = np.linalg.norm(flat, axis=1, keepdims=True)
            normals = np.repeat((flat / np.where(length > 0.0, length, 1.0))[:, None], 3, axis=1)
        return Form(positions, normals)


def normals_of(data: bpy.types.Mesh, triangles: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """(T, 3, 3) corner normals of triangles with these vertices and corners; None if all are flat."""
    if data.normals_domain == "POINT":
        return read(data.vertex_normals, "vector", np.float32, 3)[triangles]
    if data.normals_domain == "CORNER":
        return read(data.corner_normals, "vector", np.float32, 3)[corners]
    return None


class Meshes:
    """Adds each evaluated mesh to the scene once, however many instances use it."""

    def __init__(self, scene: Scene, warn: Warnings, kept: Kept | None = None):
        self._scene, self._warn, self._kept = scene, warn, kept
        self._known: dict[int, _Known | None] = {}
        self._edited: dict[int, bpy.types.Mesh] = {}
        self.forms: dict[int, Readable] = {}  # of each mesh of the scene

    def evaluated(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bpy.types.Mesh:
        """The evaluated mesh of an object of a dependency graph, in a form whose arrays can be read.

        A mesh in Edit Mode has none: its geometry is in the editor's own structure. Blender makes a mesh from it that
        lives as long as the evaluated object. With preserve_all_data_layers, Blender would make the mesh as it was
        before the edits.
        """
        if not obj.data.is_editmode:
            return obj.data
        key = obj.original.as_pointer()
        if key not in self._edited:
            owner = obj.original.evaluated_get(depsgraph)
            self._edited[key] = owner.to_mesh()
        return self._edited[key]

    def index(
        self, data: bpy.types.Mesh, slots: int, attributes: Iterable[Attribute], owners: frozenset[int] = frozenset()
    ) -> int | None:
        """Index of the mesh in the scene, with at least these attributes; None if it has no triangles. ``owners``: see
        ``kept.Entry``.

        Faces whose slot is past the number of ``slots`` use the last one, as in Blender. Evaluated data keeps its
        address as long as its dependency graph lives, so the address identifies it. Names do not.
        """
        key = data.as_pointer()
        if key not in self._known:
            self._known[key] = self._again(data, slots, owners) or self._add(data, slots, owners)
        known = self._known[key]
        if known is None:
            return None
        mesh = self._scene.meshes[known.index]
        for attribute in attributes:
            if attribute.kind in ("uv", "tangent") and attribute.name not in mesh.uvs:
                layer = uv_layer(data, attribute.name)
                if layer is not None:
                    mesh.uvs[attribute.name] = read(layer.uv, "vector", np.float32, 2)[known.corners]
            if attribute.kind == "tangent" and attribute.name not in mesh.tangents:
                places = mesh.uvs.get(attribute.name)
                if places is None and not attribute.name and not data.uv_layers:
                    undeformed = read(data.vertices, "undeformed_co", np.float32, 3)
                    places = on_sphere(undeformed)[mesh.triangles]
                if places is not None:
                    mesh.tangents[attribute.name] = tangents(mesh.positions, mesh.triangles, mesh.normals, places)
            if attribute.kind in READERS and attribute not in mesh.attributes:
                found = READERS[attribute.kind](data, mesh, known.corners, known.faces, attribute.name)
                if found is not None:
                    mesh.attributes[attribute] = found
        return known.index

    def _again(self, data: bpy.types.Mesh, slot_count: int, owners: frozenset[int]) -> _Known | None:
        """Add a mesh that is kept from the last render."""
        if self._kept is None or data.is_editmode:
            return None
        entry = self._kept.mesh((data.as_pointer(), slot_count), owners)
        if entry is None:
            return None
        corners, faces, forms = entry.known
        return self._put(entry.mesh, corners, faces, forms)

    def _put(self, mesh: Mesh, corners: np.ndarray, faces: np.ndarray, forms: Forms) -> _Known:
        index = len(self._scene.meshes)
        self._scene.meshes.append(mesh)
        self.forms[index] = forms
        return _Known(index, corners, faces)

    def _add(self, data: bpy.types.Mesh, slot_count: int, owners: frozenset[int]) -> _Known | None:
        data.calc_loop_triangles()
        if not data.loop_triangles:
            return None
        corners = read(data.loop_triangles, "loops", np.int32, 3)
        # Reading an attribute is one memory copy; reading `vertices` or `co` visits every item.
        positions = read(data.attributes["position"].data, "vector", np.float32, 3)
        triangles = read(data.attributes[".corner_vert"].data, "value", np.int32)[corners]
        faces = read(data.loop_triangle_polygons, "value", np.int32)

        finite = np.isfinite(positions)
        if not finite.all():
            finite = finite.all(axis=1)
            self._warn(
                f"Mesh '{data.name}' has vertices whose coordinates are not finite numbers: "
                "the faces at them are left out; delete those vertices."
            )
            whole = finite[triangles].all(axis=1)
            corners, triangles, faces = corners[whole], triangles[whole], faces[whole]
            positions = np.where(finite[:, None], positions, np.float32(0.0))
            if not len(triangles):
                return None

        mesh = Mesh(data.name, positions, triangles)
        mesh.normals = normals_of(data, triangles, corners)
        slots = data.attributes.get("material_index")
        if slots is not None and slots.domain == "FACE" and slots.data_type == "INT":
            mesh.slots = read(slots.data, "value", np.int32)[faces]
            np.clip(mesh.slots, 0, slot_count - 1, out=mesh.slots)
        forms = Forms(len(data.vertices), len(data.loops), corners, triangles, mesh.normals is not None)
        if self._kept is not None and owners and finite.all() and not data.is_editmode:
            entry = Entry(mesh, (corners, faces, forms), owners)
            self._kept.keep_mesh((data.as_pointer(), slot_count), entry)
            mesh = replace(mesh)  # the scene may give it motion
        return self._put(mesh, corners, faces, forms)


def uv_layer(data: bpy.types.Mesh, name: str):
    """UV map by name; the one that is active for rendering for an empty name; None if there is none."""
    if name:
        return data.uv_layers.get(name)
    return next((layer for layer in data.uv_layers if layer.active_render), None)
