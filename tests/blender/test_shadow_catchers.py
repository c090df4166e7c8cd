# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers have the picture and the pass of Cycles."""

import bpy
import numpy as np
import pytest


@pytest.fixture
def scene(file, add, quad, material):
    """A floor that catches the shadow of a red board and the light of a blue one, under a lamp and a sky."""

    def painted(name: str, color, roughness: float):
        made, tree, output = material(name)
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.inputs["Base Color"].default_value, node.inputs["Roughness"].default_value = color, roughness
        tree.links.new(node.outputs[0], output)
        mesh = quad(name)
        mesh.materials.append(made)
        return mesh

    floor = add("Floor", painted("Floor", (0.8, 0.8, 0.7, 1.0), 0.6), scale=(2.5, 2.5, 1.0))
    floor.is_shadow_catcher = True
    add("Board", painted("Board", (0.8, 0.1, 0.1, 1.0), 0.4), (0.0, 0.5, 0.6), (1.2, 0.0, 0.3), (0.5, 0.6, 1.0))
    glow, tree, output = material("Glow")
    node = tree.nodes.new("ShaderNodeEmission")
    node.inputs["Color"].default_value, node.inputs["Strength"].default_value = (0.2, 0.4, 1.0, 1.0), 3.0
    tree.links.new(node.outputs[0], output)
    mesh = quad("Glow")
    mesh.materials.append(glow)
    add("Glow", mesh, (1.3, 0.6, 0.3), (1.4, 0.0, -0.6), (0.2, 0.2, 1.0))
    light = bpy.data.lights.new("Area", "AREA")
    light.energy, light.size = 120.0, 0.8
    add("Area", light, (-0.8, -0.6, 2.6))
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1.0)
    file.scene.world = world
    file.camera.data.lens = 40.0
    file.scene.render.resolution_x, file.scene.render.resolution_y = 48, 32
    own = file.scene.sdf_lights
    own.device, own.samples, own.filter, own.origin = "CPU", 256, "BOX", "OWN"
    return file.scene


def over(picture: np.ndarray, backdrop: np.ndarray) -> np.ndarray:
    return picture[..., :3] + (1.0 - picture[..., 3:]) * backdrop


@pytest.mark.parametrize(
    ("transparent", "own_pass"),
    [
        (True, True),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in ((True, False), (False, True), (False, False))),
    ],
)
def test_it_is_what_cycles_has(scene, file, pictures, transparent, own_pass):
    compare(scene, file, pictures, transparent, own_pass)


def test_lights_that_do_not_count_for_catchers(scene, file, add, pictures):
    """Their light is added to the picture, with its shadows."""
    spot = bpy.data.lights.new("Spot", "SPOT")
    spot.energy, spot.color, spot.shadow_soft_size = 60.0, (0.2, 1.0, 0.4), 0.2
    add("Spot", spot, (0.9, -0.9, 2.2), (-0.3, 0.3, 0.0)).is_shadow_catcher = False
    compare(scene, file, pictures, True, True)


def compare(scene, file, pictures, transparent, own_pass) -> None:
    """Both engines have the same means of all passes, and of the picture over a backdrop."""
    pytest.importorskip("_cycles")
    bpy.ops.preferences.addon_enable(module="cycles")
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.samples, cycles.blur_glossy, cycles.light_sampling_threshold = 512, 0.0, 0.0
    cycles.sample_clamp_indirect, cycles.pixel_filter_type = 0.0, "BOX"
    scene.render.film_transparent = transparent
    file.layer.cycles.use_pass_shadow_catcher = own_pass
    file.layer.use_pass_diffuse_direct = file.layer.use_pass_emit = file.layer.use_pass_environment = True
    found = {}
    for scene.render.engine in ("SDF_LIGHTS", "CYCLES"):
        found[scene.render.engine] = pictures()["ViewLayer"]
    ours, theirs = found["SDF_LIGHTS"], found["CYCLES"]
    backdrop = np.random.default_rng(1).random(ours["Combined"][..., :3].shape) + 0.2
    named = [*theirs.items(), ("over a picture", over(theirs["Combined"], backdrop))]
    if own_pass:
        shown = {key: over(one["Combined"], backdrop * one["Shadow Catcher"]) for key, one in found.items()}
        named.append(("multiplied", shown["CYCLES"]))
        ours |= {"multiplied": shown["SDF_LIGHTS"]}
    ours |= {"over a picture": over(ours["Combined"], backdrop)}
    for name, expected in named:
        if name == "Noisy Image":
            continue
        right, means = expected.mean((0, 1), dtype=float), ours[name].mean((0, 1), dtype=float)
        assert np.abs(means - right).max() <= 0.01 * np.abs(right).max() + 1e-4, name
    blocks = [one["Combined"].reshape(4, 8, 6, 8, 4).mean((1, 3)) for one in (ours, theirs)]
    assert np.abs(blocks[0] - blocks[1]).max() < 0.03
