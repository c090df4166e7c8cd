# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A world with the disc of a sun: samples follow the density, and their mean is the light of sky and sun."""

import math

import numpy as np
import pytest

from sdf_lights.graph.formula import Vector, call, parameter
from sdf_lights.render.kernels.world_sun import Disc, WorldMap, find_disc
from sdf_lights.render.nodes.sky import sky_function
from sdf_lights.render.nodes.variables import POSITION
from sdf_lights.render.scene import World
from sdf_lights.render.sky import Sky, numbers, radiance, sky_map, sun_of
from tests.render.lights.harness import Packed, scene_of

SKY = Sky(sun_elevation=0.5, sun_rotation=2.0, sun_size=0.05)


def world_map(sky=SKY, rows=64):
    picture = sky_map(sky, 2 * rows, rows).mean(axis=2)
    disc = sun_of(sky)
    points = Disc(disc.direction, disc.half_angle)
    return points.separate(picture, float(radiance(sky, points.points()).mean()))


def packed(found):
    return Packed(scene_of(world=World((1.0, 1.0, 1.0))), world_map=found)


def cone(direction, half_angle, u):
    """Uniform directions of a cone."""
    cosine, turn = 1.0 - (1.0 - math.cos(half_angle)) * u[:, 0], 2.0 * np.pi * u[:, 1]
    sine = np.sqrt(1.0 - cosine**2)
    side = np.cross(direction, (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    up = np.cross(direction, side)
    return cosine[:, None] * direction + sine[:, None] * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * up)


def test_the_density_is_one_over_the_sphere_and_the_disc_has_its_share():
    found = world_map()
    u = np.random.default_rng(1).random((200_000, 2))
    everywhere, disc = cone(np.array([0.0, 0.0, 1.0]), math.pi, u), cone(found.sun, found.half_angle, u[:20_000])
    _, pdf = packed(found).world(everywhere)
    _, within = packed(found).world(disc)
    outside = np.linalg.norm(everywhere - found.sun, axis=1) > 2.0 * math.sin(0.5 * found.half_angle)
    solid_angle = 2.0 * math.pi * (1.0 - math.cos(found.half_angle))
    assert 4.0 * math.pi * (pdf * outside).mean() + solid_angle * within.mean() == pytest.approx(1.0, abs=0.01)
    assert solid_angle * within.mean() >= found.sun_share


def test_samples_have_the_density_that_rays_find():
    found = world_map()
    wi, _, _, pdf, _ = packed(found).sample(0, (0.0, 0.0, 0.0), np.random.default_rng(2).random((20_000, 2)), dark=True)
    np.testing.assert_allclose(packed(found).world(wi)[1], pdf, rtol=1e-9)
    in_disc = np.linalg.norm(wi - found.sun, axis=1) <= 2.0 * math.sin(0.5 * found.half_angle) + 1e-12
    assert in_disc.mean() == pytest.approx(found.sun_share, abs=0.02)


def test_the_mean_of_samples_is_the_light_of_sky_and_sun():
    found, sun = world_map(), sun_of(SKY)
    wi, _, _, pdf, _ = packed(found).sample(0, (0.0, 0.0, 0.0), np.random.default_rng(3).random((60_000, 2)), dark=True)
    estimate = (radiance(SKY, wi).mean(axis=1) / pdf).mean()
    picture = sky_map(SKY, 256, 128)
    weight = np.diff(np.sin(np.pi * (np.arange(129) / 128 - 0.5)))
    sky = 2.0 * math.pi * (weight @ picture.mean(axis=(1, 2), dtype=float))
    expected = sky + 2.0 * math.pi * (1.0 - math.cos(sun.half_angle)) * sun.radiance.mean()
    assert estimate == pytest.approx(expected, rel=0.01)
    # A sun that its map does not see is 300 times as bright as the rest: only its own samples make this mean steady.
    assert np.std(radiance(SKY, wi).mean(axis=1) / pdf) < 0.7 * expected


def test_cells_in_the_disc_have_what_is_around_it():
    values = np.ones((32, 64), np.float32)
    disc = Disc(np.array([1.0, 0.0, 0.0]), 0.3)
    values[15:17, 31:33] = 1000.0
    found = disc.separate(values, 5.0)
    assert (found.values == 1.0).all() and found.sun_radiance == 5.0
    assert found.mean == pytest.approx(1.0 + 0.5 * (1.0 - math.cos(0.3)) * 5.0, rel=1e-6)


def test_a_sun_that_gives_nothing_takes_no_samples():
    found = Disc(np.array([0.0, 0.0, 1.0]), 0.1).separate(np.ones((8, 16), np.float32), 0.0)
    assert found.sun is None and found.sun_share == 0.0
    assert WorldMap(found.values).mean == pytest.approx(1.0)


def test_the_sun_is_found_among_formulas():
    values = numbers(SKY)
    constants = np.concatenate((np.zeros(5), values))

    def roots(direction, with_sun=True):
        return call(sky_function(SKY.kind, with_sun), parameter(0), *direction)

    found = find_disc(roots(POSITION), np.array([5.0]), constants)
    np.testing.assert_allclose(found.direction, SKY.sun())
    assert found.half_angle == pytest.approx(0.025)
    assert find_disc(roots(POSITION, False), np.array([5.0]), constants) is None
    turned = Vector(POSITION.y, POSITION.x, POSITION.z)
    assert find_disc(roots(turned), np.array([5.0]), constants) is None
    twice = [a + b for a, b in zip(roots(POSITION), call(sky_function(SKY.kind, True), parameter(1), *POSITION))]
    assert find_disc(twice, np.array([5.0, 5.0]), constants) is None
