# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_rendered_gui runs in a Blender with a window: a final render that Esc cancels, while a viewport renders.

    blender --factory-startup --python escape_session.py -- REPORT.json

Only real keys stop jobs, and a Blender that takes simulated ones takes no others. So xdotool presses this one.
"""

import pathlib
import subprocess
import sys
import time

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, override, report, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

PATIENCE = 60.0


def is_rendering():
    return bpy.app.is_job_running("RENDER")


def session():
    addon.register()
    made = bpy.context.scene
    made.render.engine = "SDF_LIGHTS"
    made.render.resolution_x, made.render.resolution_y = 160, 90
    # The reference needs no machine code, which may have to be compiled first.
    made.sdf_lights.device, made.sdf_lights.samples, made.sdf_lights.noise_threshold = "REFERENCE", 1 << 20, 0.0
    bpy.context.preferences.view.render_display_type = "NONE"
    with override():
        bpy.ops.sdf_lights.lamp_add(location=(0.0, 0.0, 3.0))
    areas()[0].spaces.active.shading.type = "RENDERED"
    yield 2.0
    with override():
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(is_rendering)
    yield 5.0
    report["renders"] = is_rendering()
    started = time.monotonic()
    subprocess.run(
        ["xdotool", "search", "--class", "blender", "windowfocus", "key", "Escape"], check=True, timeout=PATIENCE
    )
    yield from until(lambda: not is_rendering(), PATIENCE)
    report["seconds"] = time.monotonic() - started
    path = str(pathlib.Path(ARGUMENTS[0]).with_suffix(".exr"))
    made.render.image_settings.file_format = "OPEN_EXR"
    bpy.data.images["Render Result"].save_render(path)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], -1)
    report["picture"] = [*pixels.shape[:2], float(pixels[..., :3].max())]


run(session())
