# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that are copied from Cycles do here what they do there: a room has the same picture."""

import math

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")


@pytest.fixture
def room(file, add, quad, material):
    """A diffuse floor and wall, a wall of rough metal, a bar of glass and a stack of clear sheets under an area
    light."""
    bpy.ops.preferences.addon_enable(module="cycles")

    def surface(name: str, kind: str, **inputs):
        made, tree, output = material(name)
        node = tree.nodes.new(f"ShaderNode{kind}")
        if hasattr(node, "distribution"):
            node.distribution = "GGX"
        for key, value in inputs.items():
            node.inputs[key].default_value = value
        tree.links.new(node.outputs[0], output)
        mesh = quad(name)
        mesh.materials.append(made)
        return mesh

    half = math.pi / 2
    grey = dict(Color=(0.8, 0.7, 0.6, 1.0))
    add("Floor", surface("Floor", "BsdfDiffuse", **grey), scale=(2.0, 2.0, 1.0))
    add("Wall", surface("Wall", "BsdfDiffuse", **grey), (0.0, 2.0, 1.0), (half, 0.0, 0.0), (2.0, 2.0, 1.0))
    add(
        "Metal",
        surface("Metal", "BsdfGlossy", Color=(0.9, 0.9, 0.9, 1.0), Roughness=0.4),
        (2.0, 0.0, 1.0),
        (half, 0.0, half),
        (2.0, 2.0, 1.0),
    )
    glass = surface("Glass", "BsdfRefraction", Color=(0.9, 0.9, 0.9, 1.0), Roughness=0.4, IOR=1.2)
    add("Glass", glass, (-1.0, 0.0, 0.8), scale=(1.0, 1.0, 1.0))
    clear = surface("Clear", "BsdfTransparent", Color=(0.7, 0.8, 0.9, 1.0))
    for i in range(3):
        add(f"Clear {i}", clear, (-1.0, -2.0 - 0.3 * i, 1.0), (half, 0.0, 0.0), (1.0, 0.7, 1.0))
    light = bpy.data.lights.new("Area", "AREA")
    light.energy, light.size = 60.0, 1.0
    add("Area", light, (0.0, 0.0, 2.5))
    file.camera.data.lens = 35.0
    cycles = file.scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.samples, cycles.blur_glossy, cycles.light_sampling_threshold = 1024, 0.0, 0.0
    cycles.sample_clamp_indirect, cycles.pixel_filter_type, cycles.max_bounces = 0.0, "BOX", 4
    return file.scene


# Settings of Cycles, and by how much of its mean each changes the picture at least: 0 for the room itself. With
# roulette after one bounce, as by default in Cycles, some light is brighter and rarer, so a strong clamp takes more.
CASES = {
    "as it is": (dict(), 0.0),
    "clamp of direct light": (dict(sample_clamp_direct=0.25), 0.05),
    "clamp of indirect light": (dict(sample_clamp_indirect=0.05, min_light_bounces=4), 0.02),
    "no reflective caustics": (dict(caustics_reflective=False), 0.02),
    "no refractive caustics": (dict(caustics_refractive=False), 0.02),
    "no caustics": (dict(caustics_reflective=False, caustics_refractive=False), 0.04),
    "no bounce": (dict(max_bounces=0), 0.1),
    "one diffuse bounce": (dict(diffuse_bounces=1), 0.01),
    "no glossy bounce": (dict(glossy_bounces=0), 0.01),
    "no transmission": (dict(transmission_bounces=0), 0.01),
    "three sheets": (dict(transparent_max_bounces=3), 0.0),
    "two sheets": (dict(transparent_max_bounces=2), 0.01),
    "no sheet": (dict(transparent_max_bounces=0), 0.01),
    "exposure": (dict(film_exposure=2.0), 0.5),
}


_plain: dict[str, dict] = {}  # both pictures of the room as it is, which every case needs


@pytest.fixture
def both(room, pictures):
    """Function: the pictures of the room by both engines."""

    def run() -> dict[str, np.ndarray]:
        result = {}
        for room.render.engine in ("CYCLES", "SDF_LIGHTS"):
            bpy.ops.sdf_lights.cycles_settings_copy()
            room.sdf_lights.device = "CPU"
            result[room.render.engine] = pictures()["ViewLayer"]["Combined"][..., :3].astype(float)
        return result

    return run


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_setting_does_what_it_does_in_cycles(room, both, name):
    changes, least = CASES[name]
    plain = _plain.get("room") or both()
    _plain["room"] = plain
    for key, value in changes.items():
        setattr(room.cycles, key, value)
    compare(name, plain, both() if changes else plain, least)


# Inputs of the Principled BSDF of all that is solid in the room.
LAYERS = {
    "specular": {},
    "half metal": {"Metallic": 0.5},
    "coat": {"Coat Weight": 1.0},
    "film": {"Thin Film Thickness": 400.0},
    "half glass": {"Transmission Weight": 0.5},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LAYERS)
def test_layers_that_reflect_no_caustics_are_not_there(room, both, name):
    for made in ("Floor", "Wall", "Metal"):
        tree = bpy.data.materials[made].node_tree
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.inputs["Base Color"].default_value, node.inputs["Roughness"].default_value = (0.8, 0.7, 0.6, 1.0), 0.4
        for key, value in LAYERS[name].items():
            node.inputs[key].default_value = value
        output = next(each for each in tree.nodes if each.type == "OUTPUT_MATERIAL")
        tree.links.new(node.outputs[0], output.inputs["Surface"])
    plain = both()
    room.cycles.caustics_reflective = room.cycles.caustics_refractive = False
    compare(f"no caustics, {name}", plain, both(), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("roughness", [0.0, 0.2])
def test_filter_glossy_blurs_what_it_blurs_in_cycles(room, both, roughness):
    # Not refraction: Cycles adds light rays to it that no microfacet refracts, the more the rougher it is.
    bpy.data.objects.remove(bpy.data.objects["Glass"])
    nodes = bpy.data.materials["Metal"].node_tree.nodes
    next(node for node in nodes if node.type == "BSDF_GLOSSY").inputs["Roughness"].default_value = roughness
    plain = both()
    room.cycles.blur_glossy = 1.0
    compare(f"filter glossy, roughness {roughness}", plain, both(), 0.02)


def compare(name: str, plain: dict, found: dict, least: float) -> None:
    """Both engines agree, and the picture has changed by ``least`` of its mean."""
    ours, theirs = found["SDF_LIGHTS"], found["CYCLES"]
    change = abs(theirs.mean() / plain["CYCLES"].mean() - 1.0)
    print(f"{name}: {ours.mean() / theirs.mean() - 1.0:+.4f}, changed by {change:.4f}")
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)
    assert change >= least
    blocks = [picture.reshape(4, 4, 6, 4, 3).mean((1, 3)) for picture in (ours, theirs)]
    assert np.abs(blocks[0] - blocks[1]).mean() < 0.02 * theirs.mean()
