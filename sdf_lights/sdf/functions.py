# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of the expression language: every shape by name, transforms, and the mathematics of numbers and fields.

``FUNCTIONS`` and ``CONSTANTS`` are all that an expression can reach. A word is a Python function whose annotations say
which values it takes; what they mean is said in ``values``.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from . import formula, values
from .formula import Formula
from .noise import value_noise
from .shapes import SHAPES, Box, Field, Shape, Transformed
from .shapes.base import Parametric
from .shapes.operators import SetOperation
from .shapes.polygons import Polygon
from .shapes.profiles import PROFILES, Profile
from .values import (
    Condition, Live, Misuse, NeedsNumber, Scalar, Vector, Work, absolute, choose, compute, cos, has_field, kind_of,
    maximum, minimum, sin, spread, sqrt)

REQUIRED = object()

SHAPE_GROUPS = ("Shapes", "Profiles", "Solids from profiles", "Combinations", "Operators", "Transforms")

# What an argument can be, and how messages say so. Those of the first group have to be numbers, not fields.
_WANTED = {
    "number": "a number", "angle": "a number of degrees", "numbers": "a vector of three numbers or a number",
    "angles": "a vector of three numbers of degrees or one for all",
    "scalar": "a number or a field", "vector": "a vector", "vector3": "a vector of three components",
    "value": "a number, a field or a vector", "condition": "a condition such as a < b", "shape": "a shape",
    "profile": "a profile such as circle(0.5)", "corner": "a vector of two numbers", "any": "a value"}


_ANGLES = ("angle", "angles")


def _map(function: Callable, value):
    return tuple(map(function, value)) if isinstance(value, tuple) else function(value)


class Argument(NamedTuple):
    """``default`` is what the function is given for it: of an angle, radians, though artists give degrees."""

    name: str
    kind: str  # a key of _WANTED
    default: Any = REQUIRED

    def signature(self) -> str:
        if self.default is REQUIRED:
            return self.name
        return f"{self.name}={show(_map(math.degrees, self.default) if self.kind in _ANGLES else self.default)}"


class Function(NamedTuple):
    """A word of the language.

    ``call(slots, …)`` gets the slots of the expression and one value for each argument. ``variadic``: the first
    argument may be given any number of times. ``cost`` is about how many operations it makes of a field, or of each component.
    ``other`` is the word for what is not a shape, where the name serves for both.
    """

    name: str
    group: str
    arguments: tuple[Argument, ...]
    call: Callable
    description: str
    variadic: bool = False
    usage: str = ""  # where the arguments do not say it well
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
        return self.group in SHAPE_GROUPS

    def __call__(self, slots: Work, positional: list, named: dict[str, Any]):
        """The result for the given values. Raises ``Misuse``."""
        if self.other is not None and positional and not isinstance(positional[0], Parametric):
            return self.other(slots, positional, named)
        repeated, arguments = [], self.arguments
        if self.variadic:
            if named and len(arguments) == 1:
                raise Misuse(f"{self.name} takes no named arguments", f"write {self.signature()}")
            repeated, positional, arguments = self._repeated(positional)
        positional = self._gathered(positional, arguments)
        given = self._bound(positional, named, arguments)
        return self.call(
            slots, *(self._converted(self.arguments[0], value, slots) for value in repeated),
            *(self._converted(a, given[a.name], slots) if a.name in given else a.default for a in arguments))

    def _repeated(self, positional: list) -> tuple[list, list, tuple[Argument, ...]]:
        """Values of the first argument, the values after them, and the arguments that those are for."""
        first, rest = self.arguments[0], self.arguments[1:]
        count = len(positional)
        if rest:
            numbers = [isinstance(value, float) for value in positional]
            count = numbers.index(True) if True in numbers else count
        if not count:
            raise self._wrong_count(positional)
        return [*positional[:count]], positional[count:], rest

    def _gathered(self, positional: list, arguments: tuple[Argument, ...]) -> list:
        """``positional`` with three numbers in a row made one vector, where there are more values than arguments."""
        if len(positional) <= len(arguments):
            return positional
        gathered, rest = [], list(positional)
        for argument in arguments:
            if argument.kind in ("numbers", "angles", "vector", "vector3") and len(rest) >= 3 and all(
                    kind_of(v) in ("number", "field") for v in rest[:3]):
                gathered.append(tuple(rest[:3]))
                del rest[:3]
            elif rest:
                gathered.append(rest.pop(0))
        if rest:
            raise self._wrong_count(positional)
        return gathered

    def _bound(self, positional: list, named: dict[str, Any], arguments: tuple[Argument, ...]) -> dict[str, Any]:
        given = {a.name: v for a, v in zip(arguments, positional)}
        for name, value in named.items():
            if name not in {a.name for a in arguments}:
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
                raise NeedsNumber(f"{argument.name} of {self.name} differs from point to point, but must be a number",
                                  "give it a number, or write the field of the shape with p yourself")
            given = _map(math.radians, value) if wanted in _ANGLES else value
            if kind == "number" and wanted != "corner":
                return (given,) * 3 if wanted in ("numbers", "angles") else given
            if kind == "vector" and (wanted == "corner" or wanted in ("numbers", "angles") and len(value) == 3):
                return given
        elif wanted == "any" or wanted == kind or wanted == "scalar" and kind in ("number", "field") or (
                wanted == "value" and kind in ("number", "field", "vector")):
            return value
        elif wanted == "vector3" and kind == "vector" and len(value) == 3:
            return value
        elif wanted in ("vector", "vector3") and kind in ("number", "field"):
            return (value,) * 3
        elif wanted == "shape" and kind == "field":
            return as_shape(value, slots)
        raise Misuse(f"{argument.name} of {self.name} must be {_WANTED[wanted]}, not a {kind}",
                     f"write {self.signature()}")

    def _wrong_count(self, positional: list) -> Misuse:
        return Misuse(f"{self.name} does not take {len(positional)} values", f"write {self.signature()}")


