# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms, and a city: light that hides, and light in rows."""

from __future__ import annotations

import math
import random

import bpy
from scenery import textures
from scenery.materials import Graph, image, principled
from scenery.modelling import add, box, leaf, plane, smooth_profile, turned
from scenery.staging import camera, world

from . import surfaces
from .stage import expression, pattern, preset, primitive, recipe, shine


@recipe("Ceiling cove", samples=12)
def ceiling_cove(scene) -> None:
    """A strip of light runs around the ceiling. A ledge hides the strip, and the ceiling shows its light.

    1. Model a ledge around the room, 26 cm below the ceiling and 20 cm wide, with an edge of 9 cm.
    2. Choose Add > Light > SDF Lamp > **From an Expression**, and write `onion(extrusion(rectangle(4.8, 5.8),
       0.02), 0.01)`. This is a strip along a rectangle.
    3. Put it on the ledge. Set *Temperature* to 3600 K, and *Power* to 50 W.
    4. Add the preset **Fluorescent Tube** above the painting, with a *Power* of 7 W.
    """
    world((0.0, 0.0, 0.0))
    white = principled("Paint", (0.72, 0.70, 0.66), 0.9)
    blue = principled("Wall", (0.13, 0.2, 0.24), 0.85)
    oak = surfaces.wood("Oak", (0.5, 0.34, 0.21), (0.34, 0.21, 0.12), 0.28)
    width, depth, height = 5.0, 6.0, 2.8
    surfaces.floor(oak, (width, depth))
    add("Ceiling", plane("Ceiling", (width, depth)), white, location=(0, 0, height), rotation=(180, 0, 0))
    add("Back", plane("Back", (width, height)), blue, location=(0, 0.5 * depth, 0.5 * height), rotation=(90, 0, 0))
    for side in (-1, 1):
        add(
            "Side",
            plane("Side", (depth, height)),
            blue,
            location=(side * 0.5 * width, 0, 0.5 * height),
            rotation=(90, 0, -90 * side),
        )
        add("Ledge", box("Ledge", (0.2, depth, 0.03)), white, location=(side * (0.5 * width - 0.1), 0, height - 0.26))
        add("Edge", box("Edge", (0.02, depth, 0.09)), white, location=(side * (0.5 * width - 0.21), 0, height - 0.23))
    add("Ledge", box("Ledge", (width, 0.2, 0.03)), white, location=(0, 0.5 * depth - 0.1, height - 0.26))
    add("Edge", box("Edge", (width - 0.4, 0.02, 0.09)), white, location=(0, 0.5 * depth - 0.21, height - 0.23))
    fabric = principled("Linen", (0.32, 0.29, 0.25), 0.95, Sheen_Weight=0.3)
    rust = principled("Rust", (0.42, 0.12, 0.05), 0.9, Sheen_Weight=0.3)
    add("Sofa", box("Sofa Base", (2.3, 0.9, 0.2), 0.04), fabric, location=(0, 2.3, 0.22))
    for side in (-1, 1):
        add("Sofa", box("Seat", (1.05, 0.8, 0.2), 0.07, 5), fabric, location=(side * 0.53, 2.22, 0.42))
        add(
            "Sofa",
            box("Cushion", (1.0, 0.24, 0.5), 0.08, 5),
            fabric,
            location=(side * 0.53, 2.58, 0.66),
            rotation=(-10, 0, 0),
        )
        add("Sofa", box("Arm", (0.17, 0.92, 0.5), 0.06, 5), fabric, location=(side * 1.2, 2.3, 0.38))
    add(
        "Cushion", box("Small", (0.42, 0.14, 0.42), 0.06, 5), rust, location=(-0.75, 2.35, 0.72), rotation=(-20, 10, 15)
    )
    add(
        "Rug",
        box("Rug", (2.6, 1.7, 0.015), 0.006),
        principled("Wool", (0.46, 0.42, 0.36), 1.0),
        location=(0, 0.9, 0.01),
    )
    marble = surfaces.marble(0.12)
    add(
        "Table",
        turned("Table", [(0, 0.36), (0.45, 0.36), (0.46, 0.38), (0.45, 0.4), (0, 0.4)], 64),
        marble,
        location=(0, 0.9, 0),
    )
    add(
        "Stem",
        turned("Stem", [(0.22, 0.0), (0.22, 0.02), (0.04, 0.05), (0.04, 0.36)], 48),
        surfaces.metal("Brass", (0.8, 0.55, 0.25), 0.25),
        location=(0, 0.9, 0),
    )
    vase = smooth_profile([(0.0, 0.0), (0.05, 0.0), (0.09, 0.08), (0.05, 0.2), (0.035, 0.24), (0.05, 0.28)])
    add("Vase", turned("Vase", vase, 48), principled("Glaze", (0.03, 0.12, 0.12), 0.15), location=(0.1, 0.95, 0.4))
    picture = Graph("Painting")
    picture.finish(
        picture.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=picture.texture(image("Contours", textures.contours(512, 320), True)),
            Roughness=0.5,
        )
    )
    add(
        "Painting",
        plane("Painting", (1.5, 0.94), None),
        picture.material,
        location=(0, 2.98, 1.62),
        rotation=(90, 0, 0),
    )
    strip = expression("Cove", "onion(extrusion(rectangle(4.8, 5.8), 0.02), 0.01)", (0.0, 0.0, height - 0.22))
    shine(strip, 50.0, kelvins=3600.0)
    shine(preset("tube", (0.0, 2.86, 2.2), scale=0.7), 7.0, kelvins=2700.0, camera=0.05)
    camera((-0.55, -2.95, 1.35), (0.08, 2.5, 1.42), 60.0)


