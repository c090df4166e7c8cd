# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A million samples per pixel: the film does not drift, the pattern does not repeat, and the error falls as
expected."""

from __future__ import annotations

import functools
import math

import numpy as np

from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.film import Film
from sdf_lights.render.scene import Lamp
from sdf_lights.sdf.shapes import Sphere
from support.scenes import rotation, scaling, translation

from . import Figure, attraction, case
from .stage import ALBEDO, STANDARD_ERRORS, floor, from_above, places, settings, volumes_unknown

MOST = 20  # log₂ of the samples of a pixel
FEWEST = 8
PIXELS = 2
WIDTH = 1e-5  # m: the irradiance over a pixel this large is its value in the middle, to 1e-11
# Float32 corners of the floor and float64 sums; nothing else is rounded to more than 1e-12.
ROUNDING = 2.0**-23
MATRIX = translation(0.2, 0.1, 0.75) @ rotation("x", 20.0) @ scaling(0.6, 0.4, 0.5)
POWER = 40.0  # W
LAMP = Lamp("lamp", Sphere(1.0), MATRIX, POWER)
UP = np.array((0.0, 0.0, 1.0))


@functools.lru_cache(maxsize=2)
def errors(quick: bool) -> tuple[list[int], np.ndarray]:
    """Numbers of samples, and relative errors (numbers, pixels and seeds) of pixels under an ellipsoid close by."""
    at = (0.0, 0.0, 0.0)
    points = places(at, WIDTH, PIXELS)
    expected = attraction.of_ellipsoid(MATRIX, points, UP).reshape(PIXELS, PIXELS)
    expected *= ALBEDO / math.pi * attraction.intensity(POWER)
    counts = [1 << power for power in range(FEWEST, MOST + 1, 4)]
    found = []
    for seed in range(1 if quick else 3):
        scene = floor(from_above(at, 0.05, WIDTH), PIXELS, at, 0.1, [LAMP], settings(counts[-1], seed))
        film = Film(scene)
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        done = 0
        for count in counts:
            renderer.sample(done, count - done, lambda: False, lambda part: None)
            assert np.all(film.count == count)
            light = film.light()[0].mean(axis=1).reshape(PIXELS, PIXELS)
            found.append((light / expected - 1.0).ravel())
            done = count
        renderer.finish()
    return counts, np.concatenate(np.reshape(found, (-1, len(counts), PIXELS * PIXELS)), axis=1)


@case("million-samples-mean", slow=True)
def mean(quick):
    """relative error of the mean of pixels of 2^20 samples against the analytic value"""
    _, found = errors(quick)
    scatter = float(found[-1].std(ddof=1) / math.sqrt(found.shape[1]))
    unknown = volumes_unknown(LAMP, np.zeros(3), UP) / (
        attraction.intensity(POWER) * attraction.of_ellipsoid(MATRIX, np.zeros((1, 3)), UP)[0]
    )
    return Figure(
        abs(float(found[-1].mean())),
        STANDARD_ERRORS * math.hypot(scatter, unknown) + ROUNDING,
        dict(standard_error=scatter, volumes_unknown=unknown),
    )


@case("million-samples-slope", slow=True)
def slope(quick):
    """exponent of the error against the number of samples, from 2^8 to 2^20; independent samples have −1/2"""
    counts, found = errors(quick)
    rms = np.sqrt(np.mean(found**2, axis=1))
    exponent = float(np.polyfit(np.log(counts), np.log(rms), 1)[0])
    return Figure(exponent, -0.5, {f"error_{count}": float(value) for count, value in zip(counts, rms)})
