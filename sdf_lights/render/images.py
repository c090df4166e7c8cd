# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images in the type of their files, and their look-up.

A 4K map of bytes takes 64 MB as RGBA and 16 MB as grey. Colours in sRGB stay encoded: a look-up interpolates encoded
values and decodes the result, as in Cycles, so bytes need no conversion.

There are no levels of detail (mipmaps). Cycles uses them only for tiled files made with them; all its other textures
have none. The samples of a pixel average a texture as they average geometry.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from ..frozen import frozen

MISSING = (1.0, 0.0, 1.0, 1.0)  # magenta is easy to notice, and Cycles shows the same

# Types of pixels, and the value of 1 in each.
LARGEST = {np.dtype("u1"): 255.0, np.dtype("u2"): 65535.0, np.dtype("f2"): 1.0, np.dtype("f4"): 1.0}

LINEAR_BELOW = 0.04045  # sRGB value above which the curve is a power


@dataclass
class Image:
    """Pixels of one texture.

    ``pixels`` is (height, width, channels), row 0 at the bottom: 1 channel is grey, 3 are RGB, 4 RGBA; uint8 and
    uint16, whose largest number is 1, float16 or float32. Colours are scene-linear, or sRGB if ``encoded``. An image
    without pixels is missing, and shown in magenta.
    """

    name: str
    pixels: np.ndarray
    encoded: bool = False


@frozen
class Texture:
    """A look-up of an image, or of UDIM tiles.

    ``image`` is an index of ``Scene.images``; None: magenta. ``interpolation`` ("Linear", "Closest", "Cubic", "Smart")
    and ``extension`` ("REPEAT", "EXTEND", "CLIP", "MIRROR") are Blender's. ``straight``: colours are divided by alpha,
    by which pixels are multiplied. ``tiles``: UDIM numbers with the index of each one's image.
    """

    image: int | None = None
    interpolation: str = "Linear"
    extension: str = "REPEAT"
    straight: bool = False
    tiles: tuple[tuple[int, int], ...] = ()


def as_pixels(array: np.ndarray) -> np.ndarray:
    """``array`` as pixels of a known type, C-contiguous; (0, 0, 4) if it is None or of an unknown shape."""
    array = np.asarray(array)
    if array.ndim != 3 or array.shape[2] not in (1, 3, 4) or not array.size:
        return np.zeros((0, 0, 4), np.float32)
    return np.ascontiguousarray(array, array.dtype if array.dtype in LARGEST else np.float32)


def decoded(codes: np.ndarray) -> np.ndarray:
    """Linear values (…) of sRGB values (…) (IEC 61966-2-1). Above 1 the power curve continues; below 0 the result is
    0."""
    codes = np.maximum(codes, codes.dtype.type(0.0))
    power = ((codes + 0.055) / 1.055) ** 2.4
    return np.where(codes < LINEAR_BELOW, codes / 12.92, power)


def colors(image: Image) -> np.ndarray:
    """Scene-linear RGB (height, width, 3) float32 of all pixels, without a copy if possible; one magenta pixel if the
    image is missing."""
    pixels = as_pixels(image.pixels)
    if not pixels.size:
        return np.full((1, 1, 3), MISSING[:3], np.float32)
    stored = pixels[..., :3]
    if pixels.dtype == np.float32 and stored.shape[2] == 3 and not image.encoded:
        return stored
    result = np.empty((*pixels.shape[:2], 3), np.float32)
    result[...] = stored
    if pixels.dtype.kind == "u":
        result /= np.float32(LARGEST[pixels.dtype])
    if image.encoded:
        for row in result:  # one at a time: a power of a whole image would double the memory twice
            row[:] = decoded(row)
    return result


def mean_color(image: Image) -> tuple[float, float, float]:
    """Approximate mean of the colours, from at most 256 × 256 pixels."""
    pixels = as_pixels(image.pixels)
    steps = (max(size // 256, 1) for size in pixels.shape[:2])
    few = Image(image.name, pixels[tuple(slice(None, None, step) for step in steps)], image.encoded)
    red, green, blue = colors(few).mean((0, 1), dtype=np.float64).tolist()
    return red, green, blue


def reduced(pixels: np.ndarray, limit: int, share: float | None = None) -> np.ndarray:
    """Pixels (height, width, channels) made smaller, as in Cycles' Simplify, until no side is longer than the
    ``limit``, unless that is 0. With a ``share``, to that fraction of their size, or to the limit; without, by repeated
    halving."""
    height, width = pixels.shape[:2]
    longest, factor = max(height, width), 1.0 if share is None else share
    if limit and longest > limit:
        if share is not None:
            factor = min(factor, limit / longest)
        while share is None and longest * factor > limit:
            factor *= 0.5
    if factor >= 1.0 or not pixels.size:
        return pixels
    inverse = 1.0 / factor
    result = pixels.astype(np.float32)
    for axis, size in enumerate((height, width)):
        result = _averaged(result, max(int(size * factor), 1), inverse, axis)
    return (np.rint(result) if pixels.dtype.kind == "u" else result).astype(pixels.dtype)


def _averaged(values: np.ndarray, count: int, step: float, axis: int) -> np.ndarray:
    """Means of about ``step`` values each, starting at each of ``count`` positions."""
    size, width = values.shape[axis], int(step + 0.5)
    first = (np.arange(count) * step).astype(int)
    total, number = 0.0, np.zeros(count)
    for offset in range(width):
        there = first + offset < size
        part = np.take(values, np.minimum(first + offset, size - 1), axis)
        shape = [1, 1, 1]
        shape[axis] = count
        total = total + part * there.reshape(shape).astype(np.float32)
        number += there
    return total / number.reshape(shape).astype(np.float32)


STEPS = 4 * 255  # of the table of decoded values, which include those of bytes


@functools.lru_cache(maxsize=1)
def decoding_table() -> np.ndarray:
    """(STEPS + 2,) float32: linear values of the sRGB codes 0, 1 / STEPS, … 1, and one more.

    Values in between are interpolated linearly, to 4e-7: a power takes seven times as long.
    """
    return decoded(np.arange(STEPS + 2) / STEPS).astype(np.float32)
