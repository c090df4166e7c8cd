# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The denoised picture of a film.

A denoiser takes away noise, but leaves an error of its own, which more samples do not reduce. Two things limit it:

- Light that the camera sees directly (the pass Emission) may be added after all other light was denoised. A lamp may be
  thousands of times as bright as what stands beside it. If its edge is blurred by a part of a pixel, this is more than
  all noise of the picture.
- The noisy picture is used where noise does not explain how far it is from the denoised one. So with many samples the
  picture converges.

Both choose between two pictures of a pixel, one with less noise and one with less bias. The estimator of James and
Stein (1961) shrinks the second towards the first: Gu, Iglesias-Guitian and Moon (2022), "Neural James-Stein Combiner
for Unbiased and Biased Renderings".
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .denoise import denoise, denoise_each
from .film import LEAST_SAMPLES, Film

# Standard deviations of noise that explain a difference of the denoised picture from the noisy one. With fewer, noise
# comes back where few samples find the light, so that most pixels do not know how noisy they are.
DEVIATIONS = 2.0


def denoise_film(film: Film, cancelled: Callable[[], bool] = lambda: False) -> None:
    """Replace the film's Combined pass by a denoised one, unless cancelled; Noisy Image keeps the original."""
    result = _denoised(film, cancelled)
    if result is None:
        return
    if film.catches:
        shadow = denoise(film.read("Shadow Catcher"), cancelled=cancelled)
        if shadow is None:
            return
        film.replace_shadow(shadow)
    film.replace_combined(result)


def _denoised(film: Film, cancelled: Callable[[], bool]) -> np.ndarray | None:
    """(height, width, RGB) the denoised picture; None if cancelled."""
    noisy, seen = film.read("Noisy Image")[..., :3], film.read("Emission")
    guides = film.read("Denoising Albedo"), film.read("Denoising Normal")
    # Shadow catchers show other light than the samples scatter about.
    if film.catches or not (film.count >= LEAST_SAMPLES).any():
        return denoise(noisy, *guides, cancelled)
    found = denoise_each([noisy, noisy - seen] if seen.any() else [noisy], *guides, cancelled)
    if found is None:
        return None
    result, *rest = found
    halves, scatter = film.variances()
    if rest:
        # The noise of all light counts, as nearly all of it is the lamp's where one is seen. Not the scatter of
        # samples: edges of lamps are stratified well, so it is much too large there.
        result = shrunk(rest[0] + seen, result, halves)
    if len(film.caustics):  # the variance does not have their noise
        return result
    variance = np.maximum(halves, scatter)
    # A pixel whose samples have missed rare light knows nothing of that noise, but its neighbours do.
    return shrunk(noisy, result, DEVIATIONS**2 * np.maximum(variance, _smoothed(variance)), doubts_dots=True)


def shrunk(noisy: np.ndarray, denoised: np.ndarray, variance: np.ndarray, doubts_dots: bool = False) -> np.ndarray:
    """d + max(0, 1 − v / |n − d|²) (n − d), of pictures n and d (height, width, RGB) and the variance v (height, width)
    of n, a sum over RGB: the positive part of the estimator of James and Stein.

    ``doubts_dots``: |n − d|² is at most its mean over 3 × 3 pixels, so one that differs alone is taken for noise.
    """
    difference = noisy - denoised
    square = (difference**2).sum(axis=2)
    if doubts_dots:
        square = np.minimum(square, _smoothed(square))
    kept = 1.0 - np.divide(variance, square, out=np.ones_like(variance), where=square > 0.0)
    return (denoised + np.maximum(kept, 0.0)[..., None] * difference).astype(np.float32)


def _smoothed(values: np.ndarray) -> np.ndarray:
    """Means over 3 × 3 pixels with binomial weights, (height, width)."""
    padded = np.pad(values, 1, mode="edge")
    rows = (padded[:-2] + 2.0 * padded[1:-1] + padded[2:]) / 4.0
    return (rows[:, :-2] + 2.0 * rows[:, 1:-1] + rows[:, 2:]) / 4.0
