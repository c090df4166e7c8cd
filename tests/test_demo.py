# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo command, as a user runs it."""

import io
import pathlib
import re
import subprocess
import sys

import numpy as np
import OpenImageIO
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "scripts"))

import demo  # noqa: E402  (found on the path set above)
from stages import Stages  # noqa: E402

DEMO = [REPOSITORY / "scripts" / "demo"]


def run(*arguments, timeout: float = 600.0):
    return subprocess.run(
        [*DEMO, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, stdin=subprocess.DEVNULL
    )


def pixels(path: pathlib.Path) -> np.ndarray:
    picture = OpenImageIO.ImageBuf(str(path))
    assert not picture.has_error, picture.geterror()
    return picture.get_pixels(OpenImageIO.FLOAT)


@pytest.mark.slow  # compiles the kernels where that has not been done
def test_demo_scene_renders_to_both_files_and_tells_about_it(tmp_path):
    done = run(
        "--size",
        "96x54",
        "--samples",
        16,  # the fewest whose noise can be estimated
        "--no-denoise",
        "--noise-threshold",
        0,
        "--seed",
        3,
        "--out",
        tmp_path / "demo",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    linear, shown = pixels(tmp_path / "demo.exr"), pixels(tmp_path / "demo.png")
    assert OpenImageIO.ImageBuf(str(tmp_path / "demo.exr")).spec().format == OpenImageIO.FLOAT
    assert linear.shape == (54, 96, 4)
    assert shown.shape == (54, 96, 3)
    colour = linear[..., :3]
    assert np.isfinite(colour).all()
    assert colour.max() > 1.0  # a lamp that is seen
    assert (colour.mean(axis=2) > 0.0).mean() > 0.99  # a closed room: light gets everywhere
    assert 0.0 <= shown.min() and shown.max() <= 1.0

    assert str(tmp_path / "demo.exr") in done.stdout
    assert str(tmp_path / "demo.png") in done.stdout
    said = re.search(
        r"(\d+) pixels, ([\d.]+) samples per pixel, ([\d.]+) s, ([\d.]+) million samples/s, noise ([\d.]+) %",
        done.stdout,
    )
    assert said, done.stdout
    assert int(said[1]) == 96 * 54
    assert float(said[2]) == pytest.approx(16.0, rel=0.05)  # guided samples keep to their number on average
    assert float(said[4]) > 0.0 and float(said[5]) > 0.0
    assert re.search(r"\[█*·*\] +\d+ %  \d+:\d\d left  Sample \d+/16", done.stdout)


def test_the_time_left_is_of_all_stages_and_follows_the_machine():
    """A machine of half the speed, whose second stage is not needed: the bar never goes back, and ends in time."""
    now = 0.0
    stream = io.StringIO()
    stages = Stages({"first": 10.0, "second": 100.0, "third": 20.0}, stream, lambda: now)
    stages.show("begins")
    left = []
    for now in np.linspace(0.0, 20.0, 81):
        stages.show("first", now / 20.0)
    assert 140.0 < stages.left() < 250.0  # 240 s at that pace, of which so short a time does not convince
    stages.begin("third")
    for now in np.linspace(20.0, 60.0, 161):
        stages.show("third", (now - 20.0) / 40.0)
        left.append(now + stages.left())
    assert left[-1] == pytest.approx(60.0) and max(abs(end - 60.0) for end in left[len(left) // 4 :]) < 6.0
    stages.begin("first")  # is over
    parts = [int(text) for text in re.findall(r"(\d+) %", stream.getvalue())]
    assert parts == sorted(parts) and len(parts) >= 5


def test_reference_renders_a_file_that_is_given(tmp_path):
    """Its own settings hold unless they are overridden; the NumPy back end compiles nothing."""
    script = tmp_path / "make.py"
    script.write_text(
        f"""
import sys
sys.path.insert(0, {str(REPOSITORY / "scripts")!r})
import bpy, host
host.register_extension()
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
light = bpy.data.lights.new("Lamp", "POINT")
host.set_lamp(light, "sphere", radius=1.0)
light.energy = 100.0
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.location = (0.0, 0.0, 6.0)
for thing in (bpy.data.objects.new("Lamp", light), camera):
    scene.collection.objects.link(thing)
scene.camera = camera
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 40, 20, 50
scene.sdf_lights.samples = 16
scene.sdf_lights.filter, scene.sdf_lights.filter_width = "BOX", 1.0
bpy.ops.wm.save_as_mainfile(filepath={str(tmp_path / "lamp.blend")!r})
scene.view_layers[0].use_pass_shadow = True
bpy.ops.wm.save_as_mainfile(filepath={str(tmp_path / "passes.blend")!r})
host.finish(0)
""",
        encoding="utf-8",
    )
    python = subprocess.run(
        [REPOSITORY / "scripts" / "environment.sh"], capture_output=True, text=True, check=True
    ).stdout.strip()
    subprocess.run([python, script], check=True, timeout=120)
    done = run("--scene", tmp_path / "lamp.blend", "--device", "reference", "--out", tmp_path / "lamp")
    assert done.returncode == 0, done.stdout + done.stderr
    colour = pixels(tmp_path / "lamp.exr")[..., :3]
    assert colour.shape == (10, 20, 3)
    # Radiance is ρ = power / (4π V) times the chord, here over the four pixels in the middle: 36 mm of sensor at 50 mm.
    density = 100.0 / (4.0 * np.pi * (4.0 / 3.0 * np.pi))
    offset = (np.arange(64) + 0.5) / 64 * 2.0 - 1.0
    square = (offset[:, None] ** 2 + offset[None, :] ** 2) * (36.0 / 50.0 / 20.0) ** 2
    nearest = 6.0**2 * square / (1.0 + square)  # of each ray to the centre, squared
    assert colour[4:6, 9:11].mean() == pytest.approx(density * 2.0 * np.sqrt(1.0 - nearest).mean(), rel=0.005)
    assert colour[0, 0].max() == 0.0

    # What is not rendered as the file says is told, and fails a strict render.
    done = run("--scene", tmp_path / "passes.blend", "--device", "reference", "--strict", "--out", tmp_path / "passes")
    assert done.returncode == 1 and not (tmp_path / "passes.exr").exists()
    assert "these passes are not supported and are left out: Shadow" in done.stdout + done.stderr
    assert "1 item is not rendered as the scene says" in done.stderr


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["--scene", "nowhere.blend"], "there is no file nowhere.blend"),
        (["--samples", "0"], "'0' is not a number of samples"),
        (["--samples", "many"], "'many' is not a number of samples"),
        (["--size", "640"], "'640' is not WIDTHxHEIGHT"),
        (["--noise-threshold", "nan"], "'nan' is not a relative error"),
        (["--seed", "-1"], "'-1' is not a seed"),
        (["--device", "abacus"], "invalid choice: 'abacus'"),
        (["--colour"], "unrecognized arguments: --colour"),
    ],
)
def test_a_wrong_call_gets_one_sentence(arguments, sentence, capfd):
    assert demo.main(arguments) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith("demo: ") and said.err.count("\n") == 1
    assert sentence in said.err


def test_a_file_that_is_no_blend_gets_one_sentence():
    done = run("--scene", REPOSITORY / "LICENSE", timeout=60)
    assert done.returncode == 2
    assert "is no .blend that this Blender" in done.stderr
    assert done.stderr.count("\n") == 1
