# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes that vary in space have the brightness that they have in Cycles."""

import bpy
import pytest

from tests.blender.node_trees import new
from tests.blender.volumes import agree, linked, set_world

pytest.importorskip("_cycles")


@pytest.fixture
def cube(add, material):
    """Function: a cube from −1 to 1 around (0, 0, 1), with the volume that ``build(tree) -> socket`` makes."""

    def run(build, **placed):
        mesh = bpy.data.meshes.new("Cube")
        corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        mesh.from_pydata(corners, [], faces)
        made, tree, surface = material("Volume")
        tree.links.new(build(tree), surface.node.inputs["Volume"])
        mesh.materials.append(made)
        return add("Cube", mesh, **{"location": (0.0, 0.0, 1.0), **placed})

    return run


def smoke(tree, coordinates: str = "Object"):
    place = new(tree, "ShaderNodeTexCoord").outputs[coordinates]
    noise = linked(tree, place, "ShaderNodeTexNoise", "Vector", Scale=2.0)
    density = linked(
        tree, noise.outputs[0], "ShaderNodeMapRange", "Value", From_Min=0.4, From_Max=0.65, To_Min=0.0, To_Max=6.0
    )
    volume = linked(
        tree,
        density.outputs[0],
        "ShaderNodeVolumePrincipled",
        "Density",
        Color=(0.8, 0.6, 0.4, 1.0),
        Anisotropy=0.3,
    )
    return volume.outputs[0]


def light(add, kind: str, energy: float, **values):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for name, value in values.items():
        setattr(data, name, value)
    return add(kind, data, (1.5, -1.5, 2.5), (0.6, 0.4, 0.0))


@pytest.mark.parametrize("kind, energy", [("POINT", 200.0), ("SUN", 3.0)])
def test_smoke_of_noise(volume_frame, render, cube, add, kind, energy):
    cube(smoke)
    light(add, kind, energy)
    agree(render, 1500)


@pytest.mark.parametrize("coordinates", ["Generated", "Camera"])
def test_coordinates_of_a_turned_box(volume_frame, render, cube, add, coordinates):
    cube(lambda tree: smoke(tree, coordinates), rotation=(0.3, 0.2, 0.5), scale=(1.2, 1.0, 0.8))
    light(add, "SUN", 3.0)
    volume_frame.cycles.max_bounces = volume_frame.cycles.volume_bounces = 0
    agree(render, 1500)


def test_fog_that_thins_out_with_height(volume_frame, render, cube, add, quad, material):
    def fog(tree):
        position = new(tree, "ShaderNodeNewGeometry").outputs["Position"]
        height = linked(tree, position, "ShaderNodeSeparateXYZ", "Vector").outputs["Z"]
        density = linked(tree, height, "ShaderNodeMapRange", "Value", From_Max=3.0, To_Min=0.1, To_Max=0.0)
        return linked(
            tree, density.outputs[0], "ShaderNodeVolumeScatter", "Density", Color=(0.9, 0.8, 0.7, 1.0)
        ).outputs[0]

    cube(fog, scale=(60.0, 60.0, 2.0))
    add("Floor", quad(), scale=(20.0, 20.0, 1.0))
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000)


def test_colours_that_absorb_along_a_gradient(volume_frame, render, cube):
    def glass(tree):
        place = new(tree, "ShaderNodeTexCoord").outputs["Generated"]
        x = linked(tree, place, "ShaderNodeSeparateXYZ", "Vector").outputs["X"]
        ramp = linked(tree, x, "ShaderNodeValToRGB", "Fac")
        first, last = ramp.color_ramp.elements
        first.color, last.color = (1.0, 0.2, 0.1, 1.0), (0.1, 0.3, 1.0, 1.0)
        return linked(tree, ramp.outputs[0], "ShaderNodeVolumeAbsorption", "Color", Density=1.0).outputs[0]

    cube(glass, rotation=(0.0, 0.0, 0.5), scale=(1.2, 1.0, 0.8))
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    agree(render, 256)


def test_fire_of_a_ramp(volume_frame, render, cube):
    def fire(tree):
        place = new(tree, "ShaderNodeTexCoord").outputs["Object"]
        ball = new(tree, "ShaderNodeTexGradient", gradient_type="SPHERICAL")
        tree.links.new(place, ball.inputs["Vector"])
        ramp = linked(tree, ball.outputs[0], "ShaderNodeValToRGB", "Fac")
        ramp.color_ramp.elements[1].color = (1.0, 0.5, 0.1, 1.0)
        volume = linked(tree, ball.outputs[0], "ShaderNodeVolumePrincipled", "Density", Emission_Strength=2.0)
        tree.links.new(ramp.outputs[0], volume.inputs["Emission Color"])
        return volume.outputs[0]

    cube(fire)
    agree(render, 1000)
