# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Powers, colours and emissions that are infinite, huge or no numbers: every pixel is finite, and one sentence says
why."""

import warnings

import bpy
import numpy as np
import pytest

HUGE = 3.4e38


def _material(color=(1.0, 1.0, 1.0), strength=1.0):
    material = bpy.data.materials.new("Bright")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value, emission.inputs["Strength"].default_value = (*color, 1.0), strength
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    for obj in bpy.data.objects:
        if obj.type == "MESH":
            obj.data.materials.clear()
            obj.data.materials.append(material)


def _light(add, kind="AREA", color=(1.0, 1.0, 1.0), energy=100.0):
    data = bpy.data.lights.new("Bright", kind)
    data.color, data.energy = color, energy
    add("Bright", data, location=(0.0, -2.0, 2.0))
    return data


def _nodes_of(data, value):
    data.use_nodes = True
    name = "Background" if isinstance(data, bpy.types.World) else "Emission"
    data.node_tree.nodes[name].inputs["Strength"].default_value = value


@pytest.mark.parametrize("device", ["REFERENCE", "CPU"])
@pytest.mark.parametrize("value", [pytest.param(float("inf"), marks=pytest.mark.slow), HUGE, float("nan")])
@pytest.mark.parametrize(
    "what",
    ["power", "colour of a light", "colour of a lamp", "strength", "colour of a material", "world", "nodes of a light"],
)
def test_pixels_stay_finite(file, stage, add, lamp, pictures, capfd, what, value, device):
    file.scene.sdf_lights.device = device
    if what == "power":
        _light(add, energy=value)
    elif what == "colour of a light":
        _light(add, color=(value, 1.0, 1.0))
    elif what == "colour of a lamp":
        data = lamp()
        data.color = (value, 1.0, 1.0)
        add("Bright", data, location=(0.0, -2.0, 1.0))
    elif what == "strength":
        _material(strength=value)
    elif what == "colour of a material":
        _material((value, 1.0, 1.0))
    elif what == "world":
        file.scene.world = bpy.data.worlds.new("Bright")
        _nodes_of(file.scene.world, value)
    else:
        _nodes_of(_light(add), value)
    capfd.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # those of NumPy
        picture = pictures()["ViewLayer"]["Combined"]
    output = capfd.readouterr()
    assert np.isfinite(picture).all()
    assert "Traceback" not in output.out + output.err and "unexpected" not in output.out
    assert sum(line.startswith("Warning: ") for line in output.out.splitlines()) <= 1


@pytest.mark.parametrize("device", ["REFERENCE", "CPU"])
@pytest.mark.parametrize("kind", ["Sheen", "Glossy", "Glass"])
def test_pixels_stay_finite_where_a_roughness_is_no_number(file, stage, add, quad, material, pictures, kind, device):
    file.scene.sdf_lights.device = device
    made, tree, output = material()
    node, roughness = tree.nodes.new(f"ShaderNodeBsdf{kind}"), tree.nodes.new("ShaderNodeAttribute")
    roughness.attribute_name = "roughness"
    tree.links.new(roughness.outputs["Fac"], node.inputs["Roughness"])
    tree.links.new(node.outputs[0], output)
    mesh = quad()
    mesh.attributes.new("roughness", "FLOAT", "POINT").data.foreach_set("value", [float("nan")] * 4)
    mesh.materials.append(made)
    add("Rough", mesh, (0.0, 0.0, 0.01), scale=(5.0, 5.0, 1.0))
    assert np.isfinite(pictures()["ViewLayer"]["Combined"]).all()


def test_more_threads_than_there_is_work(file, stage, pictures):
    file.scene.sdf_lights.device = "CPU"
    few = pictures()["ViewLayer"]["Combined"]
    file.scene.render.threads_mode, file.scene.render.threads = "FIXED", 1024
    assert np.array_equal(pictures()["ViewLayer"]["Combined"], few)
