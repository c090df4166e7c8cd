# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path reuse: the picture's mean is the same, its noise less; threads and batches change nothing; a scene that cannot
have it, or does not gain, keeps its picture to the last bit."""

import dataclasses
import itertools

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.graph.formula import constant, maximum, minimum
from sdf_lights.render import session
from sdf_lights.render.cpu import light_paths, path_reuse
from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.film import Film
from sdf_lights.render.kernels.path_reuse.records import ARRIVAL
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.medium import Medium, Scattering
from sdf_lights.render.nodes.variables import INCOMING, NORMAL
from sdf_lights.render.passes import BY_NAME, is_light, matte_passes
from sdf_lights.render.sample_allocation import golden_ratio_sequence
from sdf_lights.render.scene import Ray, Shutter
from sdf_lights.render.settings import LampPaths, PathReuse
from support.blocks import means
from support.graphs import Graph
from support.scenes import (
    GREEN,
    RED,
    add,
    checker_image,
    diffuse,
    light_control,
    material,
    moving,
    probed,
    rotation,
    scaling,
    shadow_catcher,
    subsurface,
    torus_room,
    translation,
)
from support.scenes.media import smoke, varying_smoke
from support.scenes.strands import fur, moving_strands

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SIZE = 48, 32
WITHOUT, AUTOMATIC, ALWAYS = PathReuse.NEVER, PathReuse.AUTOMATIC, PathReuse.ALWAYS


def things(width: int, height: int):
    """A room with a ball that has a clear coat, rough metal, and a cube of glass that other things are seen through."""
    scene = torus_room(width, height)
    ball = material("principled", "ball", base_color=RED, roughness=0.4)
    add(scene, 2, translation(0.8, 0.3, 0.5) @ scaling(0.5, 0.5, 0.5), ball)
    metal = material("glossy", "metal", color=(0.9, 0.9, 0.9), roughness=0.3)
    add(scene, 2, translation(-0.2, -0.3, 0.3) @ scaling(0.3, 0.3, 0.3), metal)
    glass = material("glass", "glass", roughness=0.0)
    add(scene, 1, translation(0.3, -0.9, 0.3) @ rotation("z", 30) @ scaling(0.2, 0.02, 0.3), glass)
    return scene


def facing(width: int, height: int):
    """A wall whose diffuse colour depends on the direction of view."""
    scene = torus_room(width, height)
    view = INCOMING.dot(NORMAL)
    color = (view, constant(0.5), 1.0 - view)
    add(
        scene,
        1,
        translation(0.9, 0.3, 0.6) @ scaling(0.05, 0.9, 0.6),
        Material("facing", Node("diffuse", {"color": color})),
    )
    return scene


def film_of(path_reuse: PathReuse, build=things, size=SIZE, change=lambda scene: None, passes=(), **changes) -> Film:
    scene = build(*size)
    values = dict(samples=8, threads=2, path_reuse=path_reuse, lamp_paths=LampPaths.NEVER) | changes
    scene.settings = dataclasses.replace(scene.settings, **values)
    change(scene)
    return session.render(scene, passes)


def picture(path_reuse: PathReuse, **changes) -> np.ndarray:
    """(height, width, RGB)."""
    return film_of(path_reuse, **changes).read("Combined")[..., :3].astype(float)


def hidden(width: int, height: int):
    """``things`` that some rays pass by, and sheets that only some meet."""
    scene = things(width, height)
    named = {instance.name: instance for instance in scene.instances}
    for name, rays in (("wall 2", Ray.GLOSSY), ("ball", Ray.DIFFUSE), ("metal", Ray.GLOSSY), ("glass", Ray.CAMERA)):
        named[name].visibility &= ~rays
    for x, rays in ((0.2, Ray.SHADOW), (1.2, Ray.DIFFUSE), (-1.2, Ray.GLOSSY | Ray.CAMERA)):
        add(scene, 1, translation(x, 0.5, 0.9) @ scaling(0.4, 0.02, 0.4), diffuse(GREEN))
        scene.instances[-1].visibility = rays
    return scene


def linked(width: int, height: int):
    """``things`` with a lamp, a light and a glowing ball that each light some of them, and shadows that not all
    cast."""
    scene = things(width, height)
    for number, instance in enumerate(scene.instances):
        instance.light_set, instance.shadow_set = number % 3, number % 2
    scene.lamps[0].receivers, scene.lamps[0].blockers = 0b011, 0b01
    scene.lights.append(AreaLight("area", translation(0.5, -0.5, 2.8), 40.0, receivers=0b110, size=(0.8, 0.4)))
    add(scene, 2, translation(1.4, 0.8, 2.4) @ scaling(0.2, 0.2, 0.2), material("emission", strength=12.0))
    scene.instances[-1].receivers, scene.instances[-1].blockers = 0b101, 0b10
    return scene


def leaves(width: int, height: int):
    """A room with cut-out and tinted sheets, and one that is clear at flat angles."""
    scene = things(width, height)
    scene.images.append(checker_image())
    graph = Graph()
    color, alpha = (graph.image(0, graph.uv(), output, "Closest") for output in ("Color", "Alpha"))
    cut_out = graph.material("leaf", Node("principled", {"base_color": color, "alpha": alpha, "roughness": 0.5}))
    clear, red = Node("transparent", {"color": (0.5, 0.9, 0.6)}), Node("diffuse", {"color": RED})
    tinted = Material("tinted", Node("mix_closure", {"factor": 0.6, "a": red, "b": clear}))
    flat = minimum(maximum(1.2 - 2.0 * abs(INCOMING.dot(NORMAL)), 0.0), 1.0)
    grazing = Material("grazing", Node("mix_closure", {"factor": flat, "a": red, "b": clear}))
    for number in range(6):
        at = translation(0.6 * number - 1.5, 0.4 - 0.2 * (number % 2), 1.3) @ rotation("z", 50 * number)
        add(scene, 0, at @ rotation("x", 70) @ scaling(0.4, 0.4, 1.0), (cut_out, tinted, grazing)[number % 3])
    return scene


def mirrors(width: int, height: int):
    """A rough floor, whose rays meet a wall with a mirror: Filter Glossy blurs that for some of its points alone."""
    scene = torus_room(width, height)
    scene.materials.append(material("glossy", "rough", color=(0.8, 0.8, 0.8), roughness=0.4))
    scene.instances[0].materials = (len(scene.materials) - 1,)
    mirror = Node("glossy", {"color": (0.9, 0.9, 0.9), "roughness": 0.0})
    wall = Node("mix_closure", {"factor": 0.7, "a": Node("diffuse", {"color": (0.5, 0.5, 0.5)}), "b": mirror})
    scene.materials.append(Material("mirror", wall))
    scene.instances[2].materials = (len(scene.materials) - 1,)
    scene.lamps[0].matrix = translation(0.0, -1.0, 1.2) @ scaling(0.3, 0.3, 0.3)
    return scene


def by_area(scene) -> None:
    scene.lamps.clear()
    scene.lights.append(AreaLight("area", translation(0.5, -0.5, 2.8), 60.0, size=(0.8, 0.4)))


def assert_only_noise_differs(least: float, seeds: int = 24, lamp_paths=LampPaths.NEVER, **changes) -> None:
    """Means of the whole and of blocks over so many renders each agree within 4.5 standard errors: by chance, one set
    of seeds in a hundred would not. The variance is less than the part ``least``. ``lamp_paths``: beside path reuse."""
    fixed = dict(samples=8, indirect_paths=4, guided_samples=False) | changes
    found = [
        np.array([picture(each, seed=seed, **fixed, lamp_paths=beside) for seed in range(seeds)])
        for each, beside in ((WITHOUT, LampPaths.NEVER), (ALWAYS, lamp_paths))
    ]
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)
    if not fixed["guided_samples"]:  # else there are fewer branches
        noise = [np.median(each.var(axis=0, ddof=1)) for each in found]
        assert noise[1] < least * noise[0]


@pytest.mark.parametrize(
    ("build", "changes"),
    [
        (things, dict()),
        (facing, dict()),
        pytest.param(things, dict(change=by_area), marks=pytest.mark.slow),
        (things, dict(filter_glossy=1.0, max_bounces=12, diffuse_bounces=2, glossy_bounces=1)),
        pytest.param(
            things, dict(samples=32, indirect_paths=0, guided_samples=True, size=(32, 24)), marks=pytest.mark.slow
        ),
        pytest.param(mirrors, dict(filter_glossy=1.0, max_bounces=4, seeds=32), marks=pytest.mark.slow),
    ],
    ids=["things", "facing", "area", "limits", "allocated", "mirrors"],
)
def test_path_reuse_changes_the_noise_alone(build, changes):
    assert_only_noise_differs(0.6, build=build, **changes)


@pytest.mark.parametrize(
    ("build", "changes"),
    [
        (things, dict()),
        pytest.param(things, dict(change=by_area), marks=pytest.mark.slow),
        pytest.param(
            things,
            dict(filter_glossy=1.0, max_bounces=12, diffuse_bounces=2, glossy_bounces=1),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            things, dict(samples=32, indirect_paths=0, guided_samples=True, size=(32, 24)), marks=pytest.mark.slow
        ),
        pytest.param(leaves, dict(transparent_bounces=3), marks=pytest.mark.slow),
        pytest.param(subsurface, dict(), marks=pytest.mark.slow),
    ],
    ids=["things", "area", "limits", "allocated", "leaves", "subsurface"],
)
def test_vertices_that_groups_share_change_the_noise_alone(build, changes):
    assert_only_noise_differs(0.8, build=build, seeds=16, lamp_paths=LampPaths.ALWAYS, **changes)


# Scenes where some points and arrivals are not shared, with settings.
SPECIAL = {
    "hidden": (hidden, dict()),
    "linked": (linked, dict()),
    "light control": (light_control, dict()),
    "moving": (moving, dict()),
    "leaves": (leaves, dict(transparent_bounces=3)),
    "no caustics": (things, dict(caustics_reflective=False, caustics_refractive=False)),
    "no reflections": (things, dict(caustics_reflective=False)),
    "subsurface": (subsurface, dict()),
    "strands": (fur, dict()),
    "moving strands": (moving_strands, dict()),
    "catcher": (shadow_catcher, dict()),
    "smoke": (smoke, dict()),
    "varying smoke": (varying_smoke, dict()),
}
COMBINED = "moving strands", "no reflections", "varying smoke"  # parts of which others have: means are not compared


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SPECIAL if name not in COMBINED])
def test_special_scenes_differ_by_noise_alone(name):
    build, changes = SPECIAL[name]
    assert_only_noise_differs(0.8, build=build, size=(32, 24), seeds=16, **changes)


@pytest.mark.parametrize(
    "name", [name if name in ("hidden", "moving") else pytest.param(name, marks=pytest.mark.slow) for name in SPECIAL]
)
def test_special_scenes_do_not_depend_on_threads(name):
    """Each group has its time, and nothing of one group stays for the next."""
    build, changes = SPECIAL[name]
    fixed = dict(build=build, samples=4, indirect_paths=2, guided_samples=False, size=(72, 40)) | changes
    one, three = (picture(ALWAYS, threads=threads, **fixed) for threads in (1, 3))
    assert np.array_equal(one, three) and np.isfinite(one).all()
    assert not np.array_equal(one, picture(WITHOUT, **fixed))


def with_numbers(scene) -> None:
    scene.passes += matte_passes("object", 2)
    for number, instance in enumerate(scene.instances):
        instance.index = number


@pytest.mark.parametrize("build", [leaves, shadow_catcher])
def test_passes_have_the_surfaces_that_the_camera_sees(build):
    """These are known before paths divide."""
    scene_passes = *matte_passes("object", 2), *(item for item in BY_NAME.values() if not is_light(item))
    names = tuple(item.name for item in scene_passes)
    fixed = dict(build=build, passes=names, samples=4, indirect_paths=2, guided_samples=False, change=with_numbers)
    without, reused = (film_of(each, **fixed) for each in (WITHOUT, ALWAYS))
    assert not np.array_equal(without.read("Combined"), reused.read("Combined"))
    for name in ("Depth", "Normal", "Position", "Mist", "UV", "Object Index", "CryptoObject00", "Glossy Color"):
        assert np.array_equal(without.read(name), reused.read(name)), name


def test_times_of_a_pixel_are_spread_evenly():
    """A wall glows before the camera for half of the time: 8 of 16 samples see it, or one more or less at the end of
    the half."""

    def blink(scene) -> None:
        scene.shutter = Shutter()
        scene.lamps.clear()
        scene.instances[:] = [scene.instances[2]]
        scene.materials[0] = material("emission", strength=1.0)
        there = scene.instances[0]
        away = translation(0.0, 0.0, 100.0) @ there.matrix
        there.motion = np.stack([there.matrix] * 64 + [away] * 64)

    found = picture(ALWAYS, build=torus_room, change=blink, samples=16, guided_samples=False)
    middle = found[SIZE[1] // 2, :, 0]
    assert np.abs(middle[12:-12] - 0.5).max() <= 1.001 / 16


@pytest.mark.parametrize(
    ("path_reuse", "lamp_paths"), [(ALWAYS, LampPaths.NEVER), (ALWAYS, LampPaths.ALWAYS), (AUTOMATIC, LampPaths.NEVER)]
)
def test_the_picture_does_not_depend_on_threads(path_reuse, lamp_paths):
    one, three = (picture(path_reuse, lamp_paths=lamp_paths, threads=threads, samples=16) for threads in (1, 3))
    assert np.array_equal(one, three)


def test_samples_do_not_depend_on_how_they_are_asked_for():
    found = []
    for counts in ((1, 1, 6), (1, 2, 3, 2)):
        scene = things(*SIZE)
        fixed = dict(indirect_paths=4, guided_samples=False, path_reuse=ALWAYS, lamp_paths=LampPaths.NEVER)
        scene.settings = dataclasses.replace(scene.settings, **fixed)
        film = Film(scene)
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        for count in counts:
            assert renderer.sample(film.samples, count, lambda: False, lambda part: None)
        found.append(film.read("Combined"))
    assert np.array_equal(*found)


def test_pixels_with_more_samples_share_them():
    """A few pixels, far apart, take eight times as many samples. They share these with each other, so about an eighth
    of the noise is left: of the variance of 16 renders, less than a quarter."""
    found = []
    for seed in range(16):
        scene = torus_room(32, 32)
        fixed = dict(indirect_paths=2, guided_samples=False, path_reuse=ALWAYS, lamp_paths=LampPaths.NEVER, seed=seed)
        scene.settings = dataclasses.replace(scene.settings, **fixed)
        film = Film(scene)
        more = golden_ratio_sequence(len(film.rate)) < 1.0 / 16.0
        film.rate[more] = 8.0
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        assert renderer.sample(0, 4, lambda: False, lambda part: None)
        assert np.array_equal(film.count, 4 * film.rate)
        found.append(film.sums["scattered"].reshape(len(more), -1)[:, :3].sum(axis=1) / film.divided[:, 0])
    noise = np.var(found, axis=0, ddof=1) / np.mean(found, axis=0) ** 2
    assert np.median(noise[more]) < 0.25 * np.median(noise[~more])


@pytest.mark.parametrize("lamp_paths", [LampPaths.NEVER, LampPaths.ALWAYS])
def test_ranges_of_samples_are_one_render(lamp_paths):
    fixed = dict(indirect_paths=2, guided_samples=False, lamp_paths=lamp_paths)

    def part(first: int, end: int) -> np.ndarray:
        return picture(ALWAYS, sample_offset=first, samples=end - first, **fixed)

    ends = 0, 5, 16, 24
    joined = np.average([part(*each) for each in itertools.pairwise(ends)], axis=0, weights=np.diff(ends))
    np.testing.assert_allclose(joined, part(0, 24), rtol=2e-5, atol=1e-7)


def test_it_is_used_where_it_pays():
    """In a room of diffuse walls, most noise is of light that they have scattered. A floor alone does not light
    itself."""
    fixed = dict(samples=32, build=torus_room, size=(96, 64))
    assert not np.array_equal(picture(AUTOMATIC, **fixed), picture(WITHOUT, **fixed))
    fixed |= dict(change=floor)
    assert np.array_equal(picture(AUTOMATIC, **fixed), picture(WITHOUT, **fixed))


def test_no_sample_is_lost_where_nothing_can_be_gained(monkeypatch):
    """The samples that tell so are the first ones of the picture: none goes to a film of its own."""
    monkeypatch.setattr(CpuRenderer, "_trial", None)
    fixed = dict(samples=32, build=torus_room, size=(96, 64), change=floor)
    without = picture(WITHOUT, **fixed)
    assert np.array_equal(picture(AUTOMATIC, lamp_paths=LampPaths.AUTOMATIC, **fixed), without)


def floor(scene) -> None:
    del scene.instances[1:]


def fill(scene) -> None:
    scene.world.medium = Medium((0.01, 0.02, 0.04), (Scattering((0.05, 0.05, 0.05)),))


def roll(scene) -> None:
    scene.shutter = Shutter(rolling=0.1)


@pytest.mark.parametrize(
    ("path_reuse", "changes"),
    [
        (AUTOMATIC, dict(denoise=True)),
        (AUTOMATIC, dict(samples=8)),
        (ALWAYS, dict(max_bounces=0)),
        (ALWAYS, dict(change=fill)),
        (ALWAYS, dict(change=roll)),
        (ALWAYS, dict(passes=("Combined", "Diffuse Direct"))),
        (AUTOMATIC, dict(lamp_paths=LampPaths.ALWAYS)),
    ],
    ids=["denoised", "few samples", "no bounces", "in fog", "rolling shutter", "lobes", "light paths"],
)
def test_other_pictures_stay_as_they_are(path_reuse, changes):
    assert np.array_equal(picture(path_reuse, **changes), picture(WITHOUT, **changes))


@pytest.mark.parametrize("lamp_paths", [LampPaths.NEVER, LampPaths.ALWAYS])
def test_materials_that_trace_rays_do_not_share(lamp_paths):
    """Shading them once more would need random numbers of its own."""
    assert np.isfinite(picture(ALWAYS, build=probed, samples=2, lamp_paths=lamp_paths)).all()


def test_a_clamp_takes_as_much(monkeypatch):
    """Light that is shared is clamped as if one path had brought it. All bounces behind a surface are clamped together,
    so a little more is lost: with a strong clamp, nothing is shared."""
    fixed = dict(samples=32, indirect_paths=2, guided_samples=False)
    without, always = (picture(each, clamp_indirect=0.2) for each in (WITHOUT, ALWAYS))
    assert np.array_equal(without, always)
    monkeypatch.setattr(light_paths, "LEAST_CLAMP", 0.0)
    plain = picture(WITHOUT, **fixed).mean()
    lost = [1.0 - picture(each, clamp_indirect=0.2, **fixed).mean() / plain for each in (WITHOUT, ALWAYS)]
    assert 0.05 < lost[0] < lost[1] < 1.2 * lost[0]


def test_points_share_costly_arrivals_less():
    arrivals = np.zeros(2, ARRIVAL)
    arrivals["number"] = 1000
    assert path_reuse.step_for(arrivals) == 1
    arrivals["uneven"] = 20
    assert path_reuse.step_for(arrivals) == 1
    arrivals["uneven"] = 1000
    assert path_reuse.step_for(arrivals) == path_reuse.MOST_STEP
