# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the demo scene, a sitting room at night lit by three SDF lamps, and saves it as a .blend.

    python demo_scene.py FILE.blend

A ring hangs over the table, a lantern (a cube with a ball cut out of it, written as an expression) stands on the side
table, a tube leans in the corner behind the plant. There is no other light.
"""

from __future__ import annotations

import math
import pathlib
import random
import sys

import bpy
import host
from mathutils import Euler, Vector
from scenery import textures
from scenery.materials import Graph, image, principled
from scenery.modelling import add, box, leaf, plane, rod, smooth_profile, turned

ROOM = dict(left=-2.5, right=2.5, front=-3.6, back=2.0, height=2.7)
RING_RADIUS, RING_TILT = 0.42, (-17.0, -7.0, 0.0)


def make_materials() -> dict:
    """Every material by name."""
    made = {}

    oak = image("Oak", textures.wood(), True)
    walnut = image("Walnut", textures.wood(1024, 5, (0.36, 0.22, 0.14), (0.17, 0.09, 0.05)), True)
    weave = image("Weave height", textures.weave(), False)
    floor_colour, floor_height = textures.parquet()

    graph = Graph("Parquet")
    bump = graph.bump(graph.texture(image("Parquet height", floor_height, False)), 0.004)
    made["parquet"] = graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=graph.texture(image("Parquet", floor_colour, True)),
            Roughness=0.28,
            Normal=bump,
        )
    )

    graph = Graph("Plaster")
    bump = graph.bump(graph.texture(image("Plaster height", textures.plaster(), False), Scale=(0.6, 0.6, 0.6)), 0.008)
    made["plaster"] = graph.finish(graph.node("ShaderNodeBsdfDiffuse", Color=(0.66, 0.61, 0.55), Normal=bump))

    graph = Graph("Ceiling")
    made["ceiling"] = graph.finish(graph.node("ShaderNodeBsdfDiffuse", Color=(0.78, 0.76, 0.73)))

    for name, texture, roughness in (("oak", oak, 0.42), ("walnut", walnut, 0.33)):
        graph = Graph(name.title())
        made[name] = graph.finish(
            graph.node("ShaderNodeBsdfPrincipled", Base_Color=graph.texture(texture), Roughness=roughness)
        )

    for name, colour in (("linen", (0.42, 0.40, 0.36)), ("rust", (0.46, 0.13, 0.05)), ("teal", (0.03, 0.16, 0.18))):
        graph = Graph(name.title())
        bump = graph.bump(graph.texture(weave, Scale=(5.0, 5.0, 5.0)), 0.003, 0.7)
        made[name] = graph.finish(
            graph.node(
                "ShaderNodeBsdfPrincipled",
                Base_Color=colour,
                Roughness=0.9,
                Sheen_Weight=0.35,
                Sheen_Roughness=0.4,
                Normal=bump,
            )
        )

    graph = Graph("Rug")
    bump = graph.bump(graph.texture(weave, Scale=(24.0, 24.0, 24.0)), 0.004, 0.8)
    made["rug"] = graph.finish(
        graph.node(
            "ShaderNodeBsdfDiffuse", Color=graph.texture(image("Rug", textures.rug(), True)), Roughness=0.5, Normal=bump
        )
    )

    graph = Graph("Marble")
    made["marble"] = graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=graph.texture(image("Marble", textures.marble(), True)),
            Roughness=0.12,
        )
    )

    graph = Graph("Brass")
    made["brass"] = graph.finish(graph.node("ShaderNodeBsdfAnisotropic", Color=(0.86, 0.62, 0.27), Roughness=0.22))

    made["steel"] = principled("Dark Steel", (0.10, 0.10, 0.11), 0.35, Metallic=1.0)

    graph = Graph("Glass")
    made["glass"] = graph.finish(graph.node("ShaderNodeBsdfGlass", Color=(0.93, 0.98, 0.96), Roughness=0.0, IOR=1.5))

    made["glaze"] = principled("Glazed Ceramic", (0.035, 0.10, 0.16), 0.3, Coat_Weight=1.0, Coat_Roughness=0.03)
    made["white"] = principled("White Ceramic", (0.78, 0.75, 0.70), 0.18)
    made["orange"] = principled("Orange Peel", (0.86, 0.30, 0.04), 0.38)
    made["earth"] = principled("Earth", (0.05, 0.035, 0.025), 0.95)

    graph = Graph("Leaf")
    surface = graph.node("ShaderNodeBsdfPrincipled", Base_Color=(0.06, 0.19, 0.07), Roughness=0.35)
    through = graph.node("ShaderNodeBsdfTranslucent", Color=(0.16, 0.42, 0.08))
    made["leaf"] = graph.finish(graph.node("ShaderNodeMixShader", _0=0.4, _1=surface, _2=through))

    graph = Graph("Painting")
    made["painting"] = graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=graph.texture(image("Contours", textures.contours(), True)),
            Roughness=0.45,
        )
    )
    return made


def make_room(made: dict) -> None:
    width, depth = ROOM["right"] - ROOM["left"], ROOM["back"] - ROOM["front"]
    x, y, height = 0.0, 0.5 * (ROOM["front"] + ROOM["back"]), ROOM["height"]
    add("Floor", plane("Floor", (width, depth), 0.55), made["parquet"], location=(x, y, 0.0), rotation=(0, 0, 0))
    add("Ceiling", plane("Ceiling", (width, depth)), made["ceiling"], location=(x, y, height), rotation=(180, 0, 0))
    upright = plane("Wall across", (width, height))
    add("Back Wall", upright, made["plaster"], location=(x, ROOM["back"], height / 2), rotation=(90, 0, 0))
    add("Front Wall", upright, location=(x, ROOM["front"], height / 2), rotation=(-90, 0, 180))
    side = plane("Wall along", (depth, height))
    add("Right Wall", side, made["plaster"], location=(ROOM["right"], y, height / 2), rotation=(90, 0, -90))
    add("Left Wall", side, location=(ROOM["left"], y, height / 2), rotation=(90, 0, 90))

    # One slat, set on the vertices of a line: Blender instances it.
    spacing, count = 0.085, 40
    line = bpy.data.meshes.new("Slat places")
    line.from_pydata([(0.0, ROOM["back"] - 0.03 - spacing * index, 0.0) for index in range(count)], [], [])
    places = add("Slatted Wall", line, location=(ROOM["left"] + 0.03, 0.0, height / 2))
    slat = add("Slat", box("Slat", (0.045, 0.045, height - 0.01), 0.004, 2, 1.2, grain=2), made["oak"])
    slat.parent = places
    places.instance_type = "VERTS"

    add(
        "Skirting",
        box("Skirting", (width, 0.018, 0.09), 0.004),
        made["white"],
        location=(x, ROOM["back"] - 0.009, 0.045),
    )
    add(
        "Skirting",
        box("Skirting", (0.018, depth, 0.09), 0.004),
        made["white"],
        location=(ROOM["right"] - 0.009, y, 0.045),
    )


def make_sofa(made: dict, at) -> None:
    x, y, _ = at
    add("Sofa Base", box("Sofa Base", (2.0, 0.82, 0.16), 0.03), made["linen"], location=(x, y, 0.22))
    for side in (-1, 1):
        add(
            "Sofa Seat",
            box("Sofa Seat", (0.92, 0.74, 0.18), 0.06, 5),
            made["linen"],
            location=(x + side * 0.47, y - 0.04, 0.38),
        )
        add(
            "Sofa Back",
            box("Sofa Back", (0.92, 0.20, 0.46), 0.07, 5),
            made["linen"],
            location=(x + side * 0.47, y + 0.30, 0.62),
            rotation=(-10, 0, 0),
        )
        add(
            "Sofa Arm", box("Sofa Arm", (0.15, 0.86, 0.46), 0.05, 5), made["linen"], location=(x + side * 1.03, y, 0.36)
        )
        for front in (-1, 1):
            rod(
                "Sofa Foot",
                (x + side * 0.95, y + front * 0.34, 0.0),
                (x + side * 0.93, y + front * 0.32, 0.15),
                0.018,
                made["brass"],
            )
    for name, material, place, turn in (
        ("Cushion Rust", "rust", (-0.66, 0.12, 0.62), (-18, 8, 14)),
        ("Cushion Teal", "teal", (0.62, 0.12, 0.62), (-20, -12, -10)),
    ):
        cushion = box(name, (0.42, 0.13, 0.42), 0.06, 5)
        thing = add(name, cushion, made[material], location=(x + place[0], y + place[1], place[2]), rotation=turn)
        thing.modifiers.new("Soft", "SUBSURF").render_levels = 1


def make_table(made: dict, at) -> None:
    x, y, _ = at
    top = 0.735
    add(
        "Table Top",
        turned("Table Top", [(0, 0), (0.555, 0), (0.57, 0.008), (0.57, 0.022), (0.56, 0.03), (0, 0.03)], 96),
        made["marble"],
        location=(x, y, top - 0.03),
    )
    # A turned top would have its texture wrapped round; marble needs it flat.
    layer = bpy.data.meshes["Table Top"].uv_layers[0]
    for loop, uv in zip(bpy.data.meshes["Table Top"].loops, layer.data):
        place = bpy.data.meshes["Table Top"].vertices[loop.vertex_index].co
        uv.uv = (0.8 * place.x + 0.5, 0.8 * place.y + 0.5)
    stem = smooth_profile(
        [(0.0, 0.0), (0.27, 0.0), (0.27, 0.012), (0.10, 0.05), (0.045, 0.16), (0.04, 0.40), (0.07, 0.64), (0.16, 0.705)]
    )
    add("Table Stem", turned("Table Stem", stem), made["brass"], location=(x, y, 0.0))

    vase = smooth_profile([(0.0, 0.0), (0.055, 0.0), (0.10, 0.09), (0.085, 0.19), (0.038, 0.27), (0.055, 0.33)])
    inner = [(max(r - 0.007, 0.0), max(z, 0.012)) for r, z in reversed(vase)]
    add("Vase", turned("Vase", [*vase, *inner], 96), made["glass"], location=(x - 0.20, y + 0.12, top))
    ball = turned(
        "Glass Ball",
        [(0.075 * math.sin(math.pi * i / 32), 0.075 - 0.075 * math.cos(math.pi * i / 32)) for i in range(33)],
    )
    add("Glass Ball", ball, made["glass"], location=(x - 0.08, y - 0.25, top + 0.0005))

    bowl = smooth_profile([(0.0, 0.0), (0.06, 0.0), (0.075, 0.012), (0.15, 0.06), (0.185, 0.11)])
    inside = [(max(r - 0.008, 0.0), z + (0.008 if r < 0.17 else 0.0)) for r, z in reversed(bowl)]
    add("Bowl", turned("Bowl", [*bowl, *inside], 96), made["glaze"], location=(x + 0.22, y + 0.14, top))
    fruit = turned(
        "Orange", [(0.042 * math.sin(math.pi * i / 20), -0.042 * math.cos(math.pi * i / 20)) for i in range(21)], 40
    )
    fruit.materials.append(made["orange"])
    for index, (dx, dy, dz) in enumerate(
        ((-0.05, 0.02, 0.07), (0.05, 0.03, 0.07), (0.0, -0.055, 0.072), (0.005, 0.015, 0.128))
    ):
        add("Orange", fruit, location=(x + 0.22 + dx, y + 0.14 + dy, top + dz), rotation=(20 * index, 40 * index, 0))


def make_stools(made: dict) -> None:
    """One stool, instanced as a collection."""
    stool = bpy.data.collections.new("Stool")
    add(
        "Stool Seat",
        turned("Stool Seat", [(0, 0.43), (0.165, 0.43), (0.18, 0.442), (0.18, 0.458), (0.165, 0.47), (0, 0.465)], 64),
        made["walnut"],
        collection=stool,
    )
    for index in range(3):
        angle = 2.0 * math.pi * index / 3 + 0.4
        c, s = math.cos(angle), math.sin(angle)
        rod("Stool Leg", (0.21 * c, 0.21 * s, 0.0), (0.11 * c, 0.11 * s, 0.44), 0.012, made["steel"], stool)
    ring = [
        (0.165 + 0.007 * math.cos(a), 0.20 + 0.007 * math.sin(a)) for a in [2 * math.pi * i / 12 for i in range(13)]
    ]
    add("Stool Ring", turned("Stool Ring", ring, 64), made["steel"], collection=stool)
    for place, turn in (((1.52, 0.22, 0.0), 20), ((0.08, -0.62, 0.0), 75)):
        empty = bpy.data.objects.new("Stool", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", stool
        empty.location, empty.rotation_euler = place, (0.0, 0.0, math.radians(turn))
        bpy.context.scene.collection.objects.link(empty)


def make_side_table(made: dict, at) -> None:
    x, y, height = at
    add(
        "Side Table Top",
        box("Side Table Top", (0.50, 0.50, 0.035), 0.006),
        made["walnut"],
        location=(x, y, height - 0.0175),
    )
    add("Side Table Shelf", box("Side Table Shelf", (0.44, 0.44, 0.02), 0.004), made["walnut"], location=(x, y, 0.16))
    for dx in (-0.21, 0.21):
        for dy in (-0.21, 0.21):
            rod("Side Table Leg", (x + dx, y + dy, 0.0), (x + dx, y + dy, height - 0.03), 0.012, made["steel"])
    for index, (size, colour) in enumerate(
        (((0.24, 0.17, 0.03), "teal"), ((0.22, 0.16, 0.025), "white"), ((0.19, 0.14, 0.035), "rust"))
    ):
        z = 0.17 + sum((0.03, 0.025, 0.035)[:index]) + size[2] / 2
        add(
            "Book",
            box("Book", size, 0.003),
            made[colour],
            location=(x + 0.02, y - 0.03, z),
            rotation=(0, 0, 12 * index - 8),
        )


def make_plant(made: dict, at) -> None:
    x, y, _ = at
    pot = smooth_profile([(0.0, 0.0), (0.13, 0.0), (0.17, 0.10), (0.20, 0.30), (0.215, 0.36)])
    inner = [(max(r - 0.018, 0.0), max(z, 0.30)) for r, z in reversed(pot)]
    add("Pot", turned("Pot", [*pot, *inner]), made["white"], location=at)
    add("Earth", turned("Earth", [(0.0, 0.0), (0.195, 0.0)], 32), made["earth"], location=(x, y, 0.315))
    shape = leaf("Leaf", 0.36, 0.14)
    shape.materials.append(made["leaf"])
    chance = random.Random(4)
    for stem in range(8):
        turn = 2.4 * stem + chance.uniform(-0.2, 0.2)
        lean, rise = chance.uniform(0.10, 0.30), chance.uniform(0.65, 1.25)
        foot = Vector((x + 0.05 * math.cos(turn), y + 0.05 * math.sin(turn), 0.31))
        tip = Vector((x + lean * math.cos(turn), y + lean * math.sin(turn), 0.31 + rise))
        rod("Stem", foot, tip, 0.007, made["leaf"], steps=8)
        for level in range(5):
            place = foot.lerp(tip, 0.42 + 0.145 * level)
            size = chance.uniform(0.75, 1.15) * (1.05 - 0.08 * level)
            add(
                "Leaf",
                shape,
                location=place,
                scale=(size,) * 3,
                rotation=(chance.uniform(15, 45), chance.uniform(-15, 15), math.degrees(turn) + 137.5 * level - 90),
            )


def make_painting(made: dict, at) -> None:
    x, y, z = at
    add(
        "Painting",
        plane("Painting", (1.20, 0.75), None),
        made["painting"],
        location=(x, y - 0.02, z),
        rotation=(90, 0, 0),
    )
    for size, dx, dz in (
        ((1.26, 0.035, 0.03), 0.0, 0.39),
        ((1.26, 0.035, 0.03), 0.0, -0.39),
        ((0.03, 0.035, 0.75), 0.615, 0.0),
        ((0.03, 0.035, 0.75), -0.615, 0.0),
    ):
        add("Frame", box("Frame", size, 0.003), made["walnut"], location=(x + dx, y - 0.0175, z + dz))


def add_lamp(name: str, shape: str, power: float, colour, location, rotation=(0.0, 0.0, 0.0), **parameters):
    """A light that is an SDF lamp; other engines see a point light of the same power.

    ``shape`` is a primitive's name with its ``parameters``, or an expression.
    """
    light = bpy.data.lights.new(name, "POINT")
    light.energy, light.color = power, colour
    host.set_lamp(light, shape, **parameters)
    return add(name, light, location=location, rotation=rotation)


def make_lamps(made: dict) -> None:
    x, y, z = 0.85, -0.25, 1.72
    add_lamp(
        "Ring", "torus", 55.0, (1.0, 0.66, 0.36), (x, y, z), RING_TILT, major_radius=RING_RADIUS, minor_radius=0.045
    )
    ring = Euler([math.radians(angle) for angle in RING_TILT])
    for index in range(3):
        angle = 2.0 * math.pi * index / 3 + 0.5
        held = ring.to_matrix() @ Vector((RING_RADIUS * math.cos(angle), RING_RADIUS * math.sin(angle), 0.0))
        rod("Wire", held + Vector((x, y, z)), (x, y, ROOM["height"] - 0.02), 0.0025, made["steel"], steps=8)
    add(
        "Ceiling Rose",
        turned("Ceiling Rose", [(0, 0), (0.06, 0), (0.06, 0.03), (0, 0.03)], 40),
        made["brass"],
        location=(x, y, ROOM["height"] - 0.03),
    )

    add_lamp(
        "Lantern", "difference(box(0.15), sphere(0.195))", 20.0, (1.0, 0.30, 0.08), (-1.93, 1.22, 0.712), (0, 0, 27)
    )
    add_lamp("Tube", "capsule", 30.0, (0.12, 0.42, 1.0), (2.16, 1.66, 0.90), (4, 7, 0), radius=0.04, height=1.6)


def make_camera(scene) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.lens, camera.clip_start = 27.0, 0.01
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 3.3, 5.6
    thing = add("Camera", camera, location=(-0.55, -3.35, 1.32))
    thing.rotation_euler = (Vector((0.22, 1.2, 0.93)) - thing.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera = thing


def build() -> None:
    """The scene, in place of the open file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    made = make_materials()
    make_room(made)
    make_sofa(made, (-0.45, 1.45, 0.0))
    make_table(made, (0.85, -0.25, 0.0))
    make_stools(made)
    make_side_table(made, (-1.93, 1.22, 0.56))
    make_plant(made, (1.92, 1.30, 0.0))
    make_painting(made, (-0.45, ROOM["back"], 1.55))
    add("Rug", box("Rug", (2.6, 1.9, 0.012), 0.005, 2), made["rug"], location=(0.25, 0.05, 0.006), rotation=(0, 0, 0))
    rug = bpy.data.meshes["Rug"]
    for loop, uv in zip(rug.loops, rug.uv_layers[0].data):
        place = rug.vertices[loop.vertex_index].co
        uv.uv = (place.x / 2.6 + 0.5, place.y / 1.9 + 0.5)
    make_lamps(made)
    make_camera(scene)
    world = bpy.data.worlds.new("Night")
    world.color = (0.0, 0.0, 0.0)
    scene.world = world
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    # Few, because the first command of a new user should be fast: denoised, the picture looks almost like one with 48.
    scene.sdf_lights.samples, scene.sdf_lights.denoise = 4, True
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"


def main(arguments: list[str]) -> int:
    if len(arguments) != 1 or not arguments[0].endswith(".blend"):
        print("Usage: demo_scene.py FILE.blend", file=sys.stderr)
        return 2
    path = pathlib.Path(arguments[0]).resolve()
    host.register_extension()
    build()
    bpy.context.scene.render.engine = host.ENGINE
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    return 0


if __name__ == "__main__":
    host.finish(main(sys.argv[1:]))