def show(value) -> str:
    """A value as one writes it in an expression."""
    return f"{value:g}" if isinstance(value, float) else f"vec3({', '.join(f'{v:g}' for v in value)})"


CONSTANTS = {"pi": math.pi, "tau": math.tau, "e": math.e}

FUNCTIONS: dict[str, Function] = {}

MATHEMATICS, POINTS = "Numbers, fields and vectors", "Points"
GROUPS = (*SHAPE_GROUPS, "Fields", MATHEMATICS, POINTS)
"""Of words, in the order in which one looks for them."""

_KINDS = {"float": "number", "Vec3": "numbers", "Scalar": "scalar", "Vector": "vector", "Vector3": "vector3",
          "Value": "value", "Condition": "condition", "Shape": "shape", "Any": "any"}


def _add(function: Function) -> None:
    shape = FUNCTIONS.get(function.name)
    FUNCTIONS[function.name] = function if shape is None else shape._replace(other=function)


def _word(group: str, usage: str = "", cost: int = 1):
    """Decorator: adds a function to the language, under its name without a trailing underscore.

    One whose first argument is ``slots`` gets those of the expression; others are computed with formulas or floats.
    """

    def add(function):
        signature = inspect.signature(function)
        named = list(signature.parameters.values())
        raw = named[0].name == "slots"
        arguments = tuple(
            Argument(p.name, _KINDS[p.annotation], REQUIRED if p.default is p.empty else p.default)
            for p in named[raw:])
        variadic = any(p.kind is p.VAR_POSITIONAL for p in named)
        call = function if raw else lambda slots, *given: compute(slots, function, *given)
        _add(Function(
            function.__name__.rstrip("_"), group, arguments, call, inspect.getdoc(function), variadic, usage, cost))
        return function

    return add


# -- shapes -----------------------------------------------------------------------------------------------------------


def _arguments(kind_of_shape: type[Parametric]) -> tuple[Argument, ...]:
    parts = [Argument("shape" if field.name == "child" else field.name, field.metadata["part"])
             for field in dataclasses.fields(kind_of_shape) if "part" in field.metadata]
    numbers = []
    for about in kind_of_shape.fields():
        kind = ("angle" if about.unit == "ANGLE" else "number") + "s" * (about.size == 3)
        numbers.append(Argument(about.name, kind, about.default))
    return (*parts, *numbers)


