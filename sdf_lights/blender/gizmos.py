# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrows in the 3D view for the sizes of a primitive lamp."""

from __future__ import annotations

import math
from typing import NamedTuple

import blf
import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Matrix, Vector

from .properties import PRIMITIVES, values_of

_MOST = 6
_HALVINGS = 24
_SETS_UNDO = "use_undo" in bpy.types.Gizmo.bl_rna.properties  # since Blender 5.2
_COLORS = ((0.93, 0.21, 0.31), (0.55, 0.86, 0.0), (0.17, 0.56, 1.0))  # of the axes, as in Blender
_TURN = (Matrix.Rotation(math.radians(90.0), 4, "Y"), Matrix.Rotation(math.radians(-90.0), 4, "X"), Matrix())


class Handle(NamedTuple):
    """An arrow. The parameter, or its ``component`` if that is not −1, is ``factor`` times the distance of the tip
    along ``axis``."""

    name: str
    component: int
    axis: int
    factor: float


def handles(shape: str) -> list[Handle]:
    """Arrows for the sizes of a primitive. Heights lie along z and begin in the middle. Others alternate along x and
    y."""
    found, aside = [], 0
    for about in PRIMITIVES[shape].fields():
        if about.unit != "LENGTH":
            continue
        if about.size == 3:
            found += [Handle(about.name, axis, axis, 1.0) for axis in range(3)]
        elif about.name in ("height", "length", "leg"):
            found.append(Handle(about.name, -1, 2, 2.0))
        else:
            # Sizes from one side to the other also begin in the middle.
            factor = 2.0 if about.name in ("width", "thickness") else 1.0
            found.append(Handle(about.name, -1, aside % 2, factor))
            aside += 1
    return found[:_MOST]


def _with(values: dict, handle: Handle, value: float) -> dict:
    if handle.component < 0:
        return values | {handle.name: value}
    changed = list(values[handle.name])
    changed[handle.component] = value
    return values | {handle.name: tuple(changed)}


def held(shape: str, values: dict, handle: Handle, wanted: float) -> float:
    """``wanted``, or the nearest value that still gives a shape with these ``values``, if there is one."""
    kind = PRIMITIVES[shape]
    about = next(about for about in kind.fields() if about.name == handle.name)
    wanted = min(max(wanted, about.minimum), about.maximum)
    now = values[handle.name] if handle.component < 0 else values[handle.name][handle.component]

    def is_good(value: float) -> bool:
        return not kind(**_with(values, handle, value)).validate()

    if is_good(wanted) or not is_good(now):
        return wanted
    for _ in range(_HALVINGS):
        middle = 0.5 * (now + wanted)
        if is_good(middle):
            now = middle
        else:
            wanted = middle
    return now


def _lamp(context):
    obj = context.object
    if obj is None or obj.type != "LIGHT" or not obj.data.sdf_lamp.use or not obj.data.is_editable:
        return None
    return obj.data.sdf_lamp if obj.data.sdf_lamp.source == "PRIMITIVE" else None


class _Shown(NamedTuple):
    """The label beside the arrow under the mouse, at a world position."""

    text: str
    place: Vector


_shown: dict[int, _Shown] = {}  # by region
_begun: dict[int, float] = {}  # the value before a drag, by the number of its arrow; empty without a drag


def _push_undo() -> None:
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.ed.undo_push(message=SDFLIGHTS_GGT_primitive.bl_label)


def _draw_label() -> None:
    context = bpy.context
    shown = _shown.get(context.region.as_pointer())
    if shown is None or not SDFLIGHTS_GGT_primitive.poll(context):
        return
    at = location_3d_to_region_2d(context.region, context.region_data, shown.place)
    if at is not None:
        scale = context.preferences.system.ui_scale
        blf.enable(0, blf.SHADOW)
        blf.shadow(0, 5, 0.0, 0.0, 0.0, 0.8)
        blf.size(0, 12.0 * scale)
        blf.color(0, 1.0, 1.0, 1.0, 1.0)
        blf.position(0, at.x + 14.0 * scale, at.y + 14.0 * scale, 0.0)
        blf.draw(0, shown.text)
        blf.disable(0, blf.SHADOW)


