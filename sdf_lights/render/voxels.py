# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of voxels that volumes read: bricks of 8³ voxels, and the place of each brick of a box.

All bricks of one value are stored once, so empty space costs four bytes a brick. Values are interpolated between the
centers of voxels, which lie at whole numbers. Outside of the box they are the background.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..interruption import check

SIDE = 8  # voxels of a brick; kernels shift by its exponent
BRICK = SIDE**3
# Numbers before the places of bricks: the matrix (3, 4) from object space to voxels, counted from the first one of the
# box; bricks along each axis; channels; the background of at most four channels.
COUNTS, CHANNELS, BACKGROUND, HEAD = 12, 15, 16, 20

MOST_BRICKS = 1 << 24  # whole numbers in single precision


class TooManyVoxels(ValueError):
    """The box of a grid is too large."""


def packed(
    read: Callable[[np.ndarray, np.ndarray], np.ndarray],
    first: np.ndarray,
    last: np.ndarray,
    background: np.ndarray,
    matrix: np.ndarray,
) -> np.ndarray:
    """The grid of the voxels from ``first`` to ``last`` (3,), whole numbers, as a row (1, n) of an
    attribute.

    ``read(start, counts)`` gives values (x, y, z, channels) of so many voxels; one, three or four channels. ``matrix``
    (4, 4) maps the numbers of voxels to object space. Values that are not finite are 0. Raises TooManyVoxels.
    """
    start = np.asarray(first, np.int64) // SIDE * SIDE
    counts = (np.asarray(last, np.int64) - start) // SIDE + 1
    if np.prod(counts.astype(float)) > MOST_BRICKS:
        raise TooManyVoxels
    background = np.nan_to_num(np.asarray(background, np.float32).reshape(-1), posinf=0.0, neginf=0.0)
    channels = len(background)
    places = np.empty(counts[::-1], np.float32)
    alike: dict[bytes, int] = {}  # bricks of one value
    bricks: list[np.ndarray] = []
    count = 0
    for layer in range(counts[0]):
        check()
        found = np.asarray(read(start + (SIDE * layer, 0, 0), SIDE * counts * (0, 1, 1) + (SIDE, 0, 0)), np.float32)
        found = np.nan_to_num(found.reshape(SIDE, counts[1], SIDE, counts[2], SIDE, channels), posinf=0.0, neginf=0.0)
        # To rows (z, y) of bricks, x innermost.
        rows = found.transpose(3, 1, 4, 2, 0, 5).reshape(-1, BRICK, channels)
        numbers = np.empty(len(rows), np.int64)
        uniform = (rows == rows[:, :1]).all(axis=(1, 2))
        kinds, kind = np.unique(rows[uniform, 0], axis=0, return_inverse=True)
        for value in kinds:
            if value.tobytes() not in alike:
                alike[value.tobytes()], count = count, count + 1
                bricks.append(np.tile(value, BRICK))
        numbers[uniform] = np.array([alike[value.tobytes()] for value in kinds], np.int64)[kind.ravel()]
        rest = np.flatnonzero(~uniform)
        numbers[rest] = count + np.arange(len(rest))
        bricks.append(rows[rest].ravel())
        count += len(rest)
        places[:, :, layer] = numbers.reshape(counts[2], counts[1])
    to_voxels = np.linalg.inv(np.asarray(matrix, np.float64))[:3]
    to_voxels[:, 3] -= start
    head = np.zeros(HEAD, np.float32)
    head[:COUNTS], head[COUNTS:CHANNELS], head[CHANNELS] = to_voxels.ravel(), counts, channels
    head[BACKGROUND : BACKGROUND + channels] = background
    return np.concatenate([head, places.ravel(), *bricks])[None]