def _add_shape(name: str, shape: type[Parametric]) -> None:
    arguments = _arguments(shape)
    if issubclass(shape, SetOperation):

        def call(slots, *given):
            count = len(given) - len(arguments)
            return shape(*given[:count], **{a.name: v for a, v in zip(arguments, given[count:])})

        _add(Function(name, "Combinations", (Argument("shape", "shape"), *arguments), call, inspect.getdoc(shape),
                      variadic=True))
        return
    variadic = shape is Polygon
    if variadic:
        arguments = (Argument("point", "corner"),)
    parts = {argument.kind for argument in arguments}
    group = ("Profiles" if issubclass(shape, Profile) else "Operators" if "shape" in parts
             else "Solids from profiles" if "profile" in parts else "Shapes")
    _add(Function(name, group, arguments, lambda slots, *given: shape(*given), inspect.getdoc(shape), variadic))


_PRIMITIVE = 20  # operations of the field of a primitive, about


def as_shape(value, slots: Work, cut: Box | None = None) -> Shape:
    """A shape, or the one that a field is negative in, cut to a box if one is given.

    Raises ``Misuse`` for anything else.
    """
    if isinstance(value, Shape):
        return value
    if isinstance(value, Formula):
        nodes = formula.order(value)
        slots.operate(len(nodes))
        if any(node.kind == formula.STATE for node in nodes):
            raise NeedsNumber("a shape cannot differ from round to round of a loop of fields",
                              "combine the fields with min and max")
        return Field.of(value, slots.values, cut)
    raise Misuse(f"a {kind_of(value)} is not a shape", "give it a shape, or a field that is negative inside")


for _name, _shape in {**SHAPES, **PROFILES}.items():
    _add_shape(_name, _shape)


@_word("Fields", usage="field(value, bounds=none)")
def field(slots: Work, value: Scalar, bounds: Vec3 = (math.inf,) * 3):
    """The shape that a field is negative in.

    Its limits are found by themselves. Where that fails or takes long, give half of the size of a box around the origin
    as bounds: the shape is cut to it.
    """
    if not isinstance(value, Formula):
        raise Misuse("this field is the same at all points", "make it of the point p, as in field(length(p) - 1)")
    return as_shape(value, slots, None if math.inf in bounds else Box(bounds))


@_word("Fields", usage="distance(shape, point) or distance(a, b)")
def distance(slots: Work, shape: Any, point: Vector):
    """The field of a shape at a point, also written `shape(point)`, or the distance between two points.

    That of a profile is at a point of two components: `circle(1)(p.xy)`.
    """
    if isinstance(shape, tuple):
        return compute(slots, lambda a, b: _length(_subtract(a, b)), shape, point)
    if not isinstance(shape, Profile):
        shape = as_shape(shape, slots)
    if len(point) != (2 if isinstance(shape, Profile) else 3):
        raise Misuse("a profile has its field in the plane, a shape in space",
                     "give a profile a point of two components, as in p.xy, and a shape one of three")
    point = point if len(point) == 3 else (*point, 0.0)
    if not has_field(point):
        slots.step(4 * _PRIMITIVE * shape.size)
        return Live(shape.distance(np.array(point)))
    slots.operate(_PRIMITIVE * shape.size)
    return shape.build(formula.Vector(*map(_formula, values.lifted(point, slots))), slots)


def _formula(scalar: Scalar) -> Formula:
    return scalar if isinstance(scalar, Formula) else formula.constant(scalar)


# -- transforms -------------------------------------------------------------------------------------------------------


def _transformed(shape: Shape, linear, offset=(0.0, 0.0, 0.0)) -> Shape:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = offset
    return Transformed(shape, matrix)


