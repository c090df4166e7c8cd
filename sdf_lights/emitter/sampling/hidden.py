# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of lamps that hardly any surface sees: sunk in the floor, in a wall, or inside of things.

Cuts know the angle and the distance of a lamp's boxes, but not what hides them. So a grid over the lamp has the part of
a few places in the scene that see each of its cells, and boxes in cells that next to none see count less. Any weights
above 0 are unbiased. Only such cells have less: what some places see and others do not must be sampled well for the
former.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel, table
from ..tree.moments import lamp_cells

SIDE = 8  # cells along each axis
CELLS = SIDE**3
CORNERS = SIDE + 1
ROWS = CORNERS**3  # of the table, for each lamp
NONE = -1  # instead of the first row, for lamps without hidden parts
# A cell counts as seen if at least this part of the places see it that see the best cell. Of other cells, a part in
# proportion counts, and this at least. A box of which ``ENOUGH`` is seen has the weight 1. If the weight were the part
# that is seen, such a box would get fewer rays to what is seen of it than the box beside it, which is noisier.
ENOUGH, LEAST_WEIGHT = 0.25, 1.0 / 16.0
# How much boxes that are seen in part are split rather than others. More is noisier where boxes do not end at a floor,
# as others are larger then; 0 is noisier where they do.
SPLITS = 0.05
LEAST_HIDDEN = 0.02  # part of a lamp that must be hidden, or else it is sampled as it is
FEWEST_LOOKS = 16  # at a cell, to count as the best

ROUNDING = 1e-3  # of a cell: a box that ends at the side of one does not touch the next

SEEN = np.dtype([("volume", np.float64), ("seen", np.float64)])  # sums over all cells below a corner of the grid
TABLES = {"lamp_seen": SEEN}

lamp_seen = table("lamp_seen", SEEN)


def sums_of(looks: np.ndarray) -> np.ndarray | None:
    """(ROWS,) ``SEEN`` of a lamp; None if nearly nothing of it is hidden.

    ``looks`` (CELLS, 2): how often places looked at even points of each cell, and how often they saw them."""
    tried, seen = looks.T
    known = tried >= FEWEST_LOOKS
    best = np.max(seen[known] / tried[known], initial=0.0)
    if not best > 0.0:
        return None
    part = np.clip(seen / np.maximum(tried, 1) / (ENOUGH * best), LEAST_WEIGHT, 1.0)
    if tried @ (1.0 - part) < LEAST_HIDDEN * tried.sum():
        return None
    found = np.zeros((CORNERS,) * 3, SEEN)
    for name, values in (("volume", tried), ("seen", tried * part)):
        sums = values.reshape((SIDE,) * 3)
        for axis in range(3):
            sums = np.cumsum(sums, axis=axis)
        found[name][1:, 1:, 1:] = sums
    return found.ravel()


@kernel
def cell_of(root, q):
    """The cell of a point in tree space. ``root``: the first of the lamp's ``lamp_cells``."""
    index = 0
    for axis in range(3):
        size = root.high[axis] - root.low[axis]
        at = int(SIDE * (q[axis] - root.low[axis]) / size) if size > 0.0 else 0
        index = SIDE * index + min(max(at, 0), SIDE - 1)
    return index


@kernel
def _touched(low, high, first, last):
    """The first and after the last cell along an axis that a box touches; ``first`` and ``last``: ends of the grid."""
    scale = SIDE / (last - first) if last > first else 0.0
    start = min(max(int(scale * (low - first) + ROUNDING), 0), SIDE - 1)
    return start, min(max(int(math.ceil(scale * (high - first) - ROUNDING)), start + 1), SIDE)


@kernel
def seen_of(block, place, low, high):
    """The part of a box in tree space, by its corners, that is seen, of a lamp that has hidden parts: of the cells that
    it touches."""
    root, sums = lamp_cells(block)[place.first_cell], lamp_seen(block)[place.first_seen :]
    i, far_i = _touched(low[0], high[0], root.low[0], root.high[0])
    j, far_j = _touched(low[1], high[1], root.low[1], root.high[1])
    k, far_k = _touched(low[2], high[2], root.low[2], root.high[2])
    volume = seen = 0.0
    for corner in range(8):
        a, b, c = corner & 1, (corner >> 1) & 1, corner >> 2
        row = sums[((far_i if a else i) * CORNERS + (far_j if b else j)) * CORNERS + (far_k if c else k)]
        sign = 1.0 if (a + b + c) & 1 else -1.0
        volume += sign * row.volume
        seen += sign * row.seen
    return seen / volume if volume > 0.0 else 1.0


@kernel
def weight_of(seen):
    """The weight of a box of which this part is seen."""
    return min(LEAST_WEIGHT + (1.0 - LEAST_WEIGHT) * max(seen - LEAST_WEIGHT, 0.0) / (ENOUGH - LEAST_WEIGHT), 1.0)


@kernel
def variance_of(seen):
    """What is added to the relative variance of such a box, so that it is split."""
    return SPLITS * max((1.0 - seen) * (seen - LEAST_WEIGHT), 0.0) / (seen * seen)
