# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lipschitz bounds of formulas over boxes: values and gradients in interval arithmetic, side by side.

Interval forward differentiation (Griewank and Walther, "Evaluating Derivatives"), with two additions that distance
fields live on. Every node also has a bound on the norm of its gradient, which rotations and nested lengths would
inflate if it came from bounds of the components alone; and the square root of a sum of squares is taken as a norm, whose
gradient is bounded where that of the root alone has a pole. At a crease the gradients of both sides are bounded
(Clarke's generalised gradient).

The bounds hold for formulas that are continuous. Where one jumps (at a step of ``floor``, a ``select`` whose sides
differ, the cut of an angle, the end of a loop that points leave early) they are true of both sides, not of the jump.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .formula import CONDITIONS, ITERATE, Formula, order
from .read_interval import DOUBLE, Arithmetic, Boxes, Condition, Interval, run

_MARGIN = 1.0 + 64.0 * DOUBLE.basic  # covers the rounding of the few operations of a norm

_arithmetic = Arithmetic()


class Slope(NamedTuple):
    """A value over boxes, and its gradient with respect to the position."""

    value: Interval
    gradient: Interval | None  # components (3, n); None where the value does not depend on the position
    norm: np.ndarray | float  # bound on the length of the gradient, often less than that of the components together
    parts: "tuple[Slope, ...] | None" = None  # the value is the sum of their squares; where a square root needs them


def lipschitz(formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray = ()) -> np.ndarray:
    """Least bounds (n,) found for |φ(x) − φ(y)| / |x − y| over boxes with the corners ``low`` and ``high`` (n, 3).

    Infinite where no bound is found. It covers every box by itself: between points of two boxes the greatest of the
    boxes' bounds that the segment passes through holds.
    """
    return _slope(formula, low, high, parameters)[2]


def global_lipschitz(formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray = ()) -> float:
    """As ``lipschitz``, of one box with the corners ``low`` and ``high`` (3,), by dividing it where the bound is loose.

    Ends when no slope much below the bound is known to occur any more, or after ``_ROUNDS`` divisions. Infinite where
    no bound is found.
    """
    low, high = np.array(low, np.float64, ndmin=2), np.array(high, np.float64, ndmin=2)
    if not np.isfinite(high - low).all():
        return float(lipschitz(formula, low, high, parameters)[0])
    low, high = _octants(*_octants(low, high))
    settled = steepest = 0.0
    for round_ in range(_ROUNDS):
        # Slopes that do occur: those at one point of each box, off the planes of symmetry that shapes have.
        points = low + (high - low) * _INSIDE
        bounds = lipschitz(formula, np.concatenate([low, points]), np.concatenate([high, points]), parameters)
        bounds, slopes = bounds[:len(low)], bounds[len(low):]
        steepest = max(steepest, slopes[np.isfinite(slopes)].max(initial=0.0))
        worst = np.argsort(bounds)[::-1]
        worst = worst[bounds[worst] > (1.0 + _LOOSE) * steepest]
        if not len(worst) or round_ == _ROUNDS - 1:
            return float(max(settled, bounds.max()))
        divided = np.zeros(len(low), bool)
        divided[worst[:_DIVIDED]] = True
        settled = max(settled, bounds[~divided].max(initial=0.0))
        low, high = _octants(low[divided], high[divided])


_ROUNDS, _DIVIDED, _LOOSE = 6, 64, 0.01
_INSIDE = np.array([0.37, 0.61, 0.53])


def _octants(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 3), each divided in 8."""
    corner = np.stack(np.meshgrid(*[(0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(8, 1, 3)
    middle = 0.5 * (low + high)
    return np.where(corner, middle, low).reshape(-1, 3), np.where(corner, high, middle).reshape(-1, 3)


def gradient_bounds(formula: Formula, low: np.ndarray, high: np.ndarray,
                    parameters: np.ndarray = ()) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n, 3), (n, 3) of the components of the gradient over boxes, both sides of every crease included."""
    _, gradient, _ = _slope(formula, low, high, parameters)
    return gradient[0].T.copy(), gradient[1].T.copy()


def enclose_with_slope(formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray = ()):
    """What ``read_interval.enclose`` and ``lipschitz`` give, for little more than the second alone: low, high, bound."""
    value, _, norm = _slope(formula, low, high, parameters)
    return *value, norm


def _slope(formula: Formula, low, high, parameters):
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    n = len(low)
    with np.errstate(all="ignore"):
        found = run((formula,), _Slopes(formula, low, high, parameters))[0]
        value = tuple(np.broadcast_to(bound, n).astype(np.float64) for bound in found.value[:2])
        if found.gradient is None:
            return value, (np.zeros((3, n)), np.zeros((3, n))), np.zeros(n)
        gradient = tuple(np.broadcast_to(bound, (3, n)) for bound in found.gradient[:2])
        return value, gradient, np.minimum(found.norm, _length(found.gradient)) * np.ones(n)


def _length(gradient: Interval) -> np.ndarray:
    """Bound on the length of a vector of intervals."""
    x, y, z = gradient.magnitude
    return np.sqrt(x * x + y * y + z * z) * _MARGIN


def _scaled(slope: Slope, factor: Interval) -> tuple[Interval | None, np.ndarray | float]:
    """Gradient and norm, times a factor."""
    if slope.gradient is None:
        return None, 0.0
    return _plain(_arithmetic.multiply(slope.gradient, factor)), _product(slope.norm, factor.magnitude)


def _product(norm, factor):
    """Product of two bounds, where 0 · ∞ is 0: of what is bounded by 0 no multiple is more."""
    product = norm * factor * _MARGIN
    return np.where(np.isnan(product), 0.0, product)


def _plain(gradient: Interval) -> Interval:
    """Whether a gradient is defined is not asked: bounds are about the points where it is."""
    return Interval(gradient.low, gradient.high)


def _sum(*terms: tuple[Interval | None, np.ndarray | float]) -> tuple[Interval | None, np.ndarray | float]:
    """Gradient and norm of a sum."""
    terms = [term for term in terms if term[0] is not None]
    if not terms:
        return None, 0.0
    gradient, norm = terms[0]
    for other, more in terms[1:]:
        gradient, norm = _plain(_arithmetic.add(gradient, other)), (norm + more) * _MARGIN
    if len(terms) > 1:
        norm = np.minimum(norm, _length(gradient))
    return gradient, norm


_NOTHING = (np.zeros((3, 1)), np.zeros((3, 1)))


def _select(condition: Condition, a: Slope, b: Slope, value: Interval | None = None) -> Slope:
    value = _arithmetic.select(condition, a.value, b.value) if value is None else value
    if a.gradient is None and b.gradient is None:
        return Slope(value, None, 0.0)
    u, v = (Interval(*_NOTHING) if slope.gradient is None else slope.gradient for slope in (a, b))
    certain, possible = condition
    norm = np.where(certain, a.norm, np.where(possible, np.maximum(a.norm, b.norm), b.norm))
    return Slope(value, _plain(_arithmetic.select(condition, u, v)), norm)


# -- norms --------------------------------------------------------------------------------------------------------


def _norm(parts: list[Slope]) -> tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray]:
    """Of a vector of values: bounds of the components of the unit vector along it, and of its least length."""
    squares = [_arithmetic.square(part.value) for part in parts]
    units = []
    for i, (part, square) in enumerate(zip(parts, squares)):
        rest = [other for j, other in enumerate(squares) if j != i]
        least, most = (sum(other[end] for other in rest) for end in (0, 1))
        # u/√(u² + rest) grows with u; it moves away from 0 as the rest becomes less. At the origin it can be anything.
        u, v = part.value.low, part.value.high
        low = u / np.sqrt(u * u + np.where(u < 0.0, least, most)) * _MARGIN
        high = v / np.sqrt(v * v + np.where(v > 0.0, least, most)) * _MARGIN
        low = np.where(np.isfinite(low) & (low > 0.0), low / _MARGIN**2, low)
        high = np.where(np.isfinite(high) & (high < 0.0), high / _MARGIN**2, high)
        low, high = np.where(low >= -1.0, low, -1.0), np.where(high <= 1.0, high, 1.0)
        units.append((low, high))
    return units, np.sqrt(sum(square.low for square in squares)) / _MARGIN


