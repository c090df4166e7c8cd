# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders lamps that are made of texts, curves, a picture and a network, for docs/lamps.md.

python object_lamps.py [--out FILE.png] [--samples 8] [--size 720x360]
"""

from __future__ import annotations

import argparse
import math
import pathlib
import sys

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY))

from sdf_lights import blender  # noqa: E402
from sdf_lights.blender.naming import ENGINE  # noqa: E402

UPRIGHT = (math.pi / 2.0, 0.0, 0.0)


def add(name: str, data, location=(0.0, 0.0, 0.0), rotation=UPRIGHT) -> bpy.types.Object:
    """A new object of the scene."""
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(obj)
    return obj


def text(body: str, size: float, **settings) -> bpy.types.Curve:
    """A text around its middle."""
    curve = bpy.data.curves.new(body, "FONT")
    curve.body, curve.size, curve.align_x = body, size, "CENTER"
    for name, value in settings.items():
        setattr(curve, name, value)
    return curve


def bend() -> bpy.types.Curve:
    """A tube that tapers towards its ends."""
    curve = bpy.data.curves.new("Bend", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.06
    spline = curve.splines.new("NURBS")
    turn = np.linspace(0.0, 5.0 * math.pi, 24)
    spline.points.add(len(turn) - 1)
    spline.use_endpoint_u, spline.order_u = True, 4
    for index, (point, a) in enumerate(zip(spline.points, turn)):
        point.co = (0.35 * math.cos(a), 0.08 * a, 0.35 * math.sin(a), 1.0)
        point.radius = 0.15 + math.sin(math.pi * index / (len(turn) - 1))
    return curve


def logo(size: int = 256) -> bpy.types.Image:
    """A star with a hole, as a picture with alpha."""
    y, x = (np.mgrid[:size, :size] + 0.5) / size - 0.5
    angle, radius = np.arctan2(x, y), np.hypot(x, y)
    fold = np.abs((angle + math.pi / 5.0) % (2.0 * math.pi / 5.0) - math.pi / 5.0)
    edge = 0.46 * math.sin(math.radians(18.0)) / np.sin(math.radians(18.0) + fold)
    inside = np.minimum(edge - radius, radius - 0.09)
    image = bpy.data.images.new("Logo", size, size, alpha=True)
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., 3] = np.clip(inside * size + 0.5, 0.0, 1.0)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def lamp_of(obj: bpy.types.Object, form: str, power: float, color) -> bpy.types.Object:
    """The lamp that *To SDF Lamp* makes of an object."""
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.sdf_lights.object_to_lamp(form=form, power=power)
    made = bpy.context.active_object
    made.data.color, made.data.sdf_lamp.camera_brightness = color, 0.25
    return made


def build() -> None:
    """The scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    material = bpy.data.materials.new("Plaster")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value, shader.inputs["Roughness"].default_value = (0.3, 0.3, 0.32, 1.0), 0.35
    for name, location, rotation in (("Floor", (0, 0, 0), (0, 0, 0)), ("Wall", (0, 0.6, 0), UPRIGHT)):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
        mesh.materials.append(material)
        add(name, mesh, location, rotation)

    open_ = add("Open", text("open", 1.15), (-1.5, 0.3, 1.3))
    made = lamp_of(open_, "NEON", 40.0, (1.0, 0.16, 0.07))
    made.data.sdf_lamp.neon_radius, made.data.sdf_lamp.neon_gap = 0.022, 0.05
    lamp_of(
        add("24", text("24h", 0.9, extrude=0.06, bevel_depth=0.03), (-1.7, 0.0, 0.06)), "SOLID", 30.0, (0.35, 0.6, 1.0)
    )
    lamp_of(
        add("Bend", bend(), (0.25, -0.2, 0.45), (0.0, 0.0, 0.0)), "SOLID", 30.0, (1.0, 0.7, 0.35)
    ).parent.rotation_euler = (
        math.radians(90.0),
        0.0,
        0.0,
    )
    light = bpy.data.lights.new("Logo", "POINT")
    light.energy, light.color = 30.0, (0.4, 1.0, 0.45)
    lamp = light.sdf_lamp
    lamp.use, lamp.source, lamp.image, lamp.image_size, lamp.thickness = True, "IMAGE", logo(), 1.7, 0.15
    lamp.camera_brightness = 0.25
    add("Logo", light, (1.95, 0.2, 1.1))

    light = bpy.data.lights.new("Rabbit", "POINT")
    light.energy, light.color = 12.0, (1.0, 0.55, 0.6)
    light.sdf_lamp.use, light.sdf_lamp.source, light.sdf_lamp.camera_brightness = True, "NETWORK", 0.25
    add("Rabbit", light, (0.95, -0.9, 0.26), (0.0, 0.0, math.radians(-20.0))).scale = (0.5, 0.5, 0.5)

    camera = add("Camera", bpy.data.cameras.new("Camera"), (0.1, -6.2, 1.5), (math.radians(86.0), 0.0, 0.0))
    camera.data.lens = 40.0
    scene.camera = camera


def main(arguments: list[str]) -> None:
    """Render the picture."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs" / "images" / "lamps_of_objects.png")
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--size", default="720x360")
    options = parser.parse_args(arguments)
    blender.register()
    build()
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    scene.render.resolution_x, scene.render.resolution_y = map(int, options.size.split("x"))
    scene.sdf_lights.samples, scene.sdf_lights.noise_threshold, scene.sdf_lights.denoise = options.samples, 0.0, True
    scene.sdf_lights.max_bounces = 3
    scene.render.filepath = str(options.out.resolve())
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(sys.argv[1:])
