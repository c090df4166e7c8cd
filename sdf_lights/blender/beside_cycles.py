# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps together with Cycles. A second scene, which shares all objects, renders the light of the lamps. The compositor
of the first scene adds it.

In the second scene, all lamps are in one light group (``sync``); its light is the light of the lamps. Meanwhile lamps
give no light in Cycles: an empty output replaces the output of their nodes (``fallback``).
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from . import cycles, fallback
from .naming import BESIDE_GROUP, ENGINE

_PASS = f"Combined_{BESIDE_GROUP}"
_MARK = "sdf_lights_beside"  # marks nodes of the add-on
_ASIDE = 300.0  # distance between nodes in the compositor


def _tree(scene: bpy.types.Scene) -> bpy.types.NodeTree | None:
    """The nodes of a scene's compositor; None if it does not use them."""
    if hasattr(scene, "compositing_node_group"):
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def _new_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """Nodes that show the render, marked as the add-on's own."""
    if hasattr(scene, "compositing_node_group"):
        tree = bpy.data.node_groups.new(f"{scene.name} Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group, kind = tree, "NodeGroupOutput"
    else:
        scene.use_nodes = True
        tree, kind = scene.node_tree, "CompositorNodeComposite"
        tree.nodes.clear()
    layers, output = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new(kind)
    layers.scene, output.location = scene, (3.0 * _ASIDE, 0.0)
    layers[_MARK] = output[_MARK] = True
    tree.links.new(layers.outputs["Image"], output.inputs[0])
    return tree


def _lamps(scene: bpy.types.Scene) -> Iterator[bpy.types.Light]:
    return (obj.data for obj in scene.objects if obj.type == "LIGHT" and obj.data.sdf_lamp.use)


def add(scene: bpy.types.Scene) -> bpy.types.Scene:
    """Add the light of a scene's lamps to its Cycles render. Returns the scene that renders the light."""
    remove(scene)
    beside = scene.copy()
    beside.name, beside.world = f"{scene.name} SDF Lamps", None
    if hasattr(beside, "compositing_node_group"):
        beside.compositing_node_group = None
    else:
        beside.use_nodes = False
    beside.render.engine = ENGINE
    cycles.copy(beside)
    beside.sdf_lights.is_beside = True
    for layer in beside.view_layers:
        if BESIDE_GROUP not in layer.lightgroups:
            layer.lightgroups.add(name=BESIDE_GROUP)
        layer.update_render_passes()
    scene.sdf_lights.beside = beside
    tree = _tree(scene) or _new_tree(scene)
    found = [node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers" and node.scene == scene]
    for node in found:
        _insert(tree, node, beside)
    for light in _lamps(scene):
        fallback.follow(light)
    return beside


def _insert(tree: bpy.types.NodeTree, shown: bpy.types.Node, beside: bpy.types.Scene) -> None:
    """Add the light of the lamps to the picture of a view layer."""
    layers, both = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("ShaderNodeMix")
    layers[_MARK] = both[_MARK] = True
    layers.scene, layers.layer, layers.label = beside, shown.layer, "Light of SDF Lamps"
    layers.location = shown.location.x, shown.location.y - 1.5 * _ASIDE
    both.data_type, both.blend_type, both.label = "RGBA", "ADD", "Add Light of SDF Lamps"
    both.location = shown.location.x + _ASIDE, shown.location.y
    picture = shown.outputs["Image"]
    factor, first, second = (
        next(socket for socket in both.inputs if socket.enabled and socket.name == name)
        for name in ("Factor", "A", "B")
    )
    result = next(socket for socket in both.outputs if socket.enabled)
    targets = [link.to_socket for link in picture.links]
    factor.default_value = 1.0
    tree.links.new(picture, first)
    tree.links.new(layers.outputs[_PASS], second)
    for target in targets:
        tree.links.new(result, target)


def remove(scene: bpy.types.Scene) -> bool:
    """Undo ``add``. Returns False if there is nothing to undo."""
    beside = scene.sdf_lights.beside
    if beside is None:
        return False
    tree = _tree(scene)
    own = [node for node in tree.nodes if _MARK in node.keys()] if tree is not None else []
    for both in [node for node in own if node.bl_idname == "ShaderNodeMix"]:
        sources = [link.from_socket for socket in both.inputs if socket.name == "A" for link in socket.links]
        for link in [link for socket in both.outputs for link in socket.links] if sources else []:
            tree.links.new(sources[0], link.to_socket)
    if own and len(own) == len(tree.nodes):
        if hasattr(scene, "compositing_node_group"):
            bpy.data.node_groups.remove(tree)
        else:
            tree.nodes.clear()
            scene.use_nodes = False
    else:
        for node in [node for node in own if node.bl_idname in ("ShaderNodeMix", "CompositorNodeRLayers")]:
            if node.bl_idname == "ShaderNodeMix" or node.scene == beside:
                tree.nodes.remove(node)
    scene.sdf_lights.beside = None
    bpy.data.scenes.remove(beside)
    for light in _lamps(scene):
        fallback.follow(light)
    return True


class _BesideOperator:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.engine == "CYCLES" and hasattr(context.scene, "cycles")


class SDFLIGHTS_OT_beside_cycles_add(_BesideOperator, bpy.types.Operator):
    """Add the light of the lamps to the render of Cycles, with a separate scene and the compositor"""

    bl_idname = "sdf_lights.beside_cycles_add"
    bl_label = "Add Lamps' Light to Cycles"

    def execute(self, context):
        beside = add(context.scene)
        self.report({"INFO"}, f"Scene '{beside.name}' renders the light of the lamps: F12 adds it to Cycles")
        return {"FINISHED"}


class SDFLIGHTS_OT_beside_cycles_remove(_BesideOperator, bpy.types.Operator):
    """Render again without the light of the lamps"""

    bl_idname = "sdf_lights.beside_cycles_remove"
    bl_label = "Remove Lamps' Light from Cycles"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.sdf_lights.beside is not None

    def execute(self, context):
        remove(context.scene)
        return {"FINISHED"}


def draw(layout, context) -> None:
    """The buttons, in a panel of a lamp."""
    if not SDFLIGHTS_OT_beside_cycles_add.poll(context):
        return
    there = context.scene.sdf_lights.beside is not None
    row = layout.row(align=True)
    row.operator(
        SDFLIGHTS_OT_beside_cycles_add.bl_idname,
        text="Update Lamps' Light in Cycles" if there else "Add Lamps' Light to Cycles",
        icon="FILE_REFRESH" if there else "ADD",
    )
    if there:
        row.operator(SDFLIGHTS_OT_beside_cycles_remove.bl_idname, text="", icon="X")


CLASSES = (SDFLIGHTS_OT_beside_cycles_add, SDFLIGHTS_OT_beside_cycles_remove)
