# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders that start anew when the scene changes, in both back ends."""

import dataclasses
import threading
import time

import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.interactive import Change, InteractiveRender
from sdf_lights.render.material import Material, Node
from sdf_lights.render.scene import Camera, Instance, Lamp, Mesh, Ray, Scene
from sdf_lights.render.settings import Device, Settings
from sdf_lights.sdf.shapes import Box, Sphere

PATIENCE = 300.0  # machine code may have to be compiled first


@pytest.fixture(params=[Device.REFERENCE, Device.CPU], ids=["reference", "cpu"])
def scene(request):
    """A ball lamp in the middle of the picture, 1 m in radius, with a radiance of 1 for each metre."""
    camera = Camera(np.eye(4), window=(-0.5, 0.5, -0.25, 0.25))
    matrix = np.eye(4)
    matrix[2, 3] = -8.0
    settings = Settings(samples=4, noise_threshold=0.0, device=request.param, threads=2, max_bounces=1)
    return Scene(camera, 48, 24, lamps=[Lamp("Ball", Sphere(1.0), matrix, density=1.0)], settings=settings)


@pytest.fixture
def render():
    made = InteractiveRender()
    yield made
    made.stop()


def wait(render, until, seconds=PATIENCE):
    deadline = time.monotonic() + seconds
    while not until():
        assert not render.error, render.error
        assert time.monotonic() < deadline, render.status
        time.sleep(0.005)


def finished(render):
    wait(render, lambda: render.finished)
    return render.picture


def moved(scene: Scene, x: float) -> Scene:
    matrix = np.eye(4)
    matrix[0, 3] = x
    return dataclasses.replace(scene, camera=dataclasses.replace(scene.camera, matrix=matrix))


def center_of(pixels: np.ndarray) -> float:
    """Mean column of the light."""
    weight = pixels[..., 0].sum(axis=0)
    return float((weight * np.arange(len(weight))).sum() / weight.sum())


def test_ends_as_the_final_render(render, scene):
    render.update(scene, Change.ALL)
    picture = finished(render)
    assert picture.samples == 4 and picture.divider == 1 and picture.window == (0, 0, 48, 24)
    if scene.settings.device is Device.CPU:  # the reference draws its numbers batch by batch
        np.testing.assert_array_equal(picture.pixels, session.render(scene, ()).read("Combined"))
    assert picture.pixels[12, 24, 0] == pytest.approx(2.0, rel=0.1)


def test_a_coarse_picture_of_the_same_frame_comes_first(render, scene):
    """Also where its pixels do not fit into the frame. The ball is so large that one sample a pixel cannot miss it."""
    ball = dataclasses.replace(scene.lamps[0], shape=Sphere(2.5))
    scene = dataclasses.replace(scene, width=45, height=22, lamps=[ball])
    seen = []
    publish = render._publish
    render._publish = lambda *args: (publish(*args), seen.append(render.picture))
    render.update(scene, Change.ALL)
    finished(render)
    coarse, fine = seen[0], seen[-1]
    assert coarse.divider == 8 and coarse.pixels.shape == (3, 6, 4)
    assert coarse.window == (0, 0, 48, 24) and coarse.size == (45, 22)
    assert 8 * center_of(coarse.pixels) + 3.5 == pytest.approx(center_of(fine.pixels), abs=4.0)


