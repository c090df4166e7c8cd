# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of the emission: where a point is in the lamp, colours, colour ramps, and patterns in text."""

from __future__ import annotations

import ast

import bpy

from ...sdf.builtin_colors import MOST_STOPS
from ...sdf.emission import INPUTS
from ...sdf.emission_presets import presets
from ...sdf.resolver import COLOURS
from ..emission import EXPRESSION
from ..emission_properties import source_items
from ..properties import tag
from . import sockets
from .lines import EMISSION, Broken, held, word
from .scene import ExpressionNode, draw_text, text_changed, text_property
from .value_nodes import ValueNode

_COLOR = (("result", "Color", sockets.COLOR),)


class SDFLIGHTS_Node_interior(ValueNode, bpy.types.Node):
    """Place of a point in the lamp. Depth is below the surface, in metres. Height, U and V (across the lamp's box along
    x and y) and the place along the lamp's curve are from 0 to 1"""

    bl_idname = "SDFLIGHTS_Node_interior"
    bl_label = "Interior"
    gives = tuple((name, name.title(), sockets.NUMBER) for name in INPUTS)

    def written(self, writer):
        if writer.makes != EMISSION:
            raise Broken("A shape has no inside before it is made: use them for the Emission of the output")
        return {name: ast.Name(name, ast.Load()) for name in INPUTS}


class SDFLIGHTS_Node_color(ValueNode, bpy.types.Node):
    """A color for several inputs"""

    bl_idname = "SDFLIGHTS_Node_color"
    bl_label = "Color"
    gives = _COLOR

    value: bpy.props.FloatVectorProperty(
        name="Color",
        description="The color",
        size=3,
        subtype="COLOR",
        default=(1.0, 1.0, 1.0),
        min=0.0,
        soft_max=1.0,
        update=tag,
    )

    def draw_settings(self, layout):
        layout.prop(self, "value", text="")

    def written(self, writer):
        return {"result": writer.assign(self.label or "color", writer.literal(tuple(self.value)))}


# -- colour ramp -------------------------------------------------------------------------------------------------------

RAMPS = {"LINEAR": "ramp", "EASE": "ramp_ease", "CONSTANT": "ramp_constant"}
"""The word of the expression language for each interpolation of the node."""


def _ramp_inputs(stops: int) -> tuple[tuple[str, str, str], ...]:
    pairs = ((("position", "Position", sockets.NUMBER), ("color", "Color", sockets.COLOR)) for _ in range(stops))
    return (
        ("value", "Value", sockets.NUMBER),
        *((f"{name}_{i}", label, kind) for i, pair in enumerate(pairs, 1) for name, label, kind in pair),
    )


def _stops_changed(self, context):
    self.match_interface()


class SDFLIGHTS_Node_ramp(ValueNode, bpy.types.Node):
    """Look up a color by a value. Colors between two stops are interpolated. Stops are sorted by position"""

    bl_idname = "SDFLIGHTS_Node_ramp"
    bl_label = "Color Ramp"
    bl_width_default = 180.0
    takes = _ramp_inputs(2)
    gives = _COLOR

    __annotations__ = (
        {
            "value_value": bpy.props.FloatProperty(
                name="Value",
                description="Value that is looked up if nothing is connected",
                default=0.5,
                precision=3,
                update=tag,
            ),
            "interpolation": bpy.props.EnumProperty(
                name="Interpolation",
                description="Interpolation between two stops",
                update=tag,
                items=[
                    ("LINEAR", "Linear", "Straight from each color to the next", 0),
                    ("EASE", "Ease", "Smooth at the stops", 1),
                    ("CONSTANT", "Constant", "The color of each stop up to the next", 2),
                ],
            ),
            "stops": bpy.props.IntProperty(
                name="Stops", description="Number of colors", default=2, min=1, max=MOST_STOPS, update=_stops_changed
            ),
        }
        | {
            f"value_position_{i}": bpy.props.FloatProperty(
                name="Position",
                description="Value that has the color below",
                default=float(i > 1),
                soft_min=0.0,
                soft_max=1.0,
                precision=3,
                update=tag,
            )
            for i in range(1, MOST_STOPS + 1)
        }
        | {
            f"value_color_{i}": bpy.props.FloatVectorProperty(
                name="Color",
                description="Color at the position above",
                size=3,
                subtype="COLOR",
                default=(float(i > 1),) * 3,
                min=0.0,
                soft_max=1.0,
                update=tag,
            )
            for i in range(1, MOST_STOPS + 1)
        }
    )

    def wanted_inputs(self):
        return _ramp_inputs(self.stops)

    def match_interface(self):
        super().match_interface()
        wanted = {identifier for identifier, _, _ in self.wanted_inputs()}
        for socket in list(self.inputs):
            if socket.identifier not in wanted:
                self.inputs.remove(socket)

    def draw_settings(self, layout):
        layout.prop(self, "interpolation", text="")
        layout.prop(self, "stops")

    def written(self, writer):
        value = writer.input(self.socket("value"))
        stops = [(self.socket(f"position_{i}"), self.socket(f"color_{i}")) for i in range(1, self.stops + 1)]
        if not any(position.is_linked for position, _ in stops):
            stops.sort(key=lambda stop: held(stop[0]))
        parts = [writer.needed(socket) for stop in stops for socket in stop]
        return {"result": writer.assign(self.label or "ramp", word(RAMPS[self.interpolation], value, *parts))}


