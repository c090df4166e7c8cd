# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Box and circle select with the bodies of lamps.

Blender selects by its own drawing in a rectangle or a circle, in which a lamp is only an icon. Where lamps are shown,
the operators here handle the gestures: they let Blender select as usual, and then add the lamps whose body is partly
inside. Without lamps, they leave everything to Blender.
"""

from __future__ import annotations

import math

import bpy
import gpu
import numpy as np
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from gpu_extras.batch import batch_for_shader

from ...render.errors import RenderError
from . import bodies, keys, picking
from .drawn import shown_lamps

_RADIUS = 25  # initial radius of the circle in pixels
_MODES = [
    ("SET", "Set", "Set a new selection", 0),
    ("ADD", "Extend", "Extend existing selection", 1),
    ("SUB", "Subtract", "Subtract existing selection", 2),
    ("XOR", "Difference", "Invert existing selection", 3),
    ("AND", "Intersect", "Intersect existing selection", 4),
]
_DIRECT = (("", "SET"), ("shift", "ADD"), ("ctrl", "SUB"), ("shift ctrl", "AND"))  # keys of Blender's tools

_keymaps: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def lamps_where(context, is_inside, middle: tuple[float, float]) -> set[bpy.types.Object]:
    """Visible lamps with a part of their body where ``is_inside`` is true of the pixels (n, 2) of a region; or with the
    body behind ``middle``, if that is inside."""
    region, data = context.region, context.region_data
    projection = np.array(data.perspective_matrix)
    ray = [np.array(made(region, data, middle)) for made in (region_2d_to_origin_3d, region_2d_to_vector_3d)]
    found = set()
    for item in shown_lamps(context):
        obj = context.view_layer.objects.get(item.owner)
        if obj is None or obj in found or obj.hide_select:
            continue
        points = bodies.points_of(item.lamp.shape)
        world = points @ item.lamp.matrix[:3, :3].T + item.lamp.matrix[:3, 3]
        clip = np.hstack([world, np.ones((len(world), 1))]) @ projection.T
        clip = clip[clip[:, 3] > 0.0]
        pixels = (0.5 * clip[:, :2] / clip[:, 3:] + 0.5) * (region.width, region.height)
        inside = bool(is_inside(pixels).any())
        if not inside:  # a small area between the points
            try:
                inside = picking.entry(item.lamp, *ray) is not None
            except (ArithmeticError, RenderError):
                pass
        if inside:
            found.add(obj)
    return found


def apply(context, mode: str, hit: set[bpy.types.Object], blender) -> None:
    """Let ``blender()`` select, and then select the lamps that it cannot see in the same ``mode``."""
    before = {obj: obj.select_get() for obj in hit}
    blender()
    for obj, was in before.items():
        if mode in {"SET", "ADD"}:
            obj.select_set(True)
        elif mode == "SUB":
            obj.select_set(False)
        elif mode == "AND":
            obj.select_set(was)
        elif obj.select_get() == was:  # XOR, for a lamp whose icon is outside
            obj.select_set(not was)


class _Gesture:
    """A modal operator that draws lines over its region."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and getattr(context.space_data, "type", "") == "VIEW_3D"

    def is_not_ours(self, context, event, blenders: str) -> bool:
        """Whether Blender handles the gesture: without lamps, or if the user has another key for it."""
        by_key = self.wait_for_input and not keys.is_of(context, event, blenders)
        return by_key or not shown_lamps(context)

    def begin(self, context):
        self._region = context.region
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_PIXEL")
        context.window_manager.modal_handler_add(self)
        context.region.tag_redraw()

    def end(self, context):
        bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
        context.window.cursor_modal_restore()
        self._region.tag_redraw()

    def _draw(self):
        if bpy.context.region != self._region:
            return
        points = self.outline()
        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        gpu.state.blend_set("ALPHA")
        for offset, color in ((1.0, (0.0, 0.0, 0.0, 0.6)), (0.0, (1.0, 1.0, 1.0, 0.8))):
            shader.bind()
            shader.uniform_float("color", color)
            placed = [(x + offset, y - offset) for x, y in points]
            batch_for_shader(shader, "LINE_STRIP", {"pos": placed}).draw(shader)
        gpu.state.blend_set("NONE")


