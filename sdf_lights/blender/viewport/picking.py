# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A click on the body of a lamp selects it.

Blender selects by its own drawing, in which a lamp is only an icon. So a click comes here first. If it is on a lamp in
front of everything, and not on the icon of another object, this operator selects the lamp. Else the click goes on to
Blender.
"""

from __future__ import annotations

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Vector

from ... import affine
from ...render.errors import RenderError
from ...render.scene import Lamp
from .drawn import shown_lamps

POINTS = 2048  # samples of the field along the ray in the lamp's box
ICON = 12.0  # pixels around the origin of objects with an icon instead of a surface, at a UI scale of 1

_keymaps: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def entry(lamp: Lamp, origin: np.ndarray, direction: np.ndarray) -> float | None:
    """Distance along a ray from ``origin`` (3,), in lengths of ``direction`` (3,), at which it enters a lamp; None if
    it misses."""
    inverse = affine.inverse(lamp.matrix)
    o, d = inverse[:3, :3] @ origin + inverse[:3, 3], inverse[:3, :3] @ direction
    low, high = lamp.shape.bounds()
    with np.errstate(divide="ignore", invalid="ignore"):
        edges = np.sort(np.stack([(low - o) / d, (high - o) / d]), axis=0)
    start, end = max(np.nanmax(edges[0]), 0.0), np.nanmin(edges[1])
    if not (start < end and np.isfinite(end)):
        return None
    t = start + (end - start) * (np.arange(POINTS) + 0.5) / POINTS
    inside = lamp.shape.distance(o + t[:, None] * d) <= 0.0
    return float(t[np.argmax(inside)]) if inside.any() else None


class SDFLIGHTS_OT_lamp_pick(bpy.types.Operator):
    """Selects the SDF lamp under the mouse."""

    bl_idname = "sdf_lights.lamp_pick"
    bl_label = "Select SDF Lamp"
    bl_description = "Select the SDF lamp under the mouse"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    extend: bpy.props.BoolProperty(
        name="Extend",
        description="Select or deselect the lamp without changing the rest of the selection",
        default=False,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and getattr(context.space_data, "type", "") == "VIEW_3D"

    def invoke(self, context, event):
        if event.type != _select_mouse(context):
            return {"PASS_THROUGH"}
        obj = _under(context, (event.mouse_region_x, event.mouse_region_y))
        if obj is None:
            return {"PASS_THROUGH"}
        is_active = context.view_layer.objects.active == obj
        if self.extend:
            obj.select_set(not (is_active and obj.select_get()))
        else:
            for other in context.selected_objects:
                other.select_set(False)
            obj.select_set(True)
        context.view_layer.objects.active = obj
        return {"FINISHED"}


def _select_mouse(context) -> str:
    preferences = context.window_manager.keyconfigs.active.preferences
    return f"{getattr(preferences, 'select_mouse', 'LEFT')}MOUSE"


def _under(context, place: tuple[float, float]) -> bpy.types.Object | None:
    """The object of the lamp whose body is nearest at a point of the region."""
    region, data = context.region, context.region_data
    origin = np.array(region_2d_to_origin_3d(region, data, place))
    direction = np.array(region_2d_to_vector_3d(region, data, place))
    nearest, found = _surface(context, origin, direction), None
    for item in shown_lamps(context):
        try:
            distance = entry(item.lamp, origin, direction)
        except (ArithmeticError, RenderError):
            continue
        if distance is not None and distance < nearest:
            nearest, found = distance, item
    obj = found and context.view_layer.objects.get(found.owner)
    return None if obj is None or obj.hide_select or _on_icon(context, place, obj) else obj


def _surface(context, origin: np.ndarray, direction: np.ndarray) -> float:
    """Distance of the first surface of the scene in a viewport."""
    if context.space_data.shading.type == "WIREFRAME":
        return np.inf
    hit, location, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), Vector(origin), Vector(direction))
    return float(np.dot(np.array(location) - origin, direction)) if hit else np.inf


def _on_icon(context, place: tuple[float, float], but: bpy.types.Object) -> bool:
    """Whether the icon of another object than ``but`` is at a point of the region."""
    overlay, reach = context.space_data.overlay, ICON * context.preferences.system.ui_scale
    if not (overlay.show_overlays and overlay.show_extras):
        return False
    for obj in context.visible_objects:
        if obj == but or obj.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"}:
            continue
        at = location_3d_to_region_2d(context.region, context.region_data, obj.matrix_world.translation)
        if at is not None and (at - Vector(place)).length < reach:
            return True
    return False


CLASSES = (SDFLIGHTS_OT_lamp_pick,)


def register():
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="Object Mode")
    for button in ("LEFTMOUSE", "RIGHTMOUSE"):
        for shift in (False, True):
            item = keymap.keymap_items.new(SDFLIGHTS_OT_lamp_pick.bl_idname, button, "CLICK", shift=shift)
            item.properties.extend = shift
            _keymaps.append((keymap, item))


def unregister():
    for keymap, item in _keymaps:
        keymap.keymap_items.remove(item)
    _keymaps.clear()
