# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What artist_screenshots runs in a Blender with a window whose user folders are empty: a zip is installed, a lamp is added, the viewport
shows it rendered, and F12 renders it. The report has the seconds of each picture, from the start of the installation.

    blender --factory-startup --enable-event-simulate --python first_minute_session.py -- REPORT.json FOLDER ZIP

BLENDER_USER_RESOURCES names an empty folder.
"""

import importlib
import math
import pathlib
import sys
import time

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "scripts"))

from window import ARGUMENTS, areas, override, picture, report, run, until  # noqa: E402  (found on the path set above)

EXTENSION = "bl_ext.user_default.sdf_lights"
FOLDER, ZIP = ARGUMENTS[1:3]
PIXELS = 25  # percent of Blender's own size


def background():
    """The module of the installed add-on that compiles beside the session."""
    return importlib.import_module(f"{EXTENSION}.sdf_lights.render.cpu.background")


def needed_are_there() -> bool:
    """Whether all is compiled that a picture needs."""
    beside = background()
    return not beside.needed(beside.NEEDED)


def steps():
    scene, view = bpy.context.scene, areas()[0]
    scene.render.resolution_percentage = PIXELS
    bpy.context.preferences.view.smooth_view = 0
    bpy.context.preferences.view.render_display_type = "SCREEN"
    yield 2.0
    started = time.perf_counter()
    times = report["times"] = {}

    def shot(name: str) -> None:
        times[name] = time.perf_counter() - started
        picture(FOLDER, name)

    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    yield 1.0
    shot("installed")
    scene.render.engine = "SDF_LIGHTS"
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with override(view):
        bpy.ops.sdf_lights.lamp_add(
            source="PRESET", preset="NEON_RING", location=(0.0, 0.0, 1.5), rotation=(0.0, 0.0, math.radians(45.0))
        )
    view.spaces.active.region_3d.view_perspective = "CAMERA"
    yield 3.0
    shot("lamp")
    view.spaces.active.shading.type = "RENDERED"
    yield 2.0
    shot("waiting")
    yield from until(needed_are_there)
    report["compiled"] = time.perf_counter() - started
    yield 4.0
    shot("viewport")
    view.spaces.active.shading.type = "SOLID"
    with override(view):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: bpy.app.is_job_running("RENDER"), 60.0)
    yield from until(lambda: not bpy.app.is_job_running("RENDER"))
    yield 1.0
    shot("rendered")


if __name__ == "__main__":
    run(steps())
