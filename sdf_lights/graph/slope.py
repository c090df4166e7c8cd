# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A value over boxes with its gradient, and the rules for sums, multiples, choices and lengths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import elementary_bounds
from .formula import Formula
from .interval_arithmetic import DOUBLE, Arithmetic, Condition, Interval

MARGIN = 1.0 + 64.0 * DOUBLE.basic  # covers the rounding of the few operations of a norm
TINY = DOUBLE.tiny  # covers underflow

ARITHMETIC = Arithmetic()


class Discontinuity(NamedTuple):
    """Where a value may jump: in all of the ``boxes``, with the known facts about both sides."""

    boxes: np.ndarray | None = None  # (n,) which boxes; None for none
    source: Formula | None = None  # the one node that causes these jumps, if there is one
    limits: tuple[float, float] | None = None  # the values on both sides, the same at all of them
    even: bool = False  # it only changes its sign: the absolute value does not jump
    zero: Formula | None = None  # a node at whose jumps the value is 0, whether it is discontinuous or not


CONTINUOUS = Discontinuity()


class Slope(NamedTuple):
    """A value over boxes, and its gradient with respect to the position."""

    value: Interval
    gradient: Interval | None  # components (3, n); None if the value does not depend on the position
    norm: np.ndarray | float  # bound of the length of the gradient, often less than that of the components together
    parts: "tuple[Slope, ...] | None" = None  # the value is the sum of their squares; needed for a square root
    discontinuity: Discontinuity = CONTINUOUS

    @property
    def is_number(self) -> bool:
        """The same in all boxes."""
        return self.gradient is None and self.discontinuity.boxes is None and self.value.is_number


def length_bound(gradient: Interval) -> np.ndarray:
    """Bound on the length of a vector of intervals."""
    x, y, z = gradient.magnitude
    return np.sqrt(x * x + y * y + z * z + TINY) * MARGIN


def scaled(slope: Slope, factor: Interval) -> tuple[Interval | None, np.ndarray | float]:
    """Gradient and norm, times a factor."""
    if slope.gradient is None:
        return None, 0.0
    return without_domain(ARITHMETIC.multiply(slope.gradient, factor)), product_bound(slope.norm, factor.magnitude)


def product_bound(norm, factor):
    """Product of two bounds, where 0 · ∞ is 0: a multiple of something bounded by 0 is 0."""
    product = norm * factor * MARGIN + TINY
    return np.where(np.isnan(product), 0.0, product)


def without_domain(gradient: Interval) -> Interval:
    """Undefined gradients are ignored: bounds are about the points where the value is defined."""
    return Interval(gradient.low, gradient.high)


def slope_sum(*terms: tuple[Interval | None, np.ndarray | float]) -> tuple[Interval | None, np.ndarray | float]:
    """Gradient and norm of a sum."""
    terms = [term for term in terms if term[0] is not None]
    if not terms:
        return None, 0.0
    gradient, norm = terms[0]
    for other, more in terms[1:]:
        gradient, norm = without_domain(ARITHMETIC.add(gradient, other)), (norm + more) * MARGIN
    if len(terms) > 1:
        norm = np.minimum(norm, length_bound(gradient))
    return gradient, norm


NO_GRADIENT = Interval(np.zeros((3, 1)), np.zeros((3, 1)))


def select_slope(condition: Condition, a: Slope, b: Slope, value: Interval | None = None) -> Slope:
    """The slope of a choice: of ``a`` where the condition holds. ``value``: its value, if it is known."""
    value = ARITHMETIC.select(condition, a.value, b.value) if value is None else value
    if a.gradient is None and b.gradient is None:
        return Slope(value, None, 0.0)
    u, v = (NO_GRADIENT if slope.gradient is None else slope.gradient for slope in (a, b))
    certain, possible = condition
    norm = np.where(certain, a.norm, np.where(possible, np.maximum(a.norm, b.norm), b.norm))
    return Slope(value, without_domain(ARITHMETIC.select(condition, u, v)), norm)


def unit_bounds(parts: list[Slope]) -> tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray]:
    """For a vector of values: bounds of the components of its unit vector, and of its least length."""
    squares = [ARITHMETIC.square(part.value) for part in parts]
    units = []
    for i, (part, square) in enumerate(zip(parts, squares)):
        rest = [other for j, other in enumerate(squares) if j != i]
        least, most = (sum(other[end] for other in rest) for end in (0, 1))
        low, high = (end * MARGIN for end in elementary_bounds.unit_bounds(*part.value[:2], least, most))
        low = np.where(low > 0.0, low / MARGIN**2, low)
        high = np.where(high < 0.0, high / MARGIN**2, high)
        low, high = np.maximum(low, -1.0), np.minimum(high, 1.0)
        units.append((low, high))
    return units, np.sqrt(sum(square.low for square in squares)) / MARGIN


def steepest_bound(parts: list[Slope], units: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray | float:
    """Bound (boxes,) of |Jᵀu| for unit vectors u within ``units`` and the matrix J of the gradients of ``parts``.

    |Jᵀu|² = uᵀGu with G = JJᵀ, which is at most the greatest sum of |G| along a row, and at most Σ |u_i| |G_ij| |u_j|.
    """
    moving = [(part, np.maximum(-low, high)) for part, (low, high) in zip(parts, units) if part.gradient is not None]
    if len(moving) > 4:  # too many pairs: the Frobenius norm
        return np.sqrt(sum(product_bound(part.norm, part.norm) for part, _ in moving)) * MARGIN
    rows, total = [], 0.0
    for i, (a, u) in enumerate(moving):
        row = 0.0
        for j, (b, v) in enumerate(moving):
            if i == j:
                entry = product_bound(a.norm, a.norm)
            else:
                dot = ARITHMETIC.multiply(a.gradient, b.gradient)
                x, y, z = (Interval(dot.low[k], dot.high[k]) for k in range(3))
                entry = np.minimum(product_bound(a.norm, b.norm), ARITHMETIC.add(ARITHMETIC.add(x, y), z).magnitude)
            row = row + entry
            total = total + product_bound(product_bound(u, v), entry)
        rows.append(row)
    greatest = rows[0]
    for row in rows[1:]:
        greatest = np.maximum(greatest, row)
    return np.sqrt(np.minimum(greatest, total)) * MARGIN


def length_of(value: Interval, parts: list[Slope]) -> Slope:
    """√(Σ part²), which is ``value``: its gradient is Jᵀ times the unit vector along the parts."""
    units, _ = unit_bounds(parts)
    gradient, norm = slope_sum(*(scaled(part, Interval(*unit)) for part, unit in zip(parts, units)))
    if gradient is None:
        return Slope(value, None, 0.0)
    return Slope(value, gradient, np.minimum(norm, steepest_bound(parts, units)))


def magnitude_of(slope: Slope) -> Slope:
    """|slope|."""
    a = slope.value
    if slope.gradient is None:
        return Slope(ARITHMETIC.abs(a), None, 0.0)
    sign = Interval(np.where(a.low >= 0.0, 1.0, -1.0), np.where(a.high <= 0.0, -1.0, 1.0))
    if a.undefined is not None:
        sign = Interval(np.where(a.undefined, -1.0, sign.low), np.where(a.undefined, 1.0, sign.high))
    return Slope(ARITHMETIC.abs(a), without_domain(ARITHMETIC.multiply(slope.gradient, sign)), slope.norm)
