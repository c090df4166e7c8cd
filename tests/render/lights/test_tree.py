# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice among emitters: exact, complete, and cheap for many of them."""

import math
import time

import numpy as np
import pytest
from scipy import stats

from sdf_lights.render.kernels.lights import Triangles
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.scene import World
from tests.render.lights.harness import NONE, UP, Packed, irradiance, place, scene_of


def crowd(count, seed=3, **fields):
    """Lights of all kinds at random in a box of 10 metres."""
    rng = np.random.default_rng(seed)
    lights = []
    for i in range(count):
        matrix = place(*rng.uniform(-5.0, 5.0, 3), axis=rng.normal(size=3))
        power = float(rng.exponential(50.0))
        lights.append(
            (
                PointLight("", matrix, power),
                SpotLight("", matrix, power, angle=0.8, radius=0.1),
                AreaLight("", matrix, power, size=(0.5, 0.7)),
                PointLight("", matrix, power, radius=0.3),
                AreaLight("", matrix, power, ellipse=True, spread=1.0),
            )[i % 5]
        )
    return scene_of(*lights, **fields)


def triangle_soup(count, seed=1):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-5.0, 5.0, (count, 1, 3)) + rng.normal(scale=0.05, size=(count, 3, 3))
    return Triangles(
        np.zeros(count, np.int32),
        np.arange(count, dtype=np.int32),
        corners,
        rng.exponential(1.0, (count, 3)),
        np.zeros(count, bool),
    )


CASES = {
    "one": scene_of(PointLight("", place(0, 0, 1), 10.0)),
    "two": scene_of(PointLight("", place(0, 0, 1), 10.0), AreaLight("", place(3, 0, 1), 20.0)),
    "ten": crowd(10),
    "three hundred": crowd(300),  # more than a cut has nodes
    "suns and world": scene_of(
        SunLight("", place(axis=(1, 0, 1)), 3.0),
        SunLight("", place(axis=(-1, 0, 1)), 1.0, angle=0.1),
        world=World((1.0, 1.0, 1.0), 0.3),
    ),
    "all": scene_of(
        *crowd(20).lights,
        SunLight("", place(axis=(1, 0, 1)), 3.0),
        SunLight("", place(axis=(0, 1, -1)), 3.0),
        world=World((1.0, 1.0, 1.0), 0.01),
    ),
    "in one place": scene_of(*(AreaLight("", place(0, 0, 1), 10.0) for _ in range(9))),
}
POINTS = [((0.3, 0.2, 0.0), UP), ((0.3, 0.2, 0.0), NONE), ((0.0, 0.0, 1.0), UP), ((40.0, 3.0, -2.0), (0.0, -0.6, 0.8))]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("x, n", POINTS)
def test_probabilities_are_what_is_sampled(case, x, n):
    packed = Packed(CASES[case])
    p = packed.probabilities(x, n)
    assert p.sum() == pytest.approx(1.0, abs=1e-9)
    draws = 50_000
    emitter, probability, again = packed.select(x, n, np.random.default_rng(11).random(draws))
    np.testing.assert_allclose(probability, p[emitter], rtol=1e-9)
    assert ((again >= 0.0) & (again < 1.0)).all()
    observed, expected = np.bincount(emitter, minlength=len(p)), draws * p
    big = expected > 5.0
    statistic = np.sum((observed[big] - expected[big]) ** 2 / expected[big])
    assert stats.chi2.sf(statistic, max(big.sum() - 1, 1)) > 1e-4  # fails one correct run in 10⁴
    # What is left of u is uniform again.
    assert stats.kstest(again, "uniform").pvalue > 1e-4


@pytest.mark.parametrize("case", CASES)
def test_every_light_that_shines_may_be_chosen(case):
    scene = CASES[case]
    packed = Packed(scene)
    for x, n in POINTS:
        p = packed.probabilities(x, n)
        assert (p[: len(scene.lights)] > 0.0).all()
        assert (p[len(scene.lights)] > 0.0) == (scene.world.color != (0.0, 0.0, 0.0))


def test_lights_without_power_are_never_chosen_and_nothing_gives_none():
    dark = PointLight("", place(), 0.0)
    packed = Packed(scene_of(dark, PointLight("", place(1.0), 5.0), SunLight("", place(), 0.0)))
    assert packed.probabilities((0, 0, 2), UP).tolist() == [0.0, 1.0, 0.0, 0.0]
    emitter, probability, _ = Packed(scene_of(dark)).select((0, 0, 2), UP, np.array([0.5]))
    assert emitter[0] == -1 and probability[0] == 0.0


def test_lamps_are_chosen_by_power_and_distance_also_from_inside():
    bounds = np.array([[[-1, -1, -1], [1, 1, 1]], [[9, -1, -1], [11, 1, 1]]], float)
    packed = Packed(scene_of(), lamp_bounds=bounds, lamp_power=np.array([10.0, 10.0]))
    inside = packed.probabilities((0.2, 0.1, 0.3), UP)
    assert inside[0] > 0.9 and inside[1] > 0.0
    between = packed.probabilities((5.0, 0.0, 0.0), UP)
    np.testing.assert_allclose(between[:2], 0.5, atol=1e-6)