def _turned(vector: Vector, axis: Vector, degrees: Scalar) -> Vector:
    """Rodrigues' formula for a unit axis, counter-clockwise as seen from its tip."""
    c, s = cos(degrees * (math.pi / 180.0)), sin(degrees * (math.pi / 180.0))
    along = _dot(axis, vector) * (1.0 - c)
    return tuple(v * c + w * s + a * along for v, w, a in zip(vector, _cross(axis, vector), axis))


def _rotated(slots: Work, what, turn: Callable, *angles):
    """A vector turned by ``turn(vector, *angles)``, or a shape by its matrix."""
    if isinstance(what, Shape):
        if any(map(has_field, angles)):
            raise NeedsNumber("a shape is turned as a whole, but the angle differs from point to point",
                              "turn the point, as in shape(rotate_z(p, 90 * p.z))")
        return _transformed(what, np.transpose([turn(tuple(unit), *angles) for unit in np.eye(3).tolist()]))
    return compute(slots, turn, what, *angles)


@_word("Transforms")
def translate(slots: Work, shape: Shape, offset: Vec3):
    """The shape moved by an offset in metres."""
    return _transformed(shape, np.eye(3), offset)


@_word("Transforms", cost=15)
def rotate(slots: Work, shape: Any, degrees: Value, axis: Vector3 = (0.0, 0.0, 1.0)):
    """The shape, or vector, turned about an axis through the origin, counter-clockwise as seen from its tip.

    With a vector of three angles: about x, then y, then z, as Blender's XYZ Euler rotation; axis is not used then. A
    vector of two components is turned in its plane.
    """
    if kind_of(shape) not in ("shape", "field", "vector"):
        raise Misuse(f"rotate turns shapes and vectors, not a {kind_of(shape)}", "write rotate(shape, degrees)")
    if isinstance(shape, Formula):
        shape = as_shape(shape, slots)
    if isinstance(shape, tuple) and len(shape) == 2:
        return _rotated(slots, (*shape, 0.0), _about(2), degrees)[:2]
    if isinstance(degrees, tuple):
        for index, angle in enumerate(degrees):
            shape = _rotated(slots, shape, _about(index), angle)
        return shape
    return _rotated(slots, shape, lambda v, a, d: _turned(v, _normalized(a), d), axis, degrees)


def _about(index: int) -> Callable:
    unit = tuple(np.eye(3)[index].tolist())
    return lambda vector, degrees: _turned(vector, unit, degrees)


