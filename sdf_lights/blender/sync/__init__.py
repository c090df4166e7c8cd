# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From an evaluated dependency graph to ``render.scene.Scene``: plain data, in which nothing refers to Blender."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import bpy

from ...render.scene import Camera, Scene
from ...render.settings import Settings
from ..properties import settings_of
from .camera import border_of, camera_of, frame_size
from .common import Warnings
from .images import Images
from .materials import Materials
from .objects import LIGHTS, sync_objects
from .world import world_of

__all__ = ["frame_settings", "shows_in", "sync", "sync_lights", "sync_viewport"]

# Odd, and far from any ratio of small numbers: seeds of neighbouring frames have nothing in common.
_FRAME_STRIDE = 0x9E3779B1


def sync(depsgraph: bpy.types.Depsgraph) -> Scene:
    """The scene of a dependency graph, for a final render.

    What cannot be used is left out or replaced, with a sentence in ``Scene.warnings``. Raises RenderError where there
    is nothing to render at all, such as no camera.
    """
    blender_scene = depsgraph.scene_eval
    warnings: list[str] = []
    warn = Warnings(warnings)
    width, height = frame_size(blender_scene.render)
    camera = blender_scene.camera and blender_scene.camera.evaluated_get(depsgraph)
    scene = Scene(
        camera_of(camera, depsgraph, width, height, warn), width, height,
        border_of(blender_scene.render, width, height), settings=frame_settings(blender_scene), warnings=warnings)
    _fill(depsgraph, scene, warn)
    return scene


def sync_viewport(depsgraph: bpy.types.Depsgraph, space: bpy.types.SpaceView3D) -> Scene:
    """What a viewport shows of a dependency graph. Camera, size and settings are left to its redraws."""
    scene = Scene(Camera(None), 0, 0)
    _fill(depsgraph, scene, Warnings(scene.warnings), shows_in(space))
    return scene


def sync_lights(depsgraph: bpy.types.Depsgraph, scene: Scene, space: bpy.types.SpaceView3D) -> Scene:
    """``scene``, as ``sync_viewport`` gave it, with its lamps and lights read again."""
    result = replace(scene, lamps=[], lights=[], warnings=list(scene.warnings))
    sync_objects(depsgraph, result, None, Warnings(result.warnings), LIGHTS, shows_in(space))
    return result


def frame_settings(scene: bpy.types.Scene, viewport: bool = False) -> Settings:
    """The settings, with the seed of the current frame."""
    settings = settings_of(scene, viewport)
    if settings.animate_seed:
        settings.seed = (settings.seed + scene.frame_current * _FRAME_STRIDE) & 0x7FFFFFFF
    return settings


def _fill(depsgraph: bpy.types.Depsgraph, scene: Scene, warn: Warnings, shows: Callable = lambda item: True) -> None:
    view_layer = depsgraph.view_layer_eval
    images = Images(scene, warn)
    materials = Materials(scene, images, warn, view_layer.material_override)
    world = getattr(view_layer, "world_override", None) or depsgraph.scene_eval.world
    scene.world = world_of(world, images, warn)
    sync_objects(depsgraph, scene, materials, warn, shows=shows)


def shows_in(space: bpy.types.SpaceView3D) -> Callable[[bpy.types.DepsgraphObjectInstance], bool]:
    """Whether a viewport shows an instance: local view, local collections, kinds of objects that it hides."""
    known: dict[int, bool] = {}

    def shows(item: bpy.types.DepsgraphObjectInstance) -> bool:
        owner = item.parent if item.is_instance and item.parent is not None else item.object
        original = owner.original
        key = original.as_pointer()
        if key not in known:
            known[key] = original.visible_in_viewport_get(space)
        return known[key]

    return shows
