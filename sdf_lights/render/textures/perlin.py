# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Perlin noise of one to four dimensions: Perlin 2002, "Improving noise", with the hash and the gradients of Cycles.

The corners of a cell are a loop, which compilers vectorise.
"""

import math

from ...jit import kernel
from .hashing import hash_1, hash_2, hash_3, hash_4, uint32

_PERIOD, _FAR = 100000.0, 1000000.0


@kernel
def _fade(t):
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@kernel
def _repeated(x):
    """The coordinate in a repeating pattern, because single precision has too few digits for large ones."""
    size = abs(x)
    if size < _PERIOD:
        return x
    if not size < 1e20:  # NaN, or too large to have a fractional part
        return 0.0
    x -= _PERIOD * int(x / _PERIOD)
    return x if size < _FAR else x + 0.5


@kernel
def _gradient_1(h, x):
    slope = float(1 + (h & 7))
    return (-slope if h & 8 else slope) * x


@kernel
def _gradient_2(h, x, y):
    swapped = h & 4
    u, v = y if swapped else x, 2.0 * (x if swapped else y)
    return (-u if h & 1 else u) + (-v if h & 2 else v)


@kernel
def _gradient_3(h, x, y, z):
    h &= 15
    u, v = x if h < 8 else y, y if h < 4 else (x if h == 12 or h == 14 else z)
    return (-u if h & 1 else u) + (-v if h & 2 else v)


@kernel
def _gradient_4(h, x, y, z, w):
    h &= 31
    u, v, s = x if h < 24 else y, y if h < 16 else z, z if h < 8 else w
    return (-u if h & 1 else u) + (-v if h & 2 else v) + (-s if h & 4 else s)


@kernel
def _signed_noise_1d(p, scale):
    x = _repeated(p[0] * scale)
    i = int(math.floor(x))
    x -= i
    near, far = _gradient_1(hash_1(uint32(i)), x), _gradient_1(hash_1(uint32(i + 1)), x - 1.0)
    return 0.25 * (near + _fade(x) * (far - near))


@kernel
def _signed_noise_2d(p, scale):
    x, y = _repeated(p[0] * scale), _repeated(p[1] * scale)
    i, j = int(math.floor(x)), int(math.floor(y))
    x, y = x - i, y - j
    u, v = _fade(x), _fade(y)
    total = 0.0
    for corner in range(4):
        a, b = corner & 1, corner >> 1
        value = _gradient_2(hash_2(uint32(i + a), uint32(j + b)), x - a, y - b)
        total += value * (u if a else 1.0 - u) * (v if b else 1.0 - v)
    return 0.6616 * total


@kernel
def _signed_noise_3d(p, scale):
    x, y, z = _repeated(p[0] * scale), _repeated(p[1] * scale), _repeated(p[2] * scale)
    i, j, k = int(math.floor(x)), int(math.floor(y)), int(math.floor(z))
    x, y, z = x - i, y - j, z - k
    u, v, w = _fade(x), _fade(y), _fade(z)
    total = 0.0
    for corner in range(8):
        a, b, c = corner & 1, (corner >> 1) & 1, corner >> 2
        value = _gradient_3(hash_3(uint32(i + a), uint32(j + b), uint32(k + c)), x - a, y - b, z - c)
        total += value * (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
    return 0.9820 * total


@kernel
def _signed_noise_4d(p, scale):
    x, y, z, w = _repeated(p[0] * scale), _repeated(p[1] * scale), _repeated(p[2] * scale), _repeated(p[3] * scale)
    i, j, k, l = int(math.floor(x)), int(math.floor(y)), int(math.floor(z)), int(math.floor(w))
    x, y, z, w = x - i, y - j, z - k, w - l
    s, t, u, v = _fade(x), _fade(y), _fade(z), _fade(w)
    total = 0.0
    for corner in range(16):
        a, b, c, d = corner & 1, (corner >> 1) & 1, (corner >> 2) & 1, corner >> 3
        value = _gradient_4(
            hash_4(uint32(i + a), uint32(j + b), uint32(k + c), uint32(l + d)), x - a, y - b, z - c, w - d
        )
        total += value * (s if a else 1.0 - s) * (t if b else 1.0 - t) * (u if c else 1.0 - u) * (v if d else 1.0 - v)
    return 0.8344 * total


SIGNED_NOISE = {1: _signed_noise_1d, 2: _signed_noise_2d, 3: _signed_noise_3d, 4: _signed_noise_4d}
"""Dimensions -> kernel (p, scale) -> noise between about −1 and 1 at p · scale; p has that many coordinates or more."""
