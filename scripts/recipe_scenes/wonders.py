# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fantasy, and the night sky: a portal, a hologram, a statue of light, a fractal, ice, an aurora."""

from __future__ import annotations

import math
import random

import bpy
import numpy as np
from scenery.materials import Graph, principled
from scenery.modelling import add, box, smooth_profile, turned
from scenery.staging import camera, world

from . import surfaces
from .stage import expression, of_object, pattern, preset, primitive, recipe, shine

WHIRL = """\
spin = slider(0, -10, 10)  # turns
r = length(p.xz)
arms = 0.5 + 0.5 * sin(3 * atan2(p.z, p.x) + 9 * r + tau * spin + 1.2 * noise(4 * p))
ramp(r, 0, (0.9, 0.9, 1), 0.35, (0.25, 0.35, 1), 1, (0.45, 0.08, 0.9)) * (0.04 + arms ** 3 + exp(-9 * r))
"""


@recipe("Portal", samples=8, gallery=True, pattern=WHIRL)
def portal(scene) -> None:
    """A spiral of light fills an arch of stone.

    1. Choose Add > Light > SDF Lamp > **From an Expression**, and write `rotate_x(lens(1.0, 0.16), 90)`.
    2. Choose Pattern > **Expression**, and write the pattern. The name `spin` becomes a slider, which you can
       animate.
    3. Set *Power* to 110 W, and *Camera Brightness* to 0.22.
    4. Add a ring around it: SDF Lamp > Basic > **Torus**, *Major Radius* 1.03 m, *Minor Radius* 0.025 m. Set
       *Power* to 45 W, and *Color* to 0.5, 0.25, 1.
    5. Build the arch from blocks. Turn each block by 14° more than the one before.
    """
    surfaces.fog(0.02, ambient=(0.006, 0.008, 0.018))
    surfaces.floor(surfaces.wet("Flags", (0.04, 0.04, 0.045), 1.1, (0.05, 0.4)), (24.0, 24.0))
    rock = surfaces.stone("Stone", (0.2, 0.19, 0.2), 3.0, 0.06)
    chance = random.Random(5)
    for index in range(19):
        angle = math.radians(-40.0 + 260.0 * index / 18.0)
        block = box("Block", (0.42, 0.5, 0.3), 0.025)
        place = (1.28 * math.cos(angle), 0.0, 1.2 + 1.28 * math.sin(angle))
        turn = (chance.uniform(-2, 2), math.degrees(-angle), chance.uniform(-3, 3))
        add("Block", block, rock, location=place, rotation=turn)
    for index in range(3):
        size = (3.6 - 0.5 * index, 1.9 - 0.45 * index, 0.13)
        add("Step", box("Step", size, 0.02), rock, location=(0.0, -0.1, 0.06 + 0.12 * index))
    for x, y, high in (
        (-2.6, 1.6, 3.4),
        (2.7, 1.9, 2.5),
        (-3.3, -0.6, 1.5),
        (3.4, -0.3, 3.2),
        (-1.6, 3.6, 3.0),
        (1.8, 3.9, 3.8),
    ):
        add(
            "Pillar",
            box("Pillar", (0.5, 0.5, high), 0.03),
            rock,
            location=(x, y, 0.5 * high),
            rotation=(0, 0, chance.uniform(-20, 20)),
        )
    disc = expression("Whirl", "rotate_x(lens(1.0, 0.16), 90)", (0.0, 0.0, 1.2))
    pattern(
        disc,
        WHIRL,
    )
    shine(disc, 110.0, (1.0, 1.0, 1.0), camera=0.22)
    ring = primitive("torus", (0.0, 0.0, 1.2), (90, 0, 0), major_radius=1.03, minor_radius=0.025)
    shine(ring, 45.0, (0.5, 0.25, 1.0), camera=0.12)
    camera((-1.0, -5.2, 1.15), (0.0, 0.0, 1.22), 42.0)


