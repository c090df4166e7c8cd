# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of the expression language: every shape by name, transforms, and the mathematics of numbers and vectors.

``FUNCTIONS`` and ``CONSTANTS`` are all that an expression can reach. A value is a float, a vector (3-tuple of floats)
or a ``Shape``; a word is a Python function whose annotations say which of them it takes.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .shapes import SHAPES, Shape, Transformed
from .shapes.operators import SetOperation

Vec3 = tuple[float, float, float]
Value = "float | Vec3"

REQUIRED = object()


class Misuse(Exception):
    """A function was called with something it does not take; says what in half a sentence, and the cure."""

    def __init__(self, problem: str, cure: str):
        super().__init__(problem)
        self.cure = cure


class Argument(NamedTuple):
    name: str
    kind: str  # "number", "vector", "value" (number or vector) or "shape"
    default: Any = REQUIRED


class Function(NamedTuple):
    """A word of the language. ``variadic``: the last argument may be given any number of times."""

    name: str
    group: str
    arguments: tuple[Argument, ...]
    call: Callable
    description: str
    variadic: bool = False
    usage: str = ""  # where the arguments do not say it well

    def signature(self) -> str:
        """As in ``torus(major_radius=0.5, minor_radius=0.175)``."""
        if self.usage:
            return self.usage
        shown = [a.name if a.default is REQUIRED else f"{a.name}={show(a.default)}" for a in self.arguments]
        return f"{self.name}({', '.join(shown)}{', …' if self.variadic else ''})"

    def __call__(self, positional: list, named: dict[str, Any]):
        """The result for the given values. Raises ``Misuse``."""
        if self.variadic:
            if named:
                raise Misuse(f"{self.name} takes no named arguments", f"write {self.signature()}")
            last = self.arguments[-1]
            fixed = [self._converted(a, v) for a, v in zip(self.arguments, positional)]
            if len(fixed) < len(self.arguments):
                raise self._wrong_count(positional)
            return self.call(*fixed, *(self._converted(last, v) for v in positional[len(fixed):]))
        given = self._bound(self._gathered(positional), named)
        return self.call(**{a.name: self._converted(a, given[a.name]) for a in self.arguments})

    def _gathered(self, positional: list) -> list:
        """``positional`` with three numbers in a row made one vector, where there are more values than arguments."""
        if len(positional) <= len(self.arguments):
            return positional
        gathered, rest = [], list(positional)
        for argument in self.arguments:
            if argument.kind == "vector" and len(rest) >= 3 and all(isinstance(v, float) for v in rest[:3]):
                gathered.append(tuple(rest[:3]))
                del rest[:3]
            elif rest:
                gathered.append(rest.pop(0))
        if rest:
            raise self._wrong_count(positional)
        return gathered

    def _bound(self, positional: list, named: dict[str, Any]) -> dict[str, Any]:
        given = {a.name: v for a, v in zip(self.arguments, positional)}
        for name, value in named.items():
            if name not in {a.name for a in self.arguments}:
                raise Misuse(f"{self.name} has no argument {name:.40}", f"write {self.signature()}")
            if name in given:
                raise Misuse(f"{self.name} gets {name} twice", f"write {self.signature()}")
            given[name] = value
        for argument in self.arguments:
            if argument.name not in given:
                if argument.default is REQUIRED:
                    raise Misuse(f"{self.name} needs {argument.name}", f"write {self.signature()}")
                given[argument.name] = argument.default
        return given

    def _converted(self, argument: Argument, value):
        if kind_of(value) == argument.kind or argument.kind == "value" and kind_of(value) in ("number", "vector"):
            return value
        if argument.kind == "vector" and isinstance(value, float):
            return (value,) * 3
        wanted = {"value": "a number or a vector", "vector": "a vector or a number"}.get(
            argument.kind, f"a {argument.kind}")
        raise Misuse(f"{argument.name} of {self.name} must be {wanted}, not a {kind_of(value)}",
                     f"write {self.signature()}")

    def _wrong_count(self, positional: list) -> Misuse:
        return Misuse(f"{self.name} does not take {len(positional)} values", f"write {self.signature()}")


def kind_of(value) -> str:
    return "number" if isinstance(value, float) else "vector" if isinstance(value, tuple) else "shape"


def show(value) -> str:
    """A value as one writes it in an expression."""
    return f"{value:g}" if isinstance(value, float) else f"vec3({', '.join(f'{v:g}' for v in value)})"


CONSTANTS = {"pi": math.pi, "tau": math.tau, "e": math.e}

FUNCTIONS: dict[str, Function] = {}

_KINDS = {"float": "number", "Vec3": "vector", "Value": "value", "Shape": "shape"}


def _word(group: str):
    """Decorator: adds a function to the language, under its name without a trailing underscore."""

    def add(function):
        signature = inspect.signature(function)
        arguments = tuple(
            Argument(p.name, _KINDS[p.annotation], REQUIRED if p.default is p.empty else p.default)
            for p in signature.parameters.values())
        variadic = any(p.kind is p.VAR_POSITIONAL for p in signature.parameters.values())
        name = function.__name__.rstrip("_")
        FUNCTIONS[name] = Function(name, group, arguments, function, inspect.getdoc(function), variadic)
        return function

    return add


def _add_shape(name: str, shape: type[Shape]) -> None:
    if issubclass(shape, SetOperation):
        FUNCTIONS[name] = Function(
            name, "Combinations", (Argument("shape", "shape"),), shape, inspect.getdoc(shape), variadic=True)
    else:
        arguments = tuple(
            Argument(f.name, "vector" if f.size == 3 else "number", f.default) for f in shape.fields())
        FUNCTIONS[name] = Function(name, "Shapes", arguments, shape, inspect.getdoc(shape))


