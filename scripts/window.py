# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session in a Blender with a window: a sequence of steps, between which Blender handles its events.

    blender --factory-startup --enable-event-simulate --python SESSION.py -- REPORT.json

The session is a generator that yields how many seconds Blender is left to itself before the next step; a plain
``yield`` is long enough for a few events. ``report`` goes into the file, even if the session fails: then with
``report["traceback"]``. A test judges the report.

Positions in the window are (x, y) in pixels from its lower left corner.
"""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator

import bpy
import gpu
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

PATIENCE = 800.0  # seconds until a session gives up waiting: kernels may need to be compiled, on a busy machine
BETWEEN = 0.05  # seconds between two checks of a condition
STEP = 0.4  # seconds of a step that yields none
KEYS = {" ": "SPACE", "\n": "RET", "\b": "BACK_SPACE", ".": "PERIOD", "-": "MINUS"}
KEYS |= dict(zip("0123456789", "ZERO ONE TWO THREE FOUR FIVE SIX SEVEN EIGHT NINE".split()))

Place = tuple[float, float]

ARGUMENTS = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
report: dict = {}


def run(steps: Iterator[float | None], finish: Callable[[], None] | None = None) -> None:
    """Run a session when the window is there; then write the report, and ``finish``, or leave."""

    def tick():
        known = len(report)
        try:
            wait = next(steps)
            if len(report) != known:
                print(list(report.items())[known:], flush=True)
            return STEP if wait is None else wait
        except StopIteration:
            pass
        except Exception:
            report["traceback"] = traceback.format_exc()
        pathlib.Path(ARGUMENTS[0]).write_text(json.dumps(report), encoding="utf-8")
        sys.stdout.flush()
        if finish is None or "traceback" in report:
            os._exit(0)  # quitting asks about unsaved work
        finish()

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)


def until(condition: Callable[[], object], patience: float = PATIENCE) -> Iterator[float]:
    """Steps that wait for something. Raises TimeoutError if it does not come."""
    deadline = time.monotonic() + patience
    while not condition():
        if time.monotonic() > deadline:
            code = condition.__code__
            raise TimeoutError(f"waited in vain: {code.co_filename}, line {code.co_firstlineno}")
        yield BETWEEN


def lamps_are_drawn() -> bool:
    """Whether viewports wait for no lamp: none is being measured, and no shader compiled."""
    from sdf_lights.blender.viewport import drawn

    if drawn.overlay is None:  # nothing has been drawn yet
        return False
    labels = {text for region in drawn.overlay._labels.values() for _, text in region}
    return not drawn.overlay.finder.busy and not labels & {"Compiling…", "Measuring…"}


# -- places ---------------------------------------------------------------------------------------------------------


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def areas(kind: str = "VIEW_3D") -> list[bpy.types.Area]:
    """Areas of a kind, the largest first."""
    found = [area for area in window().screen.areas if area.type == kind]
    return sorted(found, key=lambda area: -area.width * area.height)


def region_of(area: bpy.types.Area, kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in area.regions if region.type == kind)


def override(area: bpy.types.Area | None = None, kind: str = "WINDOW"):
    """The context of a region of an area; of the largest 3D viewport by default."""
    area = area or areas()[0]
    return bpy.context.temp_override(window=window(), area=area, region=region_of(area, kind))


def inside(area: bpy.types.Area, across: float = 0.5, up: float = 0.5, kind: str = "WINDOW") -> Place:
    """A position in a region of an area, given as fractions of its width and height."""
    region = region_of(area, kind)
    return region.x + across * region.width, region.y + up * region.height


def on_screen(area: bpy.types.Area, point: tuple[float, float, float]) -> Place:
    """Position of a point of the scene in a 3D viewport."""
    region = region_of(area)
    x, y = location_3d_to_region_2d(region, area.spaces.active.region_3d, point)
    return region.x + x, region.y + y


def threads() -> list[str]:
    """Threads of the path tracer in viewports."""
    return sorted(thread.name for thread in threading.enumerate() if thread.name == "SDF Lights: viewport")


# -- hands ----------------------------------------------------------------------------------------------------------


def event(kind: str, value: str, place: Place, **options) -> None:
    window().event_simulate(type=kind, value=value, x=int(place[0]), y=int(place[1]), **options)


def move(place: Place, **modifiers: bool) -> Place:
    """Move the mouse there."""
    event("MOUSEMOVE", "NOTHING", place, **modifiers)
    return place


def press(place: Place, key: str, **modifiers: bool) -> None:
    """Press and release a key or a button of the mouse."""
    event(key, "PRESS", place, **modifiers)
    event(key, "RELEASE", place, **modifiers)


def typed(place: Place, text: str) -> None:
    for letter in text:
        key = KEYS.get(letter, letter.upper())
        event(key, "PRESS", place, **({} if letter in "\n\b" else dict(unicode=letter)))
        event(key, "RELEASE", place)


def drag(
    start: Place, end: Place, button: str = "LEFTMOUSE", steps: int = 6, after: Callable[[], object] = lambda: None
):
    """Steps: press a mouse button at ``start``, move, call ``after()`` after each move, and release at ``end``."""
    move(start)
    yield
    event(button, "PRESS", start)
    for step in range(1, steps + 1):
        yield BETWEEN
        move(tuple(a + (b - a) * step / steps for a, b in zip(start, end)))
        after()
    yield BETWEEN
    event(button, "RELEASE", end)
    yield


def button_of(area: bpy.types.Area, path: str, kind: str = "UI"):
    """Steps that find the position of a property's button by its data path; None if the region does not show it."""
    region = region_of(area, kind)
    x = region.x + 0.65 * region.width  # the middle of a number's button: its right end is an arrow, which adds a step
    for y in range(region.y + region.height - 4, region.y + 4, -10):
        move((x, y))
        yield BETWEEN
        with override(area, kind):
            if bpy.ops.ui.copy_data_path_button.poll():
                bpy.ops.ui.copy_data_path_button(full_path=True)
                if bpy.context.window_manager.clipboard == path:
                    return x, y
    return None


