# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures and their look-up.

Texture coordinates have (0, 0) at the lower left corner of the image and (1, 1) at the upper right; the centre of a
texel lies half a texel inside, as in Blender.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import block_dtype, fill_table, kernel, table

LINEAR, CLOSEST, CUBIC = range(3)
REPEAT, EXTEND, CLIP, MIRROR = range(4)
INTERPOLATIONS = {"Linear": LINEAR, "Closest": CLOSEST, "Cubic": CUBIC, "Smart": CUBIC}
EXTENSIONS = {"REPEAT": REPEAT, "EXTEND": EXTEND, "CLIP": CLIP, "MIRROR": MIRROR}

TEXEL = np.dtype("f4")
IMAGE = block_dtype({"texels": TEXEL}, [("width", np.int64), ("height", np.int64)])
TABLES = {"images": IMAGE}

_images = table("images", TABLES["images"])
_texels = table("texels", TEXEL)

_MISSING = (1.0, 0.0, 1.0, 1.0)
_FAR = 4.0  # of an image that does not repeat nothing changes farther out than this, even if it is a single texel


def pack_images(scene) -> dict[str, np.ndarray]:
    """Tables of ``scene.images``, whose pixels they point at: the caller keeps these alive.

    An image without pixels, or of another shape than (h, w, 4), counts as missing.
    """
    records = np.zeros(max(len(scene.images), 1), IMAGE)
    for index, image in enumerate(scene.images):
        image.pixels = pixels = np.ascontiguousarray(image.pixels, TEXEL)
        if pixels.ndim == 3 and pixels.shape[2] == 4 and pixels.size:
            record = records[index:index + 1]
            fill_table(record, "texels", pixels.reshape(-1))
            record["height"], record["width"] = pixels.shape[:2]
    return {"images": records}


@kernel
def _wrap(i, size, extension):
    """Texel index of an index outside the image; −1 for what CLIP leaves out."""
    if 0 <= i < size:
        return i
    if extension == REPEAT:
        return i % size
    if extension == EXTEND:
        return min(max(i, 0), size - 1)
    if extension == MIRROR:
        i %= 2 * size
        return i if i < size else 2 * size - 1 - i
    return -1


@kernel
def _add_texel(texels, image, x, y, extension, associated, weight, total):
    column, row = _wrap(x, image.width, extension), _wrap(y, image.height, extension)
    if column < 0 or row < 0:
        return total
    i = 4 * (row * image.width + column)
    color = weight * texels[i + 3] if associated else weight
    return (
        total[0] + color * texels[i],
        total[1] + color * texels[i + 1],
        total[2] + color * texels[i + 2],
        total[3] + weight * texels[i + 3],
    )


@kernel
def _cubic(t, i):
    """Weight i of four of the uniform cubic B-spline."""
    if i == 0:
        return (1.0 - t) ** 3 / 6.0
    if i == 1:
        return (3.0 * t * t * (t - 2.0) + 4.0) / 6.0
    if i == 2:
        return (3.0 * t * (1.0 + t - t * t) + 1.0) / 6.0
    return t * t * t / 6.0


@kernel
def image_lookup(block, index, u, v, interpolation, extension, associated):
    """RGBA of image ``index`` at (u, v); magenta if it is missing. Texels outside a clipped image are transparent
    black, and interpolation blends with them. ``associated``: colour is multiplied by alpha."""
    images = _images(block)
    if index < 0 or index >= len(images) or images[index].width == 0:
        return _MISSING
    image = images[index]
    nothing = (0.0, 0.0, 0.0, 0.0)
    if not (math.isfinite(u) and math.isfinite(v)):
        return nothing
    # Far out, coordinates keep their precision and texel indices their range.
    if extension == REPEAT:
        u, v = u - np.floor(u), v - np.floor(v)
    elif extension == MIRROR:
        u, v = u - 2.0 * np.floor(0.5 * u), v - 2.0 * np.floor(0.5 * v)
    else:
        u, v = min(max(u, -_FAR), 1.0 + _FAR), min(max(v, -_FAR), 1.0 + _FAR)
    texels = _texels(image)
    x, y = u * image.width, v * image.height
    if interpolation == CLOSEST:
        column, row = int(np.floor(x)), int(np.floor(y))
        return _add_texel(texels, image, column, row, extension, associated, 1.0, nothing)
    x, y = x - 0.5, y - 0.5
    column, row = int(np.floor(x)), int(np.floor(y))
    s, t = x - column, y - row
    total = nothing
    if interpolation == CUBIC:
        for j in range(4):
            for i in range(4):
                weight = _cubic(s, i) * _cubic(t, j)
                total = _add_texel(texels, image, column + i - 1, row + j - 1, extension, associated, weight, total)
        return total
    for j in range(2):
        for i in range(2):
            weight = (s if i else 1.0 - s) * (t if j else 1.0 - t)
            total = _add_texel(texels, image, column + i, row + j, extension, associated, weight, total)
    return total
