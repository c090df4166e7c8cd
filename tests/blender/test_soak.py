# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hours of work in short: edits, undos, renders and cancels in one process, which keeps neither memory, threads nor
handles."""

import os
import pathlib
import subprocess
import sys
import threading
import weakref

import bpy
import pytest
from benchmarks import soaking
from benchmarks.soaking import handles, memory
from sessions import seen_by

from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.viewport import rendered
from sdf_lights.render.errors import RenderError
from sdf_lights.render.gpu import device
from sdf_lights.render.interactive import Change, InteractiveRender

ALONE = "SDF_LIGHTS_SOAK_ALONE"
REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
STEPS, WARM_UP = 500, 150
FLAT = 50 << 20  # bytes that may be more after the warm-up
REGISTERED = 100  # times
SECONDS = 780.0  # within which the session with a window comes to its end
SESSION = pathlib.Path(soaking.__file__).with_name("soak_session.py")


class Session(soaking.Actor):
    """Without a window: a viewport is the render that it would hold."""

    def __init__(self, scene: bpy.types.Scene, device: str, seed: int):
        super().__init__(scene, seed)
        scene.sdf_lights.device = device
        self.viewport = InteractiveRender()
        self.kinds.append(self.view)

    def view(self) -> None:
        """A viewport that takes the scene, and sometimes is closed while it renders."""
        self.viewport.update(self.read(), self.random.choice([Change.ALL, Change.ALL, Change.VIEW]))
        if self.random.random() < 0.3:
            self.viewport.stop()

    def steps(self, count: int) -> None:
        for _ in range(count):
            list(self.step())


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read where Linux tells it")
def test_five_hundred_steps_keep_nothing(request, file, stage, capfd):
    if ALONE not in os.environ:  # what thousands of other tests leave in this process would be counted, too
        command = [sys.executable, *"-m pytest -c tests/pytest.ini --rootdir . -q -m slow".split(), request.node.nodeid]
        environment = os.environ | {ALONE: "1"}
        done = subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout[-4000:]
        return
    file.scene.render.resolution_x = file.scene.render.resolution_y = 16
    file.scene.sdf_lights.samples = 1
    work = Session(file.scene, "CPU", 7)
    bpy.ops.ed.undo_push(message="Begin")
    try:
        work.render()
        work.view()
        soaking.fill_caches()
        work.steps(WARM_UP)
        work.viewport.stop()
        threads, before, open_before = set(threading.enumerate()), memory(), handles()
        work.steps(STEPS - WARM_UP)
    finally:
        work.viewport.stop()
    assert memory() - before < FLAT
    assert set(threading.enumerate()) <= threads
    assert handles() <= open_before
    assert len(work.counts) == 8 and min(work.counts.values()) > 20
    output = capfd.readouterr()
    assert "Traceback" not in output.out + output.err


@pytest.mark.gui
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read where Linux tells it")
def test_five_hundred_steps_in_a_window_keep_nothing(blender_command, tmp_path):
    arguments = str(STEPS), str(SECONDS), "7"
    alone = dict(size=(800, 540), real_keys=True, environment=soaking.C_LIBRARY)
    seen = seen_by(blender_command, SESSION, tmp_path, *arguments, **alone)
    assert seen["steps"] == STEPS and seen["steps of the warm-up"] < 0.5 * STEPS
    before, after = seen["before"], seen["after"]
    assert after["memory"] - before["memory"] < FLAT, seen["memory at each 50 steps"]
    assert after["handles"] <= before["handles"]
    assert set(after["threads"]) <= set(before["threads"])
    assert seen["failures"] == {}


def test_a_viewport_that_is_forgotten_ends_its_thread(file, stage):
    """Blender may free its part of an engine first: then nobody closes what the engine had."""
    file.scene.sdf_lights.samples = 1 << 20
    view = rendered.RenderedView()
    view._render.update(soaking.Actor(file.scene, 1).read(), Change.ALL)
    thread = view._render._thread
    assert thread.is_alive()
    del view
    assert not thread.is_alive()


@pytest.mark.parametrize("what", ["shape", "emission", "device"])
def test_errors_that_are_kept_keep_nobody(file, lamp, monkeypatch, what):
    """Whoever asks again is told again, and not remembered: it may be the engine of a viewport that was closed."""
    data = lamp()
    data.sdf_lamp.source, data.sdf_lamp.expression = "EXPRESSION", "sphere(0.3"
    data.sdf_lamp.emission.source, data.sdf_lamp.emission.expression = "EXPRESSION", "depth +"
    monkeypatch.setattr(device, "_found", [device.DeviceError("there is none")])
    ask = dict(
        shape=lambda: shape_of(data.sdf_lamp),
        emission=lambda: pattern_of(data.sdf_lamp),
        device=lambda: device.device(),
    )[what]

    def told(owner) -> str:
        try:
            ask()
        except (RenderError, device.DeviceError) as error:
            return str(error)
        return ""

    class Owner:
        pass

    owner = Owner()
    kept = weakref.ref(owner)
    assert told(owner) == told(owner) != ""
    del owner
    assert kept() is None


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read where Linux tells it")
def test_registering_a_hundred_times_keeps_nothing(file, registered):
    def again(times: int) -> None:
        for _ in range(times):
            registered.unregister()
            registered.register()

    again(10)
    threads, before, open_before = threading.active_count(), memory(), handles()
    again(REGISTERED)
    assert threading.active_count() == threads and handles() == open_before
    assert memory() - before < FLAT
