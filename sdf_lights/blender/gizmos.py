# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrows in the 3D view for the lengths of a primitive lamp."""

from __future__ import annotations

import math
from typing import NamedTuple

import bpy
from mathutils import Matrix

from .properties import PRIMITIVES

_MOST = 6
_COLORS = ((0.93, 0.21, 0.31), (0.55, 0.86, 0.0), (0.17, 0.56, 1.0))  # of the axes, as Blender has them
_TURN = (Matrix.Rotation(math.radians(90.0), 4, "Y"), Matrix.Rotation(math.radians(-90.0), 4, "X"), Matrix())


class Handle(NamedTuple):
    """An arrow: ``component`` (or −1) of a parameter is ``factor`` times the distance of its tip along ``axis``."""

    name: str
    component: int
    axis: int
    factor: float


def handles(shape: str) -> list[Handle]:
    """Arrows for the lengths of a primitive: heights along z and from the middle, others in turn along x and y."""
    found, aside = [], 0
    for about in PRIMITIVES[shape].fields():
        if about.unit != "LENGTH":
            continue
        if about.size == 3:
            found += [Handle(about.name, axis, axis, 1.0) for axis in range(3)]
        elif about.name in ("height", "length", "leg"):
            found.append(Handle(about.name, -1, 2, 2.0))
        else:
            # Sizes from one side to the other begin in the middle too.
            factor = 2.0 if about.name in ("width", "thickness") else 1.0
            found.append(Handle(about.name, -1, aside % 2, factor))
            aside += 1
    return found[:_MOST]


def _lamp(context):
    obj = context.object
    if obj is None or obj.type != "LIGHT" or not obj.data.sdf_lamp.use or not obj.data.is_editable:
        return None
    return obj.data.sdf_lamp if obj.data.sdf_lamp.source == "PRIMITIVE" else None


class SDFLIGHTS_GGT_primitive(bpy.types.GizmoGroup):
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
            arrow.target_set_handler("offset", get=self._getter(index), set=self._setter(index))
            self.made.append(arrow)
        self.refresh(context)

    def _handle(self, index: int):
        """Properties, handle, and the object's scale along its axis; None where the shape has fewer lengths."""
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
            group, handle, scale = found
            value = getattr(group, handle.name)
            return (value if handle.component < 0 else value[handle.component]) * scale / handle.factor

        return get

    def _setter(self, index: int):
        def set_(distance):
            found = self._handle(index)
            if found is None:
                return
            group, handle, scale = found
            value = distance * handle.factor / scale  # the property holds it to its limits
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

    draw_prepare = refresh


CLASSES = (SDFLIGHTS_GGT_primitive,)
