# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single operations on intervals, each written once, without outward rounding.

Numba compiles them for numbers, in the interpreter of ``interval_interpreter``. ``on_arrays`` has the same functions
for NumPy, over arrays of boxes: ``interval_arithmetic`` adds rounding and undefined values.
"""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from ..jit import kernel

ROUNDING = 1e-9  # relative; covers some thousand operations
TURN = 2.0 * math.pi

on_arrays: Any = SimpleNamespace()

# What the functions call, for arrays.
_ARRAY_NAMES: dict[str, Any] = {
    "np": np,
    "TURN": TURN,
    "min": np.minimum,
    "max": np.maximum,
    "where": np.where,
    "times": np.multiply,  # NaN stays, and ``interval_arithmetic`` sees that a value may be undefined
    "ratio": np.divide,
    "hypotenuse": lambda a, square: np.hypot(a, np.sqrt(square)),  # neither overflows nor underflows
}


def over_arrays(function: Callable, **names: Any) -> Callable:
    """The function for arrays, with other meanings for some ``names``."""
    python = inspect.unwrap(function)
    return functools.wraps(python)(FunctionType(python.__code__, _ARRAY_NAMES | names))


def _for_both(function: Callable, **names: Any) -> Callable:
    array_form = over_arrays(function, **names)
    _ARRAY_NAMES[function.__name__] = array_form
    setattr(on_arrays, function.__name__, array_form)
    return kernel(function, forceinline=True)


@kernel(forceinline=True)
def where(condition, a, b):
    """``a`` if the condition holds, else ``b``."""
    return a if condition else b


@kernel(forceinline=True)
def times(a, b):
    """Product of bounds, where 0 · ∞ is 0: a multiple of something bounded by 0 is 0."""
    product = a * b
    return product if product == product else 0.0


@kernel(forceinline=True)
def ratio(a, b):
    """Quotient of bounds, where ∞ / ∞ is 0: beside that corner there are others with 0 and ∞."""
    quotient = a / b
    return quotient if quotient == quotient else 0.0


@kernel(forceinline=True)
def hypotenuse(a, square):
    """√(a² + square)."""
    return math.sqrt(a * a + square)


@_for_both
def abs_bounds(low, high):
    """Bounds of |a|."""
    return max(max(low, -high), 0.0), max(-low, high)


@_for_both
def square_bounds(low, high):
    """Bounds of a²."""
    low, high = abs_bounds(low, high)
    return low * low, high * high


@_for_both
def product_bounds(a_low, a_high, b_low, b_high):
    """Bounds of a · b."""
    p, q, r, s = times(a_low, b_low), times(a_low, b_high), times(a_high, b_low), times(a_high, b_high)
    return min(min(p, q), min(r, s)), max(max(p, q), max(r, s))


@functools.partial(_for_both, min=np.fmin, max=np.fmax)
def quotient_bounds(a_low, a_high, b_low, b_high):
    """Bounds of a / b, for b without 0."""
    p, q, r, s = ratio(a_low, b_low), ratio(a_low, b_high), ratio(a_high, b_low), ratio(a_high, b_high)
    return min(min(p, q), min(r, s)), max(max(p, q), max(r, s))


@_for_both
def passes(low, high, first, period, doubt):
    """Whether the interval of angles contains one of the angles first + i · period, which are in turns. ``doubt``: how
    many turns beside it count too."""
    u, v = (low / TURN - first) / period, (high / TURN - first) / period
    return np.ceil(u - doubt / period) <= np.floor(v + doubt / period)


@_for_both
def wave_bounds(u, v, low, high, crest, doubt):
    """Bounds of a sine or cosine with the values ``u`` and ``v`` at the ends of an interval of angles. ``crest``: the
    turn at which it is 1."""
    least = where(passes(low, high, crest + 0.5, 1.0, doubt), -1.0, min(u, v))
    return least, where(passes(low, high, crest, 1.0, doubt), 1.0, max(u, v))


@_for_both
def unit_bounds(low, high, rest_low, rest_high):
    """Bounds of u/√(u² + r) for u and r ≥ 0 within bounds: it grows with u, and moves towards 0 as r grows.

    At the origin, where it is undefined, any number with the signs of u is possible."""
    a = low / hypotenuse(low, where(low < 0.0, rest_low, rest_high))
    b = high / hypotenuse(high, where(high > 0.0, rest_low, rest_high))
    # Squares may underflow to 0. NaN fails both tests.
    a = where(a >= -1.0, min(a, 1.0), where((low == 0.0) & (high > 0.0), 0.0, -1.0))
    return a, where(b <= 1.0, max(b, -1.0), where((low < 0.0) & (high == 0.0), 0.0, 1.0))


@_for_both
def angle_bounds(y_low, y_high, x_low, x_high, cut):
    """Bounds of the angle of (x, y); all angles if the box may cross the negative x axis (``cut``)."""
    p, q = np.arctan2(y_low, x_low), np.arctan2(y_low, x_high)
    r, s = np.arctan2(y_high, x_low), np.arctan2(y_high, x_high)
    return where(cut, -np.pi, min(min(p, q), min(r, s))), where(cut, np.pi, max(max(p, q), max(r, s)))


@_for_both
def power_bounds(low, high, exponent):
    """Bounds of a power with a known exponent; if that is not whole, of the part of the interval above 0."""
    even = exponent % 2.0 == 0.0
    least, most = abs_bounds(low, high)
    a, b = where(even, least, low), where(even, most, high)
    pole = (exponent < 0.0) & (a <= 0.0) & (b >= 0.0)
    u, v = a**exponent, b**exponent
    return where(pole, where(even, v, -np.inf), min(u, v)), where(pole, np.inf, max(u, v))


@kernel(forceinline=True)
def margin_of_rounding(low, high):
    """How far to move both bounds outwards, for the rounding of all operations before; 0 if they are infinite."""
    return ROUNDING * max(abs(low), abs(high)) if abs(low) + abs(high) < math.inf else 0.0