@recipe("Hologram", samples=64)
def hologram(scene) -> None:
    """A projector shows a head of light, with the lines of an old screen.

    1. Add a monkey. Choose Object > Convert > **To SDF Lamp**. The inside of the monkey now glows.
    2. Choose Pattern > **Expression**, and write `exp(-depth / 0.015) * (0.12 + smoothstep(0.0, 0.7, sin(200 * p.z)))`.
       Only a thin skin glows then, in lines.
    3. Set *Color* to 0.06, 0.6, 1, *Power* to 90 W, and *Camera Brightness* to 0.06.
    4. Add SDF Lamp > Basic > **Frustum** as the beam, with 5 W and the pattern `(1 - height) ** 2 * (0.4 +
       exp(-depth / 0.03))`.
    5. Model the projector, and put a **Torus** of 12 W into it.
    """
    world((0.03, 0.034, 0.045))
    surfaces.floor(principled("Floor", (0.05, 0.052, 0.058), 0.15), (20.0, 20.0))
    surfaces.wall(principled("Wall", (0.12, 0.13, 0.15), 0.6), 2.6)
    steel = surfaces.metal("Steel", (0.25, 0.26, 0.28), 0.25)
    for index in range(9):
        add(
            "Panel",
            box("Panel", (0.9, 0.08, 3.4), 0.02),
            principled("Panel", (0.07, 0.075, 0.085), 0.35),
            location=(-3.8 + 0.95 * index, 2.5, 1.75),
        )
    base = [
        (0.0, 0.0),
        (0.62, 0.0),
        (0.6, 0.08),
        (0.46, 0.2),
        (0.4, 0.62),
        (0.5, 0.72),
        (0.5, 0.76),
        (0.4, 0.78),
        (0.38, 0.74),
        (0.0, 0.74),
    ]
    add("Projector", turned("Projector", base, 96), steel)
    bpy.ops.mesh.primitive_monkey_add(size=0.85, location=(0.0, 0.0, 1.5), rotation=(-0.05, 0.0, 0.3))
    made = bpy.context.active_object
    made.modifiers.new("Smooth", "SUBSURF").render_levels = 2
    ghost = of_object(made)
    pattern(ghost, "exp(-depth / 0.015) * (0.12 + smoothstep(0.0, 0.7, sin(200 * p.z)))")
    shine(ghost, 90.0, (0.06, 0.6, 1.0), camera=0.06)
    beam = primitive("frustum", (0.0, 0.0, 1.0), bottom_radius=0.3, top_radius=0.62, height=0.5)
    pattern(beam, "(1 - height) ** 2 * (0.4 + exp(-depth / 0.03))")
    shine(beam, 5.0, (0.06, 0.5, 1.0), camera=0.3)
    ring = primitive("torus", (0.0, 0.0, 0.77), major_radius=0.36, minor_radius=0.02)
    shine(ring, 12.0, (0.2, 0.8, 1.0), camera=0.15)
    camera((0.5, -3.1, 1.3), (0.0, 0.0, 1.2), 42.0)


