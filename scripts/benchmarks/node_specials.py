# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of more than one node: groups, reroutes, muted nodes, and structures that Blender resolves before Cycles sees
them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy

from . import node_data
from .node_sources import Sources

PLANE, BALL = "plane", "ball"


@dataclass(frozen=True)
class Special:
    build: Callable[[Sources], bpy.types.NodeSocket]
    place: str = "value"
    shape: str = PLANE
    light: str = "POINT"  # the target is a light
    since: tuple[int, int, int] = (4, 5, 0)


SPECIALS: dict[str, Special] = {}


def special(name: str, **about):
    def note(build):
        SPECIALS[name] = Special(build, **about)
        return build

    return note


def _group(name: str) -> bpy.types.NodeTree:
    """A group that doubles a colour and adds a number's square to it."""
    tree = bpy.data.node_groups.get(name)
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor").default_value = (
        0.2,
        0.4,
        0.9,
        1.0,
    )
    tree.interface.new_socket("Number", in_out="INPUT", socket_type="NodeSocketFloat").default_value = 0.6
    tree.interface.new_socket("Result", in_out="OUTPUT", socket_type="NodeSocketColor")
    tree.interface.new_socket("Plain", in_out="OUTPUT", socket_type="NodeSocketFloat")
    begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    scale, square = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeMath")
    scale.operation, square.operation = "MULTIPLY_ADD", "MULTIPLY"
    scale.inputs[1].default_value = (2.0, 2.0, 2.0)
    for index in (0, 1):
        tree.links.new(begin.outputs["Number"], square.inputs[index])
    tree.links.new(begin.outputs["Color"], scale.inputs[0])
    tree.links.new(square.outputs[0], scale.inputs[2])
    tree.links.new(scale.outputs[0], end.inputs["Result"])
    tree.links.new(begin.outputs["Number"], end.inputs["Plain"])
    return tree


def _use(sources: Sources, tree: bpy.types.NodeTree):
    node = sources.graph.nodes.new("ShaderNodeGroup")
    node.node_tree = tree
    return node


@special("Group")
def group(sources):
    node = _use(sources, _group("Doubled"))
    sources.feed(node.inputs["Color"], "color")
    sources.feed(node.inputs["Number"], "x")
    return node.outputs["Result"]


@special("Group with its own values")
def group_of_defaults(sources):
    return _use(sources, _group("Doubled")).outputs["Result"]


@special("Group used twice")
def group_twice(sources):
    first, second = _use(sources, _group("Doubled")), _use(sources, _group("Doubled"))
    sources.feed(first.inputs["Number"], "x")
    sources.feed(second.inputs["Number"], "y")
    sources.graph.links.new(first.outputs["Result"], second.inputs["Color"])
    return second.outputs["Result"]


@special("Group in a group")
def nested_group(sources):
    name = "Doubled twice"
    tree = bpy.data.node_groups.get(name)
    if tree is None:
        tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
        tree.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
        tree.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        last = begin.outputs[0]
        for _ in range(2):
            inner = tree.nodes.new("ShaderNodeGroup")
            inner.node_tree = _group("Doubled")
            tree.links.new(last, inner.inputs["Color"])
            last = inner.outputs["Result"]
        tree.links.new(last, end.inputs[0])
    node = _use(sources, tree)
    sources.feed(node.inputs[0], "color")
    return node.outputs[0]


@special("Group of no tree")
def empty_group(sources):
    node = sources.graph.nodes.new("ShaderNodeGroup")
    node.label = "empty"
    return sources.graph.node("ShaderNodeMix", data_type="RGBA", Factor=0.5, A=(0.9, 0.4, 0.1), B=(0.1, 0.5, 0.9))


@special("Reroute")
def reroute(sources):
    node = sources.graph.nodes.new("NodeReroute")
    sources.graph.links.new(sources["color"], node.inputs[0])
    return node.outputs[0]


@special("Muted node")
def muted(sources):
    socket = sources.graph.node("ShaderNodeInvert", Color=sources["color"])
    socket.node.mute = True
    return socket


@special("Muted link")
def muted_link(sources):
    socket = sources.graph.node("ShaderNodeGamma", Color=sources["color"], Gamma=0.7)
    link = sources.graph.links.new(sources["positive"], socket.node.inputs["Gamma"])
    link.is_muted = True
    return socket


