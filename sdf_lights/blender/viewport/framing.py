# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frame Selected and Frame All with the bodies of lamps.

Blender frames a light as if it had the size of its scale, and refuses add-on operators of the same name. So its keys
come here first. If lamps are to be framed, this operator handles them; else the keys go on to Blender.
"""

from __future__ import annotations

import time

import bpy
import numpy as np
from mathutils import Vector

from . import bodies, keys

MARGIN = 1.4  # as in Blender: half of the picture over half of the framed size
_FRAMES = 1.0 / 60.0  # seconds between two steps of a smooth change

_keymaps: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def extent(obj: bpy.types.Object) -> np.ndarray:
    """World points (n, 3) around an object, like Blender's for all objects except lamps."""
    if bodies.is_lamp(obj):
        found = bodies.points_in_world(obj)
        if len(found):
            return found
    if obj.type in {"MESH", "CURVE", "CURVES", "SURFACE", "FONT", "META", "POINTCLOUD", "VOLUME", "GREASEPENCIL"}:
        return np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
    half = np.abs(np.array(obj.scale)) * (obj.empty_display_size if obj.type == "EMPTY" else 1.0)
    middle = np.array(obj.matrix_world.translation)
    return np.stack([middle - half, middle + half])


def frame(context, objects: list[bpy.types.Object]) -> None:
    """Move the view of a 3D viewport so that these objects fill it."""
    data, space = context.region_data, context.space_data
    depsgraph = context.evaluated_depsgraph_get()
    points = np.concatenate([extent(obj.evaluated_get(depsgraph)) for obj in objects])
    low, high = points.min(axis=0), points.max(axis=0)
    radius = MARGIN * 0.5 * max(float((high - low).max()), 1e-4)
    if data.view_perspective == "CAMERA":
        data.view_perspective = "PERSP"
        data.update()
    projection = data.window_matrix
    if data.is_perspective:
        distance = max(radius * max(projection[0][0], projection[1][1]), 1.5 * space.clip_start)
    else:  # half of the picture grows with the distance
        distance = data.view_distance * radius * max(projection[0][0], projection[1][1])
    _move(context, Vector(0.5 * (low + high)), distance)


def _move(context, location: Vector, distance: float) -> None:
    """Change the view as smoothly as the preferences say."""
    data, region = context.region_data, context.region
    seconds = context.preferences.view.smooth_view / 1000.0
    before, started = (data.view_location.copy(), data.view_distance), time.monotonic()

    def step():
        done = min((time.monotonic() - started) / seconds, 1.0) if seconds > 0.0 else 1.0
        ease = done * done * (3.0 - 2.0 * done)
        try:
            data.view_location = before[0].lerp(location, ease)
            data.view_distance = before[1] + (distance - before[1]) * ease
            region.tag_redraw()
        except ReferenceError:  # the viewport was closed
            return None
        return _FRAMES if done < 1.0 else None

    if seconds > 0.0 and not bpy.app.background:
        bpy.app.timers.register(step)
    else:
        step()


class SDFLIGHTS_OT_view_frame(bpy.types.Operator):
    """Move the view so that the selection fills it, with the whole bodies of lamps"""

    bl_idname = "sdf_lights.view_frame"
    bl_label = "Frame Selected SDF Lamps"
    bl_options = {"REGISTER"}

    everything: bpy.props.BoolProperty(
        name="Everything", description="Frame all visible objects instead of the selected ones", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and getattr(context.space_data, "type", "") == "VIEW_3D"

    def _framed(self, context):
        objects = context.visible_objects if self.everything else context.selected_objects
        return list(objects) if any(map(bodies.is_lamp, objects)) else []

    def invoke(self, context, event):
        blenders = "view3d.view_all" if self.everything else "view3d.view_selected"
        if not keys.is_of(context, event, blenders) or not self._framed(context) or context.region_data.lock_rotation:
            return {"PASS_THROUGH"}
        return self.execute(context)

    def execute(self, context):
        objects = self._framed(context)
        if not objects:
            return {"CANCELLED"}
        frame(context, objects)
        return {"FINISHED"}


def draw_menu(self, context):
    """Entry in View, if lamps are selected."""
    if context.mode == "OBJECT" and any(map(bodies.is_lamp, context.selected_objects)):
        self.layout.separator()
        self.layout.operator_context = "EXEC_REGION_WIN"
        self.layout.operator(SDFLIGHTS_OT_view_frame.bl_idname)


CLASSES = (SDFLIGHTS_OT_view_frame,)


def register():
    bpy.types.VIEW3D_MT_view.append(draw_menu)
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="Object Mode")
    for key, everything in (("NUMPAD_PERIOD", False), ("HOME", True)):
        item = keymap.keymap_items.new(SDFLIGHTS_OT_view_frame.bl_idname, key, "PRESS")
        item.properties.everything = everything
        _keymaps.append((keymap, item))


def unregister():
    bpy.types.VIEW3D_MT_view.remove(draw_menu)
    for keymap, item in _keymaps:
        keymap.keymap_items.remove(item)
    _keymaps.clear()