@recipe("Statue of light", samples=16)
def statue_of_light(scene) -> None:
    """A dancer of light stands in a dark hall.

    1. Model a figure: a few edges with a **Skin** modifier and a **Subdivision Surface** modifier. Any other closed
       mesh will do, too.
    2. Choose Object > Convert > **To SDF Lamp**. The lamp has all modifiers of the mesh, and follows its armature.
    3. Choose Pattern > **Core** with *Size* 0.09 m and *Sharpness* 1.5. The middle of the body is bright, and thin
       parts are dark.
    4. Set *Temperature* to 3800 K, *Power* to 160 W, and *Camera Brightness* to 0.04.
    5. Give the floor a *Roughness* of 0.1.
    """
    world((0.004, 0.005, 0.008))
    surfaces.floor(principled("Marble", (0.045, 0.045, 0.05), 0.1), (24.0, 24.0))
    pillar = surfaces.stone("Pillar", (0.4, 0.37, 0.33), 1.4, 0.02)
    for x in (-2.2, 2.2):
        for y in (-0.4, 1.6, 3.6, 5.6):
            shaft = turned("Shaft", [(0.36, 0.0), (0.36, 0.14), (0.27, 0.2), (0.25, 4.0)], 48)
            add("Pillar", shaft, pillar, location=(x, y, 0.0))
    surfaces.wall(surfaces.stone("Wall", (0.3, 0.28, 0.26), 1.0, 0.02), 7.2, (12.0, 6.0))
    plinth = turned(
        "Plinth",
        [(0.0, 0.0), (0.5, 0.0), (0.5, 0.06), (0.42, 0.1), (0.42, 0.34), (0.46, 0.38), (0.46, 0.42), (0.0, 0.42)],
        64,
    )
    add("Plinth", plinth, pillar)
    joints = {
        "foot": ((0.02, 0.0, 0.0), 0.055),
        "knee": ((0.05, -0.03, 0.48), 0.075),
        "hip": ((0.0, 0.0, 0.95), 0.125),
        "waist": ((-0.02, 0.0, 1.14), 0.105),
        "chest": ((0.03, 0.0, 1.36), 0.145),
        "neck": ((0.06, 0.0, 1.53), 0.055),
        "chin": ((0.09, -0.01, 1.62), 0.085),
        "head": ((0.12, -0.01, 1.76), 0.1),
        "shoulder left": ((-0.15, 0.0, 1.44), 0.065),
        "elbow left": ((-0.38, -0.05, 1.62), 0.048),
        "hand left": ((-0.52, -0.08, 1.9), 0.035),
        "shoulder right": ((0.2, 0.0, 1.44), 0.065),
        "elbow right": ((0.47, -0.02, 1.4), 0.048),
        "hand right": ((0.75, -0.08, 1.5), 0.035),
        "thigh": ((-0.22, 0.1, 0.86), 0.09),
        "knee back": ((-0.45, 0.2, 0.72), 0.07),
        "foot back": ((-0.82, 0.28, 0.86), 0.04),
    }
    bones = ["foot knee", "knee hip", "hip waist", "waist chest", "chest neck", "neck chin", "chin head"]
    pairs = [tuple(bone.split(" ")) for bone in bones]
    pairs += [("chest", "shoulder left"), ("shoulder left", "elbow left"), ("elbow left", "hand left")]
    pairs += [("chest", "shoulder right"), ("shoulder right", "elbow right"), ("elbow right", "hand right")]
    pairs += [("hip", "thigh"), ("thigh", "knee back"), ("knee back", "foot back")]
    names = list(joints)
    mesh = bpy.data.meshes.new("Dancer")
    mesh.from_pydata([place for place, _ in joints.values()], [(names.index(a), names.index(b)) for a, b in pairs], [])
    dancer = add("Dancer", mesh, location=(0.0, 0.0, 0.44))
    dancer.modifiers.new("Skin", "SKIN")
    mesh.skin_vertices[0].data[names.index("hip")].use_root = True
    for vertex, (_, radius) in zip(mesh.skin_vertices[0].data, joints.values()):
        vertex.radius = (radius, radius)
    smooth = dancer.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 2
    bpy.context.view_layer.update()
    made = of_object(dancer)
    pattern(made, "core", size=0.09, sharpness=1.5)
    shine(made, 160.0, kelvins=3800.0, camera=0.04)
    camera((0.9, -4.6, 1.15), (0.0, 0.4, 1.3), 42.0)


