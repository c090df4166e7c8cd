# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What artist_screenshots runs in a Blender whose user folders are empty: a zip is installed and used for the first
time.

    blender --enable-event-simulate --python first_minute_session.py -- REPORT.json ZIP FOLDER

BLENDER_USER_RESOURCES names an empty folder. Pictures of the first minute go into the folder; the report has the
seconds of each.
"""

import importlib
import pathlib
import sys
import time

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, inside, move, override, picture, press, report, run, until  # noqa: E402

EXTENSION = "bl_ext.user_default.sdf_lights"


def part(name: str):
    """A module of the installed extension."""
    return importlib.import_module(f"{EXTENSION}.sdf_lights.{name}")


def install() -> None:
    bpy.ops.extensions.package_install_files(filepath=ARGUMENTS[1], repo="user_default", enable_on_install=True)


def taken(name: str) -> None:
    """Take a picture, and note when: the time that pictures take does not count."""
    report.setdefault("seconds", {})[name] = time.perf_counter() - report["began"]
    before = time.perf_counter()
    picture(ARGUMENTS[2], name)
    report["began"] += time.perf_counter() - before


def show_add_on(area) -> None:
    """The add-on's entry in the preferences, opened."""
    area.ui_type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "SDF"
    bpy.ops.preferences.addon_expand(module=EXTENSION)


def steps():
    scene, view = bpy.context.scene, areas()[0]
    scene.render.resolution_percentage = 50
    bpy.context.preferences.view.smooth_view = 0
    bpy.context.preferences.view.render_display_type = "SCREEN"
    yield 2.0
    report["began"] = time.perf_counter()
    taken("start")
    install()
    show_add_on(view)
    yield 1.0
    taken("installed")
    picture(ARGUMENTS[2], "preferences", view)
    view.ui_type = "VIEW_3D"
    scene.render.engine = "SDF_LIGHTS"
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with override(view):
        bpy.ops.mesh.primitive_plane_add(size=14.0, location=(0.0, 0.0, -1.0))
        bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="NEON_HEART", location=(0.0, 0.0, 1.5))
    lamp = bpy.context.object
    lamp.rotation_euler.z, lamp.scale, lamp.data.energy = 0.8, (1.2, 1.2, 1.2), 50.0
    scene.sdf_lights.samples = scene.sdf_lights.viewport.samples = 24
    scene.sdf_lights.denoise = scene.sdf_lights.viewport.denoise = True
    drawn = part("blender.viewport.drawn")
    yield from until(lambda: drawn.overlay is not None and not drawn.overlay.finder.busy)
    yield 1.0
    taken("lamp")
    with override(view):
        bpy.ops.view3d.view_camera()
        bpy.ops.view3d.view_center_camera()
    view.spaces.active.shading.type = "RENDERED"
    rendered = part("blender.viewport.rendered")
    yield from until(lambda: any(each._render.picture for each in rendered._running))
    yield 0.2
    taken("first_pixels")
    yield from until(lambda: any(each._render.finished for each in rendered._running))
    yield 0.5
    taken("viewport")
    view.spaces.active.shading.type = "SOLID"
    press(move(inside(view)), "F12")
    yield from until(lambda: bpy.app.is_job_running("RENDER"), 60.0)
    yield from until(lambda: not bpy.app.is_job_running("RENDER"))
    yield 1.0
    taken("picture")
    del report["began"]


run(steps())
