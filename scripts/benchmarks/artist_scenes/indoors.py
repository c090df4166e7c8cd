# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms: by day, by night, a kitchen, a bar."""

from __future__ import annotations

import bpy
from scenery import textures
from scenery.materials import Graph, image, principled
from scenery.modelling import add, box, plane, rod, smooth_profile, turned
from scenery.staging import aimed, camera, glowing, light, sky, world

from .stage import scene


def _boards(name: str):
    """Parquet from pictures: colour, roughness and bump."""
    colour, height = textures.parquet(512)
    graph = Graph(name)
    tone = graph.texture(image(f"{name} colour", colour, True))
    bump = graph.bump(graph.texture(image(f"{name} height", height, False)), 0.004)
    return graph.finish(graph.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.35, Normal=bump))


def _plaster(name: str, color):
    graph = Graph(name)
    place = graph.node("ShaderNodeTexCoord", "Object")
    grain = graph.node("ShaderNodeTexNoise", Vector=place, Scale=6.0, Detail=5.0)
    return graph.finish(
        graph.node("ShaderNodeBsdfPrincipled", Base_Color=color, Roughness=0.85, Normal=graph.bump(grain, 0.01, 0.3))
    )


def _cloth(name: str, color):
    graph = Graph(name)
    place = graph.node("ShaderNodeTexCoord", "UV")
    weave = graph.node("ShaderNodeTexWave", "Fac", Vector=place, Scale=30.0, Distortion=1.0)
    return graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=color,
            Roughness=0.9,
            Sheen_Weight=0.4,
            Normal=graph.bump(weave, 0.003, 0.4),
        )
    )


def _curtain(name: str):
    graph = Graph(name)
    color = (0.85, 0.8, 0.7)
    front = graph.node("ShaderNodeBsdfDiffuse", Color=color)
    back = graph.node("ShaderNodeBsdfTranslucent", Color=color)
    return graph.finish(graph.node("ShaderNodeMixShader", _0=0.5, _1=front, _2=back))


def _room() -> None:
    """Five by six metres with a window in the left wall, a sofa, a table, a lamp and a picture."""
    wall = _plaster("Plaster", (0.78, 0.74, 0.68))
    add("Floor", plane("Floor", (5.0, 6.0)), _boards("Boards"))
    add("Ceiling", plane("Ceiling", (5.0, 6.0)), wall, location=(0.0, 0.0, 2.7), rotation=(180, 0, 0))
    add("Back", box("Back", (5.2, 0.1, 2.7)), wall, location=(0.0, 3.05, 1.35))
    add("Front", box("Front", (5.2, 0.1, 2.7)), wall, location=(0.0, -3.05, 1.35))
    add("Right", box("Right", (0.1, 6.0, 2.7)), wall, location=(2.55, 0.0, 1.35))
    # The left wall around a window of 2.4 by 1.6 metres.
    for name, extent, place in (
        ("Below", (0.1, 6.0, 0.7), (-2.55, 0.0, 0.35)),
        ("Above", (0.1, 6.0, 0.4), (-2.55, 0.0, 2.5)),
        ("Beside", (0.1, 1.5, 1.6), (-2.55, -2.25, 1.5)),
        ("Beyond", (0.1, 2.1, 1.6), (-2.55, 1.95, 1.5)),
    ):
        add(name, box(name, extent), wall, location=place)
    frame = principled("Frame", (0.8, 0.8, 0.78, 1.0), 0.4)
    for y in (-1.45, -0.3, 0.85):
        add("Bar", box("Bar", (0.06, 0.06, 1.6)), frame, location=(-2.55, y, 1.5))
    cloth = _cloth("Sofa", (0.1, 0.2, 0.26, 1.0))
    for extent, place in (
        ((2.0, 0.9, 0.4), (0.6, 2.3, 0.3)),
        ((2.0, 0.25, 0.5), (0.6, 2.7, 0.7)),
        ((0.25, 0.9, 0.3), (-0.35, 2.3, 0.6)),
        ((0.25, 0.9, 0.3), (1.55, 2.3, 0.6)),
    ):
        add("Cushion", box("Cushion", extent, bevel=0.08), cloth, location=place)
    wood = principled("Walnut", (0.19, 0.09, 0.045, 1.0), 0.3, Coat_Weight=0.4)
    add("Table", box("Table", (1.1, 0.6, 0.05), bevel=0.01), wood, location=(0.5, 0.9, 0.42))
    for x in (0.05, 0.95):
        for y in (0.7, 1.1):
            rod("Leg", (x, y, 0.0), (x, y, 0.4), 0.025, wood)
    vase = smooth_profile([(0.0, 0.0), (0.06, 0.0), (0.1, 0.1), (0.05, 0.22), (0.06, 0.26)])
    add("Vase", turned("Vase", vase), principled("Glaze", (0.6, 0.15, 0.05, 1.0), 0.15), location=(0.3, 0.9, 0.445))
    painting = Graph("Painting")
    tone = painting.texture(image("Painting", textures.contours(256, 160), True))
    painting.finish(painting.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.6))
    add(
        "Painting",
        plane("Painting", (1.2, 0.75), None),
        painting.material,
        location=(0.6, 2.99, 1.65),
        rotation=(90, 0, 0),
    )
    camera((1.9, -2.6, 1.45), (-0.3, 1.6, 0.95), 62.0)