for _name, _shape in SHAPES.items():
    _add_shape(_name, _shape)


# -- transforms -------------------------------------------------------------------------------------------------------


def _transformed(shape: Shape, linear: np.ndarray, offset: Vec3 = (0.0, 0.0, 0.0)) -> Shape:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = offset
    return Transformed(shape, matrix)


def _rotation(axis: np.ndarray, degrees: float) -> np.ndarray:
    """Rodrigues' formula for a unit axis, counter-clockwise as seen from its tip."""
    angle = math.radians(degrees)
    x, y, z = axis
    crossed = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    return np.eye(3) + math.sin(angle) * crossed + (1.0 - math.cos(angle)) * crossed @ crossed


@_word("Transforms")
def translate(shape: Shape, offset: Vec3):
    """The shape moved by an offset in metres."""
    return _transformed(shape, np.eye(3), offset)


@_word("Transforms")
def rotate(shape: Shape, degrees: Value, axis: Vec3 = (0.0, 0.0, 1.0)):
    """The shape turned about an axis through the origin, counter-clockwise as seen from the tip of the axis.

    With a vector of three angles: about x, then y, then z, as Blender's XYZ Euler rotation; axis is not used then.
    """
    if isinstance(degrees, tuple):
        about = [_rotation(unit, angle) for unit, angle in zip(np.eye(3), degrees)]
        return _transformed(shape, about[2] @ about[1] @ about[0])
    norm = math.hypot(*axis)
    if norm == 0.0:
        raise Misuse("the axis of rotate has no direction", "give an axis other than vec3(0, 0, 0)")
    return _transformed(shape, _rotation(np.divide(axis, norm), degrees))


@_word("Transforms")
def scale(shape: Shape, factor: Vec3):
    """The shape stretched from the origin: one factor, or one each along x, y and z. A negative factor mirrors."""
    return _transformed(shape, np.diag(factor))


# -- numbers and vectors ----------------------------------------------------------------------------------------------


FUNCTIONS["vec3"] = Function(
    "vec3", "Numbers and vectors", (Argument("xyz", "vector"),), lambda xyz: xyz,
    "A vector of three numbers, or of the same number three times: `vec3(1)`. `(x, y, z)` is one too.",
    usage="vec3(x, y, z)")


def apply(function: Callable, *values: float | Vec3) -> float | Vec3:
    """``function`` of floats applied to numbers, and to vectors component by component."""
    if not any(isinstance(value, tuple) for value in values):
        return float(function(*values))
    columns = [value if isinstance(value, tuple) else (value,) * 3 for value in values]
    return tuple(float(function(*components)) for components in zip(*columns))


def _componentwise(name: str, function: Callable, description: str, *arguments: str, variadic: bool = False) -> None:
    FUNCTIONS[name] = Function(
        name, "Numbers and vectors", tuple(Argument(a, "value") for a in arguments),
        lambda *values, **named: apply(function, *values, *named.values()), description, variadic)


_componentwise("sin", math.sin, "Sine of an angle in radians.", "angle")
_componentwise("cos", math.cos, "Cosine of an angle in radians.", "angle")
_componentwise("tan", math.tan, "Tangent of an angle in radians.", "angle")
_componentwise("asin", math.asin, "Angle in radians whose sine is the value.", "value")
_componentwise("acos", math.acos, "Angle in radians whose cosine is the value.", "value")
_componentwise("atan", math.atan, "Angle in radians whose tangent is the value.", "value")
_componentwise("atan2", math.atan2, "Angle in radians of the point (x, y).", "y", "x")
_componentwise("radians", math.radians, "Degrees as radians.", "degrees")
_componentwise("degrees", math.degrees, "Radians as degrees.", "radians")
_componentwise("sqrt", math.sqrt, "Square root.", "value")
_componentwise("exp", math.exp, "e to the power of the value.", "value")
_componentwise("log", math.log, "Natural logarithm.", "value")
_componentwise("pow", math.pow, "Base to the power of the exponent, also written `base ** exponent`.",
               "base", "exponent")
_componentwise("abs", abs, "The value without its sign.", "value")
_componentwise("sign", lambda a: (a > 0.0) - (a < 0.0), "−1, 0 or 1.", "value")
_componentwise("floor", math.floor, "The next whole number below.", "value")
_componentwise("ceil", math.ceil, "The next whole number above.", "value")
_componentwise("fract", lambda a: a - math.floor(a), "What is left above the next whole number below.", "value")
_componentwise("mod", lambda a, b: a - b * math.floor(a / b),
               "Remainder with the sign of the divisor, also written `value % divisor`.", "value", "divisor")
_componentwise("min", min, "The least value.", "value", variadic=True)
_componentwise("max", max, "The greatest value.", "value", variadic=True)
_componentwise("clamp", lambda a, low, high: min(max(a, low), high), "The value held between two limits.",
               "value", "low", "high")
_componentwise("mix", lambda a, b, t: a + (b - a) * t, "From a (at t = 0) to b (at t = 1) on a straight line.",
               "a", "b", "t")


@_word("Numbers and vectors")
def dot(a: Vec3, b: Vec3):
    """Dot product."""
    return math.fsum(x * y for x, y in zip(a, b))


@_word("Numbers and vectors")
def cross(a: Vec3, b: Vec3):
    """Cross product."""
    return tuple(np.cross(a, b).tolist())


@_word("Numbers and vectors")
def length(vector: Vec3):
    """Length of a vector."""
    return math.hypot(*vector)


@_word("Numbers and vectors")
def normalize(vector: Vec3):
    """The vector of length 1 in the same direction."""
    norm = math.hypot(*vector)
    if norm == 0.0:
        raise Misuse("a vector of length 0 has no direction", "normalize another vector")
    return tuple(component / norm for component in vector)
