# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From an evaluated dependency graph to ``render.scene.Scene``: plain data, in which nothing refers to Blender."""

from __future__ import annotations

import bpy

from ...render.scene import Scene
from ..properties import settings_of
from .camera import border_of, camera_of, frame_size
from .common import Warnings
from .images import Images
from .materials import Materials
from .objects import sync_objects
from .world import world_of

__all__ = ["sync"]

# Odd, and far from any ratio of small numbers: seeds of neighbouring frames have nothing in common.
_FRAME_STRIDE = 0x9E3779B1


def sync(depsgraph: bpy.types.Depsgraph) -> Scene:
    """The scene of a dependency graph, for a final render.

    What cannot be used is left out or replaced, with a sentence in ``Scene.warnings``. Raises RenderError where there
    is nothing to render at all, such as no camera.
    """
    blender_scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    warnings: list[str] = []
    warn = Warnings(warnings)
    width, height = frame_size(blender_scene.render)
    camera = blender_scene.camera and blender_scene.camera.evaluated_get(depsgraph)
    scene = Scene(
        camera_of(camera, depsgraph, width, height, warn), width, height,
        border_of(blender_scene.render, width, height), settings=settings_of(blender_scene), warnings=warnings)
    if scene.settings.animate_seed:
        scene.settings.seed = (scene.settings.seed + blender_scene.frame_current * _FRAME_STRIDE) & 0x7FFFFFFF
    images = Images(scene, warn)
    materials = Materials(scene, images, warn, view_layer.material_override)
    world = getattr(view_layer, "world_override", None) or blender_scene.world
    scene.world = world_of(world, images, warn)
    sync_objects(depsgraph, scene, materials, warn)
    return scene
