# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes as ``render.material`` nodes.

``_TABLE`` says which node is which, and which socket is which input; a few nodes need a function. Groups, reroutes and
muted nodes dissolve. What replaces a node that is not supported is told in README.md beside this package.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np

from ...render.material import NODES, Node
from ...vec import average, luminance
from .common import Warnings, rgb
from .images import Images, has_alpha

Stack = tuple[bpy.types.Node, ...]  # group nodes that the walk is inside of, outermost first


class _Missing:
    """What a node that is not supported gives: the socket it is linked to then uses its own value."""


MISSING = _Missing()


class _Entry(NamedTuple):
    kind: str
    inputs: dict[str, str]  # of the node here -> identifier of Blender's socket
    settings: Callable[[bpy.types.Node], dict] = lambda node: {}
    ignored: dict[str, float] = {}  # sockets that are not supported, with the value at which that does not matter


def _distribution(node) -> dict:
    # Only multiple scattering differs from a plain GGX: older distributions are taken as GGX, their nearest kin.
    return {"distribution": "MULTI_GGX" if node.distribution == "MULTI_GGX" else "GGX"}


_PRINCIPLED = {name: name.replace("_", " ").title() for name in NODES["principled"]} | {
    "ior": "IOR", "specular_ior_level": "Specular IOR Level", "coat_ior": "Coat IOR"}

_TABLE = {
    "ShaderNodeBsdfPrincipled": _Entry("principled", _PRINCIPLED, _distribution, {
        "Subsurface Weight": 0.0, "Anisotropic": 0.0, "Thin Film Thickness": 0.0, "Thin Wall": 0.0}),
    "ShaderNodeBsdfDiffuse": _Entry("diffuse", dict(color="Color", roughness="Roughness", normal="Normal")),
    "ShaderNodeBsdfAnisotropic": _Entry(  # "Glossy BSDF", whose anisotropy is zero at first
        "glossy", dict(color="Color", roughness="Roughness", normal="Normal"), _distribution, {"Anisotropy": 0.0}),
    "ShaderNodeBsdfGlass": _Entry(
        "glass", dict(color="Color", roughness="Roughness", ior="IOR", normal="Normal"), _distribution,
        {"Thin Film Thickness": 0.0}),
    "ShaderNodeBsdfRefraction": _Entry(
        "refraction", dict(color="Color", roughness="Roughness", ior="IOR", normal="Normal")),
    "ShaderNodeBsdfTransparent": _Entry("transparent", dict(color="Color")),
    "ShaderNodeBsdfTranslucent": _Entry("translucent", dict(color="Color", normal="Normal")),
    "ShaderNodeEmission": _Entry("emission", dict(color="Color", strength="Strength")),
    "ShaderNodeBackground": _Entry("emission", dict(color="Color", strength="Strength")),
    "ShaderNodeHoldout": _Entry("holdout", {}),
    "ShaderNodeMixShader": _Entry("mix_closure", dict(factor="Fac", a="Shader", b="Shader_001")),
    "ShaderNodeAddShader": _Entry("add_closure", dict(a="Shader", b="Shader_001")),
    "ShaderNodeMapping": _Entry(
        "mapping", dict(vector="Vector", location="Location", rotation="Rotation", scale="Scale"),
        lambda node: {"type": node.vector_type}),
    "ShaderNodeNormalMap": _Entry(
        "normal_map", dict(color="Color", strength="Strength"),
        lambda node: {"uv_map": node.uv_map, "space": node.space.removeprefix("BLENDER_")}),
    "ShaderNodeBump": _Entry(
        "bump", dict(strength="Strength", distance="Distance", height="Height", normal="Normal"),
        lambda node: {"invert": node.invert}),
}
_TABLE["ShaderNodeBsdfGlossy"] = _TABLE["ShaderNodeBsdfAnisotropic"]


