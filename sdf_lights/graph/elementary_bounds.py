# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single operations on intervals, each written once, without outward rounding.

Here they work on arrays of boxes: ``interval_arithmetic`` adds rounding and undefined values. ``interval_kernels``
compiles the same functions for numbers. There the names below mean functions of numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

TURN = 2.0 * math.pi

least: Callable = np.minimum
greatest: Callable = np.maximum
least_number: Callable = np.fmin  # NaN does not count
greatest_number: Callable = np.fmax
where: Callable = np.where
times: Callable = np.multiply  # NaN stays, and ``interval_arithmetic`` sees that a value may be undefined
ratio: Callable = np.divide


def hypotenuse(a, square):
    """√(a² + square), which neither overflows nor underflows."""
    return np.hypot(a, np.sqrt(square))


def abs_bounds(low, high):
    """Bounds of |a|."""
    return greatest(greatest(low, -high), 0.0), greatest(-low, high)


def square_bounds(low, high):
    """Bounds of a²."""
    low, high = abs_bounds(low, high)
    return low * low, high * high


def product_bounds(a_low, a_high, b_low, b_high):
    """Bounds of a · b."""
    p, q, r, s = times(a_low, b_low), times(a_low, b_high), times(a_high, b_low), times(a_high, b_high)
    return least(least(p, q), least(r, s)), greatest(greatest(p, q), greatest(r, s))


def quotient_bounds(a_low, a_high, b_low, b_high):
    """Bounds of a / b, for b without 0."""
    p, q, r, s = ratio(a_low, b_low), ratio(a_low, b_high), ratio(a_high, b_low), ratio(a_high, b_high)
    return least_number(least_number(p, q), least_number(r, s)), greatest_number(
        greatest_number(p, q), greatest_number(r, s)
    )


def passes(low, high, first, period, doubt):
    """Whether the interval of angles contains one of the angles first + i · period, which are in turns. ``doubt``: how
    many turns beside it count too."""
    u, v = (low / TURN - first) / period, (high / TURN - first) / period
    return np.ceil(u - doubt / period) <= np.floor(v + doubt / period)


def wave_bounds(u, v, low, high, crest, doubt):
    """Bounds of a sine or cosine with the values ``u`` and ``v`` at the ends of an interval of angles. ``crest``: the
    turn at which it is 1."""
    lowest = where(passes(low, high, crest + 0.5, 1.0, doubt), -1.0, least(u, v))
    return lowest, where(passes(low, high, crest, 1.0, doubt), 1.0, greatest(u, v))


def unit_bounds(low, high, rest_low, rest_high):
    """Bounds of u/√(u² + r) for u and r ≥ 0 within bounds: it grows with u, and moves towards 0 as r grows.

    At the origin, where it is undefined, any number with the signs of u is possible."""
    a = low / hypotenuse(low, where(low < 0.0, rest_low, rest_high))
    b = high / hypotenuse(high, where(high > 0.0, rest_low, rest_high))
    # Squares may underflow to 0. NaN fails both tests.
    a = where(a >= -1.0, least(a, 1.0), where((low == 0.0) & (high > 0.0), 0.0, -1.0))
    return a, where(b <= 1.0, greatest(b, -1.0), where((low < 0.0) & (high == 0.0), 0.0, 1.0))


def angle_bounds(y_low, y_high, x_low, x_high, cut):
    """Bounds of the angle of (x, y); all angles if the box may cross the negative x axis (``cut``)."""
    p, q = np.arctan2(y_low, x_low), np.arctan2(y_low, x_high)
    r, s = np.arctan2(y_high, x_low), np.arctan2(y_high, x_high)
    return where(cut, -np.pi, least(least(p, q), least(r, s))), where(
        cut, np.pi, greatest(greatest(p, q), greatest(r, s))
    )


def power_bounds(low, high, exponent):
    """Bounds of a power with a known exponent; if that is not whole, of the part of the interval above 0."""
    even = exponent % 2.0 == 0.0
    near, most = abs_bounds(low, high)
    a, b = where(even, near, low), where(even, most, high)
    pole = (exponent < 0.0) & (a <= 0.0) & (b >= 0.0)
    u, v = a**exponent, b**exponent
    return where(pole, where(even, v, -np.inf), least(u, v)), where(pole, np.inf, greatest(u, v))
