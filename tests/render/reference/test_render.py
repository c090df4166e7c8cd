# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole renders of the reference whose pictures are known. Seeds are fixed; error bars are 4.4 standard errors
(confidence 0.99999 each)."""

import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.film import Film
from sdf_lights.render.lights.point import PointLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.passes import BY_NAME
from sdf_lights.render.reference.integrator import Integrator
from sdf_lights.render.reference.renderer import ReferenceRenderer
from sdf_lights.render.scene import Lamp, Ray, Scene, World
from sdf_lights.render.settings import Device, Filter
from sdf_lights.sdf import shapes
from support import scenes
from support.graphs import Graph


def trace(scene, samples, seed=0):
    """One row of samples for each pixel: (samples, height · width) of every field."""
    y, x = np.divmod(np.arange(scene.width * scene.height), scene.width)
    rng = np.random.Generator(np.random.Philox(seed))
    return Integrator(scene).trace(np.tile(x, samples), np.tile(y, samples), rng)


def mean_and_error(values):
    return values.mean(), values.std() / np.sqrt(len(values))


def looking_at(mesh, material, world=(1.0, 1.0, 1.0), **settings):
    """A mesh in the middle of the frame, under an even sky."""
    scene = Scene(
        scenes.camera((0, -4, 1), (0, 0, 0), 8, 8, 0.2),
        8,
        8,
        world=World(world),
        settings=scenes.settings(
            max_bounces=64, diffuse_bounces=64, glossy_bounces=64, transmission_bounces=64, **settings
        ),
    )
    scene.meshes = [mesh]
    scenes.add(scene, 0, np.eye(4), material)
    return scene


@pytest.mark.parametrize(
    "material",
    [
        scenes.material("glass"),
        scenes.material("transparent"),
        scenes.material("glossy", color=(1.0, 1.0, 1.0), roughness=0.0),
    ],
    ids=["glass", "transparent", "mirror"],
)
def test_a_lossless_singular_box_vanishes_in_an_even_sky(material):
    """White furnace, exact in every sample."""
    samples = trace(looking_at(scenes.box(), material), 50)
    np.testing.assert_allclose(samples.combined, 1.0, rtol=1e-9)


@pytest.mark.parametrize("kind", ["diffuse", "translucent"])
def test_a_white_diffuse_box_vanishes_in_an_even_sky(kind):
    scene = looking_at(scenes.box(), scenes.material(kind, color=(1.0, 1.0, 1.0)))
    mean, error = mean_and_error(trace(scene, 100).combined[:, 0])
    assert abs(mean - 1.0) < 4.4 * error and error < 0.01


@pytest.mark.parametrize(
    "material",
    [
        scenes.material("glossy", color=(1.0, 1.0, 1.0), roughness=0.6),
        scenes.material("glass", roughness=0.5),
        scenes.material("principled", base_color=(1.0, 1.0, 1.0), metallic=1.0, roughness=0.5),
        scenes.material("principled", base_color=(1.0, 1.0, 1.0), roughness=0.4, sheen_weight=0.5, coat_weight=0.5),
    ],
    ids=["glossy", "frosted glass", "metal", "layers"],
)
def test_compensated_and_layered_white_keeps_its_energy(material):
    """White furnace on a ball; albedo tables and layering are good to one per cent of the mean."""
    mean, error = mean_and_error(trace(looking_at(scenes.sphere(columns=32, rows=16), material), 60).combined.mean(1))
    assert abs(mean - 1.0) < 0.01 + 4.4 * error


@pytest.mark.parametrize("background", [(0.0, 0.0, 0.0), (0.5, 0.5, 0.5)])
def test_the_camera_sees_chord_times_density(background):
    scene = Scene(
        scenes.camera((0, -3, 0), (0, 0, 0), 1, 1, 1e-6), 1, 1, world=World(background), settings=scenes.settings()
    )
    scene.lamps = [Lamp("ball", shapes.Sphere(radius=0.7), scenes.translation(0, 0, 0), density=1.5)]
    samples = trace(scene, 4)
    np.testing.assert_allclose(samples.combined, 2 * 0.7 * 1.5 + background[0], rtol=1e-8)
    np.testing.assert_allclose(samples.lamps, 2 * 0.7 * 1.5, rtol=1e-8)
    np.testing.assert_allclose(samples.emission, samples.lamps)
    np.testing.assert_allclose(samples.environment, background[0])


def floor(light=None, lamp=None, albedo=1.0):
    """A pixel that sees one point of a diffuse floor, lit by one light."""
    scene = Scene(scenes.camera((0, -3, 3), (0, 0, 0), 1, 1, 1e-7), 1, 1, settings=scenes.settings(max_bounces=0))
    scene.meshes = [scenes.quad()]
    scenes.add(scene, 0, scenes.scaling(5, 5, 1), scenes.diffuse((albedo,) * 3))
    scene.lights, scene.lamps = [light] * (light is not None), [lamp] * (lamp is not None)
    return scene


def test_radiance_of_a_diffuse_floor_under_a_point_light():
    samples = trace(floor(PointLight("p", scenes.translation(1, 0, 2), 4 * np.pi * 3), albedo=0.5), 3)
    np.testing.assert_allclose(samples.combined, 0.5 / np.pi * 3 / 5 * 2 / np.sqrt(5), rtol=1e-6)


def test_radiance_of_a_diffuse_floor_under_a_torus_lamp():
    """The published irradiance of a torus, through the whole integrator and its MIS."""
    matrix = np.diag([1.0, 1.0, -1.0, 1.0]) @ scenes.translation(-0.4, -0.2, -1.6)
    lamp = Lamp("torus", shapes.Torus(major_radius=1.0, minor_radius=0.35), matrix, power=4 * np.pi)
    samples = trace(floor(lamp=lamp), 30_000)
    mean, error = mean_and_error(np.pi * (samples.combined - samples.emission)[:, 0])  # the camera looks past the lamp
    assert abs(mean - 0.22912) < 4.4 * error + 1e-5 and error < 1e-3


def test_glass_slab_transmits_what_fresnel_says():
    """Straight through a slab, all internal reflections summed: T = (1 − R) / (1 + R)."""
    scene = Scene(
        scenes.camera((0, -3, 0), (0, 0, 0), 1, 1, 1e-7),
        1,
        1,
        meshes=[scenes.box(), scenes.quad()],
        settings=scenes.settings(max_bounces=64, transmission_bounces=64, glossy_bounces=64),
    )
    scenes.add(scene, 0, scenes.scaling(2, 0.1, 2), scenes.material("glass", ior=1.5))
    scenes.add(scene, 1, scenes.translation(0, 3, 0) @ scenes.rotation("x", 90), scenes.material("emission"))
    mean, error = mean_and_error(trace(scene, 20_000).combined[:, 0])
    assert abs(mean - 0.96 / 1.04) < 4.4 * error


def test_emissive_triangles_give_the_same_light_by_either_strategy():
    sampled, hit = scenes.emissive_mesh(12, 9), scenes.emissive_mesh(12, 9)
    for material in hit.materials:
        material.sample_emission = False
    (a, e), (b, f) = (mean_and_error(trace(scene, 60).combined.mean(1)) for scene in (sampled, hit))
    assert abs(a - b) < 4.4 * np.hypot(e, f)


def test_an_emissive_triangle_seen_at_a_grazing_angle_is_not_in_its_own_shadow():
    """A square of a metre, 5 cm above the floor and a metre away: 0.5 / pi times the integral of cos cos / r2."""
    scene = floor(albedo=0.5)
    scenes.add(
        scene,
        0,
        scenes.translation(1.5, 0.0, 0.05) @ scenes.scaling(0.5, 0.5, 1),
        scenes.material("emission", strength=9.0),
    )
    mean, error = mean_and_error(trace(scene, 4000).combined[:, 0])
    x, y = np.meshgrid(1.0 + (np.arange(500) + 0.5) / 500, (np.arange(500) + 0.5) / 500 - 0.5)
    expected = 0.5 / np.pi * 9.0 * np.mean(0.05**2 / (x * x + y * y + 0.05**2) ** 2)
    assert abs(mean - expected) < 4.4 * error and error < 0.02 * expected


def test_more_emitters_than_are_sampled_at_a_vertex():
    """Twenty point lights of which eight are drawn: the same mean as the sum of the lights one by one."""
    lights = [PointLight("p", scenes.translation(0.2 * i - 2, 0.5, 1.5), 5.0 + i) for i in range(20)]
    scene = floor(lights[0])
    scene.lights = lights
    mean, error = mean_and_error(trace(scene, 4000).combined[:, 0])
    expected = sum(trace(floor(light), 1).combined[0, 0] for light in lights)
    assert abs(mean - expected) < 4.4 * error


def test_a_lamp_hidden_from_some_scattered_rays_still_lights_by_sampling():
    """Hidden from glossy rays it gives a diffuse floor the same direct light, and the camera sees none of it; hidden
    from diffuse ones it gives none."""

    def picture(visibility):
        matrix = scenes.translation(0, 0.5, 1.5)
        lamp = Lamp("ball", shapes.Sphere(radius=0.5), matrix, power=20.0, visibility=visibility)
        samples = trace(floor(lamp=lamp), 10_000)
        return mean_and_error((samples.combined - samples.emission)[:, 0])

    (a, e), (b, f) = picture(Ray.ALL), picture(Ray.ALL & ~Ray.GLOSSY & ~Ray.CAMERA)
    assert abs(a - b) < 4.4 * np.hypot(e, f) and a > 0.1
    assert picture(Ray.ALL & ~Ray.DIFFUSE)[0] == 0.0


def test_transparent_film_and_alpha():
    scene = looking_at(scenes.quad(), scenes.material("transparent", color=(0.25, 0.25, 0.25)), transparent_film=True)
    samples = trace(scene, 20)
    through = samples.alpha < 1.0
    assert through.any()
    assert set(np.round(samples.alpha, 12)) <= {0.0, 0.75}
    np.testing.assert_array_equal(samples.combined, 0.0)


def render(scene, **settings):
    scene.settings.device = Device.REFERENCE
    for name, value in settings.items():
        setattr(scene.settings, name, value)
    return session.render(scene, tuple(BY_NAME))


def test_a_session_renders_all_passes_and_repeats_itself():
    films = [render(scenes.textured(12, 9), samples=4, seed=seed) for seed in (1, 1, 2)]
    first, again, other = (film.read("Combined") for film in films)
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    for name, item in BY_NAME.items():
        values = films[0].read(name)
        assert values.shape == (9, 12, len(item.channels)) and np.isfinite(values).all(), name
    assert (films[0].read("Sample Count") == 4).all()


def test_border_renders_the_same_place():
    whole, part = scenes.torus_room(16, 12), scenes.torus_room(16, 12)
    part.border = (4, 2, 10, 9)
    narrow = dict(samples=1, filter=Filter.GAUSSIAN, filter_width=0.01)  # all but the pixel's centre
    positions = render(whole, **narrow).read("Position")
    np.testing.assert_allclose(render(part, **narrow).read("Position"), positions[2:9, 4:10], atol=0.05)
    assert positions.std() > 0.3


def test_stopping_keeps_what_was_done():
    scene = scenes.torus_room(8, 6)
    film = Film(scene)
    renderer = ReferenceRenderer(scene, film)
    assert renderer.sample(0, 2, lambda: False, lambda part: None)
    assert not renderer.sample(2, 2, lambda: True, lambda part: None)
    assert film.samples == 2 and (film.count == 2).all()


@pytest.mark.parametrize("spoil", ["empty", "no faces", "flat lamp", "nan lamp", "no material", "missing image"])
def test_odd_scenes_render(spoil):
    scene = scenes.torus_room(6, 4)
    if spoil == "empty":
        scene.meshes, scene.instances, scene.lamps = [], [], []
    elif spoil == "no faces":
        scene.meshes[1].triangles = np.zeros((0, 3), np.int32)
        scene.meshes[1].slots = None
    elif spoil == "flat lamp":
        scene.lamps[0].matrix = np.diag([1.0, 1.0, 0.0, 1.0])
    elif spoil == "nan lamp":
        scene.lamps[0].matrix = np.full((4, 4), np.nan)
    elif spoil == "no material":
        scene.materials[0] = Material("none")
    else:
        graph = Graph()
        scene.materials[0] = graph.material("image", Node("diffuse", {"color": graph.image(3)}))
    film = render(scene, samples=2)
    assert np.isfinite(film.read("Combined")).all() and not film.discarded.any()
    assert ("lamp" in spoil) == any("'torus'" in warning for warning in scene.warnings)