@scene("a living room by day: a sky and its sun through a window with a curtain")
def living_room_day(opened) -> None:
    _room()
    sky(35.0, 250.0, 0.25)
    folds = plane("Curtain", (1.0, 1.8))
    add("Curtain", folds, _curtain("Voile"), location=(-2.4, 1.1, 1.5), rotation=(90, 0, 80))


@scene("a living room by night: a ceiling light, a shaded lamp, a screen, a blue world")
def living_room_night(opened) -> None:
    _room()
    world((0.01, 0.02, 0.06))
    light("Ceiling light", "AREA", 12.0, (0.0, 0.5, 2.65), (0.0, 0.5, 0.0), (1.0, 0.8, 0.55), shape="DISK", size=0.5)
    shade = turned("Shade", [(0.16, 0.0), (0.11, 0.3)], 48)
    add("Shade", shade, _curtain("Paper"), location=(2.0, 2.3, 1.2))
    light("Bulb", "POINT", 15.0, (2.0, 2.3, 1.33), color=(1.0, 0.7, 0.4), shadow_soft_size=0.04)
    rod(
        "Stand", (2.0, 2.3, 0.0), (2.0, 2.3, 1.2), 0.015, principled("Brass", (0.8, 0.55, 0.2, 1.0), 0.25, Metallic=1.0)
    )
    screen = Graph("Screen")
    tone = screen.texture(image("Screen", textures.contours(256, 160), True))
    screen.finish(screen.node("ShaderNodeEmission", Color=tone, Strength=3.0))
    add("Screen", plane("Screen", (1.1, 0.65), None), screen.material, location=(2.49, 0.0, 1.2), rotation=(90, 0, -90))


