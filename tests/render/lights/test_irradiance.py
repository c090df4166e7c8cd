# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance from every light against its closed form."""

import math

import numpy as np
import pytest

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from tests.render.lights.harness import UP, Packed, irradiance, place, scene_of

ORIGIN = (0.0, 0.0, 0.0)


def of(light, x=ORIGIN, n=UP, side=256):
    return irradiance(Packed(scene_of(light)), 0, x, n, side)


def test_point_light():
    light = PointLight("", place(0.0, 3.0, 4.0), 100.0)
    assert of(light, side=1) == pytest.approx(100.0 / (4.0 * math.pi) / 25.0 * 0.8, rel=1e-12)


def test_sphere_is_its_point_light_while_above_the_horizon():
    # E = π L sin² α cos θ = P cos θ / (4π d²) exactly.
    light = PointLight("", place(0.0, 3.0, 4.0), 100.0, radius=1.5, soft_falloff=False)
    assert of(light) == pytest.approx(100.0 / (4.0 * math.pi) / 25.0 * 0.8, rel=2e-5)


def test_inside_a_sphere_irradiance_is_pi_times_radiance():
    light = PointLight("", place(0.1, 0.2, 0.3), 100.0, radius=2.0, soft_falloff=False)
    assert of(light) == pytest.approx(math.pi * 100.0 / (4.0 * math.pi**2 * 4.0), rel=1e-4)


def test_soft_falloff_is_a_disk_that_faces_the_point():
    light = PointLight("", place(0.0, 0.0, 1.0), 100.0, radius=0.7)
    assert of(light) == pytest.approx(100.0 / (4.0 * math.pi) / (1.0 + 0.49), rel=1e-5)


def test_spot_has_the_intensity_of_the_point_light_on_its_axis_and_falls_off_as_a_smooth_step():
    angle, blend, h = 1.0, 0.4, 2.0
    light = SpotLight("", place(0.0, 0.0, h), 100.0, angle=angle, blend=blend)
    half = math.cos(angle / 2.0)
    for theta in (0.0, 0.35, 0.42, 0.49, 0.51):
        f = min(max((math.cos(theta) - half) / ((1.0 - half) * blend), 0.0), 1.0)
        expected = 100.0 / (4.0 * math.pi) * f * f * (3.0 - 2.0 * f) * math.cos(theta) ** 3 / h**2
        assert of(light, (h * math.tan(theta), 0.0, 0.0), side=1) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_scale_of_a_spot_changes_its_cone_but_not_its_power():
    wide = SpotLight("", place(0.0, 0.0, 2.0, scale=(2.0, 1.0, 1.0)), 100.0, angle=1.0, blend=0.0)
    theta = 0.7
    assert math.tan(0.5) < math.tan(theta) < 2.0 * math.tan(0.5)
    assert of(wide, (2.0 * math.tan(theta), 0.0, 0.0), side=1) > 0.0
    assert of(wide, (0.0, 2.0 * math.tan(theta), 0.0), side=1) == 0.0
    assert of(wide, side=1) == pytest.approx(100.0 / (16.0 * math.pi))


def corner_factor(a, b, c):
    """Form factor from a point to a parallel rectangle a × b at distance c, one corner over the point (Howell, B-4)."""
    p, q = a / c, b / c
    return (
        p / math.sqrt(1 + p * p) * math.atan(q / math.sqrt(1 + p * p))
        + q / math.sqrt(1 + q * q) * math.atan(p / math.sqrt(1 + q * q))
    ) / (2.0 * math.pi)


@pytest.mark.parametrize("h", [0.01, 0.5, 3.0, 800.0])
def test_rectangle(h):
    light = AreaLight("", place(0.0, 0.0, h), 50.0, size=(2.0, 1.0))
    radiance = 50.0 / (math.pi * 2.0)
    expected = math.pi * radiance * sum(corner_factor(a, b, h) for a in (1.3, 0.7) for b in (0.7, 0.3))
    assert of(light, (-0.3, 0.2, 0.0)) == pytest.approx(expected, rel=1e-4)


def test_scale_of_an_area_light_changes_its_size_but_not_its_power():
    small = AreaLight("", place(0.0, 0.0, 1.0, scale=(2.0, 3.0, 5.0)), 50.0, size=(0.5, 0.2))
    large = AreaLight("", place(0.0, 0.0, 1.0), 50.0, size=(1.0, 0.6))
    assert of(small) == pytest.approx(of(large), rel=1e-9)


