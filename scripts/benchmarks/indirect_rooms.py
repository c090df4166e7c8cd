# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms that lamps light by way of walls."""

from __future__ import annotations

import math

import bpy
from scenery.modelling import add, box, plane

from sdf_lights.blender.shader_trees import use_nodes

from . import lamp_meshes, simple_scenes
from .lamp_scenes import INTENSITY, add_lamp, marched, show, turned

SIZE = 4.0, 5.0, 2.6  # metres of a room; the camera stands at the end of −y
THICK = 0.1  # of walls


def _paint(name: str, colour=(0.75, 0.73, 0.70)):
    return simple_scenes.material(name, "ShaderNodeBsdfDiffuse", colour)


def _slab(name: str, size, at, material, turn: float = 0.0) -> None:
    add(name, box(name, size), material, location=at, rotation=(0.0, 0.0, turn))


def _room(size: int, extent=SIZE) -> None:
    """A closed room with a table, a camera at one end of it."""
    x, y, z = extent
    simple_scenes.empty(size, (0.0, 0.2 - 0.5 * y, 1.4), (0.0, 0.5 * y, 1.2), 70.0)
    wall, floor = _paint("Wall"), _paint("Floor", (0.45, 0.33, 0.22))
    _slab("Floor", (x, y, THICK), (0.0, 0.0, -0.5 * THICK), floor)
    _slab("Ceiling", (x, y, THICK), (0.0, 0.0, z + 0.5 * THICK), wall)
    for side in (-1.0, 1.0):
        _slab("Side", (THICK, y, z), (side * 0.5 * (x + THICK), 0.0, 0.5 * z), wall)
        _slab("End", (x, THICK, z), (0.0, side * 0.5 * (y + THICK), 0.5 * z), wall)
    _slab("Table", (0.9, 0.6, 0.05), (-0.6, 0.6, 0.7), _paint("Wood", (0.5, 0.3, 0.15)), 20.0)
    _slab("Foot", (0.1, 0.1, 0.7), (-0.6, 0.6, 0.35), _paint("Iron", (0.2, 0.2, 0.2)), 20.0)


def _ledge(size: int) -> None:
    """A room with a ledge under the ceiling, to hide a light."""
    _room(size)
    white = _paint("Plaster", (0.8, 0.8, 0.8))
    _slab("Ledge", (4.0, 0.25, 0.03), (0.0, 2.375, 2.2), white)
    _slab("Lip", (4.0, 0.03, 0.12), (0.0, 2.25, 2.26), white)


def _cove(size: int) -> None:
    _ledge(size)
    add_lamp(
        "Tube",
        "box(1.8, 0.015, 0.015)",
        lamp_meshes.box((1.8, 0.015, 0.015)),
        turned(at=(0.0, 2.37, 2.25)),
        INTENSITY / 0.00324,
    )


def _shade(size: int) -> None:
    _room(size)
    cloth = _paint("Cloth", (0.8, 0.6, 0.4))
    for number in range(12):
        angle = 2.0 * math.pi * number / 12
        at = 0.2 * math.cos(angle), 1.0 + 0.2 * math.sin(angle), 1.5
        _slab("Shade", (0.01, 0.108, 0.3), at, cloth, math.degrees(angle))
    add_lamp("Bulb", "sphere(0.05)", lamp_meshes.sphere(0.05, 64, 32), turned(at=(0.0, 1.0, 1.5)), INTENSITY / 0.000524)


def _sign(size: int) -> None:
    _room(size)
    for row in range(20):
        for column in range(10):
            at = -1.8 + 0.4 * column + 0.2 * (row % 2), 2.48, 0.065 + 0.13 * row
            _slab("Brick", (0.38, 0.04, 0.115), at, _paint(f"Brick {row % 3}", (0.35 + 0.05 * (row % 3), 0.12, 0.08)))
    stroke = marched("capsule(0.2, 0.012)")
    for number, turn in enumerate((0.0, 60.0, -60.0, 90.0, 30.0)):
        matrix = turned(y=turn, at=(-1.0 + 0.5 * number, 2.42, 1.5))
        add_lamp(f"Stroke {number}", "capsule(0.2, 0.012)", stroke, matrix, INTENSITY / 0.0009, (1.0, 0.2, 0.4))


def _half_open(size: int) -> None:
    """A room with a half-open door to another one."""
    _room(size)
    wall = _paint("Partition")
    _slab("Left", (2.6, 0.08, 2.6), (-0.7, 1.5, 1.3), wall)
    _slab("Right", (0.5, 0.08, 2.6), (1.75, 1.5, 1.3), wall)
    _slab("Above", (0.9, 0.08, 0.6), (1.05, 1.5, 2.3), wall)
    _slab("Door", (0.9, 0.04, 2.0), (0.82, 1.87, 1.0), _paint("Door", (0.6, 0.6, 0.65)), 120.0)


