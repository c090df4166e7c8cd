# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_object_lamps_gui runs in a Blender with a window: a sign of a text, written, rendered in the viewport, and
undone."""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import (  # noqa: E402
    ARGUMENTS,
    Eye,
    areas,
    inside,
    lamps_are_drawn,
    move,
    override,
    picture,
    press,
    report,
    run,
    typed,
    until,
)

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.lamp import shape_of  # noqa: E402
from sdf_lights.blender.viewport import rendered  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None
BEAM = (0.0, 0.0, 0.0)  # a place in the first letter, filled in below


def lamps():
    return [obj for obj in bpy.data.objects if obj.type == "LIGHT" and obj.data.sdf_lamp.use]


def width():
    low, high = shape_of(lamps()[0].data.sdf_lamp).bounds()
    return float(high[0] - low[0])


def session():
    addon.register()
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.render.engine = "SDF_LIGHTS"
    scene.world = None
    scene.sdf_lights.viewport.samples = 4
    area = areas()[0]
    space = area.spaces.active
    with override():
        bpy.ops.ed.undo_push(message="Empty")
        bpy.ops.sdf_lights.text_lamp_add("EXEC_DEFAULT", body="HI", rotation=(1.5708, 0.0, 0.0))
        bpy.ops.ed.undo_push(message="Add Text Lamp")
    space.region_3d.view_rotation = (0.7071, 0.7071, 0.0, 0.0)
    space.region_3d.view_perspective, space.region_3d.view_distance = "ORTHO", 6.0
    space.region_3d.view_location = (0.7, 0.0, 0.3)
    space.show_region_ui, space.shading.type = True, "SOLID"
    yield from until(lamps_are_drawn)
    yield 1.0
    report["added"] = [obj.data.sdf_lamp.source for obj in lamps()]
    eye = Eye((0.10, 0.0, 0.3), (-0.3, 0.0, 0.3))  # in the H, and beside it
    area.tag_redraw()
    yield 1.0
    yield from until(lambda: len(eye.colors) == 2)
    report["in"], report["beside"] = eye.color(0), eye.color(1)
    picture(PICTURES, "text_solid")

    report["width"] = width()
    text = next(obj for obj in bpy.data.objects if obj.type == "FONT")
    with override():
        bpy.ops.object.select_all(action="DESELECT")
    text.select_set(True)
    bpy.context.view_layer.objects.active = text
    here = move(inside(area))
    press(here, "TAB")
    yield 1.0
    report["mode"] = bpy.context.mode
    typed(here, "GH")
    yield 1.0
    report["wider while writing"] = width()
    yield from until(lamps_are_drawn)
    press(here, "TAB")
    yield 1.0
    report["body"], report["wider"] = text.data.body, width()
    picture(PICTURES, "text_written")

    space.shading.type = "RENDERED"
    yield from until(lambda: any(view.drawn is not None and view._render.finished for view in list(rendered._running)))
    yield 1.0
    report["rendered"] = eye.color(0)
    picture(PICTURES, "text_rendered")
    space.shading.type = "SOLID"
    yield 1.0
    eye.close()

    undone = 0
    while lamps() and undone < 8:
        with override():
            bpy.ops.ed.undo()
        undone += 1
        yield 0.5
    report["undone"], report["left"] = undone, [obj.name for obj in bpy.data.objects]
    with override():
        bpy.ops.ed.redo()
    yield 0.5
    report["redone"] = [obj.data.sdf_lamp.object.name for obj in lamps()]


run(session())
