# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising with the real library."""

import threading
import time

import numpy as np
import pytest

from sdf_lights.render.denoise import denoise, denoise_each
from sdf_lights.render.denoised_film import denoise_film, shrunk
from sdf_lights.render.film import HALF_BIT, LEAST_SAMPLES, Film
from sdf_lights.render.scene import Camera, Scene
from sdf_lights.render.settings import Settings


def picture(height, width, seed=0):
    """A lit ball in front of a checkered wall: (clean, noisy, albedo, normal), with the noise of a few samples."""
    y, x = np.mgrid[:height, :width]
    u, v = (x + 0.5) / width - 0.5, (y + 0.5) / height - 0.5
    checker = (np.floor(8 * u) + np.floor(8 * v)) % 2
    albedo = np.stack([0.3 + 0.5 * checker, 0.4 + 0.2 * checker, 0.7 - 0.3 * checker], axis=-1)
    normal = np.zeros((height, width, 3))
    normal[..., 2] = 1.0
    square = u**2 + v**2
    ball = square < 0.09
    albedo[ball] = 0.8, 0.5, 0.2
    normal[ball] = np.stack([u, v, np.sqrt(np.maximum(0.09 - square, 0.0))], axis=-1)[ball] / 0.3
    light = np.array([0.5, 0.6, 0.62])
    clean = 5.0 * albedo * np.maximum(normal @ light, 0.05)[..., None]
    noisy = clean * np.random.default_rng(seed).gamma(2.0, 0.5, (height, width, 1))
    return tuple(array.astype(np.float32) for array in (clean, noisy, albedo, normal))


def relative_error(image, clean):
    return np.sqrt(np.mean((image - clean) ** 2)) / clean.mean()


def test_error_falls_by_a_factor_of_eight():
    clean, noisy, albedo, normal = picture(160, 192)
    result = denoise(noisy, albedo, normal)
    assert result.shape == clean.shape and result.dtype == np.float32
    assert relative_error(result, clean) < relative_error(noisy, clean) / 8
    assert abs(result.mean() / clean.mean() - 1) < 0.02


def test_guides_help():
    clean, noisy, albedo, normal = picture(96, 96)
    assert relative_error(denoise(noisy, albedo, normal), clean) < 0.8 * relative_error(denoise(noisy), clean)


@pytest.mark.parametrize("shape", [(1, 1), (3, 17), (17, 3), (0, 5)])
def test_odd_sizes(shape):
    _, noisy, albedo, normal = picture(*shape)
    result = denoise(noisy, albedo, normal)
    assert result.shape == (*shape, 3) and np.isfinite(result).all()


def test_input_is_left_as_it_is():
    _, noisy, albedo, normal = picture(32, 32)
    before = noisy.copy(), albedo.copy(), normal.copy()
    denoise(noisy, albedo, normal)
    for array, copy in zip((noisy, albedo, normal), before):
        np.testing.assert_array_equal(array, copy)


def test_cancel_is_polled_in_the_calling_thread_and_takes_effect_at_once():
    _, noisy, albedo, normal = picture(1024, 1024)
    callers, spent = set(), []
    # Threads wait where other programs want the same cores: the quickest of three attempts counts.
    while len(spent) < 3 and (not spent or spent[-1] >= 0.6):
        started = time.perf_counter()

        def cancelled():
            callers.add(threading.get_ident())
            return time.perf_counter() - started > 0.1

        assert denoise(noisy, albedo, normal, cancelled) is None
        spent.append(time.perf_counter() - started)
    assert min(spent) < 0.6
    assert callers == {threading.get_ident()}


def test_an_error_in_the_caller_does_not_leave_the_filter_running():
    _, noisy, albedo, normal = picture(512, 512)
    threads = threading.active_count()

    def cancelled():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        denoise(noisy, albedo, normal, cancelled)
    assert threading.active_count() == threads


def test_shapes_are_checked():
    with pytest.raises(ValueError, match="height, width, 3"):
        denoise(np.zeros((4, 4, 3)), np.zeros((4, 5, 3)))


def test_pictures_are_denoised_each_by_itself():
    _, noisy, albedo, normal = picture(48, 64)
    other = 3.0 * picture(48, 64, 1)[1]
    for found, color in zip(denoise_each([noisy, other], albedo, normal), (noisy, other)):
        np.testing.assert_array_equal(found, denoise(color, albedo, normal))


def test_a_film_of_few_samples():
    clean, noisy, albedo, normal = picture(64, 96)
    film = Film(Scene(Camera(np.eye(4)), 96, 64, settings=Settings(denoise=True, exposure=2.0)))
    film.count[:] = 4
    film.surfaces[:] = 4
    film.sums["combined"][:] = 4.0 * np.concatenate([noisy, np.full((64, 96, 1), 0.75)], axis=-1).ravel()
    film.sums["albedo"][:] = 4.0 * albedo.ravel()
    film.sums["normal"][:] = 4.0 * normal.ravel()
    denoise_film(film)
    combined = film.read("Combined")
    np.testing.assert_allclose(film.read("Noisy Image")[..., :3], 2.0 * noisy, rtol=1e-6)
    assert relative_error(combined[..., :3], 2.0 * clean) < 0.25 * relative_error(2.0 * noisy, 2.0 * clean)
    np.testing.assert_array_equal(combined[..., 3], np.float32(0.75))


