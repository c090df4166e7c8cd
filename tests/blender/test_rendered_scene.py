# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A window may show one scene while another one is rendered: what nodes ask of the scene is what the rendered one
has."""

import bpy
import pytest


@pytest.fixture
def other(file, quad, material):
    """Function: another scene than the open one, with a quad whose material shines with what ``build(tree)`` gives."""

    def run(build) -> bpy.types.Scene:
        made, tree, output = material()
        shine = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(build(tree), shine.inputs["Strength"])
        tree.links.new(shine.outputs[0], output)
        data = quad()
        data.materials.append(made)
        scene = bpy.data.scenes.new("Other")
        for thing in (bpy.data.objects.new("Quad", data), file.camera):
            scene.collection.objects.link(thing)
        scene.camera = file.camera
        scene.render.resolution_x = scene.render.resolution_y = 8
        for owner, distance in ((file.scene, 3.0), (scene, 0.625)):
            owner.world = bpy.data.worlds.new(owner.name)
            owner.world.light_settings.distance = distance
        file.scene.render.fps, scene.render.fps = 24, 64
        assert bpy.context.scene == file.scene
        return scene

    return run


def _slots(scene) -> list:
    return scene.materials[0].parameters


def test_the_distance_of_ambient_occlusion(synced, other):
    def build(tree):
        node = tree.nodes.new("ShaderNodeAmbientOcclusion")
        node.inputs["Distance"].default_value = 0.0
        return node.outputs["AO"]

    slots = _slots(synced(rendered=other(build)))
    assert 0.625 in slots and 3.0 not in slots


@pytest.mark.skipif(bpy.app.version < (5, 2), reason="Scene Time is a node of 5.2")
def test_time(synced, other):
    """Of the first frame, for whose number Blender goes by the open scene."""
    scene = other(lambda tree: tree.nodes.new("GeometryNodeInputSceneTime").outputs["Seconds"])
    assert 1.0 / 64 in _slots(synced(rendered=scene))


def test_attributes_of_the_view_layer(file, synced, other):
    """A light's, which are read with its nodes."""
    light = bpy.data.lights.new("Light", "POINT")
    if not light.use_nodes:
        light.use_nodes = True
    tree = light.node_tree
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = "VIEW_LAYER", "number"
    shine = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")
    tree.links.new(node.outputs["Fac"], shine.inputs["Strength"])
    scene = other(lambda tree: tree.nodes.new("ShaderNodeValue").outputs[0])
    scene.collection.objects.link(bpy.data.objects.new("Light", light))
    file.scene["number"], scene["number"] = 7.0, 0.5
    assert synced(rendered=scene).lights[0].color == (0.5, 0.5, 0.5)