class SDFLIGHTS_OT_select_box(_Gesture, bpy.types.Operator):
    """Select items using box selection, lamps by their bodies"""

    bl_idname = "sdf_lights.select_box"
    bl_label = "Box Select"

    mode: bpy.props.EnumProperty(name="Mode", items=_MODES, options={"SKIP_SAVE"})
    wait_for_input: bpy.props.BoolProperty(name="Wait for Input", default=True, options={"SKIP_SAVE"})
    xmin: bpy.props.IntProperty(name="X Min", options={"HIDDEN", "SKIP_SAVE"})
    xmax: bpy.props.IntProperty(name="X Max", options={"HIDDEN", "SKIP_SAVE"})
    ymin: bpy.props.IntProperty(name="Y Min", options={"HIDDEN", "SKIP_SAVE"})
    ymax: bpy.props.IntProperty(name="Y Max", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        if self.is_not_ours(context, event, "view3d.select_box"):
            return {"PASS_THROUGH"}
        self._start = None
        if not self.wait_for_input:
            region = context.region
            self._start = event.mouse_prev_press_x - region.x, event.mouse_prev_press_y - region.y
            if self.mode == "SET":
                self.mode = _mode_of_tool(context, "view3d.select_box")
        self._now = event.mouse_region_x, event.mouse_region_y
        context.window.cursor_modal_set("CROSSHAIR")
        self.begin(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        self._now = event.mouse_region_x, event.mouse_region_y
        self._region.tag_redraw()
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.end(context)
            return {"CANCELLED"}
        if event.type in {"LEFTMOUSE", "MIDDLEMOUSE"}:
            if event.value == "PRESS":
                self._start = self._now
                if self.wait_for_input:  # as Blender's own keys inside the gesture
                    self.mode = "SUB" if event.shift or event.type == "MIDDLEMOUSE" else self.mode
            elif event.value == "RELEASE" and self._start is not None:
                self.end(context)
                (self.xmin, self.xmax), (self.ymin, self.ymax) = map(sorted, zip(self._start, self._now))
                return self.execute(context)
        return {"RUNNING_MODAL"}

    def outline(self):
        """Points (x, y) of the outline, in pixels."""
        x, y = self._now
        if self._start is None:  # lines across the region
            width, height = self._region.width, self._region.height
            return [(0, y), (width, y), (x, y), (x, 0), (x, height)]
        a, b = self._start
        return [(a, b), (x, b), (x, y), (a, y), (a, b)]

    def execute(self, context):
        low, high = (self.xmin, self.ymin), (self.xmax, self.ymax)

        def is_inside(pixels):
            return np.all((pixels >= low) & (pixels <= high), axis=1)

        def blender():
            area = dict(xmin=self.xmin, xmax=self.xmax, ymin=self.ymin, ymax=self.ymax)
            bpy.ops.view3d.select_box(mode=self.mode, wait_for_input=False, **area)

        hit = lamps_where(context, is_inside, (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])))
        apply(context, self.mode, hit, blender)
        return {"FINISHED"}