def sampled(height, width, samples, seen=None, scatter=1.4):
    """A film of so many samples that scatter about ``picture``, to which ``seen`` (height, width) is added as light
    that the camera sees directly; and the clean picture. ``scatter``: relative standard deviation of a sample."""
    clean, _, albedo, normal = picture(height, width)
    seen = np.zeros((height, width)) if seen is None else seen
    film = Film(Scene(Camera(np.eye(4)), width, height, settings=Settings(denoise=True)))
    rng = np.random.default_rng(0)
    values = clean * rng.gamma(scatter**-2, scatter**2, (samples, height, width, 1)) + seen[..., None]
    half = (np.arange(samples) & HALF_BIT) != 0
    film.count[:] = film.surfaces[:] = samples
    film.sums["combined"].reshape(height, width, 4)[..., :3] = values.sum(axis=0)
    film.sums["half"][:] = values[half].sum(axis=0).ravel()
    film.sums["emission"].reshape(height, width, 3)[:] = samples * seen[..., None]
    film.sums["albedo"][:], film.sums["normal"][:] = samples * albedo.ravel(), samples * normal.ravel()
    whole = values.sum(axis=3)
    film.squares[:, 1], film.squares[:, 2] = (whole**2).sum(axis=0).ravel(), whole.sum(axis=0).ravel()
    return film, clean + seen[..., None]


def test_light_that_the_camera_sees_directly_stays_sharp():
    seen = np.zeros((64, 96))
    seen[20:24, 30:50], seen[24, 30:50], seen[40, ::7] = 500.0, 150.0, 300.0
    film, clean = sampled(64, 96, LEAST_SAMPLES, seen)
    noisy = film.read("Noisy Image")[..., :3]
    denoise_film(film)
    error = [np.sqrt(np.mean((each - clean)[seen > 0.0] ** 2)) for each in (film.read("Combined")[..., :3], noisy)]
    of_one = denoise(noisy, film.read("Denoising Albedo"), film.read("Denoising Normal"))
    assert error[0] < 2.0 * error[1] < 0.2 * np.sqrt(np.mean((of_one - clean)[seen > 0.0] ** 2))
    dark = seen == 0.0
    errors = [np.sqrt(np.mean((each - clean)[dark] ** 2)) for each in (film.read("Combined")[..., :3], noisy)]
    assert errors[0] < 0.4 * errors[1]


def test_with_many_samples_the_picture_converges():
    errors, alone = [], []
    for scatter in (0.1, 0.02):  # 25 times as many samples leave as much noise
        film, clean = sampled(48, 64, 256, scatter=scatter)
        guides = film.read("Denoising Albedo"), film.read("Denoising Normal")
        alone.append(relative_error(denoise(film.read("Noisy Image")[..., :3], *guides), clean))
        denoise_film(film)
        errors.append(relative_error(film.read("Combined")[..., :3], clean))
    assert errors[0] < 0.6 * alone[0]
    assert errors[1] < 0.3 * errors[0] and alone[1] > 0.8 * alone[0]


def test_few_samples_are_left_to_the_denoiser():
    film, _ = sampled(48, 64, LEAST_SAMPLES)
    alone = denoise(film.read("Noisy Image")[..., :3], film.read("Denoising Albedo"), film.read("Denoising Normal"))
    denoise_film(film)
    changed = np.any(film.read("Combined")[..., :3] != alone, axis=2)
    assert changed.mean() < 0.02


def test_what_noise_explains_is_shrunk_to_nothing():
    denoised, noisy = np.zeros((1, 4, 3)), np.array([[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 10.0], [0.0] * 3]])
    found = shrunk(noisy, denoised, np.array([[1.0, 1.0, 1.0, 0.0]]))
    np.testing.assert_allclose(found[0], [[0.0] * 3, [1.5, 0.0, 0.0], [0.0, 0.0, 9.9], [0.0] * 3], rtol=1e-6)


def test_a_dot_is_taken_for_noise():
    noisy, denoised, variance = np.zeros((7, 7, 3)), np.zeros((7, 7, 3)), np.full((7, 7), 1.0)
    noisy[3, 3] = 1.0
    assert shrunk(noisy, denoised, variance)[3, 3, 0] > 0.5
    assert not shrunk(noisy, denoised, variance, doubts_dots=True).any()
    noisy[3, :] = 1.0
    assert shrunk(noisy, denoised, variance, doubts_dots=True)[3, 3, 0] > 0.3