def _door(size: int) -> None:
    _half_open(size)
    add_lamp(
        "Lamp",
        "torus(0.15, 0.03)",
        lamp_meshes.torus(0.15, 0.03, 64, 32),
        turned(at=(-1.2, 2.0, 1.8)),
        INTENSITY / 0.00266,
    )


def _corridor(size: int) -> None:
    _room(size, (2.2, 16.0, 2.6))
    metal = _paint("Baffle", (0.7, 0.7, 0.7))
    for number in range(20):
        side = -1.0 if number % 2 else 1.0
        y = -6.5 + 1.45 * (number // 2)
        _slab("Baffle", (0.02, 0.3, 0.3), (side * 0.9, y, 2.0), metal)
        at = turned(at=(side * 1.0, y, 2.0))
        add_lamp(f"Lamp {number}", "sphere(0.04)", lamp_meshes.sphere(0.04, 32, 16), at, 0.2 * INTENSITY / 0.000268)


def _add_light(kind: str, at, power: float, turn: float = 0.0, **settings) -> None:
    """One of Blender's lights; at first it points down."""
    light = bpy.data.lights.new("Light", kind)
    light.energy = power
    for name, value in settings.items():
        setattr(light, name, value)
    thing = bpy.data.objects.new("Light", light)
    thing.matrix_world = turned(x=turn, at=at)
    bpy.context.scene.collection.objects.link(thing)


def _cove_area(size: int) -> None:
    _ledge(size)
    _add_light("AREA", (0.0, 2.37, 2.25), 60.0, 180.0, shape="RECTANGLE", size=3.6, size_y=0.05)


def _door_point(size: int) -> None:
    _half_open(size)
    _add_light("POINT", (-1.2, 2.0, 1.8), 100.0, shadow_soft_size=0.1)


def _spot_on_wall(size: int) -> None:
    _room(size)
    _add_light("SPOT", (0.0, 1.5, 1.5), 200.0, 110.0, spot_size=math.radians(80.0), shadow_soft_size=0.05)


def _ball(surface):
    """A ball on the table."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.3, location=(-0.6, 0.6, 1.05))
    thing = bpy.context.object
    thing.data.materials.append(surface)
    return thing


def _moving_ball(size: int, room=_spot_on_wall) -> None:
    """A ball that rolls during the exposure."""
    room(size)
    scene, thing = bpy.context.scene, _ball(_paint("Ball", (0.7, 0.2, 0.1)))
    for frame, x in ((0, -0.8), (2, 0.4)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    scene.render.use_motion_blur = True


def _moving_cove(size: int) -> None:
    _moving_ball(size, _cove)


def _leaf():
    """A diffuse material with holes."""
    leaf = _paint("Leaf", (0.2, 0.5, 0.1))
    nodes, links = leaf.node_tree.nodes, leaf.node_tree.links
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    checker, mix, clear = (
        nodes.new(kind) for kind in ("ShaderNodeTexChecker", "ShaderNodeMixShader", "ShaderNodeBsdfTransparent")
    )
    checker.inputs["Scale"].default_value = 6.0
    links.new(checker.outputs["Fac"], mix.inputs[0])
    links.new(output.inputs["Surface"].links[0].from_socket, mix.inputs[1])
    links.new(clear.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    return leaf


def _leaves(size: int) -> None:
    """A plant of 60 leaves with cut-out edges."""
    _spot_on_wall(size)
    leaf = _leaf()
    for number in range(60):
        angle, height = 2.4 * number, 0.8 + 0.02 * number
        at = -0.6 + 0.35 * math.cos(angle), 0.6 + 0.35 * math.sin(angle), height
        turn = (60.0 + 7.0 * (number % 5), 0.0, math.degrees(angle))
        add("Leaf", plane("Leaf", (0.3, 0.3)), leaf, location=at, rotation=turn)


def _wax(size: int) -> None:
    """A ball that light enters."""
    _spot_on_wall(size)
    surface = bpy.data.materials.new("Wax")
    tree = use_nodes(surface)
    closure = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    closure.inputs["Base Color"].default_value = (0.8, 0.6, 0.3, 1.0)
    closure.inputs["Subsurface Weight"].default_value = 1.0
    closure.inputs["Subsurface Scale"].default_value = 0.1
    _ball(surface)


ROOMS = dict(cove=_cove, shade=_shade, sign=_sign, door=_door, corridor=_corridor)
LIGHTS = dict(cove_area=_cove_area, door_point=_door_point, spot_on_wall=_spot_on_wall)  # rooms without SDF lamps
# In such rooms, something moves, or is shared in part.
THINGS = dict(moving_ball=_moving_ball, moving_cove=_moving_cove, leaves=_leaves, wax=_wax)


def build(name: str, size: int) -> bpy.types.Scene:
    """A room of that name, of ``size`` pixels to each side."""
    (ROOMS | LIGHTS | THINGS)[name](size)
    show()
    return bpy.context.scene
