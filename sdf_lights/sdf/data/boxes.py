# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of boxes around many small things.

It is a complete binary tree: node i has the children 2i and 2i + 1, the leaves are nodes
``leaves`` to 2 ``leaves`` − 1, and leaf j holds the ``LEAF`` things from ``LEAF`` j on. So it has no pointers, and
NumPy builds it in one pass for each level: each box is divided across its longest side, with as many things in one half
as in the other.
"""

from __future__ import annotations

import numpy as np

LEAF = 4  # things of a leaf


def tree(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order of n things with boxes from ``low`` to ``high`` (n, k), and boxes of the nodes (2 leaves, 2k); that of node
    0 is 0.

    In the order (LEAF · leaves,) some things are there more than once, so that all leaves are full.
    """
    n, dimensions = low.shape
    leaves = 1 << (-(-n // LEAF) - 1).bit_length()
    order = np.arange(LEAF * leaves) * n // (LEAF * leaves)
    middles = 0.5 * (low + high)
    parts = 1
    while parts < leaves:
        blocks = order.reshape(parts, -1)
        points = middles[blocks]
        axes = np.argmax(np.ptp(points, axis=1), axis=1)
        along = np.take_along_axis(points, axes[:, None, None], axis=2)[..., 0]
        halves = np.argpartition(along, blocks.shape[1] // 2, axis=1)
        order = np.take_along_axis(blocks, halves, axis=1).ravel()
        parts *= 2
    nodes = np.zeros((2 * leaves, 2 * dimensions))
    nodes[leaves:, :dimensions] = low[order].reshape(leaves, LEAF, dimensions).min(axis=1)
    nodes[leaves:, dimensions:] = high[order].reshape(leaves, LEAF, dimensions).max(axis=1)
    level = leaves
    while level > 1:
        children = nodes[level : 2 * level].reshape(level // 2, 2, 2 * dimensions)
        level //= 2
        nodes[level : 2 * level, :dimensions] = children[:, :, :dimensions].min(axis=1)
        nodes[level : 2 * level, dimensions:] = children[:, :, dimensions:].max(axis=1)
    return order, nodes


def descent(distance: str, size: int, point: str) -> str:
    """GLSL that puts both children of ``node`` on the stack, the nearer one on top.

    ``distance`` is the name of a function of a box's place in the table and of ``point``; a box has ``size`` numbers.
    """
    return f"""\
int near = 2 * node;
            int far = near + 1;
            float d_near = {distance}(table + 2 + {size} * near, {point});
            float d_far = {distance}(table + 2 + {size} * far, {point});
            bool turned = d_far < d_near;
            stack[depth] = turned ? near : far;
            distances[depth] = max(d_near, d_far);
            stack[depth + 1] = turned ? far : near;
            distances[depth + 1] = min(d_near, d_far);
            depth += 2;
            continue;"""
