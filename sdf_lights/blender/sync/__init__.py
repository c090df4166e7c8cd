# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From an evaluated dependency graph to ``render.scene.Scene``: plain data without references to Blender."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import bpy

from ...render.displacement import CyclesVersion, displace
from ...render.material import UV
from ...render.passes import BY_NAME
from ...render.scene import Camera, Scene
from ...render.settings import CausticPaths, LampPaths, PathReuse, Settings
from .. import cycles, preferences, versions
from ..passes import is_enabled, layer_passes
from ..properties import layer_samples, settings_of
from .camera import border_of, camera_of, frame_size
from .common import Warnings
from .images import Images
from .kept import Kept
from .linking import signature as linking_signature
from .materials import Materials
from .motion import Motion, is_wanted
from .neighbor_frames import NeighborFrames, has_vectors
from .objects import ALL, LIGHTS, sync_objects
from .simplify import Culling, texture_limit, texture_share
from .unmodelled import report_unmodelled
from .world import mist_of, world_of

__all__ = [
    "Kept",
    "frame_settings",
    "linking_signature",
    "shows_in",
    "sync",
    "sync_camera",
    "sync_lights",
    "sync_viewport",
    "sync_views",
]

# Odd, and far from any ratio of small numbers: seeds of neighbouring frames are unrelated.
_FRAME_STRIDE = 0x9E3779B1


def sync(depsgraph: bpy.types.Depsgraph, engine: bpy.types.RenderEngine | None = None) -> Scene:
    """The scene of a dependency graph, for a final render in the active view of ``engine``.

    Unusable data is left out or replaced, with a sentence in ``Scene.warnings``. Raises RenderError if nothing can be
    rendered, for instance without a camera.
    """
    return sync_views(depsgraph, engine)[0]


def sync_views(
    depsgraph: bpy.types.Depsgraph,
    engine: bpy.types.RenderEngine | None = None,
    views: tuple[str, ...] = (),
    kept: Kept | None = None,
) -> tuple[Scene, list[Camera]]:
    """As ``sync``, with the cameras of the ``views`` of the render (by default of the active one); the first is used.
    ``kept``: the engine's data from its last render of this dependency graph."""
    blender_scene = depsgraph.scene_eval
    warnings: list[str] = []
    warn = Warnings(warnings)

    def cameras() -> list[Camera]:
        found = []
        for view in views or (None,):
            if view is not None:
                engine.active_view_set(view)
            found.append(sync_camera(depsgraph, warn, engine))
        return found

    width, height = frame_size(blender_scene.render)
    eyes = cameras()
    scene = Scene(
        eyes[0],
        width,
        height,
        border_of(blender_scene.render, width, height),
        warnings=warnings,
        settings=layer_settings(blender_scene, depsgraph.view_layer_eval),
    )
    warn(cycles.missing(blender_scene))
    warn(versions.newer(depsgraph))
    scene.passes, scene.alpha_threshold = layer_passes(depsgraph.view_layer), depsgraph.view_layer.pass_alpha_threshold
    if is_enabled(BY_NAME["UV"], depsgraph.view_layer):
        scene.attributes.append(UV)
    kind = None
    if engine is not None and not engine.is_preview:
        kind = Motion if is_wanted(depsgraph) else NeighborFrames if has_vectors(depsgraph) else None
    motion = kind(depsgraph, engine, scene, cameras) if kind is not None else None
    if kept is not None:
        kept.begin(depsgraph)
        scene.kept = kept.back_end
    _fill(depsgraph, scene, warn, motion=motion, eyes=eyes, kept=kept)
    report_unmodelled(depsgraph, _world(depsgraph), warn)
    return scene, eyes


def sync_camera(
    depsgraph: bpy.types.Depsgraph, warn: Callable[[str], None], engine: bpy.types.RenderEngine | None = None
) -> Camera:
    """The camera of a final render, in the active view of ``engine``."""
    blender_scene = depsgraph.scene_eval
    chosen = (engine.camera_override if engine is not None else None) or blender_scene.camera
    return camera_of(
        chosen and chosen.evaluated_get(depsgraph), depsgraph, *frame_size(blender_scene.render), warn, engine
    )


