# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What artist_screenshots runs in a Blender with a window: the panels of the Properties editor and of the viewport's overlays.

blender --factory-startup --enable-event-simulate --python properties_session.py -- REPORT.json FOLDER
"""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, inside, lamps_are_drawn, move, override, picture, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

FOLDER = ARGUMENTS[1]


def steps():
    addon.register()
    scene, view = bpy.context.scene, areas()[0]
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with override(view):
        bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="LANTERN", location=(1.5, 0.0, 1.0))
    scene.render.engine = "SDF_LIGHTS"
    yield 1.0
    with override(view):
        bpy.ops.wm.call_panel(name="VIEW3D_PT_overlay", keep_open=True)
    yield from until(lamps_are_drawn)
    yield 1.0
    picture(FOLDER, "overlay", view)
    move(inside(view, 0.02, 0.02))  # away from the panel, which then closes
    yield 1.0
    with override(view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    left, right = sorted(areas(), key=lambda area: area.x)
    for area in (left, right):
        area.type = "PROPERTIES"
    yield 1.0
    for name, context, area in (
        ("render", "RENDER", left),
        ("view_layer", "VIEW_LAYER", right),
        ("lamp", "DATA", left),
    ):
        area.spaces.active.context = context
        yield 1.5
        picture(FOLDER, name, area)
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    right.spaces.active.context = "OBJECT"
    yield 1.5
    picture(FOLDER, "object", right)


run(steps())
