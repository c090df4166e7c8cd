# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A function of the expression language: a Python function whose annotations give the kinds of its arguments.

An expression can reach only ``FUNCTIONS`` and ``CONSTANTS``. The functions are in ``builtin_shapes``,
``builtin_numbers`` and ``builtin_colors``; ``expression_values`` describes the values.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from ..graph import formula
from ..graph.formula import Formula
from .expression_values import Misuse, NeedsNumber, Work, compute, has_field, kind_of, spread
from .shapes import Box, Field, Shape
from .shapes.base import Parametric

REQUIRED = object()

DATA_WORDS = "Texts, Objects and Pictures"
SHAPE_GROUPS = ("Shapes", DATA_WORDS, "Profiles", "Solids from Profiles", "Combinations", "Operators", "Transforms")

# The kinds of arguments, and their words in messages. Those of the first group must be numbers, not fields.
_WANTED = {
    "number": "a number",
    "angle": "a number of degrees",
    "numbers": "a vector of three numbers or a number",
    "angles": "a vector of three numbers of degrees or one for all",
    "scalar": "a number or a field",
    "vector": "a vector",
    "vector3": "a vector of three components",
    "value": "a number, a field or a vector",
    "condition": "a condition such as a < b",
    "shape": "a shape",
    "profile": "a profile such as circle(0.5)",
    "corner": "a vector of two numbers",
    "text": "a text in quotes",
    "any": "a value",
}
_ANGLES = ("angle", "angles")

# Labels of user interfaces that differ from the names of arguments: an expression accepts both.
SYNONYMS = {"iterations": "rounds", "exponent": "power"}


def _map(function: Callable, value):
    return tuple(map(function, value)) if isinstance(value, tuple) else function(value)


class Argument(NamedTuple):
    """``default`` is the value that the function gets; for an angle it is in radians, although artists give degrees."""

    name: str
    kind: str  # a key of _WANTED
    default: Any = REQUIRED

    def signature(self) -> str:
        """As in ``name`` or ``name=default``, with angles in degrees."""
        if self.default is REQUIRED:
            return self.name
        return f"{self.name}={show(_map(math.degrees, self.default) if self.kind in _ANGLES else self.default)}"


class Function(NamedTuple):
    """A function of the language.

    ``call(slots, …)`` gets the slots of the expression and one value for each argument. ``variadic``: the first
    argument may occur any number of times. ``cost`` is the rough number of operations for a field, or for each
    component. ``other`` is the function for values that are no shapes, if one name serves for both.
    """

    name: str
    group: str
    arguments: tuple[Argument, ...]
    call: Callable
    description: str
    variadic: bool = False
    usage: str = ""  # if the arguments do not show it well
    cost: int = 1
    other: "Function | None" = None

    def signature(self) -> str:
        """As in ``torus(major_radius=0.5, minor_radius=0.175)``."""
        if self.usage:
            return self.usage
        shown = [argument.signature() for argument in self.arguments]
        return f"{self.name}({', '.join(shown[:1] + ['…'] * self.variadic + shown[1:])})"

    @property
    def makes_shape(self) -> bool:
        """Whether its result is a shape."""
        return self.group in SHAPE_GROUPS

    def __call__(self, slots: Work, positional: list, named: dict[str, Any]):
        """The result for the given values. Raises ``Misuse``."""
        if self.other is not None and positional and not isinstance(positional[0], Parametric):
            return self.other(slots, positional, named)
        repeated, given = self.bound(positional, named)
        return self.call(
            slots,
            *(self._converted(self.arguments[0], value, slots) for value in repeated),
            *(self._converted(a, given[a.name], slots) if a.name in given else a.default for a in self._single),
        )

    @property
    def _single(self) -> tuple[Argument, ...]:
        """Arguments that take one value each."""
        return self.arguments[self.variadic :]

    def bound(self, positional: list, named: dict[str, Any]) -> tuple[list, dict[str, Any]]:
        """The values of the variadic argument, and those of the others by name.

        Three numbers in a row become a vector if one is needed. Raises ``Misuse``.
        """
        repeated: list = []
        if self.variadic:
            if named and len(self.arguments) == 1:
                raise Misuse(f"{self.name} takes no named arguments", f"write {self.signature()}")
            repeated, positional = self._repeated(positional)
        return repeated, self._bound(self._gathered(positional, self._single), named, self._single)

    def _repeated(self, positional: list) -> tuple[list, list]:
        """Values of the first argument, and the values after them."""
        rest = self._single
        count = len(positional)
        if rest:
            numbers = [isinstance(value, float) for value in positional]
            count = numbers.index(True) if True in numbers else count
        if not count:
            raise self._wrong_count(positional)
        return [*positional[:count]], positional[count:]

    def _gathered(self, positional: list, arguments: tuple[Argument, ...]) -> list:
        """``positional`` with three numbers in a row joined to one vector, if there are more values than arguments."""
        if len(positional) <= len(arguments):
            return positional
        gathered, rest = [], list(positional)
        for argument in arguments:
            if (
                argument.kind in ("numbers", "angles", "vector", "vector3")
                and len(rest) >= 3
                and all(kind_of(v) in ("number", "field") for v in rest[:3])
            ):
                gathered.append(tuple(rest[:3]))
                del rest[:3]
            elif rest:
                gathered.append(rest.pop(0))
        if rest:
            raise self._wrong_count(positional)
        return gathered

    def _bound(self, positional: list, named: dict[str, Any], arguments: tuple[Argument, ...]) -> dict[str, Any]:
        given = {a.name: v for a, v in zip(arguments, positional)}
        known = {a.name for a in arguments}
        for name, value in named.items():
            if name not in known and SYNONYMS.get(name) in known:
                name = SYNONYMS[name]
            if name not in known:
                raise Misuse(f"{self.name} has no argument {name:.40}", f"write {self.signature()}")
            if name in given:
                raise Misuse(f"{self.name} gets {name} twice", f"write {self.signature()}")
            given[name] = value
        for argument in arguments:
            if argument.name not in given and argument.default is REQUIRED:
                raise Misuse(f"{self.name} needs {argument.name}", f"write {self.signature()}")
        return given

    def _converted(self, argument: Argument, value, slots: Work):
        kind, wanted = kind_of(value), argument.kind
        if wanted in ("number", "angle", "numbers", "angles", "corner"):
            if has_field(value):
                raise NeedsNumber(
                    f"{argument.name} of {self.name} differs from point to point, but must be a number",
                    "give it a number, or write the field of the shape with p yourself",
                )
            given = _map(math.radians, value) if wanted in _ANGLES else value
            if kind == "number" and wanted != "corner":
                return (given,) * 3 if wanted in ("numbers", "angles") else given
            if kind == "vector" and (wanted == "corner" or wanted in ("numbers", "angles") and len(value) == 3):
                return given
        elif (
            wanted == "any"
            or wanted == kind
            or wanted == "scalar"
            and kind in ("number", "field")
            or (wanted == "value" and kind in ("number", "field", "vector"))
        ):
            return value
        elif wanted == "vector3" and kind == "vector" and len(value) == 3:
            return value
        elif wanted in ("vector", "vector3") and kind in ("number", "field"):
            return (value,) * 3
        elif wanted == "shape" and kind == "field":
            return as_shape(value, slots)
        raise Misuse(
            f"{argument.name} of {self.name} must be {_WANTED[wanted]}, not a {kind}", f"write {self.signature()}"
        )

    def _wrong_count(self, positional: list) -> Misuse:
        return Misuse(f"{self.name} does not take {len(positional)} values", f"write {self.signature()}")


