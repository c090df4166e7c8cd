# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive triangles: Arvo's density, the tiny and the degenerate ones, and the way back from a hit."""

import math

import numpy as np
import pytest
from scipy import stats

from sdf_lights.jit import kernel
from sdf_lights.render.kernels import lights
from sdf_lights.render.kernels.lights import Triangles
from tests.render.lights.harness import UP, Packed, grid, irradiance, scene_of

X = (0.1, -0.2, 0.0)
CORNERS = {
    "near": ((-1.0, -1.0, 0.6), (1.2, -0.8, 0.9), (0.1, 1.1, 0.5)),
    "around": ((-30.0, -30.0, 0.3), (30.0, -30.0, 0.3), (0.0, 50.0, 0.3)),
    "far": ((-1.0, -1.0, 300.0), (1.2, -0.8, 301.0), (0.1, 1.1, 300.0)),
    "sliver": ((-1.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.0, 0.02, 1.0)),
}


def packed_triangle(corners, instance=0, primitive=0):
    return Packed(
        scene_of(),
        triangles=Triangles(
            np.array([instance]),
            np.array([primitive]),
            np.array([corners], float),
            np.array([(3.0, 2.0, 1.0)]),
            np.array([True]),
        ),
    )


def ray_triangle(corners, x, d):
    """Distances of the rays at the triangle, NaN where they miss: signed volumes, apart from the package's own code."""
    p = np.asarray(corners, float) - np.asarray(x)
    volumes = [d @ np.cross(p[i], p[(i + 1) % 3]) for i in range(3)]
    inside = np.all([v >= 0 for v in volumes], axis=0) | np.all([v <= 0 for v in volumes], axis=0)
    normal = np.cross(p[1] - p[0], p[2] - p[0])
    t = (p[0] @ normal) / (d @ normal)
    return np.where(inside & (t > 0.0), t, np.nan)


@kernel
def _pdfs(blocks, x, emitter, d, distance, out):
    for i in range(len(d)):
        out[i] = lights.triangle_pdf(blocks[0], x, emitter, (d[i, 0], d[i, 1], d[i, 2]), distance[i])


def pdfs(packed, x, d, distance):
    values = np.empty(len(d))
    _pdfs(packed.blocks, x, 1, np.ascontiguousarray(d), distance, values)
    return values


@pytest.mark.parametrize("name", CORNERS)
def test_samples_follow_the_pdf(name):
    """χ² with the expected counts integrated over the triangle's area, which has no rim to miss."""
    corners, draws, side = np.array(CORNERS[name]), 60_000, 1000
    packed = packed_triangle(corners)
    u = grid(side)
    root = np.sqrt(u[:, :1])
    edges = corners[1:] - corners[0]
    offset = corners[0] + root * (1.0 - u[:, 1:]) * edges[0] + root * u[:, 1:] * edges[1] - X
    distance = np.linalg.norm(offset, axis=1)
    d = offset / distance[:, None]
    solid_angle = 0.5 * np.abs(d @ np.cross(*edges)) / distance**2 / side**2
    mass = pdfs(packed, X, d, distance) * solid_angle
    assert mass.sum() == pytest.approx(1.0, abs=1e-4)

    sampled = packed.sample(1, X, np.random.default_rng(3).random((draws, 2)))[0]
    axes = np.linalg.qr(np.mean(offset, axis=0)[:, None], mode="complete")[0][:, 1:]
    bounds = [np.concatenate(([-1.0], np.quantile(d @ axis, np.linspace(0.1, 0.9, 9)), [1.0])) for axis in axes.T]
    observed = np.histogram2d(*(sampled @ axes).T, bounds)[0].ravel()
    expected = draws * np.histogram2d(*(d @ axes).T, bounds, weights=mass)[0].ravel()
    big = expected > 5.0
    assert abs(observed[~big].sum() - expected[~big].sum()) < 20.0
    statistic = np.sum((observed[big] - expected[big]) ** 2 / expected[big])
    assert stats.chi2.sf(statistic, big.sum() - 1) > 1e-4  # fails one correct run in 10⁴


@pytest.mark.parametrize("name", CORNERS)
def test_samples_lie_on_the_triangle_with_the_pdf_of_a_hit(name):
    corners = CORNERS[name]
    packed = packed_triangle(corners)
    wi, distance, radiance, pdf, singular = packed.sample(1, X, np.random.default_rng(1).random((3000, 2)))
    assert not singular.any()
    expected = ray_triangle(corners, X, wi)
    met = np.isfinite(expected)
    assert met.mean() > 0.995  # a sample on an edge may miss
    np.testing.assert_allclose(distance[met], expected[met], rtol=1e-7)
    np.testing.assert_allclose(pdf[met], pdfs(packed, X, wi[met], expected[met]), rtol=1e-6)
    assert (radiance == (3.0, 2.0, 1.0)).all()


