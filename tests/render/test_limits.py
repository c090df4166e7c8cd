# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does not fit into memory is said before it is begun."""

import time

import numpy as np
import pytest

from sdf_lights.render import memory, session
from sdf_lights.render.errors import RenderError
from sdf_lights.render.film import Film, bytes_of_a_pixel
from sdf_lights.render.interactive import Change, InteractiveRender
from sdf_lights.render.passes import PASSES
from sdf_lights.render.settings import Device
from support import scenes


def test_memory_is_known_and_in_words():
    free = memory.available()
    assert free is None or 1 << 20 < free < 1 << 50
    assert memory.in_words(3.25 * (1 << 30)) == "3.2 GB" and memory.in_words(5 << 20) == "5 MB"


@pytest.mark.parametrize("passes", [(), ("Depth", "Normal"), tuple(item.name for item in PASSES)])
def test_bytes_of_a_pixel_are_those_of_a_film(passes):
    """No less than its arrays, and no more than half as much again, for what comes while it is sampled."""
    scene = scenes.SCENES["torus_room"](64, 32)
    scene.settings.denoise = False
    film = Film(scene, passes)
    arrays = [*vars(film).values(), *film.sums.values()]
    held = sum(array.nbytes for array in arrays if isinstance(array, np.ndarray)) / (64 * 32)
    channels = sum(len(film._table[name].channels) for name in film.passes)
    assert held + 4 * channels <= bytes_of_a_pixel(scene, passes) <= 1.5 * (held + 4 * channels)
    scene.settings.denoise = True
    assert bytes_of_a_pixel(scene, passes) > held


@pytest.mark.parametrize("border", [None, (0, 0, 500_000, 300_000)])
def test_a_picture_without_room_is_refused_before_it_begins(border):
    scene = scenes.SCENES["torus_room"](1_000_000, 1_000_000)
    scene.border, scene.settings.device = border, Device.REFERENCE
    told = []
    with pytest.raises(RenderError) as caught:
        session.render(scene, ("Depth",), on_progress=told.append)
    width, height = ("500,000", "300,000") if border else ("1,000,000", "1,000,000")
    assert f"{width} × {height} pixels with 1 passes takes" in str(caught.value)
    assert "GB of memory are free: choose a lower resolution, a render region, or fewer passes." in str(caught.value)
    assert [progress.text for progress in told] == ["Preparing"]


@pytest.mark.parametrize("kind", ["triangles", "instances"])
def test_a_scene_without_room_is_refused_before_it_begins(monkeypatch, kind):
    scene = scenes.SCENES["torus_room"](8, 8)
    scene.settings.device, scene.settings.denoise = Device.REFERENCE, False
    if kind == "triangles":
        scene.meshes[0].triangles = np.broadcast_to(np.zeros(3, np.int32), (10_000_000, 3))
    else:
        scene.instances *= 1_000_000
    monkeypatch.setattr(memory, "available", lambda: 100 << 20)
    told = []
    with pytest.raises(RenderError) as caught:
        session.render(scene, (), on_progress=told.append)
    triangles = sum(len(mesh.triangles) for mesh in scene.meshes)
    assert f"The scene's {triangles:,} triangles and {len(scene.instances):,} instances take" in str(caught.value)
    assert "100 MB of memory are free: subdivide less, hide objects, or make copies instances" in str(caught.value)
    assert [progress.text for progress in told] == ["Preparing"]


def test_a_scene_without_room_is_refused_by_a_viewport(monkeypatch):
    scene = scenes.SCENES["torus_room"](8, 8)
    scene.settings.device = Device.REFERENCE
    scene.instances *= 1_000_000
    monkeypatch.setattr(memory, "available", lambda: 100 << 20)
    view = InteractiveRender()
    view.update(scene, Change.ALL)
    deadline = time.monotonic() + 20.0
    while not view.finished and time.monotonic() < deadline:
        time.sleep(0.01)
    view.stop()
    assert "100 MB of memory are free: subdivide less" in view.error


def test_where_memory_is_not_known_nothing_is_refused(monkeypatch):
    monkeypatch.setattr(memory, "available", lambda: None)
    scene = scenes.SCENES["torus_room"](8, 8)
    scene.settings.device, scene.settings.samples = Device.REFERENCE, 1
    assert session.render(scene, ()).samples == 1


@pytest.mark.slow
def test_a_region_of_16k_is_that_of_a_small_picture():
    """A still of 16,384 × 16,384 pixels is rendered in parts: the strip of each is the strip of the small picture, but
    for noise."""
    means = []
    for size, samples in ((512, 128), (16_384, 1)):
        scene = scenes.SCENES["torus_room"](size, size)
        scene.border = 0, size // 2, size, size // 2 + size // 512
        scene.settings.samples, scene.settings.denoise, scene.settings.noise_threshold = samples, False, 0.0
        means.append(session.render(scene, ()).read("Combined")[..., :3].mean(axis=(0, 1)))
    np.testing.assert_allclose(means[1], means[0], rtol=0.01)
