# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions of the expression language for shapes: every shape, profile and operator by name, and transforms."""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..graph import formula
from ..graph.formula import Formula
from . import expression_values
from .builtin_numbers import Value, Vector3, as_formula, cross_product, difference, dot_product, norm, unit
from .expression_values import Live, Misuse, NeedsNumber, Scalar, Vector, Work, compute, cos, has_field, kind_of, sin
from .functions import Argument, Function, add, as_shape, of_shape, word
from .shapes import SHAPES, Box, Shape, Transformed
from .shapes.base import Parametric
from .shapes.field import FieldDisplacement
from .shapes.operators import SetOperation
from .shapes.polygons import Polygon
from .shapes.profiles import PROFILES, Profile

Vec3 = tuple[float, float, float]

_PRIMITIVE = 20  # rough operations of the field of a primitive


def _arguments(kind_of_shape: type[Parametric]) -> tuple[Argument, ...]:
    parts = [
        Argument("shape" if field.name == "child" else field.name, field.metadata["part"])
        for field in dataclasses.fields(kind_of_shape)
        if "part" in field.metadata
    ]
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

        add(
            Function(
                name,
                "Combinations",
                (Argument("shape", "shape"), *arguments),
                call,
                inspect.getdoc(shape),
                variadic=True,
            )
        )
        return
    variadic = shape is Polygon
    if variadic:
        arguments = (Argument("point", "corner"),)
    parts = {argument.kind for argument in arguments}
    group = (
        "Profiles"
        if issubclass(shape, Profile)
        else "Operators"
        if "shape" in parts
        else "Solids from Profiles"
        if "profile" in parts
        else "Shapes"
    )
    add(Function(name, group, arguments, lambda slots, *given: shape(*given), inspect.getdoc(shape), variadic))


for _name, _shape in {**SHAPES, **PROFILES}.items():
    _add_shape(_name, _shape)


@word("Fields", usage="field(value, bounds=none)")
def field(slots: Work, value: Scalar, bounds: Vec3 = (math.inf,) * 3):
    """The shape inside which a field is negative.

    Its limits are found automatically. If that fails or takes long, give half of the size of a box around the origin as
    bounds. The shape is then cut to it.
    """
    if not isinstance(value, Formula):
        raise Misuse("this field is the same at all points", "make it of the point p, as in field(length(p) - 1)")
    return as_shape(value, slots, None if math.inf in bounds else Box(bounds))


_DISPLACEMENT_STEPS = 240  # cost of finding the limits of a field and of its slope, in addition to its operations


@word("Fields")
def displace(slots: Work, shape: Shape, amount: Scalar):
    """The shape with its surface moved outwards by a field, or inwards where the field is negative.

    If the field and its slope have limits, the shape keeps its bound on the distance.
    """
    amount = of_shape(as_formula(expression_values.lifted(amount, slots)), slots)
    slots.step(_DISPLACEMENT_STEPS + 3 * len(formula.order(amount)))
    displaced = FieldDisplacement.of(shape, amount, slots.values)
    return displaced or as_shape(distance(slots, shape, tuple(formula.POINT)) - amount, slots)


@word("Fields", usage="distance(shape, point) or distance(a, b)")
def distance(slots: Work, shape: Any, point: Vector):
    """The field of a shape at a point, also written `shape(point)`, or the distance between two points.

    The field of a profile takes a point of two components: `circle(1)(p.xy)`.
    """
    if kind_of(shape) == "vector":
        return compute(slots, lambda a, b: norm(difference(a, b)), shape, point)
    if not isinstance(shape, Profile):
        shape = as_shape(shape, slots)
    if len(point) != (2 if isinstance(shape, Profile) else 3):
        raise Misuse(
            "a profile has its field in the plane, a shape in space",
            "give a profile a point of two components, as in p.xy, and a shape one of three",
        )
    point = point if len(point) == 3 else (*point, 0.0)
    if not has_field(point):
        slots.step(4 * _PRIMITIVE * shape.size)
        return Live(shape.distance(np.array(point)))
    slots.operate(_PRIMITIVE * shape.size)
    return shape.build(formula.Vector(*map(as_formula, expression_values.lifted(point, slots))), slots)