@special("Muted shader", place="closure", shape=BALL)
def muted_shader(sources):
    shader = sources.graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2))
    socket = sources.graph.node("ShaderNodeMixShader", _1=shader)
    socket.node.mute = True
    return socket


# Each type of socket linked to each other: Blender's conversions.


@special("Color to number")
def color_to_number(sources):
    return sources.graph.node(
        "ShaderNodeMath", _0=sources.graph.node("ShaderNodeGamma", Color=sources["color"], Gamma=1.0), _1=0.0
    )


@special("Vector to number")
def vector_to_number(sources):
    return sources.graph.node("ShaderNodeMath", _0=sources["vector"], _1=0.0)


@special("Number to vector")
def number_to_vector(sources):
    return sources.graph.node("ShaderNodeVectorMath", _0=sources["x"], _1=(0.1, 0.2, 0.3))


@special("Number to color")
def number_to_color(sources):
    return sources.graph.node("ShaderNodeGamma", Color=sources["positive"], Gamma=1.3)


@special("Number as a shader", place="closure", shape=BALL)
def number_as_shader(sources):
    """A value at a shader input is emitted."""
    return sources["factor"]


@special("Color as a shader", place="closure", shape=BALL)
def color_as_shader(sources):
    return sources["color"]


@special("Mapping of the texture itself")
def texture_mapping(sources):
    """Texture nodes of old files have a mapping of their own."""
    socket = sources.graph.node("ShaderNodeTexGradient", Vector=sources["vector3"])
    mapping = socket.node.texture_mapping
    mapping.translation, mapping.rotation, mapping.scale = (0.2, -0.1, 0.3), (0.3, 0.5, -0.4), (1.7, 0.6, 1.0)
    mapping.mapping_x, mapping.mapping_y = "Y", "X"
    return socket


def _own_mapping(kind: str, scale: tuple, axis: str = "X"):
    def build(sources):
        socket = sources.graph.node("ShaderNodeTexGradient", Vector=sources["vector3"])
        mapping = socket.node.texture_mapping
        mapping.vector_type, mapping.rotation, mapping.scale = kind, (0.3, 0.5, -0.4), scale
        mapping.mapping_x = axis
        return socket

    return build


special("Mapping of the texture itself, of normals")(_own_mapping("NORMAL", (1.7, -0.6, 1.0)))
special("Mapping of the texture itself, without an axis")(_own_mapping("NORMAL", (1.7, -0.6, 1.0), "NONE"))
special("Mapping of the texture itself, of no scale")(_own_mapping("TEXTURE", (1.7, 0.0, 1.0)))


# -- Blender 5.0 and later ---------------------------------------------------------------------------------------------


@special("Bool", since=(5, 2, 0))
def boolean(sources):
    return sources.graph.node("FunctionNodeInputBool", boolean=True)


@special("Integer", since=(5, 2, 0))
def integer(sources):
    return sources.graph.node("FunctionNodeInputInt", integer=3)


@special("Vector", since=(5, 2, 0))
def vector(sources):
    return sources.graph.node("FunctionNodeInputVector", vector=(0.2, 0.7, 1.3))


@special("Scene Time", since=(5, 2, 0))
def scene_time(sources):
    return sources.graph.node("GeometryNodeInputSceneTime", "Seconds")


@special("Menu Switch", since=(5, 2, 0))
def menu_switch(sources):
    node = sources.graph.nodes.new("GeometryNodeMenuSwitch")
    for index, name in enumerate(("color", "color2")):
        sources.graph.links.new(sources[name], node.inputs[1 + index])
    node.inputs[0].default_value = node.enum_items[1].name
    return node.outputs[0]


@special("Repeat zone", since=(5, 0, 0))
def repeat(sources):
    """Three rounds that double and add."""
    begin, end = (sources.graph.nodes.new(f"GeometryNodeRepeat{kind}") for kind in ("Input", "Output"))
    begin.pair_with_output(end)
    end.repeat_items.clear()
    end.repeat_items.new("FLOAT", "Sum")
    begin.inputs["Iterations"].default_value = 3
    sources.graph.links.new(sources["x"], begin.inputs["Sum"])
    step = sources.graph.node("ShaderNodeMath", _0=begin.outputs["Sum"], _1=1.5, _2=0.2, operation="MULTIPLY_ADD")
    sources.graph.links.new(step, end.inputs["Sum"])
    return end.outputs["Sum"]


