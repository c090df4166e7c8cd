# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections to light paths on the GPU: the mean of a picture is that of the CPU without them, and the noise is less.

The pictures of different seeds are independent. Student's t compares the means of the picture, and of blocks of 4 × 4
pixels, over ``SEEDS`` renders of each kind. Two right renderers exceed ``FURTHEST`` anywhere with a chance of one in a
thousand.
"""

import dataclasses

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render import light_paths, session
from sdf_lights.render.errors import RenderError
from sdf_lights.render.film import Film
from sdf_lights.render.gpu import renderer
from sdf_lights.render.gpu.packed_scene import GpuScene
from sdf_lights.render.lights.point import PointLight
from sdf_lights.render.scene import Ray
from sdf_lights.render.settings import CausticPaths, Device, LampPaths, PathReuse
from support.blocks import means
from support.scenes import add, cove, diffuse, material, moving, room, scaling, torus_lamp, translation
from tests.gpu.support import device_or_skip, with_light_paths

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SIZE, SEEDS, FURTHEST = (16, 12), 12, 6.0
NEVER, AUTOMATIC, ALWAYS = LampPaths.NEVER, LampPaths.AUTOMATIC, LampPaths.ALWAYS


def hidden_point_light(width: int, height: int):
    """A point light above a shelf, in a room with a brushed ball, whose scattering light paths do not follow."""
    scene = room(width, height)
    add(scene, 1, translation(0.0, 1.2, 2.3) @ scaling(1.6, 0.75, 0.03), diffuse((0.6, 0.6, 0.6)))
    brushed = material("glossy", "brushed", color=(0.9, 0.9, 0.9), roughness=0.3, anisotropy=0.7)
    add(scene, 2, translation(-0.7, 0.2, 0.6) @ scaling(0.6, 0.6, 0.6), brushed)
    scene.lights.append(PointLight("point", translation(0.0, 1.3, 2.6), 60.0, radius=0.1))
    return scene


def sunk_lamp(width: int, height: int):
    """A lamp in a box without a lid, which stands on the floor: light comes by way of the ceiling."""
    scene = room(width, height)
    for x, y in ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)):
        sides = scaling(0.02 if x else 0.5, 0.02 if y else 0.5, 0.3)
        add(scene, 1, translation(0.5 * x, 0.5 * y, 0.3) @ sides, diffuse((0.7, 0.7, 0.7)))
    scene.lamps.append(torus_lamp(0.0, 0.0, 0.2, 60.0, 0.3))
    return scene


def rendered(build, lamp_paths: LampPaths, device: Device, seed: int = 0, samples: int = 32, size=SIZE) -> Film:
    scene = build(*size)
    scene.settings = dataclasses.replace(
        scene.settings,
        **dict(lamp_paths=lamp_paths, device=device, seed=seed, samples=samples, threads=2),
        # What the GPU has not. It has pilots on the CPU, whose paths split.
        **dict(guided_samples=False, path_reuse=PathReuse.NEVER, caustic_paths=CausticPaths.NEVER),
        indirect_paths=int(device is Device.CPU),
    )
    film = session.render(scene, ())
    assert not scene.warnings
    return film


def pictures(build, lamp_paths: LampPaths, device: Device) -> np.ndarray:
    """(seeds, height, width, RGB)."""
    films = [rendered(build, lamp_paths, device, 100 + seed) for seed in range(SEEDS)]
    assert all(film.made_by.startswith(device.value) for film in films)
    return np.array([film.read("Combined")[..., :3] for film in films], float)


@pytest.mark.slow
@pytest.mark.parametrize("build", [sunk_lamp, hidden_point_light])
def test_they_change_the_noise_alone(build):
    """Means are compared with those of the CPU, the noise with that of the GPU, both without light paths."""
    device_or_skip()
    expected, found = pictures(build, NEVER, Device.CPU), pictures(build, ALWAYS, Device.GPU)
    for one, other in zip(means(expected), means(found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / SEEDS)
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < FURTHEST * error + 1e-9)
    noise = [np.median(each.var(axis=0, ddof=1)) for each in (pictures(build, NEVER, Device.GPU), found)]
    assert noise[1] < 0.4 * noise[0]


def test_automatic_uses_them_where_they_pay():
    """The picture is that of the setting that is always on."""
    device_or_skip()
    found = [rendered(sunk_lamp, each, Device.GPU, size=(32, 24)) for each in (NEVER, AUTOMATIC, ALWAYS)]
    without, automatic, always = (film.read("Combined") for film in found)
    assert np.array_equal(automatic, always) and not np.array_equal(automatic, without)


@pytest.mark.slow
def test_a_graphics_card_gives_the_same_sums(monkeypatch):
    """It has some of the pixels at a time, and each of these parts has all sets of light paths. The arrays of a thread
    are in a buffer."""
    found = device_or_skip()
    first = rendered(cove, ALWAYS, Device.GPU)
    monkeypatch.setattr(renderer, "FIRST_WORK", 1)  # dispatches of one sample
    monkeypatch.setattr(found, "software", False)
    monkeypatch.setattr(renderer, "SLAB_OF_CARD", 64)
    second = rendered(cove, ALWAYS, Device.GPU)
    for name in ("combined", "half"):
        np.testing.assert_array_equal(first.sums[name], second.sums[name])


def test_where_they_cannot_be_used_no_bit_changes():
    """An object that only some rays see, and a sample that nothing measures."""
    device_or_skip()

    def partly_seen(width: int, height: int):
        scene = sunk_lamp(width, height)
        scene.instances[5] = dataclasses.replace(scene.instances[5], visibility=Ray.ALL & ~Ray.GLOSSY)
        return scene

    for build, lamp_paths, samples in ((partly_seen, ALWAYS, 8), (sunk_lamp, AUTOMATIC, 1)):
        found = [rendered(build, each, Device.GPU, samples=samples) for each in (NEVER, lamp_paths)]
        assert np.array_equal(*(film.read("Combined") for film in found))


def test_a_program_has_code_for_them_only_where_they_are_used():
    names = {f" {name}(" for name in ("connections_connect", "tree_density", "streamed_int_at", "tree_choose")}
    scene, film, tracer = with_light_paths(cove(8, 6))
    source, plain = (GpuScene(scene, film, tracer=each).source() for each in (tracer, None))
    assert {name for name in names if name in source} == names
    assert not [name for name in names if name in plain]
    scene.settings.lamp_paths = NEVER
    assert with_light_paths(scene)[2] is None
    scene = moving(8, 6)
    scene.settings.lamp_paths = ALWAYS
    assert with_light_paths(scene)[2] is None


def test_one_program_for_all_light_paths():
    """Sets have other numbers of vertices, at the same places."""
    scene, film, tracer = with_light_paths(cove(8, 6))
    packed = GpuScene(scene, film, tracer=tracer)
    source = packed.source()
    words = [packed.tables.streamed.words(tracer.use(sample)[1]) for sample in (0, 1)]
    assert len({len(each) for each in words}) == 2
    assert np.array_equal(words[0][:2], words[1][:2])  # the tree stays
    assert GpuScene(scene, film, tracer=tracer).source() == source


def test_sets_are_those_of_the_cpu():
    """Each as large as its samples are worth, and drawn anew."""
    _, _, tracer = with_light_paths(cove(8, 6))
    ends, at, seen = [], 0, []
    while at < 32:
        at, tables = tracer.use(at)
        ends.append(at)
        seen.append(tables["light_path_vertices"]["position"][0].tolist())
    assert ends == [1, 2, 4, 8, 16, 32]
    assert len({tuple(each) for each in seen}) == len(seen)


def test_the_cpu_may_be_missing(monkeypatch):
    """Then the GPU renders without them, and says why."""
    device_or_skip()

    def fails(*arguments):
        raise RenderError("Blender's Embree was not found.")

    monkeypatch.setattr(light_paths, "CpuRenderer", fails)
    scene = sunk_lamp(*SIZE)
    scene.settings = dataclasses.replace(scene.settings, lamp_paths=ALWAYS, device=Device.GPU, samples=1)
    film = session.render(scene, ())
    assert film.made_by != "CPU"
    assert scene.warnings == ["The GPU renders without paths from lamps: Blender's Embree was not found."]
