# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The values of an expression: numbers, fields, vectors of them, conditions and shapes.

A *number* is a float, or a ``Live`` one if it follows a parameter of the expression. A *field* is a ``Formula``: a
number at each point. Both are *scalars*; a vector is a tuple of two or three scalars.

All computation goes through ``compute``. Numbers alone are computed at once. When they meet a field, floats become
constants of the formula, and ``Live`` numbers become its parameters, so the formula stays the same when they change.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ..graph import formula
from ..graph.formula import CONSTANT, Formula
from ..graph.operations import OPERATIONS
from .resolver import NoResolver, Resolver
from .shapes.base import Parametric, Slots
from .shapes.profiles import Profile


class Misuse(Exception):
    """A function got a value that it does not accept. Has the mistake in half a sentence, and the cure."""

    def __init__(self, problem: str, cure: str):
        super().__init__(problem)
        self.cure = cure


class NeedsNumber(Misuse):
    """A field was given where a number is needed."""


MOST_STEPS = 10_000
MOST_OPERATIONS = 20_000  # that a field takes at each point


class Work(Slots):
    """The slots of an expression, and its work so far: all work is announced here before it is done.

    ``rounds`` is how often a loop of the formula that is being made runs, times that of the loop around it, and so on.
    The first ``inputs`` slots are not numbers: they stand for what is known only where the formula is read. Raises
    ``Misuse`` where there is too much. ``resolver`` gives the shapes that data make.
    """

    def __init__(self, resolver: Resolver | None = None):
        super().__init__()
        self.steps = self.operations = 0
        self.rounds = 1
        self.inputs = 0
        self.resolver: Resolver = resolver or NoResolver()

    def input(self) -> Formula:
        """A further input, before any number has a slot."""
        self.inputs += 1
        return self(0.0)

    def step(self, count: int = 1) -> None:
        """Count steps of about five microseconds."""
        self.steps += count
        if self.steps > MOST_STEPS:
            raise Misuse("the expression takes too many steps", "use fewer rounds, or fewer parts")

    def operate(self, count: int) -> None:
        """Count operations added to a formula."""
        self.step(6 * count)
        self.operations += count * self.rounds
        if self.operations > MOST_OPERATIONS:
            raise Misuse("the field takes too many operations at each point", "use fewer rounds")


class Live(float):
    """A number that changes with the parameters of the expression.

    ``greatest`` is its maximum, infinite if none is declared. ``slot`` is its slot in the formulas of the expression,
    once it has one.
    """

    __slots__ = ("greatest", "slot")

    greatest: float
    slot: Formula | None

    def __new__(cls, value: float, greatest: float = math.inf):
        made = super().__new__(cls, value)
        made.greatest, made.slot = greatest, None
        return made

    def formula(self, slots: Slots) -> Formula:
        """The parameter for the number; it has one slot."""
        if self.slot is None:
            self.slot = slots(float(self))
        return self.slot


Scalar = float | Formula
Vector = tuple[Scalar, ...]


class Condition(NamedTuple):
    """``truth`` is 1.0 or 0.0 if it is the same at every point, else a comparison as a formula."""

    truth: Scalar

    def formula(self, slots: Work) -> Formula:
        """As a comparison."""
        if isinstance(self.truth, Formula):
            return self.truth
        return formula.apply("less", 0.5, self.truth.formula(slots) if isinstance(self.truth, Live) else self.truth)


def kind_of(value) -> str:
    """The word for a value in messages."""
    if isinstance(value, tuple):
        return "condition" if isinstance(value, Condition) else "vector"
    if isinstance(value, Parametric):
        return "profile" if isinstance(value, Profile) else "shape"
    if isinstance(value, str):
        return "text"
    return "number" if isinstance(value, float) else "field"


def components(value) -> tuple:
    """The scalars of a scalar or vector."""
    return value if isinstance(value, tuple) else (value,)


def is_live(value) -> bool:
    """Whether a value changes with the parameters of the expression."""
    return isinstance(value, Live) or isinstance(value, tuple) and any(isinstance(c, Live) for c in value)


def has_field(value) -> bool:
    """Whether a value differs from point to point."""
    return isinstance(value, Formula) or isinstance(value, tuple) and any(isinstance(c, Formula) for c in value)


def _map(function: Callable, value):
    if isinstance(value, tuple):
        return type(value)(*map(function, value)) if isinstance(value, Condition) else tuple(map(function, value))
    return function(value)