@special("Closure zone", since=(5, 0, 0))
def closure_zone(sources):
    """A closure of nodes that is evaluated at two places."""
    begin, end = (sources.graph.nodes.new(f"NodeClosure{kind}") for kind in ("Input", "Output"))
    begin.pair_with_output(end)
    end.input_items.new("FLOAT", "Number")
    end.output_items.new("FLOAT", "Result")
    square = sources.graph.node(
        "ShaderNodeMath", _0=begin.outputs["Number"], _1=begin.outputs["Number"], operation="MULTIPLY"
    )
    sources.graph.links.new(square, end.inputs["Result"])
    results = []
    for name in ("x", "y"):
        evaluate = sources.graph.nodes.new("NodeEvaluateClosure")
        evaluate.input_items.new("FLOAT", "Number")
        evaluate.output_items.new("FLOAT", "Result")
        sources.graph.links.new(end.outputs[0], evaluate.inputs["Closure"])
        sources.graph.links.new(sources[name], evaluate.inputs["Number"])
        results.append(evaluate.outputs["Result"])
    return sources.graph.node("ShaderNodeMath", _0=results[0], _1=results[1], operation="SUBTRACT")


@special("Bundle", since=(5, 0, 0))
def bundle(sources):
    join, part = sources.graph.nodes.new("NodeCombineBundle"), sources.graph.nodes.new("NodeSeparateBundle")
    for node in (join, part):
        node.bundle_items.new("RGBA", "Color")
        node.bundle_items.new("FLOAT", "Number")
    sources.graph.links.new(sources["color"], join.inputs["Color"])
    sources.graph.links.new(sources["positive"], join.inputs["Number"])
    sources.graph.links.new(join.outputs[0], part.inputs[0])
    return sources.graph.node("ShaderNodeGamma", Color=part.outputs["Color"], Gamma=part.outputs["Number"])


# -- worlds ------------------------------------------------------------------------------------------------------------


def _background(sources, color, strength=1.0):
    return sources.graph.node("ShaderNodeBackground", Color=color, Strength=strength)


@special("World of a color", place="world")
def world_color(sources):
    return _background(sources, (0.8, 0.5, 0.2), 0.7)


@special("World without nodes linked", place="world")
def world_bare(sources):
    return sources.graph.node("ShaderNodeRGB")


def _world_picture(projection: str, interpolation: str, vector: str):
    def build(sources):
        socket = sources.graph.node("ShaderNodeTexEnvironment", projection=projection, interpolation=interpolation)
        socket.node.image = node_data.panorama()
        if vector:
            turned = sources.graph.node(
                "ShaderNodeMapping", Vector=sources.graph.node("ShaderNodeTexCoord", vector), Rotation=(0.2, 0.3, 0.9)
            )
            sources.graph.links.new(turned, socket.node.inputs["Vector"])
        return _background(sources, socket)

    return build


for _projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
    for _interpolation in ("Linear", "Closest", "Cubic", "Smart"):
        special(f"World of a picture, {_projection} {_interpolation}", place="world")(
            _world_picture(_projection, _interpolation, "")
        )
special("World of a picture that is turned", place="world")(_world_picture("EQUIRECTANGULAR", "Linear", "Generated"))


@special("World of an image texture", place="world")
def world_image(sources):
    """Without coordinates: one place of the image."""
    socket = sources.graph.node("ShaderNodeTexImage")
    socket.node.image = node_data.panorama()
    return _background(sources, socket)


def _world_sky(kind: str, disc: bool):
    def build(sources):
        socket = sources.graph.node("ShaderNodeTexSky", sky_type=kind)
        node_data.sky(socket.node, "")
        socket.node.sun_disc, socket.node.sun_size = disc, 0.35
        return _background(sources, socket, 0.1 if "SCATTERING" in kind or kind == "NISHITA" else 1.0)

    return build


for _item in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items:
    special(f"World of a sky, {_item.identifier}", place="world")(_world_sky(_item.identifier, False))
    if _item.identifier not in {"PREETHAM", "HOSEK_WILKIE"}:
        special(f"World of a sky, {_item.identifier} with its sun", place="world")(_world_sky(_item.identifier, True))


