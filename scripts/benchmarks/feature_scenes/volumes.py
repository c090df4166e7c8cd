# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog, and media in closed meshes."""

from __future__ import annotations

import bpy
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


@feature("Volumes")
def phase_functions(scene):
    """A box of Rayleigh haze."""
    scene.cycles.volume_bounces = 1
    graph = Graph("Rayleigh")
    node = graph.node("ShaderNodeVolumeScatter", Density=0.3)
    if hasattr(node.node, "phase"):
        node.node.phase = "RAYLEIGH"
    add("Haze", box("Haze", (3.6, 3.4, 2.4)), graph.finish(node, "Volume"), location=(0, 0.0, 1.25))
