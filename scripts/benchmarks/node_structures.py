# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases about the structure of node trees: groups without links, muted groups, circles of links, reroutes without a
source, and meshes without UV maps. They join the list of ``node_specials``."""

from __future__ import annotations

import bpy

from . import node_data
from .node_sources import Sources
from .node_specials import BALL, special

BARE = "bare"  # a ball without UV maps


def _tree(name: str, sockets: dict[str, str], result: str, fill) -> bpy.types.NodeTree:
    """A group with inputs of these types, and one output; ``fill`` makes it from the node of its inputs."""
    from scenery.materials import Graph

    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for socket, kind in sockets.items():
        tree.interface.new_socket(socket, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    tree.interface.new_socket("Result", in_out="OUTPUT", socket_type=f"NodeSocket{result}")
    graph = Graph(tree)
    begin, end = graph.nodes.new("NodeGroupInput"), graph.nodes.new("NodeGroupOutput")
    graph.links.new(fill(graph, begin.outputs), end.inputs[0])
    return tree


def _interface(tree: bpy.types.NodeTree, name: str):
    return next(item for item in tree.interface.items_tree if item.name == name)


def _used(sources: Sources, tree: bpy.types.NodeTree):
    node = sources.graph.nodes.new("ShaderNodeGroup")
    node.node_tree = tree
    return node


# -- inputs of groups that nothing is linked to ------------------------------------------------------------------------


def _texture(kind: str, output: str):
    def fill(graph, inputs):
        socket = graph.node(kind, output, Vector=inputs["Place"])
        if kind == "ShaderNodeTexImage":
            node_data.image(socket.node, "")
        return socket

    return fill


def _unlinked_place(kind: str, output: str, hidden: bool, levels: int = 1, given: tuple = (0.31, 0.42, 0.17)):
    """A texture in a group, whose input for the coordinates has a value and no link."""

    def build(sources):
        tree = _tree("Texture", dict(Place="Vector"), "Color", _texture(kind, output))
        for _ in range(levels - 1):
            inner = tree
            tree = _tree("Around", dict(Place="Vector"), "Color", lambda graph, inputs: _around(graph, inner, inputs))
        _interface(tree, "Place").hide_value = hidden
        node = _used(sources, tree)
        node.inputs["Place"].default_value = given
        return node.outputs[0]

    return build


def _around(graph, tree, inputs):
    node = graph.nodes.new("ShaderNodeGroup")
    node.node_tree = tree
    graph.links.new(inputs["Place"], node.inputs["Place"])
    return node.outputs[0]


for _kind, _output in (
    ("ShaderNodeTexNoise", "Color"),
    ("ShaderNodeTexGradient", "Color"),
    ("ShaderNodeTexImage", "Color"),
    ("ShaderNodeTexWhiteNoise", "Color"),
    ("ShaderNodeMapping", "Vector"),
):
    _name = _kind.removeprefix("ShaderNode")
    special(f"Group of {_name} with an unlinked vector")(_unlinked_place(_kind, _output, False))
    special(f"Group of {_name} with an unlinked vector without a field")(_unlinked_place(_kind, _output, True))
special("Group in a group with an unlinked vector")(_unlinked_place("ShaderNodeTexNoise", "Color", False, 2))


@special("Group with an unlinked vector through a reroute")
def through_reroute(sources):
    def fill(graph, inputs):
        reroute = graph.nodes.new("NodeReroute")
        graph.links.new(inputs["Place"], reroute.inputs[0])
        return graph.node("ShaderNodeTexNoise", "Color", Vector=reroute.outputs[0])

    node = _used(sources, _tree("Rerouted", dict(Place="Vector"), "Color", fill))
    node.inputs[0].default_value = (0.31, 0.42, 0.17)
    return node.outputs[0]


@special("Group of TexNoise that varies with an unlinked vector without a field")
def varying_texture(sources):
    def fill(graph, inputs):
        return graph.node("ShaderNodeTexNoise", "Color", Vector=inputs["Place"], Scale=inputs["Size"])

    tree = _tree("Texture", dict(Place="Vector", Size="Float"), "Color", fill)
    _interface(tree, "Place").hide_value = True
    node = _used(sources, tree)
    node.inputs["Place"].default_value = (0.31, 0.42, 0.17)
    sources.feed(node.inputs["Size"], "positive")
    return node.outputs[0]


@special("Group with an unlinked color that is a place")
def color_as_place(sources):
    tree = _tree("Texture", dict(Place="Color"), "Color", _texture("ShaderNodeTexNoise", "Color"))
    node = _used(sources, tree)
    node.inputs[0].default_value = (0.31, 0.42, 0.17, 1.0)
    return node.outputs[0]


@special("Group with an unlinked number that is a place")
def number_as_place(sources):
    tree = _tree("Texture", dict(Place="Float"), "Color", _texture("ShaderNodeTexNoise", "Color"))
    node = _used(sources, tree)
    node.inputs[0].default_value = 0.31
    return node.outputs[0]


def _unlinked_normal(hidden: bool, given: tuple):
    def build(sources):
        def fill(graph, inputs):
            return graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.5, 0.3), Normal=inputs["Normal"])

        tree = _tree("Diffuse", dict(Normal="Vector"), "Shader", fill)
        _interface(tree, "Normal").hide_value = hidden
        node = _used(sources, tree)
        node.inputs["Normal"].default_value = given
        return node.outputs[0]

    return build


special("Group with an unlinked normal", place="closure", shape=BALL)(_unlinked_normal(False, (0.0, 0.0, 0.0)))
special("Group with an unlinked normal of a value", place="closure", shape=BALL)(
    _unlinked_normal(False, (0.3, 0.2, 0.9))
)
special("Group with an unlinked normal without a field", place="closure", shape=BALL)(
    _unlinked_normal(True, (0.0, 0.0, 0.0))
)


@special("Group with an unlinked tangent", place="closure", shape=BALL)
def unlinked_tangent(sources):
    def fill(graph, inputs):
        return graph.node("ShaderNodeBsdfAnisotropic", Roughness=0.4, Anisotropy=0.8, Tangent=inputs["Tangent"])

    return _used(sources, _tree("Brushed", dict(Tangent="Vector"), "Shader", fill)).outputs[0]


@special("Group with an unlinked normal of Fresnel")
def unlinked_normal_of_fresnel(sources):
    def fill(graph, inputs):
        return graph.node("ShaderNodeLayerWeight", "Facing", Blend=0.4, Normal=inputs["Normal"])

    node = _used(sources, _tree("Facing", dict(Normal="Vector"), "Float", fill))
    node.inputs[0].default_value = (0.3, 0.2, 0.9)
    return node.outputs[0]


# -- sockets of another type on the way --------------------------------------------------------------------------------


def _through_number(feed):
    """A colour, or the result of ``feed``, through a group of one number."""

    def build(sources):
        tree = _tree("Number", dict(Number="Float"), "Float", lambda graph, inputs: inputs["Number"])
        node = _used(sources, tree)
        feed(sources, node.inputs[0])
        return node.outputs[0]

    return build


def _constant_color(sources, socket):
    mix = sources.graph.node("ShaderNodeMix", data_type="RGBA", Factor=0.3, A=(0.7, 0.4, 0.2), B=(0.1, 0.5, 0.9))
    sources.graph.links.new(mix, socket)


special("Color through a group of a number")(_through_number(lambda sources, socket: sources.feed(socket, "color")))
special("Constant color through a group of a number")(_through_number(_constant_color))


@special("Color through a muted node of numbers")
def through_muted_number(sources):
    socket = sources.graph.node("ShaderNodeMath", _0=sources["color"], operation="ADD")
    socket.node.mute = True
    return socket


def _through(inputs: str, result: str, feed):
    """A constant through a group of one socket of another type, with no node or with one that Blender computes."""

    def build(sources):
        node = _used(sources, _tree("Passed", dict(Passed=inputs), result, lambda graph, inputs: inputs["Passed"]))
        feed(sources, node.inputs[0])
        return node.outputs[0]

    return build


def _linked(kind: str, output: str | int = 0, **inputs):
    def feed(sources, socket):
        sources.graph.links.new(sources.graph.node(kind, output, **inputs), socket)

    return feed


def _red(sources, socket):
    color = sources.graph.node("ShaderNodeRGB")
    color.default_value = (0.9, 0.3, 0.1, 1.0)
    sources.graph.links.new(color, socket)


_PLACE = (0.31, 0.42, 0.17)
for _name, _feed in {
    "Sum": _linked("ShaderNodeMath", _0=2.6, _1=0.3),
    "Negative sum": _linked("ShaderNodeMath", _0=-2.6, _1=0.3),
    "Inverted color": _linked("ShaderNodeInvert", Fac=0.4, Color=(0.9, 0.3, 0.1)),
    "Color node": _red,
    "Ramp": _linked("ShaderNodeValToRGB", Fac=0.4),
    "Curves": _linked("ShaderNodeRGBCurve", Fac=0.6, Color=(0.9, 0.3, 0.1)),
    "Mapped vector": _linked("ShaderNodeMapping", Vector=_PLACE, Scale=(3.0, 4.0, 0.5)),
    "Rotated vector": _linked("ShaderNodeVectorRotate", Vector=_PLACE, Angle=1.3),
    "Noise of its own place": _linked("ShaderNodeTexNoise", "Color"),
    "White noise of its own place": _linked("ShaderNodeTexWhiteNoise", "Color"),
}.items():
    for _type in ("Float", "Int", "Bool"):
        special(f"{_name} through a group of {_type}")(_through(_type, "Color", _feed))


@special("Switch of a group before a number")
def switch_before_number(sources):
    def fill(graph, inputs):
        return graph.node("ShaderNodeInvert", Fac=inputs["On"], Color=(0.9, 0.3, 0.1))

    node = _used(sources, _tree("Switched", dict(On="Bool"), "Float", fill))
    node.inputs[0].default_value = True
    return node.outputs[0]


@special("Unknown node in a group")
def unknown_in_group(sources):
    tree = _tree("Unknown", dict(Place="Vector"), "Color", lambda graph, inputs: graph.node("ShaderNodeShaderToRGB"))
    return sources.graph.node("ShaderNodeGamma", Color=_used(sources, tree).outputs[0], Gamma=1.4)


@special("Unknown node before a reroute")
def unknown_before_reroute(sources):
    reroute = sources.graph.nodes.new("NodeReroute")
    sources.graph.links.new(sources.graph.node("ShaderNodeShaderToRGB"), reroute.inputs[0])
    return reroute.outputs[0]


@special("Unknown node before a texture")
def unknown_before_texture(sources):
    return sources.graph.node(
        "ShaderNodeTexNoise", "Color", Vector=sources.graph.node("ShaderNodeShaderToRGB"), Scale=2.0
    )


@special("Muted nodes without such an input")
def muted_chain(sources):
    first, second = sources.graph.node("ShaderNodeTexCoord", "Normal"), sources.graph.node("ShaderNodeGamma", Gamma=1.4)
    sources.graph.links.new(first, second.node.inputs["Color"])
    first.node.mute = second.node.mute = True
    return second


# -- muted groups ------------------------------------------------------------------------------------------------------


def _two_inputs():
    def fill(graph, inputs):
        return graph.node("ShaderNodeMix", data_type="RGBA", Factor=0.3, A=inputs["First"], B=inputs["Second"])

    return _tree("Two", dict(First="Color", Second="Color"), "Color", fill)


@special("Muted group with nothing linked")
def muted_group(sources):
    node = _used(sources, _two_inputs())
    node.inputs[0].default_value, node.inputs[1].default_value = (0.7, 0.4, 0.2, 1.0), (0.2, 0.3, 0.8, 1.0)
    node.mute = True
    return node.outputs[0]


@special("Muted group with the second input linked")
def muted_group_second(sources):
    node = _used(sources, _two_inputs())
    node.inputs[0].default_value = (0.7, 0.4, 0.2, 1.0)
    sources.feed(node.inputs[1], "color")
    node.mute = True
    return node.outputs[0]


@special("Muted group before a node")
def muted_group_before(sources):
    node = _used(sources, _two_inputs())
    node.inputs[0].default_value = (0.7, 0.4, 0.2, 1.0)
    node.mute = True
    return sources.graph.node("ShaderNodeGamma", Color=node.outputs[0], Gamma=1.4)


@special("Muted node with nothing linked")
def muted_unlinked(sources):
    socket = sources.graph.node("ShaderNodeInvert", Color=(0.7, 0.4, 0.2))
    socket.node.mute = True
    return socket


@special("Muted texture before a node")
def muted_texture(sources):
    """It has an input of the kind of its output, which is not linked either."""
    socket = sources.graph.node("ShaderNodeTexChecker", "Color", Color1=(0.7, 0.4, 0.2), Color2=(0.1, 0.3, 0.6))
    socket.node.mute = True
    return sources.graph.node("ShaderNodeGamma", Color=socket, Gamma=1.4)


@special("Muted mapping before a texture")
def muted_mapping(sources):
    socket = sources.graph.node("ShaderNodeMapping", Location=(0.2, 0.1, 0.4))
    socket.node.inputs["Vector"].default_value = (0.31, 0.42, 0.17)
    socket.node.mute = True
    return sources.graph.node("ShaderNodeTexNoise", "Color", Vector=socket)


@special("Muted node without such an input")
def muted_without(sources):
    socket = sources.graph.node("ShaderNodeTexNoise", "Color", Scale=3.0)
    socket.node.mute = True
    return sources.graph.node("ShaderNodeGamma", Color=socket, Gamma=1.4)


@special("Muted group with an unlinked shader", place="closure", shape=BALL)
def muted_group_shader(sources):
    def fill(graph, inputs):
        return graph.node("ShaderNodeMixShader", _0=0.4, _1=inputs["First"], _2=inputs["Second"])

    node = _used(sources, _tree("Shaders", dict(First="Shader", Second="Shader"), "Shader", fill))
    sources.graph.links.new(sources.graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2)), node.inputs[1])
    node.mute = True
    return node.outputs[0]


# -- links that lead nowhere -------------------------------------------------------------------------------------------


def _dangling(kind: str, socket: str, output: str | int = 0, **inputs):
    """A node with one input linked to a reroute without a source."""

    def build(sources):
        made = sources.graph.node(kind, output, **inputs)
        reroute = sources.graph.nodes.new("NodeReroute")
        sources.graph.links.new(reroute.outputs[0], made.node.inputs[socket])
        return made

    return build


special("Reroute of nothing before a color")(_dangling("ShaderNodeGamma", "Color", Color=(0.7, 0.4, 0.2), Gamma=1.4))
special("Reroute of nothing before a number")(_dangling("ShaderNodeGamma", "Gamma", Color=(0.7, 0.4, 0.2), Gamma=1.4))
special("Reroute of nothing before a texture")(_dangling("ShaderNodeTexNoise", "Vector", "Color", Scale=3.0))
special("Reroute of nothing before a shader", place="closure", shape=BALL)(
    _dangling("ShaderNodeBsdfDiffuse", "Color", Color=(0.7, 0.4, 0.2))
)
special("Reroute of nothing before a normal", place="closure", shape=BALL)(
    _dangling("ShaderNodeBsdfDiffuse", "Normal", Color=(0.7, 0.4, 0.2))
)


@special("Reroute of nothing")
def reroute_of_nothing(sources):
    node = sources.graph.nodes.new("NodeReroute")
    node.socket_idname = "NodeSocketColor"
    return node.outputs[0]


@special("Reroute of nothing as a shader", place="closure", shape=BALL)
def reroute_as_shader(sources):
    reroute = sources.graph.nodes.new("NodeReroute")
    shader = sources.graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.4, 0.2))
    mix = sources.graph.node("ShaderNodeMixShader", _0=0.3, _1=shader)
    sources.graph.links.new(reroute.outputs[0], mix.node.inputs[2])
    return mix


@special("Circle of links")
def circle(sources):
    first = sources.graph.node("ShaderNodeGamma", Color=(0.7, 0.4, 0.2), Gamma=1.4)
    second = sources.graph.node("ShaderNodeInvert", Color=first)
    sources.graph.links.new(second, first.node.inputs["Color"])
    return second


@special("Circle of links beside a color")
def circle_beside(sources):
    """The node before the circle is looked at, whose other input is linked to it."""
    first = sources.graph.node("ShaderNodeGamma", Color=(0.7, 0.4, 0.2), Gamma=1.4)
    second = sources.graph.node("ShaderNodeInvert", Color=first)
    sources.graph.links.new(second, first.node.inputs["Color"])
    return sources.graph.node("ShaderNodeMix", data_type="RGBA", Factor=0.4, A=sources["color"], B=first)


# -- meshes without UV maps --------------------------------------------------------------------------------------------


def _tint(sources):
    """Colours around the neutral one, by the position on the object."""
    return sources.graph.node(
        "ShaderNodeVectorMath",
        _0=sources.graph.node("ShaderNodeTexCoord", "Generated"),
        _1=(0.6, 0.6, 0.1),
        _2=(0.2, 0.2, 0.85),
        operation="MULTIPLY_ADD",
    )


@special("Normal Map without UVs", shape=BARE)
def normal_map_bare(sources):
    return sources.graph.node("ShaderNodeNormalMap", Color=_tint(sources))


@special("Normal Map of an UV map that is not there", shape=BARE)
def normal_map_missing(sources):
    return sources.graph.node("ShaderNodeNormalMap", Color=_tint(sources), uv_map="Missing")


@special("Tangent without UVs", shape=BARE)
def tangent_bare(sources):
    return sources.graph.node("ShaderNodeTangent", direction_type="UV_MAP")


@special("Tangent of an UV map that is not there", shape=BARE)
def tangent_missing(sources):
    return sources.graph.node("ShaderNodeTangent", direction_type="UV_MAP", uv_map="Missing")


@special("Vector Displacement without UVs", place="displacement", shape=BARE)
def displacement_bare(sources):
    return sources.graph.node("ShaderNodeVectorDisplacement", Vector=_tint(sources), Scale=0.1, Midlevel=0.3)


@special("Image without UVs", shape=BARE)
def image_bare(sources):
    socket = sources.graph.node("ShaderNodeTexImage")
    node_data.image(socket.node, "")
    return socket
