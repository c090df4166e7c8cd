# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of the reference: irradiance in closed form, and agreement of sampling with hits. Bounds are 4.4 standard
errors (confidence 0.99999 each), seeds are fixed."""

import numpy as np
import pytest

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.reference.lights import Sky, blender_light
from sdf_lights.render.reference.vectors import uniform_sphere
from sdf_lights.render.scene import Camera, Scene, World
from support import scenes

SIGMAS = 4.4
DOWN = scenes.look_at((0, 0, 0), (0, 0, -1), (0, 1, 0))


def irradiance(light, x, n, count=40_000):
    """(mean, standard error) of ∫ L cos over directions above the point x with normal n."""
    rng = np.random.Generator(np.random.Philox(5))
    wi, _, radiance, pdf = light.sample(rng, np.tile(np.asarray(x, float), (count, 1)))
    values = radiance[:, 0] * np.maximum(wi @ n, 0.0) * np.where(pdf > 0.0, 1.0 / np.where(pdf > 0.0, pdf, 1.0), 0.0)
    return values.mean(), values.std() / np.sqrt(count)


def close(measured, expected):
    mean, error = measured
    assert abs(mean - expected) <= SIGMAS * error + 1e-9 * expected, (mean, error, expected)


UP = np.array([0.0, 0.0, 1.0])


def test_point_light_falls_off_with_the_square_of_the_distance():
    light = blender_light(PointLight("p", scenes.translation(1, 0, 2), 4 * np.pi * 3.0))
    close(irradiance(light, (0, 0, 0), UP), 3.0 / 5.0 * 2.0 / np.sqrt(5.0))


@pytest.mark.parametrize("distance", [0.6, 1.0, 5.0])
def test_sphere_light_is_a_point_light_to_what_faces_it(distance):
    matrix = scenes.translation(0, 0, distance)
    light = blender_light(PointLight("p", matrix, 4 * np.pi, radius=0.5, soft_falloff=False))
    close(irradiance(light, (0, 0, 0), UP), 1.0 / distance**2)


def test_inside_a_sphere_light_irradiance_is_pi_times_radiance():
    light = blender_light(PointLight("p", np.eye(4), 4 * np.pi**2 * 0.25, radius=0.5, soft_falloff=False))
    close(irradiance(light, (0.1, 0.2, 0), UP), np.pi)


def test_soft_point_light_is_a_disk_that_faces_the_point():
    light = blender_light(PointLight("p", scenes.translation(0, 0, 2), 4 * np.pi, radius=0.5))
    close(irradiance(light, (0, 0, 0), UP), 1.0 / (2.0**2 + 0.25))


def test_spot_light():
    light = blender_light(SpotLight("s", scenes.translation(0, 0, 2) @ DOWN, 4 * np.pi, angle=1.0, blend=0.5))
    close(irradiance(light, (0, 0, 0), UP), 1.0 / 4.0)
    assert irradiance(light, (2 * np.tan(0.51), 0, 0), UP)[0] == 0.0
    middle = np.cos(0.5) + 0.5 * 0.5 * (1 - np.cos(0.5))  # where the smooth step is a half
    x = 2 * np.tan(np.arccos(middle))
    close(irradiance(light, (x, 0, 0), UP), 0.5 / (4 + x * x) * 2 / np.hypot(2, x))


@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_sun_gives_its_strength_as_irradiance(angle):
    close(irradiance(blender_light(SunLight("s", np.eye(4), 2.5, angle=angle)), (0, 0, 0), UP), 2.5)


def test_disk_light():
    """A disk of radius r and radiance L on the axis at height h: E = π L r² / (r² + h²)."""
    matrix = scenes.translation(0, 0, 1.5) @ DOWN
    light = blender_light(AreaLight("a", matrix, 5.0, ellipse=True, size=(2.0, 2.0)))
    close(irradiance(light, (0, 0, 0), UP), np.pi * 5.0 / (np.pi * np.pi) / (1 + 1.5**2))
    assert irradiance(light, (0, 0, 3), -UP)[0] == 0.0


def test_rectangle_light():
    """Parallel rectangle above the point below its corner: the form factor of the textbook."""
    light = blender_light(AreaLight("a", scenes.translation(0.5, 1.0, 1.0) @ DOWN, 2.0, size=(1.0, 2.0)))
    a, b = 1.0, 2.0
    p, q = np.hypot(1, a), np.hypot(1, b)
    factor = (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / 2
    close(irradiance(light, (0, 0, 0), UP), 2.0 / (np.pi * 2.0) * factor)


def test_spread_keeps_the_power():
    """Flux through a large plane in front of the light, by irradiance at random points of it."""
    light = blender_light(AreaLight("a", scenes.translation(0, 0, 1) @ DOWN, 3.0, size=(0.1, 0.1), spread=1.0))
    rng = np.random.Generator(np.random.Philox(6))
    count, half = 200_000, 1.0
    x = np.concatenate([rng.uniform(-half, half, (count, 2)), np.zeros((count, 1))], 1)
    wi, _, radiance, pdf = light.sample(rng, x)
    values = (2 * half) ** 2 * radiance[:, 0] * wi[:, 2] / pdf
    assert abs(values.mean() - 3.0) < SIGMAS * values.std() / np.sqrt(count)


def test_a_spread_of_zero_is_a_parallel_beam():
    """Power over area is the irradiance below the light, and nothing beside it."""
    light = blender_light(AreaLight("a", scenes.translation(0, 0, 1) @ DOWN, 3.0, size=(0.5, 0.5), spread=0.0))
    close(irradiance(light, (0.1, 0.2, -5), UP), 3.0 / 0.25)
    assert irradiance(light, (0.3, 0.0, -5), UP)[0] == 0.0


LIGHTS = {
    "ball": PointLight("p", scenes.translation(0.2, 0.1, 1.5), 10.0, radius=0.4, soft_falloff=False),
    "disk": PointLight("p", scenes.translation(0.2, 0.1, 1.5), 10.0, radius=0.4),
    "spot": SpotLight("p", scenes.translation(0.2, 0.1, 1.5) @ DOWN, 10.0, radius=0.4, angle=0.5),
    "sun": SunLight("s", scenes.look_at((0, 0, 0), (1, 2, 3)), 2.0, angle=0.7),
    "rectangle": AreaLight("a", scenes.translation(0.2, 0.1, 1.5) @ DOWN, 10.0, size=(0.5, 1.0)),
    "ellipse": AreaLight(
        "a", scenes.translation(0.2, 0.1, 1.5) @ DOWN, 10.0, ellipse=True, size=(0.5, 1.0), spread=2.0
    ),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_a_sampled_ray_hits_the_light_with_the_same_radiance_distance_and_density(name):
    light, x = blender_light(LIGHTS[name]), np.tile([0.3, 0.2, 0.1], (2000, 1))
    wi, distance, radiance, pdf = light.sample(np.random.Generator(np.random.Philox(7)), x)
    reached, seen, density = light.hit(x, wi)
    # A sample at the rim may miss by a rounding error.
    found = np.isfinite(reached)
    assert found.mean() > 0.99
    np.testing.assert_allclose(seen[found], radiance[found], rtol=1e-6)
    np.testing.assert_allclose(density[found], pdf[found], rtol=1e-6)
    if name != "sun":
        np.testing.assert_allclose(reached[found], distance[found], rtol=1e-6)


@pytest.mark.parametrize("name", LIGHTS)
def test_densities_integrate_to_one(name):
    light = blender_light(LIGHTS[name])
    count = 100_000
    directions = uniform_sphere(np.random.Generator(np.random.Philox(8)), count)
    _, _, density = light.hit(np.tile([0.3, 0.2, 0.1], (count, 1)), directions)
    values = 4 * np.pi * density
    assert abs(values.mean() - 1.0) < SIGMAS * values.std() / np.sqrt(count)


def test_sky_image_is_sampled_with_its_density_and_turned_as_the_world():
    scene = Scene(Camera(np.eye(4)), 1, 1, images=[scenes.sky_image()])
    turn = scenes.rotation("z", 70)[:3, :3]
    sky = Sky(World((1.0, 1.0, 1.0), 2.0, 0, turn), scene)
    rng = np.random.Generator(np.random.Philox(9))
    wi, _, radiance, pdf = sky.sample(rng, np.zeros((50_000, 3)))
    everywhere = uniform_sphere(rng, 200_000)
    by_light, by_chance = radiance[:, 0] / pdf, 4 * np.pi * sky.radiance(everywhere)[:, 0]
    error = np.hypot(by_light.std() / np.sqrt(len(wi)), by_chance.std() / np.sqrt(len(everywhere)))
    assert abs(by_light.mean() - by_chance.mean()) < SIGMAS * error
    values = 4 * np.pi * sky.pdf(everywhere)
    assert abs(values.mean() - 1.0) < SIGMAS * values.std() / np.sqrt(len(values))
    # The middle of the image is the direction +x of the image's space; v grows with z.
    x = np.linalg.inv(turn) @ [1.0, 0.0, 0.0]
    expected = 2.0 * scene.images[0].pixels[15:17, 31:33, :3].mean((0, 1))
    np.testing.assert_allclose(sky.radiance(x[None])[0], expected, rtol=1e-6)
