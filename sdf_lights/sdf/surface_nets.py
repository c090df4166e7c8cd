# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a shape as a mesh of quadrilaterals, by naive surface nets.

Gibson 1998, "Constrained elastic surface nets": one vertex in each cell of a grid that the surface passes through, at
the mean of its crossings with the cell's edges. Here the vertices are also moved onto the surface along the field's
gradient.
"""

from __future__ import annotations

import math

import numpy as np

from ..graph import numpy_evaluation
from ..graph.formula import Formula
from .shapes import Shape

_BLOCK = 8  # cells along each side of the blocks that are skipped if they are clear of the surface
_CHUNK = 1 << 16  # points of one evaluation
_STEPS = 3  # steps of each vertex towards the surface
_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), -1).reshape(-1, 3)
_EDGES = np.array([(a, b) for a in range(8) for b in range(a) if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1])


def surface_net(shape: Shape, resolution: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and quadrilaterals (m, 4) int64, their normals outwards.

    ``resolution`` is the number of cells along the longest side of the shape's bounding box. The shape must be bounded.
    """
    low, high = shape.bounds()
    step = float(np.max(high - low)) / resolution
    if step <= 0.0:
        return np.zeros((0, 3)), np.zeros((0, 4), np.int64)
    # Half a cell of margin on each side: no face of a box lies on the grid, and the surface is closed.
    cells = np.ceil((high - low) / step).astype(int) + 2
    origin = 0.5 * (low + high) - 0.5 * step * cells
    formula, parameters = shape.formula(), shape.parameters()
    values = _sampled(shape, formula, parameters, origin, step, cells)
    return _net(values, lambda points: _evaluated(formula, points, parameters), origin, step)


def _evaluated(formula: Formula, points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    parts = [
        numpy_evaluation.evaluate(formula, points[i : i + _CHUNK], parameters) for i in range(0, len(points), _CHUNK)
    ]
    return np.nan_to_num(np.concatenate(parts), nan=1.0) if parts else np.zeros(0)


def _sampled(
    shape: Shape, formula: Formula, parameters: np.ndarray, origin: np.ndarray, step: float, cells: np.ndarray
) -> np.ndarray:
    """The field at the corners of the cells. In a block that is clear of the surface, any value of its sign."""
    blocks = -(-(cells + 1) // _BLOCK)
    index = np.stack(np.meshgrid(*map(np.arange, blocks), indexing="ij"), -1).reshape(-1, 3)
    centers = origin + step * (index * _BLOCK + 0.5 * (_BLOCK - 1))
    at_center = _evaluated(formula, centers, parameters)
    slope = shape.lipschitz if shape.certified else math.inf
    near = ~(np.abs(at_center) > slope * step * 0.5 * math.sqrt(3.0) * _BLOCK)
    padded = np.repeat(np.repeat(np.repeat(at_center.reshape(blocks), _BLOCK, axis=0), _BLOCK, axis=1), _BLOCK, axis=2)
    local = np.stack(np.meshgrid(*[np.arange(_BLOCK)] * 3, indexing="ij"), -1).reshape(-1, 3)
    for first in range(0, int(near.sum()), _CHUNK // _BLOCK**3):
        chosen = index[near][first : first + _CHUNK // _BLOCK**3]
        lattice = (chosen[:, None] * _BLOCK + local).reshape(-1, 3)
        padded[tuple(lattice.T)] = _evaluated(formula, origin + step * lattice, parameters)
    x, y, z = cells + 1
    return padded[:x, :y, :z]


def _net(values: np.ndarray, field, origin: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    inside = values < 0.0
    cells = np.array(values.shape) - 1
    count = sum(inside[tuple(slice(c, c + n) for c, n in zip(corner, cells))].astype(np.int8) for corner in _CORNERS)
    active = np.argwhere((count > 0) & (count < 8))
    number = np.full(cells, -1)
    number[tuple(active.T)] = np.arange(len(active))
    at_corners = values[tuple((active[:, None] + _CORNERS).transpose(2, 0, 1))]
    one, other = at_corners[:, _EDGES[:, 0]], at_corners[:, _EDGES[:, 1]]
    crossed = (one < 0.0) != (other < 0.0)
    with np.errstate(all="ignore"):
        t = np.where(crossed, one / (one - other), 0.0)
    t = np.nan_to_num(t, nan=0.5).clip(0.0, 1.0)[..., None]
    places = _CORNERS[_EDGES[:, 0]] * (1.0 - t) + _CORNERS[_EDGES[:, 1]] * t
    offset = (places * crossed[..., None]).sum(axis=1) / crossed.sum(axis=1)[:, None]
    vertices = origin + step * (active + _on_surface(field, origin + step * active, offset, step))

    quads = []
    for axis in range(3):
        before = np.take(inside, np.arange(cells[axis]), axis)
        after = np.take(inside, np.arange(1, cells[axis] + 1), axis)
        edge = np.argwhere(before != after)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        edge = edge[(edge[:, u] > 0) & (edge[:, v] > 0) & (edge[:, u] < cells[u]) & (edge[:, v] < cells[v])]
        around = np.repeat(edge[:, None], 4, axis=1)
        around[:, (0, 3), u] -= 1
        around[:, (0, 1), v] -= 1
        faces = number[tuple(around.transpose(2, 0, 1))]
        leaves = before[tuple(edge.T)]
        quads.append(np.where(leaves[:, None], faces, faces[:, ::-1]))
    return vertices, np.concatenate(quads)


def _on_surface(field, base: np.ndarray, offset: np.ndarray, step: float) -> np.ndarray:
    """Offsets in cells of vertices, moved to the surface by Newton's method but kept in their cells."""
    small = 1e-3
    for _ in range(_STEPS):
        points = base + step * offset
        value = field(points)
        gradient = np.stack(
            [
                (field(points + small * step * unit) - field(points - small * step * unit)) / (2.0 * small)
                for unit in np.eye(3)
            ],
            axis=-1,
        )  # for each cell
        square = (gradient**2).sum(axis=-1)
        with np.errstate(all="ignore"):
            move = np.where(square > 0.0, value / square, 0.0)
        offset = (offset - np.nan_to_num(move)[:, None] * gradient).clip(0.0, 1.0)
    return offset
