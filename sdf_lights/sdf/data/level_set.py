# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance grids of level sets: voxels with signed distances in a narrow band, as OpenVDB's files hold them.

Near the surface the field is that of the voxels. Farther away a file knows no more than the side: there the distance
between the corners of blocks is that of a chamfer transform (Borgefors 1986), which is as steep as its values say.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from ...interruption import check
from .grid import CORNERS, SIDE, Grid, cells_that_vary, grid_tables
from .voxels import MOST_BLOCKS, MOST_CORNERS, GridError

_LAYER = 1 << 27  # bytes of voxels that are read at once
_ROUNDS = 256  # blocks from the surface up to which distances grow


def level_set_grid(
    read: Callable[[np.ndarray, np.ndarray], np.ndarray],
    first: np.ndarray,
    last: np.ndarray,
    band: float,
    size: float,
) -> Grid:
    """The grid of voxels from ``first`` to ``last`` (3,), whole numbers, whose values are within ±``band`` metres.

    ``read(start, counts)`` gives values (x, y, z) of so many voxels. The voxel i is at i ``size``. Raises GridError.
    """
    first, last = np.asarray(first, np.int64), np.asarray(last, np.int64)
    if not (0.0 < band < math.inf and 0.0 < size < math.inf):
        raise GridError("has no band of distances around its surface: write it again as a level set.")
    # Half a voxel of the background all around closes what touches the border.
    start = first - 1
    counts = np.maximum(-(-(last + 2 - first) // SIDE), 1)
    if np.prod(counts + 1.0) > MOST_CORNERS or 4.0 * (SIDE * counts[0] + 1) * (SIDE * counts[1] + 1) * CORNERS > _LAYER:
        raise GridError("has too many voxels: make its voxels larger.")
    band = float(np.float32(band))
    coarse = np.empty(counts[::-1] + 1)
    blocks, values = [], []
    for layer in range(counts[2]):
        check()
        low = start + (0, 0, SIDE * layer)
        found = np.asarray(read(low, SIDE * counts * (1, 1, 0) + (1, 1, CORNERS)), np.float32).transpose(2, 1, 0)
        if not np.isfinite(found).all():
            raise GridError("has a voxel that is not a finite number: write it again.")
        found = np.clip(found, -band, band)
        for end, plane in ((0, layer), (SIDE, layer + 1)):
            coarse[plane] = found[end, ::SIDE, ::SIDE]
        parts = np.lib.stride_tricks.sliding_window_view(found, (CORNERS,) * 3)[:, ::SIDE, ::SIDE][0]
        varying = cells_that_vary(parts.reshape(-1, CORNERS, CORNERS, CORNERS), band).any(axis=(1, 2, 3))
        # Also where a side is of the other sign than the rest, for which one of the cells between them varies.
        j, i = np.nonzero(varying.reshape(parts.shape[:2]))
        blocks.append(np.column_stack([i, j, np.full(len(i), layer)]))
        values.append(parts[j, i])
        if sum(map(len, blocks)) > MOST_BLOCKS:
            raise GridError("has too many voxels: make its voxels larger.")
    joined = np.concatenate(values)
    if not (joined < 0.0).any():
        raise GridError("has no inside: it is no level set of a closed surface.")
    corner = size * start
    return Grid(*grid_tables(corner, size, _far(coarse, band, SIDE * size), np.concatenate(blocks), joined, band))


def _far(coarse: np.ndarray, band: float, step: float) -> np.ndarray:
    """Signed distances at corners of blocks, from those in the band."""
    sizes = np.abs(coarse)
    known = sizes < band
    # A corner beside another of the other side, or of the band, is as near as the band; all others are farther.
    near = known.copy()
    for axis in range(3):
        for a, b in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            here, there = [slice(None)] * 3, [slice(None)] * 3
            here[axis], there[axis] = a, b
            near[tuple(here)] |= (coarse[tuple(here)] > 0.0) != (coarse[tuple(there)] > 0.0)
    sizes = np.where(known, sizes, np.where(near, band, np.inf))
    if not np.isfinite(sizes).any():
        return coarse
    shifts = [shift for shift in itertools.product((-1, 0, 1), repeat=3) if any(shift)]
    for _ in range(_ROUNDS):
        check()
        before = sizes
        padded = np.pad(sizes, 1, constant_values=np.inf)
        for shift in shifts:
            view = padded[tuple(slice(1 + by, 1 + by + count) for by, count in zip(shift, sizes.shape))]
            sizes = np.minimum(sizes, view + step * math.sqrt(sum(by * by for by in shift)))
        if np.array_equal(before, sizes):
            break
    return np.where(coarse > 0.0, 1.0, -1.0) * np.where(np.isfinite(sizes), sizes, band)