@pytest.mark.parametrize("count", [2, 40, 1000])
def test_probabilities_of_lamps_sum_to_one(count):
    """Lamps of sizes over three powers of ten, seen from far away, from among them and from inside one."""
    rng = np.random.default_rng(count)
    center, half = rng.normal(0.0, 2.0, (count, 3)), 10.0 ** rng.uniform(-2.0, 1.0, (count, 1)) * rng.random((count, 3))
    packed = Packed(
        scene_of(), lamp_bounds=np.stack([center - half, center + half], axis=1), lamp_power=rng.exponential(1.0, count)
    )
    for x in (center[0], center[-1] + half[-1], np.array([0.3, 500.0, -20.0])):
        for n in (UP, NONE, (0.0, -0.6, 0.8)):
            p = packed.probabilities(x, n)
            assert p[:count].min() > 0.0 and p.sum() == pytest.approx(1.0, abs=1e-9)
            emitter, probability, _ = packed.select(x, n, np.linspace(0.0, 1.0, 5000, endpoint=False))
            np.testing.assert_allclose(probability, p[emitter], rtol=1e-9)


def test_light_behind_the_surface_is_rare_but_not_excluded():
    packed = Packed(scene_of(PointLight("", place(0, 0, 1), 10.0), PointLight("", place(0, 0, -1), 10.0)))
    facing = packed.probabilities((0, 0, 0), UP)
    assert 0.005 < facing[1] < 0.05
    np.testing.assert_allclose(packed.probabilities((0, 0, 0), NONE)[:2], 0.5)


@pytest.mark.parametrize("count, least", [(10, 20.0), (1000, 80.0)])
def test_tree_reduces_variance_against_choice_by_power(count, least):
    """Second moment of the estimate of irradiance from point lights: Σ f² / p."""
    rng = np.random.default_rng(2)
    at, power = rng.uniform(-5.0, 5.0, (count, 3)), rng.exponential(20.0, count)
    packed = Packed(scene_of(*(PointLight("", place(*a), float(p)) for a, p in zip(at, power))))
    gain = []
    for x in rng.uniform(-5.0, 5.0, (20, 3)):
        p = packed.probabilities(x, UP, count)
        offset = at - x
        square = np.sum(offset**2, axis=1)
        f = power * np.maximum(offset[:, 2], 0.0) / square**1.5
        if f.any():
            by_power = power / power.sum()
            gain.append((np.sum(f * f / by_power) - f.sum() ** 2) / (np.sum(f * f / p) - f.sum() ** 2))
    print(f"{count} point lights: variance lower by {np.median(gain):.1f} (median)")
    assert np.median(gain) > least


def test_tree_of_a_hundred_thousand_triangles():
    soup = triangle_soup(100_000)
    Packed(scene_of(), triangles=triangle_soup(10))  # loads the kernels
    start = time.process_time()
    packed = Packed(scene_of(), triangles=soup)
    build = time.process_time() - start
    x, u = (0.3, 0.2, 0.1), np.random.default_rng(5).random(100_000)
    p = packed.probabilities(x, UP)
    assert p[0] == 0.0 and (p[1:] > 0.0).all()
    assert p.sum() == pytest.approx(1.0, abs=1e-6)
    emitter, probability, _ = packed.select(x, UP, u)
    np.testing.assert_allclose(probability, p[emitter], rtol=1e-9)
    print(f"tree of 100,000 triangles: built in {build:.2f} s")
    assert build < 5.0  # about 1 s


@pytest.mark.slow
def test_cost_of_a_choice_grows_with_the_logarithm_of_the_count():
    cost = {}
    u = np.random.default_rng(5).random(200_000)
    for count in (1000, 100_000):
        packed = Packed(scene_of(), triangles=triangle_soup(count))
        packed.select((0.3, 0.2, 0.1), UP, u[:10])
        best = math.inf
        for _ in range(3):
            start = time.perf_counter()
            packed.select((0.3, 0.2, 0.1), UP, u)
            best = min(best, time.perf_counter() - start)
        cost[count] = best / len(u) * 1e9
    print({count: f"{ns:.0f} ns" for count, ns in cost.items()})
    # Depths are as 1.7 to 1; what is more are nodes that a core's caches do not hold. A scan would be as 100 to 1.
    assert cost[100_000] < 10.0 * cost[1000]


def test_a_long_strip_among_many_emitters_hides_none_of_them():
    """As a bright line on a floor does, it reaches far beyond all others, and its node must not contain them."""
    small = triangle_soup(2000)
    low, high = np.array((-0.1, -200.0, 0.0)), np.array((0.1, 200.0, 0.0))
    strip = np.array([[low, (0.1, -200.0, 0.0), high], [low, high, (-0.1, 200.0, 0.0)]])
    triangles = Triangles(
        np.zeros(2002, np.int32),
        np.arange(2002, dtype=np.int32),
        np.concatenate((small.corners + (0.0, 0.0, 20.0), strip)),
        np.concatenate((small.radiance, np.ones((2, 3)))),
        np.zeros(2002, bool),
    )
    powers = 1000.0, 2000.0
    lamps = [PointLight("", place(x, -x, 3.0), power) for x, power in zip((-4.0, 4.0), powers)]
    packed = Packed(scene_of(*lamps), triangles=triangles)
    for x in ((1.0, 2.0, 0.1), (-3.0, -2.0, 0.1), (4.0, 3.0, 0.1)):
        found = packed.probabilities(x, UP, 2)
        lit = [irradiance(packed, lamp, x, UP, 1) for lamp in range(2)]
        assert (found > 0.5 * np.array(lit) / sum(lit)).all(), (x, found, lit)
