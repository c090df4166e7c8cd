# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of boxes around many small things.

It is a complete binary tree: node i has the children 2i and 2i + 1, the leaves are nodes
``leaves`` to 2 ``leaves`` − 1, and leaf j holds the ``LEAF`` things from ``LEAF`` j on. So it has no pointers, and
NumPy builds it in one pass for each level: each box is divided across its longest side, with as many things in one half
as in the other.
"""

from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor

import numpy as np

LEAF = 4  # things of a leaf
LARGE = 1 << 15  # things for which two threads take less time than one


def tree(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order of n things with boxes from ``low`` to ``high`` (n, k), and boxes of the nodes (2 leaves, 2k); that of node
    0 is 0.

    In the order (LEAF · leaves,) some things are there more than once, so that all leaves are full.
    """
    n, dimensions = low.shape
    leaves = 1 << (-(-n // LEAF) - 1).bit_length()
    order = np.arange(LEAF * leaves) * n // (LEAF * leaves)
    # One axis after the other, as numbers that lie together are compared several times as fast.
    middles = np.ascontiguousarray(0.5 * (low + high).T)
    if n < LARGE:
        order = _divided(order, middles, 1, leaves)
    else:
        halves = _divided(order, middles, 1, 2).reshape(2, -1)
        with ThreadPoolExecutor(2) as pool:  # NumPy's partition lets another thread run
            order = np.concatenate(list(pool.map(lambda half: _divided(half, middles, 1, leaves // 2), halves)))
    nodes = np.zeros((2 * leaves, 2 * dimensions))
    nodes[leaves:, :dimensions] = functools.reduce(np.minimum, (low[order[k::LEAF]] for k in range(LEAF)))
    nodes[leaves:, dimensions:] = functools.reduce(np.maximum, (high[order[k::LEAF]] for k in range(LEAF)))
    level = leaves
    while level > 1:
        first, second = nodes[level : 2 * level : 2], nodes[level + 1 : 2 * level : 2]
        level //= 2
        nodes[level : 2 * level, :dimensions] = np.minimum(first[:, :dimensions], second[:, :dimensions])
        nodes[level : 2 * level, dimensions:] = np.maximum(first[:, dimensions:], second[:, dimensions:])
    return order, nodes


def _divided(order: np.ndarray, middles: np.ndarray, parts: int, most: int) -> np.ndarray:
    """Divide each of so many ``parts`` of an order in two, until there are ``most``. ``middles`` (k, n) are those of
    the boxes."""
    while parts < most:
        blocks = order.reshape(parts, -1)
        points = middles[:, blocks]
        axes = np.argmax(_of_rows(np.maximum, points) - _of_rows(np.minimum, points), axis=0)
        along = points[axes, np.arange(parts)]
        halves = np.argpartition(along, blocks.shape[1] // 2, axis=1)
        order = np.take_along_axis(blocks, halves, axis=1).ravel()
        parts *= 2
    return order


def _of_rows(better: np.ufunc, values: np.ndarray) -> np.ndarray:
    """The greatest or least values (…) of rows (…, 2ᵏ), by halves: NumPy is slow for many short rows."""
    while values.shape[-1] > 1:
        values = better(values[..., ::2], values[..., 1::2])
    return values[..., 0]


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
