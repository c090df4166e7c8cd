# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of values: the point, numbers, parameters of the lamp, arithmetic and conditions."""

from __future__ import annotations

import ast
import math

import bpy

from ...sdf import declarations
from ...sdf.expression_values import Condition, Misuse
from ...sdf.functions import FUNCTIONS
from ..properties import tag
from . import sockets
from .lines import RESERVED, Broken, word
from .tree import LampNode


class ValueNode(LampNode):
    """A node whose inputs and outputs are all listed."""

    gives = (("result", "Value", sockets.ANY),)

    def wanted_inputs(self) -> tuple[tuple[str, str, str], ...]:
        """``takes``, where the properties of the node do not change it."""
        return self.takes

    def match_interface(self):
        """Adds the sockets that a file of an older version lacks."""
        for found, listed in ((self.inputs, self.wanted_inputs()), (self.outputs, self.gives)):
            known = {socket.identifier for socket in found}
            for identifier, label, kind in listed:
                if identifier not in known:
                    found.new(kind, label, identifier=identifier)

    def socket(self, identifier: str) -> bpy.types.NodeSocket:
        """The input with this identifier."""
        return next(socket for socket in self.inputs if socket.identifier == identifier)


def _value(label: str, **options):
    """Property for an input of one number."""
    return bpy.props.FloatProperty(
        name=label, description=f"{label} if nothing is connected", precision=3, update=tag, **options
    )


class SDFLIGHTS_Node_position(ValueNode, bpy.types.Node):
    """The point at which the shape is evaluated. Numbers that depend on it are fields"""

    bl_idname = "SDFLIGHTS_Node_position"
    bl_label = "Position"
    gives = (("result", "Position", sockets.VECTOR),)

    def written(self, writer):
        return {"result": ast.Name("p", ast.Load())}


class SDFLIGHTS_Node_number(ValueNode, bpy.types.Node):
    """A number for several inputs"""

    bl_idname = "SDFLIGHTS_Node_number"
    bl_label = "Value"
    gives = (("result", "Value", sockets.NUMBER),)

    value: bpy.props.FloatProperty(name="Value", description="The number", precision=3, update=tag)

    def draw_settings(self, layout):
        layout.prop(self, "value", text="")

    def written(self, writer):
        return {"result": writer.assign(self.label or "value", writer.literal(self.value))}


class SDFLIGHTS_Node_vector(ValueNode, bpy.types.Node):
    """Three numbers for several inputs"""

    bl_idname = "SDFLIGHTS_Node_vector"
    bl_label = "Vector"
    gives = (("result", "Vector", sockets.VECTOR),)

    value: bpy.props.FloatVectorProperty(
        name="Vector", description="The numbers", size=3, subtype="XYZ", precision=3, update=tag
    )

    def draw_settings(self, layout):
        layout.column(align=True).prop(self, "value", text="")

    def written(self, writer):
        return {"result": writer.assign(self.label or "vector", writer.literal(tuple(self.value)))}


# -- parameters of the lamp --------------------------------------------------------------------------------------------

_KIND_ITEMS = [
    ("slider", "Float", "A number", 0),
    ("integer", "Integer", "A whole number", 1),
    ("angle", "Angle", "An angle", 2),
    ("toggle", "Boolean", "A switch", 3),
    ("vector", "Vector", "Three numbers", 4),
]


def _kind_changed(self, context):
    kind = {"toggle": sockets.CONDITION, "vector": sockets.VECTOR}.get(self.kind, sockets.NUMBER)
    output = self.outputs[0]
    if output.bl_idname != kind:
        there = [link.to_socket for link in output.links]
        self.outputs.clear()
        output = self.outputs.new(kind, "Value", identifier="result")
        for socket in there:
            self.id_data.links.new(output, socket)