class Reader:
    """Reads one node tree. ``owner`` names it in warnings: "Material 'Wood'"."""

    def __init__(self, tree: bpy.types.NodeTree, owner: str, images: Images | None, warn: Warnings):
        self.tree, self._owner, self._images, self._warn = tree, owner, images, warn
        self._links: dict[int, dict] = {}
        self._values: dict[tuple, object] = {}

    # -- walking -------------------------------------------------------------------------------------------------------

    def output(self) -> bpy.types.Node | None:
        """The output node that counts: Blender's choice for engines that read Cycles' nodes."""
        return self.tree.get_output_node("CYCLES")

    def resolve(self, socket, stack: Stack = ()):
        """What an input socket is fed by, through groups, reroutes and muted nodes.

        Returns (node, output socket, stack), or (None, input socket, stack) with the socket whose own value counts.
        """
        receiver = socket
        while True:
            link = self._link(socket)
            if link is None:
                return None, receiver, stack
            node, output = link.from_node, link.from_socket
            if node.bl_idname == "NodeReroute":
                socket = node.inputs[0]
                continue
            if node.mute:
                socket = next((inner.from_socket for inner in node.internal_links if inner.to_socket == output), None)
            elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
                inside = next((inner for inner in node.node_tree.nodes
                               if inner.bl_idname == "NodeGroupOutput" and inner.is_active_output), None)
                socket = inside and _by_identifier(inside.inputs, output.identifier)
                stack += (node,)
            elif node.bl_idname == "NodeGroupInput" and stack:
                socket = _by_identifier(stack[-1].inputs, output.identifier)
                stack = stack[:-1]
            else:
                return node, output, stack
            if socket is None:
                return None, receiver, stack
            receiver = socket

    def _link(self, socket):
        """The link into an input. Blender searches all links of a tree for this, so each tree is gone through once."""
        tree = socket.id_data
        links = self._links.get(tree.as_pointer())
        if links is None:
            links = {link.to_socket.as_pointer(): link for link in tree.links if link.is_valid and not link.is_muted}
            self._links[tree.as_pointer()] = links
        return links.get(socket.as_pointer())

    # -- reading -------------------------------------------------------------------------------------------------------

    def read(self, socket, like, stack: Stack = ()):
        """Value of an input: a number, a 3-tuple or a ``Node``, for an input whose default is ``like``.

        None where ``like`` is None and nothing is linked: the input then has its default.
        """
        node, end, inner = self.resolve(socket, stack)
        if node is not None:
            value = self._value(node, end, inner)
            if value is not MISSING:
                return _converted(value, end.type, like)
            end = socket
        if like is None and (end is socket or end.hide_value):
            return None
        return _converted(constant(end), end.type, like)

    def _value(self, node, output, stack: Stack):
        """What a node gives at an output, computed once."""
        key = (node.as_pointer(), output.identifier, tuple(group.as_pointer() for group in stack))
        if key not in self._values:
            self._values[key] = self._node(node, output, stack)
        return self._values[key]

    def _node(self, node, output, stack: Stack):
        if node.bl_idname in {"ShaderNodeRGB", "ShaderNodeValue"}:
            return constant(output)
        special = {
            "ShaderNodeTexImage": self._image, "ShaderNodeUVMap": self._uv, "ShaderNodeTexCoord": self._coordinates,
        }.get(node.bl_idname)
        if special:
            return special(node, output, stack)
        entry = _TABLE.get(node.bl_idname)
        if entry is None:
            return self._unsupported(node, output, stack)
        if node.bl_idname == "ShaderNodeNormalMap" and node.space.startswith("BLENDER_"):
            self.report(node, "the swapped axes of its space are not supported, so it is read without them")
        for identifier, harmless in entry.ignored.items():
            socket = _by_identifier(node.inputs, identifier)
            if socket is not None and (self.resolve(socket, stack)[0] is not None or socket.default_value != harmless):
                self.report(node, f"{identifier} is not supported and is taken as {harmless:g}")
        inputs = {}
        for name, identifier in entry.inputs.items():
            socket = _by_identifier(node.inputs, identifier)
            value = None if socket is None else self.read(socket, NODES[entry.kind][name], stack)
            if value is not None:
                inputs[name] = value
        return Node(entry.kind, inputs, entry.settings(node))

    def _image(self, node, output, stack: Stack):
        image = node.image
        projection = node.projection
        if projection == "BOX":
            self.report(node, "box projection is not supported, so it is read as flat")
            projection = "FLAT"
        index = None
        if image is not None:
            # Blender gives colour times alpha where nothing asks for alpha by itself.
            associated = output.identifier == "Color" and not node.outputs["Alpha"].is_linked and has_alpha(image)
            index = self._images.index(image, associated)
        # "Smart" interpolation is cubic in Cycles.
        interpolation = "Cubic" if node.interpolation == "Smart" else node.interpolation
        settings = dict(image=index, interpolation=interpolation, extension=node.extension, projection=projection,
                        output=output.identifier.lower())
        vector = self.read(node.inputs["Vector"], None, stack)
        return Node("image", {} if vector is None else {"vector": vector}, settings)

    def _uv(self, node, output, stack: Stack):
        if node.from_instancer:
            self.report(node, "coordinates from the instancer are not supported, so it gives those of the mesh")
        return Node("uv", settings={"uv_map": node.uv_map})

    def _coordinates(self, node, output, stack: Stack):
        if output.identifier == "UV":
            return Node("uv", settings={"uv_map": ""})
        return self._unsupported(node, output, stack)

    def _unsupported(self, node, output, stack: Stack):
        if output.type != "SHADER":
            self.report(node, "not supported, so what it is linked to uses its own value")
            return MISSING
        socket = next((socket for socket in node.inputs if socket.name in {"Color", "Base Color"}), None)
        if socket is None:
            self.report(node, "not supported, so it is black")
            return None
        self.report(node, "not supported, so it is a Diffuse BSDF of the same colour")
        return Node("diffuse", {"color": self.read(socket, (0.0, 0.0, 0.0), stack)})

    def report(self, node, what: str) -> None:
        """Warn about a node, by the name that the node editor shows."""
        kind = node.bl_rna.name
        name = f"'{node.name}'" if node.name == kind else f"'{node.name}' ({kind})"
        self._warn(f"{self._owner}: node {name}: {what}.")


