# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path reuse: the picture's mean is the same, its noise less; threads and batches change nothing; a scene that cannot
have it, or does not gain, keeps its picture to the last bit."""

import dataclasses
import itertools

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.graph.formula import constant
from sdf_lights.render import session
from sdf_lights.render.cpu import path_reuse
from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.film import Film
from sdf_lights.render.kernels.path_reuse.records import ARRIVAL
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import INCOMING, NORMAL
from sdf_lights.render.scene import Ray
from sdf_lights.render.settings import LampPaths, PathReuse
from support.blocks import means
from support.scenes import RED, add, material, probed, rotation, scaling, torus_room, translation

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


def picture(path_reuse: PathReuse, build=things, size=SIZE, change=lambda scene: None, **changes) -> np.ndarray:
    """(height, width, RGB)."""
    scene = build(*size)
    values = dict(samples=8, threads=2, path_reuse=path_reuse, lamp_paths=LampPaths.NEVER) | changes
    scene.settings = dataclasses.replace(scene.settings, **values)
    change(scene)
    return session.render(scene, ()).read("Combined")[..., :3].astype(float)


def by_area(scene) -> None:
    scene.lamps.clear()
    scene.lights.append(AreaLight("area", translation(0.5, -0.5, 2.8), 60.0, size=(0.8, 0.4)))


@pytest.mark.parametrize(
    ("build", "changes"),
    [
        (things, dict()),
        (facing, dict()),
        pytest.param(things, dict(change=by_area), marks=pytest.mark.slow),
        (things, dict(filter_glossy=1.0, max_bounces=12, diffuse_bounces=2, glossy_bounces=1)),
        pytest.param(things, dict(samples=32, indirect_paths=0, guided_samples=True), marks=pytest.mark.slow),
    ],
    ids=["things", "facing", "area", "limits", "allocated"],
)
def test_path_reuse_changes_the_noise_alone(build, changes):
    """Means of the whole and of blocks over 24 renders each agree within 4.5 standard errors: by chance, one set of
    seeds in a hundred would not."""
    fixed = dict(build=build, samples=8, indirect_paths=4, guided_samples=False) | changes
    found = [np.array([picture(each, seed=seed, **fixed) for seed in range(24)]) for each in (WITHOUT, ALWAYS)]
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)
    if not fixed["guided_samples"]:  # else there are fewer branches
        noise = [np.median(each.var(axis=0, ddof=1)) for each in found]
        assert noise[1] < 0.6 * noise[0]


@pytest.mark.parametrize("path_reuse", [ALWAYS, AUTOMATIC])
def test_the_picture_does_not_depend_on_threads(path_reuse):
    one, three = (picture(path_reuse, threads=threads, samples=16) for threads in (1, 3))
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


def test_ranges_of_samples_are_one_render():
    def part(first: int, end: int) -> np.ndarray:
        return picture(ALWAYS, sample_offset=first, samples=end - first, indirect_paths=2, guided_samples=False)

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


def hide(scene) -> None:
    scene.instances[-1].visibility &= ~Ray.DIFFUSE


@pytest.mark.parametrize(
    ("path_reuse", "changes"),
    [
        (AUTOMATIC, dict(denoise=True)),
        (AUTOMATIC, dict(samples=8)),
        (ALWAYS, dict(max_bounces=0)),
        (ALWAYS, dict(caustics_reflective=False)),
        (ALWAYS, dict(change=hide)),
        (ALWAYS, dict(lamp_paths=LampPaths.ALWAYS)),
    ],
    ids=["denoised", "few samples", "no bounces", "no caustics", "hidden", "light paths"],
)
def test_other_pictures_stay_as_they_are(path_reuse, changes):
    assert np.array_equal(picture(path_reuse, **changes), picture(WITHOUT, **changes))


@pytest.mark.parametrize("lamp_paths", [LampPaths.NEVER, LampPaths.ALWAYS])
def test_materials_that_trace_rays_do_not_share(lamp_paths):
    """Shading them once more would need random numbers of its own."""
    assert np.isfinite(picture(ALWAYS, build=probed, samples=2, lamp_paths=lamp_paths)).all()


def test_a_clamp_takes_as_much():
    """Light that is shared is clamped as if one path had brought it. All bounces behind a surface are clamped together,
    so a little more is lost."""
    fixed = dict(samples=32, indirect_paths=2, guided_samples=False)
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