class SDFLIGHTS_Node_parameter(ValueNode, bpy.types.Node):
    """A property of the lamp. Each lamp that uses the tree has its own value"""

    bl_idname = "SDFLIGHTS_Node_parameter"
    bl_label = "Parameter"
    gives = (("result", "Value", sockets.NUMBER),)

    parameter: bpy.props.StringProperty(
        name="Name", description="Name of the property of the lamp: letters, digits and _", default="size", update=tag
    )
    kind: bpy.props.EnumProperty(
        name="Type", description="Type of the property", items=_KIND_ITEMS, update=_kind_changed
    )
    default: bpy.props.FloatProperty(
        name="Default", description="Value in lamps that do not set the parameter", default=1.0, precision=3, update=tag
    )
    default_angle: bpy.props.FloatProperty(
        name="Default", description="Value in lamps that do not set the parameter", subtype="ANGLE", update=tag
    )
    default_vector: bpy.props.FloatVectorProperty(
        name="Default",
        description="Value in lamps that do not set the parameter",
        size=3,
        subtype="XYZ",
        precision=3,
        update=tag,
    )
    default_toggle: bpy.props.BoolProperty(
        name="Default", description="Value in lamps that do not set the parameter", update=tag
    )
    minimum: bpy.props.FloatProperty(name="Minimum", description="Least value", default=0.0, precision=3, update=tag)
    maximum: bpy.props.FloatProperty(
        name="Maximum", description="Greatest value", default=10.0, precision=3, update=tag
    )
    minimum_angle: bpy.props.FloatProperty(
        name="Minimum", description="Least value", default=-2.0 * math.pi, subtype="ANGLE", update=tag
    )
    maximum_angle: bpy.props.FloatProperty(
        name="Maximum", description="Greatest value", default=2.0 * math.pi, subtype="ANGLE", update=tag
    )
    tooltip: bpy.props.StringProperty(name="Tooltip", description="Tooltip of the property", update=tag)

    def draw_settings(self, layout):
        column = layout.column()
        column.prop(self, "parameter", text="")
        column.prop(self, "kind", text="")
        suffix = {"angle": "_angle", "vector": "_vector", "toggle": "_toggle"}.get(self.kind, "")
        column.column(align=True).prop(self, f"default{suffix}")
        if self.kind != "toggle":
            limits = column.column(align=True)
            for limit in ("minimum", "maximum"):
                limits.prop(self, limit + ("_angle" if self.kind == "angle" else ""))
        column.prop(self, "tooltip", text="", icon="INFO")

    def declaration(self) -> declarations.Declaration:
        """Raises ``Broken`` where the properties do not go together."""
        name = self.parameter.strip()
        if not (name.isidentifier() and name.isascii()) or name in RESERVED or name in FUNCTIONS:
            raise Broken(
                f"'{name}' cannot be the name of a parameter: use letters, digits and _, and no word of the "
                "expression language"
            )
        if self.kind == "toggle":
            return declarations.declare(name, "toggle", [Condition(float(self.default_toggle))], self._remark())
        angle = self.kind == "angle"
        default = (
            tuple(map(_plain, self.default_vector))
            if self.kind == "vector"
            else _plain(math.degrees(self.default_angle) if angle else self.default)
        )
        limits = (
            [_plain(math.degrees(limit)) for limit in (self.minimum_angle, self.maximum_angle)]
            if angle
            else [_plain(self.minimum), _plain(self.maximum)]
        )
        if self.kind == "integer":
            default, limits = float(round(default)), [float(round(limit)) for limit in limits]
        try:
            return declarations.declare(name, self.kind, [default, *limits], self._remark())
        except Misuse as misuse:
            raise Broken(f"{str(misuse)[0].upper()}{str(misuse)[1:]}: change the default or the limits") from None

    def _remark(self) -> str:
        return " ".join(self.tooltip.split())

    def written(self, writer):
        name = writer.declare(self.declaration())
        return {"result": word("radians", name) if self.kind == "angle" else name}


def _plain(value: float) -> float:
    return float(f"{value:.7g}")


# -- arithmetic --------------------------------------------------------------------------------------------------------

