# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hashes of cells and of coordinates: the same as in Cycles, bit for bit, so patterns are the same.

Whole numbers: Jenkins 2006, "lookup3", and PCG of Jarzynski and Olano 2020, "Hash functions for GPU rendering", JCGT
9(3). Cycles computes the latter with signed numbers, whose shifts keep the sign. Coordinates: the bits of single
precision.
"""

import numpy as np

from ...jit import AVAILABLE, float_bits, kernel

if AVAILABLE:
    int32, uint32 = np.int32, np.uint32
else:  # integers of Python do not wrap around

    def uint32(x):
        return x & 0xFFFFFFFF

    def int32(x):
        return ((x + 0x80000000) & 0xFFFFFFFF) - 0x80000000


def _start(count: int):
    """Jenkins' initial state for ``count`` words."""
    return uint32(0xDEADBEEF + (count << 2) + 13)


_START_1, _START_2, _START_3, _START_4 = map(_start, (1, 2, 3, 4))
_ONE, _TWO = uint32(0x3F800000), uint32(0x40000000)  # bits of 1 and 2 in single precision


@kernel
def _mixed(a, b, c):
    a = uint32(uint32(a - c) ^ uint32(c << 4 | c >> 28))
    c = uint32(c + b)
    b = uint32(uint32(b - a) ^ uint32(a << 6 | a >> 26))
    a = uint32(a + c)
    c = uint32(uint32(c - b) ^ uint32(b << 8 | b >> 24))
    b = uint32(b + a)
    a = uint32(uint32(a - c) ^ uint32(c << 16 | c >> 16))
    c = uint32(c + b)
    b = uint32(uint32(b - a) ^ uint32(a << 19 | a >> 13))
    a = uint32(a + c)
    c = uint32(uint32(c - b) ^ uint32(b << 4 | b >> 28))
    return a, uint32(b + a), c


@kernel
def _finished(a, b, c):
    c = uint32(uint32(c ^ b) - uint32(b << 14 | b >> 18))
    a = uint32(uint32(a ^ c) - uint32(c << 11 | c >> 21))
    b = uint32(uint32(b ^ a) - uint32(a << 25 | a >> 7))
    c = uint32(uint32(c ^ b) - uint32(b << 16 | b >> 16))
    a = uint32(uint32(a ^ c) - uint32(c << 4 | c >> 28))
    b = uint32(uint32(b ^ a) - uint32(a << 14 | a >> 18))
    return uint32(uint32(c ^ b) - uint32(b << 24 | b >> 8))


@kernel
def hash_1(x):
    """uint32 from a uint32."""
    return _finished(uint32(_START_1 + x), _START_1, _START_1)


@kernel
def hash_2(x, y):
    """uint32 from two uint32."""
    return _finished(uint32(_START_2 + x), uint32(_START_2 + y), _START_2)


@kernel
def hash_3(x, y, z):
    """uint32 from three uint32."""
    return _finished(uint32(_START_3 + x), uint32(_START_3 + y), uint32(_START_3 + z))


@kernel
def hash_4(x, y, z, w):
    """uint32 from four uint32."""
    a, b, c = _mixed(uint32(_START_4 + x), uint32(_START_4 + y), uint32(_START_4 + z))
    return _finished(uint32(a + w), b, c)


@kernel
def unit(x):
    """The number in [0, 1] for a uint32."""
    return float(x) * (1.0 / 4294967295.0)


@kernel
def unit_2(x, y):
    """Number in [0, 1] for two uint32."""
    return unit(hash_2(x, y))


# Of bits of coordinates: numbers, points and colours in [0, 1].


@kernel
def point_1(x):
    """A number for the bits of a coordinate."""
    return unit(hash_1(x))


@kernel
def point_2(x, y):
    """A point for the bits of two coordinates."""
    return unit(hash_2(x, y)), unit(hash_3(x, y, _ONE))


@kernel
def point_4(x, y, z, w):
    """A point for the bits of four coordinates."""
    return unit(hash_4(x, y, z, w)), unit(hash_4(w, x, y, z)), unit(hash_4(z, w, x, y)), unit(hash_4(y, z, w, x))


@kernel
def color_1(x):
    """A colour for the bits of a coordinate."""
    return unit(hash_1(x)), unit(hash_2(x, _ONE)), unit(hash_2(x, _TWO))


@kernel
def color_2(x, y):
    """A colour for the bits of two coordinates."""
    return unit(hash_2(x, y)), unit(hash_3(x, y, _ONE)), unit(hash_3(x, y, _TWO))


@kernel
def color_3(x, y, z):
    """A colour for the bits of a point."""
    return unit(hash_3(x, y, z)), unit(hash_4(x, y, z, _ONE)), unit(hash_4(x, y, z, _TWO))


@kernel
def color_4(x, y, z, w):
    """A colour for the bits of four coordinates."""
    return unit(hash_4(x, y, z, w)), unit(hash_4(z, x, w, y)), unit(hash_4(w, z, y, x))


# Of whole numbers.


@kernel
def _positive_unit(x):
    return float(x & 0x7FFFFFFF) * (1.0 / 2147483647.0)


@kernel
def cell_2(x, y):
    """Two numbers in [0, 1] for a cell."""
    x, y = int32(x * 1664525 + 1013904223), int32(y * 1664525 + 1013904223)
    x = int32(x + y * 1664525)
    y = int32(y + x * 1664525)
    x, y = int32(x ^ (x >> 16)), int32(y ^ (y >> 16))
    x = int32(x + y * 1664525)
    y = int32(y + x * 1664525)
    return _positive_unit(x), _positive_unit(y)


@kernel
def cell_3(x, y, z):
    """Three numbers in [0, 1] for a cell."""
    x, y, z = int32(x * 1664525 + 1013904223), int32(y * 1664525 + 1013904223), int32(z * 1664525 + 1013904223)
    x = int32(x + y * z)
    y = int32(y + z * x)
    z = int32(z + x * y)
    x, y, z = int32(x ^ (x >> 16)), int32(y ^ (y >> 16)), int32(z ^ (z >> 16))
    x = int32(x + y * z)
    y = int32(y + z * x)
    z = int32(z + x * y)
    return _positive_unit(x), _positive_unit(y), _positive_unit(z)


@kernel
def cell_4(x, y, z, w):
    """Four numbers in [0, 1] for a cell."""
    x, y, z, w = (
        int32(x * 1664525 + 1013904223),
        int32(y * 1664525 + 1013904223),
        int32(z * 1664525 + 1013904223),
        int32(w * 1664525 + 1013904223),
    )
    x = int32(x + y * w)
    y = int32(y + z * x)
    z = int32(z + x * y)
    w = int32(w + y * z)
    x, y, z, w = int32(x ^ (x >> 16)), int32(y ^ (y >> 16)), int32(z ^ (z >> 16)), int32(w ^ (w >> 16))
    x = int32(x + y * w)
    y = int32(y + z * x)
    z = int32(z + x * y)
    w = int32(w + y * z)
    return _positive_unit(x), _positive_unit(y), _positive_unit(z), _positive_unit(w)


@kernel
def bits(x):
    """The 32 bits of a number in single precision, as uint32."""
    return float_bits(float(x))
