# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp for arrays of points and rays, without a renderer: the results of the kernels as NumPy arrays."""

from __future__ import annotations

import numpy as np

from ..jit import block_dtype, fill_table, kernel
from . import lamps
from .building import build, pack
from .sampling import projection

BLOCK = block_dtype(lamps.TABLES, lamps.SCALARS)


class Lamps:
    """The first of the lamps made by ``build_lamp``. Everything is in world space, in metres.

    Origins ``x`` are (3,) or (n, 3), directions (n, 3) of unit length, and ``u`` are uniform random numbers in [0, 1).
    """

    def __init__(self, *built: build.BuiltLamp):
        self.built = list(built)
        self.tables = pack.pack_lamps(self.built)
        self.blocks = np.zeros(1, BLOCK)
        for name, array in self.tables.items():
            fill_table(self.blocks, name, array)
        for name, value in pack.pack_scalars(self.built).items():
            self.blocks[name] = value
        self.spans = pack.new_spans(int(self.blocks["lamp_rows"][0]), len(built))
        self.row = self.tables["lamps"][0]

    def sample(self, x, u) -> np.ndarray:
        """(n, 3) directions from the point x, for (n, 3) random numbers; their density is ``pdf``."""
        return _sample(self.blocks, tuple(map(float, x)), np.array(u, float, order="C"))

    def points(self, u) -> np.ndarray:
        """(n, 3) uniform points in the interior, for (n, 3) random numbers."""
        return _points(self.blocks, np.array(u, float, order="C")) + self.row["center"]

    def pdf(self, x, directions) -> np.ndarray:
        """(n,) density of ``sample`` per solid angle, 1/sr."""
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 0]

    def chord(self, x, directions) -> np.ndarray:
        """(n,) length inside the lamp along each ray."""
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 1]

    def count(self, x, directions) -> np.ndarray:
        """(n,) number of intervals inside the lamp along each ray."""
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 2].astype(int)

    def crossings(self, x, directions) -> np.ndarray:
        """(n, m, 2) distances at which each ray enters and leaves the lamp, in order; NaN if it has fewer than m
        intervals."""
        origins, directions = _rows(x, directions)
        most = int(_measure(self.blocks, origins, directions, self.spans)[:, 2].max(initial=0))
        return _crossings(self.blocks, origins, directions, self.spans, most)

    def radiance(self, x, directions, u) -> np.ndarray:
        """(n, 3) radiance along each ray, RGB, W/(sr·m²), for (n,) random numbers. They matter only if the emission
        varies; then this is an unbiased estimate."""
        return _radiance(self.blocks, *_rows(x, directions), np.array(u, float, order="C"), self.spans)

    def trace(self, o, d) -> np.ndarray:
        """(count, 2) intervals of one ray: their centre and half length."""
        return _trace(self.blocks, tuple(map(float, o)), tuple(map(float, d)), self.spans)


def _rows(x, directions):
    # Copies: read-only arrays would compile the kernels once more.
    origins = np.broadcast_to(np.asarray(x, float), directions.shape)
    return np.array(origins, float, order="C"), np.array(directions, float, order="C")


@kernel
def _sample(blocks, x, u):
    out = np.empty((len(u), 3))
    for i in range(len(u)):
        out[i] = projection.sample_direction(blocks[0], 0, x, (0.0, 0.0, 0.0), u[i, 0], u[i, 1], u[i, 2])
    return out


@kernel
def _points(blocks, u):
    out = np.empty((len(u), 3))
    for i in range(len(u)):
        out[i] = projection.interior_point(blocks[0], 0, u[i, 0], u[i, 1], u[i, 2])
    return out


@kernel
def _ray(origins, directions, i):
    return (origins[i, 0], origins[i, 1], origins[i, 2]), (directions[i, 0], directions[i, 1], directions[i, 2])


@kernel
def _measure(blocks, origins, directions, spans):
    out = np.zeros((len(directions), 3))
    block = blocks[0]
    for i in range(len(directions)):
        o, d = _ray(origins, directions, i)
        count = lamps.trace(block, 0, o, d, spans)
        out[i, 0] = projection.direction_pdf(block, 0, o, (0.0, 0.0, 0.0), d, spans, count)
        for k in range(count):
            out[i, 1] += 2.0 * spans[k, 1]
        out[i, 2] = count
    return out


@kernel
def _crossings(blocks, origins, directions, spans, most):
    out = np.full((len(directions), most, 2), np.nan)
    for i in range(len(directions)):
        o, d = _ray(origins, directions, i)
        for k in range(lamps.trace(blocks[0], 0, o, d, spans)):
            out[i, k, 0], out[i, k, 1] = spans[k, 0] - spans[k, 1], spans[k, 0] + spans[k, 1]
    return out


@kernel
def _radiance(blocks, origins, directions, u, spans):
    out = np.empty((len(directions), 3))
    block = blocks[0]
    for i in range(len(directions)):
        o, d = _ray(origins, directions, i)
        count = lamps.trace(block, 0, o, d, spans)
        out[i] = lamps.radiance(block, 0, o, d, spans, count, 0.0, np.inf, u[i])
    return out


@kernel
def _trace(blocks, o, d, spans):
    count = lamps.trace(blocks[0], 0, o, d, spans)
    return spans[:count].copy()
