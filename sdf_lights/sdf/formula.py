# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas: hash-consed expression graphs over position, parameters and constants.

The same expression is always the same object, so common subexpressions are computed once whatever way they came
about, and the formula itself is the key under which a reading (compiled code, say) is kept. A parameter is the number
of a slot in an array of values: other values, same formula.

``OPERATIONS`` is the one table of what a node can be and what it means; ``iterate`` adds bounded loops. Readings walk
``order(formula)`` and add nothing to it: see ``read_numpy``, ``read_native`` and ``read_text``. This module knows none
of them.
"""

from __future__ import annotations

import contextvars
import math
import threading
import weakref
from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Operation(NamedTuple):
    """``meaning`` is the operation on float64 arrays, which is also how constants are folded."""

    arity: int
    meaning: Callable
    commutes: bool = False


CONSTANT, POSITION, PARAMETER = "constant", "position", "parameter"
STATE, ITERATE, RESULT = "state", "iterate", "result"

LONGEST_LOOP = 1000  # rounds

OPERATIONS: dict[str, Operation] = {
    "negate": Operation(1, np.negative),
    "abs": Operation(1, np.abs),
    "sqrt": Operation(1, np.sqrt),
    "sin": Operation(1, np.sin),
    "cos": Operation(1, np.cos),
    "tan": Operation(1, np.tan),
    "asin": Operation(1, np.arcsin),
    "acos": Operation(1, np.arccos),
    "atan": Operation(1, np.arctan),
    "exp": Operation(1, np.exp),
    "log": Operation(1, np.log),
    "floor": Operation(1, np.floor),
    "add": Operation(2, np.add, commutes=True),
    "subtract": Operation(2, np.subtract),
    "multiply": Operation(2, np.multiply, commutes=True),
    "divide": Operation(2, np.divide),
    "power": Operation(2, np.power),
    "atan2": Operation(2, np.arctan2),
    "minimum": Operation(2, np.minimum, commutes=True),
    "maximum": Operation(2, np.maximum, commutes=True),
    # Comparisons are conditions: they may only stand as the first operand of select.
    "less": Operation(2, np.less),
    "less_equal": Operation(2, np.less_equal),
    "select": Operation(3, np.where),
}

CONDITIONS = frozenset({"less", "less_equal"})


class Formula:
    """One node. Made only by the functions and operators of this module; compared and hashed by identity.

    ``kind`` is ``CONSTANT`` (``value`` a float), ``POSITION`` (``value`` 0, 1 or 2 for x, y, z), ``PARAMETER``
    (``value`` a slot) or a key of ``OPERATIONS`` (``operands`` formulas). Of loops (see ``iterate``) it is ``ITERATE``
    (``value`` a ``Loop``, ``operands`` the number of rounds, the first states, and what the body needs from outside),
    ``RESULT`` (``value`` the number of a state, ``operands`` the loop), or, in the body alone, ``STATE`` (``value`` the
    loop's level and the number of the state).
    """

    __slots__ = ("kind", "operands", "value", "__weakref__")

    kind: str
    operands: tuple["Formula", ...]
    value: "float | int | tuple[int, int] | Loop | None"

    def __add__(self, other):
        return apply("add", self, other)

    def __radd__(self, other):
        return apply("add", other, self)

    def __sub__(self, other):
        return apply("subtract", self, other)

    def __rsub__(self, other):
        return apply("subtract", other, self)

    def __mul__(self, other):
        return apply("multiply", self, other)

    def __rmul__(self, other):
        return apply("multiply", other, self)

    def __truediv__(self, other):
        return apply("divide", self, other)

    def __rtruediv__(self, other):
        return apply("divide", other, self)

    def __neg__(self):
        return apply("negate", self)

    def __abs__(self):
        return apply("abs", self)

    def __lt__(self, other):
        return apply("less", self, other)

    def __le__(self, other):
        return apply("less_equal", self, other)

    def __gt__(self, other):
        return apply("less", other, self)

    def __ge__(self, other):
        return apply("less_equal", other, self)

    def __bool__(self):
        raise TypeError("a formula has no truth value before it is read: use select(condition, a, b)")

    def __reduce__(self):  # copies and unpickled formulas are the same object again
        return _intern, (self.kind, self.operands, self.value)

    def __repr__(self):
        return f"<Formula {self.kind} {self.value if self.value is not None else ''}>".replace(" >", ">")


class Loop(NamedTuple):
    """The body of a loop: ``steps`` are the next states, computed while the comparison ``going`` holds.

    ``level`` says how many loops it stands in. ``limit`` is the most rounds there can be.
    """

    level: int
    limit: int
    steps: tuple[Formula, ...]
    going: Formula | None

    def roots(self) -> tuple[Formula, ...]:
        """What a round has to compute."""
        return self.steps if self.going is None else (*self.steps, self.going)


# Formulas live as long as somebody holds them. Blender renders and draws from different threads, hence the lock.
_known: weakref.WeakValueDictionary[tuple, Formula] = weakref.WeakValueDictionary()
_lock = threading.Lock()


def _intern(kind: str, operands: tuple[Formula, ...] = (), value=None) -> Formula:
    # 0.0 == -0.0, yet they are different constants.
    sign = math.copysign(1.0, value) if kind == CONSTANT else 0.0
    key = (kind, operands, value, sign)
    with _lock:
        found = _known.get(key)
        if found is None and kind in OPERATIONS and OPERATIONS[kind].commutes:
            found = _known.get((kind, operands[::-1], value, sign))
        if found is None:
            found = object.__new__(Formula)
            found.kind, found.operands, found.value = kind, operands, value
            _known[key] = found
    return found


def constant(value: float) -> Formula:
    value = float(value)
    if math.isnan(value):
        raise ValueError("a constant of a formula cannot be NaN")
    return _intern(CONSTANT, value=value)


def parameter(slot: int) -> Formula:
    """The value in slot ``slot`` of the parameter array."""
    return _intern(PARAMETER, value=int(slot))


def _is(formula: Formula, value: float) -> bool:
    return formula.kind == CONSTANT and formula.value == value


def _simplified(kind: str, operands: tuple[Formula, ...]) -> Formula | None:
    """A smaller formula of the same value for all finite operands, where one of these rules finds it."""
    a, b = operands[0], operands[-1]
    if kind == "negate" and a.kind == "negate":
        return a.operands[0]
    if kind == "abs" and a.kind in ("abs", "sqrt"):
        return a
    if kind == "abs" and a.kind == "negate":
        return apply("abs", a.operands[0])
    if kind == "add":
        return b if _is(a, 0.0) else a if _is(b, 0.0) else None
    if kind == "subtract":
        return a if _is(b, 0.0) else constant(0.0) if a is b else apply("negate", b) if _is(a, 0.0) else None
    if kind == "multiply":
        if _is(a, 0.0) or _is(b, 0.0):
            return constant(0.0)
        return b if _is(a, 1.0) else a if _is(b, 1.0) else None
    if kind in ("divide", "power"):
        return a if _is(b, 1.0) else None
    if kind in ("minimum", "maximum"):
        return a if a is b else None
    if kind == "select":
        return operands[1] if operands[1] is operands[2] else None
    return None


def apply(kind: str, *operands: Formula | float) -> Formula:
    """The operation ``kind`` of ``OPERATIONS`` on formulas or numbers: folded, simplified, shared."""
    operands = tuple(o if isinstance(o, Formula) else constant(o) for o in operands)
    operation = OPERATIONS[kind]
    if len(operands) != operation.arity:
        raise TypeError(f"{kind} takes {operation.arity} operands, not {len(operands)}")
    if any((o.kind in CONDITIONS) != (kind == "select" and i == 0) for i, o in enumerate(operands)):
        raise TypeError("a condition can only be the first operand of select, which has to be one")
    if kind not in CONDITIONS:
        if all(o.kind == CONSTANT for o in operands):
            with np.errstate(all="ignore"):
                folded = float(operation.meaning(*(o.value for o in operands)))
            # sqrt(-1) and the like stay as they are: what is undefined is then seen where the formula is read.
            if not math.isnan(folded):
                return constant(folded)
        smaller = _simplified(kind, operands)
        if smaller is not None:
            return smaller
    return _intern(kind, operands)


def sqrt(a: Formula | float) -> Formula:
    return apply("sqrt", a)


def sin(a: Formula | float) -> Formula:
    return apply("sin", a)


def cos(a: Formula | float) -> Formula:
    return apply("cos", a)


def minimum(*operands: Formula | float) -> Formula:
    """Least of one or more operands."""
    return _fold("minimum", operands)


def maximum(*operands: Formula | float) -> Formula:
    """Greatest of one or more operands."""
    return _fold("maximum", operands)


def clamp(a: Formula | float, low: Formula | float, high: Formula | float) -> Formula:
    return minimum(maximum(a, low), high)


def select(condition: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """``then`` where the condition (a comparison) holds, else ``otherwise``; both are computed."""
    return apply("select", condition, then, otherwise)


def length(*components: Formula | float) -> Formula:
    """Euclidean norm."""
    return sqrt(_fold("add", [apply("multiply", c, c) for c in components]))


def _fold(kind: str, operands) -> Formula:
    # A balanced tree: short chains of dependent instructions, and no depth that grows with the number of operands.
    operands = list(operands)
    while len(operands) > 1:
        pairs = [apply(kind, a, b) for a, b in zip(operands[::2], operands[1::2])]
        operands = pairs + operands[len(pairs) * 2:]
    first = operands[0]
    return first if isinstance(first, Formula) else constant(first)


class Vector(NamedTuple):
    """Three formulas, with the arithmetic of vectors (a scalar operand counts for each component)."""

    x: Formula
    y: Formula
    z: Formula

    def __add__(self, other):
        return Vector(*(a + b for a, b in zip(self, _components(other))))

    def __sub__(self, other):
        return Vector(*(a - b for a, b in zip(self, _components(other))))

    def __mul__(self, other):
        return Vector(*(a * b for a, b in zip(self, _components(other))))

    def __truediv__(self, other):
        return Vector(*(a / b for a, b in zip(self, _components(other))))

    def __abs__(self):
        return Vector(*(abs(a) for a in self))

    def maximum(self, other) -> "Vector":
        """Greater of each pair of components."""
        return Vector(*(maximum(a, b) for a, b in zip(self, _components(other))))

    def dot(self, other: "Vector") -> Formula:
        return _fold("add", [a * b for a, b in zip(self, other)])

    def length(self) -> Formula:
        return length(*self)


def _components(value) -> tuple:
    return value if isinstance(value, tuple) else (value, value, value)


POINT = Vector(*(_intern(POSITION, value=axis) for axis in range(3)))
"""The point at which a formula is read."""


_level = contextvars.ContextVar("level", default=0)


def iterate(count: Formula | float, initial: tuple[Formula | float, ...],
            body: Callable[..., tuple[tuple[Formula | float, ...], Formula | None]], limit: int) -> tuple[Formula, ...]:
    """States after ``count`` rounds of a loop: ``steps, going = body(*states)``.

    ``count`` must not depend on the position; it is rounded down, and held to 0 and ``limit``. ``going`` is a comparison
    of the states before the round, or None: a point at which it fails keeps its states from then on.
    """
    if not 0 < limit <= LONGEST_LOOP:
        raise ValueError(f"a loop can have 1 to {LONGEST_LOOP} rounds, not {limit}")
    count, *initial = (o if isinstance(o, Formula) else constant(o) for o in (count, *initial))
    if any(node.kind in (POSITION, STATE) for node in order(count)):
        raise TypeError("the number of rounds of a loop cannot depend on the position")
    level = _level.get()
    states = tuple(_intern(STATE, value=(level, index)) for index in range(len(initial)))
    token = _level.set(level + 1)
    try:
        steps, going = body(*states)
    finally:
        _level.reset(token)
    steps = tuple(o if isinstance(o, Formula) else constant(o) for o in steps)
    if len(steps) != len(states) or (going is not None and going.kind not in CONDITIONS):
        raise TypeError("the body of a loop gives one value for each state, and a comparison or None")
    loop = Loop(level, limit, steps, going)
    node = _intern(ITERATE, (count, *initial, *_captures(loop)), loop)
    return tuple(_intern(RESULT, (node,), index) for index in range(len(states)))


def _captures(loop: Loop) -> list[Formula]:
    """Nodes that the body of a loop uses and that stay the same in all its rounds; constants are not listed."""
    nodes = order(*loop.roots())
    inside = {}
    for node in nodes:
        inside[node] = (node.kind == STATE and node.value[0] == loop.level) or any(inside[o] for o in node.operands)
    used = [o for node in nodes if inside[node] for o in node.operands]
    used += loop.roots()
    return [node for node in dict.fromkeys(used) if not inside[node] and node.kind != CONSTANT]


def body(node: Formula) -> list[Formula]:
    """What each round of an ``ITERATE`` node computes, in order; its captures are known by then (as its operands)."""
    loop = node.value
    known = set(node.operands[1 + len(loop.steps):])
    return [n for n in order(*loop.roots(), known=known) if n not in known]


def order(*formulas: Formula, known: set[Formula] = frozenset()) -> list[Formula]:
    """Every node of the graph once, operands before the nodes that use them; the last formula itself comes last.

    The bodies of loops are not part of it. Operands of ``known`` nodes are left out, where nothing else uses them.
    """
    ordered: list[Formula] = []
    seen: set[Formula] = set()
    pending = [(formula, False) for formula in reversed(formulas)]
    while pending:
        node, ready = pending.pop()
        if ready:
            ordered.append(node)
        elif node not in seen:
            seen.add(node)
            pending.append((node, True))
            if node not in known:
                pending += [(operand, False) for operand in reversed(node.operands)]
    return ordered


def slots(formula: Formula) -> int:
    """Least length of a parameter array that the formula can be read with."""
    return 1 + max((node.value for node in order(formula) if node.kind == PARAMETER), default=-1)