def _world_coordinates(output: str):
    def build(sources):
        return _background(sources, sources.graph.node("ShaderNodeTexCoord", output))

    return build


for _output in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"):
    special(f"World of TexCoord {_output}", place="world")(_world_coordinates(_output))


def _world_geometry(output: str):
    def build(sources):
        return _background(sources, sources.graph.node("ShaderNodeNewGeometry", output))

    return build


for _output in ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Parametric"):
    special(f"World of Geometry {_output}", place="world")(_world_geometry(_output))


@special("World of noise", place="world")
def world_noise(sources):
    return _background(sources, sources.graph.node("ShaderNodeTexNoise", "Color", Scale=3.0))


@special("World of a gradient with a ramp", place="world")
def world_gradient(sources):
    up = sources.graph.node("ShaderNodeSeparateXYZ", "Z", Vector=sources.graph.node("ShaderNodeTexCoord", "Generated"))
    socket = sources.graph.node("ShaderNodeValToRGB", Fac=up)
    node_data.ramp(socket.node, "")
    return _background(sources, socket)


@special("World that only the camera sees", place="world")
def world_light_path(sources):
    seen = sources.graph.node("ShaderNodeLightPath", "Is Camera Ray")
    return sources.graph.node(
        "ShaderNodeMixShader",
        _0=seen,
        _1=_background(sources, (0.0, 0.0, 0.0)),
        _2=_background(sources, (0.3, 0.6, 0.9)),
    )


# -- lights ------------------------------------------------------------------------------------------------------------


def _emission(sources, color=(1.0, 1.0, 1.0), strength=1.0):
    return sources.graph.node("ShaderNodeEmission", Color=color, Strength=strength)


def _falloff(output: str, smooth: float):
    def build(sources):
        return _emission(
            sources, strength=sources.graph.node("ShaderNodeLightFalloff", output, Strength=1.3, Smooth=smooth)
        )

    return build


for _output in ("Quadratic", "Linear", "Constant"):
    special(f"Light with a falloff, {_output}", place="light")(_falloff(_output, 0.0))
    special(f"Light with a smooth falloff, {_output}", place="light")(_falloff(_output, 0.2))
special("Spot light with a falloff", place="light", light="SPOT")(_falloff("Linear", 0.0))


@special("Light of a color", place="light")
def light_color(sources):
    return _emission(sources, (0.3, 0.6, 0.9), 1.7)


@special("Light of a temperature", place="light")
def light_temperature(sources):
    return _emission(sources, sources.graph.node("ShaderNodeBlackbody", Temperature=3200.0))


@special("Light of a profile", place="light")
def light_profile(sources):
    socket = sources.graph.node("ShaderNodeTexIES")
    node_data.photometry(socket.node, "")
    return _emission(sources, strength=socket)


@special("Light of directions", place="light")
def light_directions(sources):
    """A pattern by the direction from the light, as gobos have it."""
    socket = sources.graph.node(
        "ShaderNodeTexChecker", Vector=sources.graph.node("ShaderNodeTexCoord", "Normal"), Scale=3.7
    )
    return _emission(sources, socket)


@special("Spot light of a picture", place="light", light="SPOT")
def light_picture(sources):
    socket = sources.graph.node("ShaderNodeTexEnvironment", Vector=sources.graph.node("ShaderNodeTexCoord", "Normal"))
    socket.node.image = node_data.panorama()
    return _emission(sources, socket)


@special("Light by its ray's length", place="light")
def light_length(sources):
    return _emission(sources, strength=sources.graph.node("ShaderNodeLightPath", "Ray Length"))


@special("Sun of a color", place="light", light="SUN")
def sun_color(sources):
    return _emission(sources, (0.9, 0.5, 0.3), 0.4)


# -- what tells of objects and cameras, where no object has been met ---------------------------------------------------

