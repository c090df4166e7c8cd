# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of every light follow the pdf that a ray which hits it is given, and that pdf integrates to 1."""

import math

import numpy as np
import pytest

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.scene import Image, Portal, World
from support.chi2 import chi2_sphere
from tests.render.lights.harness import UP, Packed, place, scene_of

# name: light, lit point, whether every sample meets light
LIGHTS = {
    "sphere": (PointLight("", place(0, 0, 2), 10.0, radius=0.5, soft_falloff=False), (0.3, 0.1, 0.0), True),
    "sphere, close": (PointLight("", place(0, 0, 2), 10.0, radius=0.5, soft_falloff=False), (0, 0, 1.499), True),
    "inside the sphere": (PointLight("", place(), 10.0, radius=1.0, soft_falloff=False), (0.3, 0.1, 0.4), True),
    "disk to the point": (PointLight("", place(0, 0, 2), 10.0, radius=1.5), (0.5, 0, 1.0), True),
    "spot": (SpotLight("", place(0, 0, 2), 10.0, radius=0.4, angle=1.2, blend=0.5), (0.6, 0.2, 0.0), True),
    "narrow wide spot": (
        SpotLight("", place(0, 0, 2), 10.0, radius=1.0, angle=0.2, soft_falloff=False),
        (0.2, 0, 0),
        False,
    ),
    "elliptic spot": (
        SpotLight("", place(0, 0, 2, scale=(2, 1, 1.5)), 10.0, radius=1.0, angle=0.3),
        (0.2, 0.1, 0),
        False,
    ),
    "rectangle": (AreaLight("", place(0, 0, 2), 10.0, size=(2.0, 1.0)), (0.7, -0.2, 0.0), True),
    "rectangle, close": (AreaLight("", place(0, 0, 2), 10.0, size=(2.0, 1.0)), (0.9, 0.2, 1.99), True),
    "rectangle, grazing": (AreaLight("", place(0, 0, 2), 10.0, size=(2.0, 1.0)), (3.0, 0.2, 1.9), True),
    "rectangle, spread": (AreaLight("", place(0, 0, 2), 10.0, size=(2.0, 1.0), spread=1.0), (0.7, -0.2, 0.0), False),
    "disk": (AreaLight("", place(0, 0, 2), 10.0, ellipse=True), (0.9, 0.1, 1.0), True),
    "disk on its axis": (AreaLight("", place(0, 0, 2), 10.0, ellipse=True), (0.0, 0.0, 1.0), True),
    "ellipse": (AreaLight("", place(0, 0, 2), 10.0, ellipse=True, size=(3.0, 0.5)), (0.9, 0.1, 1.0), True),
    "ellipse, close": (AreaLight("", place(0, 0, 2), 10.0, ellipse=True, size=(3.0, 0.5)), (1.4, 0.05, 1.6), True),
    "ellipse, far": (AreaLight("", place(0, 0, 600), 10.0, ellipse=True, size=(3.0, 0.5)), (1.4, 0.05, 0.0), True),
    "ellipse, spread": (
        AreaLight("", place(0, 0, 2), 10.0, ellipse=True, size=(2.0, 1.5), spread=1.3),
        (0.7, -0.2, 0.0),
        False,
    ),
    "sun": (SunLight("", place(axis=(1, 0, 1)), 3.0, angle=0.2), (0, 0, 0), True),
    "wide sun": (SunLight("", place(axis=(1, 0, 1)), 3.0, angle=3.0), (0, 0, 0), True),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_samples_follow_the_pdf(name):
    light, x, complete = LIGHTS[name]
    packed = Packed(scene_of(light))
    axis = np.nanmean(packed.sample(0, x, np.random.default_rng(1).random((256, 2)))[0], axis=0)
    # Rims cut through the bins, so the expected counts need a fine quadrature.
    result = chi2_sphere(
        lambda u: packed.sample(0, x, u)[0],
        lambda d: packed.hits(0, x, d)[2],
        60_000,
        5,
        confidence=0.9999,
        dimensions=2,
        axis=axis,
        bins=(12, 12),
        quadrature=64,
    )
    assert result.passed, result
    if complete:
        assert result.lost == 0
        assert abs(result.integral - 1.0) < 5.0 * result.integral_error + 2e-3, result


@pytest.mark.parametrize("name", LIGHTS)
def test_a_ray_along_a_sample_finds_the_same_light(name):
    light, x, _ = LIGHTS[name]
    packed = Packed(scene_of(light))
    wi, distance, radiance, pdf, singular = packed.sample(0, x, np.random.default_rng(2).random((2000, 2)))
    lit = np.isfinite(wi[:, 0])
    assert lit.any() and not singular.any()
    hit_distance, hit_radiance, hit_pdf = packed.hits(0, x, wi[lit])
    # A direction at the very rim may miss.
    met = hit_pdf > 0.0
    assert met.mean() > 0.998
    np.testing.assert_allclose(hit_distance[met], distance[lit][met], rtol=1e-5)
    np.testing.assert_allclose(hit_radiance[met], radiance[lit][met], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(hit_pdf[met], pdf[lit][met], rtol=1e-6)


@pytest.mark.parametrize("name", ["sphere", "rectangle", "disk", "rectangle, close", "rectangle, grazing"])
def test_density_is_uniform_in_solid_angle(name):
    light, x, _ = LIGHTS[name]
    pdf = Packed(scene_of(light)).sample(0, x, np.random.default_rng(3).random((500, 2)))[3]
    # A disk aside its axis shows an elliptic cone, whose density is only nearly uniform.
    assert np.ptp(pdf) <= (0.05 if name == "disk" else 1e-9) * pdf.max()


def test_density_of_extreme_ellipses_stays_near_uniform():
    for size, x in (((40.0, 0.4), (0, 0, 1.8)), ((40.0, 0.4), (15.0, 0.0, 1.5)), ((1.0, 1.0), (0.49, 0, 1.99))):
        packed = Packed(scene_of(AreaLight("", place(0, 0, 2), 10.0, ellipse=True, size=size)))
        _, _, _, pdf, _ = packed.sample(0, x, np.random.default_rng(3).random((5000, 2)))
        omega = np.mean(1.0 / pdf)
        assert np.std(1.0 / pdf) < 0.5 * omega


@pytest.mark.parametrize("x", [(0.0, 0.0, 0.0), (0.5, 0.3, 1.5)])
def test_the_world_through_portals(x):
    """Two that face the points, and one that does not."""
    packed = Packed(
        scene_of(
            world=World((0.5, 0.25, 1.0), 2.0),
            portals=[
                Portal("", place(0, 0, 2), size=(2.0, 1.0)),
                Portal("", place(-2, 0, 1, axis=(-1, 0, 0)), ellipse=True, size=(1.0, 1.5)),
                Portal("", place(2, 0, 1, axis=(-1, 0, 0)), size=(1.0, 1.0)),
            ],
        )
    )
    assert packed.tables["light_header"]["portal_count"] == 3
    result = chi2_sphere(
        lambda u: packed.sample(0, x, u, UP)[0],
        lambda d: packed.world(d, UP, x)[1],
        60_000,
        6,
        0.9999,
        dimensions=2,
        bins=(12, 12),
        quadrature=64,
    )
    assert result.passed and abs(result.integral - 1.0) < 5.0 * result.integral_error + 5e-3, result


@pytest.mark.parametrize("n", [UP, (0.0, 0.0, 0.0), (0.6, 0.0, -0.8)])
def test_colour_of_the_world(n):
    packed = Packed(scene_of(world=World((0.5, 0.25, 1.0), 2.0)))
    result = chi2_sphere(
        lambda u: packed.sample(0, (0, 0, 0), u, n)[0], lambda d: packed.world(d, n)[1], 60_000, 6, 0.9999, dimensions=2
    )
    assert result.passed and result.lost == 0, result
    assert abs(result.integral - 1.0) < 5.0 * result.integral_error + 1e-3
    wi, distance, radiance, pdf, _ = packed.sample(0, (0, 0, 0), np.random.default_rng(4).random((100, 2)), n)
    np.testing.assert_allclose(radiance, np.tile((1.0, 0.5, 2.0), (100, 1)))
    np.testing.assert_allclose(pdf, packed.world(wi, n)[1])
    assert np.isinf(distance).all()


def hdr(height=16, width=32):
    pixels = np.zeros((height, width, 4), np.float32)
    pixels[..., :3] = np.random.default_rng(7).random((height, width, 3)) * 0.2
    pixels[4:6, 10:20, :3] = 0.0
    pixels[12, 5, :3] = (500.0, 400.0, 300.0)
    return Image("hdr", pixels)


def rotation():
    a, b = 0.7, 1.1
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]]
    )


