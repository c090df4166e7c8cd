# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session of the viewport benchmark in a Blender with a window: edits, and the time until they are seen.

    blender --factory-startup --python viewport_session.py -- REPORT.json REPEATS SHADING

For each kind of edit the report has, in milliseconds: ``restart``, until the render of the new scene has begun;
``picture``, until its first picture is there; ``seen``, until a redraw shows it. ``blocked`` is the longest time that
one of our functions kept Blender's main thread, ``worked`` the longest time that it computed. The rest is waiting,
mostly for the depth of the scene, which a software renderer must still draw. Lists, with a value for each edit.
"""

import pathlib
import sys
import time

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, override, report, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.viewport import overlay, rendered  # noqa: E402
from sdf_lights.render import interactive  # noqa: E402

REPEATS, SHADING = int(ARGUMENTS[1]), ARGUMENTS[2]
SUBDIVISIONS = 7  # of the grid's sides, by halving: 2 · 4⁹ triangles
SETTLED = 0.6  # seconds between edits


class Clock:
    """Seconds from an edit until each of ``STAGES``, which follow each other; and the times of our functions since."""

    STAGES = ("restart", "picture", "seen")

    def __init__(self):
        self.shading = ""
        self.started = 0.0
        self.times: dict[str, float] = {}
        self.blocked: list[tuple[float, float]] = []  # seconds, and of processor time

    def start(self) -> None:
        self.times.clear()
        self.blocked.clear()
        self.started = time.perf_counter()

    def after(self, shading: str, owner, name: str, stage: str) -> None:
        """In that shading, a stage is reached when ``owner.name`` returns, and the stages before it were."""
        function, before = getattr(owner, name), self.STAGES[: self.STAGES.index(stage)]

        def wrapper(*arguments, **keywords):
            result = function(*arguments, **keywords)
            if self.shading == shading and all(earlier in self.times for earlier in before):
                self.times.setdefault(stage, time.perf_counter() - self.started)
            return result

        setattr(owner, name, wrapper)

    def watch(self, owner, name: str) -> None:
        """Record how long the function takes, which Blender calls in its main thread."""
        function = getattr(owner, name)

        def wrapper(*arguments, **keywords):
            started, worked = time.perf_counter(), time.thread_time()
            try:
                return function(*arguments, **keywords)
            finally:
                self.blocked.append((time.perf_counter() - started, time.thread_time() - worked))

        setattr(owner, name, wrapper)

    def measured(self, edit, step: int, row: dict[str, list[float]]):
        """Steps: one edit, until a redraw shows it."""
        yield SETTLED
        self.start()
        edit(step)
        areas()[0].tag_redraw()
        yield from until(lambda: "seen" in self.times)
        for stage in self.STAGES:
            row[stage].append(1e3 * self.times[stage])
        for what, seconds in zip(("blocked", "worked"), zip(*self.blocked)):
            row[what].append(1e3 * max(seconds))


clock = Clock()


def scene():
    """Two lamps over a ground of 33 thousand triangles."""
    made = bpy.context.scene
    for obj in list(made.objects):
        bpy.data.objects.remove(obj)
    made.render.engine = "SDF_LIGHTS"
    made.sdf_lights.viewport.samples, made.sdf_lights.viewport.noise_threshold = 1 << 20, 0.0
    with override():
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=1 << SUBDIVISIONS, y_subdivisions=1 << SUBDIVISIONS, size=8.0)
        bpy.context.object.name = "Ground"
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(1.5, 0.0, 0.3))
        bpy.context.object.name = "Cube"
    for index, expression in enumerate(("sphere(0.4)", "box(0.8) - sphere(0.5)")):
        light = bpy.data.lights.new(f"Lamp {index}", "POINT")
        light.energy = 60.0
        light.sdf_lamp.use, light.sdf_lamp.source, light.sdf_lamp.expression = True, "EXPRESSION", expression
        lamp = bpy.data.objects.new(f"Lamp {index}", light)
        lamp.location = (-1.0 + 2.0 * index, 0.0, 0.8)
        made.collection.objects.link(lamp)


def edits(space):
    def turn(step):
        space.region_3d.view_rotation = space.region_3d.view_rotation @ _small_turn()

    def move(name):
        def edit(step):
            bpy.data.objects[name].location.x += 0.01

        return edit

    def reshape(step):
        bpy.data.lights["Lamp 1"].sdf_lamp.expression = f"box(0.8) - sphere({0.5 + 0.001 * (step + 1)})"

    def power(step):
        bpy.data.lights["Lamp 0"].energy += 1.0

    return {
        "view turned": turn,
        "power": power,
        "lamp moved": move("Lamp 1"),
        "shape": reshape,
        "object moved": move("Cube"),
    }


def _small_turn():
    from mathutils import Quaternion

    return Quaternion((0.0, 1.0, 0.0), 0.02)


def session():
    addon.register()
    scene()
    space = areas()[0].spaces.active
    space.overlay.show_extras = False
    for name in ("data_changed", "draw"):  # Blender counts the arguments of the engine's own methods
        clock.watch(rendered.RenderedView, name)
    for name in ("before_scene", "after_scene", "labels"):
        clock.watch(overlay.Overlay, name)
    rows = report["rows"] = []

    # The proxy has nothing to restart, and its picture is there when the scene has been drawn.
    for stage, name in zip(clock.STAGES, ("before_scene", "after_scene", "labels")):
        clock.after("SOLID", overlay.Overlay, name, stage)
    clock.after("RENDERED", interactive.InteractiveRender, "_prepare", "restart")
    clock.after("RENDERED", interactive.InteractiveRender, "_publish", "picture")
    clock.after("RENDERED", rendered.RenderedView, "_show", "seen")
    clock.shading = space.shading.type = SHADING
    yield 3.0
    yield from until(
        lambda: (
            SHADING == "SOLID"
            or any(view._render.picture and view._render.picture.samples > 1 for view in rendered._running)
        )
    )
    for name, edit in edits(space).items():
        rows.append(dict(shading=SHADING, edit=name, **{key: [] for key in (*clock.STAGES, "blocked", "worked")}))
        for step in range(REPEATS):
            yield from clock.measured(edit, step, rows[-1])


run(session())
