# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes of formulas, and the rules that simplify them. ``formula`` has all of them, with functions and vectors.

The same expression is always the same object, so common subexpressions are computed once, wherever they come from. The
formula itself is the key of everything derived from it, such as compiled code. A parameter is the number of a slot in
an array of values: other values, same formula.

A variable is a named input, such as the position. The evaluator defines which names exist.

``operations.OPERATIONS`` is the one table of operations; ``loops.iterate`` adds bounded loops, ``call`` the functions
of ``functions.py``. Evaluators and code generators walk ``order(formula)`` and do not change it: see
``numpy_evaluation``, ``codegen_native`` and ``formula_text``. This module depends on none of them.
"""

from __future__ import annotations

import contextlib
import contextvars
import math
import threading
import weakref
from collections.abc import Callable, Sequence, Set
from typing import Any, NamedTuple

import numpy as np

from .functions import Function
from .operations import CONDITIONS, OPERATIONS

Numbers = Sequence[float] | np.ndarray  # values of the slots of a formula

CONSTANT, VARIABLE, PARAMETER = "constant", "variable", "parameter"
STATE, ITERATE, CALL, RESULT = "state", "iterate", "call", "result"

POSITION = "position"  # the variable of a shape's formula


class Formula:
    """One node. Made only by the functions and operators of this module; compared and hashed by identity.

    ``kind`` is ``CONSTANT`` (``value`` a float), ``VARIABLE`` (``value`` a name and the number of a component),
    ``PARAMETER`` (``value`` a slot) or a key of ``OPERATIONS`` (``operands`` formulas). Loops (see ``loops.iterate``)
    have ``ITERATE`` (``value`` a ``Loop``; ``operands`` the number of iterations, the first states, and the outer
    values that the body uses). Only inside the body, ``STATE`` has the loop's level and the number of the state as its
    ``value``. Calls have ``CALL`` (``value`` a ``Function``). ``RESULT`` is one of the values of a loop or call
    (``value`` its number, ``operands`` the loop or call).
    """

    __slots__ = ("kind", "operands", "value", "__weakref__")

    kind: str
    operands: tuple["Formula", ...]
    value: Any  # its type follows from the kind

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
        return intern, (self.kind, self.operands, self.value)

    def __repr__(self):
        return f"<Formula {self.kind} {self.value if self.value is not None else ''}>".replace(" >", ">")


class Loop(NamedTuple):
    """The body of a loop: ``steps`` are the next states, computed while the comparison ``going`` holds.

    ``level`` is the number of surrounding loops. ``limit`` is the maximum number of iterations.
    """

    level: int
    limit: int
    steps: tuple[Formula, ...]
    going: Formula | None

    def roots(self) -> tuple[Formula, ...]:
        """The nodes that an iteration computes."""
        return self.steps if self.going is None else (*self.steps, self.going)


# Formulas live as long as something refers to them. Blender renders and draws in different threads, hence the lock.
_known: weakref.WeakValueDictionary[tuple, Formula] = weakref.WeakValueDictionary()
_lock = threading.Lock()


def intern(kind: str, operands: tuple[Formula, ...] = (), value=None) -> Formula:
    """The one node of this kind, these operands and this value (hash-consing). Simplifies nothing: see ``apply``."""
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
    """A number. Raises ValueError for NaN, which no formula may contain."""
    value = float(value)
    if math.isnan(value):
        raise ValueError("a constant of a formula cannot be NaN")
    return intern(CONSTANT, value=value)


def parameter(slot: int) -> Formula:
    """The value in slot ``slot`` of the parameter array."""
    return intern(PARAMETER, value=int(slot))


def variable(name: str, component: int = 0) -> Formula:
    """A component of the named input."""
    return intern(VARIABLE, value=(name, int(component)))


def axis_of(node: Formula) -> int:
    """The axis of a variable in a shape's formula. Raises ValueError for any variable but the position."""
    name, axis = node.value
    if name != POSITION:
        raise ValueError(f"a formula of the position alone is needed here, but this one has the variable {name!r}")
    return axis


