# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples go where the picture is noisy: as many on the whole, less error, and the same mean."""

import dataclasses

import numpy as np
import pytest

from sdf_lights.render import sample_allocation, session
from sdf_lights.render.film import LEAST_SAMPLES, Film
from sdf_lights.render.scene import Instance, Lamp, Scene
from sdf_lights.sdf.shapes import Torus
from support.scenes import box, camera, diffuse, material, quad, scaling, settings, sphere, translation

SIZE = 40


def stage(size: int = SIZE, **changes) -> Scene:
    """A torus above a floor with a box and a glossy ball: edges and highlights are what is noisy."""
    scene = Scene(camera((0.0, -6.0, 2.4), (0.0, 0.0, 0.9), size, size, half_width=0.35), size, size)
    scene.world.strength = 0.0
    scene.meshes = [quad(), box(), sphere("ball", 64, 32)]
    scene.materials = [
        diffuse((0.7, 0.7, 0.6), "floor"),
        diffuse((0.2, 0.3, 0.7), "box"),
        material("glossy", "gloss", color=(0.8, 0.7, 0.6), roughness=0.3),
    ]
    scene.instances = [
        Instance(0, scaling(6.0, 6.0, 1.0), (0,)),
        Instance(1, translation(-1.0, -0.5, 0.4) @ scaling(0.3, 0.3, 0.4), (1, 1, 1)),
        Instance(2, translation(1.1, -0.9, 0.4) @ scaling(0.4, 0.4, 0.4), (2,)),
    ]
    scene.lamps = [Lamp("torus", Torus(0.8, 0.25), translation(0.0, 0.0, 1.6), power=50.0)]
    scene.settings = settings(max_bounces=0, threads=2, **changes)
    return scene


def fill(film: Film, light, half, squares) -> None:
    """Give a film sums of what its samples have had before paths divide, all of it red."""
    film.sums["combined"].reshape(-1, 4)[:, 0], film.sums["half"].reshape(-1, 3)[:, 0] = light, half
    film.squares[:, :3] = np.stack(np.broadcast_arrays(squares, squares, light), axis=-1)
    film.divided[:, 0] = film.divided[:, 3] = film.count


def pictures(guided: bool, seeds: int, samples: int) -> np.ndarray:
    return np.array(
        [
            session.render(stage(samples=samples, guided_samples=guided, seed=seed), ()).read("Combined")[..., :3]
            for seed in range(seeds)
        ],
        np.float64,
    )


def test_less_error_for_as_many_samples():
    even, guided = pictures(False, 12, 64), pictures(True, 12, 64)
    mean = even.mean(axis=0)
    scale = mean**2 + 0.01 * np.mean(mean) ** 2
    error = [np.mean(each.var(axis=0, ddof=1) / scale) for each in (even, guided)]
    assert error[1] < 0.7 * error[0], error


@pytest.mark.slow
def test_the_mean_stays():
    """Blocks of 48 renders each agree within 4 standard errors of their difference."""
    found = [pictures(guided, 48, 32).reshape(48, 8, 5, 8, 5, 3).mean(axis=(2, 4, 5)) for guided in (False, True)]
    error = np.sqrt(sum(each.var(axis=0, ddof=1) for each in found) / 48)
    difference = np.abs(found[0].mean(axis=0) - found[1].mean(axis=0))
    assert np.all(difference < 4.0 * error + 1e-9)
    assert np.mean(difference**2) < 1.5 * np.mean(error**2)


@pytest.mark.parametrize("samples", [1, 7, 8, 24, 64, 100])
def test_numbers_of_samples(samples):
    """About as many on the whole; between half, or the power of two below, and eight times as many in each pixel, and
    where they differ a power of two, which fills a Sobol sequence; none is guided too early."""
    film = session.render(stage(samples=samples), ("Sample Count",))
    assert film.samples == samples
    assert (
        film.count.min() > samples * sample_allocation.LEAST_RATE / 2.0
        and film.count.max() <= samples * sample_allocation.MOST_RATE
    )
    assert abs(film.count.mean() / samples - 1.0) < 0.1
    np.testing.assert_array_equal(film.read("Sample Count").ravel(), film.count)
    assert (film.count.std() > 0.0) == (samples > sample_allocation.FIRST_UPDATE)
    assert samples <= sample_allocation.FIRST_UPDATE or set(np.unique(film.count)) <= {
        1 << power for power in range(11)
    }
    even = session.render(stage(samples=samples, guided_samples=False), ())
    assert np.all(even.count == samples)


