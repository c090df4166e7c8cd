# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_settings_gui runs in a Blender with a window: a scene of Cycles is given this engine, and checked."""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, event, inside, override, picture, report, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import scene_report  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None
PATIENCE = 20.0


def steps():
    scene_report.SDFLIGHTS_PT_scene_report.bl_options = set()  # open from the start
    addon.register()
    scene = bpy.context.scene
    settings = scene.sdf_lights
    scene.render.engine = "CYCLES"
    yield
    scene.cycles.samples, scene.cycles.sample_clamp_indirect = 77, 4.0
    scene.render.engine = "SDF_LIGHTS"
    yield from until(lambda: settings.origin != "UNKNOWN", PATIENCE)
    report["copied"] = [settings.origin, settings.samples, settings.clamp_indirect]

    settings.samples, scene.cycles.samples = 5, 88
    for engine in ("CYCLES", "SDF_LIGHTS"):
        scene.render.engine = engine
        yield
    report["kept"] = settings.samples
    bpy.ops.sdf_lights.cycles_settings_copy()
    report["copied again"] = settings.samples

    bpy.context.object.shadow_terminator_shading_offset = 0.2
    scene.cycles.use_fast_gi = True
    area = areas("VIEW_3D")[0]
    area.type = "PROPERTIES"
    yield
    area.spaces.active.context = "RENDER"
    yield
    with override(area):
        report["checked"] = sorted(bpy.ops.sdf_lights.scene_check())
    found = scene_report._reports[scene.session_uid].groups
    report["report"] = {title: [name for name, _ in rows] for title, rows in found.items()}
    yield
    yield 1.0  # panels slide to their places
    picture(PICTURES, "scene_report", area)

    with override(area):
        bpy.ops.wm.call_panel(name="SDFLIGHTS_PT_sampling_presets", keep_open=True)
    yield
    yield
    picture(PICTURES, "presets")
    event("ESC", "PRESS", inside(area))
    event("ESC", "RELEASE", inside(area))
    yield
    path = next(
        path
        for folder in bpy.utils.preset_paths("sdf_lights/sampling")
        for path in pathlib.Path(folder).glob("Preview.py")
    )
    with override(area):
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname="SDFLIGHTS_PT_sampling_presets")
    report["preset"] = [settings.samples, settings.denoise]

    area.spaces.active.context = "VIEW_LAYER"
    yield
    yield
    picture(PICTURES, "view_layer", area)
    fresh = bpy.data.scenes.new("Fresh")
    bpy.context.window.scene = fresh
    fresh.render.engine = "SDF_LIGHTS"
    yield from until(lambda: fresh.sdf_lights.origin != "UNKNOWN", PATIENCE)
    report["fresh"] = [fresh.sdf_lights.origin, fresh.sdf_lights.samples]
    addon.unregister()


run(steps())
