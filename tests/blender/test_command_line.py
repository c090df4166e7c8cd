# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendering without a window, as farms do it: the installed extension, and ``blender -b FILE -E SDF_LIGHTS``."""

import os
import subprocess

import numpy as np
import pytest

# Saved with another engine, so that -E is what chooses this one. The lamp is above the horizon, in the upper half.
MAKE = """
import bpy

bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
floor = bpy.data.meshes.new("Floor")
floor.from_pydata([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [], [(0, 1, 2, 3)])
light = bpy.data.lights.new("Lamp", "POINT")
light.energy = 100.0
light.sdf_lamp.use, light.sdf_lamp.shape = True, "SPHERE"
for frame, radius in ((1, 0.25), (2, 0.75)):
    light.sdf_lamp.sphere.radius = radius
    light.sdf_lamp.sphere.keyframe_insert("radius", frame=frame)
lamp = bpy.data.objects.new("Lamp", light)
lamp.location = (0.0, 0.0, 2.0)
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.location, camera.rotation_euler = (0.0, -6.0, 1.0), (1.5707963, 0.0, 0.0)
for thing in (bpy.data.objects.new("Floor", floor), lamp, camera):
    scene.collection.objects.link(thing)
scene.camera = camera
scene.render.engine = "BLENDER_WORKBENCH"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.frame_start, scene.frame_end = 1, 2
scene.sdf_lights.samples = 16
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""

# The same scene as somebody saved it who renders with Cycles, and with something that is not supported.
CYCLES = """
import bpy

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.property_unset("sdf_lights")
cycles = scene.cycles
cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising, cycles.film_exposure = 16, False, False, 4.0
bpy.ops.wm.save_as_mainfile(filepath={path!r})
cycles.use_fast_gi = True
bpy.ops.wm.save_as_mainfile(filepath={blurred!r})
"""


@pytest.mark.gui
def test_frames_are_rendered_without_a_window(blender_command, blender_zip, tmp_path):
    openimageio = pytest.importorskip("OpenImageIO")
    environment = {name: value for name, value in os.environ.items() if name != "SDF_LIGHTS_CACHE"}
    environment["BLENDER_USER_RESOURCES"] = str(tmp_path / "resources")
    (tmp_path / "resources").mkdir()

    def run(*arguments) -> subprocess.CompletedProcess:
        return subprocess.run(
            [*blender_command, *map(str, arguments)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=600,
        )

    def blender(*arguments) -> None:
        done = run(*arguments)
        assert done.returncode == 0, done.stdout
        assert "Traceback" not in done.stdout and "Error" not in done.stdout, done.stdout

    def picture(name: str) -> np.ndarray:
        """(32, 48, 3), row 0 at the top."""
        return openimageio.ImageInput.open(str(tmp_path / name)).read_image(openimageio.FLOAT)[..., :3]

    file, script = tmp_path / "lamp.blend", tmp_path / "make.py"
    script.write_text(MAKE.format(path=str(file)), encoding="utf-8")
    blender("--command", "extension", "install-file", "--repo", "user_default", "--enable", blender_zip)
    blender("--background", "--python-exit-code", "1", "--python", script)

    blender("--background", file, "-E", "SDF_LIGHTS", "-o", tmp_path / "single_####", "-f", "1")
    blender("--background", file, "-E", "SDF_LIGHTS", "-o", tmp_path / "film_####", "-a")
    names = sorted(path.name for path in tmp_path.glob("*.exr"))
    assert names == ["film_0001.exr", "film_0002.exr", "single_0001.exr"]
    single, first, second = (picture(name) for name in ("single_0001.exr", "film_0001.exr", "film_0002.exr"))
    assert (single == first).all()
    for frame in (first, second):
        assert np.isfinite(frame).all() and frame[-1].min() > 0.0  # the floor is lit
    # The lamp is nine times as large in the second frame, but for the pixels that its edge crosses.
    sizes = [np.count_nonzero(frame[:16].max(axis=2)) for frame in (first, second)]
    assert 0 < 4 * sizes[0] < sizes[1]

    # A file of Cycles that was never opened in a window has its settings.
    of_cycles, blurred = tmp_path / "cycles.blend", tmp_path / "blurred.blend"
    script.write_text(CYCLES.format(path=str(of_cycles), blurred=str(blurred)), encoding="utf-8")
    blender("--background", file, "--python-exit-code", "1", "--python", script)
    blender(
        "--background", of_cycles, "-E", "SDF_LIGHTS", "-o", tmp_path / "cycles_####", "-f", "1", "--", "--sdf-strict"
    )
    assert picture("cycles_0001.exr").mean() == pytest.approx(4.0 * single.mean(), rel=0.1)

    # A strict render ends with 1, without a picture; any other one tells, and goes on.
    arguments = "--background", blurred, "-E", "SDF_LIGHTS", "-o", tmp_path / "blurred_####", "-f", "1"
    done = run(*arguments, "--", "--sdf-strict")
    assert done.returncode == 1 and "Fast GI is not supported" in done.stdout, done.stdout
    assert "1 thing is not rendered as the scene says" in done.stdout
    done = run(*arguments)
    assert done.returncode == 0 and "Fast GI is not supported" in done.stdout, done.stdout
    assert picture("blurred_0001.exr").mean() > 0.0
