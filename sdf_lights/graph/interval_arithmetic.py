# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operations on intervals, vectorised. ``interval_evaluation`` uses them to bound values of formulas over boxes.

Every result is rounded outwards, so it holds for exact arithmetic and for every evaluator whose operations are as good
as the ``Precision`` says. Interval arithmetic follows Moore, Kearfott and Cloud, "Introduction to Interval Analysis",
with three-valued conditions. Where a value may be undefined (NaN, or a division by zero), the bounds are those of the
points where it is defined, and every comparison with it is undecided.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from . import elementary_bounds


class Precision(NamedTuple):
    """Largest deviation of floating-point operations from exact results: relative errors, unless stated otherwise."""

    number: type
    basic: float  # +, −, ·, /, √
    library: float  # other functions
    sine: float = 0.0  # absolute error of sine and cosine, for operands up to 1; for others times the operand
    logarithm: float = 0.0  # absolute error of the logarithm, including that inside a power
    exponent: float = 0.0  # of an exponential function or a power, times the logarithm of the result
    tiny: float = 0.0  # absolute error of any result, from underflow; see ``sums_underflow``

    @property
    def greatest(self) -> float:
        """The greatest finite number."""
        return float(np.finfo(self.number).max)

    @property
    def sums_underflow(self) -> bool:
        """In double precision, sums that are too small for a normal number are exact."""
        return self.number is not np.float64

    def holds(self, value: float) -> bool:
        """Whether the number needs no rounding."""
        return float(self.number(value)) == value


_ULP = 2.0**-52

# Basic operations are rounded correctly. Functions of NumPy and of C libraries are within 4 ulps, and two of them may
# deviate in different directions.
DOUBLE = Precision(np.float64, basic=_ULP, library=8.0 * _ULP, tiny=2.0**-1022)


class Interval(NamedTuple):
    """Bounds of a value: arrays that broadcast to the boxes. ``low`` is never +∞, ``high`` never −∞, neither is NaN."""

    low: np.ndarray
    high: np.ndarray
    undefined: np.ndarray | None = None  # where the value may be NaN; None for nowhere
    positive: bool = False  # every value is +0 or greater, by the form of the formula
    whole: bool = False  # every value is an integer, likewise

    @property
    def magnitude(self) -> np.ndarray:
        """Greatest absolute value."""
        return np.maximum(-self.low, self.high)

    @property
    def is_number(self) -> bool:
        """One value, the same in all boxes."""
        return np.ndim(self.low) == 0 and self.low == self.high


class Line(NamedTuple):
    """scale · a + shift; ``size`` is the greatest term that was added up to the shift."""

    scale: Interval
    shift: Interval
    size: float


class Condition(NamedTuple):
    """A comparison: whether it holds everywhere in a box, and whether it may hold anywhere in it."""

    certain: np.ndarray
    possible: np.ndarray


def _either(a: np.ndarray | None, b: np.ndarray | None) -> np.ndarray | None:
    return b if a is None else a if b is None else a | b


def _where_any(mask: np.ndarray) -> np.ndarray | None:
    return mask if mask.any() else None


def _holds_zero(a: Interval) -> np.ndarray:
    return (a.low <= 0.0) & (a.high >= 0.0)


def hull(a: Interval, b: Interval) -> Interval:
    """The smallest interval that contains both, for each box."""
    return Interval(
        np.minimum(a.low, b.low),
        np.maximum(a.high, b.high),
        _either(a.undefined, b.undefined),
        a.positive and b.positive,
    )


