# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The base of all shapes: a frozen dataclass of documented parameters, and one method that builds its formula.

Everything else (the expression language, Blender's properties, the reference page) is made from ``SHAPES`` and the
fields' metadata.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import inspect
import math
import re
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...affine import inverse
from ...graph import numpy_evaluation
from ...graph.continuity import declare
from ...graph.formula import POINT, Formula, Vector, parameter
from ...graph.functions import Function
from .. import program

EXACT, BOUND, NONE = "exact", "bound", "none"

SMALLEST = 1e-6  # minimum size in metres of anything that must not vanish: below it float32 displays show nothing
LARGEST = 1e9  # maximum size and distance: squares are far from overflow, also in float32

SHAPES: dict[str, type["Shape"]] = {}
"""Every shape by its name in expressions, such as ``box_frame`` for ``BoxFrame``, in order of definition."""


class ShapeError(ValueError):
    """A shape got a value that is not a number or not a shape; names it in one sentence."""


class Parameter(NamedTuple):
    """One number (``size`` 1) or vector (``size`` 3) of a shape, as user interfaces present it."""

    name: str
    label: str
    description: str
    unit: str  # "LENGTH" (metres), "ANGLE" (radians) or "NONE", as Blender names them
    default: float | tuple[float, float, float]
    minimum: float  # −inf if there is none; validate() enforces it
    maximum: float
    soft_maximum: float  # end of a slider; larger values may be typed
    size: int
    whole: bool  # a count: only integers


def number(
    default,
    description: str,
    *,
    unit: str = "LENGTH",
    minimum: float = SMALLEST,
    maximum: float = LARGEST,
    soft_maximum: float = 10.0,
    label: str = "",
    whole: bool = False,
):
    """Dataclass field of a shape's parameter: a float, or a vector if ``default`` is a 3-tuple."""
    return dataclasses.field(
        default=default,
        metadata=dict(
            description=description,
            unit=unit,
            minimum=minimum,
            maximum=maximum,
            soft_maximum=soft_maximum,
            label=label,
            whole=whole,
        ),
    )


def part(description: str, kind: str = "shape"):
    """Dataclass field of a child shape ("shape") or profile ("profile"); before the numbers."""
    return dataclasses.field(metadata=dict(part=kind, description=description))


class Family(enum.IntEnum):
    """How a field is joined from others; pruning uses this."""

    LEAF = 0  # not joined from others
    MAP = 1  # of one field: an offset, a shell
    UNION = 2  # of a and b, far from each other: the lesser
    INTERSECTION = 3  # the greater
    DIFFERENCE = 4  # the greater of a and −b
    EXCLUSIVE = 5  # a where |a| < b, −a where |a| < −b, and so on


class Term(NamedTuple):
    """One of the formulas, in postfix order, by which a shape's field is evaluated.

    A term takes ``arity`` values from a stack and pushes its own. If ``arity`` is 0, its ``formula`` reads the point.
    Otherwise it reads its operands instead of the coordinates x (the first) and y. If operands a and b (−b in a
    difference) differ by more than ``blend_width``, the value is exactly one of them, as ``family`` says. It never
    changes faster than its fastest operand.
    """

    formula: Formula
    parameters: np.ndarray
    arity: int
    family: Family
    blend_width: float
    lipschitz: float  # of the value, as a function of the point
    zeros: Function | None = None  # a faster way to all zeros along a ray, see ``emitter.intersection.fields.zeros``


class Slots:
    """Assigns parameter slots to a formula while it is built, and stores their values."""

    def __init__(self):
        self.values: list[float] = []

    def __call__(self, value):
        """A fresh slot for a number; a ``Vector`` of three for a 3-tuple."""
        if isinstance(value, tuple):
            return Vector(*(self(component) for component in value))
        self.values.append(value)
        return parameter(len(self.values) - 1)


def _declaring(build):
    """``build`` of shapes and profiles that also declares the field continuous, if that is known for all numbers."""

    @functools.wraps(build)
    def declaring(self, p: Vector, slot: Slots) -> Formula:
        formula = build(self, p, slot)
        if self.always_continuous and math.isfinite(self.lipschitz):  # type: ignore[attr-defined]
            declare(formula, p)
        return formula

    return declaring


class Parametric:
    """A field φ with a name and documented parameters: a frozen dataclass of ``number`` fields.

    The common base of shapes, and of the profiles that they are swept from.
    """

    always_continuous = True  # if ``lipschitz`` is finite: for all numbers in the slots of the formula

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        if "build" in cls.__dict__:
            cls.build = _declaring(cls.build)  # type: ignore[method-assign]

    def __post_init__(self):
        for field in self.fields():
            object.__setattr__(self, field.name, _coerced(self, field, getattr(self, field.name)))

    @classmethod
    def name(cls) -> str:
        """The name in expressions and files: ``box_frame`` for ``BoxFrame``."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def label(cls) -> str:
        """The name in user interfaces: ``Box Frame``."""
        return cls.name().replace("_", " ").title()

    @classmethod
    def summary(cls) -> str:
        """The first paragraph of the documentation: one or two sentences, for tooltips."""
        return " ".join(inspect.getdoc(cls).split("\n\n")[0].split())

    @classmethod
    @functools.cache
    def fields(cls) -> tuple[Parameter, ...]:
        """The parameters an artist sets, in order."""
        found = []
        for field in dataclasses.fields(cls):
            if "unit" in field.metadata:
                about = dict(field.metadata)
                label = about.pop("label") or field.name.replace("_", " ").title()
                size = 3 if isinstance(field.default, tuple) else 1
                found.append(Parameter(field.name, label, default=field.default, size=size, **about))
        return tuple(found)

    def __getstate__(self) -> dict:
        """Everything that defines the shape: addresses of tables are meaningless in another process."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]

    def replaced(self, **values):
        """A copy with other values of some fields."""
        return dataclasses.replace(self, **values)  # type: ignore[type-var]

    def build(self, p: Vector, slot: Slots) -> Formula:
        """The field φ at the point p. Pass numbers that may change to ``slot(…)``, which returns their formulas.

        The graph must not depend on the numbers, or each change compiles again.
        """
        raise NotImplementedError

    def relation(self) -> str:
        """Contradictions between parameters that are each within their limits: one sentence, or an empty string."""
        return ""

    @cached_property
    def _built(self) -> tuple[Formula, np.ndarray]:
        slots = Slots()
        formula = self.build(POINT, slots)
        values = np.array(slots.values, np.float64)
        values.flags.writeable = False
        return formula, values

    def formula(self) -> Formula:
        """The field φ. Shapes that differ only in numbers share one formula, the key of compiled code."""
        return self._built[0]

    def parameters(self) -> np.ndarray:
        """Values of the formula's slots: (slots,) float64, read-only."""
        return self._built[1]

    def distance(self, points: np.ndarray) -> np.ndarray:
        """φ at points (…, 3), with NumPy."""
        return numpy_evaluation.evaluate(self.formula(), points, self.parameters())

    def check(self) -> str:
        """The mistake and its cure: one sentence, or an empty string. Child shapes are not checked."""
        return self._checked

    @cached_property
    def _checked(self) -> str:
        for field in self.fields():
            value = getattr(self, field.name)
            for component in value if field.size == 3 else (value,):
                what = f"{self.label()}: {field.label.lower()} is {component:g}, but must be"
                if not math.isfinite(component):
                    return f"{what} a finite number."
                if component < field.minimum:
                    return f"{what} at least {field.minimum:g}."
                if component > field.maximum:
                    return f"{what} at most {field.maximum:g}."
                if field.whole and component != math.floor(component):
                    return f"{what} a whole number."
        return self.relation()


def undone(matrix: np.ndarray, p: Vector, slot: Slots) -> Vector:
    """matrix⁻¹ p: the position of the point before the affine ``matrix`` (4 × 4) moved it."""
    rows = [(slot(tuple(row[:3])), slot(row[3])) for row in inverse(matrix)[:3].tolist()]
    return Vector(*(row.dot(p) + offset for row, offset in rows))


class Shape(Parametric):
    """A region of space Ω = {x : φ(x) ≤ 0}, given by a field φ that is negative inside.

    Immutable and compared by value. Coordinates are in the shape's local space; lengths are in metres.

    ``exactness`` describes |φ|: ``"exact"``, the distance to the surface everywhere; ``"bound"``, never more than that
    distance; ``"none"``, neither. The sign is right in all three. ``lipschitz`` is an L with |φ(x) − φ(y)| ≤ L |x − y|
    for all x, y. It is 1 for the first two, and infinite if none is known for all of space: then bounds are found box
    by box, from the formula. If no bound exists at all, ``certified`` is False and ``lipschitz`` is a measured value;
    rays may then miss a crossing.

    A shape that is not ``bounded`` reaches to infinity: it is useful only inside an intersection.
    """

    exactness = EXACT
    lipschitz = 1.0
    certified = True
    bounded = True
    children = ()  # the child shapes
    size = 1  # number of primitives in the shape
    depth = 1  # nesting depth of shapes

    def __init_subclass__(cls, abstract: bool = False, **options):
        """Register the class in ``SHAPES``, unless it is abstract and so hidden from artists."""
        super().__init_subclass__(**options)
        if not abstract:
            SHAPES[cls.name()] = cls

    # -- what every shape defines ---------------------------------------------------------------------------------

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Corners (low, high) of an axis-aligned box around ``matrix`` (4 × 4, default identity) applied to the shape.

        Tight for primitives under every affine matrix. An empty intersection may give a box of zero size; a shape that
        is not ``bounded`` gives infinite corners.
        """
        raise NotImplementedError

    @property
    def exact_outside(self) -> bool:
        """Whether φ is the distance at every point outside the shape, whatever it is inside."""
        return self.exactness == EXACT

    def growth(self, matrix: np.ndarray | None = None) -> np.ndarray:
        """By how much ``bounds`` must grow on each side to enclose {x : φ(x) ≤ c}, for each metre of c > 0: (3,).

        Infinite if φ is unknown outside the shape; then use ``operators.guarded``.
        """
        if not self.exact_outside:
            return np.full(3, math.inf)
        return np.ones(3) if matrix is None else np.linalg.norm(matrix[:3, :3], axis=1)

    def volume(self) -> float | None:
        """Volume in cubic metres, or None if no closed form is known: then the emitter integrates it."""
        return None

    def program(self, matrix: np.ndarray | None = None) -> np.ndarray:
        """Closed-form program (see ``sdf.program``) of ``matrix`` (4 × 4, default identity) applied to the shape.

        Raises ``program.NoClosedForm`` if ray intervals must be found numerically.
        """
        raise program.NoClosedForm(f"{self.label()} has no closed form for its ray intervals.")

    def terms(self, matrix: np.ndarray, factor: float) -> list[Term]:
        """The field factor · φ(matrix⁻¹ x) in parts that can be left out where they do not matter: see ``Term``.

        The default is for a shape without such parts. ``factor`` is at most the least singular value of ``matrix`` (4 ×
        4).
        """
        slots = Slots()
        formula = self.build(undone(matrix, POINT, slots), slots) * slots(factor)
        return [Term(formula, np.array(slots.values), 0, Family.LEAF, 0.0, self.lipschitz)]

    def along(self, p: Vector, slot: Slots) -> Formula | None:
        """How far along its curve, from 0 to 1, the part of the shape is that is nearest to p; None where it has no
        curve."""
        return None

    # -- what follows from it -------------------------------------------------------------------------------------

    def validate(self) -> str:
        """As ``check``, but for the shape and all its children.

        The other methods guarantee nothing for an invalid shape.
        """
        return self._validated

    @cached_property
    def _validated(self) -> str:
        # Cached, because shapes never change and operators ask again at each level.
        return self.check() or next(filter(None, (child.validate() for child in self.children)), "")


def _coerced(owner: Parametric, field: Parameter, value):
    """``value`` as a float or a 3-tuple of floats; one number stands for three equal ones."""
    try:
        if field.size == 1:
            return float(value)
        if np.ndim(value) == 0:
            return (float(value),) * 3
        x, y, z = value
        return float(x), float(y), float(z)
    except (TypeError, ValueError, OverflowError):
        kind = "a number" if field.size == 1 else "a number or three numbers"
        raise ShapeError(f"{owner.label()}: {field.label.lower()} must be {kind}, not {value!r:.40}.") from None
