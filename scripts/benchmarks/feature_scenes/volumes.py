# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog, and media in closed meshes."""

from __future__ import annotations

import pathlib

import bpy
import host
import numpy as np
from scenery.materials import Graph
from scenery.modelling import add, box
from scenery.staging import light

from .stage import feature, lamp


def _medium(name: str, kind: str, **inputs) -> bpy.types.Material:
    graph = Graph(name)
    return graph.finish(graph.node(f"ShaderNode{kind}", **inputs), "Volume")


@feature("Volumes")
def fog(scene):
    """A world full of fog that scatters forwards."""
    scene.cycles.volume_bounces = 2
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeVolumeScatter")
    node.inputs["Density"].default_value, node.inputs["Anisotropy"].default_value = 0.06, 0.4
    output = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    tree.links.new(node.outputs[0], output.inputs["Volume"])


@feature("Volumes")
def haze_with_a_spot(scene):
    """A box of thin haze, with the cone of a spot and a glowing lamp."""
    scene.cycles.volume_bounces = 1
    add(
        "Haze", box("Haze", (3.6, 3.4, 2.4)), _medium("Haze", "VolumePrincipled", Density=0.25), location=(0, 0.0, 1.25)
    )
    light("Spot", "SPOT", 150.0, (1.0, -0.4, 2.2), (-0.4, 0.4, 0.0), (0.5, 0.8, 1.0), spot_size=0.5, spot_blend=0.2)
    lamp()


@feature("Volumes")
def absorption(scene):
    """A block of coloured glass that absorbs."""
    graph = Graph("Jade")
    glass = graph.node("ShaderNodeBsdfRefraction", Roughness=0.1, IOR=1.3)
    graph.finish(glass)
    output = next(node for node in graph.nodes if node.type == "OUTPUT_MATERIAL")
    graph.links.new(
        graph.node("ShaderNodeVolumeAbsorption", Color=(0.2, 0.8, 0.4), Density=2.0), output.inputs["Volume"]
    )
    bpy.data.objects["Block"].data.materials[0] = graph.material


@feature("Volumes")
def glowing_medium(scene):
    """A ball of a medium that glows and scatters."""
    scene.cycles.volume_bounces = 2
    medium = _medium(
        "Ember",
        "VolumePrincipled",
        Density=2.0,
        Emission_Strength=0.6,
        Emission_Color=(1.0, 0.4, 0.1),
        Color=(0.8, 0.7, 0.6),
    )
    bpy.data.objects["Plastic"].data.materials[0] = medium


def _smoke(graph: Graph, density: float):
    """Principled Volume with puffs of a noise texture."""
    place = graph.node("ShaderNodeTexCoord", "Object")
    noise = graph.node("ShaderNodeTexNoise", Vector=place, Scale=2.5)
    puffs = graph.node("ShaderNodeMapRange", Value=noise, From_Min=0.45, From_Max=0.7, To_Min=0.0, To_Max=density)
    return graph.node("ShaderNodeVolumePrincipled", Density=puffs, Color=(0.8, 0.7, 0.6))


@feature("Volumes")
def smoke_of_noise(scene):
    """A box of smoke whose density is a noise texture, with the cone of a spot and a glowing lamp."""
    scene.cycles.volume_bounces = 2
    graph = Graph("Smoke")
    add("Smoke", box("Smoke", (3.6, 3.4, 2.0)), graph.finish(_smoke(graph, 2.0), "Volume"), location=(0, 0.0, 1.05))
    light("Spot", "SPOT", 150.0, (1.0, -0.4, 2.2), (-0.4, 0.4, 0.0), (0.5, 0.8, 1.0), spot_size=0.5, spot_blend=0.2)
    lamp()


@feature("Volumes")
def ground_fog(scene):
    """A world full of fog that thins out with height."""
    scene.cycles.volume_bounces = 1
    graph = Graph(scene.world)
    graph.finish(graph.node("ShaderNodeBackground", Color=(0.3, 0.4, 0.6), Strength=0.15))
    place = graph.node("ShaderNodeNewGeometry", "Position")
    height = graph.node("ShaderNodeSeparateXYZ", "Z", Vector=place)
    density = graph.node("ShaderNodeMapRange", Value=height, From_Max=1.5, To_Min=0.4, To_Max=0.0)
    output = next(node for node in graph.nodes if node.type == "OUTPUT_WORLD")
    graph.links.new(graph.node("ShaderNodeVolumeScatter", Density=density), output.inputs["Volume"])


@feature("Volumes")
def fire(scene):
    """A ball whose middle glows by a colour ramp and smokes at its border."""
    scene.cycles.volume_bounces = 2
    graph = Graph("Fire")
    place = graph.node("ShaderNodeTexCoord", "Object")
    ball = graph.node("ShaderNodeVectorMath", "Value", operation="LENGTH", _0=place)
    flame = graph.node("ShaderNodeMapRange", Value=ball, From_Min=0.1, From_Max=0.35, To_Min=3.0, To_Max=0.0)
    color = graph.node("ShaderNodeValToRGB", Fac=graph.node("ShaderNodeMath", operation="MULTIPLY", _0=ball, _1=3.0))
    first, last = color.node.color_ramp.elements
    first.color, last.color = (1.0, 0.7, 0.2, 1.0), (1.0, 0.15, 0.02, 1.0)
    medium = graph.node("ShaderNodeVolumePrincipled", Density=3.0, Emission_Strength=flame, Emission_Color=color)
    bpy.data.objects["Plastic"].data.materials[0] = graph.finish(medium, "Volume")


@feature("Volumes")
def cloud_of_voxels(scene):
    """A Volume object: a cloud of 64³ voxels in an OpenVDB file."""
    scene.cycles.volume_bounces = 2
    openvdb = host.program("blender.vdb_files").vdb()
    place = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 64)] * 3, indexing="ij"), -1)
    puffs = sum(np.sin(place * rate + rate).prod(-1) for rate in (5.0, 9.0))
    density = np.clip(6.0 * (1.0 - np.linalg.norm(place, axis=-1)) + 4.0 * puffs, 0.0, None) * (abs(place) < 0.95).all(
        -1
    )
    grid = openvdb.FloatGrid()
    grid.copyFromArray(density.astype(np.float32))
    grid.name, grid.transform = "density", openvdb.createLinearTransform(voxelSize=0.02)
    path = pathlib.Path(bpy.app.tempdir) / "cloud.vdb"
    openvdb.write(str(path), grids=[grid])
    volume = bpy.data.volumes.new("Cloud")
    volume.filepath = str(path)
    volume.materials.append(_medium("Cloud", "VolumePrincipled", Density=2.0, Color=(0.9, 0.9, 0.9), Anisotropy=0.3))
    add("Cloud", volume, location=(-1.1, -0.9, 0.3), rotation=(0, 0, 20))


@feature("Volumes")
def phase_functions(scene):
    """A box of Rayleigh haze."""
    scene.cycles.volume_bounces = 1
    graph = Graph("Rayleigh")
    node = graph.node("ShaderNodeVolumeScatter", Density=0.3)
    if hasattr(node.node, "phase"):
        node.node.phase = "RAYLEIGH"
    add("Haze", box("Haze", (3.6, 3.4, 2.4)), graph.finish(node, "Volume"), location=(0, 0.0, 1.25))