class Arithmetic:
    """Operations on intervals. Those of formulas have the names in ``operations.OPERATIONS``."""

    def __init__(self, precision: Precision = DOUBLE):
        self.precision = precision

    # -- rounding -------------------------------------------------------------------------------------------------

    def number(self, value: float) -> Interval:
        """A constant or parameter."""
        value = np.float64(value)
        if math.isnan(value):
            return Interval(np.float64(-np.inf), np.float64(np.inf), np.True_)
        positive = not np.signbit(value)
        if self.precision.holds(value) and math.isfinite(value):
            return Interval(value, value, None, positive, bool(value == np.floor(value)))
        return self._rounded(value, value, self.precision.basic, None, positive)

    def _rounded(
        self, low, high, relative: float, undefined=None, positive: bool = False, is_sum: bool = False
    ) -> Interval:
        """Bounds moved outward. ``low`` and ``high`` are nearest results of the bounds in double precision."""
        tiny = self.precision.tiny if self.precision.sums_underflow or not is_sum else 0.0
        greatest = self.precision.greatest
        ordinary = high.max(initial=-np.inf) <= greatest and low.min(initial=np.inf) >= -greatest
        low = low - (np.abs(low) * relative + tiny)
        high = high + (np.abs(high) * relative + tiny)
        if not ordinary:
            # fmin also turns the NaN of ∞ − ∞ above into a number.
            low, high = np.fmin(low, greatest), np.fmax(high, -greatest)
            low, high = np.where(low < -greatest, -np.inf, low), np.where(high > greatest, np.inf, high)
            undefined = _either(undefined, _where_any((low == -np.inf) & (high == np.inf)))
        if positive:
            low = np.maximum(low, 0.0)
        return Interval(low, high, undefined, positive)

    def _exact(self, operation: Callable, a: Interval, b: Interval) -> Interval | None:
        """The result of numbers, if it needs no rounding: exponents, for instance, must stay integers."""
        if not (a.is_number and b.is_number):
            return None
        value = operation(float(a.low), float(b.low))
        if not math.isfinite(value) or operation(Fraction(float(a.low)), Fraction(float(b.low))) != value:
            return None
        return self.number(value) if self.precision.holds(value) else None

    def _whole(self, low, high, a: Interval, b: Interval, positive: bool) -> Interval | None:
        """The result of integers, if it is small enough to be exact: hashes rely on that."""
        most = 2.0 / np.finfo(self.precision.number).eps
        if not (a.whole and b.whole and high.max(initial=-np.inf) <= most and low.min(initial=np.inf) >= -most):
            return None
        return Interval(low, high, _either(a.undefined, b.undefined), positive, True)

    # -- operations without rounding ------------------------------------------------------------------------------

    def negate(self, a: Interval) -> Interval:
        """Bounds of −a, without rounding."""
        return Interval(-a.high, -a.low, a.undefined, False, a.whole)

    def abs(self, a: Interval) -> Interval:
        """Bounds of |a|, without rounding."""
        if a.positive:
            return a
        return Interval(*elementary_bounds.abs_bounds(a.low, a.high), a.undefined, True, a.whole)

    def floor(self, a: Interval) -> Interval:
        """Bounds of ⌊a⌋, without rounding; whole numbers."""
        return Interval(np.floor(a.low), np.floor(a.high), a.undefined, a.positive, True)

    def minimum(self, a: Interval, b: Interval) -> Interval:
        """Bounds of min(a, b), without rounding."""
        return self._extreme(np.minimum, a, b)

    def maximum(self, a: Interval, b: Interval) -> Interval:
        """Bounds of max(a, b), without rounding."""
        return self._extreme(np.maximum, a, b)

    def _extreme(self, function, a: Interval, b: Interval) -> Interval:
        low, high = function(a.low, b.low), function(a.high, b.high)
        undefined = _either(a.undefined, b.undefined)
        # evaluators differ: the least of NaN and a number is NaN for some, the number for others
        if undefined is not None:
            either = hull(a, b)
            low, high = np.where(undefined, either.low, low), np.where(undefined, either.high, high)
        return Interval(low, high, undefined, a.positive and b.positive)

    def less(self, a: Interval, b: Interval) -> Condition:
        """Where a < b holds certainly, and where it is possible."""
        return self._compared(np.less, a, b)

    def less_equal(self, a: Interval, b: Interval) -> Condition:
        """Where a ≤ b holds certainly, and where it is possible."""
        return self._compared(np.less_equal, a, b)

    def _compared(self, function, a: Interval, b: Interval) -> Condition:
        certain, possible = function(a.high, b.low), function(a.low, b.high)
        undefined = _either(a.undefined, b.undefined)
        return (
            Condition(certain, possible) if undefined is None else Condition(certain & ~undefined, possible | undefined)
        )

    def select(self, condition: Condition, then: Interval, otherwise: Interval) -> Interval:
        """Bounds of ``then`` if the condition is certain, of ``otherwise`` if it is impossible, else of both."""
        certain, possible = condition
        if certain.all():
            return then
        if not possible.any():
            return otherwise
        either = hull(then, otherwise)
        low = np.where(certain, then.low, np.where(possible, either.low, otherwise.low))
        high = np.where(certain, then.high, np.where(possible, either.high, otherwise.high))
        undefined = either.undefined
        if undefined is not None:
            undefined = False
            if then.undefined is not None:
                undefined = possible & then.undefined
            if otherwise.undefined is not None:
                undefined = undefined | (~certain & otherwise.undefined)
            undefined = _where_any(undefined)
        return Interval(low, high, undefined, either.positive)

    # -- basic operations -----------------------------------------------------------------------------------------

    def add(self, a: Interval, b: Interval) -> Interval:
        """Bounds of a + b, rounded outwards."""
        low, high = a.low + b.low, a.high + b.high
        positive = a.positive and b.positive
        exact = self._exact(lambda u, v: u + v, a, b) or self._whole(low, high, a, b, positive)
        return exact or self._rounded(
            low, high, self.precision.basic, _either(a.undefined, b.undefined), positive, is_sum=True
        )

    def subtract(self, a: Interval, b: Interval) -> Interval:
        """Bounds of a − b, rounded outwards, for independent a and b."""
        low, high = a.low - b.high, a.high - b.low
        exact = self._exact(lambda u, v: u - v, a, b) or self._whole(low, high, a, b, False)
        return exact or self._rounded(low, high, self.precision.basic, _either(a.undefined, b.undefined), is_sum=True)

    def multiply(self, a: Interval, b: Interval) -> Interval:
        """Bounds of a · b, rounded outwards. If both are the same object, of a²."""
        if a is b:
            return self.square(a)
        exact = self._exact(lambda u, v: u * v, a, b)
        if exact:
            return exact
        undefined = _either(a.undefined, b.undefined)
        positive = a.positive and b.positive
        if a.is_number:
            a, b = b, a
        if b.is_number:
            low, high = (a.low, a.high) if b.low >= 0.0 else (a.high, a.low)
            low, high = low * b.low, high * b.low
        elif positive:
            low, high = a.low * b.low, a.high * b.high
        else:
            low, high = elementary_bounds.product_bounds(a.low, a.high, b.low, b.high)
        whole = self._whole(low, high, a, b, positive)
        if whole:
            return whole
        if not math.isfinite((high - low).sum()):
            # 0 · ∞: as a bound of products of finite numbers it is 0; as a product of values it would be undefined.
            undefined = _either(undefined, _where_any(np.isnan(low) | np.isnan(high)))
            low, high = _product_with_infinity(a.low, a.high, b.low, b.high)
        return self._rounded(low, high, self.precision.basic, undefined, positive)

    def odd_power(self, a: Interval, squares: int) -> Interval:
        """a · a^(2^squares): it grows with a, which the product of two intervals does not show."""
        ends = []
        for end in a[:2]:
            a_end = power = Interval(end, end)
            for _ in range(squares):
                power = self.square(power)
            ends.append(self.multiply(a_end, power))
        return Interval(ends[0].low, ends[1].high, a.undefined, a.positive)

    def remainder(self, a: Interval, period: Interval, line: "Line") -> Interval:
        """a − period · floor(line of a): the floor is less than its operand by 0 to 1."""
        along = self.multiply(a, line.scale)
        error = 8.0 * self.precision.basic * (along.magnitude + line.size) + self.precision.tiny
        fraction = Interval(-error, 1.0 + error)
        rest = self.multiply(a, self.subtract(self.number(1.0), self.multiply(period, line.scale)))
        return self.add(rest, self.multiply(period, self.subtract(fraction, line.shift)))

    def square(self, a: Interval) -> Interval:
        """Bounds of a², rounded outwards: tighter than those of a · a."""
        low, high = elementary_bounds.square_bounds(a.low, a.high)
        exact = self._exact(lambda u, v: u * v, a, a) or self._whole(low, high, a, a, True)
        return exact or self._rounded(low, high, self.precision.basic, a.undefined, True)

    def divide(self, a: Interval, b: Interval) -> Interval:
        """Bounds of a / b, rounded outwards; infinite and possibly undefined if b may be 0."""
        exact = self._exact(lambda u, v: u / v, a, b) if b.is_number and b.low != 0.0 else None
        if exact:
            return exact
        undefined = _either(a.undefined, b.undefined)
        if b.is_number and b.low != 0.0:
            low, high = (a.low, a.high) if b.low > 0.0 else (a.high, a.low)
            low, high = low / b.low, high / b.low
        else:
            low, high = elementary_bounds.quotient_bounds(a.low, a.high, b.low, b.high)
            zero = _where_any(_holds_zero(b))
            if zero is not None:
                endless = zero & ~(b.positive & (low <= high))  # not if the divisor is +0 or greater, and not 0/0 alone
                low, high = np.where(endless, -np.inf, low), np.where(endless, np.inf, high)
            endless = ((a.low == -np.inf) | (a.high == np.inf)) & ((b.low == -np.inf) | (b.high == np.inf))
            undefined = _either(undefined, _either(zero, _where_any(endless)))
        return self._rounded(low, high, self.precision.basic, undefined, a.positive and b.positive)

    def sqrt(self, a: Interval) -> Interval:
        """Bounds of √a; undefined if a may be negative."""
        return self._partial(np.sqrt, a, 0.0, np.inf, self.precision.basic, True)

    # -- functions ------------------------------------------------------------------------------------------------

    def _partial(self, function, a: Interval, first: float, last: float, relative: float, positive: bool) -> Interval:
        """A monotone function (increasing, or decreasing if ``first`` > ``last``) on a bounded domain."""
        least, greatest = min(first, last), max(first, last)
        outside = (a.low < least) | (a.high > greatest)
        undefined = _either(a.undefined, _where_any(outside))
        ends = function(np.clip(a.low, least, greatest)), function(np.clip(a.high, least, greatest))
        low, high = ends if first < last else ends[::-1]
        if undefined is not None:
            nowhere = _where_any((a.high < least) | (a.low > greatest))
            if nowhere is not None:
                found = self._rounded(low, high, relative, undefined, positive)
                return Interval(np.where(nowhere, -np.inf, found.low), np.where(nowhere, np.inf, found.high), undefined)
        return self._rounded(low, high, relative, undefined, positive)

    def exp(self, a: Interval) -> Interval:
        """Bounds of exp(a)."""
        low, high = np.exp(a.low), np.exp(a.high)
        return self._rounded(low, high, self._exponential_error(low, high), a.undefined, True)

    def _exponential_error(self, low, high, exponent: float = 0.0):
        """A power with this exponent that is computed as exp(b log a), as is common in single precision."""
        precision = self.precision
        if not precision.exponent and not precision.logarithm:
            return precision.library
        ends = (np.abs(np.log(np.clip(np.abs(end), precision.tiny, precision.greatest))) for end in (low, high))
        return precision.library + precision.exponent * np.maximum(*ends) + precision.logarithm * exponent

    def log(self, a: Interval) -> Interval:
        """Bounds of log(a); undefined if a may be negative."""
        found = self._partial(np.log, a, 0.0, np.inf, self.precision.library, False)
        error = self.precision.logarithm
        return found._replace(low=found.low - error, high=found.high + error) if error else found

    def atan(self, a: Interval) -> Interval:
        """Bounds of arctan(a)."""
        return self._rounded(np.arctan(a.low), np.arctan(a.high), self.precision.library, a.undefined, a.positive)

    def asin(self, a: Interval) -> Interval:
        """Bounds of arcsin(a); undefined if a may leave [−1, 1]."""
        return self._partial(np.arcsin, a, -1.0, 1.0, self.precision.library, False)

    def acos(self, a: Interval) -> Interval:
        """Bounds of arccos(a); undefined if a may leave [−1, 1]."""
        return self._partial(np.arccos, a, 1.0, -1.0, self.precision.library, False)

    def sin(self, a: Interval) -> Interval:
        """Bounds of sin(a); −1 to 1 if ``a`` is longer than a turn."""
        return self._wave(np.sin, a, 0.25)

    def cos(self, a: Interval) -> Interval:
        """Bounds of cos(a); −1 to 1 if ``a`` is longer than a turn."""
        return self._wave(np.cos, a, 0.0)

    def _wave(self, function, a: Interval, crest: float) -> Interval:
        """Sine or cosine, by the number of turns at its first crest."""
        endless = ~(np.isfinite(a.low) & np.isfinite(a.high))
        u, v = function(np.where(endless, 0.0, a.low)), function(np.where(endless, 0.0, a.high))
        low, high = elementary_bounds.wave_bounds(u, v, a.low, a.high, crest, self._doubt(a))
        error = self.precision.sine * np.maximum(1.0, np.where(endless, 1.0, a.magnitude))
        found = self._rounded(
            low - error, high + error, self.precision.library, _either(a.undefined, _where_any(endless))
        )
        return found._replace(
            low=np.maximum(found.low, -1.0 - self.precision.library),
            high=np.minimum(found.high, 1.0 + self.precision.library),
        )

    def _doubt(self, a: Interval) -> np.ndarray:
        """Turns by which an angle may be wrong after rounding."""
        return 4.0 * _ULP * (1.0 + a.magnitude / math.tau)

    def tan(self, a: Interval) -> Interval:
        """Bounds of tan(a); infinite if ``a`` may contain a pole."""
        endless = ~(np.isfinite(a.low) & np.isfinite(a.high))
        pole = elementary_bounds.passes(a.low, a.high, 0.25, 0.5, self._doubt(a))
        low, high = np.tan(np.where(pole, 0.0, a.low)), np.tan(np.where(pole, 0.0, a.high))
        error = self.precision.sine * np.maximum(1.0, np.where(pole, 0.0, a.magnitude))
        error = error * (1.0 + np.maximum(low * low, high * high))
        return self._rounded(
            np.where(pole, -np.inf, low - error),
            np.where(pole, np.inf, high + error),
            self.precision.library,
            _either(a.undefined, _where_any(endless)),
        )

    def atan2(self, y: Interval, x: Interval) -> Interval:
        """Bounds of the angle of (x, y); all angles if the box may cross the negative x axis."""
        cut = np.False_
        if not x.positive:
            # Below the negative x axis the angle is −π, above it π. On the axis both are possible, because there are
            # two zeros.
            above = y.low >= 0.0 if y.positive else np.False_
            cut = (x.low <= 0.0) & _holds_zero(y) & ~above
        low, high = elementary_bounds.angle_bounds(*y[:2], *x[:2], cut)
        return self._rounded(low, high, self.precision.library, _either(x.undefined, y.undefined), y.positive)

    def power(self, a: Interval, b: Interval) -> Interval:
        """Bounds of a to the power b; undefined if ``a`` may be negative and b is not a single integer."""
        undefined = _either(a.undefined, b.undefined)
        if b.is_number and float(b.low).is_integer():
            return self._whole_power(a, float(b.low), undefined)
        # |a|^b is monotone in each operand alone.
        size = self.abs(a)
        corners = [np.power(u, v) for u in size[:2] for v in b[:2]]
        low, high = _extremes(np.fmin, np.fmax, corners)
        unclear = np.isnan(corners).any(axis=0) if np.ndim(low) else np.isnan(np.array(corners)).any()
        if np.any(unclear):
            low, high = np.where(unclear, 0.0, low), np.where(unclear, np.inf, high)
            undefined = _either(undefined, unclear)
        relative = self._exponential_error(low, high, b.magnitude)
        positive = a.positive or bool(np.all(a.low > 0.0))
        if not positive:
            # Negative numbers have only powers with whole exponents, which may have either sign.
            negative = a.low < 0.0
            low, high = np.where(negative, -high, low), high
            undefined = _either(undefined, _where_any(negative))
        return self._rounded(low, high, relative, undefined, positive)

    def _whole_power(self, a: Interval, exponent: float, undefined) -> Interval:
        low, high = elementary_bounds.power_bounds(a.low, a.high, exponent)
        if exponent < 0.0:
            undefined = _either(undefined, _where_any(_holds_zero(a)))
        positive = a.positive or exponent % 2.0 == 0.0
        return self._rounded(low, high, self._exponential_error(low, high, abs(exponent)), undefined, positive)


def _product_with_infinity(*ends) -> tuple[np.ndarray, np.ndarray]:
    """As ``elementary_bounds.product_bounds``, where 0 · ∞ is 0."""
    a_low, a_high, b_low, b_high = np.broadcast_arrays(*ends)
    corners = [a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high]
    return _extremes(np.minimum, np.maximum, [np.where(np.isnan(corner), 0.0, corner) for corner in corners])


def _extremes(least, greatest, values) -> tuple[np.ndarray, np.ndarray]:
    low = high = values[0]
    for value in values[1:]:
        low, high = least(low, value), greatest(high, value)
    return low, high