@pytest.mark.parametrize("seen", [2, 4, 8, 16])
def test_few_samples_do_not_promise_many(seen):
    """No pixel gets more times the samples of others than the samples that tell of it."""
    film = Film(stage(), ())
    film.samples, film.count[:] = seen, seen
    rng = np.random.default_rng(9)
    noisy = np.arange(SIZE * SIZE) % SIZE > SIZE - 4
    values = 1.0 + np.where(noisy, 3.0, 0.01) * rng.random((seen, SIZE * SIZE))
    fill(film, values.sum(axis=0), values[seen // 2 :].sum(axis=0), (values**2).sum(axis=0))
    sample_allocation.update(film, stage(samples=64).settings)
    assert film.rate.max() == min(seen, sample_allocation.MOST_RATE)


def test_noisy_pixels_get_more():
    film = session.render(stage(samples=64), ())
    many = [
        session.render(stage(samples=16, guided_samples=False, seed=seed), ()).read("Combined")[..., :3]
        for seed in range(16)
    ]
    mean = np.mean(many, axis=0)
    noise = (np.var(many, axis=0) / (mean**2 + 0.01 * np.mean(mean) ** 2)).mean(axis=-1).ravel()
    noisy, clean = noise >= np.quantile(noise, 0.97), noise <= np.median(noise)
    assert film.count[noisy].mean() > 2.0 * film.count[clean].mean()


def test_the_picture_does_not_depend_on_threads():
    scene = stage(samples=48)
    films = [
        session.render(dataclasses.replace(scene, settings=dataclasses.replace(scene.settings, threads=threads)), ())
        for threads in (1, 3)
    ]
    np.testing.assert_array_equal(films[0].count, films[1].count)
    np.testing.assert_array_equal(films[0].sums["combined"], films[1].sums["combined"])


def test_a_pixels_own_samples_do_not_change_its_rate():
    """Else a lucky pixel would stop early, which is a bias."""

    def film(value: float) -> Film:
        rng = np.random.default_rng(3)
        found = Film(stage(size=24), ())
        found.samples = LEAST_SAMPLES
        found.count[:] = LEAST_SAMPLES
        light = 1.0 + np.linspace(0.05, 1.0, found.count.size) * rng.standard_normal((LEAST_SAMPLES, found.count.size))
        light[:, 300] += value * rng.standard_normal(LEAST_SAMPLES)
        fill(found, light.sum(0), light[8:].sum(0), (light**2).sum(0))
        sample_allocation.update(found, found_settings)
        return found

    found_settings = stage().settings
    one, other = film(0.0), film(5.0)
    assert one.rate[300] == other.rate[300] and one.rate.std() > 0.0


@pytest.mark.parametrize("light", [0.0, 1.0])
def test_pictures_without_noise_stay_even(light):
    film = Film(stage(), ())
    film.samples = LEAST_SAMPLES
    film.count[:] = LEAST_SAMPLES
    fill(film, light * LEAST_SAMPLES, light * LEAST_SAMPLES / 2, light * LEAST_SAMPLES)
    sample_allocation.update(film, stage().settings)
    assert np.all(film.rate == 1.0)


@pytest.mark.parametrize("stratified", [False, True])
def test_the_fall_of_noise_is_measured(stratified):
    """The error of independent samples falls by their number; that of one sample in each stratum, faster."""
    film, rng = Film(stage(), ()), np.random.default_rng(4)
    places = rng.random((16, film.count.size))
    if stratified:
        for first in (0, 8):
            places[first : first + 8] = (places[first : first + 8] + np.arange(8)[:, None]) / 8.0
    known, weight = np.ones(film.count.size, bool), np.ones(film.count.size)
    for count in (8, 16):
        film.count[:] = count
        power = sample_allocation._power(
            film, known, places[:count].sum(axis=0), places[:count].var(axis=0, ddof=1), weight
        )
    assert power == sample_allocation.MOST_POWER if stratified else 1.0 <= power < 1.1


@pytest.mark.parametrize("shared", [0.0, 1.0])
def test_what_branches_share_takes_samples(shared):
    """Where all branches of a sample bring the same, as where the camera's ray meets other things each time, one is
    enough."""
    rng, number, branches = np.random.default_rng(6), 8, 4
    film = Film(stage(), ())
    film.samples, film.count[:] = number, number
    film.divided[:] = number * branches, 0.0, number * branches, number / branches, 0.0
    light = 1.0 + rng.random((number, branches, film.count.size))
    light = shared * light[:, :1] + (1.0 - shared) * light
    film.sums["scattered"].reshape(-1, 3)[:, 0] = light.sum(axis=(0, 1))
    whole = light.mean(axis=1)
    film.squares[:, 1], film.squares[:, 2] = (whole**2).sum(axis=0), whole.sum(axis=0)
    film.squares[:, 3] = branches * light.var(axis=1).sum(axis=0)
    noise = sample_allocation._noise(film, np.ones(film.count.size, bool))
    of_all = whole.var(axis=0, ddof=1).mean()
    known = np.array([noise.first.mean(), noise.second.mean() / branches])
    weight = np.mean(1.0 / (light.mean() ** 2 * (1.0 + sample_allocation.FLOOR)))
    np.testing.assert_allclose(known, of_all * weight * np.array([shared, 1.0 - shared]), atol=0.1 * of_all * weight)
