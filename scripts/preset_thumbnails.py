# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the pictures of the lamp presets, which Blender shows in the choice of presets, into their folder.

Each is a preset as Blender adds it, above a floor, in Blender's own start-up scene with its world and its view
transform.
"""

from __future__ import annotations

import argparse
import math
import pathlib
import re
import sys
import tempfile

import bpy
import host
import numpy as np
import OpenImageIO
from mathutils import Vector

from sdf_lights.blender.shader_trees import use_nodes

EYE, TARGET = Vector((1.7, -3.4, 1.1)), Vector((0.0, 0.0, 0.42))
HOVER = 0.15  # metres above the floor
MARGIN = 1.25  # of the picture's height to the lamp's size
POINTS = 20_000  # number of points tested for the extent of a lamp
FLOOR = 0.18  # its albedo
# Scene-linear radiance that the camera sees at the 90th percentile of the visible lamp. AgX shows colours of that
# brightness bright and still saturated.
BRIGHT = 1.6
BRIGHTEST_TENTH = 0.9
SEEN = 0.05  # of the greatest radiance: above it, there is a lamp


def scene_of(name: str, size: int, samples: int) -> bpy.types.Object:
    """Blender's start-up scene with this preset in place of the cube and the light; returns the lamp."""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    for obj in list(scene.objects):
        if obj.type != "CAMERA":
            bpy.data.objects.remove(obj)
    scene.render.engine = "SDF_LIGHTS"
    settings = scene.sdf_lights
    settings.samples, settings.noise_threshold, settings.denoise = samples, 0.0, True
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    bpy.ops.sdf_lights.lamp_add(source="PRESET", preset=name.upper())
    lamp = bpy.context.object
    shape = host.program("blender.lamp").shape_of(lamp.data.sdf_lamp)
    low, high = shape.bounds()
    points = np.random.default_rng(0).uniform(low, high, (POINTS, 3))
    inside = points[shape.distance(points) <= 0.0]
    radius = float(np.linalg.norm(inside - 0.5 * (low + high), axis=1).max())
    lamp.location.z = HOVER - low[2]
    bpy.ops.mesh.primitive_plane_add(size=40.0)
    floor = bpy.data.materials.new("Floor")
    use_nodes(floor).nodes["Principled BSDF"].inputs["Base Color"].default_value = (FLOOR, FLOOR, FLOOR, 1.0)
    bpy.context.object.data.materials.append(floor)
    camera = scene.camera
    middle = Vector((0.0, 0.0, HOVER + 0.5 * float(high[2] - low[2])))
    back = (EYE - TARGET).normalized()
    distance = MARGIN * radius / math.tan(0.5 * camera.data.angle)
    camera.location = middle + distance * back
    camera.rotation_euler = back.to_track_quat("Z", "Y").to_euler()
    return lamp


def rendered(path: pathlib.Path, kind: str) -> np.ndarray:
    """The scene's picture, (height, width, 3), from a file of that kind."""
    settings = bpy.context.scene.render
    settings.image_settings.file_format = kind
    settings.image_settings.color_mode = "RGB"
    settings.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)[..., :3]


def brightness_of(lamp: bpy.types.Object, folder: pathlib.Path) -> float:
    """The factor that makes the lamp as bright as ``BRIGHT`` for the camera."""
    scene = bpy.context.scene
    scene.world = None
    for obj in list(scene.objects):
        if obj.type == "MESH" and not obj.hide_render:
            bpy.data.objects.remove(obj)
    lamp.data.sdf_lamp.camera_brightness = 1.0
    scene.sdf_lights.denoise, scene.sdf_lights.samples = False, 4
    radiance = rendered(folder / "lamp.exr", "OPEN_EXR").max(axis=2)
    seen = radiance[radiance > SEEN * radiance.max()]
    return float(f"{BRIGHT / float(np.quantile(seen, BRIGHTEST_TENTH)):.2g}")


def write_brightness(path: pathlib.Path, found: dict[str, float]) -> None:
    """Put the factors into the tables of the presets."""
    text = path.read_text(encoding="utf-8")
    for name, value in found.items():
        start = text.index(f"[{name}]\n")
        end = text.find("\n[", start + 1) % (len(text) + 1)
        table = re.sub(r"camera_brightness = .*\n", "", text[start:end])
        table = re.sub(r"(\npower = .*\n?)", rf"\1camera_brightness = {value}\n", table, count=1)
        text = text[:start] + table + text[end:]
    path.write_text(text, encoding="utf-8")


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="preset_thumbnails", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="PRESET", help="names of presets; default: all")
    parser.add_argument("--samples", type=int, default=64, help="samples per pixel (64)")
    parser.add_argument("--size", type=int, default=96, help="width and height in pixels (96)")
    parser.add_argument("--fit", action="store_true", help="find the camera brightness of the presets first")
    parser.add_argument("--out", type=pathlib.Path, help="folder; default: that of the presets")
    options = parser.parse_args(arguments)
    host.register_extension()
    module = host.program("blender.presets")
    known = module.presets()
    for name in options.names:
        if name not in known:
            parser.error(f"there is no preset {name!r}: choose from {', '.join(known)}")
    names = options.names or list(known)
    if options.fit:
        with tempfile.TemporaryDirectory() as folder:
            found = {}
            for name in names:
                found[name] = brightness_of(scene_of(name, options.size, options.samples), pathlib.Path(folder))
                print(name, found[name], file=sys.stderr)
        write_brightness(module.FOLDER / "presets.toml", found)
        module.presets.cache_clear()
    for name in names:
        print(name, file=sys.stderr)
        scene_of(name, options.size, options.samples)
        picture = known[name].picture
        rendered(options.out / picture.name if options.out else picture, "PNG")


if __name__ == "__main__":
    main(sys.argv[1:])
    host.finish(0)