def _label(context, name: str, value: float) -> str:
    unit = context.scene.unit_settings
    if unit.system == "NONE":
        return f"{name}: {value:.4g}"
    return f"{name}: {bpy.utils.units.to_string(unit.system, 'LENGTH', value * unit.scale_length, precision=4)}"


class SDFLIGHTS_GGT_primitive(bpy.types.GizmoGroup):
    """Arrows that set the sizes of a primitive."""

    bl_idname = "SDFLIGHTS_GGT_primitive"
    bl_label = "SDF Lamp Size"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and _lamp(context) is not None and context.object.select_get()

    def setup(self, context):
        self.made = []
        for index in range(_MOST):
            arrow = self.gizmos.new("GIZMO_GT_arrow_3d")
            arrow.draw_style = "BOX" if index > 2 else "NORMAL"
            arrow.use_draw_modal = True
            arrow.alpha, arrow.alpha_highlight = 0.6, 1.0
            if _SETS_UNDO:
                arrow.use_undo = True
            arrow.target_set_handler("offset", get=self._getter(index), set=self._setter(index))
            self.made.append(arrow)
        self.refresh(context)

    def _handle(self, index: int):
        """Properties, handle, and the object's scale along its axis; None if the shape has fewer sizes."""
        lamp = _lamp(bpy.context)
        listed = handles(lamp.shape.lower()) if lamp is not None else []
        if index >= len(listed):
            return None
        scale = bpy.context.object.matrix_world.to_3x3().col[listed[index].axis].length
        return getattr(lamp, lamp.shape.lower()), listed[index], max(scale, 1e-9)

    def _getter(self, index: int):
        def get():
            found = self._handle(index)
            if found is None:
                return 0.0
            _, handle, scale = found
            return self._value(found) * scale / handle.factor

        return get

    def _setter(self, index: int):
        def set_(distance):
            found = self._handle(index)
            if found is None:
                return
            group, handle, scale = found
            if not _SETS_UNDO:
                _begun.setdefault(index, self._value(found))
            shape = _lamp(bpy.context).shape.lower()
            value = held(shape, values_of(group, shape), handle, distance * handle.factor / scale)
            if handle.component < 0:
                setattr(group, handle.name, value)
            else:
                getattr(group, handle.name)[handle.component] = value

        return set_

    def refresh(self, context):
        lamp = _lamp(context)
        listed = handles(lamp.shape.lower()) if lamp is not None else []
        place = context.object.matrix_world.normalized() if lamp is not None else Matrix()
        for arrow, handle in zip(self.made, [*listed, *[None] * _MOST]):
            arrow.hide = handle is None
            if handle is not None:
                arrow.matrix_basis = place @ _TURN[handle.axis]
                arrow.color, arrow.color_highlight = _COLORS[handle.axis], (1.0, 1.0, 1.0)

    def draw_prepare(self, context):
        self.refresh(context)
        self._show_label(context)
        self._watch_drags()

    def _show_label(self, context):
        region = context.region.as_pointer()
        _shown.pop(region, None)
        for index, arrow in enumerate(self.made):
            found = self._handle(index) if arrow.is_modal or arrow.is_highlight else None
            if found is not None:
                group, handle, scale = found
                value = self._value(found)
                name = group.bl_rna.properties[handle.name].name
                if handle.component >= 0:
                    name += " " + "XYZ"[handle.component]
                tip = arrow.matrix_basis @ Vector((0.0, 0.0, value * scale / handle.factor))
                _shown[region] = _Shown(_label(context, name, value), tip)

    @staticmethod
    def _value(found) -> float:
        group, handle, _ = found
        value = getattr(group, handle.name)
        return value if handle.component < 0 else value[handle.component]

    def _watch_drags(self):
        """Before 5.2, Blender makes no undo step for the gizmos of add-ons."""
        if _SETS_UNDO:
            return
        for index, arrow in enumerate(self.made):
            found = self._handle(index)
            if found is None:
                continue
            if arrow.is_modal:
                _begun.setdefault(index, self._value(found))
            elif index in _begun and _begun.pop(index) != self._value(found):
                bpy.app.timers.register(_push_undo, first_interval=0.0)


CLASSES = (SDFLIGHTS_GGT_primitive,)

_handlers: list = []


def register():
    if not bpy.app.background:
        _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw_label, (), "WINDOW", "POST_PIXEL"))


def unregister():
    for handler in _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
    _handlers.clear()
    _shown.clear()
    _begun.clear()
