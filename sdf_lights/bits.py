# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bits of integers in kernels: reversed, and as uniform numbers. A GPU has instructions for these."""

import numpy as np

from .jit import kernel
from .replaced import replaced_on_gpu

_U32, _U64 = np.uint32, np.uint64
_SHIFT_32 = _U64(32)
_SWAPS = tuple((_U64(shift), _U64((2**64 - 1) // (2**shift + 1))) for shift in (1, 2, 4, 8, 16, 32))
_TO_UNIT = 2.0**-32


@kernel
def _swap(x, mask, shift):
    """Exchange neighbouring groups of ``shift`` bits. ``mask`` selects every second group, from the lowest."""
    return ((x >> shift) & mask) | ((x & mask) << shift)


@replaced_on_gpu
@kernel
def reverse_64(x):
    """The bits of a uint64 in reverse order."""
    for shift, mask in _SWAPS:
        x = _swap(x, mask, shift)
    return x


@replaced_on_gpu
@kernel
def reverse_32(x):
    """The bits of a uint32 in reverse order."""
    return _U32(reverse_64(_U64(x)) >> _SHIFT_32)


@replaced_on_gpu
@kernel
def unit_float(x):
    """A uint32 as a number in [0, 1): its bits are the digits after the binary point, as many as a float has."""
    return x * _TO_UNIT
