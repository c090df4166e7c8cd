# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who renders: the device that is asked for, and the CPU where the GPU cannot."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render import session
from sdf_lights.render.gpu import renderer
from sdf_lights.render.gpu.device import DeviceError
from sdf_lights.render.settings import Device
from tests import scenes
from tests.gpu.support import device_or_skip

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def render(device: Device, cancelled=lambda: False, **settings):
    scene = scenes.SCENES["torus_room"](24, 18)
    scene.settings.device = device
    for name, value in {"samples": 4, **settings}.items():
        setattr(scene.settings, name, value)
    return scene, session.render(scene, ("Combined", "Depth"), cancelled)


def test_the_gpu_renders_when_it_is_asked_to():
    found = device_or_skip()
    scene, film = render(Device.GPU)
    assert film.made_by == f"GPU ({found.name})" and not scene.warnings
    assert film.samples == 4 and film.read("Combined")[..., :3].mean() > 0.0


def test_automatic_is_the_cpu():
    _, film = render(Device.AUTOMATIC, samples=1)
    assert film.made_by == "CPU"


def test_the_cpu_takes_over_with_a_sentence(monkeypatch):
    def fails():
        raise DeviceError("there is no OpenGL 4.3 here (no driver)")

    monkeypatch.setattr(renderer, "device", fails)
    scene, film = render(Device.GPU, samples=1)
    assert film.made_by == "CPU" and film.samples == 1
    assert scene.warnings == [
        "The GPU cannot render this: there is no OpenGL 4.3 here (no driver). The CPU has rendered it."]


def test_the_cpu_takes_over_in_the_middle(monkeypatch):
    device_or_skip()
    whole = renderer.GpuRenderer.sample

    def sample(self, first, count, stop, report):
        if first:
            raise DeviceError("it is gone")
        return whole(self, first, count, stop, report)

    monkeypatch.setattr(renderer.GpuRenderer, "sample", sample)
    scene, film = render(Device.GPU)
    assert film.made_by == "CPU" and (film.count == 4).all() and len(scene.warnings) == 1


def test_a_cancelled_render_keeps_what_it_has():
    device_or_skip()
    _, film = render(Device.GPU, cancelled=lambda: True, samples=64)
    assert film.samples < 64


def test_adaptive_sampling_and_borders():
    device_or_skip()
    scene = scenes.SCENES["torus_room"](24, 18)
    scene.settings.device, scene.settings.samples, scene.border = Device.GPU, 64, (3, 2, 20, 15)
    scene.settings.noise_threshold, scene.settings.min_samples = 0.2, 16
    film = session.render(scene, ("Combined", "Sample Count"))
    count = film.read("Sample Count")
    assert count.shape == (13, 17, 1) and count.min() >= 16 and count.min() < count.max()
    whole, _ = scenes.SCENES["torus_room"](24, 18), None
    whole.settings.device, whole.settings.samples = Device.GPU, 16
    cropped = session.render(whole, ("Combined",)).read("Combined")[2:15, 3:20]
    few = count[..., 0] == 16
    assert few.any()
    np.testing.assert_allclose(film.read("Combined")[few], cropped[few], rtol=1e-5, atol=1e-6)
