# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of boxes around many small things.

It is a complete binary tree: node i has the children 2i and 2i + 1, the leaves are nodes
``leaves`` to 2 ``leaves`` − 1, and leaf j holds the ``LEAF`` things from ``LEAF`` j on. So it has no pointers. Each
box is divided across its longest side, with as many things in one half as in the other.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...jit import kernel

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
    middles, along = 0.5 * (low + high), np.empty(len(order))
    if n < LARGE:
        _divide(order, along, middles, leaves)
    else:
        _divide(order, along, middles, 2)
        with ThreadPoolExecutor(2) as pool:
            halves = zip(order.reshape(2, -1), along.reshape(2, -1))
            list(pool.map(lambda half: _divide(*half, middles, leaves // 2), halves))
    nodes = np.zeros((2 * leaves, 2 * dimensions))
    _enclose(order, np.ascontiguousarray(low), np.ascontiguousarray(high), nodes)
    return order, nodes


@kernel
def _divide(order, along, middles, parts):
    """Sort an order of things into so many ``parts``, by halves. ``middles`` (n, k) are those of the boxes, ``along``
    is as long as the order, for use here."""
    size = len(order)
    while size > len(order) // parts:
        for first in range(0, len(order), size):
            axis, widest = 0, -1.0
            for k in range(middles.shape[1]):
                least, most = math.inf, -math.inf
                for at in range(first, first + size):
                    place = middles[order[at], k]
                    least, most = min(least, place), max(most, place)
                if most - least > widest:
                    axis, widest = k, most - least
            for at in range(first, first + size):
                along[at] = middles[order[at], axis]
            _halve(order, along, first, first + size - 1, first + size // 2)
        size //= 2


@kernel
def _halve(order, along, low, high, middle):
    """Exchange things from ``low`` to ``high`` until none before ``middle`` is greater than any from it on (Hoare
    1961)."""
    while low < high:
        a, b, c = along[low], along[(low + high) // 2], along[high]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while along[i] < pivot:
                i += 1
            while along[j] > pivot:
                j -= 1
            if i <= j:
                along[i], along[j] = along[j], along[i]
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@kernel
def _enclose(order, low, high, nodes):
    """Fill the boxes of nodes 1 to 2 leaves − 1."""
    leaves, dimensions = len(nodes) // 2, low.shape[1]
    for node in range(2 * leaves - 1, 0, -1):
        for k in range(dimensions):
            least, most = math.inf, -math.inf
            if node < leaves:
                for child in range(2 * node, 2 * node + 2):
                    least, most = min(least, nodes[child, k]), max(most, nodes[child, dimensions + k])
            else:
                for place in range(LEAF * (node - leaves), LEAF * (node - leaves + 1)):
                    least, most = min(least, low[order[place], k]), max(most, high[order[place], k])
            nodes[node, k], nodes[node, dimensions + k] = least, most


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
