# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes with a part outside the tree: the lamp, objects of the scene, expressions of shapes, and transforms."""

from __future__ import annotations

import bpy
import numpy as np

from ...affine import inverse
from ...sdf.emission import EmissionExpression
from ...sdf.expression import Expression
from ...sdf.syntax import ExpressionError
from ..properties import tag
from . import sockets
from .lines import EMISSION, SHAPE, Broken, held, word
from .tree import OBJECT, OUTPUT
from .value_nodes import ValueNode

_SHAPE = (("shape", "Shape", sockets.SHAPE),)


class SDFLIGHTS_Node_output(ValueNode, bpy.types.Node):
    """The shape that glows. Emission gives its color and relative brightness at each point"""

    bl_idname = OUTPUT
    bl_label = "Lamp Output"
    takes = ((SHAPE, "Shape", sockets.SHAPE), (EMISSION, "Emission", sockets.COLOR))
    gives = ()

    def written(self, writer):
        socket = self.socket(writer.makes)
        if writer.makes == SHAPE:
            return {SHAPE: writer.needed(socket)}
        value = writer.input(socket)
        return {} if value is None else {EMISSION: value}


class SDFLIGHTS_Node_object(ValueNode, bpy.types.Node):
    """The shape with the transform of an object: move, turn or scale the object to place the shape"""

    bl_idname = OBJECT
    bl_label = "Object Transform"
    takes = _SHAPE
    gives = (("result", "Shape", sockets.SHAPE), ("location", "Location", sockets.VECTOR))

    object: bpy.props.PointerProperty(
        name="Object", description="Object with the transform, for instance an empty", type=bpy.types.Object, update=tag
    )

    def draw_settings(self, layout):
        layout.prop(self, "object", text="")

    def written(self, writer):
        if self.object is None:
            raise Broken("No object is chosen: choose one, for instance an empty")
        world = np.array([tuple(row) for row in self.object.matrix_world], np.float64)
        try:
            matrix = inverse(writer.owner) @ world
        except np.linalg.LinAlgError:
            matrix = np.full((4, 4), np.nan)
        if not np.isfinite(matrix).all():
            raise Broken("The lamp or the object is scaled to zero: set its scale")
        x, y, z, location = (writer.literal(tuple(column)) for column in matrix[:3].T.tolist())
        results = {"location": location}
        shape = self.socket("shape")
        if shape.is_linked:
            results["result"] = writer.assign(
                self.label or "placed", word("transform", writer.needed(shape), x=x, y=y, z=z, offset=location)
            )
        return results


class SDFLIGHTS_Node_place(ValueNode, bpy.types.Node):
    """The shape scaled, then turned, then moved"""

    bl_idname = "SDFLIGHTS_Node_place"
    bl_label = "Transform"
    bl_width_default = 180.0
    takes = (
        *_SHAPE,
        ("translation", "Translation", sockets.VECTOR),
        ("rotation", "Rotation", sockets.VECTOR),
        ("scale", "Scale", sockets.VECTOR),
    )
    gives = (("result", "Shape", sockets.SHAPE),)

    value_translation: bpy.props.FloatVectorProperty(
        name="Translation", description="Vector by which the shape is moved", size=3, subtype="TRANSLATION", update=tag
    )
    value_rotation: bpy.props.FloatVectorProperty(
        name="Rotation", description="Angles about x, then y, then z", size=3, subtype="EULER", update=tag
    )
    value_scale: bpy.props.FloatVectorProperty(
        name="Scale",
        description="Factor along x, y and z; a negative one mirrors",
        size=3,
        subtype="XYZ",
        default=(1.0, 1.0, 1.0),
        update=tag,
    )

    def written(self, writer):
        result = writer.needed(self.socket("shape"))
        for name, call, left_out in (
            ("scale", "scale", (1.0,) * 3),
            ("rotation", "rotate", (0.0,) * 3),
            ("translation", "translate", (0.0,) * 3),
        ):
            socket = self.socket(name)
            if not socket.is_linked and tuple(held(socket)) == left_out:
                continue
            value = writer.input(socket)
            result = writer.assign(
                self.label or call, word(call, result, writer.degrees(value) if name == "rotation" else value)
            )
        return {"result": result}


