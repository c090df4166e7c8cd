# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges of a mesh that do not have as many triangles on one side as on the other: those of holes, of loose parts, and
of parts whose faces are turned.

Up to a whole number, the winding number depends on them only.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel


@kernel
def _sort(keys, starts, order, result):
    """Fill ``result`` with an ``order`` of things, sorted by their ``keys``, which count from zero. ``starts`` has a
    zero for each key, and two more."""
    for each in range(len(order)):
        starts[keys[order[each]] + 2] += 1
    for key in range(2, len(starts)):
        starts[key] += starts[key - 1]
    for each in range(len(order)):
        key = keys[order[each]] + 1
        result[starts[key]] = order[each]
        starts[key] += 1


@kernel
def _unpaired(low, high, turned, order, kept):
    """Rows of edges, in an order in which the same ones lie together, that no turned edge balances, into ``kept``;
    their number."""
    count, first = 0, 0
    while first < len(order):
        last, total = first, 0
        a, b = low[order[first]], high[order[first]]
        while last < len(order) and low[order[last]] == a and high[order[last]] == b:
            total += -1 if turned[order[last]] else 1
            last += 1
        if total != 0 and a != b:
            for each in range(first, last):
                if turned[order[each]] == (total < 0):
                    kept[count] = order[each]
                    count += 1
                    total += 1 if total < 0 else -1
                    if total == 0:
                        break
        first = last
    return count


def _open(ends: np.ndarray, count: int) -> np.ndarray:
    """Those of the edges from one of ``count`` vertices to another (n, 2) that no edge the other way balances."""
    low, high = np.minimum(ends[:, 0], ends[:, 1]), np.maximum(ends[:, 0], ends[:, 1])
    order, sorted_by_high = np.arange(len(ends)), np.empty(len(ends), np.int64)
    _sort(high, np.zeros(count + 2, np.int64), order, sorted_by_high)
    _sort(low, np.zeros(count + 2, np.int64), sorted_by_high, order)
    kept = np.empty(len(ends), np.int64)
    return ends[kept[: _unpaired(low, high, ends[:, 0] > ends[:, 1], order, kept)]]


def _mixed(numbers: np.ndarray) -> np.ndarray:
    """64 bits that look random for each 64 bits, without two alike (Steele, Lea and Flood 2014, SplitMix64)."""
    numbers = (numbers ^ (numbers >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    numbers = (numbers ^ (numbers >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return numbers ^ (numbers >> np.uint64(31))


def open_edges(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The ends (n, 2, 3) of the open edges of a mesh with vertices (n, 3) and triangles (m, 3). Vertices at the same
    place are one."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    ends = _open(ends, len(vertices))
    if not len(ends):
        return np.empty((0, 2, 3))
    places = vertices[ends.ravel()].astype(np.float64) + 0.0  # one zero, whatever its sign
    keys = np.zeros(len(places), np.uint64)
    for column in places.view(np.uint64).T:
        keys = _mixed(keys + column)
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    return places[first][_open(same.reshape(-1, 2), len(first))]
