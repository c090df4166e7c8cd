# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes shared by benchmarks, and settings that make two engines do the same work."""

from __future__ import annotations

import functools
import math

import bpy
import host
from mathutils import Vector
from scenery.modelling import add, box, plane, turned

from sdf_lights.blender.shader_trees import use_nodes

DIFFUSE = dict(  # name: colour, centre, half sizes, rotation about z in degrees
    Red=((0.70, 0.15, 0.10), (-1.9, -0.6, 0.35), (0.35, 0.35, 0.35), 20.0),
    Blue=((0.15, 0.25, 0.65), (1.9, 0.9, 0.9), (0.2, 0.2, 0.9), 30.0),
    Green=((0.25, 0.55, 0.20), (0.0, 0.0, 0.3), (0.15, 0.15, 0.3), 10.0),
)


def material(name: str, kind: str, colour, **inputs):
    material = bpy.data.materials.new(name)
    tree = use_nodes(material)
    nodes, links = tree.nodes, tree.links
    nodes.clear()
    closure, output = nodes.new(kind), nodes.new("ShaderNodeOutputMaterial")
    closure.inputs["Color"].default_value = (*colour, 1.0)
    for key, value in inputs.items():
        if hasattr(closure, key):
            setattr(closure, key, value)
        else:
            closure.inputs[key.title()].default_value = value
    links.new(closure.outputs[0], output.inputs["Surface"])
    return material


