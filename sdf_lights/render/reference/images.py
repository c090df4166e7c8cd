# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Look-up of image textures: (0, 0) is the lower left corner of the image, texel centres lie half a texel inside."""

from __future__ import annotations

import numpy as np


def _wrap(index: np.ndarray, size: int, extension: str) -> tuple[np.ndarray, np.ndarray]:
    """Texel index, and whether there is a texel at all: CLIP has none outside."""
    inside = (index >= 0) & (index < size)
    if extension == "REPEAT":
        return index % size, np.ones_like(inside)
    if extension == "MIRROR":
        folded = index % (2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded), np.ones_like(inside)
    return np.clip(index, 0, size - 1), inside if extension == "CLIP" else np.ones_like(inside)


def _weights(interpolation: str, t: np.ndarray) -> tuple[int, list[np.ndarray]]:
    """First texel relative to the one at the left, and the weights of it and its followers, at the fraction t."""
    if interpolation == "Linear":
        return 0, [1.0 - t, t]
    cubes = (1 - t)**3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3  # uniform cubic B-spline
    return -1, [cube / 6.0 for cube in cubes]


def lookup(pixels: np.ndarray, u: np.ndarray, v: np.ndarray, interpolation: str, extension: str) -> np.ndarray:
    """RGBA (N, 4) of ``pixels`` (height, width, 4). ``interpolation`` and ``extension`` are Blender's identifiers."""
    height, width = pixels.shape[:2]
    result = np.zeros((len(u), 4))
    finite = np.isfinite(u) & np.isfinite(v)
    u, v = (np.clip(np.where(finite, x, 0.0), -1e6, 1e6) for x in (u, v))
    if interpolation == "Closest":
        axes = [[(np.floor(x * size).astype(int), 1.0)] for x, size in ((u, width), (v, height))]
    else:
        axes = []
        for x, size in ((u, width), (v, height)):
            left = np.floor(x * size - 0.5).astype(int)
            first, weights = _weights(interpolation, x * size - 0.5 - left)
            axes.append([(left + first + k, weight) for k, weight in enumerate(weights)])
    for column, s in axes[0]:
        for row, t in axes[1]:
            i, inside_i = _wrap(column, width, extension)
            j, inside_j = _wrap(row, height, extension)
            result += (s * t * inside_i * inside_j * finite)[:, None] * pixels[j, i]
    return result
