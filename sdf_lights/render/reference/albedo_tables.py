# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedos and the terms of sheen, looked up in the tables that kernels use, too."""

from __future__ import annotations

import numpy as np

from ..tables import albedo, sheen


class Table:
    """Directional albedos and ``sheen_`` terms from ``render.tables``, with multilinear interpolation."""

    def __init__(self):
        flat = albedo.load()
        self._values = {
            name: flat[start : start + int(np.prod(shape))].reshape(shape)
            for (name, shape), start in zip(albedo.SHAPES.items(), albedo.OFFSETS.values())
        } | {f"sheen_{term}": values for term, values in zip(sheen.TERMS, sheen.load())}

    def __call__(self, name: str, *coordinates: np.ndarray) -> np.ndarray:
        """Values at coordinates in [0, 1], one array for each axis of the table; what is not a number counts as 0."""
        table = self._values[name]
        total = np.zeros(np.broadcast(*coordinates).shape)
        cells = []
        for x, size in zip(coordinates, table.shape):
            x = np.clip(np.nan_to_num(x), 0.0, 1.0) * (size - 1)
            low = np.minimum(x.astype(int), size - 2)
            cells.append((low, x - low))
        for corner in np.ndindex((2,) * table.ndim):
            weight = np.prod([t if k else 1.0 - t for k, (_, t) in zip(corner, cells)], axis=0)
            total += weight * table[tuple(low + k for k, (low, _) in zip(corner, cells))]
        return total


def ior_axis(ior: np.ndarray) -> np.ndarray:
    """Coordinate of the tables of glass for an index of refraction (N,)."""
    return np.sqrt(np.abs((ior - 1.0) / (ior + 1.0)))


def cosine_axis(cosine: np.ndarray) -> np.ndarray:
    """Coordinate of the tables for a cosine (N,)."""
    return np.sqrt(np.maximum(cosine, 0.0))
