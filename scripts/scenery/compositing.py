# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compositor trees, in all supported versions of Blender."""

from __future__ import annotations

import bpy

MIX = "CompositorNodeMixRGB" if bpy.app.version < (5, 0, 0) else "ShaderNodeMix"


def empty_compositor(scene):
    """(tree, node): an empty tree of the scene's compositor, and the node whose first input is the result."""
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositor", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        return tree, tree.nodes.new("NodeGroupOutput")
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite")


def sum_of_light_groups(scene, tree, factors: dict[str, float]):
    """The output socket of the sum of light groups, each times its factor."""
    layers, result = tree.nodes.new("CompositorNodeRLayers"), None
    layers.scene = scene
    for name, factor in factors.items():
        node = tree.nodes.new(MIX)
        if MIX == "ShaderNodeMix":
            node.data_type, node.clamp_factor = "RGBA", False
        node.blend_type = "ADD"
        share, first, second = (socket for socket in node.inputs if socket.enabled)
        share.default_value, first.default_value = factor, (0.0, 0.0, 0.0, 1.0)
        if result is not None:
            tree.links.new(result, first)
        tree.links.new(layers.outputs[f"Combined_{name}"], second)
        result = next(socket for socket in node.outputs if socket.enabled)
    return result
