# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sockets: what links carry. One kind for each kind of value of the expression language.

The value of an input that nothing is linked to is a property of its node, where it has the limits, unit and tooltip of
the parameter, and can be animated. Interfaces of groups offer Blender's own sockets for numbers and vectors.
"""

import bpy

SHAPE, PROFILE, NUMBER, VECTOR, COLOR, CONDITION, ANY = (
    f"SDFLIGHTS_NodeSocket{name}" for name in ("Shape", "Profile", "Number", "Vector", "Color", "Condition", "Any")
)

_KINDS = {  # label, colour as Blender has it for the same kind of data, what links bring
    SHAPE: ("Shape", (0.0, 0.84, 0.64, 1.0), "a shape"),
    PROFILE: ("Profile", (0.92, 0.46, 0.51, 1.0), "a profile"),
    NUMBER: ("Number", (0.63, 0.63, 0.63, 1.0), "a number"),
    VECTOR: ("Vector", (0.39, 0.39, 0.78, 1.0), "a vector"),
    COLOR: ("Color", (0.78, 0.78, 0.16, 1.0), "a colour"),
    CONDITION: ("Condition", (0.8, 0.65, 0.84, 1.0), "a condition"),
    ANY: ("Value", (0.63, 0.63, 0.63, 1.0), "a value"),
}

BLENDERS = {"VALUE": "a number", "INT": "a number", "BOOLEAN": "a condition", "VECTOR": "a vector", "RGBA": "a colour"}
"""Blender's own sockets by type, which interfaces of groups and text nodes use, and what they carry."""

_SAME = {"VALUE": NUMBER, "INT": NUMBER, "BOOLEAN": CONDITION, "VECTOR": VECTOR, "RGBA": COLOR}

_IN_GROUPS = {
    NUMBER: "NodeSocketFloat",
    ANY: "NodeSocketFloat",
    VECTOR: "NodeSocketVector",
    COLOR: "NodeSocketColor",
    CONDITION: "NodeSocketBool",
}

# What each kind of socket takes. Blender's are numbers, vectors and conditions of the language.
_TAKES = {
    SHAPE: {"a shape", "a number", "a value"},  # of a field, the region where it is negative
    PROFILE: {"a profile"},
    NUMBER: {"a number", "a value"},
    VECTOR: {"a vector", "a number", "a value", "a colour"},
    COLOR: {"a colour", "a vector", "a number", "a value"},
    CONDITION: {"a condition"},
}


def carried(socket: bpy.types.NodeSocket) -> str:
    """What a socket carries, in words; empty for a socket of another kind of tree."""
    return _KINDS[socket.bl_idname][2] if socket.bl_idname in _KINDS else BLENDERS.get(socket.type, "")


def kind_of(socket: bpy.types.NodeSocket) -> str:
    """Type of socket of this kind of tree that carries the same; empty for those of other trees."""
    return socket.bl_idname if socket.bl_idname in _KINDS else _SAME.get(socket.type, "")


def carried_by(kind: str) -> str:
    """As ``carried``, for a type of this kind of tree."""
    return _KINDS[kind][2]


def takes(socket: bpy.types.NodeSocket, value: str) -> bool:
    """Whether an input takes what an output carries, as far as that can be told from the sockets."""
    return kind_takes(socket.bl_idname, value)


def kind_takes(kind: str, value: str) -> bool:
    """As ``takes``, for the type of an input."""
    return value in _TAKES.get(kind, {value})


def in_group(socket: bpy.types.NodeSocket) -> str:
    """Type of socket that stands for this one in the interface of a group."""
    return _IN_GROUPS.get(socket.bl_idname, socket.bl_idname)


def kind_in_group(name: str) -> str:
    """The way back of ``in_group``."""
    return next((kind for kind, own in _IN_GROUPS.items() if own == name), NUMBER if name == "NodeSocketInt" else name)


def is_value(socket: bpy.types.NodeSocket) -> bool:
    """Whether an input that nothing is linked to has a value: its node's parameter, or its own."""
    return socket.bl_idname not in _KINDS or held_by_node(socket)


def property_of(identifier: str) -> str:
    """Name of the node's property for an input: nodes have properties of their own called height, width and so on."""
    return f"value_{identifier}"


def held_by_node(socket: bpy.types.NodeSocket) -> bool:
    """Whether the value of the socket is a property of its node."""
    return socket.bl_idname in _KINDS and property_of(socket.identifier) in socket.node.bl_rna.properties


def _draw(self, context, layout, node, text):
    if self.is_output or self.is_linked or not held_by_node(self):
        layout.label(text=text)
    elif self.bl_idname == VECTOR:
        layout.column(align=True).prop(node, property_of(self.identifier), text=text)
    else:
        layout.prop(node, property_of(self.identifier), text=text)


def _socket(name: str) -> type:
    label, color, _ = _KINDS[name]
    return type(
        name,
        (bpy.types.NodeSocket,),
        {"bl_idname": name, "bl_label": label, "draw": _draw, "draw_color_simple": classmethod(lambda cls: color)},
    )


def _interface(name: str) -> type:
    return type(
        f"{name}Interface",
        (bpy.types.NodeTreeInterfaceSocket,),
        {
            "bl_idname": f"{name}Interface",
            "bl_socket_idname": name,
            "bl_label": _KINDS[name][0],
            "draw": lambda self, context, layout: None,
        },
    )


OFFERED = (SHAPE, PROFILE, "NodeSocketFloat", "NodeSocketInt", "NodeSocketBool", "NodeSocketVector", "NodeSocketColor")
"""Types that the interface of a group may have."""

CLASSES = (*map(_socket, _KINDS), *map(_interface, (SHAPE, PROFILE)))
