# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures and their look-up, in the steps of Cycles: stored texels are interpolated, the result is divided by
alpha if needed, and decoded.

Texture coordinates are (0, 0) at the lower left corner of the image and (1, 1) at the upper right; the centre of a
texel lies half a texel inside, as in Blender.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ...jit import block_dtype, fill_table, float_of_bits, kernel, table
from ...replaced import replaced_on_gpu
from ..images import LARGEST, MISSING, STEPS, Texture, as_pixels, decoding_table

CLOSEST, LINEAR, CUBIC = range(3)
REPEAT, EXTEND, CLIP, MIRROR = range(4)
INTERPOLATIONS = {"Linear": LINEAR, "Closest": CLOSEST, "Cubic": CUBIC, "Smart": CUBIC}
EXTENSIONS = {"REPEAT": REPEAT, "EXTEND": EXTEND, "CLIP": CLIP, "MIRROR": MIRROR}
BYTE, SHORT, HALF, FLOAT = range(4)
FORMATS = {np.dtype("u1"): BYTE, np.dtype("u2"): SHORT, np.dtype("f2"): HALF, np.dtype("f4"): FLOAT}

IMAGE = block_dtype(
    {"texels": np.dtype("u1")},
    [
        ("width", np.int64),
        ("height", np.int64),
        ("channels", np.int64),
        ("format", np.int64),
        ("encoded", np.int64),
        ("largest", np.float64),
        ("scale", np.float64),
    ],
)
TEXTURE = np.dtype(
    [
        ("image", "i4"),
        ("interpolation", "i4"),
        ("extension", "i4"),
        ("straight", "i4"),
        ("first_tile", "i4"),
        ("tiles", "i4"),
    ]
)
TILE = np.dtype([("number", "i4"), ("image", "i4")])  # of UDIM
TABLES = {"images": IMAGE, "textures": TEXTURE, "texture_tiles": TILE, "decoding": np.dtype("f4")}

_images = table("images", IMAGE)
_textures = table("textures", TEXTURE)
_tiles = table("texture_tiles", TILE)
_decoding = table("decoding", np.float32)
_bytes = table("texels", np.uint8)
_shorts = table("texels", np.uint16)
_floats = table("texels", np.float32)

_NOTHING = (0.0, 0.0, 0.0, 0.0)
_FAR = 4.0  # beyond this, an image that does not repeat is constant, even with a single texel
_TILES_ACROSS, _FIRST_TILE, _FAR_UP = 10, 1001, 1000.0  # of UDIM
_HALF_SCALE = 2.0**1008  # between the exponents of halves and of doubles


def pack_textures(scene, textures: Iterable[Texture]) -> dict[str, np.ndarray]:
    """Tables of ``scene.images``, to whose pixels they point (the caller keeps these alive), and of ``textures``, in
    order."""
    records = np.zeros(max(len(scene.images), 1), IMAGE)
    for index, image in enumerate(scene.images):
        image.pixels = pixels = as_pixels(image.pixels)
        if pixels.size:
            row = records[index : index + 1]
            fill_table(row, "texels", pixels.reshape(-1).view(np.uint8))
            row["height"], row["width"], row["channels"] = pixels.shape
            row["format"], row["encoded"] = FORMATS[pixels.dtype], image.encoded
            row["largest"] = LARGEST[pixels.dtype]
            row["scale"] = 1.0 / row["largest"]
    rows, tiles = [], []
    for texture in textures:
        rows.append(
            (
                -1 if texture.image is None else texture.image,
                INTERPOLATIONS.get(texture.interpolation, LINEAR),
                EXTENSIONS.get(texture.extension, REPEAT),
                texture.straight,
                len(tiles),
                len(texture.tiles),
            )
        )
        tiles += texture.tiles
    return {
        "images": records,
        "textures": np.array(rows or [(-1, 0, 0, 0, 0, 0)], TEXTURE),
        "texture_tiles": np.array(tiles or [(0, -1)], TILE),
        "decoding": decoding_table(),
    }


@kernel
def _wrap(i, size, extension):
    """Texel index for an index outside the image; −1 outside a clipped image."""
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
def component(image, i):
    """Number i of an image's texels, as stored."""
    if image.format == BYTE:
        return float(_bytes(image)[i])
    if image.format == SHORT:
        return float(_shorts(image)[i])
    if image.format == HALF:
        # Its exponent and mantissa at the positions of a double's, which also works for subnormal numbers.
        bits = int(_shorts(image)[i])
        size = float_of_bits((bits & 0x7FFF) << 42) * _HALF_SCALE
        return -size if bits & 0x8000 else size
    return float(_floats(image)[i])


@replaced_on_gpu
@kernel
def texel(image, column, row):
    """RGBA as stored; zeros if there is no texel (a column or row of −1)."""
    if column < 0 or row < 0:
        return _NOTHING
    i = image.channels * (row * image.width + column)
    if image.format == BYTE:  # the most common case
        values = _bytes(image)
        r = float(values[i])
        if image.channels == 1:
            return (r, r, r, image.largest)
        a = float(values[i + 3]) if image.channels == 4 else image.largest
        return (r, float(values[i + 1]), float(values[i + 2]), a)
    r = component(image, i)
    if image.channels == 1:
        return (r, r, r, image.largest)
    a = component(image, i + 3) if image.channels == 4 else image.largest
    return (r, component(image, i + 1), component(image, i + 2), a)