# -- eyes -----------------------------------------------------------------------------------------------------------


class Eye:
    """Colours of 3D viewports at world positions: scene-linear, everything drawn before colour management.

    Blender's own screenshots are black without a graphics card. ``colors[area index, place]`` is the mean of 5 × 5
    pixels at the last redraw; areas count from the largest.
    """

    def __init__(self, *places: tuple[float, float, float]):
        self.places = list(places)
        self.colors: dict[tuple[int, int], np.ndarray] = {}
        self.redraws = 0
        self._buffer = None
        add = bpy.types.SpaceView3D.draw_handler_add
        self._handles = [add(self._before, (), "WINDOW", "PRE_VIEW"), add(self._after, (), "WINDOW", "POST_PIXEL")]

    def close(self) -> None:
        for handle in self._handles:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")

    def color(self, place: int = 0, area: int = 0) -> list[float]:
        return self.colors[area, place].tolist()

    def _before(self):
        self._buffer = gpu.state.active_framebuffer_get()

    def _after(self):
        context = bpy.context
        with contextlib.suppress(ValueError):  # of an area that is not in the main window
            area = areas().index(context.area)
            for index, place in enumerate(self.places):
                at = location_3d_to_region_2d(context.region, context.region_data, place)
                if at is not None and 2 <= at.x < context.region.width - 3 and 2 <= at.y < context.region.height - 3:
                    values = self._buffer.read_color(int(at.x) - 2, int(at.y) - 2, 5, 5, 4, 0, "FLOAT")
                    values.dimensions = 100
                    self.colors[area, index] = np.array(values).reshape(25, 4)[:, :3].mean(axis=0)
        self.redraws += 1


def picture(folder: str | None, name: str, crop: bpy.types.Area | None = None) -> None:
    """A screenshot of the window, or of an area, into a folder, if there is one. Needs ImageMagick's `import`."""
    if folder is None:
        return
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    whole = window()
    part, x, y = (crop, crop.x, crop.y) if crop is not None else (whole, 0, 0)
    subprocess.run(
        [
            "import",
            "-window",
            "root",
            "-gravity",
            "SouthWest",
            "-crop",
            f"{part.width}x{part.height}+{whole.x + x}+{whole.y + y}",
            "+repage",
            "-strip",
            "-define",
            "png:compression-level=9",
            str(pathlib.Path(folder) / f"{name}.png"),
        ],
        check=True,
    )
