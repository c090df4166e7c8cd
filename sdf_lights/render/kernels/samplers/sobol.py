# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sampling pattern: Owen-scrambled Sobol points in padded sets of one to four dimensions.

Each decision of a path (``dimension``, a running number) takes a separate set of at most four dimensions. The sets
reuse the first four Sobol dimensions. A nested uniform permutation of the index shuffles the points of each set, which
makes the sets independent of each other, while any aligned block of 2^k indices keeps its stratification. A nested
uniform scrambling of their digits makes every point uniform (Burley 2020, "Practical hash-based Owen scrambling", JCGT
9(4); Owen 1995). The first two dimensions are a (0, 2)-sequence. The permutations are hashes, so a point is a function
of (index, pixel, set) alone: no state, no limit on the sets, the same picture in any order of work.

Points are computed bit-reversed. In that form the first Sobol dimension is the index itself, a nested uniform scramble
is a hash that carries only from low bits to high ones, and a single reversal at the end gives the value.
"""

import numpy as np

from ....bits import reverse_32, reverse_64, unit_float
from ....jit import kernel

_U32, _U64 = np.uint32, np.uint64
_SHIFT_30, _SHIFT_27, _SHIFT_31, _SHIFT_32 = _U64(30), _U64(27), _U64(31), _U64(32)
_MIX_1, _MIX_2 = _U64(0xBF58476D1CE4E5B9), _U64(0x94D049BB133111EB)
_GOLDEN = _U64(0x9E3779B97F4A7C15)


def _sobol_bytes(degree: int, coefficients: int, initial: tuple[int, ...]) -> np.ndarray:
    """(1024,) uint32: the bit-reversed Sobol point of each value of each byte of the index, the lowest byte first.

    ``degree`` and the inner ``coefficients`` of the primitive polynomial and the ``initial`` direction integers are
    those of Joe and Kuo 2008, "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci.
    Comput. 30.
    """
    m = list(initial)
    for k in range(degree, 32):
        value = m[k - degree] ^ (m[k - degree] << degree)
        for i in range(1, degree):
            if coefficients >> (degree - 1 - i) & 1:
                value ^= m[k - i] << i
        m.append(value)
    # A direction number is m_k / 2^(k+1): its k + 1 leading binary digits, reversed here.
    columns = [int(format(m[k], f"0{k + 1}b")[::-1], 2) for k in range(32)]
    table = np.zeros((4, 256), np.uint32)
    for byte in range(4):
        for value in range(256):
            for bit in range(8):
                if value >> bit & 1:
                    table[byte, value] ^= _U32(columns[8 * byte + bit])
    return table.ravel()


_THIRD = _sobol_bytes(2, 1, (1, 3))
_FOURTH = _sobol_bytes(3, 1, (1, 3, 1))


TABLES = {"sobol_third": _THIRD, "sobol_fourth": _FOURTH}


@kernel
def _mix(z):
    """Finalizer of SplitMix64 (Steele, Lea and Flood 2014), variant 13 of Stafford: a bijection of 64-bit words."""
    z = (z ^ (z >> _SHIFT_30)) * _MIX_1
    z = (z ^ (z >> _SHIFT_27)) * _MIX_2
    return z ^ (z >> _SHIFT_31)


@kernel
def _scramble(x, seed):
    """Nested uniform scramble of a bit-reversed word: each bit is flipped depending on ``seed`` and the lower bits.

    Laine and Karras 2011, with the constants of Vegdahl 2021, "Building a better LK hash".
    """
    x = _U32(x ^ _U32(x * 0x3D20ADEA))
    x = _U32(x + seed)
    x = _U32(x * ((seed >> 16) | 1))
    x = _U32(x ^ _U32(x * 0x05526C56))
    return _U32(x ^ _U32(x * 0x53A22864))


@kernel
def _second(index):
    """Bit-reversed second Sobol dimension: the index times Pascal's triangle modulo 2.

    That matrix is a Kronecker power of ((1, 1), (0, 1)), so one step for each bit of a bit's position multiplies by it.
    """
    index = _U32(index ^ ((index >> 1) & 0x55555555))
    index = _U32(index ^ ((index >> 2) & 0x33333333))
    index = _U32(index ^ ((index >> 4) & 0x0F0F0F0F))
    index = _U32(index ^ ((index >> 8) & 0x00FF00FF))
    return _U32(index ^ (index >> 16))


@kernel
def _lookup(table, index):
    # Unsigned indices: Numba would test signed ones for being negative.
    return _U32(
        table[_U32(index & 255)]
        ^ table[_U32(((index >> 8) & 255) | 256)]
        ^ table[_U32(((index >> 16) & 255) | 512)]
        ^ table[_U32((index >> 24) | 768)]
    )


@kernel
def _unit(reversed_digits, seed):
    return unit_float(reverse_32(_scramble(reversed_digits, seed)))


@kernel
def _units(first, first_seed, second, second_seed):
    """Two of ``_unit``: reversing a 64-bit word costs as much as one of 32 bits."""
    word = (_U64(_scramble(second, second_seed)) << _SHIFT_32) | _U64(_scramble(first, first_seed))
    word = reverse_64(word)
    return unit_float(_U32(word >> _SHIFT_32)), unit_float(_U32(word))


@kernel
def _set_word(seed, dimension):
    """Random word of a set. Its halves seed the shuffle and the first dimension; words mixed from it seed the
    others."""
    return _mix((_U64(seed) << _SHIFT_32) ^ _U64(dimension + 1) * _GOLDEN)


@kernel
def _shuffle(index, word):
    return reverse_32(_scramble(reverse_32(_U32(index)), _U32(word)))


@kernel
def pixel_seed(x, y, seed):
    """uint32 that makes the patterns of pixels, and of renders with different ``seed``, independent."""
    word = _mix((_U64(_U32(y)) << _SHIFT_32) | _U64(_U32(x)))
    return _U32(_mix(word + _U64(seed) * _GOLDEN) >> _SHIFT_32)


@kernel
def get_1d(index, seed, dimension):
    """Uniform number in [0, 1): sample ``index`` (below 2^32) of set ``dimension``; ``seed`` is from ``pixel_seed``."""
    word = _set_word(seed, dimension)
    return _unit(_shuffle(index, word), _U32(word >> _SHIFT_32))


@kernel
def get_2d(index, seed, dimension):
    """A point of the unit square: a (0, 2)-sequence over ``index``. Arguments as in ``get_1d``."""
    word = _set_word(seed, dimension)
    more = _mix(word + _GOLDEN)
    point = _shuffle(index, word)
    return _units(point, _U32(word >> _SHIFT_32), _second(point), _U32(more))


@kernel
def get_3d(index, seed, dimension):
    """A point of the unit cube; its first two coordinates are a (0, 2)-sequence. Arguments as in ``get_1d``."""
    word = _set_word(seed, dimension)
    more = _mix(word + _GOLDEN)
    point = _shuffle(index, word)
    u, v = _units(point, _U32(word >> _SHIFT_32), _second(point), _U32(more))
    return u, v, _unit(_lookup(_THIRD, point), _U32(more >> _SHIFT_32))


@kernel
def get_4d(index, seed, dimension):
    """A point of the four-dimensional unit cube, as in ``get_3d``."""
    word = _set_word(seed, dimension)
    more = _mix(word + _GOLDEN)
    point = _shuffle(index, word)
    u, v = _units(point, _U32(word >> _SHIFT_32), _second(point), _U32(more))
    w, x = _units(_lookup(_THIRD, point), _U32(more >> _SHIFT_32), _lookup(_FOURTH, point), _U32(_mix(more + _GOLDEN)))
    return u, v, w, x