_ELSEWHERE = {
    "ShaderNodeObjectInfo": ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"),
    "ShaderNodeCameraData": ("View Vector", "View Z Depth", "View Distance"),
    "ShaderNodeNewGeometry": ("Backfacing", "Pointiness", "Random Per Island"),
    "ShaderNodeAttribute": ("Color", "Fac", "Alpha"),
    "ShaderNodeVertexColor": ("Color", "Alpha"),
    "ShaderNodeUVMap": ("UV",),
    "ShaderNodeTangent": ("Tangent",),
    "ShaderNodeWireframe": ("Fac",),
    "ShaderNodeParticleInfo": ("Index", "Random"),
    "ShaderNodeNormalMap": ("Normal",),
    "ShaderNodeLayerWeight": ("Fresnel", "Facing"),
    "ShaderNodeFresnel": ("Fac",),
}
_OF_LIGHTS = {
    "ShaderNodeTexCoord": ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"),
    "ShaderNodeNewGeometry": (
        "Position",
        "Normal",
        "Tangent",
        "True Normal",
        "Incoming",
        "Parametric",
        *_ELSEWHERE["ShaderNodeNewGeometry"],
    ),
}


def _positive(sources, socket):
    return sources.graph.node("ShaderNodeVectorMath", _0=socket, operation="ABSOLUTE")


def _elsewhere(node: str, output: str, lights: bool):
    def build(sources):
        socket = sources.graph.node(node, output)
        if node == "ShaderNodeAttribute":
            socket.node.attribute_name = "There is none"
        socket = _positive(sources, socket)
        return _emission(sources, socket) if lights else _background(sources, socket)

    return build


for _node, _outputs in _ELSEWHERE.items():
    for _output in _outputs:
        special(f"World of {_node.removeprefix('ShaderNode')} {_output}", place="world")(
            _elsewhere(_node, _output, False)
        )
for _node, _outputs in (_ELSEWHERE | _OF_LIGHTS).items():
    for _output in _outputs:
        special(f"Light of {_node.removeprefix('ShaderNode')} {_output}", place="light")(
            _elsewhere(_node, _output, True)
        )


def _transformed(start: str, end: str, lights: bool):
    def build(sources):
        socket = sources.graph.node("ShaderNodeTexCoord", "Normal" if lights else "Generated")
        socket = sources.graph.node(
            "ShaderNodeVectorTransform", Vector=socket, vector_type="POINT", convert_from=start, convert_to=end
        )
        socket = _positive(sources, socket)
        return _emission(sources, socket) if lights else _background(sources, socket)

    return build


def _attribute_of(kind: str, name: str):
    def build(sources):
        socket = sources.graph.node("ShaderNodeAttribute", "Fac", attribute_type=kind, attribute_name=name)
        return _emission(sources, strength=socket)

    return build


for _kind, _name in (("OBJECT", "number"), ("INSTANCER", "number"), ("VIEW_LAYER", "scene_number")):
    special(f"Light of Attribute {_kind}", place="light")(_attribute_of(_kind, _name))
    special(f"World of Attribute {_kind}", place="world")(_attribute_of(_kind, _name))


for _start, _end in (("WORLD", "CAMERA"), ("CAMERA", "OBJECT"), ("OBJECT", "WORLD")):
    special(f"World of VectorTransform from {_start} to {_end}", place="world")(_transformed(_start, _end, False))
    special(f"Light of VectorTransform from {_start} to {_end}", place="light")(_transformed(_start, _end, True))


@special("Spot light of TexCoord UV", place="light", light="SPOT")
def spot_uv(sources):
    return _emission(sources, _positive(sources, sources.graph.node("ShaderNodeTexCoord", "UV")))


# -- values where shaders are expected ---------------------------------------------------------------------------------


@special("World of a number", place="world")
def world_number(sources):
    return sources.graph.node("ShaderNodeTexNoise", "Fac", Scale=3.0)


@special("World of a vector", place="world")
def world_vector(sources):
    return _positive(sources, sources.graph.node("ShaderNodeTexCoord", "Generated"))


@special("Light of a number", place="light")
def light_number(sources):
    return sources.graph.node("ShaderNodeMath", _0=0.3, _1=0.4)


@special("Light of a vector", place="light")
def light_vector(sources):
    return _positive(sources, sources.graph.node("ShaderNodeTexCoord", "Normal"))


@special("Mix of a number and a color as shaders", place="closure", shape=BALL)
def mixed_values(sources):
    return sources.graph.node("ShaderNodeMixShader", _0=0.4, _1=sources["factor"], _2=sources["color"])


@special("Sum of a vector and a shader", place="closure", shape=BALL)
def sum_of_values(sources):
    shader = sources.graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2))
    return sources.graph.node("ShaderNodeAddShader", _0=_positive(sources, sources["vector3"]), _1=shader)