def test_coarse_pictures_may_leave_lamps_to_their_owner(render, scene):
    """What the lamps light is in them nevertheless."""
    floor = Mesh(
        "Floor",
        np.array([[-4, -4, -10], [4, -4, -10], [4, 4, -10], [-4, 4, -10]], np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
    scene = dataclasses.replace(
        scene, meshes=[floor], instances=[Instance(0, np.eye(4), (0,))], materials=[Material("White", Node("diffuse"))]
    )
    seen = []
    publish = render._publish
    render._publish = lambda *args: (publish(*args), seen.append(render.picture))
    render.coarse_lamps = False
    render.update(scene, Change.ALL)
    finished(render)
    assert not seen[0].lamps and seen[-1].lamps
    assert 0.0 < seen[0].pixels[..., :3].max() < 1.0 < seen[-1].pixels[..., :3].max()
    assert scene.lamps[0].visibility == Ray.ALL


def test_moves_of_the_camera_keep_the_scene(render, scene):
    render.update(scene, Change.ALL)
    before = finished(render)
    built = render._renderer
    render.update(moved(scene, 2.0), Change.VIEW)
    after = finished(render)
    assert render._renderer is built
    assert center_of(after.pixels) == pytest.approx(center_of(before.pixels) - 12.0, abs=0.3)
    assert after.camera.matrix[0, 3] == 2.0


def test_a_scene_that_changes_all_the_time_is_seen(render, scene):
    """Each change alone would interrupt the first picture of the scene before."""
    large = dataclasses.replace(scene, width=1280, height=640)
    render.update(large, Change.ALL)
    wait(render, lambda: render.picture is not None and render._pace)
    first = render.picture.number
    started = time.monotonic()
    while time.monotonic() - started < 3.0:
        render.hold()
        render.update(moved(large, time.monotonic() - started), Change.VIEW)
        time.sleep(0.01)
    assert render.picture.number >= first + 5


def test_a_held_render_waits_for_its_owner(render, scene):
    render.hold()
    render.update(dataclasses.replace(scene, settings=dataclasses.replace(scene.settings, samples=100_000)), Change.ALL)
    wait(render, lambda: render.picture is not None and render.picture.divider == 1)
    render.hold()
    time.sleep(0.5)
    number = render.picture.number
    time.sleep(0.5)
    assert render.picture.number == number and render.active
    render.update(scene, Change.VIEW)
    assert finished(render).samples == 4


def test_edits_of_a_lamp_keep_the_meshes(render, scene):
    render.update(scene, Change.ALL)
    finished(render)
    built = render._renderer
    lamp = dataclasses.replace(scene.lamps[0], shape=Box((0.5, 0.5, 2.0)), density=3.0)
    render.update(dataclasses.replace(scene, lamps=[lamp]), Change.LIGHTS)
    picture = finished(render)
    assert render._renderer is built
    assert picture.pixels[12, 24, 0] == pytest.approx(12.0, rel=0.01)


def test_changes_that_were_not_rendered_add_up(render, scene):
    """A move of the camera right after an edit of a lamp must not forget the edit."""
    render.update(scene, Change.ALL)
    lamp = dataclasses.replace(scene.lamps[0], density=5.0)
    edited = dataclasses.replace(scene, lamps=[lamp])
    render.update(edited, Change.LIGHTS)
    render.update(moved(edited, 0.01), Change.VIEW)
    assert finished(render).pixels[12, 24, 0] == pytest.approx(10.0, rel=0.1)


def test_border_and_size(render, scene):
    render.update(dataclasses.replace(scene, border=(20, 5, 30, 17)), Change.ALL)
    picture = finished(render)
    assert picture.window == (20, 5, 30, 17) and picture.pixels.shape == (12, 10, 4)
    render.update(dataclasses.replace(scene, width=24, height=12), Change.VIEW)
    assert finished(render).pixels.shape == (12, 24, 4)


def test_pause_and_sample_limit(render, scene):
    many = dataclasses.replace(scene, settings=dataclasses.replace(scene.settings, samples=100_000))
    render.update(many, Change.ALL)
    wait(render, lambda: render.picture is not None and render.picture.samples > 0)
    render.paused = True
    wait(render, lambda: render.status == "Paused")
    samples = render.picture.samples
    assert not render.active
    time.sleep(0.1)
    assert render.picture.samples == samples < 100_000
    render.paused = False
    wait(render, lambda: render.picture.samples > samples)
    assert render.active


def test_stops_at_once_and_starts_again(render, scene):
    many = dataclasses.replace(scene, settings=dataclasses.replace(scene.settings, samples=100_000))
    render.update(many, Change.ALL)
    wait(render, lambda: render.picture is not None and render.picture.samples > 0)
    started = time.monotonic()
    render.stop()
    assert time.monotonic() - started < 2.0
    assert not any(thread.name.startswith("SDF Lights") for thread in threading.enumerate())
    render.update(scene, Change.ALL)
    assert finished(render).samples == 4


def test_what_goes_wrong_is_said_and_mended(render, scene):
    lamp = dataclasses.replace(scene.lamps[0], density=-1.0)
    render.update(dataclasses.replace(scene, lamps=[lamp]), Change.ALL)
    wait(render, lambda: render.finished)
    if scene.settings.device is Device.CPU:
        assert any("Ball" in warning for warning in render.warnings)
    broken = dataclasses.replace(scene, lamps=None)
    render.update(broken, Change.ALL)
    deadline = time.monotonic() + PATIENCE
    while not render.error and time.monotonic() < deadline:
        time.sleep(0.01)
    assert "failed" in render.error and render.finished
    render.update(scene, Change.VIEW)
    assert finished(render).samples == 4