@recipe("Fractal crystal", samples=16, gallery=True)
def fractal_crystal(scene) -> None:
    """The crystals in this cave are fractals.

    1. Choose Add > Light > SDF Lamp > Fractals > **Octahedron Flake**. Set *Levels* to 3, and press S Z 2.1 to
       stretch it.
    2. Choose Pattern > **Expression**, and write `0.15 + (height ** 2)`. The tips are then brightest.
    3. Set *Color* to 0.08, 0.8, 1, *Power* to 55 W, and *Camera Brightness* to 0.12.
    4. Add smaller copies (Shift D), and tilt them outwards. Give them less power and other colours.
    5. Put stones around them for the cave. Fill the world with fog of *Density* 0.03.
    """
    surfaces.fog(0.03, ambient=(0.003, 0.005, 0.008))
    rock = surfaces.stone("Rock", (0.16, 0.14, 0.15), 1.6, 0.14)
    surfaces.floor(surfaces.wet("Ground", (0.045, 0.04, 0.045), 1.4, (0.06, 0.5)), (20.0, 20.0))
    chance = random.Random(14)
    body = smooth_profile([(0.0, -0.9), (0.7, -0.55), (1.0, 0.0), (0.55, 0.6), (0.0, 1.0)], 5)
    shapes = [turned("Stone", body, 9 + 2 * index) for index in range(3)]
    for index in range(90):
        angle = chance.uniform(-0.25, math.pi + 0.25)
        ring = chance.uniform(1.7, 3.4)
        size = chance.uniform(0.35, 1.0) * (0.4 + 0.25 * ring)
        up = chance.uniform(0.0, 3.2)
        thing = add(
            "Stone", shapes[index % 3], rock, location=(ring * math.cos(angle), 0.6 + ring * math.sin(angle), up)
        )
        thing.scale = (size, size * chance.uniform(0.6, 1.2), size * chance.uniform(0.6, 1.3))
        thing.rotation_euler = [chance.uniform(-1, 1) for _ in range(3)]
    for index in range(14):
        angle = 2.0 * math.pi * index / 14.0
        size = chance.uniform(0.12, 0.28)
        thing = add(
            "Stone", shapes[index % 3], rock, location=(0.75 * math.cos(angle), 0.75 * math.sin(angle), 0.25 * size)
        )
        thing.scale = (size, size, size)
        thing.rotation_euler = [chance.uniform(-1, 1) for _ in range(3)]
    crystals = [
        ((0.0, 0.0, 0.85), (0, 6, 15), 0.75, (0.08, 0.8, 1.0), 55.0),
        ((-0.52, -0.1, 0.42), (5, -28, 40), 0.4, (0.25, 0.4, 1.0), 20.0),
    ]
    crystals += [
        ((0.5, -0.12, 0.46), (-8, 26, 70), 0.44, (0.15, 0.55, 1.0), 20.0),
        ((0.1, -0.5, 0.26), (18, 8, 20), 0.27, (0.5, 0.25, 1.0), 9.0),
    ]
    for place, turn, size, color, power in crystals:
        made = primitive("octahedron_flake", place, turn, radius=1.0, levels=3)
        made.scale = (0.62 * size, 0.62 * size, 1.3 * size)
        pattern(made, "0.15 + (height ** 2)")
        shine(made, power, color, camera=0.12)
    camera((0.25, -3.7, 1.0), (0.0, 0.0, 0.82), 40.0)


@recipe("Light in ice", samples=12)
def light_in_ice(scene) -> None:
    """Lamps are frozen in blocks of ice.

    1. Model a block with rounded edges. Give it a **Glass BSDF** with an *IOR* of 1.31, and a *Bump* from a Noise
       Texture.
    2. Put a lamp inside: the preset **Koch Snowflake**, half as large as the block.
    3. Set *Power* to 16 W, and *Color* to 0.25, 0.6, 1.
    4. Leave *Refractive Caustics* on, so that light passes through the ice onto the ground.
    """
    world((0.012, 0.016, 0.026))
    snow = Graph("Snow")
    place = snow.node("ShaderNodeTexCoord", "Object")
    drift = snow.node("ShaderNodeTexNoise", Vector=place, Scale=4.0, Detail=5.0)
    snow.finish(
        snow.node(
            "ShaderNodeBsdfPrincipled", Base_Color=(0.72, 0.76, 0.8), Roughness=0.6, Normal=snow.bump(drift, 0.08)
        )
    )
    surfaces.floor(snow.material, (16.0, 16.0))
    ice = Graph("Ice")
    place = ice.node("ShaderNodeTexCoord", "Object")
    cracks = ice.node("ShaderNodeTexNoise", Vector=place, Scale=5.0, Detail=5.0, Roughness=0.6)
    ice.finish(
        ice.node(
            "ShaderNodeBsdfGlass", Color=(0.9, 0.96, 1.0), Roughness=0.02, IOR=1.31, Normal=ice.bump(cracks, 0.025)
        )
    )
    blocks = [
        ((0.0, 0.0), 0.62, 12, "snowflake", (0.25, 0.6, 1.0), 16.0),
        ((-0.85, 0.35), 0.5, -20, "star", (1.0, 0.35, 0.12), 9.0),
    ]
    blocks += [
        ((0.82, 0.3), 0.54, 35, "neon_heart", (1.0, 0.12, 0.25), 9.0),
        ((0.42, -0.62), 0.3, -8, "pearl", (0.3, 1.0, 0.75), 3.0),
    ]
    for (x, y), size, turn, name, color, power in blocks:
        add(
            "Ice",
            box("Ice", (size, 0.8 * size, 1.15 * size), 0.07 * size, 4),
            ice.material,
            location=(x, y, 0.575 * size),
            rotation=(0, 0, turn),
        )
        made = preset(name, (x, y, 0.6 * size), (0, 0, turn), 0.5 * size)
        shine(made, power, color)
    camera((0.1, -2.7, 1.05), (0.0, 0.05, 0.34), 40.0)