def test_mirrored_area_light_shines_to_the_same_side():
    light = AreaLight("", place(0.0, 0.0, 1.0, scale=(-1.0, 1.0, 1.0)), 50.0)
    assert of(light) == pytest.approx(of(AreaLight("", place(0.0, 0.0, 1.0), 50.0)), rel=1e-9)
    assert of(light, (0.0, 0.0, 2.0), (0.0, 0.0, -1.0)) == 0.0


@pytest.mark.parametrize("h", [0.02, 0.5, 3.0, 500.0])
def test_disk_on_its_axis(h):
    light = AreaLight("", place(0.0, 0.0, h), 50.0, ellipse=True)
    radiance = 50.0 / (math.pi * math.pi * 0.25)
    assert of(light) == pytest.approx(math.pi * radiance * 0.25 / (0.25 + h * h), rel=1e-4)


def area_integral(light_size, gain, x, h, side=1500):
    """∫ gain(tan θ) cos⁴ θ / h² dA over an ellipse at height h, for the point x of the plane z = 0."""
    r = np.sqrt((np.arange(side) + 0.5) / side)
    phi = 2.0 * np.pi * (np.arange(side) + 0.5) / side
    r, phi = np.meshgrid(r, phi)
    a, b = light_size[0] / 2.0, light_size[1] / 2.0
    rho2 = (a * r * np.cos(phi) - x[0]) ** 2 + (b * r * np.sin(phi) - x[1]) ** 2
    return np.mean(gain(np.sqrt(rho2) / h) * h * h / (rho2 + h * h) ** 2) * math.pi * a * b


@pytest.mark.parametrize("x", [(0.0, 0.0), (0.3, 0.1), (1.4, 0.2), (4.0, -1.0)])
@pytest.mark.parametrize("h", [0.2, 1.0])
def test_ellipse(x, h):
    light = AreaLight("", place(0.0, 0.0, h), 50.0, ellipse=True, size=(3.0, 0.8))
    radiance = 50.0 / (math.pi * math.pi * 1.5 * 0.4)
    expected = radiance * area_integral((3.0, 0.8), np.ones_like, x, h)
    assert of(light, (*x, 0.0)) == pytest.approx(expected, rel=5e-4)


def test_spread_follows_the_slats_of_a_grid():
    s, h = 0.6, 1.0
    light = AreaLight("", place(0.0, 0.0, h), 50.0, ellipse=True, spread=2.0 * s)
    radiance = 50.0 / (math.pi * math.pi * 0.25)

    def gain(tangent):
        return np.maximum(math.tan(s) - tangent, 0.0) / (math.tan(s) - s)

    for x in ((0.0, 0.0), (0.4, 0.2), (0.9, 0.0)):
        expected = radiance * area_integral((1.0, 1.0), gain, x, h)
        assert of(light, (*x, 0.0), side=1024) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("spread", [math.pi, 2.0, 0.5, 0.02])
def test_spread_keeps_the_power(spread):
    """∫ intensity over the directions of emission is P; intensity is irradiance far away, facing the light."""
    packed = Packed(scene_of(AreaLight("", place(), 50.0, size=(0.001, 0.001), spread=spread)))
    theta = (np.arange(400) + 0.5) / 400 * spread / 2.0
    intensity = [
        1e4 * irradiance(packed, 0, (100.0 * s, 0.0, -100.0 * c), (-s, 0.0, c), 4)
        for s, c in zip(np.sin(theta), np.cos(theta))
    ]
    power = np.sum(intensity * np.sin(theta)) * 2.0 * math.pi * spread / 800
    assert power == pytest.approx(50.0, rel=1e-4)


def test_parallel_beam_has_the_irradiance_of_its_area():
    light = AreaLight("", place(0.0, 0.0, 1.0), 50.0, size=(2.0, 1.0), spread=0.0)
    assert of(light, (0.9, 0.4, 0.0), side=1) == pytest.approx(25.0)
    assert of(light, (1.1, 0.4, 0.0), side=1) == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.00918, 1.0])
def test_strength_of_the_sun_is_irradiance(angle):
    light = SunLight("", place(axis=(3.0, 0.0, 4.0)), 2.5, angle=angle)
    assert of(light, n=(0.6, 0.0, 0.8)) == pytest.approx(2.5, rel=1e-5)
    assert of(light) == pytest.approx(2.0, rel=1e-5)