@recipe("Strip under a cabinet", samples=12)
def under_cabinet(scene) -> None:
    """A strip of light shines on a worktop and on the tiles behind it.

    1. Choose Add > Light > SDF Lamp > Rounded > **Rounded Box**. Set *Half Size* to 1.5, 0.01 and 0.005 m, and
       *Radius* to 0.003 m.
    2. Put it under the cabinets, 27 cm from the wall.
    3. Set *Temperature* to 3200 K, *Power* to 30 W, and *Camera Brightness* to 0.2.
    4. Give the tiles a *Roughness* of 0.12. They then reflect the strip.
    """
    world((0.012, 0.016, 0.025))
    tile = Graph("Tiles")
    place = tile.node("ShaderNodeTexCoord", "Object")
    joint_pattern = tile.nodes.new("ShaderNodeTexBrick")
    tile.links.new(place, joint_pattern.inputs["Vector"])
    for socket, value in (("Color1", (0.10, 0.27, 0.25)), ("Color2", (0.06, 0.19, 0.18)), ("Mortar", (0.4, 0.4, 0.38))):
        joint_pattern.inputs[socket].default_value = (*value, 1.0)
    for socket, value in (("Scale", 1.0), ("Mortar Size", 0.003), ("Brick Width", 0.2), ("Row Height", 0.075)):
        joint_pattern.inputs[socket].default_value = value
    joints = tile.bump(
        tile.node("ShaderNodeMath", operation="SUBTRACT", _0=1.0, _1=joint_pattern.outputs["Fac"]), 0.004
    )
    tile.finish(
        tile.node("ShaderNodeBsdfPrincipled", Base_Color=joint_pattern.outputs["Color"], Roughness=0.12, Normal=joints)
    )
    surfaces.wall(tile.material, 0.0, (5.0, 1.6), 0.5)
    oak = surfaces.wood("Oak", (0.5, 0.32, 0.19), (0.33, 0.19, 0.1), 0.4)
    marble = surfaces.marble(0.15)
    add("Worktop", box("Worktop", (4.0, 0.66, 0.04), 0.004, 2, 0.9), marble, location=(0, -0.33, 0.9))
    add("Front", box("Front", (4.0, 0.6, 0.8), 0.004), oak, location=(0, -0.33, 0.47))
    for index in range(5):
        add(
            "Cabinet",
            box("Cabinet", (0.796, 0.36, 0.75), 0.004, grain=2),
            oak,
            location=(-1.6 + 0.8 * index, -0.18, 1.82),
        )
    metal = surfaces.metal("Steel", (0.6, 0.58, 0.55), 0.2)
    strip = primitive("rounded_box", (0.0, -0.27, 1.434), half_size=(1.5, 0.01, 0.005), radius=0.003)
    strip.name = "Strip"
    shine(strip, 30.0, kelvins=3200.0, camera=0.2)
    white = principled("Porcelain", (0.75, 0.73, 0.7), 0.15)
    for index, x in enumerate((-0.42, -0.3)):
        mug = [(0.0, 0.0), (0.038, 0.0), (0.042, 0.01), (0.042, 0.095), (0.038, 0.095), (0.038, 0.01), (0.0, 0.008)]
        add("Mug", turned("Mug", mug), white, location=(x, -0.22 - 0.1 * index, 0.92))
    pot = smooth_profile(
        [(0.0, 0.0), (0.07, 0.0), (0.085, 0.02), (0.08, 0.1), (0.045, 0.16), (0.03, 0.19), (0.0, 0.195)]
    )
    add("Kettle", turned("Kettle", pot), metal, location=(-0.72, -0.26, 0.92))
    bowl = smooth_profile([(0.0, 0.0), (0.06, 0.0), (0.075, 0.012), (0.14, 0.055), (0.17, 0.09)])
    inside = [(max(r - 0.008, 0.0), z + (0.008 if r < 0.16 else 0.0)) for r, z in reversed(bowl)]
    add(
        "Bowl",
        turned("Bowl", [*bowl, *inside], 96),
        principled("Glaze", (0.03, 0.05, 0.09), 0.1, Coat_Weight=1.0),
        location=(0.3, -0.3, 0.92),
    )
    orange = principled("Orange", (0.82, 0.27, 0.03), 0.4)
    for dx, dy, dz in ((-0.05, 0.02, 0.06), (0.05, 0.03, 0.06), (0.0, -0.05, 0.06), (0.0, 0.01, 0.12)):
        ball = turned(
            "Orange", [(0.04 * math.sin(math.pi * i / 20), -0.04 * math.cos(math.pi * i / 20)) for i in range(21)], 32
        )
        add("Orange", ball, orange, location=(0.3 + dx, -0.3 + dy, 0.92 + dz))
    board = add(
        "Board",
        box("Board", (0.3, 0.02, 0.42), 0.008, grain=2),
        surfaces.wood("Walnut"),
        location=(0.72, -0.07, 1.13),
        rotation=(-10, 0, 0),
    )
    board.name = "Board"
    clear = surfaces.glass("Glass", (0.95, 0.98, 0.96))
    bottle = smooth_profile([(0.0, 0.0), (0.035, 0.0), (0.038, 0.02), (0.036, 0.17), (0.014, 0.23), (0.013, 0.29)])
    add("Bottle", turned("Bottle", bottle), clear, location=(0.56, -0.2, 0.92))
    pot = [(0.0, 0.0), (0.05, 0.0), (0.062, 0.1), (0.055, 0.1), (0.05, 0.09), (0.0, 0.09)]
    add("Pot", turned("Pot", pot), white, location=(0.02, -0.13, 0.92))
    shape = leaf("Leaf", 0.09, 0.05, 6)
    shape.materials.append(principled("Basil", (0.07, 0.22, 0.04), 0.4))
    chance = random.Random(2)
    for index in range(40):
        turn, rise = 137.5 * index, chance.uniform(0.0, 0.12)
        out = 0.035 * chance.random()
        at = (0.02 + out * math.cos(turn), -0.13 + out * math.sin(turn), 1.0 + rise)
        add(
            "Leaf", shape, location=at, rotation=(chance.uniform(0, 50), 0, turn), scale=(chance.uniform(0.6, 1.0),) * 3
        )
    camera((-0.28, -1.7, 1.33), (-0.02, -0.1, 1.13), 43.0)