class SDFLIGHTS_OT_select_circle(_Gesture, bpy.types.Operator):
    """Select items using circle selection, lamps by their bodies"""

    bl_idname = "sdf_lights.select_circle"
    bl_label = "Circle Select"

    radius: bpy.props.IntProperty(name="Radius", default=_RADIUS, min=1)
    mode: bpy.props.EnumProperty(name="Mode", items=_MODES[:3], default="ADD", options={"SKIP_SAVE"})
    wait_for_input: bpy.props.BoolProperty(name="Wait for Input", default=True, options={"SKIP_SAVE"})
    x: bpy.props.IntProperty(name="X", options={"HIDDEN", "SKIP_SAVE"})
    y: bpy.props.IntProperty(name="Y", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        if self.is_not_ours(context, event, "view3d.select_circle"):
            return {"PASS_THROUGH"}
        self._button, self._brush = "", self.mode
        self._now = event.mouse_region_x, event.mouse_region_y
        if not self.wait_for_input:
            self._button = "LEFTMOUSE"
            if self.mode == "SET":
                self._brush = _mode_of_tool(context, "view3d.select_circle")
            self._paint(context)
        self.begin(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        self._now = event.mouse_region_x, event.mouse_region_y
        self._region.tag_redraw()
        if event.type in {"ESC", "RIGHTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            self.end(context)
            return {"FINISHED"}
        if event.value == "PRESS" and event.type in {"WHEELUPMOUSE", "NUMPAD_MINUS"}:
            self.radius = max(self.radius - math.ceil(0.05 * self.radius), 1)
        elif event.value == "PRESS" and event.type in {"WHEELDOWNMOUSE", "NUMPAD_PLUS"}:
            self.radius += math.ceil(0.05 * self.radius)
        elif event.type in {"LEFTMOUSE", "MIDDLEMOUSE"} and event.value == "PRESS":
            self._button = event.type
            self._brush = "SUB" if event.shift or event.type == "MIDDLEMOUSE" else "ADD"
            self._paint(context)
        elif event.type == self._button and event.value == "RELEASE":
            self._button = ""
            if not self.wait_for_input:
                self.end(context)
                return {"FINISHED"}
        elif event.type == "MOUSEMOVE" and self._button:
            self._paint(context)
        return {"RUNNING_MODAL"}

    def outline(self):
        """Points (x, y) of the outline, in pixels."""
        turns = np.linspace(0.0, 2.0 * math.pi, 49)
        return [
            (self._now[0] + self.radius * math.cos(turn), self._now[1] + self.radius * math.sin(turn)) for turn in turns
        ]

    def _paint(self, context):
        (self.x, self.y), self.mode = self._now, self._brush
        self.execute(context)
        if self._brush == "SET":  # the rest of the stroke extends the selection
            self._brush = "ADD"

    def execute(self, context):
        middle = self.x, self.y

        def is_inside(pixels):
            return np.linalg.norm(pixels - middle, axis=1) <= self.radius

        def blender():
            bpy.ops.view3d.select_circle(x=self.x, y=self.y, radius=self.radius, mode=self.mode, wait_for_input=False)

        apply(context, self.mode, lamps_where(context, is_inside, middle), blender)
        return {"FINISHED"}


def _mode_of_tool(context, operator: str) -> str:
    """The selection mode of the active tool."""
    tool = context.workspace.tools.from_space_view3d_mode(context.mode)
    try:
        return tool.operator_properties(operator).mode
    except (AttributeError, TypeError):  # another tool that selects by dragging
        return "SET"


CLASSES = (SDFLIGHTS_OT_select_box, SDFLIGHTS_OT_select_circle)


def register():
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="Object Mode")
    for operator, key in ((SDFLIGHTS_OT_select_box, "B"), (SDFLIGHTS_OT_select_circle, "C")):
        _keymaps.append((keymap, keymap.keymap_items.new(operator.bl_idname, key, "PRESS")))
    for tool, operator, value in (
        ("Select Box", SDFLIGHTS_OT_select_box, "CLICK_DRAG"),
        ("Select Circle", SDFLIGHTS_OT_select_circle, "PRESS"),
    ):
        for suffix in ("", " (fallback)"):
            keymap = configuration.keymaps.new(
                name=f"3D View Tool: {tool}{suffix}", space_type="VIEW_3D", region_type="WINDOW", tool=True
            )
            for modifiers, mode in _DIRECT if value == "CLICK_DRAG" else _DIRECT[:3]:
                held = dict.fromkeys(modifiers.split(), True)
                item = keymap.keymap_items.new(operator.bl_idname, "LEFTMOUSE", value, **held)
                item.properties.wait_for_input, item.properties.mode = False, mode
                _keymaps.append((keymap, item))


def unregister():
    for keymap, item in _keymaps:
        keymap.keymap_items.remove(item)
    _keymaps.clear()
