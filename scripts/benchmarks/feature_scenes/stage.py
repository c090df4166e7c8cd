# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table that all features share, and their register."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import host
from scenery.materials import Graph, principled
from scenery.modelling import add, box, plane, turned
from scenery.staging import camera, glowing, light, world

from benchmarks.simple_scenes import enable_cycles

COMBINED = "Combined"
SIZE = 96  # pixels a side
FRAME = 5  # that is rendered


@dataclass(frozen=True)
class Feature:
    name: str
    group: str
    about: str
    build: Callable[[bpy.types.Scene], None]
    layer: str = ""  # whose picture counts: "" is the view layer, "Composite" is the compositor
    all_passes: bool = False  # whether each pass counts, not only the picture


FEATURES: dict[str, Feature] = {}


def feature(group: str, **settings):
    """Register a function that changes the table, under its own name; its docstring says what is shown."""

    def register(build):
        name = build.__name__.replace("_", " ")
        FEATURES[name] = Feature(name, group, build.__doc__.strip(), build, **settings)
        return build

    return register


def ball(name: str, radius: float, steps: int = 32) -> bpy.types.Mesh:
    angles = [math.pi * step / steps for step in range(steps + 1)]
    return turned(name, [(radius * math.sin(angle), -radius * math.cos(angle)) for angle in angles], 2 * steps)


def build(name: str) -> bpy.types.Scene:
    """Open a new file with the table of a feature: a diffuse block, balls of rough metal, glass and plastic on a floor
    before a wall, under an area light, a point light and a dim world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    enable_cycles()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.use_sequencer = scene.render.use_compositing = False
    add("Floor", plane("Floor", (8.0, 8.0)), principled("Floor", (0.7, 0.68, 0.62), 0.6))
    paint = principled("Wall", (0.5, 0.6, 0.7), 0.8)
    add("Wall", plane("Wall", (8.0, 5.0)), paint, location=(0.0, 1.8, 2.5), rotation=(90, 0, 0))
    clay = Graph("Clay")
    clay.finish(clay.node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.3, 0.2)))
    add("Block", box("Block", (0.7, 0.7, 1.2), 0.03), clay.material, location=(-0.9, 0.6, 0.6), rotation=(0, 0, 25))
    metal = Graph("Metal")
    metal.finish(metal.node("ShaderNodeBsdfAnisotropic", Color=(0.9, 0.75, 0.5), Roughness=0.35, distribution="GGX"))
    add("Metal", ball("Metal", 0.45), metal.material, location=(0.2, 0.7, 0.45))
    glass = Graph("Glass")
    glass.finish(
        glass.node("ShaderNodeBsdfGlass", Color=(0.85, 0.95, 0.9), Roughness=0.25, IOR=1.45, distribution="GGX")
    )
    add("Glass", ball("Glass", 0.35), glass.material, location=(0.9, -0.2, 0.35))
    add("Plastic", ball("Plastic", 0.3), principled("Plastic", (0.1, 0.35, 0.8), 0.3), location=(-0.2, -0.5, 0.3))
    light("Key", "AREA", 90.0, (-1.6, -1.6, 3.0), (0.0, 0.2, 0.4), (1.0, 0.9, 0.8), size=0.9)
    light("Fill", "POINT", 25.0, (1.8, -0.8, 1.8), color=(0.7, 0.8, 1.0), shadow_soft_size=0.2)
    world((0.3, 0.35, 0.45), 0.25)
    camera((0.3, -4.6, 1.9), (0.0, 0.2, 0.55), 38.0)
    scene.frame_set(FRAME)
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    cycles.blur_glossy = cycles.light_sampling_threshold = cycles.sample_clamp_indirect = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 6
    FEATURES[name].build(scene)
    bpy.context.view_layer.update()
    return scene


def lamp(color=(1.0, 0.5, 0.2), strength: float = 6.0) -> bpy.types.Object:
    """A glowing ball."""
    return add("Lamp", ball("Lamp", 0.12, 16), glowing("Lamp", color, strength), location=(0.5, -0.9, 0.9))


def replace(name: str, graph: Graph, closure) -> None:
    """Give an object of the table another material."""
    bpy.data.objects[name].data.materials[0] = graph.finish(closure)
