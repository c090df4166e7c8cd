# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the scene and of view layers that change the picture."""

from __future__ import annotations

import bpy
from scenery.materials import Graph, principled

from .stage import feature, replace


@feature("Settings")
def clamps(scene):
    """Clamped direct and indirect light."""
    scene.cycles.sample_clamp_direct, scene.cycles.sample_clamp_indirect = 1.5, 0.3


@feature("Settings")
def bounces(scene):
    """Limits of bounces by kind."""
    cycles = scene.cycles
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 3, 1, 1, 2


@feature("Settings")
def caustics_off(scene):
    """Neither reflective nor refractive caustics."""
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False


@feature("Settings")
def filter_glossy(scene):
    """Filter Glossy of Cycles' default, with a sharp mirror ball."""
    graph = Graph("Mirror")
    replace("Metal", graph, graph.node("ShaderNodeBsdfAnisotropic", Color=(0.9, 0.9, 0.9), Roughness=0.05))
    scene.cycles.blur_glossy = 1.0


@feature("Settings")
def transparent_bounces(scene):
    """Sheets of a transparent material, of which two are passed."""
    graph = Graph("Veil")
    clear = graph.node("ShaderNodeBsdfTransparent", Color=(0.7, 0.9, 0.7))
    solid = graph.node("ShaderNodeBsdfDiffuse", Color=(0.9, 0.9, 0.3))
    replace("Glass", graph, graph.node("ShaderNodeMixShader", _0=0.3, _1=clear, _2=solid))
    scene.cycles.transparent_max_bounces = 2


@feature("Settings")
def film(scene):
    """Exposure, a transparent film with transparent glass, and a wide Blackman-Harris filter."""
    scene.cycles.film_exposure, scene.cycles.pixel_filter_type, scene.cycles.filter_width = 1.7, "BLACKMAN_HARRIS", 2.5
    scene.render.film_transparent = scene.cycles.film_transparent_glass = True


@feature("View layer")
def material_override(scene):
    """One material for all objects."""
    bpy.context.view_layer.material_override = principled("Grey", (0.5, 0.5, 0.5), 0.5)


@feature("View layer")
def without_sky(scene):
    """A view layer without its sky."""
    bpy.context.view_layer.use_sky = False


@feature("View layer")
def excluded_and_indirect_only(scene):
    """A collection whose objects are seen only in reflections and in bounced light, and one that holds out."""
    layer = bpy.context.view_layer
    for name, thing, flag in (("Indirect", "Block", "indirect_only"), ("Mask", "Plastic", "holdout")):
        group = bpy.data.collections.new(name)
        scene.collection.children.link(group)
        moved = bpy.data.objects[thing]
        group.objects.link(moved)
        scene.collection.objects.unlink(moved)
        setattr(layer.layer_collection.children[name], flag, True)
