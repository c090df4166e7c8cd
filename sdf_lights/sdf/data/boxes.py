# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of boxes around many small things, in the order of Morton's curve.

It is a complete binary tree: node i has the children 2i and 2i + 1, the leaves are nodes ``leaves`` to 2 ``leaves`` − 1, and
leaf j holds the ``LEAF`` things from ``LEAF`` j on. So it has no pointers, and NumPy builds it in one pass for each level.
"""

from __future__ import annotations

import numpy as np

LEAF = 4  # things of a leaf
FAR = 1e150  # where the boxes of empty leaves are: its square is finite
_BITS = 16  # of each coordinate in a code


def _codes(middles: np.ndarray) -> np.ndarray:
    """Morton codes of points (n, k)."""
    low, high = middles.min(axis=0), middles.max(axis=0)
    size = float((high - low).max())
    cells = ((middles - low) * ((2**_BITS - 1) / size if size > 0.0 else 0.0)).astype(np.uint64)
    codes = np.zeros(len(middles), np.uint64)
    dimensions = cells.shape[1]
    for bit in range(_BITS):
        for axis in range(dimensions):
            codes |= (cells[:, axis] >> np.uint64(bit) & np.uint64(1)) << np.uint64(bit * dimensions + axis)
    return codes


def tree(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order of n things with boxes from ``low`` to ``high`` (n, k), and boxes of the nodes (2 leaves, 2k).

    The order (LEAF · leaves,) repeats the last thing to fill the last leaf that is not empty, and beyond.
    """
    n, dimensions = low.shape
    order = np.argsort(_codes(0.5 * (low + high)), kind="stable")
    used = -(-n // LEAF)
    leaves = 1 << (used - 1).bit_length()
    order = np.concatenate([order, np.full(LEAF * leaves - n, order[-1])])
    nodes = np.empty((2 * leaves, 2 * dimensions))
    nodes[:, :dimensions], nodes[:, dimensions:] = FAR, -FAR
    filled = order[: LEAF * used]
    nodes[leaves : leaves + used, :dimensions] = low[filled].reshape(used, LEAF, dimensions).min(axis=1)
    nodes[leaves : leaves + used, dimensions:] = high[filled].reshape(used, LEAF, dimensions).max(axis=1)
    level = leaves
    while level > 1:
        parts = nodes[level : 2 * level].reshape(level // 2, 2, 2 * dimensions)
        level //= 2
        nodes[level : 2 * level, :dimensions] = parts[:, :, :dimensions].min(axis=1)
        nodes[level : 2 * level, dimensions:] = parts[:, :, dimensions:].max(axis=1)
    return order, nodes
