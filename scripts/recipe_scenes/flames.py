# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm light: lanterns, a fire, a bulb, a lamp that pulses."""

from __future__ import annotations

import math
import random

from scenery.materials import Graph, principled
from scenery.modelling import add, box, rod, smooth_profile, turned
from scenery.staging import camera, world

from . import surfaces
from .stage import expression, pattern, preset, recipe, shine


@recipe("Paper lanterns", samples=12, gallery=True)
def paper_lanterns(scene) -> None:
    """Paper lanterns hang above a pond at night.

    1. Choose Add > Light > SDF Lamp > Presets > **Ribbed Lantern**. Scale it by 0.7. The slider *Ribs* sets the
       number of ribs.
    2. Set *Temperature* to 2000 K, *Power* to 30 W, and *Camera Brightness* to 0.16.
    3. Press Alt D for each other lantern. The copies are linked: if you change one, all change. Scale them by 0.8
       to 1.
    4. Model the water: a plane with a *Roughness* of 0.02 and a *Bump* node.
    """
    world((0.006, 0.012, 0.035))
    water = surfaces.water("Water", (0.005, 0.012, 0.016), 0.02, 3.5, 0.03, 0.5)
    surfaces.floor(water, (40.0, 40.0), (0.0, 12.0, 0.0))
    wood = surfaces.wood("Planks", (0.26, 0.16, 0.1), (0.13, 0.08, 0.05), 0.5)
    for index in range(9):
        add("Plank", box("Plank", (0.19, 5.0, 0.05), 0.008), wood, location=(-0.8 + 0.2 * index, -0.6, 0.22))
    for x in (-0.95, 0.95):
        for y in (0.2, 1.8):
            rod("Post", (x, y, -0.3), (x, y, 1.0), 0.05, wood)
        rod("Rail", (x, 0.1, 0.85), (x, 1.9, 0.85), 0.025, wood)
    chance = random.Random(3)
    first = shine(preset("lantern", (-0.72, 1.9, 1.5), scale=0.7), 30.0, kelvins=2000.0, camera=0.16)
    string = surfaces.metal("String", (0.05, 0.05, 0.05), 0.6)
    places = [(0.95, 2.6, 1.75, 0.8), (-2.2, 4.0, 1.7, 0.9), (2.6, 4.8, 1.45, 0.9), (0.05, 5.6, 1.6, 0.9)]
    places += [(-4.2, 7.4, 1.6, 1.0), (5.0, 8.6, 1.8, 1.0), (-1.5, 9.5, 1.9, 1.0), (2.2, 11.5, 2.2, 1.0)]
    for x, y, z, size in places:
        copy = first.copy()
        copy.location, copy.scale = (x, y, z), (size,) * 3
        copy.rotation_euler.z = chance.uniform(0.0, 1.0)
        scene.collection.objects.link(copy)
    for x, y, z, size in [(-0.72, 1.9, 1.5, 0.7), *places]:
        rod("String", (x, y, z + 0.45 * size), (x, y, z + 3.0), 0.004, string, steps=6)
    camera((0.1, -2.4, 1.75), (0.0, 4.0, 1.02), 52.0)


