# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Skies and IES lights at F12, beside Cycles: what they light is as bright, within 1 %."""

import math

import bpy
import numpy as np
import pytest

from tests.render.ies_files import FILES

pytest.importorskip("_cycles")

SIZE = 32


@pytest.fixture
def both(file, pictures):
    """Pictures (rows, columns, RGB) of this engine and of Cycles, with these samples."""
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = file.scene
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.sdf_lights.device = "CPU"

    def render(samples):
        scene.sdf_lights.samples, scene.sdf_lights.guided_samples = samples, False
        cycles = scene.cycles
        cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
        cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
        found = []
        for scene.render.engine in ("SDF_LIGHTS", "CYCLES"):
            found.append(np.asarray(pictures()["ViewLayer"]["Combined"], float)[..., :3])
        return found

    return render


def sky_world(scene, **properties):
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    for name, value in properties.items():
        setattr(sky, name, value)
    tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    return tree, sky


def models():
    return [item.identifier for item in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items]


@pytest.mark.parametrize("size", [0.009512, 0.2])
@pytest.mark.parametrize("model", models())
def test_a_sky_lights_as_in_cycles(file, add, quad, both, model, size):
    """A floor, and a wall that throws a shadow on it."""
    add("Floor", quad(), scale=(20.0, 20.0, 1.0))
    wall = add("Wall", quad(), scale=(1.0, 1.0, 1.0))
    wall.location, wall.rotation_euler = (0.0, 1.5, 1.0), (math.pi / 2, 0.0, 0.3)
    file.camera.location, file.camera.rotation_euler = (0.0, -6.0, 3.0), (1.2, 0.0, 0.0)
    sky_world(
        file.scene,
        sky_type=model,
        sun_elevation=0.6,
        sun_rotation=1.0,
        sun_size=size,
        sun_direction=(0.5, 0.4, 0.6),
        turbidity=3.0,
    )
    ours, theirs = both(64)
    assert ours.mean(axis=(0, 1)) == pytest.approx(theirs.mean(axis=(0, 1)), rel=0.01)
    # The shape too: the sun's shadow lies where it does there.
    assert np.abs(ours - theirs).mean() < 0.05 * theirs.mean()


def test_an_ies_light_as_in_cycles(file, add, quad, both):
    """A floor under a point light that is turned."""
    add("Floor", quad(), scale=(20.0, 20.0, 1.0))
    file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
    light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    light.data.shadow_soft_size, light.data.energy = 0.0, 50.0
    light.location, light.rotation_euler, light.scale = (0.2, 0.3, 1.0), (0.6, 0.4, 1.0), (1.0, 2.0, 0.5)
    file.scene.collection.objects.link(light)
    light.data.use_nodes = True
    tree = light.data.node_tree
    text = bpy.data.texts.new("lamp.ies")
    text.from_string(FILES["C, all"])
    node = tree.nodes.new("ShaderNodeTexIES")
    node.mode, node.ies = "INTERNAL", text
    tree.links.new(node.outputs["Fac"], tree.nodes["Emission"].inputs["Strength"])
    ours, theirs = both(16)
    np.testing.assert_allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), rtol=0.01)
    assert np.abs(ours - theirs).mean() < 0.02 * theirs.mean()
    assert theirs.max() > 3.0 * np.median(theirs)  # there is a pattern


@pytest.mark.parametrize("kind", ["AREA", "SUN", "SPOT"])
def test_the_uv_coordinates_of_a_light_as_in_cycles(file, add, quad, both, kind):
    """A floor close to an area light whose one side is red and whose other is green, or far under a wide sun."""
    add("Floor", quad(), scale=(20.0, 20.0, 1.0))
    wall = add("Wall", quad(), scale=(1.0, 1.0, 1.0))  # hides a part of the light from a part of the floor
    wall.location, wall.rotation_euler = (0.3, 0.0, 0.5), (math.pi / 2, 0.0, 0.9)
    file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
    data = bpy.data.lights.new("Lamp", kind)
    if kind == "AREA":
        data.shape, data.size, data.size_y = "RECTANGLE", 2.0, 1.0
    elif kind == "SUN":
        data.angle = math.radians(50.0)
    else:
        data.spot_size, data.shadow_soft_size = math.radians(100.0), 0.0
    data.energy = 3.0 if kind == "SUN" else 60.0
    data.use_nodes = True
    tree = data.node_tree
    uv = tree.nodes.new("ShaderNodeTexCoord").outputs["UV"]
    tree.links.new(uv, tree.nodes["Emission"].inputs["Color"])
    lamp = add("Lamp", data)
    lamp.location, lamp.rotation_euler = (0.1, 0.2, 1.2), (0.3, 0.2, 0.7)
    ours, theirs = both(256)
    assert ours.mean(axis=(0, 1))[:2] == pytest.approx(theirs.mean(axis=(0, 1))[:2], rel=0.01)
    assert np.abs(ours - theirs).mean() < 0.04 * theirs.mean()
    assert np.abs(ours[..., 0] - ours[..., 1]).mean() > 0.1 * ours.mean()
