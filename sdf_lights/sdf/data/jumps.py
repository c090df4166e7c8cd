# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distances in blocks of voxels, bounded where they change their sign without a face.

There, in holes of a mesh, the distance to the nearest face says nothing about that to the surface.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from .grid import BLOCK, CORNERS, SIDE


@kernel
def _set(values, marks, blocks, places, at, size, mark):
    """Make the distance of the point number ``at`` no more than ``size``, in all blocks that have it. A point that
    changes gets a mark."""
    value = values[at]
    if not size < abs(value):
        return
    value = size if value > 0.0 else -size
    block, local = at // BLOCK, at % BLOCK
    i, j, k = local % CORNERS, local // CORNERS % CORNERS, local // (CORNERS * CORNERS)
    x, y, z = blocks[block, 0], blocks[block, 1], blocks[block, 2]
    for c in range(-1 if k == 0 else 0, 2 if k == SIDE else 1):
        for b in range(-1 if j == 0 else 0, 2 if j == SIDE else 1):
            for a in range(-1 if i == 0 else 0, 2 if i == SIDE else 1):
                if (
                    0 <= z + c < places.shape[0] and 0 <= y + b < places.shape[1] and 0 <= x + a < places.shape[2]
                    and places[z + c, y + b, x + a] >= 0
                ):  # fmt: skip
                    other = i - SIDE * a + CORNERS * (j - SIDE * b + CORNERS * (k - SIDE * c))
                    other += BLOCK * places[z + c, y + b, x + a]
                    values[other], marks[other] = value, mark


@kernel
def _find_jumps(values, stride, size, found, scales):
    """The number of pairs of neighbours, ``stride`` points apart, with signs that change faster than by their
    distance. Their first points and factors that cure them, into ``found`` and ``scales``, as far as these reach."""
    count, period = 0, stride * CORNERS
    for at in range(len(values) - stride):
        if at % period < period - stride and (values[at] > 0.0) != (values[at + stride] > 0.0):
            together = abs(values[at]) + abs(values[at + stride])
            if together > size:
                if count < len(found):
                    found[count], scales[count] = at, min(size / together, 1.0)
                count += 1
    return count


@kernel
def _cure(values, marks, blocks, places, stride, found, scales):
    """Scale both points of each pair that ``_find_jumps`` found."""
    sizes = np.empty(len(found))
    for end in range(2):
        for each in range(len(found)):
            sizes[each] = scales[each] * abs(values[found[each] + end * stride])
        for each in range(len(found)):
            _set(values, marks, blocks, places, found[each] + end * stride, sizes[each], 1)


@kernel
def _relax(values, marks, blocks, places, size, mark):
    """Bound neighbours of points with a ``mark`` that have their sign; whether that changed any. These have the next
    mark."""
    changed = False
    for at in range(len(values)):
        if marks[at] != mark:
            continue
        stride = 1
        for _ in range(3):
            place = at // stride % CORNERS
            for side in (-1, 1):
                if 0 <= place + side < CORNERS:
                    other = at + side * stride
                    size_there = abs(values[at]) + size
                    if (values[other] > 0.0) == (values[at] > 0.0) and size_there < abs(values[other]):
                        _set(values, marks, blocks, places, other, size_there, mark + 1)
                        changed = True
            stride *= CORNERS
    return changed


def without_jumps(blocks: np.ndarray, counts: np.ndarray, values: np.ndarray, size: float) -> np.ndarray:
    """Values (n, CORNERS, CORNERS, CORNERS) of ``blocks`` (n, 3), of a grid with so many of them, whose sign does not
    change from one voxel of ``size`` to the next faster than by their distance."""
    places = np.full(tuple(counts[::-1]), -1, np.int32)
    places[blocks[:, 2], blocks[:, 1], blocks[:, 0]] = np.arange(len(blocks))
    flat, marks = values.ravel().copy(), np.zeros(values.size, np.uint8)
    for stride in (1, CORNERS, CORNERS * CORNERS):
        none = np.empty(0, np.int64), np.empty(0)
        found = np.empty(_find_jumps(flat, stride, size, *none), np.int64)
        scales = np.empty(len(found))
        _find_jumps(flat, stride, size, found, scales)
        _cure(flat, marks, blocks, places, stride, found, scales)
    mark = 1
    while _relax(flat, marks, blocks, places, size, mark):
        mark += 1
    return flat.reshape(values.shape)
