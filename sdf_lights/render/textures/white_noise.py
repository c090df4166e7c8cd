# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's White Noise Texture: numbers in [0, 1] that depend on every bit of the coordinates.

``VALUE[dimensions](coordinates …) -> value``, ``COLOR[dimensions](coordinates …) -> (r, g, b)``; r is the value.
"""

from ...jit import kernel
from .hashing import bits, color_1, color_2, color_3, color_4, hash_3, hash_4, point_1, unit, unit_2


@kernel
def _value_1d(x):
    return point_1(bits(x))


@kernel
def _value_2d(x, y):
    return unit_2(bits(x), bits(y))


@kernel
def _value_3d(x, y, z):
    return unit(hash_3(bits(x), bits(y), bits(z)))


@kernel
def _value_4d(x, y, z, w):
    return unit(hash_4(bits(x), bits(y), bits(z), bits(w)))


@kernel
def _color_1d(x):
    return color_1(bits(x))


@kernel
def _color_2d(x, y):
    return color_2(bits(x), bits(y))


@kernel
def _color_3d(x, y, z):
    return color_3(bits(x), bits(y), bits(z))


@kernel
def _color_4d(x, y, z, w):
    return color_4(bits(x), bits(y), bits(z), bits(w))


VALUE = {1: _value_1d, 2: _value_2d, 3: _value_3d, 4: _value_4d}
COLOR = {1: _color_1d, 2: _color_2d, 3: _color_3d, 4: _color_4d}