def empty(size: int, eye, target, degrees: float) -> bpy.types.Scene:
    """Only a camera at ``eye`` that looks at ``target``, with that angle of view; a square picture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    scene = bpy.context.scene
    camera = bpy.data.cameras.new("Camera")
    camera.sensor_fit, camera.angle = "HORIZONTAL", math.radians(degrees)
    thing = add("Camera", camera, location=eye)
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera = thing
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    return scene


def boxes_and_sphere(size: int) -> bpy.types.Scene:
    """Three diffuse boxes and a glossy sphere between a floor and a wall, without a light."""
    scene = empty(size, (0.0, -6.5, 2.6), (0.0, 0.2, 1.0), 42.0)
    diffuse = "ShaderNodeBsdfDiffuse"
    add(
        "Floor",
        plane("Floor", (12.0, 10.0)),
        material("Floor", diffuse, (0.70, 0.68, 0.65)),
        location=(0.0, -2.0, 0.0),
    )
    add(
        "Wall",
        plane("Wall", (12.0, 7.0)),
        material("Wall", diffuse, (0.75, 0.75, 0.75)),
        location=(0.0, 3.0, 3.5),
        rotation=(90, 0, 0),
    )
    for name, (colour, centre, half, turn) in DIFFUSE.items():
        add(
            name,
            box(name, [2.0 * extent for extent in half]),
            material(name, diffuse, colour),
            location=centre,
            rotation=(0, 0, turn),
        )
    steps = 64
    profile = [
        (0.45 * math.sin(math.pi * step / steps), -0.45 * math.cos(math.pi * step / steps)) for step in range(steps + 1)
    ]
    glossy = material("Glossy", "ShaderNodeBsdfAnisotropic", (0.80, 0.75, 0.65), roughness=0.3, distribution="GGX")
    add("Sphere", turned("Sphere", profile, 128), glossy, location=(1.3, -1.4, 0.45))
    return scene


def make_principled() -> None:
    """Let all materials be a Principled BSDF of their colour."""
    for material in bpy.data.materials:
        nodes = material.node_tree.nodes
        color = next(node for node in nodes if "Color" in node.inputs).inputs["Color"].default_value[:]
        nodes.clear()
        surface, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
        surface.inputs["Base Color"].default_value = color
        material.node_tree.links.new(surface.outputs[0], output.inputs[0])


def diffuse(name: str, color):
    return material(name, "ShaderNodeBsdfDiffuse", color)


def room(low, high, color) -> None:
    """Floor, ceiling and four walls that face inwards."""
    material = diffuse("Walls", color)
    size, middle = [b - a for a, b in zip(low, high)], [0.5 * (a + b) for a, b in zip(low, high)]
    x, y, z = size
    for name, extent, axis, end, rotation in (
        ("Floor", (x, y), 2, low[2], (0, 0, 0)),
        ("Ceiling", (x, y), 2, high[2], (180, 0, 0)),
        ("Left", (y, z), 0, low[0], (90, 0, 90)),
        ("Right", (y, z), 0, high[0], (90, 0, -90)),
        ("Back", (x, z), 1, high[1], (90, 0, 0)),
        ("Front", (x, z), 1, low[1], (-90, 0, 0)),
    ):
        location = list(middle)
        location[axis] = end
        add(name, plane(name, extent), material, location=location, rotation=rotation)


def boxes(material, *places) -> None:
    """Boxes by (centre, full size)."""
    for index, (centre, size) in enumerate(places):
        name = f"{material.name} {index}"
        add(name, box(name, size), material, location=centre)


def corridor(size: int) -> bpy.types.Scene:
    """A corridor with doors and a bench, like that of Huang et al. 2026, without a light."""
    scene = empty(size, (0.3, -1.5, 1.5), (-0.1, 4.0, 1.35), 50.0)
    room((-1.1, -2.0, 0.0), (1.1, 9.0, 2.5), (0.72, 0.72, 0.7))
    boxes(
        diffuse("Doors", (0.4, 0.28, 0.2)),
        *(((side * 1.08, y, 1.0), (0.06, 0.9, 2.0)) for side in (-1.0, 1.0) for y in (1.5, 4.5, 7.0)),
    )
    boxes(diffuse("Bench", (0.2, 0.25, 0.4)), ((-0.85, 3.0, 0.22), (0.4, 1.2, 0.44)))
    return scene


def add_point_light(watts: float = 100.0, location=(0.0, -0.5, 3.2)) -> None:
    light = bpy.data.lights.new("Point", "POINT")
    light.energy, light.shadow_soft_size = watts, 0.0
    add("Point", light, location=location)


def enable_cycles() -> None:
    if "cycles" not in bpy.context.preferences.addons:  # again would reset its preferences
        bpy.ops.preferences.addon_enable(module="cycles")


CYCLES_ON_CARDS = ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL")


def _choose_cards(kind: str) -> bool:
    """Let Cycles render on all graphics cards that one of its back ends finds. Returns whether there is one."""
    preferences = bpy.context.preferences.addons["cycles"].preferences
    try:
        preferences.compute_device_type = kind
    except TypeError:  # not in this build of Blender
        return False
    preferences.refresh_devices()
    for device in preferences.devices:
        device.use = device.type == kind
    return any(device.use for device in preferences.devices)


@functools.cache
def cycles_cards() -> tuple[str, ...]:
    """Those back ends of Cycles for graphics cards that find one on this machine."""
    enable_cycles()
    return tuple(filter(_choose_cards, CYCLES_ON_CARDS))


def plain_cycles(scene, samples: int, bounces: int, device: str = "CPU") -> None:
    """Cycles without its defaults that trade error for bias: the same work for each sample. ``device`` is CPU, or one
    of ``cycles_cards``."""
    enable_cycles()
    if device != "CPU":  # each time: a new scene begins with the preferences of the factory, where no card is chosen
        _choose_cards(device)
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = (
        "CPU" if device == "CPU" else "GPU",
        samples,
        False,
        False,
    )
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = (
        0.0
    )
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces


def plain_sdf_lights(scene, samples: int, bounces: int, device: str) -> None:
    """SDF Lights with the same work."""
    scene.render.engine = host.ENGINE
    settings = scene.sdf_lights
    settings.origin = "OWN"  # whether Cycles was there before or not
    settings.device, settings.samples, settings.noise_threshold, settings.denoise = device, samples, 0.0, False
    settings.filter, settings.filter_width = "BOX", 1.0
    settings.indirect_paths, settings.guided_samples = 1, False
    settings.max_bounces = bounces
    settings.diffuse_bounces = settings.glossy_bounces = settings.transmission_bounces = bounces
