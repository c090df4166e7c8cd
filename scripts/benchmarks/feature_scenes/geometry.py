# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair, points, displacement, catchers and holdouts."""

from __future__ import annotations

import bpy
import numpy as np
from scenery.materials import Graph, principled
from scenery.modelling import add

from .stage import ball, feature, replace


def _curves(shape: str) -> None:
    """Wavy strands on the floor, thinner towards their tips, of the shape of Cycles' curves."""
    bpy.context.scene.cycles_curves.shape = shape
    random = np.random.default_rng(1)
    count, points = 150, 6
    t = np.linspace(0.0, 1.0, points)[None, :, None]
    root = np.concatenate([random.uniform(-0.5, 0.5, (count, 2)), np.zeros((count, 1))], 1)[:, None]
    bend = random.normal(0.0, 0.2, (count, 1, 3))
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([points] * count)
    places = root + t * (0.0, 0.0, 0.8) + bend * t * t
    data.points.foreach_set("position", places.astype(np.float32).ravel())
    radii = np.broadcast_to(0.02 * (1.0 - 0.8 * t[..., 0]), (count, points))
    data.points.foreach_set("radius", radii.astype(np.float32).ravel())
    add("Hair", data, principled("Straw", (0.7, 0.5, 0.15), 0.5), location=(0.3, -0.6, 0.0))


@feature("Geometry")
def hair_as_ribbons(scene):
    """Hair curves with the shape Rounded Ribbons."""
    _curves("RIBBONS")


@feature("Geometry")
def hair_as_tubes(scene):
    """Hair curves with the shape 3D Curves."""
    _curves("THICK")


def fur() -> bpy.types.Object:
    """The plastic ball, with particle hair."""
    thing = bpy.data.objects["Plastic"]
    thing.data.materials.append(principled("Fur", (0.5, 0.25, 0.1), 0.6))
    settings = thing.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 300, 0.3, 4
    settings.render_step, settings.root_radius, settings.tip_radius = 3, 3.0, 0.5
    settings.material, settings.brownian_factor = 2, 0.05
    return thing


@feature("Geometry")
def particle_hair(scene):
    """A ball with a particle system of hair, in the material of another slot."""
    fur()


@feature("Geometry")
def points(scene):
    """A point cloud, made by Geometry Nodes from the vertices of a ball."""
    thing = add(
        "Points", ball("Points", 0.5, 8), principled("Pearl", (0.8, 0.7, 0.75), 0.25), location=(0.3, -0.6, 0.6)
    )
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    made, dress = tree.nodes.new("GeometryNodeMeshToPoints"), tree.nodes.new("GeometryNodeSetMaterial")
    made.inputs["Radius"].default_value = 0.05
    dress.inputs["Material"].default_value = thing.data.materials[0]
    for source, target in ((start, made), (made, dress), (dress, end)):
        tree.links.new(source.outputs[0], target.inputs[0])
    thing.modifiers.new("Points", "NODES").node_group = tree


def _waves(method: str):
    """The block's neighbour, a fine ball whose surface is displaced by waves."""
    graph = Graph("Waves")
    wave = graph.node("ShaderNodeTexWave", "Fac", Vector=graph.node("ShaderNodeTexCoord", "Generated"), Scale=1.5)
    graph.finish(graph.node("ShaderNodeDisplacement", Height=wave, Scale=0.12), "Displacement")
    output = next(node for node in graph.nodes if node.type == "OUTPUT_MATERIAL")
    graph.links.new(graph.node("ShaderNodeBsdfDiffuse", Color=(0.3, 0.6, 0.4)), output.inputs["Surface"])
    graph.material.displacement_method = method
    return add("Waves", ball("Waves", 0.5, 48), graph.material, location=(0.3, -0.5, 0.6))


@feature("Geometry")
def displacement(scene):
    """A ball that is displaced, as its mesh has vertices."""
    _waves("DISPLACEMENT")


@feature("Geometry")
def displacement_and_bump(scene):
    """A ball that is displaced, and bumped between its vertices."""
    _waves("BOTH")


@feature("Geometry")
def adaptive_subdivision(scene):
    """A coarse ball, divided as far as its pixels need, then displaced."""
    thing = _waves("DISPLACEMENT")
    thing.data = ball("Coarse", 0.5, 6)
    thing.data.materials.append(bpy.data.materials["Waves"])
    if bpy.app.version < (5, 0, 0):
        scene.cycles.feature_set = "EXPERIMENTAL"
    modifier = thing.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 4
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    elif hasattr(thing.cycles, "use_adaptive_subdivision"):
        thing.cycles.use_adaptive_subdivision = True


@feature("Geometry")
def shadow_catcher(scene):
    """A floor that only catches shadows, with a transparent film."""
    bpy.data.objects["Floor"].is_shadow_catcher = True
    scene.render.film_transparent = True


@feature("Geometry")
def holdout(scene):
    """A block that makes a hole in the picture."""
    bpy.data.objects["Block"].is_holdout = True
    scene.render.film_transparent = True


@feature("Geometry")
def alpha(scene):
    """A ball that is transparent by half, with a coloured shadow."""
    graph = Graph("Veil")
    clear = graph.node("ShaderNodeBsdfTransparent", Color=(0.4, 0.9, 0.5))
    solid = graph.node("ShaderNodeBsdfDiffuse", Color=(0.9, 0.9, 0.3))
    replace("Plastic", graph, graph.node("ShaderNodeMixShader", _0=0.5, _1=clear, _2=solid))


@feature("Geometry")
def simplify(scene):
    """Simplify: textures and subdivisions are limited, far objects are culled."""
    scene.render.use_simplify, scene.render.simplify_subdivision_render = True, 1
    modifier = bpy.data.objects["Block"].modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 4
    scene.cycles.use_distance_cull, scene.cycles.distance_cull_margin = True, 5.2
    bpy.data.objects["Metal"].cycles.use_distance_cull = True
