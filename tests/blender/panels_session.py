# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_artist_panels runs in a Blender with a window: an artist in the sidebar of the 3D view."""

import pathlib
import sys

import bpy
from mathutils import Vector

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import (  # noqa: E402
    ARGUMENTS,
    areas,
    button_of,
    drag,
    event,
    inside,
    move,
    on_screen,
    override,
    picture,
    press,
    region_of,
    report,
    run,
    typed,
    until,
)

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import preset_browser, preset_pictures, viewport  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None
PATIENCE = 20.0


def thicknesses():
    return [
        round(obj.data.sdf_lamp.box_frame.thickness, 4)
        for obj in sorted(bpy.context.scene.objects, key=lambda obj: obj.name)
    ]


def traces():
    """What a registered add-on leaves in Blender, and an unregistered one must not."""
    found = [name for name in dir(bpy.types) if name.startswith(("SDFLIGHTS", "SDF_LIGHTS"))]
    for keys in (bpy.context.window_manager.keyconfigs.addon, bpy.context.window_manager.keyconfigs.user):
        found += [item.idname for keymap in keys.keymaps for item in keymap.keymap_items if "sdf_lights" in item.idname]
    for name in dir(bpy.app.handlers):
        there = getattr(bpy.app.handlers, name)
        found += (
            [f"{name}: {function}" for function in there if "sdf_lights" in getattr(function, "__module__", "")]
            if isinstance(there, list)
            else []
        )
    for menu in (
        "NODE_MT_add",
        "VIEW3D_MT_light_add",
        "VIEW3D_MT_object_convert",
        "VIEW3D_MT_object_asset",
        "IMAGE_HT_header",
    ):
        found += [
            f"{menu}: {draw}"
            for draw in getattr(bpy.types, menu)._dyn_ui_initialize()
            if "sdf_lights" in draw.__module__
        ]
    for kind in (bpy.types.Scene, bpy.types.Light, bpy.types.ViewLayer, bpy.types.WindowManager):
        found += [name for name in kind.bl_rna.properties.keys() if name.startswith("sdf_")]
    return found