class SDFLIGHTS_Node_image_color(ValueNode, bpy.types.Node):
    """Color of a picture. Without links, the picture covers the lamp's box along x and y"""

    bl_idname = "SDFLIGHTS_Node_image_color"
    bl_label = "Image Color"
    bl_width_default = 180.0
    takes = (("u", "U", sockets.NUMBER), ("v", "V", sockets.NUMBER))
    gives = _COLOR

    image: bpy.props.PointerProperty(name="Image", description="The picture", type=bpy.types.Image, update=tag)

    def draw_settings(self, layout):
        layout.template_ID(self, "image", open="image.open")

    def things(self):
        return [self.image] if self.image is not None else []

    def written(self, writer):
        if self.image is None:
            raise Broken("No image is chosen: choose one")
        if writer.makes != EMISSION and not all(socket.is_linked for socket in self.inputs):
            raise Broken(
                "A shape has no box before it is made: connect U and V, or use it for the Emission of the output"
            )
        places = [
            writer.needed(socket) if socket.is_linked else ast.Name(socket.identifier, ast.Load())
            for socket in self.inputs
        ]
        name = ast.Constant(writer.thing("image", self.image))
        return {"result": writer.assign(self.label or "image_color", word(COLOURS, name, *places))}


# -- patterns ----------------------------------------------------------------------------------------------------------


class SDFLIGHTS_Node_pattern(ExpressionNode, bpy.types.Node):
    """An emission to start from, or one in the expression language. Parameters that it declares are inputs"""

    bl_idname = "SDFLIGHTS_Node_pattern"
    bl_label = "Emission Pattern"
    bl_width_default = 220.0
    gives = (("result", "Emission", sockets.COLOR),)
    makes = EMISSION

    pattern: bpy.props.EnumProperty(
        name="Pattern",
        description="Emission to start from",
        default="SHELL",
        update=text_changed,
        items=[item for item in source_items() if item[0] != "UNIFORM"],
    )
    expression: bpy.props.StringProperty(
        name="Expression",
        description="A brightness or a color, such as exp(-20 * depth)",
        default="exp(-20 * depth)",
        update=text_changed,
    )
    text: text_property("emission")

    def draw_settings(self, layout):
        layout.prop(self, "pattern", text="")
        if self.pattern == EXPRESSION:
            draw_text(layout, self)

    def source(self) -> str:
        """Text of the expression."""
        if self.pattern != EXPRESSION:
            return presets()[self.pattern.lower()].text
        return self.text.as_string() if self.text is not None else self.expression


CLASSES = (
    SDFLIGHTS_Node_interior,
    SDFLIGHTS_Node_color,
    SDFLIGHTS_Node_ramp,
    SDFLIGHTS_Node_image_color,
    SDFLIGHTS_Node_pattern,
)
