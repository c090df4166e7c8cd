# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates hours of work in a Blender with a window: edits, undos, renders, cancels by Esc, opening and closing
viewports.

    blender --factory-startup --python soak_session.py -- REPORT.json STEPS SECONDS SEED

Ends after so many steps or seconds, whichever comes first. The report has the resources of the process, in ``before``
after a third of the steps and in ``after`` at the end: memory, threads, handles. Each time one viewport is left, in
Solid shading. Simulated events replace real ones. Only a real Esc stops a render: xdotool presses it, if it is
installed.
"""

import pathlib
import shutil
import subprocess
import sys
import threading
import time

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, override, report, run, threads, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from benchmarks.soaking import Actor, fill_caches, handles, memory  # noqa: E402
from sdf_lights.blender.viewport import rendered  # noqa: E402

STEPS, SECONDS, SEED = int(ARGUMENTS[1]), float(ARGUMENTS[2]), int(ARGUMENTS[3])
WARM_UP = 1.0 / 3.0  # of the work
MANY = 1 << 20  # samples of a render that is to be cancelled
PATIENCE = 60.0
RESTS = 5  # seconds


def is_rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


class Artist(Actor):
    """Works in a window, with one or two viewports."""

    def __init__(self, scene, seed: int):
        super().__init__(scene, seed)
        self.kinds += [self.shade, self.shade, self.orbit, self.divide]
        if shutil.which("xdotool"):
            self.kinds.append(self.escape)
        self.longest_escape = 0.0

    def step(self):
        yield from super().step()
        yield self.random.choice([0.02, 0.1, 0.3])  # that Blender has for its redraws

    def push(self, name: str) -> None:
        with override():
            super().push(name)

    def undo(self) -> None:
        with override():
            super().undo()

    def shade(self) -> None:
        """A viewport that starts or stops rendering."""
        area = self.random.choice(areas())
        area.spaces.active.shading.type = self.random.choice(["RENDERED", "RENDERED", "SOLID"])

    def orbit(self) -> None:
        for area in areas():
            region = area.spaces.active.region_3d
            region.view_distance = self.random.uniform(3.0, 9.0)
            region.view_location.z = self.random.uniform(0.0, 1.0)

    def divide(self):
        """Split one viewport in two, or join two."""
        if len(areas()) == 1:
            with override():
                bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
            yield from until(lambda: len(areas()) == 2, PATIENCE)
            for area in areas():
                area.spaces.active.shading.type = "RENDERED"
        else:
            yield from self.join()

    def join(self):
        """Join two viewports: one of them can take the other's area, not always the smaller one's."""
        deadline = time.monotonic() + PATIENCE
        while len(areas()) > 1:
            for area in reversed(areas()):
                with override(area):
                    if bpy.ops.screen.area_close() == {"FINISHED"}:
                        break
            yield 0.3
            if time.monotonic() > deadline:
                raise TimeoutError("viewports cannot be joined")

    def escape(self):
        """An endless render, which the key ends."""
        self.scene.sdf_lights.samples = MANY
        with override():
            bpy.ops.render.render("INVOKE_DEFAULT")
        yield self.random.uniform(0.0, 1.0)
        yield from until(is_rendering, PATIENCE)
        started = time.monotonic()
        press = ["xdotool", "search", "--class", "blender", "windowfocus", "key", "Escape"]
        subprocess.run(press, check=True, timeout=PATIENCE)
        yield from until(lambda: not is_rendering(), PATIENCE)
        self.longest_escape = max(self.longest_escape, time.monotonic() - started)
        self.scene.sdf_lights.samples = 1

    def rest(self):
        """One viewport, which does not render."""
        yield from self.join()
        areas()[0].spaces.active.shading.type = "SOLID"
        yield from until(lambda: not threads(), PATIENCE)
        yield 1.0

    def held(self):
        """The resources at rest. Memory is the least of some seconds: Blender frees what its jobs had when it next
        redraws, which may be late on a busy machine."""
        least = memory()
        for _ in range(RESTS):
            yield 1.0
            least = min(least, memory())
        return dict(memory=least, handles=handles(), threads=sorted(thread.name for thread in threading.enumerate()))


def scene() -> bpy.types.Scene:
    made = bpy.context.scene
    made.render.engine = "SDF_LIGHTS"
    made.render.resolution_x = made.render.resolution_y = 16
    made.render.resolution_percentage = 100
    made.sdf_lights.device, made.sdf_lights.samples, made.sdf_lights.noise_threshold = "CPU", 1, 0.0
    bpy.context.preferences.view.render_display_type = "NONE"
    for name in ("First", "Second"):
        data = bpy.data.lights.new(name, "POINT")
        data.sdf_lamp.use = True
        made.collection.objects.link(bpy.data.objects.new(name, data))
    return made


def session():
    addon.register()
    artist = Artist(scene(), SEED)
    with override():
        bpy.ops.ed.undo_push(message="Scene")
        bpy.ops.ed.undo_push(message="Begin")  # what the first undo takes back
    bpy.ops.render.render()  # compiles, if need be
    areas()[0].spaces.active.shading.type = "RENDERED"
    yield from until(lambda: any(view.drawn is not None for view in list(rendered._running)))
    fill_caches()
    started, done = time.monotonic(), 0
    samples = []

    def part() -> float:
        return max(done / STEPS, (time.monotonic() - started) / SECONDS)

    for end in (WARM_UP, 1.0):
        while part() < end:
            yield from artist.step()
            done += 1
            if done % 50 == 0:
                samples.append(memory())
        yield from artist.rest()
        if end < 1.0:
            report["before"], report["steps of the warm-up"] = (yield from artist.held()), done
    report["after"], report["steps"], report["seconds"] = (yield from artist.held()), done, time.monotonic() - started
    report["counts"], report["memory at each 50 steps"] = artist.counts, samples
    report["longest escape"] = artist.longest_escape
    report["failures"] = sys.modules["sdf_lights.blender.viewport"]._failures


run(session())
