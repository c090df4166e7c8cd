# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of lamps added to what Cycles renders is that of one render of all, within noise."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import beside_cycles, fallback
from sdf_lights.blender.naming import ENGINE
from sdf_lights.blender.shader_trees import node_tree_of

SAMPLES = 144
WIDTH, HEIGHT = 24, 16


@pytest.fixture
def scene(file, stage, add):
    """A lamp and a point light above a floor, for Cycles without what biases it."""
    bpy.ops.preferences.addon_enable(module="cycles")
    made, cycles = file.scene, file.scene.cycles
    light = bpy.data.lights.new("Point", "POINT")
    light.energy, light.shadow_soft_size = 60.0, 0.3
    add("Point", light, location=(1.5, 0.0, 1.5))
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SAMPLES, False, False
    cycles.blur_glossy, cycles.light_sampling_threshold, cycles.sample_clamp_indirect = 0.0, 0.0, 0.0
    cycles.pixel_filter_type = "BOX"
    made.render.engine = "CYCLES"
    return made


def rendered(scene, path) -> np.ndarray:
    """(HEIGHT, WIDTH, 3) of F12, after the compositor."""
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(str(path))
    values = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, -1)[..., :3]
    bpy.data.images.remove(image)
    return values


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of 4 × 4 pixels."""
    return picture.reshape(HEIGHT // 4, 4, WIDTH // 4, 4, 3).mean(axis=(1, 3))


def test_the_sum_is_one_render_within_noise(scene, stage, tmp_path):
    fallback.follow(stage.data)
    plain = rendered(scene, tmp_path / "plain.exr")
    assert bpy.ops.sdf_lights.beside_cycles_add() == {"FINISHED"}
    beside = scene.sdf_lights.beside
    beside.sdf_lights.device = "CPU"  # the reference has no light groups
    both = rendered(scene, tmp_path / "both.exr")
    assert beside.sdf_lights.samples == SAMPLES and beside.world is None

    assert bpy.ops.sdf_lights.beside_cycles_remove() == {"FINISHED"}
    again = rendered(scene, tmp_path / "again.exr")
    assert scene.sdf_lights.beside is None and len(bpy.data.scenes) == 1
    np.testing.assert_allclose(again, plain, atol=1e-6)

    scene.render.engine = ENGINE
    bpy.ops.sdf_lights.cycles_settings_copy()
    scene.sdf_lights.device = "CPU"
    one = rendered(scene, tmp_path / "one.exr")
    found, wanted = blocks(both), blocks(one)
    assert wanted.mean() > 0.1
    np.testing.assert_allclose(found.mean(), wanted.mean(), rtol=0.01)
    np.testing.assert_allclose(found, wanted, rtol=0.06, atol=0.02 * wanted.mean())
    assert abs(blocks(plain).mean() - wanted.mean()) > 0.02 * wanted.mean(), "Cycles had a point light there"


def test_a_compositor_and_nodes_of_the_user_stay(scene, stage):
    light, tree = stage.data, beside_cycles._new_tree(scene)
    for node in tree.nodes:
        del node["sdf_lights_beside"]
    blur = tree.nodes.new("CompositorNodeBlur")
    (link,) = tree.links
    source, target = link.from_socket, link.to_socket
    tree.links.new(source, blur.inputs[0])
    tree.links.new(blur.outputs[0], target)
    before = len(tree.nodes)
    for _ in range(2):  # again is an update
        bpy.ops.sdf_lights.beside_cycles_add()
    assert len(tree.nodes) == before + 2 and blur.inputs[0].links[0].from_node.bl_idname == "ShaderNodeMix"
    assert len(bpy.data.scenes) == 2 and len(node_tree_of(light).nodes) == 4
    bpy.ops.sdf_lights.beside_cycles_remove()
    assert len(tree.nodes) == before and blur.inputs[0].links[0].from_node.bl_idname == "CompositorNodeRLayers"
    assert len(node_tree_of(light).nodes) == 2
