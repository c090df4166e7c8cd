# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single operations on intervals, as kernels, without rounding outwards."""

from __future__ import annotations

import math

from ...jit import kernel

ROUNDING = 1e-9  # relative; covers some thousand operations
HALF_TURN, TURN = math.pi, 2.0 * math.pi


@kernel(forceinline=True)
def times(a, b):
    """Product of bounds, where 0 · ∞ is 0: a multiple of something bounded by 0 is 0."""
    product = a * b
    return product if product == product else 0.0


@kernel(forceinline=True)
def product_bounds(a_low, a_high, b_low, b_high):
    """Bounds (low, high) of the product of two intervals, without rounding outwards."""
    p, q, r, s = times(a_low, b_low), times(a_low, b_high), times(a_high, b_low), times(a_high, b_high)
    return min(min(p, q), min(r, s)), max(max(p, q), max(r, s))


@kernel(forceinline=True)
def quotient_bounds(a_low, a_high, b_low, b_high):
    """Bounds (low, high) of a quotient; infinite if the divisor may be 0."""
    if b_low <= 0.0 <= b_high:
        return -math.inf, math.inf
    return product_bounds(a_low, a_high, 1.0 / b_high, 1.0 / b_low)


@kernel(forceinline=True)
def square_bounds(low, high):
    """Bounds of a square."""
    least = 0.0 if low <= 0.0 <= high else min(low * low, high * high)
    return least, max(low * low, high * high)


@kernel(forceinline=True)
def unit_bounds(low, high, rest_low, rest_high):
    """Bounds of u/√(u² + r) for u and r ≥ 0 within bounds: it grows with u, and moves towards 0 as r grows."""
    a = low / math.sqrt(low * low + (rest_low if low < 0.0 else rest_high))
    b = high / math.sqrt(high * high + (rest_low if high > 0.0 else rest_high))
    # At the origin, any unit vector is possible: NaN fails both tests.
    return (a if a >= -1.0 else -1.0), (b if b <= 1.0 else 1.0)


@kernel(forceinline=True)
def passes(low, high, first, period):
    """Whether one of the numbers first + i · period is between the bounds."""
    return math.ceil((low - first) / period - ROUNDING) <= math.floor((high - first) / period + ROUNDING)


@kernel
def wave_bounds(low, high, crest):
    """Bounds of the function with period 2π that is 1 at ``crest`` and falls like a cosine on both sides."""
    if not high - low < TURN:
        return -1.0, 1.0
    a, b = math.cos(low - crest), math.cos(high - crest)
    least = -1.0 if passes(low, high, crest + HALF_TURN, TURN) else min(a, b)
    return least, (1.0 if passes(low, high, crest, TURN) else max(a, b))


@kernel
def power_bounds(low, high, exponent):
    """Bounds of a power of a base without sign change, unless the exponent is whole and not negative."""
    whole = exponent == math.floor(exponent)
    if low < 0.0 and not whole or low <= 0.0 <= high and exponent < 0.0:
        return -math.inf, math.inf
    a, b = low**exponent, high**exponent
    if low < 0.0 < high and exponent % 2.0 == 0.0:
        return 0.0, max(a, b)
    return min(a, b), max(a, b)
