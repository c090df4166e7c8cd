# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A box around the region in which a formula is negative, by interval arithmetic.

A branch and bound search. Space is divided into cells that grow with the distance from the origin. Cells in which the
formula is positive are dropped. Others are split if they reach beyond the box around the points known to be inside.
"""

from __future__ import annotations

import functools

import numpy as np

from ..graph import interval_evaluation, numpy_evaluation
from ..graph.formula import Formula

NEAREST, FARTHEST = 0.01, 163_840.0  # half sizes of the innermost and outermost cube of cells, in metres
NEAR = 10.0  # half size of the cube of a closer search, if the large one is too much work

_TIGHT = 0.01  # of the sum of the box's sizes: a search ends when it is this close, or gains no more
_PATIENCE = 7  # splits of the cells after which it must gain
_LEAST_RAISED = 0.1
_CALL = 1_000  # cells that take as long as the fixed part of an evaluation
_MOST_WORK = 3_000_000  # operations × cells of one search
_MOST_FAR_WORK = 1_000_000  # of the search for the end of a region
_SMALLEST = 1e-300


@functools.lru_cache(maxsize=256)
def negative_region(formula: Formula, parameters: tuple[float, ...], operations: int) -> np.ndarray | None:
    """Corners (2, 3) of a box around the points at which the formula is not positive; of zero size if there are none.

    None if they reach to the end of the search, or might do so. If a search up to ``FARTHEST`` is undecided, one up to
    ``NEAR`` is used: the limits are then those of the part of the region that is not farther away. ``operations`` is
    the number of operations of the formula at a point.
    """
    box, reached = _search(formula, parameters, operations, FARTHEST, _MOST_FAR_WORK)
    if box is None and reached < NEAR:
        box, _ = _search(formula, parameters, operations, NEAR, _MOST_WORK)
    return box


def _search(
    formula: Formula, parameters: tuple[float, ...], operations: int, farthest: float, far_work: int
) -> tuple[np.ndarray | None, float]:
    """The box, as above, and the greatest distance of known points of the region."""

    def least(centers: np.ndarray, halves: np.ndarray) -> np.ndarray:
        shape = centers.shape[:-1]
        centers, halves = centers.reshape(-1, 3), np.broadcast_to(halves, centers.shape).reshape(-1, 3)
        return interval_evaluation.enclose(formula, centers - halves, centers + halves, parameters)[0].reshape(shape)

    centers, halves = _cells(farthest)
    work = operations * (_CALL + len(centers))
    if work > _MOST_WORK:
        return None, 0.0
    low = least(centers, halves)
    inside = np.array([(np.inf,) * 3, (-np.inf,) * 3])  # around points of the region
    reached = 0.0
    sizes = []  # of the region's box
    while True:
        kept = low <= 0.0
        centers, halves, low = centers[kept], halves[kept], low[kept]
        points = (centers[:, None] + halves[:, None] * _SAMPLES).reshape(-1, 3)
        points = points[numpy_evaluation.evaluate(formula, points, parameters) <= 0.0]
        reached = np.abs(points).max(initial=reached)
        if reached > farthest / 2.0:
            return None, reached
        inside = _hull(points, points, inside)
        beyond = ((centers - halves < inside[0]) | (centers + halves > inside[1])).any(axis=1)
        centers, halves, low = centers[beyond], halves[beyond], low[beyond]
        around = _hull(centers - halves, centers + halves, inside)
        if not (around[0] <= around[1]).all():
            return np.zeros((2, 3)), reached
        work += operations * (_CALL + 6 * len(centers))
        endless = np.abs(around).max() >= farthest
        if work > (far_work if endless else _MOST_WORK):
            return None if endless else around, reached
        sizes.append((around[1] - around[0]).sum())
        settled = len(sizes) > _PATIENCE and sizes[-1] > (1.0 - _TIGHT) * sizes[-1 - _PATIENCE]
        if not endless and (settled or np.abs(around - inside).max() <= _TIGHT * sizes[-1]):
            return around, reached
        # Each cell is split in two, along the axis that raises the least values most, unless it is already short.
        parts = halves[:, None] * (1.0 - 0.5 * np.eye(3))
        steps = parts * np.eye(3)
        trials = centers[:, None, None] + np.stack([-steps, steps], 1)
        lows = least(trials, parts[:, None])
        with np.errstate(invalid="ignore"):
            raised = np.nan_to_num(1.0 - lows.clip(max=0.0).sum(axis=1) / low.clip(max=-_SMALLEST)[:, None] / 2.0)
        axis = np.argmax((raised + _LEAST_RAISED) * halves, axis=1)
        chosen = np.arange(len(centers)), slice(None), axis
        centers, low = trials[chosen].reshape(-1, 3), lows[chosen].reshape(-1)
        halves = np.repeat(parts[chosen[0], axis], 2, axis=0)


_SAMPLES = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])  # centre of a cell, and of its faces


@functools.cache
def _cells(farthest: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres and half sizes, (n, 3) each, of the first cells of a search.

    They fill cubes around the origin, each half as large as the one before, in cells of a quarter of the cube's size.
    """
    grid = np.stack(np.meshgrid(*[(-0.75, -0.25, 0.25, 0.75)] * 3, indexing="ij"), -1).reshape(-1, 3)
    outside = np.abs(grid).max(axis=1) > 0.5
    radii = farthest * 0.5 ** np.arange(np.ceil(np.log2(farthest / NEAREST)))
    parts = [grid[outside] * radius for radius in radii] + [grid[~outside] * radii[-1]]
    halves = np.repeat([*radii, radii[-1]], list(map(len, parts))) / 4.0
    return np.concatenate(parts), np.repeat(halves[:, None], 3, axis=1)


def _hull(low: np.ndarray, high: np.ndarray, box: np.ndarray) -> np.ndarray:
    """The box (2, 3) around boxes, (n, 3) and (n, 3), and another box."""
    return np.array(
        [np.minimum(low.min(axis=0, initial=np.inf), box[0]), np.maximum(high.max(axis=0, initial=-np.inf), box[1])]
    )
