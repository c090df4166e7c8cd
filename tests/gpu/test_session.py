# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who renders: the device that is asked for, and the CPU where the GPU cannot."""

import dataclasses
import time

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.render import session
from sdf_lights.render.film import Film
from sdf_lights.render.gpu import lamp_kernels, packed_scene, renderer
from sdf_lights.render.gpu.device import GROUP, GROUP_OF_NVIDIA, DeviceError
from sdf_lights.render.scene import Lamp, Scene
from sdf_lights.render.settings import Device, LampSampling
from sdf_lights.sdf.expression import Expression
from support import scenes
from support.scenes import camera, settings, translation
from tests.gpu.support import device_or_skip

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def render(device: Device, name="torus_room", cancelled=lambda: False, **settings):
    scene = scenes.SCENES[name](24, 18)
    scene.settings.device = device
    for name, value in {"samples": 4, **settings}.items():
        setattr(scene.settings, name, value)
    return scene, session.render(scene, ("Combined", "Depth"), cancelled)


def test_the_gpu_renders_when_it_is_asked_to():
    found = device_or_skip()
    scene, film = render(Device.GPU)
    assert film.made_by == f"GPU ({found.name})" and not scene.warnings
    assert film.samples == 4 and film.read("Combined")[..., :3].mean() > 0.0


@pytest.mark.parametrize(
    "name, settings, slab",
    [
        ("torus_room", dict(samples=24), None),
        ("torus_room", dict(samples=24), 64 * 3),
        ("torus_room", dict(samples=24, max_bounces=0), 64 * 3),  # has cuts
        ("field_lamps", dict(max_bounces=0), None),
    ],
)
def test_a_graphics_card_gives_the_same_sums(monkeypatch, name, settings, slab):
    """It has its own dispatches, the arrays of a thread are in a buffer, and textures are read in another way."""
    found = device_or_skip()
    films, words = [], []
    reserve = renderer.GpuRenderer._reserve_arrays

    def noted(self, context) -> None:
        reserve(self, context)
        words.append(self._packed.tables.arrays.words)

    monkeypatch.setattr(renderer.GpuRenderer, "_reserve_arrays", noted)
    for software, group in (True, GROUP), (False, GROUP_OF_NVIDIA):
        monkeypatch.setattr(found, "software", software)
        monkeypatch.setattr(found, "group", group)
        films.append(render(Device.GPU, name, **settings)[1])
        if slab:
            monkeypatch.setattr(renderer, "SLAB_OF_CARD", slab)
            monkeypatch.setattr(renderer, "ARRAYS_BYTES", 1)  # one group of threads
    first, second = films
    assert first.made_by == second.made_by == f"GPU ({found.name})"
    assert words[0] == 0 and (words[1] > 0) == (name != "torus_room" or "max_bounces" in settings)
    for name in ("combined", "half", "depth"):
        np.testing.assert_array_equal(first.sums[name], second.sums[name])
    np.testing.assert_array_equal(first.count, second.count)


@pytest.mark.slow
def test_the_gpu_says_that_it_has_no_rolling_shutter():
    """The frame is blurred all the same."""
    device_or_skip()

    def picture(scene) -> tuple[np.ndarray, list[str]]:
        scene.settings.device, scene.settings.samples = Device.GPU, 4
        return session.render(scene, ()).read("Combined"), scene.warnings

    def still(scene) -> Scene:
        scene.shutter = dataclasses.replace(scene.shutter, rolling=None)
        return scene

    blurred, told = picture(scenes.SCENES["rolling"](16, 12))
    as_if, nothing = picture(still(scenes.SCENES["rolling"](16, 12)))
    sharp, _ = picture(scenes.SCENES["torus_room"](16, 12))
    assert len(told) == 1 and "no rolling shutter" in told[0] and nothing == []
    np.testing.assert_array_equal(blurred, as_if)
    assert np.abs(blurred - sharp).max() > 0.05


@pytest.mark.slow
def test_the_cpu_takes_over_where_a_lamp_changes_its_shape():
    scene = scenes.SCENES["changing_lamps"](8, 6)
    scene.settings.device, scene.settings.samples = Device.GPU, 1
    film = session.render(scene, ())
    assert film.made_by == "CPU" and any("“torus”, whose shape changes" in warning for warning in scene.warnings)


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
        "The GPU cannot render this: there is no OpenGL 4.3 here (no driver). The CPU has rendered it."
    ]


def test_the_cpu_takes_over_in_the_middle(monkeypatch):
    device_or_skip()
    whole = renderer.GpuRenderer.sample

    def sample(self, first, count, stop, report):
        if first:
            raise DeviceError("it is gone")
        return whole(self, first, count, stop, report)

    monkeypatch.setattr(renderer.GpuRenderer, "sample", sample)
    scene, film = render(Device.GPU)
    assert film.made_by == "CPU" and film.samples == 4 and film.count.min() >= 2 and len(scene.warnings) == 1


