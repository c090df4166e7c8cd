# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add > Light > SDF Lamp."""

import math

import bpy
from bpy_extras.object_utils import AddObjectHelper, object_data_add

from .lamp import shape_of
from .properties import PRIMITIVES, shape_items


class SDFLIGHTS_OT_lamp_add(bpy.types.Operator, AddObjectHelper):
    """Add a lamp whose inside glows"""

    bl_idname = "sdf_lights.lamp_add"
    bl_label = "Add SDF Lamp"
    bl_options = {"REGISTER", "UNDO"}

    source: bpy.props.EnumProperty(
        name="Source", description="What says the shape of the lamp",
        items=[("PRIMITIVE", "Primitive", "One shape with its parameters", 0),
               ("EXPRESSION", "Expression", "Shapes put together by a few lines of text", 1)])
    shape: bpy.props.EnumProperty(name="Shape", description="Shape that glows", items=shape_items(), default="SPHERE")
    power: bpy.props.FloatProperty(
        name="Power", description="Power of the whole lamp", default=100.0, min=0.0, soft_max=1000.0, unit="POWER")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        primitive = self.source == "PRIMITIVE"
        name = f"{PRIMITIVES[self.shape.lower()].label()} Lamp" if primitive else "SDF Lamp"
        light = bpy.data.lights.new(name, "POINT")
        light.energy = self.power
        light.sdf_lamp.use = True
        light.sdf_lamp.source = self.source
        light.sdf_lamp.shape = self.shape
        # Other engines see a point light: as large as a ball of the same volume.
        volume = shape_of(light.sdf_lamp).volume()
        if volume:
            light.shadow_soft_size = (0.75 * volume / math.pi) ** (1.0 / 3.0)
        object_data_add(context, light, operator=self, name=name)
        return {"FINISHED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "source")
        if self.source == "PRIMITIVE":
            layout.prop(self, "shape")
        layout.prop(self, "power")
        layout.prop(self, "align")
        layout.prop(self, "location")
        layout.prop(self, "rotation")


class SDFLIGHTS_MT_lamp_add(bpy.types.Menu):
    bl_label = "SDF Lamp"
    bl_idname = "SDFLIGHTS_MT_lamp_add"

    def draw(self, context):
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        for name, shape in PRIMITIVES.items():
            operator = layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=shape.label())
            operator.source, operator.shape = "PRIMITIVE", name.upper()
        layout.separator()
        layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text="Expression").source = "EXPRESSION"


def draw_menu(self, context):
    """Entry in Add > Light."""
    self.layout.menu(SDFLIGHTS_MT_lamp_add.bl_idname, icon="LIGHT_POINT")


CLASSES = (SDFLIGHTS_OT_lamp_add, SDFLIGHTS_MT_lamp_add)


def register():
    bpy.types.VIEW3D_MT_light_add.append(draw_menu)


def unregister():
    bpy.types.VIEW3D_MT_light_add.remove(draw_menu)
