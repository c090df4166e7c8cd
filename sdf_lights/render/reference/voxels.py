# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values between the voxels of grids: see ``render.voxels``, whose bricks are one array here."""

from __future__ import annotations

import itertools
import zlib

import numpy as np

from ..kernels.voxels import BY_CHANCE, CUBIC
from ..voxels import BACKGROUND, CHANNELS, COUNTS, HEAD, SIDE


def _cubic_weights(t: np.ndarray) -> np.ndarray:
    """(N, 4) of uniform cubic B-splines."""
    basis = np.array([(1, -3, 3, -1), (4, 0, -6, 3), (1, 3, 3, -3), (0, 0, 0, 1)]) / 6.0
    return np.stack([np.ones_like(t), t, t * t, t**3], -1) @ basis.T


class Voxels:
    """A grid by its packed ``numbers`` (n,)."""

    def __init__(self, numbers: np.ndarray):
        counts = numbers[COUNTS:CHANNELS].astype(int)
        self.channels = int(numbers[CHANNELS])
        self._matrix = numbers[:COUNTS].reshape(3, 4).astype(float)
        self._background = numbers[BACKGROUND : BACKGROUND + self.channels].astype(float)
        places = numbers[HEAD : HEAD + counts.prod()].astype(int).reshape(counts[::-1])
        bricks = numbers[HEAD + counts.prod() :].reshape(-1, SIDE, SIDE, SIDE, self.channels)
        self._values = bricks[places].transpose(0, 3, 1, 4, 2, 5, 6).reshape(*(SIDE * counts[::-1]), self.channels)

    def _at(self, index: np.ndarray) -> np.ndarray:
        """(N, channels) of voxels x, y, z (N, 3)."""
        index, shape = index[:, ::-1], np.array(self._values.shape[:3])
        inside = ((index >= 0) & (index < shape)).all(1)
        found = self._values[tuple(np.clip(index, 0, shape - 1).T)].astype(float)
        return np.where(inside[:, None], found, self._background)

    def between(self, x: np.ndarray, mode: int) -> np.ndarray:
        """(N, channels) interpolated at points of object space (N, 3)."""
        p = np.clip(x @ self._matrix[:, :3].T + self._matrix[:, 3], -1e9, 1e9)
        first = np.floor(p).astype(int)
        t = p - first
        if mode == BY_CHANCE:
            chance = np.random.default_rng(zlib.crc32(p.tobytes())).random(p.shape)
            return self._at(first + (chance < t))
        weights = _cubic_weights(t) if mode == CUBIC else np.stack([1.0 - t, t], -1)
        total = np.zeros((len(p), self.channels))
        for place in itertools.product(range(weights.shape[-1]), repeat=3):
            share = weights[:, 0, place[0]] * weights[:, 1, place[1]] * weights[:, 2, place[2]]
            total += share[:, None] * self._at(first + place - int(mode == CUBIC))
        return total