def lifted(value, slots: Work):
    """A value with parameters of a formula instead of numbers that change."""
    return _map(lambda scalar: scalar.formula(slots) if isinstance(scalar, Live) else scalar, value)


def settled(value):
    """A value with numbers instead of formulas that turned out constant."""
    if type(value) is Formula:
        return value.value if value.kind == CONSTANT else value
    return _map(settled, value) if isinstance(value, tuple) else value


def live(value):
    """A value that counts as changing with the parameters."""
    return _map(lambda scalar: Live(scalar) if type(scalar) is float else scalar, value)


def compute(slots: Work, function: Callable, *values):
    """Apply ``function`` to values. Scalars in them are all floats, or formulas and floats."""
    fields = follows = False
    for value in values:
        for scalar in value if isinstance(value, tuple) else (value,):
            kind = type(scalar)
            fields = fields or kind is Formula
            follows = follows or kind is Live
    if fields:
        return settled(function(*((lifted(value, slots) for value in values) if follows else values)))
    return live(function(*values)) if follows else function(*values)


def spread(function: Callable, *values):
    """Apply ``function`` to scalars, and to vectors component by component.

    A scalar applies to each component. Raises ``Misuse`` for vectors of different length.
    """
    sizes = {len(value) for value in values if isinstance(value, tuple)}
    if not sizes:
        return function(*values)
    if len(sizes) > 1:
        raise Misuse("vectors of two and of three components cannot be combined", "use one kind, as in p.xy or p")
    columns = [value if isinstance(value, tuple) else (value,) * max(sizes) for value in values]
    return tuple(function(*scalars) for scalars in zip(*columns))


# -- arithmetic of scalars: of floats, or of formulas and floats ------------------------------------------------------


def _operation(kind: str) -> Callable:
    meaning = OPERATIONS[kind].meaning

    def run(*operands: Scalar) -> Scalar:
        if any(isinstance(operand, Formula) for operand in operands):
            return formula.apply(kind, *operands)
        return float(meaning(*operands))

    run.__doc__ = f"The operation {kind!r} of formulas, on scalars."
    return run


absolute, sqrt, sin, cos, tan, asin, acos, atan, exp, log, floor, power, atan2, minimum, maximum = map(
    _operation,
    (
        "abs",
        "sqrt",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "exp",
        "log",
        "floor",
        "power",
        "atan2",
        "minimum",
        "maximum",
    ),
)


def less(a: Scalar, b: Scalar) -> Condition:
    """The condition a < b."""
    truth = a < b
    return Condition(truth if isinstance(truth, Formula) else float(truth))


def less_equal(a: Scalar, b: Scalar) -> Condition:
    """The condition a ≤ b."""
    truth = a <= b
    return Condition(truth if isinstance(truth, Formula) else float(truth))


def choose(slots: Work, condition: Condition, then, otherwise):
    """``then`` where the condition holds, else ``otherwise``: values of one kind, or scalars and vectors."""
    truth = condition.truth
    if isinstance(then, (Parametric, str)) or isinstance(otherwise, (Parametric, str)):
        if isinstance(truth, Formula):
            raise Misuse(
                f"a condition on the point cannot choose between {kind_of(then)}s",
                "choose between their fields, as in select(p.x > 0, a(p), b(p))",
            )
        return then if truth > 0.5 else otherwise
    if type(truth) is float:
        return then if truth > 0.5 else otherwise
    if isinstance(then, Condition) != isinstance(otherwise, Condition):
        raise Misuse(f"one side is a {kind_of(then)}, the other a {kind_of(otherwise)}", "make both sides of one kind")
    if isinstance(then, Condition):
        one, other = (choose(slots, c, 1.0, 0.0) for c in (then, otherwise))
        chosen = choose(slots, condition, one, other)
        return Condition(chosen if isinstance(chosen, float) else formula.apply("less", 0.5, chosen))

    def scalar(test: Scalar, a: Scalar, b: Scalar) -> Scalar:
        if isinstance(test, float) and not isinstance(a, Formula) and not isinstance(b, Formula):
            return Live(a if test > 0.5 else b)
        return settled(formula.select(Condition(test).formula(slots), lifted(a, slots), lifted(b, slots)))

    return spread(scalar, truth, then, otherwise)