# -- transforms -------------------------------------------------------------------------------------------------------


def _transformed(shape: Shape, linear, offset=(0.0, 0.0, 0.0)) -> Shape:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = offset
    return Transformed(shape, matrix)


def _turned(vector: Vector, axis: Vector, degrees: Scalar) -> Vector:
    """Rodrigues' formula for a unit axis, counter-clockwise as seen from its tip."""
    c, s = cos(degrees * (math.pi / 180.0)), sin(degrees * (math.pi / 180.0))
    along = dot_product(axis, vector) * (1.0 - c)
    return tuple(v * c + w * s + a * along for v, w, a in zip(vector, cross_product(axis, vector), axis))


def _rotated(slots: Work, what, turn: Callable, *angles):
    """A vector rotated by ``turn(vector, *angles)``, or a shape by its matrix."""
    if isinstance(what, Shape):
        if any(map(has_field, angles)):
            raise NeedsNumber(
                "a shape rotates as a whole, but the angle differs from point to point",
                "rotate the point, as in shape(rotate_z(p, 90 * p.z))",
            )
        return _transformed(what, np.transpose([turn(tuple(unit), *angles) for unit in np.eye(3).tolist()]))
    return compute(slots, turn, what, *angles)


@word("Transforms")
def translate(slots: Work, shape: Shape, offset: Vec3):
    """The shape moved by an offset in metres."""
    return _transformed(shape, np.eye(3), offset)


@word("Transforms", cost=6)
def rotate(slots: Work, shape: Any, degrees: Value, axis: Vector3 = (0.0, 0.0, 1.0)):
    """The shape, or vector, rotated about an axis through the origin, counter-clockwise as seen from its tip.

    With a vector of three angles: about x, then y, then z, like Blender's XYZ Euler rotation; axis is then unused. A
    vector of two components rotates in its plane.
    """
    if kind_of(shape) not in ("shape", "field", "vector"):
        raise Misuse(f"rotate takes shapes and vectors, not a {kind_of(shape)}", "write rotate(shape, degrees)")
    if isinstance(shape, Formula):
        shape = as_shape(shape, slots)
    if isinstance(shape, tuple) and len(shape) == 2:
        return _rotated(slots, (*shape, 0.0), _about(2), degrees)[:2]
    if isinstance(degrees, tuple):
        for index, angle in enumerate(degrees):
            shape = _rotated(slots, shape, _about(index), angle)
        return shape
    return _rotated(slots, shape, lambda v, a, d: _turned(v, unit(a), d), axis, degrees)


def _about(index: int) -> Callable:
    unit = tuple(np.eye(3)[index].tolist())
    return lambda vector, degrees: _turned(vector, unit, degrees)


@word("Transforms", cost=4)
def rotate_x(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, rotated about the x axis."""
    return rotate(slots, shape, degrees, (1.0, 0.0, 0.0))


@word("Transforms", cost=4)
def rotate_y(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, rotated about the y axis."""
    return rotate(slots, shape, degrees, (0.0, 1.0, 0.0))


@word("Transforms", cost=4)
def rotate_z(slots: Work, shape: Any, degrees: Scalar):
    """The shape, or vector, rotated about the z axis."""
    return rotate(slots, shape, degrees, (0.0, 0.0, 1.0))


@word("Transforms")
def scale(slots: Work, shape: Shape, factor: Vec3):
    """The shape scaled from the origin: one factor, or one for each of x, y and z. A negative factor mirrors."""
    return _transformed(shape, np.diag(factor))


@word("Transforms", cost=6)
def transform(slots: Work, shape: Shape, x: Vec3, y: Vec3, z: Vec3, offset: Vec3 = (0.0, 0.0, 0.0)):
    """The shape under an affine map, including shear: x, y and z are the images of the axes' unit vectors.

    The offset is the image of the origin.
    """
    return _transformed(shape, np.transpose([x, y, z]), offset)