@recipe("Campfire", samples=12)
def campfire(scene) -> None:
    """A fire burns between stones. Its pattern gives it the colours of a flame.

    1. Choose Add > Light > SDF Lamp > Presets > **Campfire**. Put it on the logs.
    2. In the panel Pattern, *Bottom* and *Top* are temperatures. Set *Bottom* to 2200 K.
    3. Set *Power* to 130 W, and *Camera Brightness* to 0.035.
    4. To make the flames rise, animate *Rise*. Hold the mouse over it, and press I at two frames with different
       values.
    5. Set the colour of the world to a dark blue.
    """
    world((0.014, 0.024, 0.06))
    surfaces.floor(surfaces.stone("Earth", (0.09, 0.065, 0.045), 2.0, 0.12), (30.0, 30.0))
    bark = surfaces.stone("Bark", (0.13, 0.08, 0.05), 9.0, 0.06)
    chance = random.Random(8)
    for index in range(7):
        angle = 2.0 * math.pi * index / 7.0 + 0.2
        foot = (0.52 * math.cos(angle), 0.52 * math.sin(angle), 0.05)
        tip = (-0.05 * math.cos(angle), -0.05 * math.sin(angle), 0.36)
        rod("Log", foot, tip, chance.uniform(0.045, 0.065), bark)
    rock = surfaces.stone("Rock", (0.2, 0.19, 0.18), 6.0, 0.06)
    for index in range(13):
        angle = 2.0 * math.pi * index / 13.0
        size = chance.uniform(0.1, 0.16)
        shape = turned("Stone", smooth_profile([(0.0, -0.8), (0.75, -0.5), (1.0, 0.05), (0.7, 0.6), (0.0, 0.8)], 4), 24)
        thing = add("Stone", shape, rock, location=(0.82 * math.cos(angle), 0.82 * math.sin(angle), 0.6 * size))
        thing.scale = (size, size * chance.uniform(0.8, 1.3), size * chance.uniform(0.7, 1.0))
        thing.rotation_euler.z = chance.uniform(0.0, 3.0)
    for x, y, turn in ((-1.75, 0.55, 70), (1.7, 0.75, 115), (0.1, 1.9, 5)):
        log = rod("Seat", (-0.6, 0.0, 0.0), (0.6, 0.0, 0.0), 0.17, bark)
        log.matrix_world = log.matrix_world.copy()
        log.location, log.rotation_euler = (x, y, 0.16), (math.radians(90), 0.0, math.radians(turn + 90))
    pine = principled("Pine", (0.02, 0.045, 0.025), 0.9)
    for index in range(26):
        x, y = chance.uniform(-7.0, 7.0), chance.uniform(3.2, 9.0)
        height = chance.uniform(2.6, 4.6)
        for level in range(5):
            z, radius = height * (0.12 + 0.17 * level), 0.23 * height * (1.0 - 0.17 * level)
            cone = turned("Tier", [(radius, 0.0), (0.6 * radius, 0.1 * height), (0.0, 0.32 * height)], 14)
            add("Tier", cone, pine, location=(x, y, z), rotation=(0, 0, 40 * level))
    fire = shine(preset("campfire", (0.0, 0.0, 0.55), scale=1.0), 130.0, camera=0.035)
    fire.data["sdf_emission.bottom"], fire.data["sdf_emission.rise"] = 2200.0, 0.4
    camera((0.55, -3.3, 1.0), (0.0, 0.4, 0.6), 44.0)


@recipe("Glass bulb with a filament", samples=48, gallery=True)
def glass_bulb(scene) -> None:
    """Glass bulbs have glowing coils inside.

    1. Model a bulb: draw half of its outline, and add a **Screw** modifier.
    2. Make a material for thin glass: a **Mix Shader** of **Transparent BSDF** and **Glossy BSDF**, with a
       **Fresnel** node as its factor. Light passes through it in a straight line, so the picture has little noise.
    3. Choose Add > Light > SDF Lamp > Presets > **Filament**. Set *Radius* to 0.11 m, *Pitch* to 0.07 m, *Turns* to
       6 and *Wire* to 0.009 m. Scale it by 0.15, and put it into the bulb.
    4. Set *Temperature* to 2000 K, *Power* to 2.2 W, and *Camera Brightness* to 0.003. With more brightness, the
       coil would be a white spot.
    5. In the properties of the camera, turn on *Depth of Field*, and set *F-Stop* to 4.
    """
    world((0.045, 0.045, 0.05))
    surfaces.floor(surfaces.wood("Board", (0.24, 0.14, 0.085), (0.1, 0.055, 0.035), 0.4), (3.0, 3.0))
    surfaces.wall(principled("Wall", (0.1, 0.12, 0.13), 0.8), 0.75, (4.0, 2.0))
    thin = Graph("Thin Glass")
    through, mirror = (
        thin.node("ShaderNodeBsdfTransparent", Color=(0.98, 0.95, 0.9)),
        thin.node("ShaderNodeBsdfGlossy", Roughness=0.02),
    )
    clear = thin.finish(
        thin.node("ShaderNodeMixShader", _0=thin.node("ShaderNodeFresnel", IOR=1.5), _1=through, _2=mirror)
    )
    outline = [
        (0.0, 0.135),
        (0.028, 0.13),
        (0.047, 0.105),
        (0.05, 0.08),
        (0.042, 0.05),
        (0.024, 0.015),
        (0.017, -0.005),
    ]
    outer = smooth_profile(outline[::-1], 10)
    brass = surfaces.metal("Brass", (0.75, 0.5, 0.2), 0.25)
    black = principled("Socket", (0.02, 0.02, 0.02), 0.3)
    steel = surfaces.metal("Wire", (0.4, 0.4, 0.4), 0.3)
    for x, y, power in ((0.0, 0.0, 2.2), (-0.2, 0.22, 1.1), (0.24, 0.3, 1.1)):
        z = 0.075
        add("Bulb", turned("Bulb", outer, 96), clear, location=(x, y, z))
        thread = [(0.0, -0.03)] + [(0.016 + 0.0012 * math.cos(1.6 * k), -0.03 + 0.0022 * k) for k in range(14)]
        add("Cap", turned("Cap", [*thread, (0.0, 0.001)], 48), brass, location=(x, y, z))
        base = [(0.0, -0.075), (0.045, -0.075), (0.045, -0.068), (0.024, -0.06), (0.022, -0.024), (0.0, -0.024)]
        add("Base", turned("Base", base, 64), black, location=(x, y, z))
        for side in (-1.0, 1.0):
            rod("Support", (x + side * 0.006, y, z), (x + side * 0.012, y, z + 0.055), 0.0007, steel, steps=8)
        coil = preset("spring", (x, y, z + 0.08), scale=0.15, radius=0.11, wire=0.009, turns=6, pitch=0.07)
        shine(coil, power, kelvins=2000.0, camera=0.003)
    view = camera((0.02, -0.55, 0.15), (0.012, 0.0, 0.125), 30.0, aperture=4.0, focus=(0.0, 0.0, 0.15))
    view.data.clip_start = 0.01