def show(value) -> str:
    """A value as one writes it in an expression."""
    if isinstance(value, str):
        return f'"{value}"'
    return f"{value:g}" if isinstance(value, float) else f"vec3({', '.join(f'{v:g}' for v in value)})"


CONSTANTS = {"pi": math.pi, "tau": math.tau, "e": math.e}

FUNCTIONS: dict[str, Function] = {}

MATHEMATICS, POINTS, COLOURS = "Numbers, fields and vectors", "Points", "Colours"
GROUPS = (*SHAPE_GROUPS, "Fields", MATHEMATICS, POINTS, COLOURS)
"""Titles of the groups of functions, in a natural order."""

_KINDS = {
    "float": "number",
    "Vec3": "numbers",
    "Scalar": "scalar",
    "Vector": "vector",
    "Vector3": "vector3",
    "Value": "value",
    "Condition": "condition",
    "Shape": "shape",
    "Any": "any",
}


def add(function: Function) -> None:
    """Adds a function. One name can serve for shapes and for other values."""
    there = FUNCTIONS.get(function.name)
    if there is not None:
        shape, other = (there, function) if there.makes_shape else (function, there)
        function = shape._replace(other=other)
    FUNCTIONS[function.name] = function


def word(group: str, usage: str = "", cost: int = 1):
    """Decorator: adds a function to the language, under its name without a trailing underscore.

    If its first argument is ``slots``, it gets those of the expression. Otherwise it is computed with formulas or
    floats.
    """

    def wrap(function):
        signature = inspect.signature(function)
        named = list(signature.parameters.values())
        raw = named[0].name == "slots"
        arguments = tuple(
            Argument(p.name, _KINDS[p.annotation], REQUIRED if p.default is p.empty else p.default) for p in named[raw:]
        )
        variadic = any(p.kind is p.VAR_POSITIONAL for p in named)
        call = function if raw else lambda slots, *given: compute(slots, function, *given)
        add(
            Function(
                function.__name__.rstrip("_"),
                group,
                arguments,
                call,
                inspect.getdoc(function) or "",
                variadic,
                usage,
                cost,
            )
        )
        return function

    return wrap


def spread_word(
    name: str, function: Callable, description: str, *arguments: str, variadic: bool = False, cost: int = 1
) -> None:
    """Adds a function of scalars, which works on the components of vectors one by one."""
    add(
        Function(
            name,
            MATHEMATICS,
            tuple(Argument(a, "value") for a in arguments),
            lambda slots, *given: spread(lambda *scalars: compute(slots, function, *scalars), *given),
            description,
            variadic,
            cost=cost,
        )
    )


def of_shape(value: Formula, slots: Work) -> Formula:
    """A field that becomes part of a shape. Raises ``NeedsNumber`` if it belongs to one iteration of a loop."""
    nodes = formula.order(value)
    slots.operate(len(nodes))
    if any(node.kind == formula.PARAMETER and node.value < slots.inputs for node in nodes):
        raise Misuse("a shape cannot depend on the depth or the height", "make it of the point p")
    if any(node.kind == formula.STATE for node in nodes):
        raise NeedsNumber(
            "a shape cannot differ from round to round of a loop of fields", "combine the fields with min and max"
        )
    return value


def as_shape(value, slots: Work, cut: Box | None = None) -> Shape:
    """A shape, or the one inside which a field is negative, cut to a box if one is given.

    Raises ``Misuse`` for anything else.
    """
    if isinstance(value, Shape):
        return value
    if isinstance(value, Formula):
        return Field.of(of_shape(value, slots), slots.values, cut)
    raise Misuse(f"a {kind_of(value)} is not a shape", "give it a shape, or a field that is negative inside")
