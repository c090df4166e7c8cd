# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU's pictures against the CPU's, pass by pass.

Both draw the same numbers for the same seed, so most samples are the same but for rounding, and the difference of two
pictures is far less than their noise. With projection sampling of SDF lamps the mean difference of each block of pixels
and of the picture has to be zero within what float32 and the rare sample that takes another way explain. Cuts have
other boxes on the GPU, which has them for direct light alone: there the difference has to be zero within the noise of
both.

Pixels draw their numbers independently. So the differences of pixels are tested, by Student's t over the pixels of all
seeds: a block has ``SEEDS`` · 16 of them, the picture ``SEEDS`` · 768. Two right renderers fail in a scene with
probability 1 − ``CONFIDENCE``, over all passes, channels and blocks together. For that, t may be 6 in a block. A
difference is found with probability 95 % from 8 standard errors on. ``test_a_small_difference_is_found`` has an
example: ``FOUND`` of the light in the picture, or of that in one block.
"""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from sdf_lights import jit
from sdf_lights.graph.formula import Vector, constant, variable
from sdf_lights.render.film import NO_DEPTH, Film
from sdf_lights.render.material import Material, Node
from sdf_lights.render.passes import LIGHT_SUMS, aov_pass, light_group_pass, matte_passes, own_pass
from sdf_lights.render.passes import PASSES as PASSES_OF_ALL
from sdf_lights.render.scene import Instance, Primitive, Scene, World
from sdf_lights.render.settings import LampPaths, LampSampling, Settings
from support import scenes
from support.blocks import BLOCK, means
from support.graphs import Graph
from support.scenes import media, strands
from tests.gpu.support import device_or_skip
from tests.render.test_agreement import PASSES

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SEEDS, SAMPLES, CONFIDENCE = 6, 8, 0.9999
FOUND = 2e-3, 2e-2
# Lamps that differ in how cuts sample them.
BY_CUTS = ("varying_lamps", "frame_lamp")
# Scenes that are not compared with the others: some have tests of their own, a rolling shutter and lamps that
# change are not on the GPU, and software OpenGL ends the long loops of a network. To compile a program takes long, so
# scenes all of whose parts others have are left out, too.
APART = (
    *("network_lamp", "torus_room", "subsurface", "fog_lamp", "fur", "rolling", "changing_lamps", "moving"),
    *(
        "colored_lamps",
        "moving_strands",
        "only_reflective_caustics",
        "only_refractive_caustics",
        "haze",
        "linked_media",
    ),
)
SCENES = scenes.SCENES | media.MEDIA_SCENES | strands.STRAND_SCENES


def sample_as_on_the_gpu(settings: Settings) -> None:
    """Without what only the CPU does: then both use the same random numbers."""
    settings.indirect_paths, settings.guided_samples, settings.lamp_paths = 1, False, LampPaths.NEVER


def pictures(
    renderer,
    name: str,
    sampling: LampSampling,
    bounces: int | None = None,
    passes: tuple[str, ...] = PASSES,
    seeds: int = SEEDS,
) -> dict[str, np.ndarray]:
    """Every pass: (seeds, height, width, channels)."""
    found = {item: [] for item in passes}
    for seed in range(seeds):
        scene = (SCENES | media.VARYING_SCENES)[name](32, 24)
        scene.settings.seed, scene.settings.lamp_sampling = 100 + seed, sampling
        sample_as_on_the_gpu(scene.settings)
        if bounces is not None:
            scene.settings.max_bounces = bounces
        film = Film(scene, passes)
        back_end = renderer(scene, film, lambda: False, lambda text: None)
        assert back_end.sample(0, SAMPLES, lambda: False, lambda part: None)
        back_end.finish()
        # Fields with one bound for all their slopes leave more unresolved than the CPU's trees do, and say so.
        told = [warning for warning in scene.warnings if "could not be resolved" not in warning]
        assert not film.discarded.any() and not told, told
        for item in passes:
            value = film.read(item).astype(float)
            found[item].append(np.where(value == NO_DEPTH, 0.0, value))
    return {item: np.array(values) for item, values in found.items()}


def both(name: str, *arguments, **options) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """``pictures`` by the CPU and by the GPU."""
    from sdf_lights.render.cpu.renderer import CpuRenderer
    from sdf_lights.render.gpu.renderer import GpuRenderer

    device_or_skip()
    return tuple(pictures(renderer, name, *arguments, **options) for renderer in (CpuRenderer, GpuRenderer))


def by_block(values: np.ndarray) -> list[np.ndarray]:
    """(pixels, blocks or 1, channels) of ``values`` (seeds, height, width, channels), for blocks and for the
    picture."""
    seeds, height, width, channels = values.shape
    blocks = values.reshape(seeds, height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels)
    blocks = blocks.transpose(0, 2, 4, 1, 3, 5).reshape(seeds * BLOCK**2, -1, channels)
    return [blocks, values.reshape(-1, 1, channels)]


def by_seed(values: np.ndarray) -> list[np.ndarray]:
    """The same with one value of each seed, for pixels that are not independent."""
    return [part.reshape(len(part), -1, values.shape[-1]) for part in means(values)]


def differences(cpu: dict[str, np.ndarray], gpu: dict[str, np.ndarray], parts=by_block) -> list[str]:
    """A sentence for each pass whose means differ."""
    failures = []
    for item in cpu:
        rounding = 2e-5 * max(np.abs(cpu[item]).max(), 1e-3)
        for a, b in zip(parts(cpu[item]), parts(gpu[item])):
            difference, count = b - a, len(a)
            t = difference.mean(0) / np.sqrt(difference.var(0, ddof=1) / count + rounding**2)
            p = 2.0 * stats.t.sf(np.abs(t), count - 1)
            if p.min() < (1.0 - CONFIDENCE) / (2 * len(cpu) * t.size):
                place = np.unravel_index(p.argmin(), p.shape)
                failures.append(f"{item}: {b.mean(0)[place]:.6g} against {a.mean(0)[place]:.6g} (t = {t[place]:.1f})")
    return failures


def several(name: str) -> bool:
    """Whether more than one emitter, besides the world, may light the scene."""
    scene = SCENES[name](8, 6)
    glows = any(_glows(material.surface) for material in scene.materials)
    return len(scene.lamps) + len(scene.lights) + 2 * glows > 1  # every triangle is one


def _glows(surface) -> bool:
    return isinstance(surface, Node) and (
        surface.kind == "emission" or any(_glows(surface[part]) for part in ("a", "b") if part in surface.inputs)
    )


def compared_passes(name: str) -> tuple[str, ...]:
    """Where along a curve a ray meets it, Embree and the GPU know to 0.001: see the test of each kind of hair."""
    return tuple(item for item in PASSES if item != "Position" or name not in strands.STRAND_SCENES)


def compare(name: str) -> None:
    cpu, gpu = both(name, LampSampling.MIS, passes=compared_passes(name))
    failures = differences(cpu, gpu)
    for item in cpu:
        # Emitters are chosen in another way. Where there is one alone, a sample in a hundred may differ, not more.
        if several(name):
            continue
        far = np.abs(gpu[item] - cpu[item]).max(-1) > 1e-3 * np.abs(cpu[item]).max()
        if far.mean() > 0.01 * SAMPLES:
            failures.append(f"{item}: {100.0 * far.mean():.1f} % of the pixels differ")
    assert not failures, "; ".join(failures)


def compare_cuts(name: str, bounces: int | None = 0) -> None:
    failures = differences(*both(name, LampSampling.CUT, bounces, compared_passes(name)))
    assert not failures, "; ".join(failures)


def test_lamp_in_a_room():
    compare("torus_room")


@pytest.mark.parametrize("sampling", [pytest.param(LampSampling.MIS, marks=pytest.mark.slow), LampSampling.CUT])
def test_a_small_difference_is_found(sampling):
    """With the noise that pictures have."""
    cpu, gpu = both("torus_room", sampling, 0, passes=("Combined",))
    assert not differences(cpu, gpu)
    assert differences(cpu, {"Combined": (1.0 + FOUND[0]) * gpu["Combined"]})
    gpu["Combined"][:, 8:12, 12:16] *= 1.0 + FOUND[1]
    assert differences(cpu, gpu)


@pytest.mark.slow
def test_lamp_in_a_room_by_cuts():
    compare_cuts("torus_room")


@pytest.mark.slow
def test_light_below_surfaces():
    compare("subsurface")


@pytest.mark.slow
def test_light_that_transparent_surfaces_stop():
    compare("stopped_light")


def test_shadow_catchers():
    """Under a lamp and a sky, sample by sample."""

    def make() -> Scene:
        scene = scenes.torus_room(16, 16)
        scene.instances[0].catcher = True
        scene.world = World((0.3, 0.4, 0.6), 0.4)
        return scene

    _, film = compare_samples(make, ("Combined", "Shadow Catcher", "Environment"))
    assert film.read("Shadow Catcher").min() < 0.9


@pytest.mark.slow
def test_lights_that_do_not_count_for_shadow_catchers():
    cpu, gpu = both("shadow_catcher", LampSampling.MIS, passes=("Combined", "Shadow Catcher"))
    failures = differences(cpu, gpu)
    assert not failures, "; ".join(failures)


LOBES = tuple(
    item.name for item in PASSES_OF_ALL if item.source in (*LIGHT_SUMS, "glossy_albedo", "transmission_albedo")
)
DATA = "Mist", "UV", "Object Index", "Material Index", "Vector"


@pytest.mark.slow
def test_parts_of_the_light_and_properties_of_surfaces():
    """Lobes, light groups, passes of lights, Cryptomatte, AOVs and numbers of objects, sample by sample."""

    def make() -> Scene:
        scene = scenes.torus_room(16, 16)
        scene.lamps[0].light_group, scene.lamps[0].own_pass = "lamps", "Ring"
        glass = Node("glass", {"color": (0.9, 0.95, 1.0), "roughness": 0.3})
        glossy = Node("glossy", {"color": (0.8, 0.5, 0.3), "roughness": 0.4})
        color = Vector(variable("position"), variable("position", 1), variable("position", 2))
        for index, surface in enumerate(
            (glass, Node("mix_closure", {"factor": 0.5, "a": glossy, "b": Node("diffuse")}))
        ):
            scene.materials.append(
                Material(f"new {index}", surface, index=index + 3, aovs={"Place": color, "One": constant(1.0)})
            )
            scene.instances[index].materials = (len(scene.materials) - 1,)
        # A rough pane before the lamp, with light on both sides.
        before = scenes.translation(0.2, -1.5, 1.4) @ scenes.rotation("x", 90.0) @ scenes.scaling(0.6, 0.6, 1.0)
        scene.instances.append(Instance(0, before, scene.instances[0].materials, "pane"))
        for index, instance in enumerate(scene.instances):
            instance.index = index + 1
        nearer, farther = (scenes.translation(0.0, y, 0.1) @ scene.camera.matrix for y in (0.3, -0.3))
        around = tuple(dataclasses.replace(scene.camera, matrix=matrix) for matrix in (nearer, farther))
        scene.camera = dataclasses.replace(scene.camera, around=around)
        scene.world.aovs = Material("sky", aovs={"Place": color, "One": constant(0.5)})
        groups = [light_group_pass("lamps"), own_pass("Ring"), aov_pass("Place", False), aov_pass("One", True)]
        scene.passes = [*groups, *matte_passes("object", 4), *matte_passes("material", 2)]
        return scene

    more = tuple(item.name for item in make().passes)
    cpu, _ = compare_samples(make, ("Combined", *LOBES, *DATA, *more), batches=(1, SAMPLES - 1))
    for name in (*more, "Diffuse Indirect", "Glossy Direct", "Transmission Direct", "Object Index", "Mist", "Vector"):
        assert np.abs(cpu.read(name)).max() > 1e-3, name


def test_visible_sky():
    """Its directions are drawn by other numbers on the GPU."""
    failures = differences(*both("torus_room", LampSampling.MIS, 0, passes=("Ambient Occlusion",)))
    assert not failures, "; ".join(failures)


@pytest.mark.slow
def test_lobes_in_fog():
    cpu, _ = compare_samples(lambda: SCENES["fog_lamp"](16, 12), ("Combined", *LOBES))
    assert cpu.read("Volume Direct").mean() > 0.0


@pytest.mark.slow
def test_motion_blur():
    """On the GPU, all pixels of a sample have the same time, so seeds are compared, not pixels."""
    passes = ("Combined", "Normal", "Emission")
    cpu, gpu = both("moving", LampSampling.MIS, passes=passes, seeds=8)
    failures = differences(cpu, gpu, by_seed)
    assert not failures, "; ".join(failures)


def compare_samples(
    make, passes: tuple[str, ...] = ("Combined",), most: float = 0.01, batches=(SAMPLES,)
) -> tuple[Film, Film]:
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
        for count in batches:
            assert back_end.sample(film.samples, count, lambda: False, lambda part: None)
        back_end.finish()
        assert scene.warnings == []
        found.append(film)
    shares = {}
    for item in passes:
        cpu, gpu = (film.read(item).astype(float) for film in found)
        shares[item] = float((np.abs(gpu - cpu).max(-1) > 1e-3 * max(np.abs(cpu).max(), 1e-4)).mean())
    assert not {item: share for item, share in shares.items() if share > most * SAMPLES}
    return tuple(found)


@pytest.mark.slow
def test_emission_that_traces_rays():
    """The floor glows where nothing is near it. Only scattered rays find its light, so one emitter is sampled."""

    def make() -> Scene:
        scene, graph = scenes.torus_room(16, 16), Graph()
        glow = graph.material("open", Node("emission", {"color": graph.occlusion(scenes.WHITE, 1.5), "strength": 0.5}))
        scene.materials.append(dataclasses.replace(glow, sample_emission=False))
        scene.instances[0].materials = (len(scene.materials) - 1,)
        return scene

    cpu, _ = compare_samples(make, ("Combined", "Emission"))
    glow = cpu.read("Emission")[..., 1]
    assert len(np.unique(glow.round(3))) > 10


def test_faces_in_the_same_place():
    """Three instances of one wall: they hide light from each other, as on the CPU."""

    def make() -> Scene:
        scene = scenes.torus_room(16, 16)
        scene.instances += [dataclasses.replace(scene.instances[0], name=f"again {index}") for index in range(2)]
        return scene

    cpu, _ = compare_samples(make)
    alone, _ = compare_samples(lambda: scenes.torus_room(16, 16))
    assert cpu.read("Combined")[..., :3].mean() < 0.9 * alone.read("Combined")[..., :3].mean()


@pytest.mark.slow
def test_hair_and_points():
    compare("fur")


@pytest.mark.parametrize("kind", tuple(Primitive)[1:], ids=lambda kind: kind.name.lower())
def test_rays_meet_each_kind_of_hair_where_embree_does(kind):
    compare_samples(lambda: strands.fur(24, 18, (kind,)), ("Position",), 0.001)


@pytest.mark.slow
def test_a_medium_that_varies():  # by other numbers than the CPU: null collisions are decided in float32
    failures = differences(*both("varying_smoke", LampSampling.MIS, passes=("Combined", "SDF Lamps")))
    assert not failures, "; ".join(failures)


def test_lamp_in_fog_by_cuts():
    compare_cuts("fog_lamp")


def test_lamp_in_a_room_where_cuts_do_not_pay():
    compare_cuts("torus_room", None)


@pytest.mark.slow
def test_light_through_a_veil_where_cuts_do_not_pay():
    compare_cuts("veiled", None)


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_CUTS)
def test_scene_by_cuts(name):
    compare_cuts(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SCENES if name not in APART])
def test_scene(name):
    compare(name)