def _steepest(parts: list[Slope], units: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray | float:
    """Bound on |Jᵀu| for unit vectors u within ``units`` and the matrix J of the gradients of ``parts``.

    |Jᵀu|² = uᵀGu with G = JJᵀ, which is at most the greatest sum of |G| along a row, and at most Σ |u_i| |G_ij| |u_j|.
    """
    moving = [(part, np.maximum(-low, high)) for part, (low, high) in zip(parts, units) if part.gradient is not None]
    if len(moving) > 4:  # the pairs are too many: the Frobenius norm
        return np.sqrt(sum(_product(part.norm, part.norm) for part, _ in moving)) * _MARGIN
    rows, total = [], 0.0
    for i, (a, u) in enumerate(moving):
        row = 0.0
        for j, (b, v) in enumerate(moving):
            if i == j:
                entry = _product(a.norm, a.norm)
            else:
                dot = _arithmetic.multiply(a.gradient, b.gradient)
                x, y, z = (Interval(dot.low[k], dot.high[k]) for k in range(3))
                entry = np.minimum(_product(a.norm, b.norm), _arithmetic.add(_arithmetic.add(x, y), z).magnitude)
            row = row + entry
            total = total + _product(_product(u, v), entry)
        rows.append(row)
    greatest = rows[0]
    for row in rows[1:]:
        greatest = np.maximum(greatest, row)
    return np.sqrt(np.minimum(greatest, total)) * _MARGIN


def _length_of(value: Interval, parts: list[Slope]) -> Slope:
    """√(Σ part²), which is ``value``: its gradient is Jᵀ times the unit vector along the parts."""
    units, _ = _norm(parts)
    gradient, norm = _sum(*(_scaled(part, Interval(*unit)) for part, unit in zip(parts, units)))
    if gradient is None:
        return Slope(value, None, 0.0)
    return Slope(value, gradient, np.minimum(norm, _steepest(parts, units)))


def _magnitude(slope: Slope) -> Slope:
    """|slope|."""
    a = slope.value
    if slope.gradient is None:
        return Slope(_arithmetic.abs(a), None, 0.0)
    sign = Interval(np.where(a.low >= 0.0, 1.0, -1.0), np.where(a.high <= 0.0, -1.0, 1.0))
    if a.undefined is not None:
        sign = Interval(np.where(a.undefined, -1.0, sign.low), np.where(a.undefined, 1.0, sign.high))
    return Slope(_arithmetic.abs(a), _plain(_arithmetic.multiply(slope.gradient, sign)), slope.norm)


# -- rules of the operations --------------------------------------------------------------------------------------


def _along(derivative: Callable[[Interval, Interval], Interval]) -> Callable:
    """Rule of a function of one operand, from its derivative in terms of value and operand."""
    return lambda value, operands: _scaled(operands[0], derivative(value, operands[0].value))


_ONE, _MINUS_ONE, _HALF = (_arithmetic.number(number) for number in (1.0, -1.0, 0.5))


def _of_root(value: Interval, operand: Interval) -> Interval:
    return _arithmetic.divide(_HALF, value)


def _of_sine_inverse(value: Interval, operand: Interval) -> Interval:
    return _arithmetic.divide(_ONE, _arithmetic.sqrt(_arithmetic.subtract(_ONE, _arithmetic.square(operand))))


def _multiply(value: Interval, operands: list[Slope]):
    a, b = operands
    if a is b:
        return _scaled(a, _arithmetic.add(a.value, a.value))
    return _sum(_scaled(a, b.value), _scaled(b, a.value))


def _divide(value: Interval, operands: list[Slope]):
    a, b = operands
    inverse = _arithmetic.divide(_ONE, b.value)
    return _sum(_scaled(a, inverse), _scaled(b, _arithmetic.negate(_arithmetic.multiply(value, inverse))))


def _power(value: Interval, operands: list[Slope]):
    a, b = operands
    less = _arithmetic.power(a.value, _arithmetic.subtract(b.value, _ONE))
    terms = [_scaled(a, _arithmetic.multiply(b.value, less))]
    if b.gradient is not None:
        terms.append(_scaled(b, _arithmetic.multiply(value, _arithmetic.log(a.value))))
    return _sum(*terms)


def _atan2(value: Interval, operands: list[Slope]):
    """(x ∇y − y ∇x) / r², with (x, y)/r a unit vector."""
    units, least = _norm(operands)
    y, x = (Interval(*unit) for unit in units)
    inverse = _arithmetic.divide(_ONE, Interval(least, np.full_like(least, np.inf)))
    gradient, norm = _sum(_scaled(operands[0], x), _scaled(operands[1], _arithmetic.negate(y)))
    if gradient is None:
        return None, 0.0
    steepest = _steepest(operands, units)
    return _scaled(Slope(value, gradient, np.minimum(norm, steepest)), inverse)


def _order(less: Callable) -> Callable:
    def rule(value: Interval, operands: list[Slope]):
        chosen = _select(less(*(operand.value for operand in operands)), *operands, value)
        return chosen[1:3]

    return rule


_RULES: dict[str, Callable] = {
    "negate": lambda value, operands: (
        None if operands[0].gradient is None else _arithmetic.negate(operands[0].gradient), operands[0].norm),
    "abs": lambda value, operands: _magnitude(operands[0])[1:3],
    "sqrt": _along(_of_root),
    "sin": _along(lambda value, a: _arithmetic.cos(a)),
    "cos": _along(lambda value, a: _arithmetic.negate(_arithmetic.sin(a))),
    "tan": _along(lambda value, a: _arithmetic.add(_ONE, _arithmetic.square(value))),
    "asin": _along(_of_sine_inverse),
    "acos": _along(lambda value, a: _arithmetic.negate(_of_sine_inverse(value, a))),
    "atan": _along(lambda value, a: _arithmetic.divide(_ONE, _arithmetic.add(_ONE, _arithmetic.square(a)))),
    "exp": _along(lambda value, a: value),
    "log": _along(lambda value, a: _arithmetic.divide(_ONE, a)),
    "floor": lambda value, operands: (None, 0.0),
    "add": lambda value, operands: _sum(*(operand[1:3] for operand in operands)),
    "subtract": lambda value, operands: _sum(operands[0][1:3], _scaled(operands[1], _MINUS_ONE)),
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "atan2": _atan2,
    "minimum": _order(_arithmetic.less_equal),
    "maximum": _order(lambda a, b: _arithmetic.less_equal(b, a)),
}


# -- sums of squares ----------------------------------------------------------------------------------------------

_MOST_PARTS = 12
_PASSES_ROOTS_ON = frozenset({"add", "minimum", "maximum", "select", "multiply", "divide"})


def _under_roots(formula: Formula) -> set[Formula]:
    """Nodes that a square root is taken of, and those whose sums, choices and multiples these are."""
    nodes = order(formula)
    found = set()
    for node in reversed(nodes):
        if node.kind == ITERATE:
            for root in node.value.roots():
                found |= _under_roots(root)
        elif node.kind == "sqrt" or (node in found and node.kind in _PASSES_ROOTS_ON):
            found.update(node.operands)
    return found


def _root(slope: Slope) -> Slope:
    """Something whose square is the sum of the squares of the parts."""
    return slope.parts[0] if len(slope.parts) == 1 else _length_of(_arithmetic.sqrt(slope.value), list(slope.parts))


def _constant_root(slope: Slope) -> Slope | None:
    if slope.gradient is not None or np.any(slope.value.low < 0.0):
        return None
    return Slope(_arithmetic.sqrt(slope.value), None, 0.0)


def _with_parts(slope: Slope) -> Slope:
    """The slope with its parts, if it has none, but is itself the square of a number."""
    root = _constant_root(slope) if slope.parts is None else None
    return slope if root is None else slope._replace(parts=(root,))


def _parts(kind: str, operands: list) -> tuple[Slope, ...] | None:
    """Parts of the value of one node."""
    if kind == "select":
        then, otherwise = map(_with_parts, operands[1:])
        if then.parts is None or otherwise.parts is None:
            return None
        return (_select(operands[0], _root(then), _root(otherwise)),)
    a, b = (*operands, None)[:2]
    if kind == "multiply" and a is b:
        return (a._replace(parts=None),)
    if kind == "power" and b.value.is_number and b.value.low == 2.0:
        return (a._replace(parts=None),)
    if kind in ("multiply", "divide"):
        if kind == "multiply" and a.parts is None:
            a, b = b, a
        scale = _constant_root(b)
        if a.parts is None or scale is None:
            return None
        rule = getattr(_arithmetic, kind)
        return tuple(Slope(rule(part.value, scale.value), *_RULES[kind](None, [part, scale])) for part in a.parts)
    if kind in ("add", "minimum", "maximum"):
        a, b = _with_parts(a), _with_parts(b)
        if a.parts is None or b.parts is None:
            return None
        if kind == "add":
            return (*a.parts, *b.parts) if len(a.parts) + len(b.parts) <= _MOST_PARTS else (_root(a), _root(b))
        condition = _arithmetic.less_equal(a.value, b.value)
        return (_select(condition, *((_root(a), _root(b)) if kind == "minimum" else (_root(b), _root(a)))),)
    return None


class _Slopes(Boxes):
    """Values with gradients, at each kind of node."""

    def __init__(self, formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray):
        super().__init__(_arithmetic, low, high, parameters)
        self.under_roots = _under_roots(formula)

    def position(self, axis):
        direction = np.zeros((3, 1))
        direction[axis] = 1.0
        return Slope(super().position(axis), Interval(direction, direction), 1.0)

    def number(self, value):
        return Slope(super().number(value), None, 0.0)

    def interval(self, value):
        return value.value

    def select(self, condition, then, otherwise):
        return _select(condition, then, otherwise)

    def apply(self, node, operands):
        slope = self._apply(node, operands)
        if node in self.under_roots and node.kind not in CONDITIONS:
            slope = slope._replace(parts=_parts(node.kind, operands))
        return slope

    def _apply(self, node, operands):
        if node.kind == "select":
            return _select(*operands)
        value = getattr(_arithmetic, node.kind)(*(operand.value for operand in operands))
        if node.kind in CONDITIONS:
            return value
        if node.kind == "sqrt" and operands[0].parts is not None:
            parts = operands[0].parts
            slope = _magnitude(parts[0]) if len(parts) == 1 else _length_of(value, list(parts))
            return slope._replace(value=value)
        return Slope(value, *_RULES[node.kind](value, operands))