@scene("a kitchen: tiles, steel, glass, and spots over the worktop")
def kitchen(opened) -> None:
    tiles = Graph("Tiles")
    place = tiles.node("ShaderNodeTexCoord", "UV")
    brick = tiles.node(
        "ShaderNodeTexBrick",
        Vector=place,
        Color1=(0.7, 0.75, 0.72),
        Color2=(0.55, 0.66, 0.64),
        Mortar=(0.25, 0.24, 0.23),
        Scale=4.0,
        Mortar_Size=0.015,
    )
    joints = tiles.node("ShaderNodeTexBrick", "Fac", Vector=place, Scale=4.0, Mortar_Size=0.015)
    gloss = tiles.node("ShaderNodeMath", operation="MULTIPLY_ADD", _0=joints, _1=0.7, _2=0.12)
    bump = tiles.node("ShaderNodeBump", Height=joints, Distance=0.003, invert=True)
    tiles.finish(tiles.node("ShaderNodeBsdfPrincipled", Base_Color=brick, Roughness=gloss, Normal=bump))
    wall = _plaster("Plaster", (0.75, 0.73, 0.7))
    add("Floor", plane("Floor", (4.0, 4.0)), tiles.material)
    add("Wall", plane("Wall", (4.0, 2.6)), tiles.material, location=(0.0, 1.2, 1.3), rotation=(90, 0, 0))
    add("Side", plane("Side", (4.0, 2.6)), wall, location=(1.8, 0.0, 1.3), rotation=(90, 0, -90))
    add("Ceiling", plane("Ceiling", (4.0, 4.0)), wall, location=(0.0, 0.0, 2.6), rotation=(180, 0, 0))
    marble = Graph("Marble")
    tone = marble.texture(image("Marble", textures.marble(512), True))
    marble.finish(marble.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.1))
    add("Cupboards", box("Cupboards", (3.4, 0.6, 0.86), bevel=0.01), principled("Lacquer", (0.05, 0.12, 0.1, 1.0), 0.3))
    bpy.data.objects["Cupboards"].location = (0.0, 0.9, 0.43)
    add("Worktop", box("Worktop", (3.5, 0.66, 0.04), bevel=0.008), marble.material, location=(0.0, 0.87, 0.88))
    steel = principled("Steel", (0.65, 0.65, 0.66, 1.0), 0.22, Metallic=1.0, Anisotropic=0.6)
    pot = [(0.0, 0.0), (0.14, 0.0), (0.15, 0.01), (0.15, 0.18), (0.143, 0.18), (0.143, 0.012), (0.0, 0.012)]
    add("Pot", turned("Pot", pot), steel, location=(-0.5, 0.85, 0.9))
    copper = principled("Copper", (0.9, 0.45, 0.3, 1.0), 0.15, Metallic=1.0)
    add("Pan", turned("Pan", [(0.0, 0.0), (0.1, 0.0), (0.13, 0.06), (0.125, 0.06), (0.0, 0.01)]), copper)
    bpy.data.objects["Pan"].location = (-0.12, 0.8, 0.9)
    glass = Graph("Glass")
    glass.finish(glass.node("ShaderNodeBsdfGlass", Color=(0.96, 0.98, 0.97), Roughness=0.0, IOR=1.5))
    tumbler = [(0.0, 0.0), (0.035, 0.0), (0.04, 0.12), (0.037, 0.12), (0.033, 0.012), (0.0, 0.012)]
    for x, y in ((0.4, 0.75), (0.52, 0.85), (0.3, 0.9)):
        # Not in the plane of the worktop: the first hit of a ray is undefined for two surfaces in one plane.
        add("Tumbler", turned("Tumbler", tumbler, 48), glass.material, location=(x, y, 0.901))
    fruit = Graph("Fruit")
    noise = fruit.node("ShaderNodeTexNoise", Vector=fruit.node("ShaderNodeTexCoord", "Object"), Scale=20.0)
    peel = fruit.node("ShaderNodeMix", data_type="RGBA", _0=noise, _1=(0.9, 0.3, 0.02), _2=(0.95, 0.55, 0.05))
    fruit.finish(
        fruit.node("ShaderNodeBsdfPrincipled", Base_Color=peel, Roughness=0.4, Normal=fruit.bump(noise, 0.004))
    )
    ball = smooth_profile([(0.0, -0.05), (0.035, -0.035), (0.05, 0.0), (0.035, 0.035), (0.0, 0.05)])
    for x, y, z in ((0.95, 0.8, 0.95), (1.05, 0.83, 0.95), (1.0, 0.9, 0.95), (1.0, 0.84, 1.03)):
        add("Orange", turned("Orange", ball, 32), fruit.material, location=(x, y, z))
    world((0.35, 0.4, 0.5), 0.15)
    for x in (-1.0, 0.0, 1.0):
        light(
            f"Spot {x}",
            "SPOT",
            60.0,
            (x, 0.55, 2.5),
            (x, 0.9, 0.9),
            (1.0, 0.88, 0.7),
            spot_size=1.2,
            spot_blend=0.4,
            shadow_soft_size=0.03,
        )
    light(
        "Window",
        "AREA",
        60.0,
        (-1.9, -1.0, 1.6),
        (0.5, 0.6, 0.8),
        (0.8, 0.9, 1.0),
        shape="RECTANGLE",
        size=1.2,
        size_y=1.5,
    )
    camera((-0.5, -0.9, 1.5), (0.15, 0.8, 0.98), 48.0, 5.6, (0.2, 0.8, 0.95))