CURTAIN = """\
swing = slider(9, 0, 30)       # how far the curtain swings, in metres
phase = slider(0, 0, 10)       # animate it
wave = swing * sin(0.07 * p.x + phase) + 0.45 * swing * sin(0.16 * p.x - 1.7 * phase + 1) + 0.3 * p.x
field((abs(p.y - wave) - 0.9) / 2.4) & box(75, 45, 15)
"""
RAYS = """\
rays = 0.25 + smoothstep(-0.3, 0.7, noise((0.55 * p.x, 0.1, 0.02 * p.z))) * (0.6 + 0.4 * noise((2.3 * p.x, 5, 0)))
fall = smoothstep(0, 0.3, height) * (1 - height) ** 2
ramp(height, 0, (0.1, 1, 0.35), 0.35, (0.1, 0.9, 0.5), 0.7, (0.35, 0.2, 0.9), 1, (0.6, 0.1, 0.7)) * rays * fall
"""


@recipe("Aurora", samples=8, gallery=True, shape=CURTAIN, pattern=RAYS)
def aurora(scene) -> None:
    """A curtain of light hangs above mountains and a lake. It is 150 metres wide.

    1. Choose Add > Light > SDF Lamp > **From an Expression**. Press *New* beside *Text*, and write the shape. It is
       a thin sheet along a wave, inside a box.
    2. Choose Pattern > **Expression**, and write the pattern. It is green below and violet above, with vertical
       rays.
    3. Set *Power* to 60 kW, and *Camera Brightness* to 0.6.
    4. Animate *Phase* to move the curtain.
    5. Model mountains, and a lake with a *Roughness* of 0.03.
    """
    graph = world((0.004, 0.008, 0.022))
    background = next(node for node in graph.nodes if node.bl_idname == "ShaderNodeBackground")
    cells = graph.node(
        "ShaderNodeTexVoronoi", "Distance", Vector=graph.node("ShaderNodeTexCoord", "Generated"), Scale=110.0
    )
    stars = graph.node("ShaderNodeMapRange", Value=cells, _1=0.05, _2=0.13, _3=0.5, _4=0.006)
    tint = graph.node("ShaderNodeMix", data_type="RGBA", _0=stars, _1=(0.0, 0.0, 0.0), _2=(0.75, 0.9, 1.6))
    graph.links.new(tint, background.inputs["Color"])
    curtain = expression(
        "Aurora",
        CURTAIN,
        (0.0, 95.0, 47.0),
    )
    pattern(
        curtain,
        RAYS,
    )
    shine(curtain, 60000.0, (1.0, 1.0, 1.0), camera=0.6)
    steps = 120
    y, x = np.mgrid[0:steps, 0:steps] / (steps - 1.0)
    chance = np.random.default_rng(4)
    height = np.zeros_like(x)
    for octave in range(6):
        for _ in range(3):
            turn, phase = chance.uniform(0.0, 2.0 * math.pi, 2)
            wave = np.sin(2.0 * math.pi * 1.7 * 1.9**octave * (x * math.cos(turn) + y * math.sin(turn)) + phase)
            height += (1.0 - np.abs(wave)) * 0.55**octave / 3.0
    height = 26.0 * (height - np.quantile(height, 0.3)) * (0.1 + y)
    mesh = bpy.data.meshes.new("Mountains")
    vertices = np.stack([230.0 * (x - 0.5), 30.0 + 110.0 * y, height], axis=2).reshape(-1, 3)
    cell = (np.arange(steps - 1)[:, None] * steps + np.arange(steps - 1)[None]).ravel()
    mesh.from_pydata(vertices.tolist(), [], np.stack([cell, cell + 1, cell + steps + 1, cell + steps], axis=1).tolist())
    mesh.shade_smooth()
    add("Mountains", mesh, principled("Snow", (0.6, 0.62, 0.66), 0.7))
    lake = surfaces.water("Lake", (0.004, 0.01, 0.015), 0.03, 0.9, 0.05, 0.4)
    surfaces.floor(lake, (300.0, 160.0), (0.0, 60.0, 0.6))
    camera((0.0, -12.0, 3.2), (0.0, 60.0, 19.0), 62.0)
