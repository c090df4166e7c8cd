# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""SDF lamps from nothing but the NumPy reading of their formula: where rays run inside, volume, light sampling.

Closed-form intervals are not used even where a shape has them, so that they can be tested against this.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from ..scene import Lamp, Ray

# Shortest march step as a share of the diagonal of the shape's box. Parts of a ray shorter than this can be missed.
SHORTEST_STEP = 5e-4
ROOT_ITERATIONS = 60


class Spans(NamedTuple):
    """Parts of rays inside a lamp: ray index, start and end distance, one row a part, in order of ray and distance."""

    ray: np.ndarray
    near: np.ndarray
    far: np.ndarray

    def total(self, values: np.ndarray, count: int) -> np.ndarray:
        """Sum of ``values``, one a span, for each of ``count`` rays."""
        return np.bincount(self.ray, values, count)

    def length(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Length of each ray inside the lamp between the distances ``start`` and ``end`` along it."""
        part = np.minimum(self.far, end[self.ray]) - np.maximum(self.near, start[self.ray])
        return self.total(np.maximum(part, 0.0), len(start))


class SdfLamp:
    """A lamp of the scene as an emitter. Raises ValueError where it cannot emit: flattened, or not finite."""

    def __init__(self, lamp: Lamp):
        self.lamp = lamp
        self.visibility = Ray(lamp.visibility)
        matrix = np.asarray(lamp.matrix, float)
        self._linear, self._origin = matrix[:3, :3], matrix[:3, 3]
        scales = np.linalg.svd(self._linear, compute_uv=False) if np.isfinite(matrix).all() else np.zeros(3)
        if scales[-1] <= 1e-9 * scales[0] or lamp.shape.validate():
            raise ValueError(lamp.shape.validate() or "its scale is zero along an axis")
        self._inverse = np.linalg.inv(self._linear)
        low, high = (np.asarray(corner, float) for corner in lamp.shape.bounds())
        self._low, self._high = low - 1e-9 * (high - low), high + 1e-9 * (high - low)
        self._diagonal = float(np.linalg.norm(high - low))
        self.volume = self._local_volume() * abs(np.linalg.det(self._linear))
        if not self.volume > 0.0:
            raise ValueError("it has no volume")
        scale = lamp.density if lamp.density is not None else lamp.power / (4.0 * np.pi * self.volume)
        self.emission = scale * np.asarray(lamp.color, float)

    def _local_volume(self, side: int = 400) -> float:
        """The closed form, or chords of side² parallel rays on a jittered grid across the shape's box."""
        closed = self.lamp.shape.volume()
        if closed is not None:
            return closed
        rng = np.random.Generator(np.random.Philox(0))
        u = (np.mgrid[0:side, 0:side].reshape(2, -1).T + rng.random((side * side, 2))) / side
        extent = self._high - self._low
        origins = self._low + np.concatenate([u, np.full((len(u), 1), -0.5)], 1) * extent
        spans = self._local_spans(origins, np.broadcast_to([0.0, 0.0, 1.0], origins.shape))
        return float(np.sum(spans.far - spans.near) / len(u) * extent[0] * extent[1])

    # --- rays ---------------------------------------------------------------------------------------------------------

    def spans(self, origins: np.ndarray, directions: np.ndarray) -> Spans:
        """Every part of the rays, from their origins on, that is inside the lamp; distances in world space."""
        # The local direction is not made a unit vector, so that distances need no conversion.
        return self._local_spans((origins - self._origin) @ self._inverse.T, directions @ self._inverse.T)

    def _local_spans(self, origins: np.ndarray, directions: np.ndarray) -> Spans:
        """March by |φ| / L, which no boundary can be nearer than, and find the roots between changes of sign."""
        field = self.lamp.shape.distance
        inverse = 1.0 / np.where(directions == 0.0, 1e-300, directions)
        a, b = (self._low - origins) * inverse, (self._high - origins) * inverse
        start, end = np.maximum(np.minimum(a, b).max(1), 0.0), np.maximum(a, b).min(1)
        ray = np.flatnonzero(start < end)
        t, speed = start[ray], np.linalg.norm(directions[ray], axis=1)
        shortest = SHORTEST_STEP * self._diagonal / speed
        value = field(origins[ray] + t[:, None] * directions[ray])
        edges = [(ray[value <= 0.0], t[value <= 0.0])]
        brackets = []
        while len(ray):
            step = np.maximum(np.abs(value) / (self.lamp.shape.lipschitz * speed), shortest)
            following = np.minimum(t + step, end[ray])
            next_value = field(origins[ray] + following[:, None] * directions[ray])
            changed = (value <= 0.0) != (next_value <= 0.0)
            brackets.append((ray[changed], t[changed], following[changed]))
            finished = following >= end[ray]
            inside = finished & (next_value <= 0.0)
            edges.append((ray[inside], end[ray[inside]]))
            keep = ~finished
            ray, t, value, speed, shortest = ray[keep], following[keep], next_value[keep], speed[keep], shortest[keep]
        if brackets:
            ray, low, high = (np.concatenate(part) for part in zip(*brackets))
            edges.append((ray, self._root(origins[ray], directions[ray], low, high)))
        ray, t = (np.concatenate(part) for part in zip(*edges))
        order = np.lexsort((t, ray))
        ray, t = ray[order], t[order]
        return Spans(ray[::2], t[::2], t[1::2])

    def _root(self, origins, directions, low, high) -> np.ndarray:
        """A root of the field in each bracket by bisection to the last bits, which trusts nothing but the sign."""
        field = self.lamp.shape.distance
        sign = field(origins + low[:, None] * directions) <= 0.0
        for _ in range(ROOT_ITERATIONS):
            middle = 0.5 * (low + high)
            same = (field(origins + middle[:, None] * directions) <= 0.0) == sign
            low, high = np.where(same, middle, low), np.where(same, high, middle)
            if np.all(high - low <= 1e-12 * np.abs(high) + 1e-14):
                break
        return 0.5 * (low + high)

    # --- light sampling -----------------------------------------------------------------------------------------------

    def sample(self, rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
        """Directions from the points x to points uniform in the lamp: projection sampling."""
        points = np.empty(x.shape)
        missing = np.arange(len(x))
        # The share of the box that is filled bounds the wait; a shape too thin to be hit at all gives up in the end.
        for _ in itertools.repeat(None, 10_000):
            if not len(missing):
                break
            trial = self._low + rng.random((len(missing), 3)) * (self._high - self._low)
            accepted = self.lamp.shape.distance(trial) <= 0.0
            points[missing[accepted]] = trial[accepted]
            missing = missing[~accepted]
        points[missing] = 0.5 * (self._low + self._high)
        towards = points @ self._linear.T + self._origin - x
        return towards / np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-300)

    def pdf(self, spans: Spans, count: int) -> np.ndarray:
        """Density of ``sample`` in solid angle for ``count`` rays: Σ (far³ − near³) / 3V, equation 4 of Huang et al. 2026."""
        return spans.total(spans.far**3 - spans.near**3, count) / (3.0 * self.volume)
