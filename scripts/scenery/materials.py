# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the demo scene."""

from __future__ import annotations

import bpy
import numpy as np


def image(name: str, pixels: np.ndarray, colour: bool):
    """A painted texture, (height, width, 3) in [0, 1], packed into the .blend; not ``colour``: plain numbers."""
    height, width, _ = pixels.shape
    texture = bpy.data.images.new(name, width, height)
    texture.colorspace_settings.name = "sRGB" if colour else "Non-Color"
    flat = np.ones((height, width, 4), np.float32)
    flat[..., :3] = pixels
    texture.pixels.foreach_set(flat.ravel())
    texture.pack()
    return texture


class Graph:
    """A material's node tree, written down in a line a node."""

    def __init__(self, name: str):
        self.material = bpy.data.materials.new(name)
        if not self.material.use_nodes:
            self.material.use_nodes = True
        self.nodes, self.links = self.material.node_tree.nodes, self.material.node_tree.links
        self.nodes.clear()

    def node(self, kind: str, output: str | int = 0, **inputs):
        """The output socket of a new node; an input is a value or another node's output."""
        node = self.nodes.new(kind)
        for name, value in inputs.items():
            socket = node.inputs[int(name[1:]) if name[0] == "_" else name.replace("_", " ")]
            if isinstance(value, bpy.types.NodeSocket):
                self.links.new(value, socket)
            else:
                socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
        return node.outputs[output]

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
        output = self.nodes.new("ShaderNodeOutputMaterial")
        self.links.new(closure, output.inputs[socket])
        return self.material


def principled(name: str, base_color, roughness: float, **inputs):
    """A Principled material without textures."""
    graph = Graph(name)
    return graph.finish(graph.node("ShaderNodeBsdfPrincipled", Base_Color=base_color, Roughness=roughness, **inputs))
