# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lipschitz bounds of formulas over boxes: values and gradients in interval arithmetic, side by side.

Interval forward differentiation (Griewank and Walther, "Evaluating Derivatives"), with two additions that distance
fields live on. Every node also has a bound on the norm of its gradient, which rotations and nested lengths would
inflate if it came from bounds of the components alone; and the square root of a sum of squares is taken as a norm,
whose gradient is bounded where that of the root alone has a pole. At a crease the gradients of both sides are bounded
(Clarke's generalised gradient).

The bounds hold for formulas that are continuous. Where one jumps (at a step of ``floor``, a ``select`` whose sides
differ, the cut of an angle, the end of a loop that points leave early) they are true of both sides, not of the jump.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .formula import CONDITIONS, ITERATE, STATE, VARIABLE, Formula, Numbers, order
from .interval_arithmetic import DOUBLE, Arithmetic, Boxes, Condition, Interval, run

_MARGIN = 1.0 + 64.0 * DOUBLE.basic  # covers the rounding of the few operations of a norm
_TINY = DOUBLE.tiny  # covers underflow

_arithmetic = Arithmetic()


class Slope(NamedTuple):
    """A value over boxes, and its gradient with respect to the position."""

    value: Interval
    gradient: Interval | None  # components (3, n); None where the value does not depend on the position
    norm: np.ndarray | float  # bound on the length of the gradient, often less than that of the components together
    parts: "tuple[Slope, ...] | None" = None  # the value is the sum of their squares; where a square root needs them


def lipschitz(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), parts: int = 16
) -> np.ndarray:
    """Least bounds (n,) found for |φ(x) − φ(y)| / |x − y| over boxes with the corners ``low`` and ``high`` (n, 3).

    Infinite where no bound is found. It covers every box by itself: between points of two boxes the greatest of the
    boxes' bounds that the segment passes through holds. ``parts`` is how many cases a box may be taken apart into, by
    the sides of clamps and folds that its points are on.
    """
    return _slope(formula, low, high, parameters, parts)[2]


def global_lipschitz(formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = ()) -> float:
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
        bounds = lipschitz(formula, np.concatenate([low, points]), np.concatenate([high, points]), parameters, 1)
        bounds, slopes = bounds[: len(low)], bounds[len(low) :]
        steepest = max(steepest, slopes[np.isfinite(slopes)].max(initial=0.0))
        enough = (1.0 + _LOOSE) * steepest
        loose = np.flatnonzero(bounds > enough)
        bounds[loose] = lipschitz(formula, low[loose], high[loose], parameters, _PARTS)
        worst = np.argsort(bounds)[: -_DIVIDED - 1 : -1]
        divided = np.zeros(len(low), bool)
        divided[worst] = bounds[worst] > enough
        if not divided.any() or round_ == _ROUNDS - 1:
            return float(max(settled, bounds.max()))
        settled = max(settled, bounds[~divided].max(initial=0.0))
        low, high = _octants(low[divided], high[divided])


_ROUNDS, _DIVIDED, _PARTS, _LOOSE = 4, 32, 8, 0.01
_INSIDE = np.array([0.37, 0.61, 0.53])


def _octants(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 3), each divided in 8."""
    corner = np.stack(np.meshgrid(*[(0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(8, 1, 3)
    middle = 0.5 * (low + high)
    return np.where(corner, middle, low).reshape(-1, 3), np.where(corner, high, middle).reshape(-1, 3)


def gradient_bounds(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), parts: int = 16
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n, 3), (n, 3) of the components of the gradient over boxes, both sides of every crease included."""
    least, most, _ = _slope(formula, low, high, parameters, parts)
    return least.T, most.T


