# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames are complete, even if Blender was killed; the animation then goes on with the next one."""

import pathlib
import signal
import subprocess
import sys

import bpy
import OpenImageIO
import pytest

from sdf_lights.blender import whole_files

kills = pytest.mark.skipif(sys.platform == "win32", reason="has no SIGKILL")

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

RENDER = """
import os, signal, sys
sys.path[:0] = [{repository!r}, {repository!r} + "/scripts"]
import bpy
import host
from sdf_lights import blender

blender.register()
bpy.ops.wm.open_mainfile(filepath={path!r})

def kill_when_written(scene, *_):
    if scene.frame_current == 2:
        os.kill(os.getpid(), signal.SIGKILL)

def kill_while_writing(scene, *_):
    if scene.frame_current == 2:  # Python ignores this signal, which otherwise ends the process
        import resource
        half = os.path.getsize(scene.render.frame_path(frame=1)) // 2
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_FSIZE, (half, half))

if {when!r} == "written":
    bpy.app.handlers.render_post.append(kill_when_written)
if {when!r} == "writing":
    bpy.app.handlers.render_pre.insert(0, kill_while_writing)
bpy.ops.render.render(animation=True)
host.finish(0)
"""


def run(path: pathlib.Path, when: str = "") -> int:
    """Exit code of a process that renders an animation. It kills itself when it has ``written`` the second
    frame, which may not have its name yet; or the system kills it while it is ``writing`` that frame, at half the
    size of the first one."""
    text = RENDER.format(repository=str(REPOSITORY), path=str(path), when=when)
    done = subprocess.run(
        [sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300
    )
    print(done.stdout)
    return done.returncode


def rows(path: pathlib.Path) -> int:
    """Rows of an image file that OpenImageIO reads from the first one on."""
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        return 0
    parts = [source.spec()]
    while source.seek_subimage(len(parts), 0):
        parts.append(source.spec())
    found = []
    for part, spec in enumerate(parts):
        found.append(0)
        while (
            found[-1] < spec.height
            and source.read_scanlines(part, 0, found[-1], found[-1] + 1, 0, 0, spec.nchannels, OpenImageIO.UNKNOWN)
            is not None
        ):
            found[-1] += 1
    source.close()
    return min(found)


def names(folder: pathlib.Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


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


@kills
def test_an_animation_goes_on_after_it_was_killed(animation, tmp_path):
    path = tmp_path / "film.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert run(path, "written") == -signal.SIGKILL
    assert names(animation) == [".unfinished-film_0002.exr", "film_0001.exr"]
    first = (animation / "film_0001.exr").stat().st_mtime_ns
    assert run(path) == 0
    assert names(animation) == [f"film_000{frame}.exr" for frame in (1, 2, 3)]
    assert (animation / "film_0001.exr").stat().st_mtime_ns == first


@kills
@pytest.mark.parametrize("kind", ["OPEN_EXR", "OPEN_EXR_MULTILAYER"])
def test_half_a_frame_never_has_its_name(animation, file, tmp_path, kind):
    """Real halves of frames, in every Blender: the system lets no file become larger than that."""
    path, scene = tmp_path / "film.blend", file.scene
    scene.render.resolution_x = scene.render.resolution_y = 512
    scene.sdf_lights.samples, scene.frame_end = 1, 2
    if kind == "OPEN_EXR_MULTILAYER" and hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = kind, "32"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    half = animation / (whole_files.UNFINISHED + "film_0002.exr")
    assert run(path, "writing") == -signal.SIGXFSZ
    assert names(animation) == [half.name, "film_0001.exr"]
    assert rows(animation / "film_0001.exr") == 512 and rows(half) < 512
    first = (animation / "film_0001.exr").stat().st_mtime_ns
    assert run(path) == 0
    assert names(animation) == ["film_0001.exr", "film_0002.exr"]
    assert rows(animation / "film_0002.exr") == 512
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
    found = names(animation)
    assert len(found) >= 9 and not [name for name in found if name.startswith(whole_files.UNFINISHED)]


def test_each_view_has_its_file(animation, file):
    render = file.scene.render
    render.use_multiview, render.image_settings.views_format = True, "INDIVIDUAL"
    file.scene.frame_end = 1
    bpy.ops.render.render(animation=True)
    assert names(animation) == ["film_0001_L.exr", "film_0001_R.exr"]


def test_other_engines_are_left_alone(animation, file):
    file.scene.render.engine = "BLENDER_WORKBENCH"
    whole_files._begin(file.scene)
    assert file.scene.render.filepath == str(animation / "film_####")
