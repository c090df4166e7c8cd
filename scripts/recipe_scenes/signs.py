# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signs: neon, texts, curves, a picture."""

from __future__ import annotations

import math

import bpy
import numpy as np
from scenery.materials import principled
from scenery.modelling import add, box, plane, rod, turned
from scenery.staging import camera, world

from . import surfaces
from .stage import of_object, pattern, preset, recipe, shine


def _text(body: str, size: float, location, **settings) -> bpy.types.Object:
    """A text that stands upright, around its middle."""
    curve = bpy.data.curves.new(body, "FONT")
    curve.body, curve.size, curve.align_x = body, size, "CENTER"
    for name, value in settings.items():
        setattr(curve, name, value)
    return add(body, curve, location=location, rotation=(90, 0, 0))


@recipe("Neon in fog", samples=14, gallery=True)
def neon_in_fog(scene) -> None:
    """Neon signs hang in a wet street. The fog glows around them.

    1. Model a street: a floor and two walls. Give the floor a *Roughness* of 0.03 where it is wet.
    2. Choose Add > Light > SDF Lamp > Presets > **Neon Ring**. Put it in front of the left wall, and turn it to the
       camera. Set *Power* to 60 W and *Tint* to 0.03, 0.4, 1.
    3. Choose Add > Light > SDF Lamp > **Neon Text**, and write `jazz`. Put it in front of the right wall. Set
       *Power* to 60 W, and choose Pattern > **Neon** with the *Tint* 1, 0.05, 0.22.
    4. Add the preset **Pearl** at the end of the street, with 260 W and 2400 K.
    5. Choose World Properties > Volume > **Volume Scatter**. Set *Density* to 0.05.
    6. Set the *Camera Brightness* of the neon to 0.05, so that the camera sees its colour.
    """
    surfaces.fog(0.05, ambient=(0.006, 0.009, 0.018))
    surfaces.floor(surfaces.wet("Asphalt", scale=0.9, gloss=(0.03, 0.35)), (14.0, 40.0), (0.0, 12.0, 0.0))
    brick = surfaces.brick("Brick")
    for side in (-1.0, 1.0):
        house = plane("House", (22.0, 7.0))
        add("House", house, brick, location=(side * 1.7, 10.0, 3.5), rotation=(90, 0, -90 * side))
    dark = principled("Door", (0.03, 0.035, 0.04), 0.4)
    steel = surfaces.metal("Steel", (0.2, 0.2, 0.21), 0.35)
    step = surfaces.stone("Step")
    for side, place in ((1.0, 2.1), (-1.0, 4.6), (1.0, 7.5)):
        add("Door", box("Door", (0.08, 1.0, 2.1), 0.01), dark, location=(side * 1.69, place, 1.05))
        add("Step", box("Step", (0.4, 1.2, 0.14), 0.01), step, location=(side * 1.55, place, 0.07))
    for side, place in ((-1.0, 3.2), (1.0, 5.6)):
        rod("Pipe", (side * 1.62, place, 0.0), (side * 1.62, place, 6.0), 0.05, steel)
    for index, x in enumerate((-1.2, -1.25)):
        crate = box("Crate", (0.55, 0.55, 0.45), 0.02)
        add(
            "Crate",
            crate,
            surfaces.wood("Crate"),
            location=(x, 1.5, 0.225 + 0.45 * index),
            rotation=(0, 0, 9 + 14 * index),
        )
    for place in (3.0, 6.5, 10.0):
        rod("Cable", (-1.7, place, 4.2), (1.7, place + 0.4, 4.0), 0.012, steel, steps=8)
    sign = of_object(_text("jazz", 0.95, (1.05, 2.9, 1.75)), "NEON")
    sign.parent.rotation_euler.z = math.radians(-32)
    sign.data.sdf_lamp.neon_radius, sign.data.sdf_lamp.neon_gap = 0.022, 0.04
    pattern(shine(sign, 60.0, (1.0, 1.0, 1.0), camera=0.05), "neon", tint=(1.0, 0.05, 0.22), depth_of_middle=0.018)
    ring = preset("neon_ring", (-1.15, 4.0, 2.2), (0, 0, 30), 1.0)
    pattern(shine(ring, 60.0, (1.0, 1.0, 1.0), camera=0.06), "neon", tint=(0.03, 0.4, 1.0))
    shine(preset("pearl", (0.25, 17.0, 3.1), scale=0.8), 260.0, kelvins=2400.0, camera=0.2)
    camera((-0.1, -2.6, 1.5), (0.05, 5.0, 1.45), 48.0)