def _by_identifier(sockets, identifier: str):
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def constant(socket):
    """A socket's own value: a float, a 3-tuple, or None for a shader."""
    value = getattr(socket, "default_value", None)
    if value is None or isinstance(value, str):
        return None
    return rgb(value) if hasattr(value, "__len__") else float(value)


def _converted(value, socket_type: str, like):
    """A constant as Blender converts it between sockets: colours to numbers by luminance, vectors by mean.

    Nodes stay as they are; back ends convert what they compute.
    """
    if isinstance(value, tuple) and isinstance(like, float):
        return float(luminance(value) if socket_type == "RGBA" else average(value))
    if isinstance(value, float) and isinstance(like, tuple):
        return (value, value, value)
    return value


def emission_of(tree: bpy.types.NodeTree, owner: str, warn: Warnings) -> np.ndarray:
    """RGB that the node tree of a light or world emits: Emission's colour times its strength, or a sum of several.

    Only constants count: the factor is one for the whole light.
    """
    reader = Reader(tree, owner, None, warn)
    output = reader.output()
    if output is None:
        return np.zeros(3)
    surface = reader.read(output.inputs["Surface"], None)
    if surface is None:
        return np.zeros(3)
    if not isinstance(surface, Node) or surface.kind != "emission":
        warn(f"{owner}: only an Emission node linked to its output is supported: its nodes are left out of account.")
        return np.ones(3)
    color, strength = surface["color"], surface["strength"]
    if isinstance(color, Node) or isinstance(strength, Node):
        warn(f"{owner}: textures on lights are not supported: they are taken as 1.")
        color, strength = (np.ones(3) if isinstance(value, Node) else value for value in (color, strength))
    return np.array(color) * strength