@kernel
def cubic_weight(t, i):
    """Weight i of four of the uniform cubic B-spline."""
    if i == 0:
        return (1.0 - t) ** 3 / 6.0
    if i == 1:
        return (3.0 * t * t * (t - 2.0) + 4.0) / 6.0
    if i == 2:
        return (3.0 * t * (1.0 + t - t * t) + 1.0) / 6.0
    return t * t * t / 6.0


@kernel
def _mixed(a, b, t):
    return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]), a[3] + t * (b[3] - a[3]))


@kernel
def _cubic_sum(image, column, row, s, t, extension):
    """RGBA of the sixteen texels around the four from (column, row) on."""
    r, g, b, a = 0.0, 0.0, 0.0, 0.0
    for j in range(4):
        other_row, weight_v = _wrap(row + j - 1, image.height, extension), cubic_weight(t, j)
        for i in range(4):
            weight = weight_v * cubic_weight(s, i)
            found = texel(image, _wrap(column + i - 1, image.width, extension), other_row)
            r, g, b, a = r + weight * found[0], g + weight * found[1], b + weight * found[2], a + weight * found[3]
    return (r, g, b, a)


@kernel
def _interpolated(image, u, v, interpolation, extension):
    """RGBA of texels as stored. Those outside a clipped image are transparent black."""
    # Far out, coordinates keep their precision and texel indices their range.
    if extension == REPEAT:
        u, v = u - np.floor(u), v - np.floor(v)
    elif extension == MIRROR:
        u, v = u - 2.0 * np.floor(0.5 * u), v - 2.0 * np.floor(0.5 * v)
    else:
        u, v = min(max(u, -_FAR), 1.0 + _FAR), min(max(v, -_FAR), 1.0 + _FAR)
    x, y = u * image.width, v * image.height
    if interpolation == CLOSEST:
        column, row = int(np.floor(x)), int(np.floor(y))
        return texel(image, _wrap(column, image.width, extension), _wrap(row, image.height, extension))
    x, y = x - 0.5, y - 0.5
    column, row = int(np.floor(x)), int(np.floor(y))
    s, t = x - column, y - row
    if interpolation == CUBIC:
        return _cubic_sum(image, column, row, s, t, extension)
    left, right = _wrap(column, image.width, extension), _wrap(column + 1, image.width, extension)
    below, above = _wrap(row, image.height, extension), _wrap(row + 1, image.height, extension)
    lower = _mixed(texel(image, left, below), texel(image, right, below), s)
    upper = _mixed(texel(image, left, above), texel(image, right, above), s)
    return _mixed(lower, upper, t)


@replaced_on_gpu
@kernel
def decoded(block, code):
    """The linear value of an sRGB code, as ``images.decoded``."""
    if code > 1.0:
        return ((code + 0.055) / 1.055) ** 2.4
    # No branch for dark values: which texels are dark cannot be predicted.
    values, place = _decoding(block), max(code, 0.0) * STEPS
    i = int(place)
    return values[i] + (place - i) * (values[i + 1] - values[i])


@kernel
def image_lookup(block, index, u, v, interpolation, extension, straight):
    """Scene-linear RGBA of image ``index`` at (u, v); magenta if it is missing. ``straight``: colour is divided by
    alpha."""
    images = _images(block)
    if index < 0 or index >= len(images) or images[index].width == 0:
        return MISSING
    if not (math.isfinite(u) and math.isfinite(v)):
        return _NOTHING
    image = images[index]
    r, g, b, a = _interpolated(image, u, v, interpolation, extension)
    scale = image.scale
    # Outside of a clipped image grey is black, but not transparent.
    a = 1.0 if image.channels == 1 else scale * a
    if straight and a != 0.0 and a != 1.0:
        scale /= a
    r, g, b = scale * r, scale * g, scale * b
    if image.encoded:
        return (decoded(block, r), decoded(block, g), decoded(block, b), a)
    return (r, g, b, a)


@kernel
def texture_lookup(block, workspace, place, u, v):
    """Scene-linear RGBA of the texture in this row of the table at (u, v); black where ``place`` is below 0. Between
    UDIM tiles it is magenta."""
    if place < 0.0:
        return _NOTHING
    texture = _textures(block)[int(place)]
    index = texture.image
    if texture.tiles > 0:
        index = -1
        if -1.0 < u < _TILES_ACROSS and -1.0 < v < _FAR_UP:
            # Cycles rounds towards zero, too: within a tile's width below the first tile, the first tile is used.
            column, row = int(u), int(v)
            number = _FIRST_TILE + _TILES_ACROSS * row + column
            tiles = _tiles(block)
            for i in range(texture.first_tile, texture.first_tile + texture.tiles):
                if tiles[i].number == number:
                    index = tiles[i].image
            u, v = u - column, v - row
    return image_lookup(block, index, u, v, texture.interpolation, texture.extension, texture.straight)