def test_samples_that_a_driver_cuts_short_are_taken_again():
    """A close view of a fractal: llvmpipe ends all loops of a thread after 65535 turns in all. Samples that it ended
    had less light."""
    device_or_skip()
    films = []
    for device in (Device.CPU, Device.GPU):
        scene = Scene(camera((0.0, -7.0, 2.5), (0.0, 0.0, 1.7), 32, 32, half_width=0.2), 32, 32)
        scene.world.strength = 0.0
        scene.lamps = [Lamp("bulb", Expression("mandelbulb()").shape(), translation(0.0, 0.0, 1.7), power=50.0)]
        scene.settings = settings(
            max_bounces=0,
            samples=32,
            guided_samples=False,
            indirect_paths=1,
            device=device,
            lamp_sampling=LampSampling.BSDF,
        )
        films.append(session.render(scene, ()))
    cpu, gpu = films
    assert gpu.made_by != "CPU" and (gpu.count == 32).all()
    means = [film.read("Combined")[..., :3].mean(dtype=float) for film in films]
    assert means[1] == pytest.approx(means[0], rel=1e-3)


def lit_by(expression: str):
    """A room whose lamp has this shape."""
    scene = scenes.SCENES["torus_room"](8, 6)
    scene.settings.device = Device.GPU
    scene.lamps = [dataclasses.replace(scene.lamps[0], shape=Expression(expression).shape())]
    return scene


def balls(count: int) -> str:
    return ", ".join(f"translate(sphere(0.05), {x:.3f}, 0, 0)" for x in np.linspace(-0.5, 0.5, count))


def refusal(scene) -> str:
    """What the GPU says of a scene that it does not render, before anything is compiled."""
    with pytest.raises(DeviceError) as told:
        packed_scene.GpuScene(scene, Film(scene, ())).source()
    return str(told.value)


def test_samplings_that_only_the_cpu_has():
    scene = lit_by("sphere(0.5)")
    scene.settings.lamp_sampling = LampSampling.EXTERNAL
    assert refusal(scene) == "it has no such sampling of lamps"


def test_lamps_of_too_many_parts(monkeypatch):
    monkeypatch.setattr(packed_scene, "MOST_ROWS", 30)
    scene = lit_by(f"union({balls(20)})")
    assert "has too many parts" in refusal(scene) and scene.lamps[0].name in refusal(scene)


def test_formulas_that_are_too_long(monkeypatch):
    monkeypatch.setattr(lamp_kernels, "MOST_NODES", 30)
    assert "the formulas of the scene's lamps have" in refusal(lit_by(f"smooth_union({balls(3)}, 0.05)"))


def test_a_program_that_does_not_compile(monkeypatch):
    device_or_skip()
    monkeypatch.setattr(packed_scene.GpuScene, "source", lambda self: "#version 430 core\nvoid main() { nonsense; }\n")
    scene, film = render(Device.GPU, samples=1)
    assert film.made_by == "CPU" and len(scene.warnings) == 1
    assert "could not compile the scene's program" in scene.warnings[0] and "nonsense" in scene.warnings[0]


@pytest.mark.parametrize("limit", ["largest_buffer", "largest_texture"])
def test_scenes_that_are_too_large(monkeypatch, limit):
    monkeypatch.setattr(device_or_skip(), limit, 1000)
    scene, film = render(Device.GPU, samples=1)
    assert film.made_by == "CPU" and len(scene.warnings) == 1 and " MB in one " in scene.warnings[0]


def test_memory_that_is_not_there():
    device = device_or_skip()
    size = 1 << 50
    with pytest.raises(DeviceError, match="no room for 1073741824 MB more"):
        device.submit(lambda context: device.allocate(context, size, context.buffer, reserve=size)).result()
    # The context goes on working.
    _, film = render(Device.GPU, samples=1)
    assert film.made_by != "CPU"


def test_cancel_stops_within_half_a_second():
    device_or_skip()
    scene = scenes.SCENES["torus_room"](96, 72)
    scene.settings.device, scene.settings.samples, scene.settings.max_bounces = Device.GPU, 4096, 12
    deadline = np.inf

    def on_progress(progress: session.Progress) -> None:
        nonlocal deadline
        if progress.samples and deadline == np.inf:
            deadline = time.perf_counter() + 0.5  # dispatches have found their length by then

    film = session.render(scene, (), lambda: time.perf_counter() > deadline, on_progress)
    assert film.made_by != "CPU" and time.perf_counter() - deadline < 0.5


def test_building_is_told_and_cancel_ends_it():
    """Times are of processors, of which a build uses several."""
    device = device_or_skip()
    rounds = "q = p\nfor i in range({}):\n    q = q + 0.001 * sin(4 * q)\nfield(length(q) - 1.5) & box(2)"
    build_lamp("Small", Expression(rounds.format(3)).shape(), np.eye(4))  # compiles
    scene = lit_by(rounds.format(1000))
    told, asked = [], []

    def cancelled() -> bool:
        if any("Building lamp" in text for text in told):
            asked.append(time.process_time())
        return bool(asked)

    film = session.render(scene, (), cancelled, lambda progress: told.append(progress.text))
    device.submit(lambda context: None).result()  # the build has ended
    assert time.process_time() - asked[0] < 1.0
    assert f"Building lamp “{scene.lamps[0].name}”" in told
    assert film.samples == 0 and not scene.warnings


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


def test_ranges_of_samples_are_one_render():
    device_or_skip()
    whole = render(Device.GPU, samples=16)[1].read("Combined")
    halves = [render(Device.GPU, samples=8, sample_offset=first)[1].read("Combined") for first in (0, 8)]
    assert not np.allclose(*halves)
    np.testing.assert_allclose(np.mean(halves, axis=0), whole, rtol=1e-4, atol=1e-5)
