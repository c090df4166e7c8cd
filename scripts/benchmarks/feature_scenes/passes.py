# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes, and the compositor trees that read them."""

from __future__ import annotations

import bpy
from scenery.compositing import empty_compositor, sum_of_light_groups

from .motion import keyed
from .stage import feature, lamp

LOBES = [f"{lobe}_{part}" for lobe in ("diffuse", "glossy", "transmission") for part in ("direct", "indirect", "color")]
DATA = ("z", "mist", "position", "normal", "uv", "object_index", "material_index", "ambient_occlusion")


def _on(names) -> None:
    layer = bpy.context.view_layer
    for name in names:
        setattr(layer, f"use_pass_{name}", True)


def _compositor(scene):
    scene.render.use_compositing = True
    return empty_compositor(scene)


@feature("Passes", all_passes=True)
def passes(scene):
    """All passes of data and of light."""
    lamp()
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 3.0, 4.0
    scene.world.light_settings.distance = 1.0
    for index, thing in enumerate(scene.objects):
        thing.pass_index = index
    for index, material in enumerate(bpy.data.materials):
        material.pass_index = 10 * index
    _on([*LOBES, *DATA, "emit"])


@feature("Passes", all_passes=True)
def environment(scene):
    """The world behind a low wall."""
    wall, tree = bpy.data.objects["Wall"], scene.world.node_tree
    wall.scale.y, wall.location.z = 0.3, 0.75
    place, shade = (tree.nodes.new(f"ShaderNodeTex{kind}") for kind in ("Coord", "Gradient"))
    tree.links.new(place.outputs["Generated"], shade.inputs["Vector"])
    tree.links.new(
        shade.outputs["Color"], next(node for node in tree.nodes if node.type == "BACKGROUND").inputs["Color"]
    )
    _on(["environment"])


@feature("Passes", all_passes=True)
def light_groups(scene):
    """A pass for each light group."""
    layer = bpy.context.view_layer
    for name in ("Key", "Fill", "Sky"):
        layer.lightgroups.add(name=name)
    bpy.data.objects["Key"].lightgroup, bpy.data.objects["Fill"].lightgroup = "Key", "Fill"
    scene.world.lightgroup = "Sky"


@feature("Passes", all_passes=True)
def AOV(scene):
    """A colour and a value that a material gives to passes."""
    layer, tree = bpy.context.view_layer, bpy.data.materials["Clay"].node_tree
    for name, kind in (("Tint", "COLOR"), ("Height", "VALUE")):
        aov = layer.aovs.add()
        aov.name, aov.type = name, kind
        node = tree.nodes.new("ShaderNodeOutputAOV")
        node.aov_name = name
        place = tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(place.outputs["Position"], node.inputs[0 if kind == "COLOR" else 1])


@feature("Compositor", layer="Composite")
def cryptomatte(scene):
    """The matte of two objects, by Blender's Cryptomatte node."""
    _on(["cryptomatte_object"])
    tree, end = _compositor(scene)
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.scene, node.layer_name = "RENDER", scene, f"{bpy.context.view_layer.name}.CryptoObject"
    node.matte_id = "Metal,Block"
    tree.links.new(node.outputs["Matte"], end.inputs[0])


@feature("Compositor", layer="Composite")
def vector_blur(scene):
    """Motion from the pass Vector, by Blender's Vector Blur node."""
    _on(["vector", "z"])
    keyed(bpy.data.objects["Plastic"], "location", (-0.6, -0.5, 0.3), (-0.2, -0.5, 0.3), (0.2, -0.5, 0.3))
    tree, end = _compositor(scene)
    layers, node = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeVecBlur")
    layers.scene = scene
    for source, target in (("Image", "Image"), ("Vector", "Speed"), ("Depth", "Z")):
        tree.links.new(layers.outputs[source], node.inputs[target])
    tree.links.new(node.outputs[0], end.inputs[0])


@feature("Compositor", layer="Composite")
def light_groups_mixed_anew(scene):
    """Half of one light group and twice another one, added by the compositor."""
    light_groups(scene)
    bpy.context.view_layer.update_render_passes()
    tree, end = _compositor(scene)
    result = sum_of_light_groups(scene, tree, {"Key": 0.5, "Fill": 2.0, "Sky": 1.0})
    tree.links.new(result, end.inputs[0])
