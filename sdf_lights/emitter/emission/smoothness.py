# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of points per ray that a varying emission needs, and where it is negative or undefined: measured on some
rays."""

from __future__ import annotations

import inspect
import math
from typing import NamedTuple

import numpy as np

from ...graph.numpy_evaluation import evaluate_all
from ...sdf.emission import GREATEST, Placed
from ...sdf.shapes import Shape
from .varying import place_point, point_count

RAYS, STEPS = 64, 384
RATES = (4, 8, 16, 32, 64, 128, 256)  # points of a ray through the diagonal of the shape's box
TOLERANCE = (
    0.02  # standard deviation of a ray's integral under shifts of its points, relative to the greatest integrals
)
SHIFTS = (np.arange(8) + 0.5) / 8.0
SEED = 1


class Tried(NamedTuple):
    """``rate`` is points per metre of the shape's local space; the others are fractions of the points inside."""

    rate: float
    negative: float
    undefined: float


def try_rays(shape: Shape, placed: Placed) -> Tried:
    """Measure the emission along random rays through a shape."""
    low, high = shape.bounds()
    diagonal = float(np.linalg.norm(high - low))
    rng = np.random.default_rng(SEED)
    through = low + rng.random((RAYS, 3)) * (high - low)
    ways = rng.standard_normal((RAYS, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    a, b = ((corner - through) / ways for corner in (low, high))
    start, end = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    step = (end - start) / STEPS
    t = start[:, None] + step[:, None] * (np.arange(STEPS) + rng.random((RAYS, STEPS)))
    points = through[:, None] + t[..., None] * ways[:, None]
    inside = shape.distance(points) <= 0.0
    colour = placed.evaluate(points[inside])
    written = np.stack(evaluate_all(placed.written, points[inside], placed.parameters), axis=-1)
    with np.errstate(invalid="ignore"):
        undefined = ~(np.abs(written) <= GREATEST)
        negative = written < 0.0
    shares = [float(part.any(axis=-1).mean()) if part.size else 0.0 for part in (negative & ~undefined, undefined)]
    brightness = np.zeros(inside.shape)
    brightness[inside] = colour.mean(axis=-1)
    runs = [(ray, first, last) for ray in range(RAYS) for first, last in _runs(inside[ray])]
    for points_across in RATES:
        error, size = np.zeros((RAYS, len(SHIFTS))), np.zeros(RAYS)
        for ray, first, last in runs:
            values = brightness[ray, first:last]
            length = step[ray] * len(values)
            whole = float(values.mean()) * length
            error[ray] += _sums(values, length, points_across / diagonal) - whole
            size[ray] += whole
        if math.sqrt(np.mean(error**2)) <= TOLERANCE * math.sqrt(np.mean(size**2)):
            break
    return Tried(points_across / diagonal, *shares)


def _runs(inside: np.ndarray) -> list[tuple[int, int]]:
    """First and end of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist()))


def _sums(values: np.ndarray, length: float, rate: float) -> np.ndarray:
    """The integral of evenly spaced values, by the rule of ``emission.line_integral`` with each of ``SHIFTS``."""
    count = inspect.unwrap(point_count)(rate * length)
    t, weight = inspect.unwrap(place_point)((np.arange(count) + SHIFTS[:, None]) / count)
    found = np.interp(t, (np.arange(len(values)) + 0.5) / len(values), values)
    return (weight * found).mean(axis=1) * length
