# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the demo scene."""

from __future__ import annotations

import bpy
import numpy as np

from sdf_lights.blender.shader_trees import use_nodes


def image(name: str, pixels: np.ndarray, colour: bool):
    """A painted texture, (height, width, 3) in [0, 1], packed into the .blend; without ``colour``: plain numbers."""
    height, width, _ = pixels.shape
    texture = bpy.data.images.new(name, width, height)
    texture.colorspace_settings.name = "sRGB" if colour else "Non-Color"
    flat = np.ones((height, width, 4), np.float32)
    flat[..., :3] = pixels
    texture.pixels.foreach_set(flat.ravel())
    texture.pack()
    return texture


class Graph:
    """A node tree, written with one line per node: that of a new material, or of another owner."""

    def __init__(self, name: str | bpy.types.ID):
        self.material = bpy.data.materials.new(name) if isinstance(name, str) else name
        tree = self.material if isinstance(self.material, bpy.types.NodeTree) else use_nodes(self.material)
        self.nodes, self.links = tree.nodes, tree.links
        self.nodes.clear()

    def node(self, kind: str, output: str | int = 0, **inputs):
        """The output socket of a new node. An input is a value or another node's output, by name or by index: ``_0``.

        Other arguments are settings: ``operation="SINE"``. Settings come first, because they determine the sockets.
        """
        node = self.nodes.new(kind)
        settings = {name for name in inputs if name in node.bl_rna.properties}
        for name in settings:
            setattr(node, name, inputs[name])
        for name, value in inputs.items():
            if name not in settings:
                self.feed(_socket(node.inputs, int(name[1:]) if name[0] == "_" else name.replace("_", " ")), value)
        return _socket(node.outputs, output)

    def feed(self, socket, value) -> None:
        """Link an input to another node's output, or give it a value."""
        if isinstance(value, bpy.types.NodeSocket):
            self.links.new(value, socket)
        else:
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value

    def texture(self, texture, **mapping):
        """Colour of an image texture on the active UV map, through a Mapping node if ``mapping`` is given."""
        socket = self.node("ShaderNodeTexImage")
        socket.node.image = texture
        if mapping:
            uv = self.node("ShaderNodeTexCoord", "UV")
            self.links.new(self.node("ShaderNodeMapping", Vector=uv, **mapping), socket.node.inputs["Vector"])
        return socket

    def bump(self, height, distance: float, strength: float = 1.0):
        return self.node("ShaderNodeBump", Height=height, Distance=distance, Strength=strength)

    def finish(self, closure, socket: str = "Surface"):
        kind = {"WORLD": "World", "LIGHT": "Light"}.get(self.material.id_type, "Material")
        output = self.nodes.new(f"ShaderNodeOutput{kind}")
        self.links.new(closure, output.inputs[socket])
        return self.material


def principled(name: str, base_color, roughness: float, **inputs):
    """A Principled material without textures."""
    graph = Graph(name)
    return graph.finish(graph.node("ShaderNodeBsdfPrincipled", Base_Color=base_color, Roughness=roughness, **inputs))


def _socket(sockets, key: str | int):
    """A socket by its name or index, among those that a node's settings leave."""
    there = [socket for socket in sockets if socket.enabled]
    return (
        there[key]
        if isinstance(key, int)
        else next(socket for socket in there if key in (socket.name, socket.identifier))
    )
