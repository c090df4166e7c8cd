# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values between the voxels of a grid: see ``render.voxels``, which packs it."""

from __future__ import annotations

import math

import numpy as np

from ...jit import float_bits, kernel
from ...vec import transform_point
from ..textures.hashing import color_3
from ..voxels import BACKGROUND, BRICK, CHANNELS, COUNTS, HEAD
from .geometry import attribute_table, attribute_value_table, instance_table, surface_table
from .textures import cubic_weight

# Between the centers of voxels: linear, by cubic B-splines, or one of the eight around a point, chosen by a hash of it
# so that their mean is linear.
LINEAR, CUBIC, BY_CHANCE = range(3)

_FAR = 1e9  # voxels; beyond, whole numbers would leave their range
_TRANSPARENT = 1e-6


@kernel
def _place(values, start, i, j, k):
    """Where the numbers of a voxel begin; those of the background outside of the box."""
    nx, ny, nz = int(values[start + COUNTS]), int(values[start + COUNTS + 1]), int(values[start + COUNTS + 2])
    if i < 0 or j < 0 or k < 0 or i >= 8 * nx or j >= 8 * ny or k >= 8 * nz:
        return start + BACKGROUND
    places = start + HEAD
    brick = int(values[places + (i >> 3) + nx * ((j >> 3) + ny * (k >> 3))])
    inner = (i & 7) + 8 * ((j & 7) + 8 * (k & 7))
    return places + nx * ny * nz + int(values[start + CHANNELS]) * (BRICK * brick + inner)


@kernel
def _add(values, at, channels, weight, total):
    """Four sums and the numbers of a voxel by its weight."""
    x, y, z, w = total
    x += weight * float(values[at])
    if channels > 1:
        y, z = y + weight * float(values[at + 1]), z + weight * float(values[at + 2])
    if channels > 3:
        w += weight * float(values[at + 3])
    return x, y, z, w


@kernel
def _between(values, start, p, mode):
    """Interpolated values at p, in voxels. There are four numbers; those without a channel are 0."""
    i, j, k = np.int64(math.floor(p[0])), np.int64(math.floor(p[1])), np.int64(math.floor(p[2]))
    s, t, far = p[0] - i, p[1] - j, p[2] - k
    channels, total = int(values[start + CHANNELS]), (0.0, 0.0, 0.0, 0.0)
    if mode == CUBIC:
        for c in range(4):
            for b in range(4):
                share = cubic_weight(far, c) * cubic_weight(t, b)
                for a in range(4):
                    at = _place(values, start, i + a - 1, j + b - 1, k + c - 1)
                    total = _add(values, at, channels, share * cubic_weight(s, a), total)
        return total
    if mode == BY_CHANCE:
        u = color_3(float_bits(p[0]), float_bits(p[1]), float_bits(p[2]))
        at = _place(values, start, i + int(u[0] < s), j + int(u[1] < t), k + int(u[2] < far))
        return _add(values, at, channels, 1.0, total)
    for c in range(2):
        for b in range(2):
            share = (far if c == 1 else 1.0 - far) * (t if b == 1 else 1.0 - t)
            for a in range(2):
                at = _place(values, start, i + a, j + b, k + c)
                total = _add(values, at, channels, share * (s if a == 1 else 1.0 - s), total)
    return total


@kernel
def _coordinate(values, row, p):
    """A row of a matrix times a point."""
    return values[row] * p[0] + values[row + 1] * p[1] + values[row + 2] * p[2] + values[row + 3]


@kernel
def grid_value(block, workspace, mode, place, x, y, z):
    """Attribute number ``place``, a grid, at the world point (x, y, z): three numbers, alpha, and the mean of the
    three. All are 0 if the object has no such grid. Colours with alpha are divided by it, as in Cycles."""
    instance = instance_table(block)[surface_table(workspace)[0].instance]
    record = attribute_table(block)[instance.attributes + int(place)]
    if record.domain < 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    values, start = attribute_value_table(block), record.start
    inner = transform_point(instance.inverse, (x, y, z))
    p = (
        _coordinate(values, start, inner),
        _coordinate(values, start + 4, inner),
        _coordinate(values, start + 8, inner),
    )
    if not (abs(p[0]) < _FAR and abs(p[1]) < _FAR and abs(p[2]) < _FAR):
        return 0.0, 0.0, 0.0, 0.0, 0.0
    r, g, b, alpha = _between(values, start, p, mode)
    if values[start + CHANNELS] < 2.0:
        return r, r, r, 1.0, r
    if values[start + CHANNELS] < 4.0:
        alpha = 1.0
    elif alpha > _TRANSPARENT and alpha != 1.0:
        r, g, b = r / alpha, g / alpha, b / alpha
    return r, g, b, alpha, (r + g + b) / 3.0
