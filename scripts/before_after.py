# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders presets in Blender's start-up scene, at an older revision and at this one: a picture with two rows.

    scripts/before_after REVISION [--presets CAMPFIRE,NEON_RING,…] [--out docs/images/presets_before_after.jpg]

Rendered without denoising, by the NumPy reference, which needs no machine code of either revision.
"""

from __future__ import annotations

import argparse
import pathlib
import subprocess
import sys
import tempfile

import host

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
DISTANCE = 2.6  # metres to the camera, whose direction is that of the start-up scene

RENDER = """
import sys
import bpy
from mathutils import Vector
checkout, folder, size, samples, distance, *names = sys.argv[sys.argv.index("--") + 1 :]
sys.path.insert(0, checkout)
import sdf_lights.blender as addon
addon.register()
for name in names:
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    for obj in list(scene.objects):
        if obj.type != "CAMERA":
            bpy.data.objects.remove(obj)
    scene.render.engine = "SDF_LIGHTS"
    scene.sdf_lights.device, scene.sdf_lights.samples = "REFERENCE", int(samples)
    scene.sdf_lights.noise_threshold, scene.sdf_lights.max_bounces = 0.0, 1
    scene.render.resolution_x = scene.render.resolution_y = int(size)
    scene.render.resolution_percentage = 100
    bpy.ops.sdf_lights.lamp_add(source="PRESET", preset=name, location=(0.0, 0.0, 0.7))
    bpy.ops.mesh.primitive_plane_add(size=40.0)
    camera = scene.camera
    back = camera.matrix_world.to_quaternion().to_matrix().col[2]
    camera.location = Vector((0.0, 0.0, 0.5)) + float(distance) * back
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = f"{folder}/{name}.png"
    bpy.ops.render.render(write_still=True)
"""


def rendered(checkout: pathlib.Path, folder: pathlib.Path, options: argparse.Namespace) -> None:
    """Pictures of the presets by the program of a checkout."""
    script = folder / "render.py"
    script.write_text(RENDER, encoding="utf-8")
    numbers = map(str, (options.size, options.samples, DISTANCE))
    command = [sys.executable, script, "--", checkout, folder, *numbers, *options.presets.split(",")]
    subprocess.run(command, check=True, cwd=folder)


def main(arguments: list[str]) -> None:
    from artist_screenshots import write_strip  # imports its siblings

    parser = argparse.ArgumentParser(prog="before_after", description=__doc__.splitlines()[0])
    parser.add_argument("revision", help="of this repository")
    parser.add_argument("--presets", default="CAMPFIRE,NEON_RING,SUNSET", help="names (%(default)s)")
    parser.add_argument("--size", type=int, default=200, help="width and height of each in pixels (%(default)s)")
    parser.add_argument("--samples", type=int, default=16, help="samples per pixel (%(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/images/presets_before_after.jpg")
    options = parser.parse_args(arguments)
    names = options.presets.split(",")
    with tempfile.TemporaryDirectory() as place:
        before, after, checkout = (pathlib.Path(place) / name for name in ("before", "after", "checkout"))
        with host.checkout_of(options.revision, checkout):
            for folder, program in ((before, checkout), (after, REPOSITORY)):
                folder.mkdir()
                rendered(program, folder, options)
        pictures = tuple(f"{folder.name}/{name}" for folder in (before, after) for name in names)
        write_strip(pathlib.Path(place), pictures, options.out, len(names), options.size * len(names))


if __name__ == "__main__":
    main(sys.argv[1:])
