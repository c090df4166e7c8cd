# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimators of the irradiance that a lamp gives an unoccluded point, to compare samplers of directions by.

    E = ∫ L(ω) max(0, n·ω) dω,     L(ω) = ρ Σ ∫ profile(x + r·ω) dr over the intervals inside

An estimator is a kernel ``f(block, lamp, x, n, u, spans, shell) -> value`` whose mean over uniform u (``DIMENSIONS``
numbers) is E; ``Technique`` names them all. ``shell`` is the profile, the emission at a point relative to the lamp's
uniform ρ. Values are of the red channel.
"""

from __future__ import annotations

import enum
import math
import time
from dataclasses import dataclass

import numpy as np

from ..jit import kernel
from ..vec import add, dot, frame, madd, normalize, sub, to_world, vec
from .lamps import direction_pdf, interior_point, lamps, new_spans, sample_direction, trace
from .points import disk_point

DIMENSIONS = 7  # a direction by the cosine (2), a point in the lamp (3), a place in the intervals of each ray (2)
CHUNK = 1 << 17


EVEN = (1.0, 0.0, 1.0, 0.0)
TORUS_SHELL = (3.2, 3.0 / 0.35, 1.0, 0.35)  # the published check's emission that varies


@kernel
def profile(x, shell):
    """gain · exp(−falloff · |φ|), φ the distance to the torus of the given radii round the world's z axis.

    ``shell`` is (gain, falloff, major radius, minor radius). Numbers instead of a kernel keep the estimators cached.
    """
    ring = math.sqrt(x[0] * x[0] + x[1] * x[1]) - shell[2]
    return shell[0] * math.exp(-shell[1] * abs(math.sqrt(ring * ring + x[2] * x[2]) - shell[3]))


@kernel
def _radiance(block, lamp, x, d, spans, count, u, shell):
    """Unbiased estimate of L from one point in each interval."""
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        # A different place in each interval from one number: each is uniform, which is all an unbiased sum needs.
        place = (u + index * 0.6180339887498949) % 1.0
        total += 2.0 * h * profile(madd(x, c + (2.0 * place - 1.0) * h, d), shell)
    return total * lamps(block)[lamp].emission[0]


@kernel
def _ray(block, lamp, x, n, d, spans, u, shell):
    """Value L·max(0, n·ω) of a direction, and its density under projection sampling."""
    count = trace(block, lamp, x, d, spans)
    value = _radiance(block, lamp, x, d, spans, count, u, shell) * max(dot(n, d), 0.0)
    return value, direction_pdf(block, lamp, x, n, d, spans, count)


@kernel
def _cosine_direction(n, u1, u2):
    """Direction of density cos θ/π about n. Malley's method: a uniform point of the disk, lifted to the hemisphere."""
    x, y = disk_point(u1, u2)
    t, b = frame(n)
    return to_world((x, y, math.sqrt(max(1.0 - x * x - y * y, 0.0))), t, b, n)


@kernel
def uniform_directions(block, lamp, x, n, u, spans, shell):
    """Uniform directions of the whole sphere."""
    z = 1.0 - 2.0 * u[0]
    ring = math.sqrt(max(1.0 - z * z, 0.0))
    angle = 2.0 * math.pi * u[1]
    d = (ring * math.cos(angle), ring * math.sin(angle), z)
    return 4.0 * math.pi * _ray(block, lamp, x, n, d, spans, u[5], shell)[0]


@kernel
def cosine_directions(block, lamp, x, n, u, spans, shell):
    """Directions in proportion to the cosine: what a diffuse BSDF samples."""
    d = _cosine_direction(n, u[0], u[1])
    cosine = dot(n, d)
    return math.pi * _ray(block, lamp, x, n, d, spans, u[5], shell)[0] / cosine if cosine > 0.0 else 0.0