LIT = """\
cell = (1.8, 3, 3)
random = noise(floor(p / cell + 0.5) * 7.31 + 3.7)
smoothstep(0.0, 0.25, random) + 0.03
"""


@recipe("City at night", samples=12, gallery=True, pattern=LIT)
def city_at_night(scene) -> None:
    """Houses at night have lit windows. One lamp makes all windows of one side of a house.

    1. Choose Add > Light > SDF Lamp > **From an Expression**, and write `repetition(box(0.55, 0.03, 0.75), (7, 1,
       11), (1.8, 3, 3))`. This makes 77 windows.
    2. Choose Pattern > **Expression**, and write the pattern. It gives each window a random brightness.
    3. Set *Power* to 500 W, *Temperature* to 2600 K, and *Camera Brightness* to 0.25. Put the lamp on the front of
       a house.
    4. Press Alt D for linked copies on more houses. Add three more lamps, with 2900 K, 3600 K and 5600 K. Change
       the last number of the second line of their patterns, so that other windows are lit.
    5. Add the preset **Neon Heart**, scaled by 4, with a *Power* of 900 W. For the fog, add a **Volume Scatter** to
       the world, with a *Density* of 0.004.
    """
    surfaces.fog(0.004, (0.7, 0.8, 1.0), (0.012, 0.02, 0.05))
    surfaces.floor(surfaces.wet("Street", (0.02, 0.02, 0.024), 0.12, (0.03, 0.3)), (140.0, 260.0), (0.0, 90.0, 0.0))
    facade = principled("Facade", (0.07, 0.075, 0.09), 0.5)
    chance = random.Random(12)
    kinds = []
    for seed, kelvins in (("3.7", 2600.0), ("11.3", 3600.0), ("23.9", 5600.0), ("31.1", 2900.0)):
        text = "repetition(box(0.55, 0.03, 0.75), (7, 1, 11), (1.8, 3, 3))"
        made = expression(f"Windows {int(kelvins)}", text, (0.0, 0.0, -500.0))
        shine(made, 500.0, kelvins=kelvins, camera=0.25)
        pattern(made, LIT.replace("3.7", seed))
        kinds.append(made.data)
        bpy.data.objects.remove(made)
    for row, y in enumerate((6.0, 24.0, 42.0, 62.0, 84.0)):
        for side in (-1, 1):
            high = chance.uniform(0.8, 1.5)
            x = side * (14.5 + chance.uniform(0.0, 1.5))
            height = 36.0 * high
            add("House", box("House", (15.0, 14.5, height)), facade, location=(x, y + 7.0, 0.5 * height))
            light = kinds[(2 * row + (side > 0)) % len(kinds)]
            for place, turn in (((x - side * 7.5, y + 7.0), 90), ((x, y - 0.25), 0)):
                front = add("Windows", light, location=(*place, 0.5 * height), rotation=(0, 0, turn))
                front.scale = (1.0, 1.0, high)
    for x, y, high in ((-30.0, 118.0, 2.4), (-9.0, 128.0, 1.9), (11.0, 124.0, 2.7), (31.0, 116.0, 2.1)):
        add("Tower", box("Tower", (15.0, 14.0, 36.0 * high)), facade, location=(x, y + 7.3, 18.0 * high))
        light = kinds[int(high * 10) % len(kinds)]
        add("Windows", light, location=(x, y, 18.0 * high), scale=(1.0, 1.0, high))
    shine(preset("neon_heart", (-5.2, 13.0, 8.6), (0, 0, 30), 4.0), 900.0, camera=0.1)
    shine(preset("moon", (3.0, 240.0, 112.0), (0, -30, 0), 22.0), 20000.0, camera=0.9)
    camera((1.4, -16.0, 2.6), (0.0, 40.0, 19.0), 62.0)
