# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame on disk is complete, even if Blender was killed; the animation then goes on with the next one."""

import pathlib
import signal
import subprocess
import sys

import bpy
import pytest

from sdf_lights.blender import whole_files

pytestmark = pytest.mark.skipif(not whole_files.SUPPORTED, reason="Blender 4.5 writes frames under their names")

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

# Killed when Blender has written the second frame, and before that has its name.
RENDER = """
import os, signal, sys
sys.path.insert(0, {repository!r})
import bpy
from sdf_lights import blender

blender.register()
bpy.ops.wm.open_mainfile(filepath={path!r})

def kill(scene, *_):
    if {kill} and scene.frame_current == 2:
        os.kill(os.getpid(), signal.SIGKILL)

bpy.app.handlers.render_post.append(kill)
bpy.ops.render.render(animation=True)
"""


@pytest.fixture
def animation(file, tmp_path):
    """The scene of three frames, in a folder with a space and an umlaut."""
    folder = tmp_path / "zwei Bücher"
    scene = file.scene
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(folder / "film_####")
    scene.render.use_overwrite = False
    return folder


@pytest.mark.skipif(sys.platform == "win32", reason="has no SIGKILL")
def test_an_animation_goes_on_after_it_was_killed(animation, tmp_path):
    path = str(tmp_path / "film.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)

    def run(kill: bool) -> int:
        text = RENDER.format(repository=str(REPOSITORY), path=path, kill=kill)
        return subprocess.run([sys.executable, "-c", text], capture_output=True, timeout=300).returncode

    assert run(kill=True) == -signal.SIGKILL
    assert sorted(path.name for path in animation.iterdir()) == [".unfinished-film_0002.exr", "film_0001.exr"]
    first = (animation / "film_0001.exr").stat().st_mtime_ns
    assert run(kill=False) == 0
    assert sorted(path.name for path in animation.iterdir()) == [f"film_000{frame}.exr" for frame in (1, 2, 3)]
    assert (animation / "film_0001.exr").stat().st_mtime_ns == first


def test_the_path_of_the_scene_is_as_before(animation, file, capsys):
    scene = file.scene
    for path in (str(animation / "film_####"), str(animation) + "/", str(animation / "#_film")):
        scene.render.filepath = path
        bpy.ops.render.render(animation=True)
        assert scene.render.filepath == path
    assert f"Saved: '{animation / 'film_0003.exr'}'" in capsys.readouterr().out
    bpy.ops.render.render(write_still=True)
    assert scene.render.filepath == path
    names = [path.name for path in animation.iterdir()]
    assert len(names) >= 9 and not [name for name in names if name.startswith(whole_files.UNFINISHED)]


def test_each_view_has_its_file(animation, file):
    render = file.scene.render
    render.use_multiview, render.image_settings.views_format = True, "INDIVIDUAL"
    file.scene.frame_end = 1
    bpy.ops.render.render(animation=True)
    assert sorted(path.name for path in animation.iterdir()) == ["film_0001_L.exr", "film_0001_R.exr"]


def test_other_engines_are_left_alone(animation, file):
    file.scene.render.engine = "BLENDER_WORKBENCH"
    whole_files._begin(file.scene)
    assert file.scene.render.filepath == str(animation / "film_####")