@scene("a bar at night: neon of glowing meshes, bottles of coloured glass, a counter like a mirror")
def neon_bar(opened) -> None:
    world((0.02, 0.02, 0.04))
    brick = Graph("Brick")
    place = brick.node("ShaderNodeTexCoord", "UV")
    tone = brick.node(
        "ShaderNodeTexBrick",
        Vector=place,
        Color1=(0.3, 0.1, 0.06),
        Color2=(0.2, 0.07, 0.05),
        Mortar=(0.1, 0.1, 0.1),
        Scale=3.0,
    )
    rough = brick.node("ShaderNodeTexNoise", Vector=place, Scale=25.0, Detail=6.0)
    brick.finish(
        brick.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.8, Normal=brick.bump(rough, 0.02, 0.6))
    )
    add("Wall", plane("Wall", (5.0, 3.0)), brick.material, location=(0.0, 1.0, 1.5), rotation=(90, 0, 0))
    counter = Graph("Counter")
    smear = counter.node(
        "ShaderNodeTexNoise", Vector=counter.node("ShaderNodeTexCoord", "Object"), Scale=4.0, Detail=8.0
    )
    ramp = counter.node("ShaderNodeValToRGB", Fac=smear)
    ramp.node.color_ramp.elements[0].color, ramp.node.color_ramp.elements[1].color = (
        (0.03,) * 3 + (1.0,),
        (0.3,) * 3 + (1.0,),
    )
    counter.finish(
        counter.node("ShaderNodeBsdfPrincipled", Base_Color=(0.03, 0.02, 0.02), Roughness=ramp, Coat_Weight=1.0)
    )
    add("Counter", box("Counter", (4.0, 1.0, 0.08), bevel=0.02), counter.material, location=(0.0, 0.0, 0.9))
    for index, (color, height) in enumerate(
        (((1.0, 0.05, 0.25), 1.9), ((0.05, 0.4, 1.0), 1.7), ((1.0, 0.5, 0.05), 1.5))
    ):
        tube = glowing(f"Tube {index}", color, 40.0)
        rod(f"Tube {index}", (-0.9 + 0.1 * index, 0.93, height), (0.9 - 0.25 * index, 0.93, height), 0.012, tube)
    bottle = smooth_profile([(0.0, 0.0), (0.045, 0.0), (0.045, 0.18), (0.016, 0.25), (0.016, 0.31), (0.0, 0.31)], 6)
    for index, color in enumerate(((0.2, 0.8, 0.3), (0.9, 0.5, 0.1), (0.8, 0.85, 0.9), (0.7, 0.15, 0.1))):
        glass = Graph(f"Bottle {index}")
        glass.finish(glass.node("ShaderNodeBsdfPrincipled", Base_Color=color, Roughness=0.02, Transmission_Weight=1.0))
        add(
            f"Bottle {index}",
            turned(f"Bottle {index}", bottle, 32),
            glass.material,
            location=(-0.5 + 0.3 * index, 0.1, 0.94),
        )
    stool = principled("Leather", (0.25, 0.04, 0.03, 1.0), 0.45)
    add("Seat", turned("Seat", [(0.0, 0.0), (0.2, 0.0), (0.2, 0.05), (0.0, 0.07)]), stool, location=(-0.7, -0.9, 0.7))
    eye = (0.7, -1.9, 1.45)
    camera(eye, (0.0, 0.5, 1.2), 50.0).rotation_euler = aimed(eye, (-0.05, 0.5, 1.2))
