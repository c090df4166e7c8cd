# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Brick Texture, without its colours."""

import math

from ...jit import kernel
from .hashing import uint32


@kernel
def _tint(row, brick):
    """A number in [0, 1) for a brick: an integer noise older than Blender's hashes."""
    n = uint32(uint32(uint32(row << 16) + uint32(brick & 0xFFFF)) + 1013) & 0x7FFFFFFF
    n = uint32(n ^ (n >> 13))
    square = uint32(uint32(uint32(n * n) * 60493) + 19990303)
    return float(uint32(uint32(n * square) + 1376312589) & 0x7FFFFFFF) * (1.0 / 2147483648.0)


@kernel
def brick(x, y, mortar_size, mortar_smooth, bias, width, height, offset, offset_rows, squash, squash_rows):
    """Fraction of the second colour in the brick at a point, and fraction of mortar there.

    One of ``offset_rows`` rows is shifted by the fraction ``offset`` of a brick. In one of ``squash_rows``, bricks are
    ``squash`` times as wide. Numbers of rows are whole.
    """
    row = int(math.floor(y / height)) if height != 0.0 else 0
    shift = 0.0
    if offset_rows >= 1.0 and squash_rows >= 1.0:
        if row % int(squash_rows) == 0:
            width *= squash
        if row % int(offset_rows) == 0:
            shift = width * offset
    x += shift
    column = int(math.floor(x / width)) if width != 0.0 else 0
    x -= width * column
    y -= height * row
    tint = min(max(0.0, _tint(row, column) + bias), 1.0)
    inside = min(min(x, y), min(width - x, height - y))
    if inside >= mortar_size:
        return tint, 0.0
    if mortar_smooth == 0.0 or mortar_size == 0.0:
        return tint, 1.0
    share = min(max(0.0, (1.0 - inside / mortar_size) / mortar_smooth), 1.0)
    return tint, share * share * (3.0 - 2.0 * share)
