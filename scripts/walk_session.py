# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session of artist_screenshots in a Blender with a window: from Blender's start-up scene to a rendered neon sign,
like a new user, with only the mouse and keys. The report counts clicks and keys; a typed word or number counts as one.

blender --factory-startup --enable-event-simulate --python walk_session.py -- REPORT.json FOLDER
"""

import pathlib
import sys

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

import window as hands  # noqa: E402
from window import ARGUMENTS, areas, button_of, inside, lamps_are_drawn, move, picture, region_of, report, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

FOLDER = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None
LIGHT = 89.0  # pixels from the top of the Outliner to the row of the light
TAB = 55.0  # pixels from the top of the tabs to the second one, Render


def counted(count: int = 1) -> None:
    report["actions"] = report.get("actions", 0) + count


def press(place, key: str, **modifiers: bool) -> None:
    counted()
    hands.press(place, key, **modifiers)


def typed(place, text: str) -> None:
    counted()
    hands.typed(place, text)


def keys(place, letters: str, number: str) -> None:
    """A transform by keys, with a number."""
    for letter in letters:
        counted()
        hands.typed(place, letter)
    typed(place, number)
    press(place, "RET")


def is_rendering():
    return bpy.app.is_job_running("RENDER")


def engine(view):
    """Render Properties > Render Engine > SDF Lights."""
    properties = areas("PROPERTIES")[0]
    tabs = region_of(properties, "NAVIGATION_BAR")
    press(
        move((tabs.x + 0.5 * tabs.width, tabs.y + tabs.height - TAB * bpy.context.preferences.system.ui_scale)),
        "LEFTMOUSE",
    )
    yield 1.0
    report["tab"] = properties.spaces.active.context
    place = yield from button_of(properties, 'bpy.data.scenes["Scene"].render.engine', "WINDOW")
    press(place, "LEFTMOUSE")
    yield 1.0
    picture(FOLDER, "engine")
    typed(place, "s")
    yield 1.0
    report["engine"] = bpy.context.scene.render.engine


def dark(view):
    """Delete the light: a click on it in the Outliner, and a key over the viewport."""
    outliner = areas("OUTLINER")[0]
    region = region_of(outliner)
    unit = bpy.context.preferences.system.ui_scale
    press(move((region.x + 70.0 * unit, region.y + region.height - LIGHT * unit)), "LEFTMOUSE")
    yield 0.7
    report["clicked"] = bpy.context.object.name
    press(move(inside(view, 0.5, 0.6)), "DEL")
    yield 0.7


def sign(view):
    """Add > Light > SDF Lamp > Presets > Neon Heart, by the search of the menu; twice as large, and on the cube."""
    place = move(inside(view, 0.5, 0.6))
    yield
    press(place, "A", shift=True)
    yield 1.0
    typed(place, "neon heart")
    yield 1.0
    picture(FOLDER, "search")
    press(place, "RET")
    yield 1.5
    yield from until(lamps_are_drawn)
    yield 0.5
    picture(FOLDER, "added")
    place = move(inside(view, 0.7, 0.8))
    yield
    keys(place, "gz", "1.5")
    yield 0.5
    keys(place, "rz", "45")
    yield 0.5
    press(place, "NUMPAD_0")  # what the camera sees
    yield 1.5
    yield from until(lamps_are_drawn)
    yield 1.0
    picture(FOLDER, "placed")
    report["lamps"] = [obj.name for obj in bpy.data.objects if obj.type == "LIGHT" and obj.data.sdf_lamp.use]
    report["height"] = bpy.context.object.location.z


def render(view):
    press(inside(view, 0.5, 0.6), "F12")
    yield from until(is_rendering, 60.0)
    yield from until(lambda: not is_rendering())
    yield 2.0
    picture(FOLDER, "rendered")
    path = str(pathlib.Path(ARGUMENTS[0]).with_suffix(".png"))
    bpy.data.images["Render Result"].save_render(path)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:]).reshape(*image.size[::-1], -1)[..., :3]
    report["reddest"] = float((pixels[..., 0] - pixels[..., 2]).max())


def steps():
    addon.register()
    scene = bpy.context.scene
    # For a fast render: a small picture, in this window.
    scene.render.resolution_percentage = 50 if FOLDER is not None else 5
    bpy.context.preferences.view.smooth_view = 0
    bpy.context.preferences.view.render_display_type = "SCREEN"
    view = areas()[0]
    yield 1.0
    picture(FOLDER, "start")
    for part in (engine, dark, sign, render):
        yield from part(view)


if __name__ == "__main__":
    run(steps())