def sync_viewport(depsgraph: bpy.types.Depsgraph, space: bpy.types.SpaceView3D) -> Scene:
    """The scene of a viewport, from a dependency graph. Its redraws add camera, size and settings."""
    scene = Scene(Camera(None), 0, 0)
    _fill(depsgraph, scene, Warnings(scene.warnings), shows_in(space))
    return scene


def sync_lights(depsgraph: bpy.types.Depsgraph, scene: Scene, space: bpy.types.SpaceView3D) -> Scene:
    """``scene``, a result of ``sync_viewport``, with its lamps and lights read again."""
    result = replace(scene, lamps=[], lights=[], portals=[], images=list(scene.images), warnings=list(scene.warnings))
    warn = Warnings(result.warnings)
    images = Images(result, warn, depsgraph.scene_eval.frame_current)
    sync_objects(depsgraph, result, None, images, warn, LIGHTS, shows_in(space))
    images.load()
    return result


def frame_settings(scene: bpy.types.Scene, viewport: bool = False) -> Settings:
    """The settings, with the seed of the current frame."""
    settings = settings_of(scene, viewport)
    preferences.apply(settings)
    if viewport and settings.lamp_paths is LampPaths.AUTOMATIC:
        settings.lamp_paths = LampPaths.NEVER  # it would have to be measured anew at each edit
    if viewport and settings.path_reuse is PathReuse.AUTOMATIC:
        settings.path_reuse = PathReuse.NEVER
    if viewport:
        settings.caustic_paths = CausticPaths.NEVER
    if settings.animate_seed:
        settings.seed = (settings.seed + scene.frame_current * _FRAME_STRIDE) & 0x7FFFFFFF
    return settings


def layer_settings(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Settings:
    """The settings of a view layer for the final render, with the seed of the current frame."""
    settings = frame_settings(scene)
    settings.samples = layer_samples(scene, settings.samples, view_layer.samples)
    settings.denoise &= getattr(getattr(view_layer, "cycles", None), "use_denoising", True)
    return settings


def _fill(
    depsgraph: bpy.types.Depsgraph,
    scene: Scene,
    warn: Warnings,
    shows: Callable = lambda item: True,
    motion: Motion | None = None,
    eyes: Sequence[Camera] = (),
    kept: Kept | None = None,
) -> None:
    limits = texture_limit(depsgraph), texture_share(depsgraph)
    images = Images(scene, warn, depsgraph.scene_eval.frame_current, *limits, kept)
    materials = Materials(scene, depsgraph, images, warn)
    view_layer = depsgraph.view_layer_eval
    world = _world(depsgraph)
    if world is not None:
        scene.mist, scene.occlusion_distance = mist_of(world.mist_settings), world.light_settings.distance
    if view_layer.use_sky:
        scene.world = world_of(world, depsgraph, images, warn, scene.passes)
    kinds = ALL if view_layer.use_solid else ALL - {"MESH"}
    if not view_layer.use_strand:
        kinds -= {"CURVES"}
    # as in Cycles, these are objects of that kind, not the volumes of meshes and the world
    if not view_layer.use_volumes:
        kinds -= {"VOLUME"}
    culling = Culling(depsgraph, eyes[0] if eyes else None)
    noted = sync_objects(depsgraph, scene, materials, images, warn, kinds, shows, motion is not None, culling, kept)
    images.load()
    if motion is not None:
        motion.read(noted.placed, noted.forms, eyes)
    displace(scene, CyclesVersion(bpy.app.version < (5, 1, 0), bpy.app.version < (5, 0, 0)))


def _world(depsgraph: bpy.types.Depsgraph) -> bpy.types.World | None:
    return getattr(depsgraph.view_layer_eval, "world_override", None) or depsgraph.scene_eval.world


def shows_in(space: bpy.types.SpaceView3D) -> Callable[[bpy.types.DepsgraphObjectInstance], bool]:
    """Whether a viewport shows an instance: local view, local collections, hidden kinds of objects."""
    known: dict[int, bool] = {}

    def shows(item: bpy.types.DepsgraphObjectInstance) -> bool:
        owner = item.parent if item.is_instance and item.parent is not None else item.object
        original = owner.original
        key = original.as_pointer()
        if key not in known:
            known[key] = original.visible_in_viewport_get(space)
        return known[key]

    return shows