OPERATORS = {
    "ADD": ast.Add,
    "SUBTRACT": ast.Sub,
    "MULTIPLY": ast.Mult,
    "DIVIDE": ast.Div,
    "MODULO": ast.Mod,
    "POWER": ast.Pow,
}
_A_AND_B = (("a", "A", sockets.ANY), ("b", "B", sockets.ANY))


class SDFLIGHTS_Node_math(ValueNode, bpy.types.Node):
    """Arithmetic of numbers, fields and vectors. A number applies to each component of a vector"""

    bl_idname = "SDFLIGHTS_Node_math"
    bl_label = "Math"
    takes = _A_AND_B

    value_a: _value("A")
    value_b: _value("B")
    operation: bpy.props.EnumProperty(
        name="Operation",
        description="Operation on the two values",
        update=tag,
        items=[(name, name.title(), "", index) for index, name in enumerate(OPERATORS)],
    )

    def draw_settings(self, layout):
        layout.prop(self, "operation", text="")

    def draw_label(self):
        return self.operation.title()

    def written(self, writer):
        a, b = (writer.input(self.socket(name)) for name in "ab")
        return {"result": writer.assign(self.label or self.operation, ast.BinOp(a, OPERATORS[self.operation](), b))}


COMPARISONS = {"LESS": ast.Lt, "LESS_EQUAL": ast.LtE, "GREATER": ast.Gt, "GREATER_EQUAL": ast.GtE}
_NUMBERS_A_AND_B = (("a", "A", sockets.NUMBER), ("b", "B", sockets.NUMBER))


class SDFLIGHTS_Node_compare(ValueNode, bpy.types.Node):
    """Whether a number or field is less than another"""

    bl_idname = "SDFLIGHTS_Node_compare"
    bl_label = "Compare"
    takes = _NUMBERS_A_AND_B
    gives = (("result", "Condition", sockets.CONDITION),)

    value_a: _value("A")
    value_b: _value("B")
    operation: bpy.props.EnumProperty(
        name="Operation",
        description="Comparison of A with B",
        update=tag,
        items=[
            (name, name.replace("_", " or ").title() + " Than" * (not name.endswith("EQUAL")), "", index)
            for index, name in enumerate(COMPARISONS)
        ],
    )

    def draw_settings(self, layout):
        layout.prop(self, "operation", text="")

    def written(self, writer):
        a, b = (writer.input(self.socket(name)) for name in "ab")
        comparison = ast.Compare(a, [COMPARISONS[self.operation]()], [b])
        return {"result": writer.assign(self.label or "compare", comparison)}


class SDFLIGHTS_Node_boolean(ValueNode, bpy.types.Node):
    """Combine conditions"""

    bl_idname = "SDFLIGHTS_Node_boolean"
    bl_label = "Boolean Math"
    takes = (("a", "A", sockets.CONDITION), ("b", "B", sockets.CONDITION))
    gives = (("result", "Condition", sockets.CONDITION),)

    operation: bpy.props.EnumProperty(
        name="Operation",
        description="Combination of the conditions",
        update=tag,
        items=[
            ("AND", "And", "A and B", 0),
            ("OR", "Or", "A, or B, or both", 1),
            ("NOT", "Not", "Not A", 2),
        ],
    )

    def draw_settings(self, layout):
        layout.prop(self, "operation", text="")

    def written(self, writer):
        a = writer.needed(self.socket("a"))
        if self.operation == "NOT":
            value = ast.UnaryOp(ast.Not(), a)
        else:
            value = ast.BoolOp(ast.And() if self.operation == "AND" else ast.Or(), [a, writer.needed(self.socket("b"))])
        return {"result": writer.assign(self.label or self.operation, value)}


_XYZ = (("x", "X", sockets.NUMBER), ("y", "Y", sockets.NUMBER), ("z", "Z", sockets.NUMBER))


