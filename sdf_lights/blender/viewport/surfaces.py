# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth of the scene's surfaces if Blender has none.

Without overlays, Blender draws no depth for engines such as Cycles, and EEVEE leaves zeros until its picture is
finished. So this module draws the meshes of the viewport again. Their triangles stay on the graphics card until a
geometry changes. Their transforms are read again when something has moved, not for every view.
"""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from mathutils import Matrix

from ..sync import shows_in
from ..sync.common import matrix_of
from ..sync.mesh import read
from . import rendered, shaders
from .painter import Depth, View


class Surfaces:
    """All methods but ``changed`` need a graphics context."""

    def __init__(self):
        self._batches: dict[int, gpu.types.GPUBatch | None] = {}  # by the address of the evaluated mesh
        self._shown: dict[tuple, tuple[np.ndarray, list[gpu.types.GPUBatch]]] = {}  # by the state of a viewport
        self._target: tuple[tuple[int, int], gpu.types.GPUFrameBuffer, gpu.types.GPUTexture] | None = None
        self._stale = False
        self._drawn: tuple = ()  # the view in the target

    def changed(self, geometry: bool) -> None:
        """Something has moved; with ``geometry``, a geometry has changed too."""
        self._drawn = ()
        self._shown.clear()
        self._stale = self._stale or geometry

    def depth(self, context, view: View, scale: int) -> Depth:
        """Depth of the meshes seen in ``view``, drawn again only if the view or the scene has changed."""
        space = context.space_data
        shows = space.as_pointer(), rendered.filters(space)
        wanted = view.view.tobytes(), view.projection.tobytes(), view.size, shows
        if wanted != self._drawn:
            if shows not in self._shown:
                self._shown[shows] = self._collect(context)
            self._draw(view, *self._shown[shows])
            self._drawn = wanted
        return Depth(self._target[2], (0, 0), scale)

    def _collect(self, context) -> tuple[np.ndarray, list[gpu.types.GPUBatch]]:
        """Matrices (n, 4, 4) and triangles of the n meshes that the viewport shows."""
        if self._stale:
            self._batches.clear()
            self._stale = False
        matrices, batches, shows = [], [], shows_in(context.space_data)
        for item in context.evaluated_depsgraph_get().object_instances:
            # Nothing may refer to `item` after this iteration: Blender reuses it for the next instance.
            obj = item.object
            if obj.type != "MESH" or not item.show_self or not obj.visible_camera or not shows(item):
                continue
            batch = self._batch_of(obj.data)
            if batch is not None:
                matrices.append(matrix_of(item.matrix_world))
                batches.append(batch)
        return np.reshape(matrices, (-1, 4, 4)), batches

    def _draw(self, view: View, matrices: np.ndarray, batches: list[gpu.types.GPUBatch]) -> None:
        buffer, shader = self._target_of(view.size), shaders.depth_shader()
        transforms = (view.projection @ view.view @ matrices).tolist()
        with buffer.bind():
            buffer.viewport_set(0, 0, *view.size)
            buffer.clear(color=(1.0, 1.0, 1.0, 1.0), depth=1.0)
            gpu.state.blend_set("NONE")
            gpu.state.depth_test_set("LESS_EQUAL")
            gpu.state.depth_mask_set(True)
            try:
                shader.bind()
                for transform, batch in zip(transforms, batches):
                    shader.uniform_float("transform", Matrix(transform))
                    batch.draw(shader)
            finally:
                gpu.state.depth_mask_set(False)
                gpu.state.depth_test_set("NONE")

    def _target_of(self, size: tuple[int, int]) -> gpu.types.GPUFrameBuffer:
        if self._target is None or self._target[0] != size:
            texture = gpu.types.GPUTexture(size, format="R32F")
            hidden = gpu.types.GPUTexture(size, format="DEPTH_COMPONENT32F")
            self._target = size, gpu.types.GPUFrameBuffer(depth_slot=hidden, color_slots=(texture,)), texture
        return self._target[1]

    def _batch_of(self, mesh: bpy.types.Mesh) -> gpu.types.GPUBatch | None:
        key = mesh.as_pointer()
        if key not in self._batches:
            self._batches[key] = _batch(mesh)
        return self._batches[key]


def _batch(mesh: bpy.types.Mesh) -> gpu.types.GPUBatch | None:
    """The triangles of a mesh; None if it has none."""
    mesh.calc_loop_triangles()
    if not mesh.loop_triangles:
        return None
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="position", comp_type="F32", len=3, fetch_mode="FLOAT")
    corners = gpu.types.GPUVertBuf(layout, len(mesh.vertices))
    corners.attr_fill("position", read(mesh.vertices, "co", np.float32, 3))
    triangles = read(mesh.loop_triangles, "vertices", np.int32, 3)
    return gpu.types.GPUBatch(type="TRIS", buf=corners, elem=gpu.types.GPUIndexBuf(type="TRIS", seq=triangles))
