# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps in a block of their own, and their kernels over many rays."""

from __future__ import annotations

import numpy as np

from sdf_lights.emitter import lamps
from sdf_lights.emitter.building import build, pack
from sdf_lights.emitter.sampling import projection
from sdf_lights.jit import block_dtype, fill_table, kernel

BLOCK = block_dtype(lamps.TABLES, lamps.SCALARS)


class Lamps:
    """The first lamp of a list, seen through the kernels' contract."""

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

    def sample(self, x, u):
        """(n, 3) directions from x for (n, 3) numbers."""
        return _sample(self.blocks, tuple(map(float, x)), np.array(u, float, order="C"))

    def points(self, u):
        """(n, 3) interior points in the world."""
        return _points(self.blocks, np.array(u, float, order="C")) + self.row["center"]

    def pdf(self, x, directions):
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 0]

    def chord(self, x, directions):
        """Length inside the lamp along each ray."""
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 1]

    def count(self, x, directions):
        return _measure(self.blocks, *_rows(x, directions), self.spans)[:, 2].astype(int)

    def trace(self, o, d):
        """(count, 2) rows (c, h) of one ray."""
        return _trace(self.blocks, tuple(map(float, o)), tuple(map(float, d)), self.spans)


def _rows(x, directions):
    # Copies: kernels are compiled once more for arrays that are read-only.
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
def _measure(blocks, origins, directions, spans):
    out = np.zeros((len(directions), 3))
    block = blocks[0]
    for i in range(len(directions)):
        o = (origins[i, 0], origins[i, 1], origins[i, 2])
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        count = lamps.trace(block, 0, o, d, spans)
        out[i, 0] = projection.direction_pdf(block, 0, o, (0.0, 0.0, 0.0), d, spans, count)
        for k in range(count):
            out[i, 1] += 2.0 * spans[k, 1]
        out[i, 2] = count
    return out


@kernel
def _trace(blocks, o, d, spans):
    count = lamps.trace(blocks[0], 0, o, d, spans)
    return spans[:count].copy()
