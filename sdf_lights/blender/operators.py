# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add > Light > SDF Lamp, and what the panels of a lamp do at a click."""

import math

import bpy
from bpy_extras.object_utils import AddObjectHelper, object_data_add

from ..sdf.catalogue import grouped
from ..sdf.examples import examples
from . import parameters
from .context import light_of
from .lamp import shape_of
from .properties import PRIMITIVES, shape_items


def example_items() -> list[tuple]:
    """Items of an EnumProperty with every example."""
    return [(name.upper(), example.title, "") for name, example in examples().items()]


def load_example(light: bpy.types.Light, name: str) -> None:
    """Make the light a lamp whose expression is an example, in a text block of its own."""
    example = examples()[name.lower()]
    text = bpy.data.texts.new(example.title)
    text.write(example.text)
    lamp = light.sdf_lamp
    lamp.use, lamp.source, lamp.text = True, "EXPRESSION", text


class SDFLIGHTS_OT_lamp_add(bpy.types.Operator, AddObjectHelper):
    """Add a lamp whose inside glows"""

    bl_idname = "sdf_lights.lamp_add"
    bl_label = "Add SDF Lamp"
    bl_options = {"REGISTER", "UNDO"}

    source: bpy.props.EnumProperty(
        name="Source", description="What says the shape of the lamp",
        items=[("PRIMITIVE", "Primitive", "One shape with its parameters", 0),
               ("EXPRESSION", "Expression", "Shapes put together by a few lines of text", 1),
               ("EXAMPLE", "Example", "An expression to start from", 2)])
    shape: bpy.props.EnumProperty(name="Shape", description="Shape that glows", items=shape_items(), default="SPHERE")
    example: bpy.props.EnumProperty(name="Example", description="Expression to start from", items=example_items())
    power: bpy.props.FloatProperty(
        name="Power", description="Power of the whole lamp", default=100.0, min=0.0, soft_max=1000.0, unit="POWER")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        name = {"PRIMITIVE": f"{PRIMITIVES[self.shape.lower()].label()} Lamp", "EXPRESSION": "SDF Lamp",
                "EXAMPLE": examples()[self.example.lower()].title}[self.source]
        light = bpy.data.lights.new(name, "POINT")
        light.energy = self.power
        if self.source == "EXAMPLE":
            load_example(light, self.example)
        else:
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
        if self.source == "EXAMPLE":
            layout.prop(self, "example")
        layout.prop(self, "power")
        layout.prop(self, "align")
        layout.prop(self, "location")
        layout.prop(self, "rotation")


class _LampOperator:
    """An operator on the light that the panel is about."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        light = light_of(context)
        return light is not None and light.is_editable


class SDFLIGHTS_OT_example_load(_LampOperator, bpy.types.Operator):
    """Load a worked example into a new text block, as the lamp's expression"""

    bl_idname = "sdf_lights.example_load"
    bl_label = "Load Example"

    example: bpy.props.EnumProperty(name="Example", description="Expression to start from", items=example_items())

    def execute(self, context):
        load_example(light_of(context), self.example)
        return {"FINISHED"}


class SDFLIGHTS_OT_expression_to_text(_LampOperator, bpy.types.Operator):
    """Put the lamp's expression into a new text block, where it can have several lines"""

    bl_idname = "sdf_lights.expression_to_text"
    bl_label = "Edit as Text"

    def execute(self, context):
        light = light_of(context)
        text = bpy.data.texts.new(light.name)
        text.write(parameters.text_of(light.sdf_lamp))
        light.sdf_lamp.text = text
        return {"FINISHED"}


class SDFLIGHTS_OT_parameters_remove(_LampOperator, bpy.types.Operator):
    """Remove parameters of expressions that the lamp had before"""

    bl_idname = "sdf_lights.parameters_remove"
    bl_label = "Remove Unused Parameters"

    def execute(self, context):
        parameters.remove_unused(light_of(context))
        return {"FINISHED"}


class SDFLIGHTS_MT_examples(bpy.types.Menu):
    bl_label = "Load Example"
    bl_idname = "SDFLIGHTS_MT_examples"

    def draw(self, context):
        for name, title, _ in example_items():
            self.layout.operator(SDFLIGHTS_OT_example_load.bl_idname, text=title).example = name


class SDFLIGHTS_MT_examples_add(bpy.types.Menu):
    bl_label = "Examples"
    bl_idname = "SDFLIGHTS_MT_examples_add"

    def draw(self, context):
        for name, title, _ in example_items():
            operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=title)
            operator.source, operator.example = "EXAMPLE", name


def _shapes_menu(index: int, title: str, shapes: list) -> type:
    """The menu of one group of shapes."""

    def draw(self, context):
        for shape in shapes:
            operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=shape.label())
            operator.source, operator.shape = "PRIMITIVE", shape.name().upper()

    name = f"SDFLIGHTS_MT_lamp_add_{index}"
    return type(name, (bpy.types.Menu,), {"bl_label": title, "bl_idname": name, "draw": draw})


_SHAPES_MENUS = [
    _shapes_menu(index, title, shapes) for index, (title, shapes) in enumerate(grouped(PRIMITIVES.values()).items())]


class SDFLIGHTS_MT_lamp_add(bpy.types.Menu):
    bl_label = "SDF Lamp"
    bl_idname = "SDFLIGHTS_MT_lamp_add"

    def draw(self, context):
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        for menu in _SHAPES_MENUS:
            layout.menu(menu.bl_idname)
        layout.separator()
        layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text="Expression").source = "EXPRESSION"
        layout.menu(SDFLIGHTS_MT_examples_add.bl_idname)


def draw_menu(self, context):
    """Entry in Add > Light."""
    self.layout.menu(SDFLIGHTS_MT_lamp_add.bl_idname, icon="LIGHT_POINT")


CLASSES = (
    SDFLIGHTS_OT_lamp_add, SDFLIGHTS_OT_example_load, SDFLIGHTS_OT_expression_to_text, SDFLIGHTS_OT_parameters_remove,
    SDFLIGHTS_MT_examples, SDFLIGHTS_MT_examples_add, *_SHAPES_MENUS, SDFLIGHTS_MT_lamp_add)


def register():
    bpy.types.VIEW3D_MT_light_add.append(draw_menu)


def unregister():
    bpy.types.VIEW3D_MT_light_add.remove(draw_menu)
