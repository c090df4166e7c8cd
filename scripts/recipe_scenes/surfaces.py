# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that several recipes have."""

from __future__ import annotations

import bpy
import numpy as np
from scenery import textures
from scenery.materials import Graph, image, principled
from scenery.modelling import add, plane


def brick(name: str, color=(0.22, 0.09, 0.06), mortar=(0.12, 0.11, 0.10)) -> bpy.types.Material:
    """Bricks of 22 cm on a wall whose own x and y are in metres."""
    graph = Graph(name)
    place = graph.node("ShaderNodeTexCoord", "Object")
    dark = tuple(0.55 * part for part in color)
    pattern = graph.nodes.new("ShaderNodeTexBrick")
    graph.links.new(place, pattern.inputs["Vector"])
    for socket, value in (("Color1", color), ("Color2", dark), ("Mortar", mortar)):
        pattern.inputs[socket].default_value = (*value, 1.0)
    for socket, value in (("Scale", 1.0), ("Mortar Size", 0.006), ("Brick Width", 0.22), ("Row Height", 0.075)):
        pattern.inputs[socket].default_value = value
    grain = graph.node("ShaderNodeTexNoise", Vector=place, Scale=22.0, Detail=4.0)
    joints = graph.bump(graph.node("ShaderNodeMath", operation="SUBTRACT", _0=1.0, _1=pattern.outputs["Fac"]), 0.01)
    rough = graph.node("ShaderNodeBump", Height=grain, Distance=0.006, Normal=joints)
    return graph.finish(
        graph.node("ShaderNodeBsdfPrincipled", Base_Color=pattern.outputs["Color"], Roughness=0.7, Normal=rough)
    )


def wet(name: str, color=(0.02, 0.02, 0.023), scale: float = 0.7, gloss=(0.04, 0.5)) -> bpy.types.Material:
    """A dark ground with puddles: its roughness goes from the first to the second of ``gloss``."""
    graph = Graph(name)
    place = graph.node("ShaderNodeTexCoord", "Object")
    puddles = graph.node("ShaderNodeTexNoise", Vector=place, Scale=scale, Detail=4.0)
    roughness = graph.node("ShaderNodeMapRange", Value=puddles, _1=0.42, _2=0.62, _3=gloss[0], _4=gloss[1])
    grain = graph.node("ShaderNodeTexNoise", Vector=place, Scale=70.0, Detail=3.0)
    depth = graph.node("ShaderNodeMath", operation="MULTIPLY", _0=grain, _1=roughness)
    return graph.finish(
        graph.node("ShaderNodeBsdfPrincipled", Base_Color=color, Roughness=roughness, Normal=graph.bump(depth, 0.02))
    )


def water(name: str, color, roughness: float, scale: float, bump: float, strength: float) -> bpy.types.Material:
    """Dark water with small waves; ``bump`` is their height in metres."""
    graph = Graph(name)
    waves = graph.node("ShaderNodeTexNoise", Vector=graph.node("ShaderNodeTexCoord", "Object"), Scale=scale, Detail=2.0)
    return graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=color,
            Roughness=roughness,
            Normal=graph.bump(waves, bump, strength),
        )
    )


def marble(roughness: float) -> bpy.types.Material:
    """Polished marble."""
    graph = Graph("Marble")
    color = graph.texture(image("Marble", textures.marble(512), True))
    return graph.finish(graph.node("ShaderNodeBsdfPrincipled", Base_Color=color, Roughness=roughness))


def wood(name: str, light=(0.36, 0.22, 0.14), dark=(0.17, 0.09, 0.05), roughness: float = 0.35) -> bpy.types.Material:
    """Wood on the UV map, in metres."""
    graph = Graph(name)
    grain = image(name, textures.wood(512, 5, light, dark), True)
    return graph.finish(graph.node("ShaderNodeBsdfPrincipled", Base_Color=graph.texture(grain), Roughness=roughness))


def stone(name: str, color=(0.16, 0.15, 0.14), scale: float = 3.0, depth: float = 0.05) -> bpy.types.Material:
    """Rough stone."""
    graph = Graph(name)
    place = graph.node("ShaderNodeTexCoord", "Object")
    noise = graph.node("ShaderNodeTexNoise", Vector=place, Scale=scale, Detail=8.0, Roughness=0.6)
    dark = tuple(0.4 * part for part in color)
    tone = graph.node("ShaderNodeMix", data_type="RGBA", _0=noise, _1=dark, _2=color)
    return graph.finish(
        graph.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.8, Normal=graph.bump(noise, depth))
    )


def glass(name: str, color=(1.0, 1.0, 1.0), roughness: float = 0.0, ior: float = 1.5) -> bpy.types.Material:
    graph = Graph(name)
    return graph.finish(graph.node("ShaderNodeBsdfGlass", Color=color, Roughness=roughness, IOR=ior))


def metal(name: str, color=(0.5, 0.5, 0.5), roughness: float = 0.25) -> bpy.types.Material:
    return principled(name, color, roughness, Metallic=1.0)


def floor(material: bpy.types.Material, size=(20.0, 20.0), location=(0.0, 0.0, 0.0)) -> bpy.types.Object:
    return add("Floor", plane("Floor", size), material, location=location)


def wall(material: bpy.types.Material, y: float, size=(20.0, 8.0), bottom: float = 0.0) -> bpy.types.Object:
    """A wall across the view that faces -y."""
    return add("Wall", plane("Wall", size), material, location=(0.0, y, bottom + 0.5 * size[1]), rotation=(90, 0, 0))


def backdrop(material: bpy.types.Material, y: float = 1.6, radius: float = 0.8) -> bpy.types.Object:
    """A floor that bends up into a wall."""
    angles = np.linspace(0.0, 0.5 * np.pi, 24)
    profile = [(-6.0, 0.0), *((y - radius + radius * np.sin(a), radius - radius * np.cos(a)) for a in angles), (y, 6.0)]
    mesh = bpy.data.meshes.new("Backdrop")
    vertices = [(x, along, up) for along, up in profile for x in (-8.0, 8.0)]
    faces = [(2 * row, 2 * row + 1, 2 * row + 3, 2 * row + 2) for row in range(len(profile) - 1)]
    mesh.from_pydata(vertices, [], faces)
    mesh.shade_smooth()
    return add("Backdrop", mesh, material)


def fog(density: float, color=(0.9, 0.9, 1.0), ambient=(0.0, 0.0, 0.0), strength: float = 1.0, anisotropy: float = 0.2):
    """A world of one colour, filled with fog."""
    from scenery.staging import world

    graph = world(ambient, strength)
    output = next(node for node in graph.nodes if node.bl_idname == "ShaderNodeOutputWorld")
    mist = graph.node("ShaderNodeVolumeScatter", Color=color, Density=density, Anisotropy=anisotropy)
    graph.links.new(mist, output.inputs["Volume"])