@kernel
def point_in_volume(block, lamp, x, n, u, spans, shell):
    """A uniform point of the lamp, treated as a point light; its variance is infinite where x is inside."""
    row = lamps(block)[lamp]
    y = add(vec(row.center), interior_point(block, lamp, u[2], u[3], u[4]))
    offset = sub(y, x)
    square = dot(offset, offset)
    cosine = max(dot(n, normalize(offset)), 0.0)
    return row.emission[0] * row.volume * profile(y, shell) * cosine / square if square > 0.0 else 0.0


@kernel
def projection(block, lamp, x, n, u, spans, shell):
    """Projection sampling: the whole line through a uniform point, by its directional density."""
    d = sample_direction(block, lamp, x, n, u[2], u[3], u[4])
    value, pdf = _ray(block, lamp, x, n, d, spans, u[5], shell)
    return value / pdf if pdf > 0.0 else 0.0


@kernel
def cosine_and_projection(block, lamp, x, n, u, spans, shell):
    """One cosine-weighted and one projection sample, combined by the balance heuristic."""
    total = 0.0
    d = _cosine_direction(n, u[0], u[1])
    for technique in range(2):
        if technique == 1:
            d = sample_direction(block, lamp, x, n, u[2], u[3], u[4])
        value, pdf = _ray(block, lamp, x, n, d, spans, u[5 + technique], shell)
        both = pdf + max(dot(n, d), 0.0) / math.pi
        total += value / both if both > 0.0 else 0.0
    return total


class Technique(enum.IntEnum):
    UNIFORM = 0
    COSINE = 1
    POINT = 2
    PROJECTION = 3
    MIS = 4


UNIFORM, COSINE, POINT, PROJECTION = map(int, list(Technique)[:4])


@kernel
def _values(technique, blocks, lamp, x, n, numbers, spans, shell, out):
    block = blocks[0]
    for i in range(len(numbers)):
        u = (numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3], numbers[i, 4], numbers[i, 5], numbers[i, 6])
        if technique == UNIFORM:
            out[i] = uniform_directions(block, lamp, x, n, u, spans, shell)
        elif technique == COSINE:
            out[i] = cosine_directions(block, lamp, x, n, u, spans, shell)
        elif technique == POINT:
            out[i] = point_in_volume(block, lamp, x, n, u, spans, shell)
        elif technique == PROJECTION:
            out[i] = projection(block, lamp, x, n, u, spans, shell)
        else:
            out[i] = cosine_and_projection(block, lamp, x, n, u, spans, shell)


@dataclass(frozen=True)
class Estimate:
    """Mean and variance of one sample, the standard error of the mean, and the seconds spent in the estimator."""

    mean: float
    variance: float
    error: float
    seconds: float


def run(technique: Technique, blocks: np.ndarray, lamp: int, x, n, samples: int, seed: int,
        shell: tuple[float, float, float, float] = EVEN) -> Estimate:
    """Mean and variance of ``samples`` values of an estimator.

    ``blocks`` is a one-element array of a block with the tables of ``lamps.TABLES``; x and n are a world point and the
    unit normal there. Deterministic for a seed, but for the time.
    """
    rng = np.random.default_rng(seed)
    x, n = tuple(map(float, x)), tuple(map(float, n))
    spans = new_spans(int(blocks["lamp_rows"][0]), int(blocks["lamps_count"][0]))
    total = square = seconds = 0.0
    shift, done = None, 0
    while done < samples:
        numbers = rng.random((min(CHUNK, samples - done), DIMENSIONS))
        values = np.empty(len(numbers))
        start = time.perf_counter()
        _values(int(technique), blocks, lamp, x, n, numbers, spans, shell, values)
        seconds += time.perf_counter() - start
        if shift is None:
            shift = values.mean()  # sums about a first guess of the mean, so that small variances do not cancel
        total += np.sum(values - shift)
        square += np.sum((values - shift) ** 2)
        done += len(numbers)
    mean = total / done
    variance = max(square / done - mean * mean, 0.0) * done / max(done - 1, 1)
    return Estimate(shift + mean, variance, math.sqrt(variance / done), seconds)