EGG = """\
top = slider(0.2, 0.1, 0.5)  # radius of its upper end
egg(0.36, top, 0.4)
"""
VEINS = """\
veins = slider(7, 1, 30)  # in a metre
web = abs(noise(veins * p) + 0.5 * noise(2 * veins * p))
exp(-depth / 0.025) * (0.1 + 1.5 * exp(-9 * web)) + 0.8 * clamp(depth / 0.3, 0, 1) ** 3
"""


@recipe("Lamp that pulses", samples=8, shape=EGG, pattern=VEINS)
def pulsing_lamp(scene) -> None:
    """Eggs become brighter and darker, as if they breathe. Their power and their shape are animated.

    1. Choose Add > Light > SDF Lamp > **From an Expression**. Press *New* beside *Text*, and write the shape. The
       name `top` becomes a slider.
    2. Choose Pattern > **Expression**, and write the pattern. It makes veins below the shell.
    3. Set *Power* to 12 W at frame 1, 48 W at frame 20, and 12 W at frame 39. At each of these frames, hold the
       mouse over *Power* and press I.
    4. Do the same with *Top*: 0.18 m, 0.21 m and 0.18 m.
    5. Press Shift E in the Graph Editor, and choose **Make Cyclic**. The animation then repeats for ever.
    """
    world((0.006, 0.009, 0.014))
    surfaces.floor(surfaces.stone("Rock", (0.13, 0.12, 0.13), 1.3, 0.2), (20.0, 20.0))
    rock = surfaces.stone("Boulder", (0.15, 0.14, 0.15), 2.4, 0.12)
    chance = random.Random(21)
    body = smooth_profile([(0.0, -0.8), (0.8, -0.5), (1.0, 0.0), (0.62, 0.6), (0.0, 0.9)], 5)
    for index in range(38):
        angle, ring = chance.uniform(0.0, 2.0 * math.pi), 0.85 + 2.4 * chance.random() ** 0.8
        if math.sin(angle) * ring < -1.1:
            continue
        size = chance.uniform(0.15, 0.5) * min(1.0, 0.3 + 0.35 * ring)
        thing = add(
            "Boulder",
            turned("Boulder", body, 20),
            rock,
            location=(ring * math.cos(angle), ring * math.sin(angle), 0.3 * size),
        )
        thing.scale = (size, size * chance.uniform(0.7, 1.4), size * chance.uniform(0.8, 1.7))
        thing.rotation_euler = [chance.uniform(-0.4, 0.4), chance.uniform(-0.4, 0.4), chance.uniform(0.0, 3.0)]
    for x, y, size, first in (
        (0.0, 0.0, 1.0, 1),
        (-0.95, 0.75, 0.62, 8),
        (0.92, 0.95, 0.7, 14),
        (0.55, -0.62, 0.42, 18),
    ):
        egg = expression(
            "Egg",
            EGG,
            (x, y, 0.34 * size),
            (chance.uniform(-14, 14), chance.uniform(-14, 14), 0),
            size,
        )
        pattern(shine(egg, 30.0, (1.0, 0.22, 0.04), camera=0.12), VEINS)
        light = egg.data
        for frame, power, top in ((first, 12.0, 0.18), (first + 19, 48.0, 0.21), (first + 38, 12.0, 0.18)):
            light.energy, light["sdf_top"] = power * size, top
            light.keyframe_insert("energy", frame=frame)
            light.keyframe_insert('["sdf_top"]', frame=frame)
    scene.frame_start, scene.frame_end = 1, 38
    scene.frame_set(20)
    camera((0.15, -3.3, 1.25), (0.0, 0.2, 0.42), 40.0)