def environment():
    return Packed(scene_of(images=[hdr()], world=World((1.0, 1.0, 1.0), 1.0, 0, rotation())))


def test_samples_of_an_image_follow_the_pdf():
    packed = environment()
    axis = rotation().T @ (0.0, 0.0, 1.0)
    result = chi2_sphere(
        lambda u: packed.sample(0, (0, 0, 0), u, dark=True)[0],
        lambda d: packed.world(d)[1],
        60_000,
        8,
        0.9999,
        dimensions=2,
        axis=axis,
        bins=(24, 32),
        quadrature=16,
    )
    assert result.passed and result.lost == 0, result
    assert abs(result.integral - 1.0) < 5.0 * result.integral_error + 2e-3


def test_image_is_sampled_where_it_shines_and_without_bias():
    packed = environment()
    rng = np.random.default_rng(9)
    d = rng.normal(size=(200_000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    radiance, pdf = packed.world(d)
    assert (pdf[radiance.max(axis=1) > 0.0] > 0.0).all()

    # Total of the filtered image, by quadrature far finer than its pixels.
    z = (np.arange(800) + 0.5) / 400 - 1.0
    phi = (np.arange(1600) + 0.5) / 1600 * 2.0 * np.pi
    z, phi = (a.ravel() for a in np.meshgrid(z, phi))
    s = np.sqrt(1.0 - z * z)
    local = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
    truth = packed.world(local @ rotation())[0].mean(axis=0) * 4.0 * np.pi

    wi, _, radiance, pdf, _ = packed.sample(0, (0, 0, 0), rng.random((100_000, 2)))
    lit = np.isfinite(wi[:, 0])
    value = np.where(lit[:, None], radiance / pdf[:, None], 0.0)
    error = value.std(axis=0) / math.sqrt(len(value))
    assert (error < 0.005 * truth).all()
    assert (np.abs(value.mean(axis=0) - truth) < 4.0 * error).all()  # four standard errors
    np.testing.assert_allclose(packed.world(wi[lit])[0], radiance[lit], rtol=1e-6)


def test_image_lies_as_in_cycles():
    pixels = np.zeros((4, 8, 4), np.float32)
    pixels[2, 4, 0] = 1.0  # right of the middle, above the equator
    packed = Packed(scene_of(images=[Image("", pixels)], world=World((1, 1, 1), 1.0, 0)))
    longitude, latitude = -2.0 * np.pi * (4.5 / 8 - 0.5), np.pi * (2.5 / 4 - 0.5)
    d = np.array([[np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]])
    assert packed.world(d)[0][0, 0] == pytest.approx(1.0)
