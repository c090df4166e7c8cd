# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendering without a window, as farms do it: the installed extension, and ``blender -b FILE -E SDF_LIGHTS``."""

import contextlib
import dataclasses
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

# Saved with another engine, so that -E is what chooses this one. The lamp is above the horizon, in the upper half.
MAKE = """
import bpy

bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
floor = bpy.data.meshes.new("Floor")
floor.from_pydata([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [], [(0, 1, 2, 3)])
light = bpy.data.lights.new("Lamp", "POINT")
light.energy = 100.0
light.sdf_lamp.use, light.sdf_lamp.shape = True, "SPHERE"
for frame, radius in ((1, 0.25), (2, 0.75)):
    light.sdf_lamp.sphere.radius = radius
    light.sdf_lamp.sphere.keyframe_insert("radius", frame=frame)
lamp = bpy.data.objects.new("Lamp", light)
lamp.location = (0.0, 0.0, 2.0)
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.location, camera.rotation_euler = (0.0, -6.0, 1.0), (1.5707963, 0.0, 0.0)
for thing in (bpy.data.objects.new("Floor", floor), lamp, camera):
    scene.collection.objects.link(thing)
scene.camera = camera
scene.render.engine = "BLENDER_WORKBENCH"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.frame_start, scene.frame_end = 1, 2
scene.sdf_lights.samples = 16
# Ranges of samples then make the picture of one render: see docs/farm.md.
scene.sdf_lights.guided_samples, scene.sdf_lights.noise_threshold = False, 0.0
scene.sdf_lights.indirect_paths, scene.sdf_lights.lamp_paths = 1, "NEVER"
scene.sdf_lights.path_reuse = scene.sdf_lights.caustic_paths = "NEVER"
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""

# The same scene as somebody saved it who renders with Cycles, and with something that is not supported.
CYCLES = """
import bpy

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.property_unset("sdf_lights")
cycles = scene.cycles
cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising, cycles.film_exposure = 16, False, False, 4.0
bpy.ops.wm.save_as_mainfile(filepath={path!r})
cycles.use_fast_gi = True
bpy.ops.wm.save_as_mainfile(filepath={blurred!r})
"""


LEAK = "Error: Not freed memory blocks.*"  # of Blender's sequencer, where it has made a movie of pictures


@dataclasses.dataclass
class Installed:
    """A Blender that has the extension, in ``folder``, and the ``file`` of the scene."""

    command: list[str]
    environment: dict[str, str]
    folder: pathlib.Path
    file: pathlib.Path

    def run(self, *arguments) -> subprocess.CompletedProcess:
        return subprocess.run(
            [*self.command, *map(str, arguments)],
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=600,
        )

    def blender(self, *arguments) -> None:
        done = self.run(*arguments)
        assert done.returncode == 0, done.stdout
        said = re.sub(LEAK, "", done.stdout)
        assert "Traceback" not in said and "Error" not in said, said


@pytest.fixture(scope="module")
def installed(blender_command, blender_zip, tmp_path_factory) -> Installed:
    folder = tmp_path_factory.mktemp("installed")
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(folder / "resources")}
    (folder / "resources").mkdir()
    found = Installed(blender_command, environment, folder, folder / "lamp.blend")
    script = folder / "make.py"
    script.write_text(MAKE.format(path=str(found.file)), encoding="utf-8")
    found.blender("--command", "extension", "install-file", "--repo", "user_default", "--enable", blender_zip)
    found.blender("--background", "--python-exit-code", "1", "--python", script)
    return found


@pytest.mark.gui
def test_frames_are_rendered_without_a_window(installed, tmp_path):
    openimageio = pytest.importorskip("OpenImageIO")
    file, script, run, blender = installed.file, tmp_path / "make.py", installed.run, installed.blender

    def picture(name: str) -> np.ndarray:
        """(32, 48, 3), row 0 at the top."""
        return openimageio.ImageInput.open(str(tmp_path / name)).read_image(openimageio.FLOAT)[..., :3]

    blender("--background", file, "-E", "SDF_LIGHTS", "-o", tmp_path / "single_####", "-f", "1")
    blender("--background", file, "-E", "SDF_LIGHTS", "-o", tmp_path / "film_####", "-a")
    names = sorted(path.name for path in tmp_path.glob("*.exr"))
    assert names == ["film_0001.exr", "film_0002.exr", "single_0001.exr"]
    single, first, second = (picture(name) for name in ("single_0001.exr", "film_0001.exr", "film_0002.exr"))
    assert (single == first).all()
    for frame in (first, second):
        assert np.isfinite(frame).all() and frame[-1].min() > 0.0  # the floor is lit
    # The lamp is nine times as large in the second frame, but for the pixels that its edge crosses.
    sizes = [np.count_nonzero(frame[:16].max(axis=2)) for frame in (first, second)]
    assert 0 < 4 * sizes[0] < sizes[1]

    # A file of Cycles that was never opened in a window has its settings.
    of_cycles, blurred = tmp_path / "cycles.blend", tmp_path / "blurred.blend"
    script.write_text(CYCLES.format(path=str(of_cycles), blurred=str(blurred)), encoding="utf-8")
    blender("--background", file, "--python-exit-code", "1", "--python", script)
    blender(
        "--background", of_cycles, "-E", "SDF_LIGHTS", "-o", tmp_path / "cycles_####", "-f", "1", "--", "--sdf-strict"
    )
    assert picture("cycles_0001.exr").mean() == pytest.approx(4.0 * single.mean(), rel=0.1)

    # A strict render ends with 1, without a picture; any other one tells, and goes on.
    arguments = "--background", blurred, "-E", "SDF_LIGHTS", "-o", tmp_path / "blurred_####", "-f", "1"
    done = run(*arguments, "--", "--sdf-strict")
    assert done.returncode == 1 and "Fast GI is not supported" in done.stdout, done.stdout
    assert "1 item is not rendered as the scene says" in done.stdout
    done = run(*arguments)
    assert done.returncode == 0 and "Fast GI is not supported" in done.stdout, done.stdout
    assert picture("blurred_0001.exr").mean() > 0.0

    # So does one that fails, and one whose arguments are wrong.
    done = run(
        "--background", file, "-E", "SDF_LIGHTS", "-o", tmp_path / "wrong_####", "-f", "1", "--", "--sdf-samples", "all"
    )
    assert done.returncode == 1 and "--sdf-samples all: write a whole number" in done.stdout, done.stdout


def kill_renders(word: str) -> bool:
    """End the Blender that has this word among its arguments, at once; whether there was one."""
    found = False
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it may have ended
            arguments = (process / "cmdline").read_bytes()
            if word.encode() in arguments and b"SDF_LIGHTS" in arguments:
                os.kill(int(process.name), signal.SIGKILL)
                found = True
    return found


def environment_with(package: str, folder: pathlib.Path) -> pathlib.Path:
    """The Python of a new environment that has a package. The test is skipped where there is no index of packages."""
    python = folder / "bin" / "python"
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", package]
    if subprocess.run(pip, capture_output=True).returncode:
        pytest.skip(f"pip cannot install {package}")
    return python


def frames_of_movie(path: pathlib.Path) -> int:
    import bpy

    clip = bpy.data.movieclips.load(str(path))
    try:
        return clip.frame_duration
    finally:
        bpy.data.movieclips.remove(clip)


FRAMES, TASKS = 10, 2


@pytest.mark.gui
def test_a_farm_renders_an_animation(installed, tmp_path):
    """By the job that a command writes, with Open Job Description's own runner. One task is killed; its frames are
    whole after the next run."""
    openimageio = pytest.importorskip("OpenImageIO")
    python = environment_with("openjd-cli==0.8.0", tmp_path / "openjd")
    job, folder = installed.folder / "job.json", installed.folder / "frames"
    installed.blender(
        *("-b", "-c", "sdf_lights_job", job, installed.file, "--frames", f"1-{FRAMES}", "--samples", "16"),
        *("--tasks", TASKS, "--folder", folder, "--movie"),
    )
    assert len(json.loads(job.read_text())["steps"]) == 3
    # A template names one program, and the command of a Blender with a window may be longer.
    start = tmp_path / "start"
    start.write_text("#!/bin/sh\nexec " + " ".join(installed.command) + ' "$@"\n', encoding="utf-8")
    start.chmod(0o755)
    openjd = [
        python,
        "-m",
        "openjd",
        "run",
        job,
        "--job-param",
        f"Blender={start}",
        "--step",
        "Movie",
        "--run-dependencies",
    ]

    with open(tmp_path / "log", "w") as log:  # a pipe that nobody reads would fill, and stop it
        began = subprocess.Popen([*map(str, openjd)], env=installed.environment, stdout=log, stderr=log)
    killed = False
    while not killed and began.poll() is None:  # between two tasks there is none to kill
        time.sleep(0.02)
        killed = len(list(folder.glob("parts/*.exr"))) > 2 and kill_renders(f"{folder}/parts")
    assert began.wait(timeout=600) != 0 and killed, (tmp_path / "log").read_text()
    assert not list(folder.glob("*.exr"))

    done = subprocess.run([*map(str, openjd)], env=installed.environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
    names = sorted(path.name for path in folder.glob("*.exr"))
    assert names == [f"{frame:04}.exr" for frame in range(1, FRAMES + 1)]

    assert frames_of_movie(folder / "movie.mp4") == FRAMES

    def channels(path: pathlib.Path) -> np.ndarray:
        return openimageio.ImageInput.open(str(path)).read_image(openimageio.FLOAT)[..., :3]

    installed.blender("-b", installed.file, "-E", "SDF_LIGHTS", "-o", tmp_path / "whole_####", "-f", "1")
    found, whole = channels(folder / "0001.exr"), channels(tmp_path / "whole_0001.exr")
    np.testing.assert_allclose(found, whole, rtol=1e-5, atol=1e-7)


FLAMENCO = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "flamenco" / "sdf_lights.js"
# What the Flamenco Manager gives to job types, as its documents say, with tasks in the order in which they may run.
MANAGER = """
const tasks = [];
const author = {
    Command: (name, parameters) => ({ name, parameters }),
    Task: (name, type) => {
        const task = { name, type, commands: [], after: [] };
        task.addCommand = command => task.commands.push(command);
        task.addDependency = other => task.after.push(other.name);
        return task;
    },
};
const path = { join: (...parts) => parts.join("/") };
const frameChunker = (frames, size) => {
    const [first, last] = frames.split("-").map(Number);
    return Array.from({ length: last - first + 1 }, (_, index) => String(first + index));
};
"""
COMPILE = """
import json, sys
import quickjs
context = quickjs.Context()
manager, job_type, settings = sys.stdin.read().split("\\0")
context.eval(manager + job_type)
context.eval("compileJob({ settings: " + settings + ", addTask: task => tasks.push(task) })")
print(json.dumps([json.loads(context.eval("JSON.stringify(tasks)")), json.loads(context.eval("JSON.stringify(JOB_TYPE)"))]))
"""


@pytest.mark.gui
def test_flamenco_renders_an_animation(installed, tmp_path):
    """The job type makes tasks, in an engine of JavaScript; each is run as a worker of Flamenco does."""
    python, folder = environment_with("quickjs==1.19.4", tmp_path / "quickjs"), tmp_path / "frames"
    settings = dict(frames="1-2", samples=7, tasks_per_frame=2, denoise=False, movie=True)
    settings |= dict(render_output_path=str(folder), blendfile=str(installed.file))
    source = "\0".join([MANAGER, FLAMENCO.read_text(encoding="utf-8"), json.dumps(settings)])
    done = subprocess.run([python, "-c", COMPILE], input=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    tasks, job_type = json.loads(done.stdout)
    assert settings.keys() <= {item["key"] for item in job_type["settings"]}
    finished: list[str] = []
    for task in tasks:
        assert set(task["after"]) <= set(finished)
        for command in task["commands"]:
            given = command["parameters"]
            file = ["-b", given["blendfile"]] if command["name"] == "blender-render" else []
            assert given["exe"] == "{blender}"
            installed.blender(*file, *given["args"])
        finished.append(task["name"])
    assert len(finished) == 2 * 3 + 1
    assert sorted(path.name for path in folder.glob("*.exr")) == ["0001.exr", "0002.exr"]
    assert frames_of_movie(folder / "movie.mp4") == 2