@_word("Transforms", cost=15)
def rotate_x(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, turned about the x axis."""
    return rotate(slots, shape, degrees, (1.0, 0.0, 0.0))


@_word("Transforms", cost=15)
def rotate_y(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, turned about the y axis."""
    return rotate(slots, shape, degrees, (0.0, 1.0, 0.0))


@_word("Transforms", cost=15)
def rotate_z(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, turned about the z axis."""
    return rotate(slots, shape, degrees, (0.0, 0.0, 1.0))


@_word("Transforms")
def scale(slots: Work, shape: Shape, factor: Vec3):
    """The shape stretched from the origin: one factor, or one each along x, y and z. A negative factor mirrors."""
    return _transformed(shape, np.diag(factor))


# -- numbers, fields and vectors --------------------------------------------------------------------------------------


def _vector(slots: Work, size: int, given: tuple) -> Vector:
    flat = [scalar for value in given for scalar in values.components(value)]
    for value in given:
        if kind_of(value) not in ("number", "field", "vector"):
            raise Misuse(f"a vector is made of numbers and fields, not of a {kind_of(value)}",
                         f"write vec{size}({', '.join('xyz'[:size])})")
    if len(flat) == 1:
        flat *= size
    if len(flat) != size:
        raise Misuse(f"vec{size} does not take {len(flat)} components", f"write vec{size}({', '.join('xyz'[:size])})")
    return tuple(flat)


FUNCTIONS["vec2"] = Function(
    "vec2", MATHEMATICS, (Argument("x", "value"),), lambda slots, *given: _vector(slots, 2, given),
    "A vector of two components, as in `vec2(length(p.xy) - 1, p.z)`. `(x, y)` is one too.", True, "vec2(x, y)")
FUNCTIONS["vec3"] = Function(
    "vec3", MATHEMATICS, (Argument("x", "value"),), lambda slots, *given: _vector(slots, 3, given),
    "A vector of three components, made of numbers and vectors, `vec3(p.xy, 0)`, or of the same number three times, "
    "`vec3(1)`. `(x, y, z)` is one too.", True, "vec3(x, y, z)")


def _spread(name: str, function: Callable, description: str, *arguments: str, variadic: bool = False,
            cost: int = 1) -> None:
    """Adds a function of scalars, which works on the components of vectors one by one."""
    _add(Function(
        name, MATHEMATICS, tuple(Argument(a, "value") for a in arguments),
        lambda slots, *given: spread(lambda *scalars: compute(slots, function, *scalars), *given), description,
        variadic, cost=cost))


def _fold(function: Callable) -> Callable:
    def run(first, *others):
        for other in others:
            first = function(first, other)
        return first

    return run


def _sign(a: Scalar) -> Scalar:
    return _where(0.0 < a, 1.0, 0.0) - _where(a < 0.0, 1.0, 0.0)


def _where(truth, then: Scalar, otherwise: Scalar) -> Scalar:
    if isinstance(truth, Formula):
        return formula.select(truth, then, otherwise)
    return then if truth else otherwise


def _clamp(a: Scalar, low: Scalar, high: Scalar) -> Scalar:
    return minimum(maximum(a, low), high)


def _smoothstep(low: Scalar, high: Scalar, a: Scalar) -> Scalar:
    t = _clamp((a - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _round(a: Scalar) -> Scalar:
    return values.floor(a + 0.5)


def _mod(a: Scalar, divisor: Scalar) -> Scalar:
    return a - divisor * values.floor(a / divisor)


_spread("sin", sin, "Sine of an angle in radians.", "angle")
_spread("cos", cos, "Cosine of an angle in radians.", "angle")
_spread("tan", values.tan, "Tangent of an angle in radians.", "angle")
_spread("asin", values.asin, "Angle in radians whose sine is the value.", "value")
_spread("acos", values.acos, "Angle in radians whose cosine is the value.", "value")
_spread("atan", values.atan, "Angle in radians whose tangent is the value.", "value")
_spread("atan2", values.atan2, "Angle in radians of the point (x, y).", "y", "x")
_spread("radians", lambda a: a * (math.pi / 180.0), "Degrees as radians.", "degrees")
_spread("degrees", lambda a: a * (180.0 / math.pi), "Radians as degrees.", "radians")
_spread("sqrt", sqrt, "Square root.", "value")
_spread("exp", values.exp, "e to the power of the value.", "value")
_spread("log", values.log, "Natural logarithm.", "value")
_spread("pow", values.power, "Base to the power of the exponent, also written `base ** exponent`.", "base", "exponent")
_spread("abs", absolute, "The value without its sign.", "value")
_spread("sign", _sign, "−1, 0 or 1.", "value", cost=5)
_spread("floor", values.floor, "The next whole number below.", "value")
_spread("ceil", lambda a: -values.floor(-a), "The next whole number above.", "value")
_spread("round", _round, "The nearest whole number.", "value")
_spread("fract", lambda a: a - values.floor(a), "What is left above the next whole number below.", "value")
_spread("mod", _mod, "Remainder with the sign of the divisor, also written `value % divisor`.", "value", "divisor",
        cost=4)
_spread("min", _fold(minimum), "The least value.", "value", variadic=True)
_spread("max", _fold(maximum), "The greatest value.", "value", variadic=True)
_spread("clamp", _clamp, "The value held between two limits.", "value", "low", "high", cost=2)
_spread("mix", lambda a, b, t: a + (b - a) * t, "From a (at t = 0) to b (at t = 1) on a straight line.", "a", "b", "t",
        cost=3)
_spread("step", lambda edge, a: _where(a < edge, 0.0, 1.0), "0 below the edge, 1 from there on.", "edge", "value")
_spread("smoothstep", _smoothstep, "From 0 below low to 1 above high, on a smooth curve between.", "low", "high",
        "value", cost=8)


@_word(MATHEMATICS)
def select(slots: Work, condition: Condition, then: Any, otherwise: Any):
    """One value where the condition holds, another elsewhere; also written `then if condition else otherwise`.

    A condition compares numbers or fields: `a < b`, `<=`, `>`, `>=`, and is put together with `and`, `or` and `not`.
    """
    return choose(slots, condition, then, otherwise)


def _dot(a: Vector, b: Vector) -> Scalar:
    if len(a) != len(b):
        raise Misuse("vectors of two and of three components do not go together", "use one kind, as in p.xy or p")
    return sum((x * y for x, y in zip(a[1:], b[1:])), a[0] * b[0])


def _cross(a: Vector, b: Vector) -> Vector:
    return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))


def _subtract(a: Vector, b: Vector) -> Vector:
    return spread(lambda x, y: x - y, a, b)


def _length(vector: Vector) -> Scalar:
    return sqrt(_dot(vector, vector))


def _normalized(vector: Vector) -> Vector:
    norm = _length(vector)
    if isinstance(norm, float) and norm == 0.0:
        raise Misuse("a vector of length 0 has no direction", "give another vector")
    return tuple(component / norm for component in vector)


@_word(MATHEMATICS, cost=2)
def dot(a: Vector, b: Vector):
    """Dot product."""
    return _dot(a, b)


@_word(MATHEMATICS, cost=3)
def cross(a: Vector3, b: Vector3):
    """Cross product."""
    return _cross(a, b)


@_word(MATHEMATICS, cost=2)
def length(vector: Vector):
    """Length of a vector."""
    return _length(vector)


@_word(MATHEMATICS, cost=4)
def normalize(vector: Vector):
    """The vector of length 1 in the same direction."""
    return _normalized(vector)


# -- points -----------------------------------------------------------------------------------------------------------


@_word(POINTS, cost=5)
def repeat(slots: Work, point: Value, period: Value):
    """The point as seen from the middle of its cell, where cells of the given size fill space.

    A shape there appears in every cell: `sphere(0.2)(repeat(p, 1))`. A direction with a period of 0 is left alone.
    """
    def cell(a: Scalar, size: Scalar) -> Scalar:
        return a if type(size) is float and size == 0.0 else compute(slots, lambda a, b: a - b * _round(a / b), a, size)

    return spread(cell, point, period)


@_word(POINTS, cost=8)
def fold(point: Vector, normal: Vector, offset: Scalar = 0.0):
    """The point mirrored to the side of a plane that its normal points to, if it is on the other.

    The plane is offset from the origin by so many metres along the normal.
    """
    normal = _normalized(normal)
    beyond = 2.0 * minimum(_dot(point, normal) - offset, 0.0)
    return _subtract(point, tuple(beyond * n for n in normal))


@_word("Fields", cost=40)
def noise(slots: Work, point: Vector3, seed: float = 0.0):
    """Smooth random values between −1 and 1, with features of one metre: `noise(4 * p)` has them four times finer.

    Another seed, a whole number from 0 to 288, gives other noise.
    """
    return compute(slots, lambda point, seed: values.settled(value_noise(formula.Vector(*map(_formula, point)), seed)),
                   point, seed)


@_word(POINTS, cost=8)
def mirror(point: Vector3, normal: Vector3 = (1.0, 0.0, 0.0)):
    """The point mirrored to the side of a plane through the origin that its normal points to, if it is on the other."""
    return fold(point, normal)


@_word(POINTS, cost=6)
def polar(point: Vector, count: Scalar):
    """The point turned about the z axis, by whole parts of a turn, to the part around the x axis.

    A shape there appears that many times around the axis: `sphere(0.2)(polar(p, 6) - (1, 0, 0))`.
    """
    part = math.tau / count
    angle = values.atan2(point[1], point[0])
    # Held to its limits, which changes nothing, the angle has an interval that keeps the point in its part.
    angle = _clamp(angle - part * _round(angle / part), -0.5 * part, 0.5 * part)
    radius = _length(point[:2])
    return (radius * cos(angle), radius * sin(angle), *point[2:])
