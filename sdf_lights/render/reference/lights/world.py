# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world. See ``emitter.py``."""

from __future__ import annotations

import numpy as np

from ...images import colors
from ...scene import Scene, World
from ..emission_nodes import Emission
from ..images import interpolated
from ..vectors import luminance, uniform_sphere
from .emitter import BACKGROUND, Emitter


def direction_of(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Unit directions (N, 3) of equirectangular coordinates."""
    angle, latitude = (0.5 - u) * 2.0 * np.pi, (v - 0.5) * np.pi
    return np.stack([np.cos(latitude) * np.cos(angle), np.cos(latitude) * np.sin(angle), np.sin(latitude)], -1)


class Sky(Emitter):
    """The world. An image is sampled by texels in proportion to their brightness and solid angle."""

    def __init__(self, world: World, scene: Scene):
        super().__init__(world.visibility)
        self.color = world.strength * np.asarray(world.color, float)
        self.rotation = np.asarray(world.rotation, float)
        self.pixels = self.points = None
        if world.emission is not None:
            self.points = Emission(world.emission, scene)
            rows = 64
            v, u = (np.mgrid[0:rows, 0 : 2 * rows] + 0.5).reshape(2, -1) / [[rows], [2 * rows]]
            directions = direction_of(u, v)
            self.pixels = self.points.radiance(directions, 0).reshape(rows, 2 * rows, 3)
            self._build_table()
        elif world.image is not None and 0 <= world.image < len(scene.images):
            self.pixels = colors(scene.images[world.image]).astype(float)
            self._build_table()

    @property
    def black(self) -> bool:
        """Whether it gives no light."""
        return not np.any(self.color > 0.0)

    def _build_table(self):
        rows, columns = self.pixels.shape[:2]
        bright = np.maximum(luminance(self.pixels[..., :3]), 0.0)
        # Interpolation carries light into neighbouring texels, so every direction keeps some probability.
        spread = (
            sum(
                np.roll(np.pad(bright, ((1, 1), (0, 0)), "edge"), (i, j), (0, 1))[1:-1]
                for i in (-1, 0, 1)
                for j in (-1, 0, 1)
            )
            / 9.0
        )
        spread += 0.1 * spread.mean() + 1e-12
        edges = np.sin((np.arange(rows + 1) / rows - 0.5) * np.pi)
        weights = spread * np.diff(edges)[:, None]
        self.table = np.cumsum(weights.ravel() / weights.sum())
        self.density = spread / weights.sum() * columns / (2.0 * np.pi)  # by solid angle

    def radiance(self, directions: np.ndarray, kind: np.ndarray | int = 0) -> np.ndarray:
        """Radiance (N, 3) along directions (N, 3). ``kind``: ``scene.Ray`` of the rays; 0 in light sampling."""
        if self.points is not None:
            return self.color * self.points.radiance(directions, kind)
        if self.pixels is None:
            return np.broadcast_to(self.color, directions.shape)
        u, v = self._coordinates(directions)
        return self.color * interpolated(self.pixels, u, v, "Linear", "REPEAT")[:, :3]

    def _coordinates(self, directions):
        x, y, z = self.rotation @ directions.T
        return 0.5 - np.arctan2(y, x) / (2.0 * np.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi

    def pdf(self, directions: np.ndarray) -> np.ndarray:
        """Density (N,) of ``sample`` per solid angle."""
        if self.pixels is None:
            return np.full(len(directions), 0.25 / np.pi)
        rows, columns = self.density.shape
        u, v = self._coordinates(directions)
        row = np.clip((v * rows).astype(int), 0, rows - 1)
        return self.density[row, (u * columns).astype(int) % columns]

    def sample(self, rng, x):
        count = len(x)
        far = np.full(count, np.inf)
        if self.pixels is None:
            wi = uniform_sphere(rng, count)
        else:
            rows, columns = self.density.shape
            texel = np.minimum(np.searchsorted(self.table, rng.random(count), side="right"), self.table.size - 1)
            row, column = np.divmod(texel, columns)
            low, high = (np.sin(((row + k) / rows - 0.5) * np.pi) for k in (0, 1))
            z = low + rng.random(count) * (high - low)
            angle = (0.5 - (column + rng.random(count)) / columns) * 2.0 * np.pi
            s = np.sqrt(np.maximum(1.0 - z * z, 0.0))
            wi = np.stack([s * np.cos(angle), s * np.sin(angle), z], -1) @ self.rotation
        return wi, far, self.radiance(wi), self.pdf(wi)

    def hit(self, origins, directions):
        return np.full(len(origins), BACKGROUND), self.radiance(directions), self.pdf(directions)
