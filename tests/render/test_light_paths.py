# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths: the picture's mean is the same, its noise less; threads change nothing; a scene that cannot have them,
or does not gain, keeps its picture to the last bit. ``test_agreement`` compares the scene "cove" with the reference."""

import dataclasses
import itertools

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.graph.formula import Vector, constant
from sdf_lights.render import session
from sdf_lights.render.cpu import light_paths, pilot
from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.film import Film
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import BACKFACING, POSITION
from sdf_lights.render.scene import Primitive, Ray, Shutter, World
from sdf_lights.render.settings import LampPaths, PathReuse
from support.blocks import means
from support.scenes import (
    add,
    camera,
    changing_lamps,
    cove,
    look_at,
    material,
    moving,
    rolling,
    scaling,
    torus_lamp,
    torus_room,
    translation,
)
from support.scenes.strands import tuft

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SIZE = 32, 24
WITHOUT, AUTOMATIC, ALWAYS = LampPaths.NEVER, LampPaths.AUTOMATIC, LampPaths.ALWAYS


def picture(lamp_paths: LampPaths, build=cove, size=SIZE, change=lambda scene: None, **changes) -> np.ndarray:
    """(height, width, RGB)."""
    scene = build(*size)
    values = dict(samples=8, threads=2, lamp_paths=lamp_paths) | changes
    scene.settings = dataclasses.replace(scene.settings, **values)
    change(scene)
    return session.render(scene, ()).read("Combined")[..., :3].astype(float)


@pytest.mark.parametrize(
    ("changes", "connections"),
    [
        pytest.param(dict(), 1, marks=pytest.mark.slow),
        (dict(), 4),
        pytest.param(
            dict(max_bounces=12, diffuse_bounces=2, glossy_bounces=1, transmission_bounces=1, transparent_bounces=1),
            4,
            marks=pytest.mark.slow,
        ),
    ],
    ids=["one connection", "plain", "tight limits"],
)
def test_light_paths_change_the_noise_alone(changes, connections, monkeypatch):
    """Means of the whole and of blocks over 24 renders each agree within 4.5 standard errors: by chance, one set of
    seeds in a hundred would not. Both have the same numbers of samples and branches: else the noise alone would not
    tell."""
    monkeypatch.setattr(light_paths, "CONNECTIONS", connections)
    fixed = dict(samples=16, indirect_paths=4, guided_samples=False) | changes
    found = [np.array([picture(each, seed=seed, **fixed) for seed in range(24)]) for each in (WITHOUT, ALWAYS)]
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)
    noise = [np.median(each.var(axis=0, ddof=1)) for each in found]
    assert noise[1] < 0.4 * noise[0]


@pytest.mark.parametrize("lamp_paths", [ALWAYS, AUTOMATIC])
def test_the_picture_does_not_depend_on_threads(lamp_paths):
    one, three = (picture(lamp_paths, threads=threads, size=(48, 36)) for threads in (1, 3))
    assert np.array_equal(one, three)


def test_samples_do_not_depend_on_how_they_are_asked_for():
    """Sets of light paths belong to the numbers of samples."""
    found = []
    for counts in ((1, 1, 6), (1, 2, 3, 2)):
        scene = cove(*SIZE)
        scene.settings = dataclasses.replace(scene.settings, indirect_paths=4, guided_samples=False)
        film = Film(scene)
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        for count in counts:
            assert renderer.sample(film.samples, count, lambda: False, lambda part: None)
        found.append(film.read("Combined"))
    assert np.array_equal(*found)


@pytest.mark.parametrize("ends", [(0, 16, 32, 48, 64), (0, 5, 24, 25, 64)], ids=["equal", "anywhere"])
def test_ranges_of_samples_are_one_render(ends):
    """Their mean by the number of samples is the picture of one render: ranges have the light paths that their samples
    have there."""

    def part(first: int, end: int) -> np.ndarray:
        fixed = dict(sample_offset=first, samples=end - first, indirect_paths=2, guided_samples=False)
        return picture(ALWAYS, change=_only_walls, **fixed)

    whole, parts = part(0, 64), [part(*each) for each in itertools.pairwise(ends)]
    joined = np.average(parts, axis=0, weights=np.diff(ends))
    np.testing.assert_allclose(joined, whole, rtol=2e-5, atol=1e-7)
    assert not np.allclose(parts[1], parts[2], rtol=1e-2)  # no two have the same samples


def test_denoised_pictures_have_more_light_paths(monkeypatch):
    """A denoiser cannot see the noise that all pixels share. The first samples have most of them."""
    connect, numbers = light_paths.LightPaths._connect, []

    def counting(self, number: int, paths: int, connections: int) -> None:
        numbers.append(paths)
        connect(self, number, paths, connections)

    monkeypatch.setattr(light_paths.LightPaths, "_connect", counting)
    totals = []
    for denoise in (False, True):
        picture(ALWAYS, denoise=denoise)
        totals.append(sum(numbers))
        numbers.clear()
    pixels = SIZE[0] * SIZE[1]
    assert totals[0] < 2 * pixels and totals[1] == 8 * pixels
    monkeypatch.setattr(light_paths, "DENOISED_SAMPLES", 4 * pixels)
    picture(ALWAYS, denoise=True)
    assert 4 * pixels < sum(numbers) < 5 * pixels


@pytest.mark.slow
def test_ranges_that_choose_light_paths_themselves_have_no_bias():
    """Each range tries light paths by its own samples. The mean of four ranges is that of renders without light paths,
    within 4.5 standard errors: by chance, one set of seeds in a hundred thousand would not be."""

    def joined(seed: int) -> float:
        return float(
            np.mean(
                [
                    picture(AUTOMATIC, size=(48, 36), change=_only_walls, samples=16, sample_offset=first, seed=seed)
                    for first in range(0, 64, 16)
                ]
            )
        )

    without = [picture(WITHOUT, size=(48, 36), change=_only_walls, samples=64, seed=seed).mean() for seed in range(8)]
    found = [joined(seed) for seed in range(8)]
    error = np.sqrt((np.var(found, ddof=1) + np.var(without, ddof=1)) / 8)
    assert abs(np.mean(found) - np.mean(without)) < 4.5 * error


def _only_walls(scene) -> None:
    """Only the room and the shelf, from near by: nothing but scattered light is noisy."""
    scene.instances = scene.instances[:6]
    scene.camera = camera((0.0, -3.0, 1.2), (0.0, 0.0, 1.0), scene.width, scene.height)
    scene.lamps[0] = dataclasses.replace(scene.lamps[0], visibility=Ray.ALL & ~Ray.CAMERA)


def test_where_they_pay_they_are_used():
    """A room that a hidden lamp lights. The choice is no other sampling than the setting that is always on. Path reuse,
    which would divide paths without light paths, is off."""
    fixed = dict(size=(64, 48), change=_only_walls, samples=16, path_reuse=PathReuse.NEVER)
    without, automatic, always = (picture(each, **fixed) for each in (WITHOUT, AUTOMATIC, ALWAYS))
    assert not np.array_equal(without, automatic)
    assert _roughness(automatic) < 0.8 * _roughness(without)
    assert automatic.mean() == pytest.approx(always.mean(), rel=0.02)


def _roughness(picture: np.ndarray) -> float:
    """The median square of differences of neighbours."""
    return float(np.median(np.diff(picture.sum(axis=2), axis=1) ** 2))


def _outside(scene) -> None:
    """A floor and a wall under a lamp that shines on them: hardly any light is scattered twice."""
    scene.instances = scene.instances[:1] + scene.instances[2:3]


def test_where_they_do_not_pay_no_bit_changes():
    found = (picture(each, torus_room, (48, 36), _outside, samples=16) for each in (WITHOUT, AUTOMATIC))
    assert np.array_equal(*found)


def test_a_single_sample_is_not_measured():
    assert np.array_equal(*(picture(each, samples=1) for each in (WITHOUT, AUTOMATIC)))


def _lamp(**changes):
    def change(scene) -> None:
        scene.lamps[0] = dataclasses.replace(scene.lamps[0], **changes)

    return change


def _object(**changes):
    def change(scene) -> None:
        scene.instances[5] = dataclasses.replace(scene.instances[5], **changes)

    return change


def _sun(scene) -> None:
    scene.lights.append(SunLight("sun", look_at((0.0, -3.0, 2.0), (0.0, 0.0, 0.5)), 0.5))


def _world(scene) -> None:
    scene.world = World((0.1, 0.1, 0.1), 1.0)


def _emission(scene) -> None:
    add(scene, 1, translation(0.0, 0.0, 0.2), material("emission", "glow", color=(1.0, 1.0, 1.0), strength=1.0))


def _clamp(scene) -> None:
    scene.settings = dataclasses.replace(scene.settings, clamp_indirect=0.5)


def _toon(scene) -> None:
    scene.materials[scene.instances[5].materials[0]] = material("toon", "toon", color=(0.8, 0.8, 0.8))


@pytest.mark.parametrize(
    "change",
    [
        _lamp(visibility=Ray.ALL & ~Ray.DIFFUSE),
        _lamp(visibility=Ray.ALL & ~Ray.SHADOW),
        _lamp(receivers=2),
        _lamp(blockers=2),
        _lamp(max_bounces=1),
        _object(visibility=Ray.ALL & ~Ray.GLOSSY),
        _object(visibility=Ray.ALL & ~Ray.SHADOW),
        _toon,
        _clamp,
    ],
    ids=["unseen", "no shadow rays", "receivers", "blockers", "bounces", "object", "no shadow", "toon", "clamp"],
)
def test_what_they_cannot_follow_leaves_them_off(change):
    assert np.array_equal(*(picture(each, change=change, samples=2) for each in (WITHOUT, ALWAYS)))


def _restricted_lamp(scene) -> None:
    """Light paths start from the other lamp alone."""
    scene.lamps.append(dataclasses.replace(torus_lamp(0.5, -0.6, 1.2, 20.0, 0.2), visibility=Ray.ALL & ~Ray.GLOSSY))


def _restricted_mesh(scene) -> None:
    """A glowing ball lights some objects alone, and a panel has shadows that not all cast. No light paths start
    there."""
    for number, instance in enumerate(scene.instances):
        instance.light_set, instance.shadow_set = number % 3, number % 2
    for x, links in ((-1.2, dict(receivers=0b101)), (1.2, dict(blockers=0b01))):
        glow = material("emission", "glow", color=(1.0, 0.8, 0.6), strength=10.0)
        add(scene, 2, translation(x, -0.5, 0.8) @ scaling(0.15, 0.15, 0.15), glow)
        scene.instances[-1] = dataclasses.replace(scene.instances[-1], **links)


def _everywhere(node: Node):
    """All but the floor gets a material of this node."""

    def change(scene) -> None:
        scene.materials.append(Material("all", node))
        for instance in scene.instances[1:]:
            instance.materials = (len(scene.materials) - 1,)

    return change


def _strands(scene) -> None:
    """Diffuse strands stand in the room."""
    scene.meshes.append(tuft(Primitive.CONES))
    add(scene, len(scene.meshes) - 1, scaling(2.0, 1.5, 1.2), material("diffuse", "fur", color=(0.8, 0.7, 0.5)))


def _outdoors(scene) -> None:
    """A bright world and a sun take the place of the lamp."""
    scene.lamps.clear()
    scene.world = World((1.0, 1.2, 1.5), 1.0)
    _sun(scene)


SKIN = Node(
    "principled", {"base_color": (0.8, 0.5, 0.4), "subsurface_weight": 0.7, "subsurface_radius": (0.3, 0.2, 0.1)}
)
SHINY = Node(
    "mix_closure",
    {
        "factor": 0.5,
        "a": Node("diffuse", {"color": (0.7, 0.7, 0.7)}),
        "b": Node("glossy", {"color": (0.9, 0.9, 0.9), "roughness": 0.0}),
    },
)
BRUSHED = Node(
    "mix_closure",
    {
        "factor": 0.6,
        "a": Node("diffuse", {"color": (0.7, 0.7, 0.7)}),
        "b": Node("glossy", {"color": (0.9, 0.9, 0.9), "roughness": 0.3, "anisotropy": 0.7}),
    },
)


@pytest.mark.parametrize(
    "change",
    [
        _outdoors,
        *(
            pytest.param(change, marks=pytest.mark.slow)
            for change in (
                *(_sun, _everywhere(SKIN), _world, _emission, _restricted_lamp, _restricted_mesh, _everywhere(BRUSHED)),
                _strands,
            )
        ),
    ],
    ids=["world and sun", "sun", "skin", "world", "mesh", "restricted lamp", "linked meshes", "brushed", "strands"],
)
def test_all_light_of_such_scenes_is_there(change):
    """Light paths are used, and means of the whole and of blocks over 24 renders each agree within 4.5 standard errors:
    by chance, one set of seeds in a hundred would not."""
    found = [
        np.array([picture(each, change=change, seed=seed, samples=8) for seed in range(24)])
        for each in (WITHOUT, ALWAYS)
    ]
    assert not np.array_equal(*found)
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)


@pytest.mark.parametrize("build", [moving, pytest.param(changing_lamps, marks=pytest.mark.slow)])
def test_what_moves_has_all_of_its_light(build):
    """As above, over 16 renders each. The camera, objects, meshes, lamps and lights move, turn, and change their
    shapes; some objects glow. Some of the exposure counts more than the rest."""
    found = [np.array([picture(each, build, seed=seed, samples=8) for seed in range(16)]) for each in (WITHOUT, ALWAYS)]
    assert not np.array_equal(*found)
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)


def test_light_paths_have_the_times_of_the_exposure():
    """A set has one time in each eighth of the exposure, and the times of many sets are even there. The second half of
    the exposure has three times the weight of the first."""
    scene = moving(8, 8)
    scene.shutter = Shutter(np.interp(np.linspace(0.0, 1.0, 65), (0.0, 0.25, 1.0), (0.0, 0.5, 1.0)))
    renderer = CpuRenderer(scene, Film(scene), lambda: False, lambda text: None)
    times = np.array([renderer._light_paths._times(number) for number in range(1, 129)])
    even = np.interp(times, (0.0, 0.5, 1.0), (0.0, 0.25, 1.0))
    assert np.array_equal(np.floor(even * light_paths.TIMES), np.tile(np.arange(light_paths.TIMES), (128, 1)))
    histogram, _ = np.histogram(even[:, 3] * light_paths.TIMES % 1.0, 16, (0.0, 1.0))
    assert np.abs(histogram - 8).max() <= 2


def test_a_moving_picture_does_not_depend_on_threads():
    one, three = (picture(ALWAYS, changing_lamps, threads=threads, size=(48, 36)) for threads in (1, 3))
    assert np.array_equal(one, three)


def test_a_rolling_shutter_leaves_them_off():
    assert np.array_equal(*(picture(each, rolling, samples=2) for each in (WITHOUT, ALWAYS)))


def _metals(scene) -> None:
    """A wall, the ceiling and the shelf are metal."""
    scene.materials.append(material("glossy", "steel", color=(0.9, 0.9, 0.9), roughness=0.1))
    for index in (2, 4, 5):
        scene.instances[index].materials = (len(scene.materials) - 1,)


@pytest.mark.slow
@pytest.mark.parametrize(
    "limit, change",
    [
        (1.0, lambda scene: None),
        *((1.0, _metals), (1.0, _everywhere(SHINY)), (4.0, _metals), (0.2, _everywhere(SHINY))),
    ],
    ids=["glass and coat", "metal", "mirrors", "high limit", "low limit"],
)
def test_filter_glossy_leaves_the_mean(limit, change):
    """With lobes that Filter Glossy blurs, means of the whole and of blocks over 24 renders each agree within 4.5
    standard errors: by chance, one set of seeds in a hundred would not."""
    found = [
        np.array([picture(each, change=change, seed=seed, filter_glossy=limit) for seed in range(24)])
        for each in (WITHOUT, ALWAYS)
    ]
    assert not np.array_equal(*found)
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)


PLASTIC = Node("principled", {"base_color": (0.6, 0.5, 0.4), "roughness": 0.4})


def _only(*lights):
    """Lights take the place of the lamp, above the shelf."""

    def change(scene) -> None:
        scene.lamps.clear()
        scene.lights += lights

    return change


ABOVE, UP = translation(0.0, 1.3, 2.5), look_at((0.0, 1.3, 2.5), (0.0, 1.3, 4.0), (0.0, 1.0, 0.0))
LIGHTS = dict(
    point=PointLight("point", ABOVE, 60.0),
    disk=PointLight("disk", ABOVE, 60.0, radius=0.3),
    ball=PointLight("ball", ABOVE, 60.0, radius=0.3, soft_falloff=False),
    spot=SpotLight("spot", UP, 60.0, angle=1.6, blend=0.3),
    spot_ball=SpotLight("spot ball", UP, 60.0, radius=0.15, soft_falloff=False, angle=1.6, blend=0.3),
    area=AreaLight("area", UP, 60.0, size=(0.8, 0.4)),
    ellipse=AreaLight("ellipse", UP, 60.0, size=(0.8, 0.4), ellipse=True, spread=1.0),
    beam=AreaLight("beam", UP, 60.0, size=(0.8, 0.4), spread=0.0),
)


def _nodes(scene) -> None:
    """The lamp is an area light whose ends are brighter, by its nodes."""
    scene.lamps.clear()
    color = Vector(constant(1.0), abs(POSITION[0]) * 3.0, abs(POSITION[0]))
    scene.lights.append(
        dataclasses.replace(LIGHTS["area"], emission=Material("gobo", Node("emission", {"color": color})))
    )


def _panel(strength):
    """The lamp is a panel that glows to both sides, with this strength."""

    def change(scene) -> None:
        scene.lamps.clear()
        node = Node("emission", {"color": (1.0, 0.9, 0.8), "strength": strength})
        add(scene, 0, translation(0.0, 1.3, 2.5) @ scaling(0.5, 0.2, 1.0), Material("glow", node))

    return change


@pytest.mark.slow
@pytest.mark.parametrize("strength", [30.0, 30.0 * BACKFACING], ids=["both sides", "one side"])
def test_light_paths_of_meshes_leave_the_mean(strength):
    """As those of lights."""
    found = [
        np.array([picture(each, change=_panel(strength), seed=seed) for seed in range(24)])
        for each in (WITHOUT, ALWAYS)
    ]
    assert not np.array_equal(*found)
    one, other = (means(each)[1] for each in found)
    error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
    assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error)
    noise = [np.median(each.var(axis=0, ddof=1)) for each in found]
    assert noise[1] < 0.7 * noise[0]


@pytest.mark.slow
@pytest.mark.parametrize("light", LIGHTS)
def test_light_paths_of_lights_leave_the_mean(light):
    """Means of the whole over 24 renders each agree within 4.5 standard errors: by chance, one set of seeds in ten
    thousand would not. Without light paths, many blocks get no light in any of so few samples, so they say nothing.
    There is glass before the light, which rays pass by chance and light rays do not."""
    found = [
        np.array([picture(each, change=_only(LIGHTS[light]), seed=seed) for seed in range(24)])
        for each in (WITHOUT, ALWAYS)
    ]
    assert not np.array_equal(*found)
    one, other = (means(each)[1] for each in found)
    error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
    assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error)


@pytest.mark.parametrize(
    "change",
    [
        _lamp(visibility=Ray.ALL & ~Ray.CAMERA),
        pytest.param(_object(visibility=Ray.CAMERA), marks=pytest.mark.slow),
    ],
)
def test_what_the_camera_alone_does_or_does_not_see_leaves_them_on(change):
    found = [np.array([picture(each, change=change, seed=seed) for seed in range(12)]) for each in (WITHOUT, ALWAYS)]
    one, other = (each.mean(axis=(1, 2, 3)) for each in found)
    assert not np.array_equal(one, other)
    assert abs(one.mean() - other.mean()) < 4.0 * np.sqrt((one.var(ddof=1) + other.var(ddof=1)) / 12)


def _sheet(scene) -> None:
    """The shelf is a translucent sheet, which carries most of the light."""
    scene.materials[scene.instances[5].materials[0]] = material("translucent", "sheet", color=(0.8, 0.8, 0.8))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "less"),
    [(_everywhere(PLASTIC), 0.4), (_sheet, 0.5), (_nodes, 0.7)],
    ids=["rough lobes", "translucent", "light with nodes"],
)
def test_they_take_over_the_light_of(change, less):
    """Means of the whole and of blocks over 24 renders each agree within 4.5 standard errors: by chance, one set of
    seeds in a hundred would not. And this part of the noise is left."""
    fixed = dict(samples=16, indirect_paths=4, guided_samples=False)
    found = [
        np.array([picture(each, change=change, seed=seed, **fixed) for seed in range(24)]) for each in (WITHOUT, ALWAYS)
    ]
    for one, other in zip(*(means(each) for each in found)):
        error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(one))
        assert np.all(np.abs(other.mean(axis=0) - one.mean(axis=0)) < 4.5 * error + 1e-9)
    noise = [np.median(each.var(axis=0, ddof=1)) for each in found]
    assert noise[1] < less * noise[0]


def _pilot(
    whole: float, before: float = 0.0, time: float = 1.0, time_before: float = 1.0, branches: float = 1.0
) -> pilot.Pilot:
    """Of samples with these variances, and these times after they split and before."""
    noise = np.random.default_rng(1).chisquare(1, 4000)
    return pilot.Pilot(np.full(4000, 2.0), whole * noise, before * noise, time_before, time, branches)


def test_gain_is_error_times_time():
    assert pilot.gain(_pilot(4.0), _pilot(1.0)) == pytest.approx(4.0)
    assert pilot.gain(_pilot(4.0), _pilot(4.0, time=2.0)) == pytest.approx(0.5)
    assert pilot.gain(_pilot(4.0), _pilot(0.0)) == 0.0  # black with light paths: nothing is known


def test_gain_is_that_of_the_best_number_of_branches():
    """However many branches the pilot has."""
    without, connected = (1.0, 5.0, 2.0, 3.0), (1.0, 2.0, 4.0, 3.0)  # variances before and of a branch, and times
    numbers = np.linspace(0.1, 100.0, 100_000)
    best = [((a + b / numbers) * (d + numbers * c)).min() for a, b, c, d in (without, connected)]
    found = {
        branches: pilot.gain(*(_pilot(a + b / branches, a, branches * c, d) for a, b, c, d in (without, connected)))
        for branches in (1, 3, 16)
    }
    assert list(found.values()) == pytest.approx([best[0] / best[1]] * 3, rel=1e-3)


def test_gain_of_whole_paths():
    """However many branches the pilot has, the figures are those of one."""
    without, connected = (1.0, 5.0, 2.0, 3.0), (1.0, 2.0, 4.0, 3.0)  # as above
    whole = [(a + b) * (d + c) for a, b, c, d in (without, connected)]
    for k in (1, 3, 16):
        pilots = [_pilot(a + b / k, a, k * c, d, k) for a, b, c, d in (without, connected)]
        assert pilot.gain(*pilots, splits=False) == pytest.approx(whole[0] / whole[1])


def test_a_few_bright_pixels_do_not_decide():
    without, rare = _pilot(1.0), np.zeros(4000)
    rare[:4] = 1e6
    assert pilot.gain(dataclasses.replace(without, whole=without.whole + rare), without) == pytest.approx(1.0, rel=0.02)
    assert pilot.gain(without, dataclasses.replace(without, whole=0.1 * without.whole + rare)) < 1.0


def test_noise_of_direct_light_promises_nothing():
    assert pilot.may_be_worthwhile(_pilot(4.0, 0.1))
    assert not pilot.may_be_worthwhile(_pilot(4.0, 3.9))
    assert not pilot.may_be_worthwhile(_pilot(0.0))


def test_pilot_pixels_are_few_and_even():
    film = Film(torus_room(100, 80))
    film.active[:4000] = 0
    found = pilot.pilot_pixels(film, 16)
    assert found.sum() == pytest.approx(pilot.PART * 16 * 4000, abs=2) and not found[:4000].any()
    assert abs(int(found[4000:6000].sum()) - int(found[6000:].sum())) <= 2
    assert pilot.pilot_pixels(film, 1) is None


def test_a_film_that_is_cleared_is_as_new():
    scene = torus_room(16, 12)
    scene.settings.samples = 4
    film = session.render(scene, ("Depth", "Normal"))
    fresh = Film(scene, ("Depth", "Normal"))
    film.clear()
    for name in film.passes:
        assert np.array_equal(film.read(name), fresh.read(name))
    assert film.samples == 0 and not film.squares.any() and not film.divided.any()