def _slope(formula: Formula, low, high, parameters, parts: int):
    """Bounds over boxes of the gradient, (3, n) and (3, n), and of its length (n,)."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    with np.errstate(all="ignore"):
        boxes = _Slopes(formula, low, high, parameters, parts)
        found = run((formula,), boxes)[0]
        n = len(boxes.rows)
        gradient = _NOTHING if found.gradient is None else found.gradient
        norm = np.broadcast_to(np.minimum(found.norm, _length(gradient)), n)
        least, most = (np.broadcast_to(bound, (3, n)) for bound in gradient[:2])
        return boxes.whole(np.minimum, least), boxes.whole(np.maximum, most), boxes.whole(np.maximum, norm)


def _length(gradient: Interval) -> np.ndarray:
    """Bound on the length of a vector of intervals."""
    x, y, z = gradient.magnitude
    return np.sqrt(x * x + y * y + z * z + _TINY) * _MARGIN


def _scaled(slope: Slope, factor: Interval) -> tuple[Interval | None, np.ndarray | float]:
    """Gradient and norm, times a factor."""
    if slope.gradient is None:
        return None, 0.0
    return _plain(_arithmetic.multiply(slope.gradient, factor)), _product(slope.norm, factor.magnitude)


def _product(norm, factor):
    """Product of two bounds, where 0 · ∞ is 0: of what is bounded by 0 no multiple is more."""
    product = norm * factor * _MARGIN + _TINY
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


_NOTHING = Interval(np.zeros((3, 1)), np.zeros((3, 1)))


def _select(condition: Condition, a: Slope, b: Slope, value: Interval | None = None) -> Slope:
    value = _arithmetic.select(condition, a.value, b.value) if value is None else value
    if a.gradient is None and b.gradient is None:
        return Slope(value, None, 0.0)
    u, v = (_NOTHING if slope.gradient is None else slope.gradient for slope in (a, b))
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
        low = u / np.hypot(u, np.sqrt(np.where(u < 0.0, least, most))) * _MARGIN
        high = v / np.hypot(v, np.sqrt(np.where(v > 0.0, least, most))) * _MARGIN
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


_ZERO, _ONE, _MINUS_ONE, _HALF = (_arithmetic.number(number) for number in (0.0, 1.0, -1.0, 0.5))


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


_RULES: dict[str, Callable] = {
    "negate": lambda value, operands: (
        None if operands[0].gradient is None else _arithmetic.negate(operands[0].gradient),
        operands[0].norm,
    ),
    "sqrt": _along(_of_root),
    "sin": _along(lambda value, a: _arithmetic.cos(a)),
    "cos": _along(lambda value, a: _arithmetic.negate(_arithmetic.sin(a))),
    "tan": _along(lambda value, a: _arithmetic.add(_ONE, _arithmetic.square(value))),
    "asin": _along(_of_sine_inverse),
    "acos": _along(lambda value, a: _arithmetic.negate(_of_sine_inverse(value, a))),
    "atan": _along(lambda value, a: _arithmetic.divide(_ONE, _arithmetic.add(_ONE, _arithmetic.square(a)))),
    "exp": _along(lambda value, a: value),
    "log": _along(lambda value, a: _arithmetic.divide(_ONE, a)),
    "add": lambda value, operands: _sum(*(operand[1:3] for operand in operands)),
    "subtract": lambda value, operands: _sum(operands[0][1:3], _scaled(operands[1], _MINUS_ONE)),
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "atan2": _atan2,
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


def _parts(kind: str, operands: list[Slope], condition: Condition | None) -> tuple[Slope, ...] | None:
    """Parts of the value of one node; ``condition`` says where it is the first of two operands, for a choice."""
    a, b = (*operands, None)[:2]
    if condition is not None:
        a, b = _with_parts(a), _with_parts(b)
        return None if a.parts is None or b.parts is None else (_select(condition, _root(a), _root(b)),)
    if (kind == "multiply" and a is b) or (kind == "power" and b.value.is_number and b.value.low == 2.0):
        return (a._replace(parts=None),)
    if kind in ("multiply", "divide"):
        if kind == "multiply" and a.parts is None:
            a, b = b, a
        scale = _constant_root(b)
        if a.parts is None or scale is None:
            return None
        rule = getattr(_arithmetic, kind)
        return tuple(Slope(rule(part.value, scale.value), *_RULES[kind](None, [part, scale])) for part in a.parts)
    if kind == "add":
        a, b = _with_parts(a), _with_parts(b)
        if a.parts is None or b.parts is None:
            return None
        return (*a.parts, *b.parts) if len(a.parts) + len(b.parts) <= _MOST_PARTS else (_root(a), _root(b))
    return None


# -- parts of boxes -----------------------------------------------------------------------------------------------

_SIGN, _STEP = "sign", "step"


def _sides(formula: Formula) -> dict[Formula, list[tuple]]:
    """What tells the sides of clamps, folds and cells apart, by each formula that it depends on.

    A pair of formulas of which the lesser and the greater are taken, or of which one is a number; or a formula and
    ``_SIGN``, where its absolute value is taken, or ``_STEP``, where it is rounded down.
    """
    pairs: dict[tuple, set[str]] = {}
    fixed: dict[Formula, bool] = {}
    pending = [formula]
    while pending:
        for node in order(pending.pop()):
            fixed[node] = node.kind not in (VARIABLE, STATE, ITERATE) and all(fixed[o] for o in node.operands)
            if node.kind == ITERATE:
                pending += node.value.roots()
            elif node.kind in ("abs", "floor"):
                pairs[node.operands[0], _SIGN if node.kind == "abs" else _STEP] = set()
            elif node.kind in ("minimum", "maximum"):
                known = node.operands[::-1] if node.operands[::-1] in pairs else node.operands
                pairs.setdefault(known, set()).add(node.kind)
    found: dict[Formula, list] = {}
    for (a, b), kinds in pairs.items():
        if b in (_SIGN, _STEP):
            found.setdefault(a, []).append((a, b))
        elif len(kinds) == 2 or fixed[a] != fixed[b]:
            found.setdefault(a, []).append((a, b))
            found.setdefault(b, []).append((a, b))
    return found


def _taken(value, index: np.ndarray, rows: int, done: dict):
    """A value with the rows ``index`` of its arrays; what is the same object stays the same object.

    ``done`` holds the objects that were seen, by their identities, so that these stay theirs.
    """
    if id(value) in done:
        return done[id(value)][1]
    if isinstance(value, np.ndarray):
        found = value[..., index] if value.ndim and value.shape[-1] == rows else value
    elif isinstance(value, dict):
        found = {key: _taken(part, index, rows, done) for key, part in value.items()}
    elif isinstance(value, (list, tuple)):
        parts = [_taken(part, index, rows, done) for part in value]
        found = type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    else:
        found = value
    done[id(value)] = value, found
    return found


class _Slopes(Boxes):
    """Values with gradients, at each kind of node.

    Where it is open which side of a clamp, a fold or a cell's border a box is on, it is divided into the points on
    either side: what is computed from both sides later, as in the distance to a box, which joins one inside and one
    outside, or after repeated reflections, would else be taken to combine in ways that do not occur.
    """

    def __init__(self, formula: Formula, low: np.ndarray, high: np.ndarray, parameters: np.ndarray, parts: int):
        super().__init__(_arithmetic, low, high, parameters)
        self.parts = parts
        self.under_roots = _under_roots(formula)
        self.sides = _sides(formula) if parts > 1 else {}
        self.rows = np.arange(len(low))  # the box that each row is of

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
        if node.kind in CONDITIONS:
            return super().apply(node, [operand.value for operand in operands])
        condition = None
        if node.kind == "select":
            condition, *operands = operands
        elif node.kind in ("minimum", "maximum"):
            condition = self._first_of(node, operands)
        slope = self._slope(node, operands, condition)
        if node in self.under_roots:
            slope = slope._replace(parts=_parts(node.kind, operands, condition))
        return slope

    def _slope(self, node, operands, condition):
        if node.kind == "select":
            return _select(condition, *operands)
        value = super().apply(node, [operand.value for operand in operands])
        if condition is not None:
            return _select(condition, *operands, value)
        if node.kind == "abs":
            return _magnitude(operands[0])
        if node.kind == "floor":
            return Slope(self._floor(node, value), None, 0.0)
        if node.kind == "sqrt" and operands[0].parts is not None:
            parts = operands[0].parts
            slope = _magnitude(parts[0]) if len(parts) == 1 else _length_of(value, list(parts))
            return slope._replace(value=value)
        return Slope(value, *_RULES[node.kind](value, operands))

    def _first_of(self, node: Formula, operands: list[Slope]) -> Condition:
        """Where a minimum or maximum is its first operand. Where both are the same, so are their gradients."""
        a, b = (operand.value for operand in operands)
        if node.kind == "maximum":
            a, b = b, a
        first, second = a.high <= b.low, b.high <= a.low
        sides = self.live[-1].get(node.operands)
        if sides is None and node.operands[::-1] in self.live[-1]:
            sides = -self.live[-1][node.operands[::-1]]
        if sides is not None:
            sides = -sides if node.kind == "maximum" else sides
            first, second = first | (sides < 0), second | (sides > 0)
        undefined = (
            a.undefined if b.undefined is None else (b.undefined if a.undefined is None else a.undefined | b.undefined)
        )
        if undefined is not None:
            first, second = first & ~undefined, second & ~undefined
        return Condition(first, ~second | first)

    def _floor(self, node: Formula, value: Interval) -> Interval:
        sides = self.live[-1].get((node.operands[0], _STEP))
        if sides is None:
            return value
        # On the lower side of a step the number itself is included, but the floor is that of the points below.
        return value._replace(high=np.where(sides < 0, value.low, value.high))

    def divide(self, node):
        for pair in self.sides.get(node, ()):
            values = self.live[-1]
            if pair not in values and all(side in values for side in pair if isinstance(side, Formula)):
                self._divide(*pair)

    def _divide(self, a: Formula, b: Formula | str) -> None:
        values = self.live[-1]
        u = values[a].value
        if b == _SIGN:
            v = _ZERO
        elif b == _STEP:
            step = np.floor(u.high)
            v = Interval(step, step)
        else:
            v = values[b].value
        open_ = (u.low < v.high) & (v.low < u.high)
        if b == _STEP:
            open_ = (u.low < step) & (u.low >= step - 1.0)
        for side in (u, v):
            if side.undefined is not None:
                open_ = open_ & ~side.undefined
        if not np.any(open_):
            return
        n = len(self.rows)
        full = 2 * np.bincount(self.rows, minlength=self.rows.max() + 1)[self.rows] > self.parts
        open_ = np.flatnonzero(open_ & ~full)
        if not len(open_):
            return
        index = np.concatenate([np.arange(n), open_])
        self.rows, self.low, self.high = self.rows[index], self.low[index], self.high[index]
        done: dict = {}
        for frame in self.live:
            frame.update(_taken(frame, index, n, done))
        sides = np.zeros(len(index), np.int8)  # −1: a ≤ b, 1: a ≥ b, 0: open
        sides[open_], sides[n:] = -1, 1
        values[a, b] = sides
        u, v = _taken(u, index, n, {}), _taken(v, index, n, {})
        self._restrict(a, u, v, sides)
        if isinstance(b, Formula):
            self._restrict(b, v, u, -sides)

    def _restrict(self, node: Formula, value: Interval, other: Interval, sides: np.ndarray) -> None:
        """Hold the value of a node to its side of another."""
        if np.ndim(value.low):
            low = np.where(sides > 0, np.maximum(value.low, other.low), value.low)
            high = np.where(sides < 0, np.minimum(value.high, other.high), value.high)
            values = self.live[-1]
            values[node] = values[node]._replace(value=value._replace(low=low, high=high))

    def whole(self, join, values: np.ndarray) -> np.ndarray:
        """Values (…, rows) of the boxes (…, n) from those of all their rows."""
        first = np.argsort(self.rows, kind="stable")
        starts = np.flatnonzero(np.diff(self.rows[first], prepend=-1))
        return join.reduceat(values[..., first], starts, axis=-1) if len(first) else values
