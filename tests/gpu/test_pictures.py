# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU's pictures against the CPU's, pass by pass.

Both draw the same numbers for the same seed, so most samples are the same but for rounding, and the difference of two
pictures is far less than their noise. With projection sampling of SDF lamps the mean difference of each block of pixels
and of the picture has to be zero within what float32 and the rare sample that takes another way explain, by a t test
over seeds. Cuts have other boxes on the GPU, which has them for direct light alone: there the difference has to be zero
within the noise of both.
"""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from sdf_lights import jit
from sdf_lights.render.film import NO_DEPTH, Film
from sdf_lights.render.material import Node
from sdf_lights.render.scene import Primitive, Scene, World
from sdf_lights.render.settings import LampPaths, LampSampling, Settings
from support import scenes
from support.blocks import means
from support.scenes import media, strands
from tests.gpu.support import device_or_skip
from tests.render.test_agreement import PASSES

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SEEDS, SAMPLES, CONFIDENCE = 6, 8, 0.9999
# Scenes that are not compared with the others: some have tests of their own, some have what the GPU leaves out.
APART = ("torus_room", "subsurface", "fog_lamp", "fur", "moving", "rolling")
SCENES = scenes.SCENES | media.MEDIA_SCENES | strands.STRAND_SCENES


def sample_as_on_the_gpu(settings: Settings) -> None:
    """Without what only the CPU does: then both use the same random numbers."""
    settings.indirect_paths, settings.guided_samples, settings.lamp_paths = 1, False, LampPaths.NEVER


def pictures(renderer, name: str, sampling: LampSampling, bounces: int | None = None) -> dict[str, np.ndarray]:
    """Every pass: (seeds, height, width, channels)."""
    found = {item: [] for item in PASSES}
    for seed in range(SEEDS):
        scene = SCENES[name](32, 24)
        scene.settings.seed, scene.settings.lamp_sampling = 100 + seed, sampling
        sample_as_on_the_gpu(scene.settings)
        if bounces is not None:
            scene.settings.max_bounces = bounces
        film = Film(scene, PASSES)
        back_end = renderer(scene, film, lambda: False, lambda text: None)
        assert back_end.sample(0, SAMPLES, lambda: False, lambda part: None)
        back_end.finish()
        # Fields with one bound for all their slopes leave more unresolved than the CPU's trees do, and say so.
        told = [warning for warning in scene.warnings if "could not be resolved" not in warning]
        assert not film.discarded.any() and not told, told
        for item in PASSES:
            value = film.read(item).astype(float)
            found[item].append(np.where(value == NO_DEPTH, 0.0, value))
    return {item: np.array(values) for item, values in found.items()}


def several(name: str) -> bool:
    """Whether more than one emitter, besides the world, may light the scene."""
    scene = SCENES[name](8, 6)
    glows = any(_glows(material.surface) for material in scene.materials)
    return len(scene.lamps) + len(scene.lights) + 2 * glows > 1  # every triangle is one


def _glows(surface) -> bool:
    return isinstance(surface, Node) and (
        surface.kind == "emission" or any(_glows(surface[part]) for part in ("a", "b") if part in surface.inputs)
    )


def compare(name: str) -> None:
    from sdf_lights.render.cpu.renderer import CpuRenderer
    from sdf_lights.render.gpu.renderer import GpuRenderer

    device_or_skip()
    cpu, gpu = (pictures(renderer, name, LampSampling.MIS) for renderer in (CpuRenderer, GpuRenderer))
    failures = []
    for item in PASSES:
        rounding = 2e-5 * max(np.abs(cpu[item]).max(), 1e-3)
        for a, b in zip(means(cpu[item]), means(gpu[item])):
            difference = b - a
            error = np.sqrt(difference.var(0, ddof=1) / SEEDS + rounding**2)
            t = difference.mean(0) / error
            p = 2.0 * stats.t.sf(np.abs(t), SEEDS - 1)
            if p.min() < (1.0 - CONFIDENCE) / (2 * len(PASSES) * t.size):
                worst = int(p.argmin())
                failures.append(f"{item}: {b.mean(0)[worst]:.6g} against {a.mean(0)[worst]:.6g} (t = {t[worst]:.1f})")
        # Emitters are chosen in another way. Where there is one alone, a sample in a hundred may differ, not more.
        if several(name):
            continue
        far = np.abs(gpu[item] - cpu[item]).max(-1) > 1e-3 * np.abs(cpu[item]).max()
        if far.mean() > 0.01 * SAMPLES:
            failures.append(f"{item}: {100.0 * far.mean():.1f} % of the pixels differ")
    assert not failures, "; ".join(failures)


def compare_cuts(name: str, bounces: int | None = 0) -> None:
    from sdf_lights.render.cpu.renderer import CpuRenderer
    from sdf_lights.render.gpu.renderer import GpuRenderer

    device_or_skip()
    cpu, gpu = (pictures(renderer, name, LampSampling.CUT, bounces) for renderer in (CpuRenderer, GpuRenderer))
    failures = []
    for item in PASSES:
        rounding = 2e-5 * max(np.abs(cpu[item]).max(), 1e-3)
        for a, b in zip(means(cpu[item]), means(gpu[item])):
            error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / SEEDS + rounding**2)
            t = (b.mean(0) - a.mean(0)) / error
            p = 2.0 * stats.t.sf(np.abs(t), SEEDS - 1)
            if p.min() < (1.0 - CONFIDENCE) / (2 * len(PASSES) * t.size):
                worst = int(p.argmin())
                failures.append(f"{item}: {b.mean(0)[worst]:.6g} against {a.mean(0)[worst]:.6g} (t = {t[worst]:.1f})")
    assert not failures, "; ".join(failures)


def test_lamp_in_a_room():
    compare("torus_room")


def test_lamp_in_a_room_by_cuts():
    compare_cuts("torus_room")


def test_light_below_surfaces():
    compare("subsurface")


def test_shadow_catchers():
    """Under a lamp and a sky, sample by sample."""

    def make() -> Scene:
        scene = scenes.torus_room(16, 16)
        scene.instances[0].catcher = True
        scene.world = World((0.3, 0.4, 0.6), 0.4)
        return scene

    _, film = compare_samples(make, ("Combined", "Shadow Catcher", "Environment"))
    assert film.read("Shadow Catcher").min() < 0.9


def compare_samples(make, passes: tuple[str, ...] = ("Combined",), most: float = 0.01) -> tuple[Film, Film]:
    """The films of both, whose pixels agree but for this part of the samples. ``make`` makes the scene."""
    from sdf_lights.render.cpu.renderer import CpuRenderer
    from sdf_lights.render.gpu.renderer import GpuRenderer

    device_or_skip()
    found = []
    for renderer in (CpuRenderer, GpuRenderer):
        scene = make()
        scene.settings.lamp_sampling = LampSampling.MIS
        sample_as_on_the_gpu(scene.settings)
        film = Film(scene, passes)
        back_end = renderer(scene, film, lambda: False, lambda text: None)
        assert back_end.sample(0, SAMPLES, lambda: False, lambda part: None)
        back_end.finish()
        assert scene.warnings == []
        found.append(film)
    for item in passes:
        cpu, gpu = (film.read(item).astype(float) for film in found)
        far = np.abs(gpu - cpu).max(-1) > 1e-3 * np.abs(cpu).max()
        assert far.mean() <= most * SAMPLES
    return tuple(found)


def test_faces_in_the_same_place():
    """Three instances of one wall: they hide light from each other, as on the CPU."""

    def make() -> Scene:
        scene = scenes.torus_room(16, 16)
        scene.instances += [dataclasses.replace(scene.instances[0], name=f"again {index}") for index in range(2)]
        return scene

    cpu, _ = compare_samples(make)
    alone, _ = compare_samples(lambda: scenes.torus_room(16, 16))
    assert cpu.read("Combined")[..., :3].mean() < 0.9 * alone.read("Combined")[..., :3].mean()


def test_hair_and_points():
    compare("fur")


@pytest.mark.parametrize("kind", tuple(Primitive)[1:], ids=lambda kind: kind.name.lower())
def test_rays_meet_each_kind_of_hair_where_embree_does(kind):
    compare_samples(lambda: strands.fur(24, 18, (kind,)), ("Position",), 0.001)


def test_lamp_in_fog():
    compare("fog_lamp")


def test_lamp_in_fog_by_cuts():
    compare_cuts("fog_lamp")


def test_lamp_in_a_room_where_cuts_do_not_pay():
    compare_cuts("torus_room", None)


@pytest.mark.slow
def test_light_through_a_veil_where_cuts_do_not_pay():
    compare_cuts("veiled", None)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SCENES if name not in APART and SCENES[name](8, 6).lamps])
def test_scene_by_cuts(name):
    compare_cuts(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SCENES if name not in APART])
def test_scene(name):
    compare(name)
