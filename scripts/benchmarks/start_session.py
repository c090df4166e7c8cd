# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of the benchmark ``start``: installs a zip in a Blender with empty user folders, and uses it for the first
time.

    python start_session.py REPORT.json ZIP F12                        in Blender's Python module
    blender … --python start_session.py -- REPORT.json ZIP PIXELS VIEWPORT|F12
    blender … --python start_session.py -- REPORT.json ZIP STALLS SECONDS

BLENDER_USER_RESOURCES names an empty folder.
"""

import json
import os
import pathlib
import sys
import time

import bpy

TICK = 0.005  # seconds from one look at the clock to the next
SETTLED = 8.0  # seconds until Blender's window has been drawn
REDRAWS = 5.0  # seconds from one redraw of the status bar to the next, before the add-on does it
EXTENSION = "bl_ext.user_default.sdf_lights"

ARGUMENTS = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]


def install() -> None:
    bpy.ops.extensions.package_install_files(filepath=ARGUMENTS[1], repo="user_default", enable_on_install=True)


def write(report: dict) -> None:
    pathlib.Path(ARGUMENTS[0]).write_text(json.dumps(report), encoding="utf-8")
    sys.stdout.flush()
    os._exit(0)


def first_picture() -> None:
    """Seconds of the first F12 of Blender's default scene, with a lamp as its light, until its first pixels."""
    bpy.ops.wm.read_factory_settings()
    install()
    scene = bpy.context.scene
    bpy.data.lights["Light"].sdf_lamp.use = True
    scene.render.engine = "SDF_LIGHTS"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 36, 100
    scene.sdf_lights.samples, scene.sdf_lights.denoise = 1, False
    seconds = []
    for _ in range(2):
        started, processor = time.perf_counter(), time.process_time()
        bpy.ops.render.render()
        seconds.append((time.perf_counter() - started, time.process_time() - processor))
    from bl_ext.user_default.sdf_lights.sdf_lights.render.session import process_memory

    write(
        dict(
            first=seconds[0][0],
            first_processor=seconds[0][1],
            later=seconds[1][0],
            memory=process_memory() / 1e6,
        )
    )


def first_pixels() -> None:
    """Seconds from the begin and from the end of the installation until the window has the first pixels of a lamp: in a
    rendered viewport, or of an F12."""
    state = dict(begun=0.0, installed=0.0, step=0)

    def done(*_) -> None:
        now = time.perf_counter()
        write(dict(from_begin=now - state["begun"], from_end=now - state["installed"]))

    def tick():
        if state["step"] == 0:
            state["begun"] = time.perf_counter()
            install()
            state.update(installed=time.perf_counter(), step=1)
            scene = bpy.context.scene
            bpy.data.lights["Light"].sdf_lamp.use = True
            scene.render.engine = "SDF_LIGHTS"
            if ARGUMENTS[3] == "F12":
                scene.render.resolution_percentage, scene.sdf_lights.samples = 25, 1
                bpy.context.preferences.view.render_display_type = "NONE"
                bpy.app.handlers.render_complete.append(done)
                with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
                    bpy.ops.render.render("INVOKE_DEFAULT")
                return None
            for area in bpy.context.window_manager.windows[0].screen.areas:
                if area.type == "VIEW_3D":
                    area.spaces.active.shading.type = "RENDERED"
        rendered = sys.modules.get(f"{EXTENSION}.sdf_lights.blender.viewport.rendered")
        if rendered and any(each._render.picture for each in rendered._running):
            done()
        return TICK

    bpy.app.timers.register(tick, first_interval=SETTLED, persistent=True)


def stalls() -> None:
    """Longest times that the window did not answer: first while it redraws its status bar without the add-on, then as
    long while kernels compile. Redraws of the status bar are told apart."""
    phases: list[dict] = [dict(drawing=[], other=[], work=[]) for _ in range(2)]
    texts: list[str] = []
    state = dict(last=0.0, work=0.0, phase=0, until=0.0, redraw=0.0, skip=0, drawn=False)
    wanted = float(ARGUMENTS[3])

    def drawn(self, context):
        state["drawn"] = True

    def tick():
        now, work = time.perf_counter(), time.thread_time()
        if state["skip"] > 0:  # what Blender itself takes to install, and to draw its whole window after that
            state["skip"] -= 1
        elif state["last"]:
            phase = phases[state["phase"]]
            phase["drawing" if state["drawn"] else "other"].append(1000.0 * (now - state["last"]))
            phase["work"].append(1000.0 * (work - state["work"]))
        state.update(last=now, work=work, drawn=False)
        if state["phase"] == 1:
            compiling = sys.modules.get(f"{EXTENSION}.sdf_lights.blender.compiling")
            text = compiling.short() if compiling else ""
            if text and (not texts or texts[-1] != text):
                texts.append(text)
        if state["phase"] == 0 and now > state["redraw"]:
            state["redraw"] = now + REDRAWS
            with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
                bpy.context.workspace.status_text_set(None)
        if now < state["until"]:
            return TICK
        if state["phase"] == 0:
            install()
            state.update(phase=1, until=time.perf_counter() + wanted, skip=2)
            return TICK
        before, after = (
            {kind: max(each, default=0.0) for kind, each in phase.items()}
            | dict(over_50=sum(gap > 50.0 for kind in ("drawing", "other") for gap in phase[kind]))
            for phase in phases
        )
        write(dict(before=before, after=after, texts=texts))
        return None

    bpy.types.STATUSBAR_HT_header.append(drawn)
    state["until"] = time.perf_counter() + SETTLED + wanted
    bpy.app.timers.register(tick, first_interval=SETTLED, persistent=True)


if ARGUMENTS[2] == "F12":
    first_picture()
elif ARGUMENTS[2] == "PIXELS":
    first_pixels()
else:
    stalls()
