# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions of ``elementary_bounds`` as kernels of numbers, for ``interval_interpreter``."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType

from ..jit import kernel
from . import elementary_bounds

ROUNDING = 1e-9  # relative; covers some thousand operations


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


_MEANING = {
    **vars(elementary_bounds),
    "least": min,
    "greatest": max,
    "least_number": min,
    "greatest_number": max,
    "where": where,
    "times": times,
    "ratio": ratio,
    "hypotenuse": hypotenuse,
}


def _of_numbers(function: Callable) -> Callable:
    """The function as a kernel, which calls the kernels made before."""
    name = function.__name__
    copy = FunctionType(function.__code__, _MEANING, name)
    copy.__module__, copy.__doc__ = function.__module__, function.__doc__
    _MEANING[name] = made = kernel(copy, forceinline=True)
    return made


abs_bounds = _of_numbers(elementary_bounds.abs_bounds)
square_bounds = _of_numbers(elementary_bounds.square_bounds)
product_bounds = _of_numbers(elementary_bounds.product_bounds)
quotient_bounds = _of_numbers(elementary_bounds.quotient_bounds)
passes = _of_numbers(elementary_bounds.passes)
wave_bounds = _of_numbers(elementary_bounds.wave_bounds)
unit_bounds = _of_numbers(elementary_bounds.unit_bounds)
angle_bounds = _of_numbers(elementary_bounds.angle_bounds)
power_bounds = _of_numbers(elementary_bounds.power_bounds)


@kernel(forceinline=True)
def margin_of_rounding(low, high):
    """How far to move both bounds outwards, for the rounding of all operations before; 0 if they are infinite."""
    return ROUNDING * max(abs(low), abs(high)) if abs(low) + abs(high) < math.inf else 0.0
