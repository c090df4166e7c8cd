# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A process with Blender that test_faults.py ends at some moment, or asks what another one has left.

python fault_session.py render|animation|saving|check FOLDER DEVICE
"""

import json
import os
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY))

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

FRAMES = 500


def build() -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "SDF_LIGHTS"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 32, 100
    scene.render.image_settings.file_format, scene.render.use_file_extension = "PNG", True
    scene.frame_end = FRAMES
    settings = scene.sdf_lights
    settings.device, settings.samples, settings.noise_threshold, settings.animate_seed = sys.argv[3], 2, 0.0, False
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (np.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    light = bpy.data.lights.new("Lamp", "POINT")
    light.energy, light.sdf_lamp.use, light.sdf_lamp.shape = 100.0, True, "TORUS"
    scene.collection.objects.link(bpy.data.objects.new("Lamp", light))
    return scene


def render(scene, folder: pathlib.Path) -> None:
    for number in range(FRAMES):
        scene.render.filepath = str(folder / f"still{number:04d}.png")
        bpy.ops.render.render(write_still=True)


def animation(scene, folder: pathlib.Path) -> None:
    scene.render.filepath = str(folder / "frame")
    bpy.ops.render.render(animation=True)


def saving(scene, folder: pathlib.Path) -> None:
    scene.frame_end = 1
    for number in range(100_000):
        scene["number"] = number
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), check_existing=False)


def check(scene, folder: pathlib.Path) -> None:
    """What the pictures of the folder, and its .blend, are; and a picture of this process beside them."""
    found = {}
    scene.render.filepath = str(folder / "whole.png")
    bpy.ops.render.render(write_still=True)
    for path in sorted(folder.glob("*.png")):
        image = bpy.data.images.load(str(path))
        pixels = np.array(image.pixels[:])
        found[path.name] = [len(pixels), float(pixels.sum()), path.stat().st_mtime_ns]
    report = dict(pictures=found)
    # Blender makes the last file a backup before it gives the new one its name.
    saved = [folder / name for name in ("scene.blend", "scene.blend1") if (folder / name).exists()]
    if saved:
        bpy.ops.wm.open_mainfile(filepath=str(saved[0]))
        report["lamp"] = bpy.data.lights["Lamp"].sdf_lamp.shape
    print("REPORT", json.dumps(report), flush=True)


if __name__ == "__main__":
    addon.register()
    what, where, _ = sys.argv[1:]
    made = build()
    bpy.ops.render.render()  # compiles, if need be
    print("READY", flush=True)
    globals()[what](made, pathlib.Path(where))
    os._exit(0)  # Blender's destructors can hang