def formula_of(value: Formula | float) -> Formula:
    """A formula unchanged, a number as a constant. Raises ValueError for NaN."""
    return value if isinstance(value, Formula) else constant(value)


def call(function: Function, *operands: Formula | float) -> tuple[Formula, ...]:
    """All results of an external function. Raises TypeError for a wrong number of operands."""
    nodes = tuple(map(formula_of, operands))
    if any(o.kind in CONDITIONS for o in nodes):
        raise TypeError("a condition can only be the first operand of select")
    node = intern(CALL, nodes, function)
    return tuple(intern(RESULT, (node,), index) for index in range(function.results))


def _is(formula: Formula, value: float) -> bool:
    return formula.kind == CONSTANT and formula.value == value


_MOST_FACTORS = 16  # of a power that is written as products

_numbers_may_change = contextvars.ContextVar("numbers_may_change", default=False)


@contextlib.contextmanager
def numbers_may_change():
    """Inside this context, no rule uses the value of a number, except for 0, 1 and the order of two numbers: a formula
    with other numbers has the same nodes."""
    token = _numbers_may_change.set(True)
    try:
        yield
    finally:
        _numbers_may_change.reset(token)


def _simplified(kind: str, operands: tuple[Formula, ...]) -> Formula | None:
    """A smaller or faster formula of the same value, to rounding, for all finite operands; None if no rule applies."""
    rule = _RULES.get(kind)
    return rule(*operands) if rule else None


def _negate(a: Formula) -> Formula | None:
    if a.kind == "negate":
        return a.operands[0]
    if a.kind == "subtract":
        return a.operands[1] - a.operands[0]
    if a.kind == "multiply" and CONSTANT in (factor.kind for factor in a.operands):
        return apply("multiply", *(-factor if factor.kind == CONSTANT else factor for factor in a.operands))
    return None


def _abs(a: Formula) -> Formula | None:
    if a.kind == "negate":
        return abs(a.operands[0])
    return a if a.kind in ("abs", "sqrt", "exp") or _is_square(a) else None


def _sqrt(a: Formula) -> Formula | None:
    return abs(a.operands[0]) if _is_square(a) else None


def _is_square(a: Formula) -> bool:
    return a.kind == "multiply" and a.operands[0] is a.operands[1]


def _add(a: Formula, b: Formula) -> Formula | None:
    if _is(a, 0.0):
        return b
    if _is(b, 0.0):
        return a
    if b.kind == "negate":
        return a - b.operands[0]
    return b - a.operands[0] if a.kind == "negate" else None


def _subtract(a: Formula, b: Formula) -> Formula | None:
    if _is(b, 0.0):
        return a
    if _is(a, 0.0):
        return -b
    if a is b:
        return constant(0.0)
    return a + b.operands[0] if b.kind == "negate" else None


def _multiply(a: Formula, b: Formula) -> Formula | None:
    for factor, other in ((a, b), (b, a)):
        if _is(factor, -1.0) and not _numbers_may_change.get():
            return -other
        if factor.kind == CONSTANT and factor.value in (0.0, 1.0):
            return factor if factor.value == 0.0 else other
        if factor.kind == "negate":
            return -(factor.operands[0] * other)
    return None


def _divide(a: Formula, b: Formula) -> Formula | None:
    if a.kind == "negate":
        return -(a.operands[0] / b)
    if b.kind == "negate":
        return -(a / b.operands[0])
    if _is(b, 1.0):
        return a
    if (
        b.kind == CONSTANT
        and math.frexp(b.value)[0] in (0.5, -0.5)
        and 2.0**-1000 < abs(b.value) < 2.0**1000
        and not _numbers_may_change.get()
    ):
        return a * (1.0 / b.value)  # exact
    return None


