# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that send rays show what they show in Cycles, on any number of threads."""

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")


@pytest.fixture
def corner(file, add, quad, material):
    """Function: a floor and a block whose material ends in what ``build(tree)`` gives, with a ball beside them."""
    bpy.ops.preferences.addon_enable(module="cycles")

    def run(build):
        made, tree, output = material("Probed")
        tree.links.new(build(tree), output)
        made.cycles.emission_sampling = "NONE"  # so that nothing lights the ball
        floor = quad("Floor")
        bpy.ops.mesh.primitive_cube_add(size=1.2, location=(0.3, 0.0, 0.7), rotation=(0.2, 0.1, 0.6))
        block = bpy.context.object
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(-0.9, -0.2, 0.6), segments=16, ring_count=8)
        for mesh in (floor, block.data):
            mesh.materials.append(made)
        add("Floor", floor, scale=(2.0, 2.0, 1.0))
        file.camera.location, file.camera.rotation_euler = (0.0, -4.0, 3.0), (0.95, 0.0, 0.0)
        scene, cycles = file.scene, file.scene.cycles
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        cycles.samples, cycles.pixel_filter_type, cycles.max_bounces = 256, "BOX", 0
        bpy.ops.sdf_lights.cycles_settings_copy()
        scene.sdf_lights.device = "CPU"
        return scene

    return run


def _shown(tree, value):
    """The value as light."""
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(value, emission.inputs["Color"])
    return emission.outputs[0]


def occlusion(tree, **settings):
    node = tree.nodes.new("ShaderNodeAmbientOcclusion")
    node.inputs["Color"].default_value = (0.9, 0.6, 0.3, 1.0)
    for name, value in settings.items():
        setattr(node, name, value)
    return _shown(tree, node.outputs["Color"])


def occlusion_of_the_world(tree):
    bpy.context.scene.world = bpy.data.worlds.new("World")
    bpy.context.scene.world.light_settings.distance = 0.7
    shown = occlusion(tree)
    tree.nodes["Ambient Occlusion"].inputs["Distance"].default_value = 0.0
    return shown


def bevel(tree):
    node = tree.nodes.new("ShaderNodeBevel")
    node.samples, node.inputs["Radius"].default_value = 16, 0.3
    return _shown(tree, node.outputs[0])


def raycast(tree):
    node = tree.nodes.new("ShaderNodeRaycast")
    node.inputs["Length"].default_value = 1.5
    return _shown(tree, node.outputs["Hit Distance"])


def occluded_where_it_is_clear(tree):
    """Occlusion is not looked for by light rays that ask what a surface lets through."""
    node = tree.nodes.new("ShaderNodeAmbientOcclusion")
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    solid = tree.nodes.new("ShaderNodeBsdfDiffuse")
    for source, target in (
        (node.outputs["AO"], mix.inputs[0]),
        (clear.outputs[0], mix.inputs[1]),
        (solid.outputs[0], mix.inputs[2]),
    ):
        tree.links.new(source, target)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, 0.1
    thing = bpy.data.objects.new("Sun", sun)
    thing.rotation_euler = (0.5, 0.3, 0.0)
    bpy.context.scene.collection.objects.link(thing)
    return mix.outputs[0]


CASES = {
    "occlusion": occlusion,
    "inside": lambda tree: occlusion(tree, inside=True),
    "only local": lambda tree: occlusion(tree, only_local=True),
    "the world's distance": occlusion_of_the_world,
    "bevel": bevel,
    "raycast": raycast,
    "clear in part": occluded_where_it_is_clear,
}


@pytest.mark.parametrize("name", CASES)
def test_rays_show_what_they_show_in_cycles(corner, pictures, name):
    if name == "raycast" and not hasattr(bpy.types, "ShaderNodeRaycast"):
        pytest.skip("this Blender has no such node")
    scene, found = corner(CASES[name]), {}
    for engine in ("CYCLES", "SDF_LIGHTS"):
        scene.render.engine = engine
        picture = pictures()["ViewLayer"]["Combined"][..., :3].astype(float)
        found[engine] = picture.reshape(4, 4, 6, 4, 3).mean((1, 3))
    ours, theirs = found["SDF_LIGHTS"], found["CYCLES"]
    assert theirs.std() > 0.02
    size = np.maximum(np.abs(theirs), np.abs(theirs).mean())
    print(f"{name}: {np.abs((ours - theirs) / size).mean():.4f}, at most {np.abs((ours - theirs) / size).max():.4f}")
    assert np.abs((ours - theirs) / size).mean() < 0.005
    assert np.abs((ours - theirs) / size).max() < 0.02


def test_the_picture_does_not_depend_on_threads(corner, pictures):
    def both(tree):
        mix = tree.nodes.new("ShaderNodeMixRGB")
        for place, shown in ((1, occlusion(tree)), (2, bevel(tree))):
            tree.links.new(shown.node.inputs["Color"].links[0].from_socket, mix.inputs[place])
        return _shown(tree, mix.outputs[0])

    scene, found = corner(both), []
    scene.render.engine, scene.sdf_lights.samples = "SDF_LIGHTS", 4
    for threads in (1, 3):
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
        found.append(pictures()["ViewLayer"]["Combined"])
    assert found[0][..., :3].std() > 0.1
    assert np.array_equal(*found)