class SDFLIGHTS_Node_combine(ValueNode, bpy.types.Node):
    """A vector from its components"""

    bl_idname = "SDFLIGHTS_Node_combine"
    bl_label = "Combine XYZ"
    takes = _XYZ
    gives = (("result", "Vector", sockets.VECTOR),)

    value_x: _value("X")
    value_y: _value("Y")
    value_z: _value("Z")
    plane: bpy.props.BoolProperty(
        name="In the Plane",
        description="Give the vector two components, for profiles and corners of polygons",
        update=lambda self, context: self.plane_changed(),
    )

    def plane_changed(self):
        """Show the inputs for this choice."""
        self.socket("z").enabled = not self.plane

    def draw_settings(self, layout):
        layout.prop(self, "plane")

    def written(self, writer):
        parts = [writer.input(self.socket(name)) for name in ("xy" if self.plane else "xyz")]
        return {"result": writer.assign(self.label or "vector", word(f"vec{len(parts)}", *parts))}


class SDFLIGHTS_Node_separate(ValueNode, bpy.types.Node):
    """The components of a vector"""

    bl_idname = "SDFLIGHTS_Node_separate"
    bl_label = "Separate XYZ"
    takes = (("vector", "Vector", sockets.VECTOR),)
    gives = _XYZ

    def written(self, writer):
        vector = writer.needed(self.socket("vector"))
        if not isinstance(vector, ast.Name):
            vector = writer.assign("vector", vector)
        return {name: ast.Attribute(vector, name, ast.Load()) for name in "xyz"}


class SDFLIGHTS_Node_distance(ValueNode, bpy.types.Node):
    """The field of a shape or profile at a point: negative inside, and at most the distance from the surface"""

    bl_idname = "SDFLIGHTS_Node_distance"
    bl_label = "Field of Shape"
    takes = (("shape", "Shape or Profile", sockets.ANY), ("point", "Point", sockets.VECTOR))
    gives = (("result", "Field", sockets.NUMBER),)

    def written(self, writer):
        point = writer.input(self.socket("point")) or ast.Name("p", ast.Load())
        field = word("distance", writer.needed(self.socket("shape")), point)
        return {"result": writer.assign(self.label or "field", field)}


_BOUNDS = (("bounds", "Bounds", sockets.VECTOR),)


class SDFLIGHTS_Node_field(ValueNode, bpy.types.Node):
    """The shape in which a field is negative. Its limits are found automatically, or given by a box"""

    bl_idname = "SDFLIGHTS_Node_field"
    bl_label = "Shape of Field"
    takes = (("value", "Field", sockets.NUMBER), *_BOUNDS)
    gives = (("result", "Shape", sockets.SHAPE),)

    value_bounds: bpy.props.FloatVectorProperty(
        name="Bounds",
        description="Half of the size of the box along x, y and z",
        size=3,
        subtype="XYZ",
        default=(1.0, 1.0, 1.0),
        min=0.0,
        precision=3,
        update=tag,
    )
    use_bounds: bpy.props.BoolProperty(
        name="Bounds", description="Cut the shape to a box", update=lambda self, context: self.bounds_changed()
    )

    def init(self, context):
        super().init(context)
        self.bounds_changed()

    def bounds_changed(self):
        """Show the inputs for this choice."""
        self.socket("bounds").enabled = self.use_bounds

    def draw_settings(self, layout):
        layout.prop(self, "use_bounds")

    def written(self, writer):
        named = {"bounds": writer.input(self.socket("bounds"))} if self.use_bounds else {}
        field = word("field", writer.needed(self.socket("value")), **named)
        return {"result": writer.assign(self.label or "shape", field)}


CLASSES = (
    SDFLIGHTS_Node_position,
    SDFLIGHTS_Node_number,
    SDFLIGHTS_Node_vector,
    SDFLIGHTS_Node_parameter,
    SDFLIGHTS_Node_math,
    SDFLIGHTS_Node_compare,
    SDFLIGHTS_Node_boolean,
    SDFLIGHTS_Node_combine,
    SDFLIGHTS_Node_separate,
    SDFLIGHTS_Node_distance,
    SDFLIGHTS_Node_field,
)
