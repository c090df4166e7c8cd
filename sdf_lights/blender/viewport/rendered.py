# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading of the viewport: the data of each engine instance of a viewport.

Blender calls ``view_update`` after changes of the data and ``view_draw`` at each redraw. The first records the change.
The second copies the change, compares the view, draws the latest picture, and never waits. A thread renders; a timer
polls it for results.
"""

from __future__ import annotations

import os
import weakref
from dataclasses import replace

import bpy
import gpu
import numpy as np

from ...render import libraries
from ...render.errors import RenderError
from ...render.interactive import Change, InteractiveRender, Picture
from ...render.scene import Scene
from ..naming import LABEL, NODE_TREE
from ..sync import frame_settings, linking_signature, sync_lights, sync_viewport
from .drawing import draw_texture
from .viewport_camera import view_camera

POLL = 0.04

_running: weakref.WeakSet = weakref.WeakSet()
_by_region: dict[int, weakref.ref] = {}


class RenderedView:
    """The progressive render of one viewport."""

    def __init__(self):
        self._render = InteractiveRender()
        self._scene: Scene | None = None
        self._shown: tuple = ()  # other conditions of the scene's last sync
        self._linking: tuple = ()
        self._stale: Change | None = Change.ALL
        self._texture: tuple[Picture, gpu.types.GPUTexture] | None = None  # the last drawn picture
        self._drawn_status = ""
        self._region = 0
        _running.add(self)
        # Blender may free its part of an engine before Python's, so the engine cannot be asked later.
        weakref.finalize(self, self._render.stop).atexit = False

    @property
    def news(self) -> bool:
        """Whether there is a reason to redraw."""
        return self._stale is None and (
            self._render.picture is not self.drawn or self._render.status != self._drawn_status
        )

    @property
    def busy(self) -> bool:
        """Whether there may be results later."""
        return self._render.active

    @property
    def drawn(self) -> Picture | None:
        """The picture in the viewport."""
        return self._texture[0] if self._texture is not None else None

    @property
    def warnings(self) -> list[str]:
        """Warnings of the render, and its error if it has failed."""
        return self._render.warnings + ([self._render.error] if self._render.error else [])

    def data_changed(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Record a change; the next redraw copies it."""
        change = Change.ALL if self._scene is None else change_of(depsgraph)
        if change is not None:
            self._stale = change if self._stale is None else max(change, self._stale)
            self._render.hold()

    def draw(self, engine: bpy.types.RenderEngine, context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draw the latest picture, and restart the render if the view or the data have changed."""
        self._remember(context.region)
        try:
            self._restart(context, depsgraph)
        except RenderError as error:
            self._scene, self._stale = None, Change.ALL
            self._render.stop()
            engine.update_stats(LABEL, str(error))
            return
        picture = self._render.picture
        if picture is not None:
            self._show(engine, picture, context, depsgraph.scene)
        self._drawn_status = self._render.status
        engine.update_stats(LABEL, self._drawn_status)
        watch()

    def _restart(self, context, depsgraph: bpy.types.Depsgraph) -> None:
        space, region = context.space_data, context.region
        shown = filters(space)
        change = self._stale
        if self._scene is None or shown != self._shown:
            change = Change.ALL
        if change is not None and change >= Change.LIGHTS:
            linking = linking_signature(depsgraph)
            if linking != self._linking:
                self._linking, change = linking, Change.ALL
        settings = frame_settings(depsgraph.scene_eval, viewport=True)
        if self._scene is not None and (settings.device, settings.threads) != (
            self._scene.settings.device,
            self._scene.settings.threads,
        ):
            change = Change.ALL
        if change is Change.ALL:
            self._find_libraries()
            scene = sync_viewport(depsgraph, space)
        elif change is Change.LIGHTS:
            scene = sync_lights(depsgraph, self._scene, space)
        else:
            scene = self._scene
        self._render.paused = depsgraph.scene.sdf_lights_overlay.pause
        self._render.coarse_lamps = not depsgraph.scene.sdf_lights_overlay.show_lamps
        camera, border = view_camera(context, depsgraph, region.width, region.height)
        view = replace(scene, camera=camera, width=region.width, height=region.height, border=border, settings=settings)
        if change is None and self._scene is not None and _same_view(view, self._scene):
            return
        if view.border is not None and (view.border[2] <= view.border[0] or view.border[3] <= view.border[1]):
            raise RenderError(
                "The render region is empty or outside of the view: set it with Ctrl B, or clear it with Ctrl Alt B."
            )
        self._scene, self._shown, self._stale = view, shown, None
        self._render.update(view, Change.VIEW if change is None else change)

    @staticmethod
    def _find_libraries() -> None:
        if bpy.app.binary_path:
            libraries.add_search_folder(os.path.dirname(bpy.app.binary_path))

    def _show(self, engine, picture: Picture, context, scene) -> None:
        if picture is not self.drawn:
            height, width = picture.pixels.shape[:2]
            data = gpu.types.Buffer("FLOAT", picture.pixels.size, picture.pixels.ravel())
            self._texture = picture, gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
        width, height = picture.size
        x0, y0, x1, y1 = picture.window
        place = x0 / width, y0 / height, x1 / width, y1 / height
        if engine.support_display_space_shader(scene):
            engine.bind_display_space_shader(scene)
            try:
                draw_texture(self._texture[1], place)
            finally:
                engine.unbind_display_space_shader()
        else:
            draw_texture(self._texture[1], place)

    def _remember(self, region) -> None:
        self._region = region.as_pointer()
        _by_region[self._region] = weakref.ref(self)

    def stop(self) -> None:
        """End the thread and wait for it; the next redraw starts again."""
        self._render.stop()
        self._scene, self._stale = None, Change.ALL

    def close(self) -> None:
        """Stop the render for good."""
        self.stop()
        _running.discard(self)
        _by_region.pop(self._region, None)


def _same_view(a: Scene, b: Scene) -> bool:
    if (a.width, a.height, a.border, a.settings) != (b.width, b.height, b.border, b.settings):
        return False
    first, second = vars(a.camera), vars(b.camera)
    return all(np.array_equal(first[name], second[name]) for name in first)


def filters(space: bpy.types.SpaceView3D) -> tuple:
    """State of a viewport that affects its scene without a data update."""
    return (
        space.local_view is not None,
        space.use_local_collections,
        *(getattr(space, name) for name in dir(space) if name.startswith("show_object_viewport_")),
    )


def change_of(depsgraph: bpy.types.Depsgraph) -> Change | None:
    """The part of the scene that the updates of a dependency graph affect; None if they affect no picture."""
    change = None
    for update in depsgraph.updates:
        if not (update.is_updated_geometry or update.is_updated_transform or update.is_updated_shading):
            continue
        found = _change_of(update.id)
        if found is not None:
            change = found if change is None else max(found, change)
    return change


def _change_of(block: bpy.types.ID) -> Change | None:
    if isinstance(block, (bpy.types.Camera, bpy.types.Screen, bpy.types.WindowManager)):
        return Change.VIEW
    if isinstance(block, bpy.types.NodeTree) and block.is_embedded_data:
        return None  # its owner is among the updates too
    if isinstance(block, bpy.types.Light) or getattr(block, "bl_idname", "") == NODE_TREE:
        return Change.LIGHTS
    if isinstance(block, bpy.types.Object):
        if block.type == "EMPTY" and block.instance_type == "NONE":
            return Change.LIGHTS  # parts of lamps may follow it
        return {"CAMERA": Change.VIEW, "LIGHT": Change.LIGHTS}.get(block.type, Change.ALL)
    return Change.ALL


def shows_lamps(context) -> bool:
    """Whether the path tracer's picture contains the lamps of this region."""
    if context.space_data.shading.type != "RENDERED":
        return False
    found = _by_region.get(context.region.as_pointer())
    view = found() if found is not None else None
    return view is not None and view.drawn is not None and view.drawn.lamps


def warnings() -> list[str]:
    """Sentences about parts that renders in viewports left out."""
    found: list[str] = []
    for view in list(_running):
        found += [warning for warning in view.warnings if warning not in found]
    return found


def stop_all() -> None:
    """End every render in a viewport and wait for its threads; the next redraw restarts the remaining ones."""
    for view in list(_running):
        view.stop()


# -- news from threads ---------------------------------------------------------------------------------------------


def watch() -> None:
    """Redraw viewports when their renders have results, until all are finished."""
    if not bpy.app.timers.is_registered(_poll):
        bpy.app.timers.register(_poll, first_interval=POLL)


def _poll() -> float | None:
    views = list(_running)
    if any(view.news for view in views):
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D" and any(
                    space.type == "VIEW_3D" and space.shading.type == "RENDERED" for space in area.spaces
                ):
                    area.tag_redraw()
    return POLL if any(view.busy or view.news for view in views) else None