def steps():
    addon.register()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    view = areas("VIEW_3D")[0]
    press(inside(view, 0.4), "N")
    yield
    yield 1.0  # the tabs are known once they are drawn
    report["sidebar by N"] = view.spaces.active.show_region_ui
    region_of(view, "UI").active_panel_category = "SDF Lights"
    with override(view):
        for x in (0.0, 1.5, 3.0):
            bpy.ops.sdf_lights.lamp_add(shape="BOX_FRAME", location=(x, 0.0, 0.0))
    for obj in bpy.data.objects:
        obj.select_set(True)
    yield 1.0

    # The wheel over a number changes it, Alt Return changes all that is selected, I makes a key of it. (A simulated
    # drag loses its Alt in Blender.)
    active = bpy.context.object
    path = f'bpy.data.lights["{active.data.name}"].sdf_lamp.box_frame.thickness'
    report["before"] = thicknesses()
    place = yield from button_of(view, path)
    report["button"] = place is not None
    event("WHEELUPMOUSE", "PRESS", place, ctrl=True)
    yield
    report["one"] = thicknesses()
    move((place[0], place[1] + 1))
    yield
    press(place, "RET")
    yield
    press(place, "A", ctrl=True)
    typed(place, "0.08")
    yield
    press(place, "RET", alt=True)
    yield
    report["all"] = thicknesses()
    move(place)
    yield
    press(place, "I")
    yield
    report["animated"] = active.data.animation_data is not None
    picture(PICTURES, "sidebar", view)

    # Linked and single duplicates, deletion and undo, by keys.
    for obj in bpy.data.objects:
        obj.select_set(obj == active)
    there = inside(view, 0.4)
    press(there, "D", alt=True)
    yield
    typed(there, "\n")
    yield
    yield from until(lambda: len(bpy.data.objects) == 4, PATIENCE)
    report["linked"] = len(bpy.data.objects), active.data.users
    press(there, "DEL")
    yield from until(lambda: len(bpy.data.objects) == 3, PATIENCE)
    report["deleted"] = len(bpy.data.objects)
    press(there, "Z", ctrl=True)
    yield from until(lambda: len(bpy.data.objects) == 4, PATIENCE)
    report["back"] = len(bpy.data.objects)

    # By keys alone: Shift A, a name, and the panel of what was done by F9.
    press(there, "A", shift=True)
    yield
    typed(there, "torus knot")
    yield
    typed(there, "\n")
    yield from until(lambda: len(bpy.data.objects) == 5, PATIENCE)
    report["added"] = bpy.context.object.data.sdf_lamp.shape
    report["redo"] = bpy.context.window_manager.operators[-1].bl_idname
    press(there, "F9")
    yield 1.0
    picture(PICTURES, "redo_panel")
    press(there, "ESC")
    yield
    with override(view):
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.sdf_lights.lamp_add(shape="SPHERE", location=(0.0, -2.0, 0.0))
    yield

    # An arrow's head, dragged.
    ball = bpy.context.object
    radius = ball.data.sdf_lamp.sphere.radius
    with override(view):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield 1.0
    tip, far = (on_screen(view, ball.location + Vector((x, 0.0, 0.0))) for x in (radius, 2.0 * radius))
    ahead = (tip[0] + 40.0, tip[1])
    move(ahead)
    yield
    picture(PICTURES, "arrows", view)
    yield from drag(ahead, (ahead[0] + far[0] - tip[0], ahead[1]))
    yield
    report["dragged"] = ball.data.sdf_lamp.sphere.radius / radius
    view.spaces.active.region_3d.view_distance = 40.0  # or every redraw takes its time

    # A mistake in one line.
    ball.data.sdf_lamp.source = "EXPRESSION"
    ball.data.sdf_lamp.expression = "box(0.5) - spere(0.6)"
    move(inside(view, 0.4, 0.8))  # where no button tells what it is for
    yield 1.0
    yield from until(lambda: not viewport.drawn.overlay.finder.busy)  # its last good shape has a label
    picture(PICTURES, "expression_error", view)

    # Presets: a click on the picture opens all of them.
    ball.data.sdf_lamp.source = "PRIMITIVE"
    bpy.context.window_manager.sdf_lights_preset = "CAMPFIRE"
    report["presets"] = len(preset_browser.items())
    for thumbnail in preset_pictures._pictures.values():
        tuple(thumbnail.image_size)  # Blender loads it for the answer, and otherwise once it is shown
    bpy.context.view_layer.objects.active = None
    yield 1.0
    picture(PICTURES, "presets", view)
    there = region_of(view, "UI")
    place = there.x + 0.45 * there.width, there.y + there.height - 170
    press(move(place), "LEFTMOUSE")
    yield 2.0
    picture(PICTURES, "preset_browser")
    press(place, "ESC")
    yield

    # At twice the size of everything.
    bpy.context.view_layer.objects.active = ball
    bpy.context.preferences.view.ui_scale = 2.0
    yield 2.0
    picture(PICTURES, "twice_the_size")
    radius = ball.data.sdf_lamp.sphere.radius
    place = yield from button_of(view, f'bpy.data.lights["{ball.data.name}"].sdf_lamp.sphere.radius')
    event("WHEELUPMOUSE", "PRESS", place or (0.0, 0.0), ctrl=True)
    yield
    report["at twice the size"] = ball.data.sdf_lamp.sphere.radius - radius
    bpy.context.preferences.view.ui_scale = 1.0
    yield

    bpy.ops.ed.undo_push(message="The session")
    report["traces"] = len(traces())
    addon.unregister()
    yield
    report["left"] = traces()


if __name__ == "__main__":
    run(steps())
