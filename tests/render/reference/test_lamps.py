# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of the reference against closed forms. Statistical tests use fixed seeds; bounds are 4.4 standard errors
(confidence 0.99999 each) unless said."""

import numpy as np
import pytest

from sdf_lights.render.reference.sdf_lamps import SdfLamp
from sdf_lights.render.reference.vectors import cosine_hemisphere, uniform_sphere
from sdf_lights.render.scene import Lamp
from sdf_lights.sdf import shapes

TORUS = shapes.Torus(major_radius=1.0, minor_radius=0.35)
ABOVE, INSIDE = (0.4, 0.2, 1.6), (1.0, 0.0, 0.1)
SIGMAS = 4.4


def generator(seed=1):
    return np.random.Generator(np.random.Philox(seed))


def lamp(shape, matrix=None, **changes):
    return SdfLamp(Lamp("lamp", shape, np.eye(4) if matrix is None else matrix, **changes))


def whole(lamp, origins, directions):
    count = len(origins)
    return lamp.spans(origins, directions).length(np.zeros(count), np.full(count, np.inf))


def random_rays(count, radius=3.0, seed=2):
    rng = generator(seed)
    origins = radius * uniform_sphere(rng, count)
    targets = rng.uniform(-1.0, 1.0, (count, 3))
    return origins, (targets - origins) / np.linalg.norm(targets - origins, axis=1)[:, None]


def test_chord_of_a_sphere():
    origins, directions = random_rays(5000)
    closest = np.sum(origins * directions, 1)
    square = closest**2 - np.sum(origins**2, 1) + 1.0
    expected = 2.0 * np.sqrt(np.maximum(square, 0.0))
    np.testing.assert_allclose(whole(lamp(shapes.Sphere(radius=1.0)), origins, directions), expected, atol=1e-9)


def test_spans_of_a_torus_are_the_real_roots_of_its_quartic():
    origins, directions = random_rays(300)
    spans = lamp(TORUS).spans(origins, directions)
    for i, (o, d) in enumerate(zip(origins, directions)):
        # (|p|² + R² − r²)² = 4 R² (x² + y²) as a polynomial of t.
        g = np.array([1.0, 2.0 * o @ d, o @ o + 1.0 - 0.35**2])
        flat = np.array([d[:2] @ d[:2], 2.0 * o[:2] @ d[:2], o[:2] @ o[:2]])
        roots = np.roots(np.polysub(np.polymul(g, g), 4.0 * flat))
        real = np.sort(roots[np.abs(roots.imag) < 1e-7].real)
        real = real[real > 0.0]
        mine = np.stack([spans.near[spans.ray == i], spans.far[spans.ray == i]], 1).ravel()
        assert len(mine) == len(real) and np.allclose(mine, real, atol=1e-6), i


def test_spans_end_where_the_field_changes_sign_under_every_affine_matrix():
    shear = np.eye(4)
    shear[0, 2], shear[:3, 3] = 0.7, (0.1, -0.2, 0.3)
    matrix = shear @ np.diag([-1.4, 0.8, 0.5, 1.0])
    shape = shapes.Difference(shapes.Box(half_size=(0.8, 0.8, 0.8)), shapes.Sphere(radius=1.0))
    origins, directions = random_rays(600)
    spans = lamp(shape, matrix).spans(origins, directions)
    assert len(spans.ray) > 150

    def field(t):
        points = origins[spans.ray] + t[:, None] * directions[spans.ray]
        return shape.distance((points - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T)

    assert np.abs(field(spans.near)).max() < 1e-9 and np.abs(field(spans.far)).max() < 1e-9
    for share in (0.01, 0.5, 0.99):
        assert (field(spans.near + share * (spans.far - spans.near)) <= 0.0).all()


def test_a_ray_that_starts_inside_counts_from_its_origin():
    length = whole(lamp(shapes.Sphere(radius=2.0)), np.zeros((1, 3)), np.array([[0.0, 0.6, 0.8]]))
    assert length == pytest.approx(2.0, abs=1e-10)


@pytest.mark.parametrize("point, truth", [(ABOVE, 0.22912), (INSIDE, 0.70850)])
def test_irradiance_of_a_torus(point, truth):
    """Both estimators give the irradiance of the published analysis for I = 1 and a receiver that faces −z.

    The truth is given to five digits. Inside, projection sampling has heavy tails; there its error bar is wide.
    """
    count = 30_000
    source, rng, x = lamp(TORUS, power=4.0 * np.pi), generator(), np.tile(point, (count, 1))
    n = np.tile([0.0, 0.0, -1.0], (count, 1))
    by_cosine = np.pi * source.emission[0] * whole(source, x, cosine_hemisphere(rng, n))
    wi = source.sample(rng, x)
    pdf = source.pdf(source.spans(x, wi), count)
    by_projection = source.emission[0] * whole(source, x, wi) / pdf * np.maximum(-wi[:, 2], 0.0)
    for values in (by_cosine, by_projection):
        assert abs(values.mean() - truth) < SIGMAS * values.std() / np.sqrt(count) + 1e-5


def test_variances_of_the_published_table():
    """To 5 %; the standard error of these variances is below 1 %."""
    count = 60_000
    source, rng, x = lamp(TORUS, power=4.0 * np.pi), generator(3), np.tile(ABOVE, (count, 1))
    n = np.tile([0.0, 0.0, -1.0], (count, 1))
    by_cosine = np.pi * source.emission[0] * whole(source, x, cosine_hemisphere(rng, n))
    wi = source.sample(rng, x)
    by_projection = source.emission[0] * whole(source, x, wi) * -wi[:, 2] / source.pdf(source.spans(x, wi), count)
    assert by_cosine.var() == pytest.approx(0.1273, rel=0.05)
    assert by_projection.var() == pytest.approx(0.0037, rel=0.05)


@pytest.mark.parametrize("point", [ABOVE, INSIDE])
def test_density_integrates_to_one(point):
    shear = np.eye(4)
    shear[1, 2], shear[0, 0] = 0.3, -1.2
    count = 40_000
    source, x = lamp(TORUS, shear), np.tile(np.array(point) @ shear[:3, :3].T, (count, 1))
    values = 4.0 * np.pi * source.pdf(source.spans(x, uniform_sphere(generator(4), count)), count)
    assert abs(values.mean() - 1.0) < SIGMAS * values.std() / np.sqrt(count)


def test_volume_by_chords():
    """A shape without closed form: a box with a ball cut out, whose volume is known all the same."""
    shape = shapes.Difference(shapes.Box(half_size=(0.5, 0.6, 0.7)), shapes.Sphere(radius=0.4))
    assert shape.volume() is None
    assert lamp(shape).volume == pytest.approx(8 * 0.5 * 0.6 * 0.7 - 4 / 3 * np.pi * 0.4**3, rel=1e-4)


def test_power_and_density():
    matrix = np.diag([2.0, 1.0, 0.5, 1.0])
    volume = 4 / 3 * np.pi * 0.5**3
    assert lamp(shapes.Sphere(radius=0.5), matrix, power=7.0).emission[0] == pytest.approx(7.0 / (4 * np.pi * volume))
    dense = lamp(shapes.Sphere(radius=0.5), matrix, density=3.0, color=(1.0, 0.5, 0.0))
    assert dense.emission == pytest.approx([3.0, 1.5, 0.0])


def test_a_flat_lamp_is_refused():
    with pytest.raises(ValueError, match="scale is zero"):
        lamp(TORUS, np.diag([1.0, 0.0, 1.0, 1.0]))
