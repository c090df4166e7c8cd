# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What artist_screenshots runs in a Blender with a window: the panels of the Properties editor.

blender --factory-startup --enable-event-simulate --python properties_session.py -- REPORT.json FOLDER
"""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, event, inside, move, override, picture, run  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import panels, scene_panels, scene_report  # noqa: E402

FOLDER = ARGUMENTS[1]
PAGES, PAGE = 3, 17  # of the tab Render, and turns of the wheel from one to the next


def opened() -> None:
    """Let all panels of the tab Render be open from the start, before they are registered."""
    for module in (panels, scene_panels, scene_report):
        for kind in module.CLASSES:
            if getattr(kind, "bl_context", "") == "render":
                kind.bl_options = getattr(kind, "bl_options", set()) - {"DEFAULT_CLOSED"}


def steps():
    opened()
    addon.register()
    scene, view = bpy.context.scene, areas()[0]
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with override(view):
        bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="LANTERN", location=(1.5, 0.0, 1.0))
    scene.render.engine = "SDF_LIGHTS"
    yield 1.0
    with override(view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    area, other = sorted(areas(), key=lambda area: area.x)
    area.type = other.type = "PROPERTIES"
    yield 1.0
    for name, context in (("view_layer", "VIEW_LAYER"), ("lamp", "DATA"), ("render_0", "RENDER")):
        area.spaces.active.context = context
        yield 1.5
        picture(FOLDER, name, area)
    place = move(inside(area, 0.5, 0.3))
    yield
    for page in range(1, PAGES):
        for _ in range(PAGE):
            event("WHEELDOWNMOUSE", "PRESS", place)
            yield 0.1
        yield 1.0
        picture(FOLDER, f"render_{page}", area)


run(steps())