def test_density_is_one_over_the_solid_angle():
    """The octant of three axes has a solid angle of π / 2."""
    packed = packed_triangle(((2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.5)))
    pdf = packed.sample(1, (0.0, 0.0, 0.0), np.random.default_rng(1).random((100, 2)))[3]
    np.testing.assert_allclose(pdf, 2.0 / math.pi, rtol=1e-12)


def test_irradiance_by_lamberts_formula():
    corners = np.array(CORNERS["near"]) - X
    r = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    total = 0.0
    for i in range(3):
        a, b = r[i], r[(i + 1) % 3]
        normal = np.cross(a, b)
        total += math.acos(a @ b) * normal[2] / np.linalg.norm(normal)
    expected = 3.0 * abs(total) / 2.0
    assert irradiance(packed_triangle(CORNERS["near"]), 1, X, UP) == pytest.approx(expected, rel=1e-4)


def test_both_samplings_agree_where_they_meet():
    """Solid angle and area sampling give one irradiance on both sides of the switch between them."""
    values = []
    for height in (99.0, 100.0, 101.0):
        corners = ((-0.5, -0.5, height), (1.0, -0.5, height), (-0.5, 0.83, height))
        values.append(irradiance(packed_triangle(corners), 1, (0.0, 0.0, 0.0), UP) * height**2)
    np.testing.assert_allclose(values, values[1], rtol=1e-4)


@pytest.mark.parametrize(
    "corners, x",
    [
        (((1, 1, 1), (1, 1, 1), (1, 1, 1)), X),
        (((0, 0, 1), (1, 0, 1), (2, 0, 1)), X),
        (((0, 0, 0), (1, 0, 0), (0, 1, 0)), (0.2, 0.2, 0.0)),
        (((0, 0, 0), (1, 0, 0), (0, 1, 0)), (3.0, 0.2, 0.0)),
        (((0, 0, 0), (1, 0, 0), (0, 1, 0)), (0.0, 0.0, 0.0)),
        (((0, 0, 0), (1, 0, 0), (0, 1, 0)), (0.3, 0.3, 1e-9)),
    ],
)
def test_degenerate_views_give_finite_numbers(corners, x):
    packed = packed_triangle(corners)
    x = tuple(map(float, x))
    one = 1.0 - 1e-16
    u = np.concatenate([np.random.default_rng(1).random((200, 2)), [(0, 0), (0, one), (one, 0), (one, one)]])
    wi, distance, radiance, pdf, _ = packed.sample(1, x, u)
    assert np.isfinite(pdf).all() and np.isfinite(distance).all() and np.isfinite(radiance).all()
    lit = np.isfinite(wi[:, 0])
    np.testing.assert_allclose(np.linalg.norm(wi[lit], axis=1), 1.0, rtol=1e-9)
    out = np.empty(1)
    _pdfs(packed.blocks, x, 1, np.array([[0.0, 0.0, 1.0]]), np.array([1.0]), out)
    assert np.isfinite(out).all()


@kernel
def _emitter(blocks, instance, primitive):
    return lights.triangle_emitter(blocks[0], instance, primitive)


@kernel
def _point(blocks, x, emitter, d):
    return lights.triangle_textured(blocks[0], emitter), lights.triangle_point(blocks[0], x, emitter, d)


def test_hits_find_their_emitter():
    corners = np.array([CORNERS["near"]] * 4, float)
    packed = Packed(
        scene_of(),
        triangles=Triangles(
            np.array([1, 1, 3, 3]), np.array([5, 2, 0, 9]), corners, np.ones((4, 3)), np.zeros(4, bool)
        ),
    )
    found = {(i, p): _emitter(packed.blocks, i, p) for i in range(6) for p in range(12)}
    found = {key: emitter for key, emitter in found.items() if emitter >= 0}
    assert found == {(1, 5): 1, (1, 2): 2, (3, 0): 3, (3, 9): 4}


def test_sampled_point_has_its_barycentric_weights():
    corners = np.array(CORNERS["near"])
    packed = packed_triangle(corners, 2, 7)
    wi, distance, _, _, _ = packed.sample(1, X, np.random.default_rng(4).random((50, 2)))
    for d, t in zip(wi, distance):
        textured, (instance, primitive, v, w) = _point(packed.blocks, X, 1, tuple(d))
        assert textured and (instance, primitive) == (2, 7)
        np.testing.assert_allclose((1 - v - w) * corners[0] + v * corners[1] + w * corners[2], X + t * d, atol=1e-9)