def _power(a: Formula, exponent: Formula) -> Formula | None:
    if exponent.kind != CONSTANT:
        return None
    n = exponent.value
    if _numbers_may_change.get() and n not in (0.0, 1.0):
        return None
    if n == 0.5:
        return apply("sqrt", a)
    if n != math.floor(n) or abs(n) > _MOST_FACTORS:
        return None
    if n < 0.0:
        return 1.0 / apply("power", a, -n)
    product, square = constant(1.0), a
    for bit in reversed(f"{int(n):b}"):
        product = product * square if bit == "1" else product
        square = square * square
    return product


def _extremum(kind: str, opposite: str) -> Callable:
    meaning = OPERATIONS[kind].meaning

    def rule(a: Formula, b: Formula) -> Formula | None:
        if a is b:
            return a
        for nested, other in ((a, b), (b, a)):
            if nested.kind not in (kind, opposite):
                continue
            if other in nested.operands:
                return nested if nested.kind == kind else other
            for operand, bound in (nested.operands, nested.operands[::-1]):
                if bound.kind == other.kind == CONSTANT:
                    if nested.kind == kind:
                        return apply(kind, operand, apply(kind, bound, other))
                    if meaning(bound.value, other.value) == other.value:  # as in min(max(x, 2), 1)
                        return other
        return None

    return rule


def _select(condition: Formula, then: Formula, otherwise: Formula) -> Formula | None:
    a, b = condition.operands
    if then is otherwise:
        return then
    if a.kind == b.kind == CONSTANT:
        return then if OPERATIONS[condition.kind].meaning(a.value, b.value) else otherwise
    if (then, otherwise) == (a, b):
        return apply("minimum", a, b)
    return apply("maximum", a, b) if (then, otherwise) == (b, a) else None


_RULES: dict[str, Callable[..., Formula | None]] = {
    "negate": _negate,
    "abs": _abs,
    "sqrt": _sqrt,
    "add": _add,
    "subtract": _subtract,
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "minimum": _extremum("minimum", "maximum"),
    "maximum": _extremum("maximum", "minimum"),
    "select": _select,
}


def apply(kind: str, *operands: Formula | float) -> Formula:
    """The operation ``kind`` of ``OPERATIONS`` on formulas or numbers: folded, simplified, shared.
    Raises TypeError for wrong operands."""
    nodes = tuple(map(formula_of, operands))
    operation = OPERATIONS[kind]
    if len(nodes) != operation.arity:
        raise TypeError(f"{kind} takes {operation.arity} operands, not {len(nodes)}")
    if any((o.kind in CONDITIONS) != (kind == "select" and i == 0) for i, o in enumerate(nodes)):
        raise TypeError("a condition can only be the first operand of select, which has to be one")
    if kind not in CONDITIONS:
        if all(o.kind == CONSTANT for o in nodes):
            with np.errstate(all="ignore"):
                folded = float(operation.meaning(*(o.value for o in nodes)))
            # sqrt(-1) and the like stay as they are: an undefined value then shows when the formula is evaluated.
            if not math.isnan(folded):
                return constant(folded)
        smaller = _simplified(kind, nodes)
        if smaller is not None:
            return smaller
    return intern(kind, nodes)


def body(node: Formula) -> list[Formula]:
    """The nodes that each iteration of an ``ITERATE`` node computes, in order. Its captures are known by then (as its
    operands)."""
    loop = node.value
    known = set(node.operands[1 + len(loop.steps) :])
    return [n for n in order(*loop.roots(), known=known) if n not in known]


def order(*formulas: Formula, known: Set[Formula] = frozenset()) -> list[Formula]:
    """Every node of the graph once, operands before the nodes that use them; the last formula comes last.

    The bodies of loops are not included. Operands of ``known`` nodes are left out, unless other nodes use them.
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
    """Minimum length of a parameter array for the formula."""
    return 1 + max((node.value for node in order(formula) if node.kind == PARAMETER), default=-1)
