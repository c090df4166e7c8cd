# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hands and eyes for the sessions that tests run in a Blender with a window: keys, the mouse, pictures, a report.

    blender --factory-startup --enable-event-simulate --python …_session.py -- REPORT.json [PICTURES]

A session is a generator that ends each step with ``yield``, in which Blender works on the events; ``yield seconds``
waits longer. It writes what it sees into ``report``; judging that is the test's part. Into the folder PICTURES go
screenshots, taken by ImageMagick's `import`: Blender's own are black without a graphics card.
"""

import json
import os
import pathlib
import subprocess
import sys
import traceback

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY))

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.nodes import link_search  # noqa: E402

REPORT, *PICTURES = sys.argv[sys.argv.index("--") + 1:]
_KEYS = {" ": "SPACE", "\n": "RET", "\b": "BACK_SPACE", ".": "PERIOD", "-": "MINUS"}
_STEP = 0.4  # seconds
report: dict = {}


def window():
    return bpy.context.window_manager.windows[0]


def areas(kind):
    """From the bottom to the top."""
    return sorted((area for area in window().screen.areas if area.type == kind), key=lambda area: area.y)


def region(area, kind="WINDOW"):
    return next(region for region in area.regions if region.type == kind)


def override(area, kind="WINDOW"):
    return bpy.context.temp_override(window=window(), area=area, region=region(area, kind))


def event(kind, value, place, **options):
    window().event_simulate(type=kind, value=value, x=int(place[0]), y=int(place[1]), **options)


def move(place):
    event("MOUSEMOVE", "NOTHING", place)
    return place


def inside(area, across=0.4, up=0.5, kind="WINDOW"):
    """A place in a region, as parts of its size."""
    there = region(area, kind)
    return there.x + across * there.width, there.y + up * there.height


def press(place, key, **modifiers):
    move(place)
    event(key, "PRESS", place, **modifiers)
    event(key, "RELEASE", place, **modifiers)


def typed(place, text):
    for letter in text:
        unicode = {} if letter in "\n\b" else dict(unicode=letter)
        key = _KEYS.get(letter) or (
            "ZERO ONE TWO THREE FOUR FIVE SIX SEVEN EIGHT NINE".split()[int(letter)] if letter.isdigit()
            else letter.upper())
        event(key, "PRESS", place, **unicode)
        event(key, "RELEASE", place)


def drag(start, end, steps=6, **modifiers):
    """A generator: the left button down at ``start``, moved, and let go at ``end``."""
    move(start)
    yield
    event("LEFTMOUSE", "PRESS", start, **modifiers)
    for i in range(1, steps + 1):
        event("MOUSEMOVE", "NOTHING", [a + (b - a) * i / steps for a, b in zip(start, end)], **modifiers)
        yield 0.05
    event("LEFTMOUSE", "RELEASE", end, **modifiers)
    yield


def until(condition, patience=20.0):
    """A generator that waits for a condition, or for as long as there is patience (seconds)."""
    while not condition() and patience > 0.0:
        yield
        patience -= _STEP


def button(area, path, kind="UI"):
    """A generator that finds the place of a property's button by its data path; None if the region does not show it."""
    there = region(area, kind)
    x = there.x + 0.75 * there.width
    for y in range(int(there.y + there.height) - 4, int(there.y) + 4, -10):
        move((x, y))
        yield 0.03
        with override(area, kind):
            if bpy.ops.ui.copy_data_path_button.poll():
                bpy.ops.ui.copy_data_path_button(full_path=True)
                if bpy.context.window_manager.clipboard == path:
                    return x, y
    return None


def socket_place(area, socket):
    """Where a socket of a node is in the window; found as Blender does, because Python does not know."""
    node, view = socket.node, region(area).view2d
    tree = socket.id_data
    scale = bpy.context.preferences.system.ui_scale
    x = node.location.x + (node.width if socket.is_output else 0.0)
    for down in range(-10, 600, 4):
        place = view.view_to_region(x * scale, (node.location.y - down) * scale, clip=False)
        with override(area):
            hit = link_search.socket_at(tree, place)
        if hit == socket:
            return region(area).x + place[0], region(area).y + place[1] - 6
    raise LookupError(f"{node.name} {socket.name}")


def picture(name, crop=None):
    """A screenshot; ``crop`` is an area."""
    if not PICTURES:
        return
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    path = str(pathlib.Path(PICTURES[0]) / f"{name}.png")
    command = ["import", "-window", "root"]
    if crop is not None:
        x, y = window().x + crop.x, window().y + crop.y
        command += ["-gravity", "SouthWest", "-crop", f"{crop.width}x{crop.height}+{x}+{y}", "+repage"]
    subprocess.run([*command, path], check=True)


def run(session):
    """Runs the session, writes the report, and leaves Blender."""
    bpy.context.preferences.view.show_splash = False
    addon.register()

    def step():
        try:
            return next(session) or _STEP
        except StopIteration:
            pass
        except Exception:
            report["error"] = traceback.format_exc()
        pathlib.Path(REPORT).write_text(json.dumps(report), encoding="utf-8")
        sys.stdout.flush()
        os._exit(0)  # quitting asks about unsaved work

    bpy.app.timers.register(step, first_interval=2.0)
