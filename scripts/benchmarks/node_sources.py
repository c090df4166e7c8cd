# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of the nodes under test: numbers, vectors and colours that vary over a tile.

All of them are the UV map through a Mapping node, which is among the simplest nodes. Their ranges are odd numbers, so
that few edges or cells fall on the centre of a pixel, where rounding would decide.
"""

from __future__ import annotations

import bpy

# name: location, rotation and scale of Mapping, from UVs in [0, 1].
VECTORS = {
    "vector": ((-2.137, -1.913, 0.371), (0.51, 0.35, 0.23), (4.93, 5.11, 1.0)),  # all signs, no axis along the tile
    "vector2": ((1.317, -2.213, 0.613), (0.13, -0.41, 0.93), (-3.07, 4.09, 1.0)),
    "vector3": ((-0.417, -0.813, -0.213), (-0.31, 0.21, 0.37), (1.37, 1.31, 1.0)),
    "flat": ((-1.537, -2.513, 0.0), (0.0, 0.0, 0.23), (4.93, 5.11, 1.0)),
    "picture": ((-0.337, -0.613, 0.213), (0.0, 0.0, 0.2), (1.93, 2.11, 1.0)),  # beyond [0, 1] on all sides
    "color": ((-0.043, -0.021, 0.353), (0.31, -0.23, 0.41), (1.13, 1.07, 1.0)),  # a little below 0 and above 1, too
    "color2": ((0.917, 0.213, 0.113), (0.41, 0.33, 0.73), (-0.83, 0.71, 1.0)),
    "direction": ((-1.013, -0.987, 0.453), (0.0, 0.0, 0.1), (2.03, 1.97, 1.0)),
}
# name: the component, and its range across (0) or up (1) the tile.
NUMBERS = {
    "x": (0, -2.27, 2.31),
    "y": (1, -2.287, 2.353),
    "factor": (0, -0.137, 1.143),
    "factor_y": (1, -0.113, 1.121),
    "positive": (0, 0.053, 3.113),
    "positive_y": (1, 0.047, 2.911),
    "unit": (0, 0.031, 0.983),
    "unit_y": (1, 0.017, 0.971),
    "kelvin": (0, 713.0, 13013.0),
    "nanometres": (0, 360.3, 800.7),
    "sides": (0, 2.113, 7.943),
}


class Sources:
    """Nodes of one graph (``scenery.materials.Graph``) that feed others, each made on first use."""

    def __init__(self, graph):
        self.graph, self._made, self._turn = graph, {}, {}

    def __getitem__(self, name: str) -> bpy.types.NodeSocket:
        if name not in self._made:
            if name == "uv":
                self._made[name] = self.graph.node("ShaderNodeTexCoord", "UV")
            elif name == "object_positive":  # inside objects, where there are no UVs
                self._made[name] = self.graph.node(
                    "ShaderNodeSeparateXYZ", "X", Vector=self.graph.node("ShaderNodeTexCoord", "Generated")
                )
            elif name in VECTORS:
                location, rotation, scale = VECTORS[name]
                self._made[name] = self._mapped(location, rotation, scale)
            else:
                component, low, high = NUMBERS[name]
                location, scale = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
                location[component], scale[component] = low, high - low
                vector = self._mapped(location, (0.0, 0.0, 0.0), scale)
                self._made[name] = self.graph.node("ShaderNodeSeparateXYZ", component, Vector=vector)
        return self._made[name]

    def _mapped(self, location, rotation, scale) -> bpy.types.NodeSocket:
        return self.graph.node(
            "ShaderNodeMapping", Vector=self["uv"], Location=location, Rotation=rotation, Scale=scale
        )

    def feed(self, socket, value) -> None:
        """Give an input a value: a source by its name, a function of ``self``, a constant, or None to leave it."""
        if isinstance(value, str) and socket.type not in {"STRING", "MENU"}:
            self.graph.links.new(self[value], socket)
        elif callable(value):
            self.graph.links.new(value(self), socket)
        elif isinstance(value, tuple) and socket.type == "RGBA" and len(value) == 3:
            socket.default_value = (*value, 1.0)
        elif value is not None:
            socket.default_value = value

    def feed_by_type(self, socket) -> None:
        """For an unknown node: the first inputs of a kind vary, others keep their defaults."""
        names = dict(VALUE=("x", "y", "factor"), RGBA=("color", "color2"), VECTOR=("vector", "vector2")).get(
            socket.type, ()
        )
        turn = self._turn.get(socket.type, 0)
        if turn < len(names) and socket.name not in {"Normal", "Tangent"}:
            self.feed(socket, names[turn])
            self._turn[socket.type] = turn + 1


def wavy(sources: Sources) -> bpy.types.NodeSocket:
    """A height that goes up and down."""
    return sources.graph.node(
        "ShaderNodeMath",
        _0=sources.graph.node(
            "ShaderNodeVectorMath", "Value", _0=sources["vector"], _1=(1.0, 0.7, 0.0), operation="DOT_PRODUCT"
        ),
        operation="SINE",
    )


def snapped(sources: Sources) -> bpy.types.NodeSocket:
    """Vectors that are constant in each of a few cells: white noise shows no other structure."""
    return sources.graph.node("ShaderNodeVectorMath", _0=sources["vector"], _1=(1.213, 1.213, 1.213), operation="SNAP")


def snapped_number(sources: Sources) -> bpy.types.NodeSocket:
    return sources.graph.node("ShaderNodeMath", _0=sources["x"], _1=0.613, operation="SNAP")


def bumped(sources: Sources) -> bpy.types.NodeSocket:
    """A normal other than the surface's."""
    return sources.graph.node(
        "ShaderNodeVectorMath", _0=sources.graph.node("ShaderNodeNewGeometry", "Normal"), _1=(0.4, -0.3, 0.2)
    )


def normal_color(sources: Sources) -> bpy.types.NodeSocket:
    """Colours as in a picture of normals: about (0.5, 0.5, 1)."""
    return sources.graph.node(
        "ShaderNodeVectorMath", _0=sources["color"], _1=(0.6, 0.6, 0.1), _2=(0.2, 0.2, 0.85), operation="MULTIPLY_ADD"
    )


def place(sources: Sources) -> bpy.types.NodeSocket:
    """A point a little above the surface."""
    surface = sources.graph.node("ShaderNodeNewGeometry", "Position").node.outputs
    return sources.graph.node(
        "ShaderNodeVectorMath",
        _0=surface["Normal"],
        _1=(0.013, 0.013, 0.013),
        _2=surface["Position"],
        operation="MULTIPLY_ADD",
    )


def sideways(sources: Sources) -> bpy.types.NodeSocket:
    """A direction along the tiles, in the rotation of ``node_scenes.FRAME``, and slightly towards the camera."""
    return sources.graph.node("ShaderNodeCombineXYZ", X=0.469, Y=0.789, Z=0.45)


def far(sources: Sources) -> bpy.types.NodeSocket:
    """Positions a kilometre away."""
    return sources.graph.node("ShaderNodeVectorMath", _0=sources["vector"], _1=(1000.3, -700.7, 400.9))
