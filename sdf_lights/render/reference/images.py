# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Look-up of image textures: (0, 0) is the lower left corner of the image, texel centres lie half a texel inside."""

from __future__ import annotations

import numpy as np

from ..images import LARGEST, MISSING, Image, Texture, as_pixels, decoded


def _wrap(index: np.ndarray, size: int, extension: str) -> tuple[np.ndarray, np.ndarray]:
    """Texel index, and whether there is a texel: CLIP has none outside."""
    inside = (index >= 0) & (index < size)
    if extension == "REPEAT":
        return index % size, np.ones_like(inside)
    if extension == "MIRROR":
        folded = index % (2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded), np.ones_like(inside)
    return np.clip(index, 0, size - 1), inside if extension == "CLIP" else np.ones_like(inside)


def _weights(interpolation: str, t: np.ndarray) -> tuple[int, list[np.ndarray]]:
    """First texel relative to the left one, and the weights of it and its successors, at the fraction t."""
    if interpolation == "Linear":
        return 0, [1.0 - t, t]
    cubes = (1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3  # uniform cubic B-spline
    return -1, [cube / 6.0 for cube in cubes]


def interpolated(pixels: np.ndarray, u: np.ndarray, v: np.ndarray, interpolation: str, extension: str) -> np.ndarray:
    """(N, channels) of ``pixels`` (height, width, channels) as stored. Outside of a clipped image everything is 0."""
    height, width, channels = pixels.shape
    result = np.zeros((len(u), channels))
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
            result += (s * t * inside_i * inside_j * finite)[:, None] * pixels[j, i].astype(float)
    return result


def _image(image: Image, u: np.ndarray, v: np.ndarray, texture: Texture) -> np.ndarray:
    """RGBA (N, 4) of one image."""
    pixels = as_pixels(image.pixels)
    if not pixels.size:
        return np.broadcast_to(MISSING, (len(u), 4))
    channels = pixels.shape[2]
    if channels < 4:
        opaque = np.full_like(pixels[..., :1], LARGEST[pixels.dtype])
        pixels = np.concatenate([np.broadcast_to(pixels, (*pixels.shape[:2], 3)), opaque], axis=2)
    rgba = interpolated(pixels, u, v, texture.interpolation, texture.extension) / LARGEST[pixels.dtype]
    if channels == 1:  # outside of a clipped image it is black, but not transparent
        rgba[:, 3] = 1.0
    if texture.straight:
        alpha = rgba[:, 3:]
        rgba[:, :3] /= np.where((alpha != 0.0) & (alpha != 1.0), alpha, 1.0)
    if image.encoded:
        rgba[:, :3] = decoded(rgba[:, :3])
    return rgba


def lookup(images: list[Image], texture: Texture, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Scene-linear RGBA (N, 4) of a texture; magenta without an image."""
    choice = [(texture.image, np.ones(len(u), bool), 0.0, 0.0)]
    if texture.tiles:
        u, v = (np.where(np.isfinite(x), x, -1.0) for x in (u, v))
        column, row = np.trunc(u), np.trunc(v)
        known = (column >= 0.0) & (column < 10.0) & (row >= 0.0)
        number = np.where(known, 1001.0 + column + 10.0 * row, 0.0)
        choice = [(index, number == tile, column, row) for tile, index in texture.tiles]
    result = np.broadcast_to(MISSING, (len(u), 4)).copy()
    for index, rows, column, row in choice:
        if index is not None and 0 <= index < len(images):
            result[rows] = _image(images[index], (u - column)[rows], (v - row)[rows], texture)
    return result
