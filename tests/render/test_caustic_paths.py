# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustic paths: the picture's mean is the same, its noise less; threads and batches change nothing; a scene that
cannot have them, or does not gain, keeps its picture to the last bit."""

import dataclasses
import itertools

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.graph.formula import constant, maximum
from sdf_lights.render import session
from sdf_lights.render.cpu.block import PackedScene, Workspace
from sdf_lights.render.cpu.caustic_paths import CausticTracer
from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.film import Film
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import BACKFACING, POSITION
from sdf_lights.render.scene import Lamp, Projection
from sdf_lights.render.settings import CausticPaths, Filter, LampPaths, PathReuse
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.shapes import Box, Sphere
from support.blocks import means
from support.scenes import GREY, WHITE, add, camera, material, room, rotation, scaling, translation
from support.scenes.meshes import sphere

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SIZE = 32, 24
WITHOUT, AUTOMATIC, ALWAYS = CausticPaths.NEVER, CausticPaths.AUTOMATIC, CausticPaths.ALWAYS
FIXED = dict(samples=32, indirect_paths=4, guided_samples=False)


def lamp(radius: float, power: float = 60.0, **changes) -> Lamp:
    return Lamp("lamp", Sphere(radius), translation(0.3, -0.3, 2.2), power=power, **changes)


def above_floor(width: int, height: int):
    """A floor of some materials, seen from above, with a lamp over it."""
    scene = room(width, height, max_bounces=6, diffuse_bounces=1, glossy_bounces=4, transmission_bounces=6)
    scene.instances = scene.instances[:1]
    scene.camera = camera((0.0, -3.0, 3.0), (0.0, 0.0, 0.2), width, height, 0.42)
    scene.lamps.append(lamp(0.35))
    return scene


def ball(width: int, height: int):
    """A coarse smooth ball of glass: its normals are far from those of its faces."""
    scene = above_floor(width, height)
    add(scene, 2, translation(-0.4, -0.1, 0.6) @ scaling(0.5, 0.5, 0.5), material("glass", "ball", roughness=0.0))
    return scene


def mirrors(width: int, height: int):
    """A mirror, plastic whose coat is a mirror and whose base is seen, too, and a floor that is partly glossy."""
    scene = above_floor(width, height)
    mirror = material("glossy", "mirror", color=(0.9, 0.8, 0.7), roughness=0.0)
    add(scene, 1, translation(0.9, 0.3, 0.5) @ rotation("z", 25) @ scaling(0.3, 0.3, 0.5), mirror)
    plastic = material("principled", "plastic", base_color=(0.2, 0.5, 0.8), roughness=0.0)
    add(scene, 1, translation(-0.7, 0.2, 0.4) @ rotation("z", -30) @ scaling(0.1, 0.6, 0.4), plastic)
    scene.materials[0] = material("principled", "floor", base_color=WHITE, roughness=0.5)
    return scene


def water(width: int, height: int):
    """A sheet of tinted water with waves above the floor, below a lamp whose emission varies, beside a box lamp."""
    scene = above_floor(width, height)
    wavy = sphere("water", columns=24, rows=12)
    scene.meshes.append(wavy)
    tint = Material("water", Node("glass", {"color": (0.8, 0.9, 1.0), "roughness": constant(0.0), "ior": 1.33}))
    add(scene, len(scene.meshes) - 1, translation(0.0, 0.0, 0.5) @ scaling(0.9, 0.9, 0.15), tint)
    scene.lamps[0] = lamp(0.35, emission=EmissionExpression("exp(-20 * depth)").emission())
    scene.lamps.append(Lamp("box", Box((0.5, 0.5, 0.1)), translation(-0.8, -0.4, 2.0), power=20.0))
    return scene


def one_sided(width: int, height: int):
    """Panes that are mirrors on one side, by the Geometry node, and partly by a texture."""
    scene = above_floor(width, height)
    bright = Node("glossy", {"color": (0.9, 0.9, 0.9), "roughness": 0.0})
    dark = Node("diffuse", {"color": GREY})
    add(
        scene,
        1,
        translation(0.8, 0.3, 0.5) @ rotation("z", 25) @ scaling(0.1, 0.4, 0.5),
        Material("pane", Node("mix_closure", {"factor": BACKFACING, "a": bright, "b": dark})),
    )
    rough = {"color": (0.9, 0.9, 0.9), "roughness": maximum(POSITION[2] - 0.5, 0.0)}
    add(scene, 1, translation(-0.8, 0.3, 0.5) @ scaling(0.3, 0.1, 0.5), Material("rough", Node("glossy", rough)))
    return scene


def metal(width: int, height: int):
    """A rough metal box, a plate of frosted glass, and plastic with a smooth coat that is not quite a mirror, on a
    floor that is partly glossy."""
    scene = above_floor(width, height)
    brushed = material("glossy", "brushed", color=(0.9, 0.8, 0.7), roughness=0.25)
    add(scene, 1, translation(0.9, 0.3, 0.5) @ rotation("z", 25) @ scaling(0.3, 0.3, 0.5), brushed)
    add(scene, 1, translation(0.0, -0.2, 0.6) @ scaling(0.3, 0.3, 0.02), material("glass", "frosted", roughness=0.3))
    plastic = material("principled", "plastic", base_color=(0.2, 0.5, 0.8), roughness=0.2)
    add(scene, 1, translation(-0.7, 0.2, 0.4) @ rotation("z", -30) @ scaling(0.1, 0.6, 0.4), plastic)
    scene.materials[0] = material("principled", "floor", base_color=WHITE, roughness=0.5)
    return scene


def render(caustic_paths: CausticPaths, build=ball, size=SIZE, change=lambda scene: None, passes=(), **changes) -> Film:
    scene = build(*size)
    values = dict(samples=8, threads=2, caustic_paths=caustic_paths, lamp_paths=LampPaths.NEVER)
    values |= dict(path_reuse=PathReuse.NEVER) | changes
    scene.settings = dataclasses.replace(scene.settings, **values)
    change(scene)
    return session.render(scene, passes)


def picture(*arguments, **changes) -> np.ndarray:
    """(height, width, RGB)."""
    return render(*arguments, **changes).read("Combined")[..., :3].astype(float)


def small(scene) -> None:
    scene.lamps[0] = lamp(0.1)


def orthographic(scene) -> None:
    scene.camera = dataclasses.replace(scene.camera, projection=Projection.ORTHOGRAPHIC, window=(-1.6, 1.6, -1.2, 1.2))


def through_a_lens(scene) -> None:
    scene.camera = dataclasses.replace(scene.camera, aperture=0.1, focus=3.0, blades=5)


def border(scene) -> None:
    scene.border = (8, 4, 28, 20)
    scene.settings.filter, scene.settings.filter_width = Filter.BLACKMAN_HARRIS, 2.5


@pytest.fixture
def left_to_caustic_paths(monkeypatch) -> None:
    """All light that caustic paths can find is left to them, by ratios a thousand times as large."""
    fill = PackedScene.set_caustic_paths

    def leave(packed, tables, scalars) -> None:
        if "caustic_density" in tables:
            targets = tables["caustic_targets"].copy()
            targets["lines"] *= 1000.0
            tables = tables | {"caustic_density": 1000.0 * tables["caustic_density"], "caustic_targets": targets}
        fill(packed, tables, scalars)

    monkeypatch.setattr(PackedScene, "set_caustic_paths", leave)


def tight(scene) -> None:
    scene.settings.max_bounces = 3
    scene.settings.glossy_bounces = scene.settings.transmission_bounces = 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("build", "change"),
    [
        (ball, lambda scene: None),
        (ball, border),
        (ball, orthographic),
        (ball, through_a_lens),
        (ball, tight),
        (mirrors, lambda scene: None),
        (mirrors, tight),
        (water, lambda scene: None),
        (one_sided, lambda scene: None),
        (metal, lambda scene: None),
        (metal, tight),
    ],
    ids=[
        *("ball", "border", "orthographic", "lens", "limits", "mirrors", "limited mirrors", "water", "one-sided"),
        *("metal", "limited metal"),
    ],
)
def test_caustic_paths_change_the_noise_alone(build, change, left_to_caustic_paths):
    """Means of the whole and of blocks over 24 renders each agree within 4.5 standard errors of their differences: by
    chance, one set of seeds in a hundred would not. Blocks with hardly any caustic do not count: errors are not normal
    there."""
    one, other = (
        np.array([picture(each, build, change=change, seed=seed, **FIXED) for seed in range(24)])
        for each in (WITHOUT, ALWAYS)
    )
    assert not np.array_equal(one, other)
    if one.shape[1:3] != SIZE[::-1]:
        assert one.shape[1:3] == (16, 20)
    for left, right in zip(means(one), means(other)):
        apart = right - left
        error = apart.std(axis=0, ddof=1) / np.sqrt(len(apart))
        known = error > 1e-4 * left.mean()
        assert np.all(np.abs(apart.mean(axis=0))[known] < 4.5 * error[known])


def test_caustics_have_less_noise():
    """The same mean, within 2 %, and a fifth of the squared error at most where the caustic is bright."""
    without, found = (
        np.array([picture(each, change=small, seed=seed, **FIXED) for seed in range(8)]) for each in (WITHOUT, ALWAYS)
    )
    assert found.mean() == pytest.approx(without.mean(), rel=0.02)
    caustic = render(ALWAYS, change=small, **FIXED).caustic_light().sum(axis=1).reshape(SIZE[::-1])
    lit = caustic > np.quantile(caustic, 0.98)
    noise = [each.var(axis=0, ddof=1).mean(axis=2)[lit].mean() for each in (without, found)]
    assert noise[1] < 0.2 * noise[0]


@pytest.mark.parametrize("caustic_paths", [ALWAYS, AUTOMATIC])
@pytest.mark.parametrize("build", [ball, metal])
def test_the_picture_does_not_depend_on_threads(build, caustic_paths):
    one, three = (
        picture(caustic_paths, build, change=small, threads=threads, size=(48, 36), samples=64) for threads in (1, 3)
    )
    assert np.array_equal(one, three)
    assert not np.array_equal(one, picture(WITHOUT, build, change=small, size=(48, 36), samples=64))


def test_samples_do_not_depend_on_how_they_are_asked_for():
    found = []
    for counts in ((1, 1, 14), (1, 2, 3, 10)):
        scene = ball(*SIZE)
        scene.settings = dataclasses.replace(
            scene.settings, indirect_paths=4, guided_samples=False, caustic_paths=ALWAYS, lamp_paths=LampPaths.NEVER
        )
        film = Film(scene)
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        for count in counts:
            assert renderer.sample(film.samples, count, lambda: False, lambda part: None)
        found.append(film.read("Combined"))
    np.testing.assert_allclose(*found, rtol=1e-6)


@pytest.mark.parametrize("ends", [(0, 16, 32), (0, 5, 24, 32)], ids=["equal", "anywhere"])
def test_ranges_of_samples_are_one_render(ends):
    """Their mean by the number of samples is the picture of one render."""

    def part(first: int, end: int) -> np.ndarray:
        return picture(ALWAYS, sample_offset=first, samples=end - first, indirect_paths=2, guided_samples=False)

    whole, parts = part(0, 32), [part(*each) for each in itertools.pairwise(ends)]
    joined = np.average(parts, axis=0, weights=np.diff(ends))
    np.testing.assert_allclose(joined, whole, rtol=2e-5, atol=1e-7)


CONNECTED, REUSED = dict(lamp_paths=LampPaths.ALWAYS), dict(path_reuse=PathReuse.ALWAYS)


@pytest.mark.parametrize("build", [ball, metal])
@pytest.mark.parametrize("others", [CONNECTED, REUSED, CONNECTED | REUSED], ids=["connected", "reused", "both"])
def test_they_work_with_light_paths_and_path_reuse(build, others, left_to_caustic_paths):
    """Means over 12 renders agree within 4.5 standard errors."""
    one, other = (
        np.array([picture(each, build, seed=seed, **FIXED | dict(samples=16) | others).mean() for seed in range(12)])
        for each in (WITHOUT, ALWAYS)
    )
    assert not np.array_equal(one, other)
    apart = other - one
    assert abs(apart.mean()) < 4.5 * apart.std(ddof=1) / np.sqrt(len(apart))


def test_the_pass_of_lamps_has_them():
    film = render(ALWAYS, passes=("SDF Lamps",))
    assert len(film.caustics)
    np.testing.assert_allclose(film.read("SDF Lamps"), film.read("Combined")[..., :3], rtol=1e-5, atol=1e-6)


def _blurred(scene) -> None:
    scene.settings.filter_glossy = 1.0


def _rough(scene) -> None:
    scene.materials[-1] = material("glass", "ball", roughness=0.6)


def _seen_through(scene) -> None:
    """Narrow lobes, but also something transparent, which light rays pass."""
    scene.materials[-1] = material("glass", "ball", roughness=0.3)
    add(scene, 1, translation(0.9, 0.3, 0.5) @ scaling(0.1, 0.1, 0.1), material("transparent", "veil", color=GREY))


def _hidden(scene) -> None:
    """The ball stands below the floor: no path finds it."""
    scene.instances[-1].matrix = translation(0.0, 0.0, -3.0)


def _area(scene) -> None:
    scene.lamps.clear()
    scene.lights.append(AreaLight("area", translation(0.5, -0.5, 2.8), 60.0, size=(0.8, 0.4)))


@pytest.mark.parametrize(
    ("caustic_paths", "change", "passes"),
    [
        (ALWAYS, _blurred, ()),
        (ALWAYS, _rough, ()),
        (ALWAYS, _seen_through, ()),
        (ALWAYS, _area, ()),
        (AUTOMATIC, _hidden, ()),
        (AUTOMATIC, lambda scene: setattr(scene.settings, "samples", 4), ()),
        (ALWAYS, lambda scene: setattr(scene.settings, "caustics_refractive", False), ()),
        (ALWAYS, lambda scene: None, ("Diffuse Direct",)),
    ],
    ids=["filtered", "rough", "seen through", "area", "hidden", "few samples", "no caustics", "lobes"],
)
def test_where_they_are_not_used_the_picture_is_the_same(caustic_paths, change, passes):
    changes = dict(samples=64, change=change, passes=passes)
    found = [render(each, **changes) for each in (WITHOUT, caustic_paths)]
    assert not len(found[1].caustics)
    assert np.array_equal(*(film.read("Combined") for film in found))


def test_targets_are_around_mirrors():
    scene = mirrors(*SIZE)
    scene.settings = dataclasses.replace(scene.settings, caustic_paths=ALWAYS)
    packed = PackedScene(scene, Film(scene, ()))
    tracer = CausticTracer.of(scene, packed, [Workspace(packed)])
    assert tracer is not None and tracer.begin(lambda: None)
    targets = packed.table("caustic_targets")
    assert 2 <= len(targets)
    for index in (1, 2):
        corners = scene.meshes[1].positions.astype(float)
        world = corners @ scene.instances[index].matrix[:3, :3].T + scene.instances[index].matrix[:3, 3]
        apart = np.linalg.norm(world[:, None] - targets["position"][None], axis=2)
        assert np.all((apart <= targets["radius"] + 1e-6).any(axis=1))
    # The floor is rough, and no mirror.
    assert np.all(targets["position"][:, 2] + targets["radius"] > 0.1)
