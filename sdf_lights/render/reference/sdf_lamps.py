# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""SDF lamps from their formula in NumPy alone: intervals of rays, volume, light sampling.

Closed-form intervals are not used even if a shape has them, so they can be tested against this.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from ...graph.lipschitz import global_lipschitz
from ..scene import Lamp, Ray

# Relative to the diagonal of the shape's box: parts of a ray shorter than this can be missed.
RESOLUTION = 2e-4
ROOT_ITERATIONS = 60
# Gauss–Legendre nodes in [0, 1] for a varying emission along a span; they are densest at its ends.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)
NODES, WEIGHTS = 0.5 * (1.0 + NODES), 0.5 * WEIGHTS
CHUNK = 4096  # spans whose nodes are in memory at a time


class Spans(NamedTuple):
    """Parts of rays inside a lamp: ray index, start and end distance, one row per part, in order of ray and
    distance."""

    ray: np.ndarray
    near: np.ndarray
    far: np.ndarray

    def total(self, values: np.ndarray, count: int) -> np.ndarray:
        """Sums (count,) of ``values`` (spans,), one per span, for each of ``count`` rays."""
        return np.bincount(self.ray, values, count)

    def length(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Length (N,) of each ray inside the lamp between the distances ``start`` and ``end`` along it."""
        part = np.minimum(self.far, end[self.ray]) - np.maximum(self.near, start[self.ray])
        return self.total(np.maximum(part, 0.0), len(start))


KEPT = 16  # shapes whose columns are kept for the next render, 4 MB each
_known_columns: dict[tuple[object, int], Spans] = {}  # by shape and side


class SdfLamp:
    """A lamp of the scene as an emitter. Raises ValueError if it cannot emit: flattened, or not finite."""

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
        # If no bound exists at all, nothing is certified, and rays are followed in steps of RESOLUTION.
        self._lipschitz = (
            lamp.shape.lipschitz
            if np.isfinite(lamp.shape.lipschitz)
            else global_lipschitz(lamp.shape.formula(), self._low, self._high, lamp.shape.parameters())
        )
        self.volume = self._local_volume() * abs(np.linalg.det(self._linear))
        if not self.volume > 0.0:
            raise ValueError("it has no volume")
        emission = lamp.emission.placed(lamp.shape) if lamp.emission is not None else None
        self._varying = emission if emission is not None and lamp.emission.varies else None
        mean = (
            np.ones(3)
            if emission is None
            else (emission.evaluate(np.zeros(3)) if self._varying is None else self._mean_emission())
        )
        if not mean.max() > 0.0:
            raise ValueError("its emission is zero everywhere")
        scale = lamp.density if lamp.density is not None else lamp.power / (4.0 * np.pi * self.volume * mean.mean())
        self.scale = scale * np.asarray(lamp.color, float)
        self.emission = self.scale * mean

    def _local_volume(self, side: int = 400) -> float:
        """The closed form, or chords of side² parallel rays on a jittered grid across the shape's box."""
        closed = self.lamp.shape.volume()
        if closed is not None:
            return closed
        spans = self._columns(side)[0]
        extent = self._high - self._low
        return float(np.sum(spans.far - spans.near) / side**2 * extent[0] * extent[1])

    def _columns(self, side: int) -> tuple[Spans, np.ndarray, np.ndarray]:
        """Spans, origins and directions, in the shape's local space, of side² rays along z on a jittered grid."""
        rng = np.random.Generator(np.random.Philox(0))
        u = (np.mgrid[0:side, 0:side].reshape(2, -1).T + rng.random((side * side, 2))) / side
        origins = self._low + np.concatenate([u, np.full((len(u), 1), -0.5)], 1) * (self._high - self._low)
        directions = np.broadcast_to([0.0, 0.0, 1.0], origins.shape)
        key = self.lamp.shape, side
        spans = _known_columns.get(key)
        if spans is None:
            while len(_known_columns) >= KEPT:
                _known_columns.pop(next(iter(_known_columns)), None)
            spans = _known_columns[key] = self._local_spans(origins, directions)
        return spans, origins, directions

    def _mean_emission(self, side: int = 200) -> np.ndarray:
        """Mean (3,) of the relative emission over the volume."""
        spans, origins, directions = self._columns(side)
        return self._integrals(origins, directions, spans.ray, spans.near, spans.far).sum(0) / np.sum(
            spans.far - spans.near
        )

    # --- emission -----------------------------------------------------------------------------------------------------

    def radiance(
        self, spans: Spans, origins: np.ndarray, directions: np.ndarray, start: np.ndarray, end: np.ndarray
    ) -> np.ndarray:
        """Line integral (N, 3) of the emission along each ray between the distances ``start`` and ``end``."""
        if self._varying is None:
            return self.emission * spans.length(start, end)[:, None]
        near, far = np.maximum(spans.near, start[spans.ray]), np.minimum(spans.far, end[spans.ray])
        rows = near < far
        found = self._integrals(
            (origins - self._origin) @ self._inverse.T,
            directions @ self._inverse.T,
            spans.ray[rows],
            near[rows],
            far[rows],
        )
        return self.scale * np.stack(
            [np.bincount(spans.ray[rows], channel, len(origins)) for channel in found.T], axis=1
        )

    def _integrals(self, origins, directions, ray, near, far) -> np.ndarray:
        """Integral (spans, 3) of the relative emission over each span, of rays in the shape's local space."""
        found = np.zeros((len(ray), 3))
        for first in range(0, len(ray), CHUNK):
            part = slice(first, first + CHUNK)
            t = near[part, None] + (far - near)[part, None] * NODES
            points = origins[ray[part], None] + t[..., None] * directions[ray[part], None]
            found[part] = np.einsum("snc,n,s->sc", self._varying.evaluate(points), WEIGHTS, (far - near)[part])
        return found

    # --- rays ---------------------------------------------------------------------------------------------------------

    def spans(self, origins: np.ndarray, directions: np.ndarray) -> Spans:
        """Every part of the rays, from their origins (N, 3) along directions (N, 3), that is inside the lamp; distances
        in world space."""
        # The local direction is not made a unit vector, so that distances need no conversion.
        return self._local_spans((origins - self._origin) @ self._inverse.T, directions @ self._inverse.T)

    def _field(self, origins: np.ndarray, directions: np.ndarray, ray: np.ndarray, t: np.ndarray) -> np.ndarray:
        return self.lamp.shape.distance(origins[ray] + t[:, None] * directions[ray])

    def _local_spans(self, origins: np.ndarray, directions: np.ndarray) -> Spans:
        """Cover each ray's segment in the shape's box with balls.

        A point where the field is φ proves that there is no boundary within |φ| / L of it. The rest on both sides of
        the middle of an interval is handled in the same way, until it is shorter than ``RESOLUTION``. Then there is a
        boundary in it if its ends differ in sign.
        """
        inverse = 1.0 / np.where(directions == 0.0, 1e-300, directions)
        a, b = (self._low - origins) * inverse, (self._high - origins) * inverse
        start, end = np.maximum(np.minimum(a, b).max(1), 0.0), np.maximum(a, b).min(1)
        ray = np.flatnonzero(start < end)
        speed = np.linalg.norm(directions, axis=1)
        low, high = start[ray], end[ray]
        low_in, high_in = (self._field(origins, directions, ray, t) <= 0.0 for t in (low, high))
        edges = [(ray[low_in], low[low_in]), (ray[high_in], high[high_in])]
        brackets = []
        while len(ray):
            middle = 0.5 * (low + high)
            value = self._field(origins, directions, ray, middle)
            # An undefined field proves nothing, and counts as outside.
            radius = np.nan_to_num(np.abs(value)) / (self._lipschitz * speed[ray])
            inside = value <= 0.0
            low, high = (
                np.concatenate(part)
                for part in ((low, np.minimum(middle + radius, high)), (np.maximum(middle - radius, low), high))
            )
            low_in, high_in = (np.concatenate(part) for part in ((low_in, inside), (inside, high_in)))
            ray = np.tile(ray, 2)
            short = high - low <= RESOLUTION * self._diagonal / speed[ray]
            crossed = short & (low_in != high_in)
            brackets.append((ray[crossed], low[crossed], high[crossed]))
            ray, low, high, low_in, high_in = (array[~short] for array in (ray, low, high, low_in, high_in))
        if brackets:
            ray, low, high = (np.concatenate(part) for part in zip(*brackets))
            edges.append((ray, self._root(origins, directions, ray, low, high)))
        ray, t = (np.concatenate(part) for part in zip(*edges))
        order = np.lexsort((t, ray))
        ray, t = ray[order], t[order]
        return Spans(ray[::2], t[::2], t[1::2])

    def _root(self, origins, directions, ray, low, high) -> np.ndarray:
        """A root of the field in each bracket by the Illinois variant of false position, to 1e-12 of the box."""
        f_low, f_high = (self._field(origins, directions, ray, t) for t in (low, high))
        low, high = low.copy(), high.copy()
        tolerance = 1e-12 * self._diagonal / np.linalg.norm(directions, axis=1)[ray]
        root = 0.5 * (low + high)
        open_ = np.flatnonzero((high - low > tolerance) & ((f_low <= 0.0) != (f_high <= 0.0)))
        for _ in range(ROOT_ITERATIONS):
            if not len(open_):
                break
            a, b, fa, fb = low[open_], high[open_], f_low[open_], f_high[open_]
            c = np.clip((a * fb - b * fa) / (fb - fa), a, b)
            fc = self._field(origins, directions, ray[open_], c)
            with_low = (fc <= 0.0) == (fa <= 0.0)
            # The value of an end that stays twice is halved, so that both ends converge.
            step = np.abs(c - root[open_])
            root[open_] = c
            low[open_], high[open_] = np.where(with_low, c, a), np.where(with_low, b, c)
            f_low[open_] = np.where(with_low, fc, 0.5 * fa)
            f_high[open_] = np.where(with_low, 0.5 * fb, fc)
            open_ = open_[(step > tolerance[open_]) & (fc != 0.0)]
        return root

    # --- light sampling -----------------------------------------------------------------------------------------------

    def sample(self, rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
        """Directions (N, 3) from the points x (N, 3) to points uniform in the lamp: projection sampling."""
        points = np.empty(x.shape)
        missing = np.arange(len(x))
        # The filled fraction of the box bounds the wait; a shape too thin to be hit gives up in the end.
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
        """Density of ``sample`` in solid angle for ``count`` rays: Σ (far³ − near³) / 3V (Huang et al. 2026, eq. 4)."""
        return spans.total(spans.far**3 - spans.near**3, count) / (3.0 * self.volume)
