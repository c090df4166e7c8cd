# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and instances: what stands where in the world, and with which materials."""

from __future__ import annotations

import bpy
import numpy as np

from ...render.errors import RenderError
from ...render.scene import Instance, Ray, Scene
from .common import FLAT, Warnings, is_finite, matrix_of, visibility_of
from .lights import light_of
from .materials import Materials
from .mesh import Meshes

# Curves, text, surfaces and metaballs are not here: Blender lists their evaluated meshes as instances of their own.
_UNSUPPORTED = {
    "CURVES": "hair curves", "POINTCLOUD": "a point cloud", "VOLUME": "a volume", "GREASEPENCIL": "Grease Pencil",
    "GPENCIL": "Grease Pencil"}

# A flattened instance is given this part of its largest scale as thickness, so that its matrix has an inverse.
_THICKNESS = 1e-6


def sync_objects(depsgraph: bpy.types.Depsgraph, scene: Scene, materials: Materials, warn: Warnings) -> None:
    """Append every mesh, instance, lamp and light of the dependency graph to ``scene``.

    An object that cannot be used is left out with a warning that names it; the rest is rendered.
    """
    meshes = Meshes(scene, warn)
    view_layer = depsgraph.view_layer  # the original, which knows original objects
    for item in depsgraph.object_instances:
        # Nothing of `item` may outlive this turn of the loop: Blender reuses it for the next instance.
        obj = item.object
        if not item.show_self:
            continue
        if obj.type in _UNSUPPORTED:
            warn(f"Object '{_name(item)}' is {_UNSUPPORTED[obj.type]}, which is not supported: it is left out; "
                 "convert it to a mesh.")
            continue
        if obj.type not in {"MESH", "LIGHT"}:
            continue
        matrix = matrix_of(item.matrix_world)
        if not is_finite(matrix):
            warn(f"Object '{_name(item)}' has a transform that is not made of finite numbers: it is left out; "
                 "clear its location, rotation and scale.")
            continue
        try:
            if obj.type == "LIGHT":
                light = light_of(obj, matrix, _visibility(item, view_layer), warn)
                if light is not None:
                    (scene.lamps if hasattr(light, "shape") else scene.lights).append(light)
            else:
                _add_mesh(item, matrix, view_layer, scene, meshes, materials)
        except RenderError as error:
            warn(str(error))


def _add_mesh(item, matrix: np.ndarray, view_layer, scene: Scene, meshes: Meshes, materials: Materials) -> None:
    obj = item.object
    matrix = _invertible(matrix)
    if matrix is None:
        return
    slots = tuple(materials.index(material) for material in slot_materials(obj))
    index = meshes.index(obj.data, len(slots), *materials.needs(slots))
    if index is not None:
        scene.instances.append(Instance(
            index, matrix, slots, _name(item), _visibility(item, view_layer), _is_holdout(item, view_layer)))


def slot_materials(obj: bpy.types.Object) -> list[bpy.types.Material | None]:
    """Material of each slot: that of the object where its slot says so, else that of its evaluated mesh.

    Modifiers may add slots to the mesh that the object does not have. Without any slot there is one default material.
    """
    data, slots = obj.data.materials, obj.material_slots
    found = []
    for i in range(max(len(data), len(slots), 1)):
        if i < len(slots) and slots[i].link == "OBJECT":
            found.append(slots[i].material)
        else:
            found.append(data[i] if i < len(data) else None)
    return found


def _name(item) -> str:
    """The object that the user knows: the instancer, for an instance without a name of its own."""
    return item.object.original.name if item.object.original else item.parent.name


def _owners(item):
    yield item.object
    if item.is_instance and item.parent is not None:
        yield item.parent


def _visibility(item, view_layer) -> Ray:
    """Rays that see the instance: those that see both the object and what instances it."""
    rays = Ray.ALL
    for owner in _owners(item):
        rays &= visibility_of(owner)
        if owner.original.indirect_only_get(view_layer=view_layer):
            rays &= ~Ray.CAMERA
    return rays


def _is_holdout(item, view_layer) -> bool:
    return any(owner.is_holdout or owner.original.holdout_get(view_layer=view_layer) for owner in _owners(item))


def _invertible(matrix: np.ndarray) -> np.ndarray | None:
    """``matrix``, with a trace of thickness where it flattens (a plane scaled to zero along its normal is still to be
    seen); None where it leaves no area at all."""
    rotation, scales, axes = np.linalg.svd(matrix[:3, :3])
    if scales[1] <= FLAT * scales[0] or scales[0] == 0.0:
        return None
    if scales[2] > FLAT * scales[0]:
        return matrix
    scales[2] = _THICKNESS * scales[0]
    result = matrix.copy()
    result[:3, :3] = (rotation * scales) @ axes
    return result
