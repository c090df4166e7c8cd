# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels on the GPU, in the format of the images, packed in the words of a table.

They are not OpenGL textures: cards interpolate those with weights of eight bits.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, table
from ..images import LINEAR_BELOW, Image
from ..kernels.textures import BYTE, FLOAT, SHORT
from .crossings import halves

_words = table("texels", np.uint32)
_floats = table("texels", np.float32)


def placed(images: list[Image], records: np.ndarray) -> dict[str, np.ndarray]:
    """Tables of the pixels, and of the ``records`` (images,) of ``kernels.textures.pack_textures``, with the start of
    each image in them."""
    records, parts, used = records.copy(), [np.zeros(0, np.uint32)], 0
    for record, image in zip(records, images):
        if record["width"] > 0:
            record["texels_address"] = used
            flat = image.pixels.reshape(-1).view(np.uint8)
            if flat.size % 4:
                flat = np.concatenate([flat, np.zeros(-flat.size % 4, np.uint8)])
            parts.append(flat.view(np.uint32))
            used += parts[-1].size
    return {"images": records, "texels": parts[1] if len(parts) == 2 else np.concatenate(parts)}


@kernel
def component(image, i):
    """As ``kernels.textures.component``."""
    if image.format == FLOAT:
        return _floats(image)[i]
    words = _words(image)
    if image.format == BYTE:
        return float((words[i >> 2] >> (8 * (i & 3))) & 255)
    word = words[i >> 1] >> (16 * (i & 1))
    return float(word & 65535) if image.format == SHORT else halves(word)[0]


@kernel
def texel(image, column, row):
    """As ``kernels.textures.texel``, which reads a word for four bytes."""
    if column < 0 or row < 0:
        return (0.0, 0.0, 0.0, 0.0)
    i = image.channels * (row * image.width + column)
    if image.channels == 4 and image.format == BYTE:
        word = _words(image)[i >> 2]
        return (float(word & 255), float((word >> 8) & 255), float((word >> 16) & 255), float((word >> 24) & 255))
    r = component(image, i)
    if image.channels == 1:
        return (r, r, r, image.largest)
    a = component(image, i + 3) if image.channels == 4 else image.largest
    return (r, component(image, i + 1), component(image, i + 2), a)


@kernel
def decoded(block, code):
    """As ``kernels.textures.decoded``, without a table: on a GPU, reading one takes longer than a power."""
    if code < LINEAR_BELOW:
        return max(code, 0.0) / 12.92
    return ((code + 0.055) / 1.055) ** 2.4