@recipe("Neon text", samples=12)
def neon_text(scene) -> None:
    """A sign of two colours hangs on a wall of bricks. You can still edit its text.

    1. Choose Add > Light > SDF Lamp > **Neon Text**. Press Tab, and write `open`.
    2. Turn it upright (R X 90), and put it 8 cm in front of a wall.
    3. Set *Tube Radius* to 0.018 m, *Gap* to 0.04 m, *Power* to 45 W, and *Camera Brightness* to 0.06.
    4. Choose Pattern > **Neon**, which makes the middle of the tube whiter. Set *Tint* to 1, 0.12, 0.05, and *Depth
       Of Middle* to 0.015 m.
    5. Add a second text, `all night`, with *Tube Radius* 0.011 m, *Power* 14 W and *Tint* 0.06, 0.4, 1.
    """
    world((0.01, 0.012, 0.02))
    surfaces.wall(surfaces.brick("Brick", (0.2, 0.11, 0.085)), 0.0)
    sign = of_object(_text("open", 1.1, (-0.05, -0.08, 1.35)), "NEON")
    sign.data.sdf_lamp.neon_radius, sign.data.sdf_lamp.neon_gap = 0.018, 0.04
    pattern(shine(sign, 45.0, (1.0, 1.0, 1.0), camera=0.06), "neon", tint=(1.0, 0.12, 0.05), depth_of_middle=0.015)
    under = of_object(_text("all night", 0.42, (0.38, -0.08, 0.88)), "NEON")
    under.data.sdf_lamp.neon_radius, under.data.sdf_lamp.neon_gap = 0.011, 0.02
    pattern(shine(under, 14.0, (1.0, 1.0, 1.0), camera=0.05), "neon", tint=(0.06, 0.4, 1.0), depth_of_middle=0.009)
    board = principled("Shelf", (0.05, 0.05, 0.055), 0.25)
    add("Ledge", box("Ledge", (6.0, 0.5, 0.06), 0.01), board, location=(0.0, -0.25, 0.5))
    camera((-0.85, -3.0, 1.0), (0.0, 0.0, 1.28), 44.0)


@recipe("Glowing logo from a picture", samples=8)
def glowing_logo(scene) -> None:
    """A picture with transparency becomes a sign that lights the wall behind it.

    1. Add any SDF lamp, and choose Shape > Source > **Image**. Open a picture with an alpha channel.
    2. Set *Width* to 1.25 m, *Thickness* to 0.05 m, and *Power* to 45 W.
    3. Put it 7 cm in front of the wall, so that the wall glows around it.
    4. For a dark front, copy the lamp, and choose Object > Convert > **SDF Lamp to Mesh**. Move the mesh 5.5 cm to
       the front, make it half as thick, and give it a dark metal.
    """
    world((0.008, 0.009, 0.012))
    size = 256
    y, x = (np.mgrid[:size, :size] + 0.5) / size - 0.5
    angle, radius = np.arctan2(x, y), np.hypot(x, y)
    turn = np.abs((angle % (2.0 * math.pi / 6.0)) - math.pi / 6.0)
    petals = 0.27 + 0.17 * np.cos(6.0 * angle) - radius
    inside = np.minimum(np.maximum(petals, 0.03 - np.abs(radius - 0.45)), radius - 0.09 - 0.02 * turn)
    picture = bpy.data.images.new("Logo", size, size, alpha=True)
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., 3] = np.clip(inside * size + 0.5, 0.0, 1.0)
    picture.pixels.foreach_set(pixels.ravel())
    picture.pack()
    concrete = surfaces.stone("Concrete", (0.34, 0.33, 0.32), 1.2, 0.03)
    surfaces.wall(concrete, 0.0)
    made = preset("pearl", (0.0, -0.07, 1.3), (90, 0, 0))
    made.name = "Logo"
    settings = made.data.sdf_lamp
    settings.source, settings.image, settings.image_size, settings.thickness = "IMAGE", picture, 1.25, 0.05
    shine(made, 45.0, (1.0, 0.52, 0.16), camera=0.2)
    copy = made.copy()
    copy.data = made.data.copy()
    scene.collection.objects.link(copy)
    bpy.ops.object.select_all(action="DESELECT")
    copy.select_set(True)
    bpy.context.view_layer.objects.active = copy
    bpy.ops.sdf_lights.lamp_to_mesh(resolution=160)
    front = bpy.context.active_object
    front.location.y -= 0.055
    front.scale.z = 0.5
    front.data.materials.clear()
    front.data.materials.append(surfaces.metal("Anthracite", (0.16, 0.16, 0.17), 0.3))
    camera((-0.95, -2.5, 0.95), (0.02, 0.0, 1.3), 40.0)


