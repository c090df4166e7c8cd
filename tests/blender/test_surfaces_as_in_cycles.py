# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that lights shine on directly, from where artists look at them: along floors, and through frosted glass."""

import math

import bpy
import measure_sheen
import numpy as np
import pytest

from sdf_lights.render.tables import sheen

pytest.importorskip("_cycles")

LAYERS = {
    "specular": {"Roughness": 0.5},
    "smooth": {"Roughness": 0.1, "IOR": 1.8},
    "coat": {"Roughness": 0.3, "Coat Weight": 1.0},
}


@pytest.mark.parametrize("name", LAYERS)
def test_what_layers_leave_to_a_floor_seen_at_a_flat_angle(file, render, add, quad, material, name):
    made, tree, output = material()
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for key, value in LAYERS[name].items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Floor", mesh, scale=(40.0, 40.0, 1.0))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.angle = 0.0
    add("Sun", sun, rotation=(0.5, 0.3, 0.0))
    file.scene.cycles.max_bounces = 0
    ours, theirs = (picture[:7, :, 0].mean(1) for picture in render(64))
    assert theirs.min() > 0.02
    assert ours == pytest.approx(theirs, rel=0.004)


def test_the_table_of_sheen_is_that_of_this_cycles(registered):
    np.testing.assert_array_equal(measure_sheen.measure(), np.round(sheen.SCALE * sheen.load()))


@pytest.mark.parametrize("light", ["SUN", "POINT"])
@pytest.mark.parametrize("kind, roughness", [("Sheen", 0.1), ("Sheen", 0.3), ("Sheen", 0.9), ("Principled", 0.5)])
def test_sheen_of_a_floor_seen_at_a_flat_angle(file, render, add, quad, material, kind, roughness, light):
    made, tree, output = material()
    node = tree.nodes.new(f"ShaderNodeBsdf{kind}")
    if kind == "Sheen":
        node.inputs["Roughness"].default_value = roughness
    else:  # above a diffuse surface
        node.inputs["Sheen Weight"].default_value, node.inputs["Sheen Roughness"].default_value = 1.0, roughness
        node.inputs["Specular IOR Level"].default_value = 0.0
    tree.links.new(node.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Floor", mesh, scale=(40.0, 40.0, 1.0))
    lamp = bpy.data.lights.new("Light", light)
    if light == "SUN":
        lamp.angle = 0.0
        add("Light", lamp, rotation=(0.5, 0.3, 0.0))
    else:
        lamp.energy, lamp.shadow_soft_size = 500.0, 0.0
        add("Light", lamp, (1.0, -2.0, 1.0))
    file.scene.cycles.max_bounces = 0
    ours, theirs = (picture[:7, :, 0].mean(1) for picture in render(64))
    assert theirs.min() > 1e-5
    assert ours == pytest.approx(theirs, rel=0.004)


@pytest.mark.parametrize("backfacing", [False, True])
@pytest.mark.parametrize("kind, distribution", [("Glass", "GGX"), ("Refraction", "GGX"), ("Refraction", "BECKMANN")])
def test_a_light_behind_rough_glass(file, render, add, quad, material, kind, distribution, backfacing):
    made, tree, output = material()
    node = tree.nodes.new(f"ShaderNodeBsdf{kind}")
    node.distribution, node.inputs["Roughness"].default_value, node.inputs["IOR"].default_value = distribution, 0.6, 1.5
    tree.links.new(node.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Pane", mesh, (0.0, 0.0, 1.0), (math.pi / 2, 0.0, math.pi * backfacing), (4.0, 4.0, 1.0))
    light = bpy.data.lights.new("Point", "POINT")
    light.energy, light.shadow_soft_size = 500.0, 0.0
    add("Light", light, (0.0, 1.0, 1.0))
    file.scene.cycles.max_bounces = 0
    ours, theirs = (picture[..., 0].reshape(4, 4, 6, 4).mean((1, 3)) for picture in render(256))
    assert theirs.mean() > 0.1
    assert ours == pytest.approx(theirs, rel=0.02, abs=1e-3)


def test_glowing_faces_do_not_light_themselves(file, render, material):
    # Nothing lights a convex body that glows: it is as bright as it glows.
    made, tree, output = material()
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Emission Strength"].default_value, node.inputs["Specular IOR Level"].default_value = 1.0, 0.0
    tree.links.new(node.outputs[0], output)
    bpy.ops.mesh.primitive_ico_sphere_add(
        subdivisions=1, radius=1.5, location=(0.1, 0.2, 1.3), rotation=(0.3, 0.5, 0.7)
    )
    bpy.context.object.data.materials.append(made)
    file.scene.cycles.max_bounces = 0
    ours, theirs = (picture[..., 0] / np.maximum(picture[..., 3], 0.5) for picture in render(64))
    assert theirs.max() == pytest.approx(1.0, rel=1e-4)
    assert ours.max() == pytest.approx(1.0, rel=1e-4)