_OF_KIND = {
    "slider": "NodeSocketFloat",
    "integer": "NodeSocketInt",
    "angle": "NodeSocketFloatAngle",
    "toggle": "NodeSocketBool",
    "vector": "NodeSocketVector",
}


class ExpressionNode(ValueNode):
    """A node with a text of the expression language, of which it makes what ``makes`` says.

    Parameters that the text declares are inputs.
    """

    makes = SHAPE

    def source(self) -> str:
        """Text of the expression."""
        raise NotImplementedError

    def parsed(self) -> Expression | EmissionExpression:
        """Raises ``ExpressionError``."""
        return (Expression if self.makes == SHAPE else EmissionExpression)(self.source())

    def names(self):
        try:
            return self.parsed().data
        except ExpressionError:
            return frozenset()

    def match_interface(self):
        """Inputs are what the text declares, for as long as it can be read."""
        super().match_interface()
        try:
            expression = self.parsed()
        except ExpressionError:
            return
        wanted = {declaration.name: declaration for declaration in expression.parameters}
        for socket in list(self.inputs):
            declaration = wanted.get(socket.identifier)
            if declaration is None or socket.bl_idname != _OF_KIND[declaration.kind]:
                self.inputs.remove(socket)
        known = {socket.identifier for socket in self.inputs}
        for name, declaration in wanted.items():
            if name not in known:
                label = name.replace("_", " ").title()
                socket = self.inputs.new(_OF_KIND[declaration.kind], label, identifier=name)
                socket.default_value = stored(declaration, declaration.default)

    def written(self, writer):
        try:
            expression = self.parsed()
        except ExpressionError as error:
            raise Broken(str(error).rstrip(".")) from None
        there = {socket.identifier: socket for socket in self.inputs}
        given = {}
        for declaration in expression.parameters:
            socket = there.get(declaration.name)
            if socket is None:  # the text has changed since
                value = writer.literal(
                    declaration.default > 0.5 if declaration.kind == "toggle" else declaration.default
                )
            else:
                value = writer.needed(socket)
                value = writer.degrees(value) if declaration.kind == "angle" else value
            given[declaration] = value
        return {"result": writer.include(self.label or self.bl_label, self.source(), given, self.makes)}


def text_property(makes: str):
    """The property of a text block with a shape or an emission."""
    return bpy.props.PointerProperty(
        name="Text",
        description=f"Text block with the {makes}, if it has several lines",
        type=bpy.types.Text,
        update=text_changed,
    )


def text_changed(self, context):
    """Callback of the text: the inputs of the node follow what it declares."""
    self.match_interface()


def draw_text(layout, node) -> None:
    """The node's text block, or its line."""
    layout.prop_search(node, "text", bpy.data, "texts", text="", icon="TEXT")
    if node.text is None:
        layout.prop(node, "expression", text="")


class SDFLIGHTS_Node_expression(ExpressionNode, bpy.types.Node):
    """A shape in the expression language. Parameters that it declares are inputs"""

    bl_idname = "SDFLIGHTS_Node_expression"
    bl_label = "Expression"
    bl_width_default = 220.0
    gives = (("result", "Shape", sockets.SHAPE),)

    expression: bpy.props.StringProperty(
        name="Expression",
        description="A shape, such as union(torus(1, 0.3), sphere(0.5))",
        default="union(torus(0.5, 0.1), sphere(0.2))",
        update=text_changed,
    )
    text: text_property("expression")

    def draw_settings(self, layout):
        draw_text(layout, self)

    def source(self) -> str:
        """Text of the expression."""
        return self.text.as_string() if self.text is not None else self.expression


def stored(declaration, value):
    """A value of a parameter as a socket or property holds it: angles in radians."""
    if declaration.kind == "angle":
        return float(np.radians(value))
    return {"integer": int, "toggle": bool, "vector": tuple}.get(declaration.kind, float)(value)


CLASSES = (SDFLIGHTS_Node_output, SDFLIGHTS_Node_object, SDFLIGHTS_Node_place, SDFLIGHTS_Node_expression)