@recipe("Lamp along a curve", samples=16)
def curve_lamp(scene) -> None:
    """A curved tube of light hangs above a dinner table.

    1. Add a NURBS path, and draw a loop with it. Set its *Bevel Depth* to 0.02 m, and the *Radius* of its end
       points to 0.3.
    2. Choose Object > Convert > **To SDF Lamp**. When you edit the curve, the lamp follows.
    3. Set *Temperature* to 3000 K, *Power* to 95 W, and *Camera Brightness* to 0.07.
    4. Hang it from two thin cylinders.
    """
    world((0.004, 0.006, 0.012))
    plaster = principled("Plaster", (0.24, 0.27, 0.28), 0.9)
    surfaces.wall(plaster, 1.9, (12.0, 4.0))
    surfaces.floor(surfaces.wood("Floor", (0.3, 0.2, 0.13), (0.2, 0.12, 0.07)), (10.0, 8.0))
    wood = surfaces.wood("Walnut")
    add("Table", box("Table", (2.6, 1.0, 0.05), 0.01, grain=0), wood, location=(0.0, 0.4, 0.75))
    steel = surfaces.metal("Steel", (0.1, 0.1, 0.1), 0.4)
    for x in (-1.15, 1.15):
        for y in (0.05, 0.75):
            rod("Leg", (x, y, 0.0), (0.97 * x, y, 0.73), 0.025, steel)
    white = principled("Porcelain", (0.75, 0.74, 0.72), 0.15)
    plate = turned("Plate", [(0.0, 0.0), (0.08, 0.0), (0.14, 0.018), (0.14, 0.022), (0.08, 0.006), (0.0, 0.006)])
    clear = surfaces.glass("Glass", (0.96, 0.98, 1.0))
    cup = turned("Tumbler", [(0.0, 0.0), (0.032, 0.0), (0.04, 0.11), (0.037, 0.11), (0.03, 0.01), (0.0, 0.01)])
    for x in (-0.8, 0.0, 0.8):
        for y, turn in ((0.12, 0), (0.68, 180)):
            add("Plate", plate, white, location=(x, y, 0.776))
            add("Glass", cup, clear, location=(x + 0.2, y + 0.08, 0.776), rotation=(0, 0, turn))
    seat = principled("Seat", (0.25, 0.07, 0.04), 0.8, Sheen_Weight=0.3)
    for x in (-0.75, 0.75):
        for y, side in ((-0.35, 1), (1.15, -1)):
            add("Chair", box("Seat", (0.46, 0.44, 0.06), 0.02), seat, location=(x, y, 0.45))
            back = (x, y - side * 0.22, 0.72)
            add("Chair", box("Back", (0.44, 0.04, 0.36), 0.02), seat, location=back, rotation=(side * 8, 0, 0))
            for dx in (-0.19, 0.19):
                for dy in (-0.18, 0.18):
                    rod("Leg", (x + dx, y + dy, 0.0), (x + dx, y + dy, 0.43), 0.012, steel, steps=8)
    curve = bpy.data.curves.new("Ribbon", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.resolution_u = "3D", 0.02, 8
    spline = curve.splines.new("NURBS")
    turn = np.linspace(0.0, 2.0 * math.pi * 3.0, 28)
    spline.points.add(len(turn) - 1)
    spline.use_endpoint_u, spline.order_u = True, 4
    for index, (point, a) in enumerate(zip(spline.points, turn)):
        along = index / (len(turn) - 1)
        swing = 0.26 * math.sin(math.pi * along)
        point.co = (2.2 * along - 1.1, swing * math.cos(a), swing * math.sin(a) + 0.06 * math.sin(2.0 * a), 1.0)
        point.radius = 0.3 + 0.7 * min(1.0, 4.0 * along * (1.0 - along) * 2.0)
    thing = add("Ribbon", curve, location=(0.0, 0.4, 1.72))
    shine(of_object(thing), 95.0, kelvins=3000.0, camera=0.07)
    for x in (-1.1, 1.1):
        rod("Wire", (x, 0.4, 1.72), (x, 0.4, 3.4), 0.003, steel, steps=8)
    camera((-1.5, -3.0, 1.7), (0.05, 0.5, 1.18), 44.0)
