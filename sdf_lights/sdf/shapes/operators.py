# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes made of shapes: the common base of all operators; sharp set operations; affine transforms."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property, reduce

import numpy as np

from ...affine import inverse
from ...frozen import frozen
from ...graph.formula import POINT, Formula, Vector, maximum, minimum, parameter, select
from ...graph.substitution import substitute
from ...interruption import check
from ..program import NoClosedForm, Op, combine
from .base import BOUND, EXACT, LARGEST, NONE, SMALLEST, Family, Shape, ShapeError, Slots, Term, part, undone
from .primitives import Box

_FLAT = 1e-9  # ratio of singular values below which a matrix counts as flat
_MOST_ROWS = 1024  # rows of programs of copies: beyond this, tracing a field is faster
_SIMILAR = 1e-12  # relative spread of singular values below which a matrix scales all directions equally


def balanced(join: Callable, parts: list):
    """``join(a, b)`` of neighbours, in the least number of levels."""
    while len(parts) > 1:
        pairs = [join(a, b) for a, b in zip(parts[::2], parts[1::2])]
        parts = pairs + parts[2 * len(pairs) :]
    return parts[0]


def wanted(shapes: Iterable[Shape]) -> Iterator[Shape]:
    """The shapes, one by one, until the work is cancelled (see ``interruption``)."""
    for shape in shapes:
        check()
        yield shape


def enclosing(boxes) -> tuple[np.ndarray, np.ndarray]:
    """The box around boxes (low, high)."""
    lows, highs = zip(*boxes)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def common(boxes) -> tuple[np.ndarray, np.ndarray]:
    """The intersection of boxes (low, high); of zero size if it is empty."""
    lows, highs = zip(*boxes)
    low = np.max(lows, axis=0)
    return low, np.maximum(low, np.min(highs, axis=0))


def checked(shape: Shape, child) -> Shape:
    """``child``, a part of ``shape``. Raises ``ShapeError`` if it is not a shape."""
    if not isinstance(child, Shape):
        raise ShapeError(f"{shape.label()} takes shapes, not {child!r:.40}.")
    return child


def images(box, matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The box around all images of a box (low, high) by affine matrices (n, 4, 4)."""
    low, high = box
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return np.full(3, -np.inf), np.full(3, np.inf)
    corners = np.stack(np.meshgrid(*zip(low, high)), axis=-1).reshape(-1, 3)
    moved = corners @ np.swapaxes(matrices[:, :3, :3], 1, 2) + matrices[:, None, :3, 3]
    return moved.min(axis=(0, 1)), moved.max(axis=(0, 1))


def images_growth(growth: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """``Shape.growth`` (3,) of all images, by ``matrices`` (n, 4, 4), of a shape with this ``growth``, with the box of
    ``images``."""
    return (np.abs(matrices[:, :3, :3]) @ growth).max(axis=0) if np.isfinite(growth).all() else growth


def images_program(shape: Shape, places: np.ndarray, matrix: np.ndarray | None) -> np.ndarray:
    """Program of the union of a shape's images by affine matrices (n, 4, 4), all transformed by ``matrix``.
    Raises NoClosedForm for too many images."""
    program = shape.program()
    if len(places) * len(program) > _MOST_ROWS:
        raise NoClosedForm(f"{shape.label()} is copied too often for a closed form.")
    copies = []
    for place in places if matrix is None else matrix @ places:
        copies.append(program.copy())
        copies[-1]["inverse"] = program["inverse"] @ inverse(place)
    return combine(Op.UNION, copies)


class Composite(Shape, abstract=True):
    """A shape made of the shapes ``children``. Values that are used repeatedly are cached."""

    @cached_property
    def certified(self) -> bool:
        return all(child.certified for child in self.children)

    @cached_property
    def always_continuous(self) -> bool:
        return all(child.always_continuous for child in self.children)

    @cached_property
    def bounded(self) -> bool:
        return all(child.bounded for child in self.children)

    @cached_property
    def lipschitz(self) -> float:
        return max(child.lipschitz for child in self.children)

    @cached_property
    def exactness(self) -> str:
        # The nearest surface may be one that the operation removed or moved: even for exact shapes this is a bound.
        return BOUND if self.lipschitz <= 1.0 and all(c.exactness != NONE for c in self.children) else NONE

    def growth(self, matrix: np.ndarray | None = None) -> np.ndarray:
        return np.max([child.growth(matrix) for child in self.children], axis=0)

    def along(self, p: Vector, slot: Slots) -> Formula | None:
        """That of the nearest of the shapes that have one."""
        known = [(child.build(p, slot), child.along(p, slot)) for child in self.children]
        known = [(distance, along) for distance, along in known if along is not None]
        if not known:
            return None
        nearest, found = known[0]
        for distance, along in known[1:]:
            found = select(distance < nearest, along, found)
            nearest = minimum(nearest, distance)
        return found


class SetOperation(Composite, abstract=True):
    """A combination of one or more shapes, given as arguments or, as with ``min``, as one sequence; then the numbers.

    Shapes are joined two at a time. Nested combinations of the same kind and numbers become one, so long chains stay
    shallow. A combination of one shape leaves it unchanged.
    """

    op: Op | None = None
    family: Family
    associative = False  # else a, b, c are joined as (a, b), c
    children: tuple[Shape, ...]

    def __init__(self, *children: Shape, **numbers: float):
        if len(children) == 1 and isinstance(children[0], (tuple, list)):
            children = tuple(children[0])
        for field in self.fields():
            object.__setattr__(self, field.name, numbers.pop(field.name, field.default))
        if numbers:
            raise ShapeError(f"{self.label()} has no parameter {next(iter(numbers)):.40}.")
        super().__post_init__()
        parts, depth = [], 1
        for index, child in enumerate(children):
            absorbed = self._absorbs(index, checked(self, child))
            parts.extend(child.children if absorbed else (child,))
            depth = max(depth, child.depth + (not absorbed))
        object.__setattr__(self, "children", tuple(parts))
        # Cached, and derived from the arguments: a long chain must not count all its parts again at each link.
        object.__setattr__(self, "size", sum(child.size for child in children))
        object.__setattr__(self, "depth", depth)

    def replaced(self, **values):
        children = values.pop("children", self.children)
        return type(self)(*children, **{field.name: getattr(self, field.name) for field in self.fields()} | values)

    def _absorbs(self, index: int, child: Shape) -> bool:
        """Whether the argument ``child`` can be replaced by its parts."""
        return (
            type(child) is type(self)
            and (self.associative or index == 0)
            and all(getattr(child, field.name) == getattr(self, field.name) for field in self.fields())
        )

    def _join(self, a: Formula, b: Formula, *numbers: Formula) -> Formula:
        """The field of two shapes with the fields a and b; it gets the operation's own numbers."""
        raise NotImplementedError

    def _numbers(self, slot: Slots, factor: float = 1.0) -> list[Formula]:
        """The numbers, for fields ``factor`` times as large as distances."""
        return [
            slot(getattr(self, field.name) * (factor if field.unit == "LENGTH" else 1.0)) for field in self.fields()
        ]

    def _blend_width(self) -> float:
        """If two fields differ by more than this, their join is one of them."""
        return 0.0

    def _operands(self) -> tuple[Shape, ...]:
        """The shapes that are joined."""
        return self.children

    def _joined(self, join: Callable, parts: list):
        return balanced(join, parts) if self.associative else reduce(join, parts)

    @cached_property
    def exactness(self) -> str:
        return self.children[0].exactness if len(self.children) == 1 else super().exactness

    @cached_property
    def exact_outside(self) -> bool:
        return len(self.children) == 1 and self.children[0].exact_outside

    def build(self, p: Vector, slot: Slots) -> Formula:
        numbers = self._numbers(slot) if len(self.children) > 1 else ()
        return self._joined(lambda a, b: self._join(a, b, *numbers), [o.build(p, slot) for o in self._operands()])

    def terms(self, matrix: np.ndarray, factor: float) -> list[Term]:
        slots = Slots()
        formula = self._join(POINT.x, POINT.y, *self._numbers(slots, factor))
        numbers, blend_width = np.array(slots.values), self._blend_width() * factor

        def join(a: list[Term], b: list[Term]) -> list[Term]:
            steepest = max(a[-1].lipschitz, b[-1].lipschitz)
            return [*a, *b, Term(formula, numbers, 2, self.family, blend_width, steepest)]

        return self._joined(join, [shape.terms(matrix, factor) for shape in wanted(self._operands())])

    def program(self, matrix: np.ndarray | None = None) -> np.ndarray:
        programs = [child.program(matrix) for child in wanted(self.children)]
        if len(programs) == 1:
            return programs[0]
        return super().program(matrix) if self.op is None else combine(self.op, programs)

    def volume(self) -> float | None:
        return self.children[0].volume() if len(self.children) == 1 else None

    def relation(self) -> str:
        return "" if self.children else f"{self.label()}: it has no shapes to combine: give it at least one."


@frozen
class Union(SetOperation):
    """All points that are in at least one of the shapes."""

    op = Op.UNION
    family = Family.UNION
    associative = True

    children: tuple[Shape, ...] = ()

    def _join(self, a, b):
        return minimum(a, b)

    @cached_property
    def exact_outside(self):
        return all(child.exact_outside for child in self.children)

    def bounds(self, matrix=None):
        return enclosing(child.bounds(matrix) for child in self.children)


@frozen
class Intersection(SetOperation):
    """The points that are in all of the shapes."""

    op = Op.INTERSECTION
    family = Family.INTERSECTION
    associative = True

    children: tuple[Shape, ...] = ()

    def _join(self, a, b):
        return maximum(a, b)

    @cached_property
    def bounded(self):
        return any(child.bounded for child in self.children) or bool(np.isfinite(self.bounds()).all())

    def bounds(self, matrix=None):
        return common(child.bounds(matrix) for child in self.children)


@frozen
class Difference(SetOperation):
    """The first shape without the others."""

    op = Op.DIFFERENCE
    family = Family.DIFFERENCE

    children: tuple[Shape, ...] = ()

    def _join(self, a, b):
        return maximum(a, -b)

    def _operands(self):
        first, *others = self.children
        return (first, Union(others)) if len(others) > 1 else self.children

    @cached_property
    def bounded(self):
        return self.children[0].bounded

    def bounds(self, matrix=None):
        return self.children[0].bounds(matrix)

    def growth(self, matrix=None):
        return self.children[0].growth(matrix)


@frozen
class Exclusive(SetOperation):
    """The points that are in an odd number of the shapes: for two, in one of them but not in both."""

    op = Op.EXCLUSIVE
    family = Family.EXCLUSIVE
    associative = True

    children: tuple[Shape, ...] = ()

    def _join(self, a, b):
        return maximum(minimum(a, b), -maximum(a, b))

    def bounds(self, matrix=None):
        return enclosing(child.bounds(matrix) for child in self.children)


class Operator(Composite, abstract=True):
    """A shape made of one other. Methods that are not overridden use the child's."""

    child: Shape

    def __post_init__(self):
        checked(self, self.child)
        super().__post_init__()

    @property
    def children(self) -> tuple[Shape, ...]:
        return (self.child,)

    @cached_property
    def size(self) -> int:
        return self.child.size

    @cached_property
    def depth(self) -> int:
        return 1 + self.child.depth

    def _asked(self, p: Vector, slot: Slots) -> Vector:
        """The point at which the child is evaluated for p."""
        return p

    def along(self, p: Vector, slot: Slots) -> Formula | None:
        return self.child.along(self._asked(p, slot), slot)


class Folded(Operator, abstract=True):
    """The child's field at another point, by a map that never increases the distance of two points."""

    @cached_property
    def exactness(self):
        # Even for an exact child: the surface may be nearer than the part of it that the map leads to.
        return BOUND if self.child.exactness == EXACT else self.child.exactness

    def _asked(self, p: Vector, slot: Slots) -> Vector:
        raise NotImplementedError

    def build(self, p, slot):
        return self.child.build(self._asked(p, slot), slot)

    def terms(self, matrix, factor):
        """The terms of the child at the other point."""
        slots = Slots()
        point = self._asked(undone(matrix, POINT, slots), slots)
        first = len(slots.values)
        terms = []
        for term in self.child.terms(np.eye(4), factor):
            if term.arity == 0:
                moved = [parameter(first + index) for index in range(len(term.parameters))]
                term = term._replace(
                    formula=substitute(term.formula, point, moved),
                    parameters=np.concatenate([slots.values, term.parameters]),
                    zeros=None,
                )
            terms.append(term)
        return terms


@frozen
class Transformed(Operator, abstract=True):
    """A shape under an affine matrix, including rotation, uneven scale, shear and mirroring.

    The field is σ·φ(M⁻¹x) with σ the least singular value of M. M⁻¹ stretches no length by more than 1/σ, so the
    Lipschitz bound of φ remains valid, and a bound of the distance does too. Not in ``SHAPES``: artists use
    ``translate``, ``rotate`` and ``scale``, or objects.
    """

    child: Shape = part("Shape that is transformed")
    matrix: tuple[tuple[float, ...], ...] = dataclasses.field(
        default=tuple(map(tuple, np.eye(4).tolist())),
        metadata=dict(description="4 × 4 matrix that transforms the shape"),
    )

    def __post_init__(self):
        super().__post_init__()
        try:
            matrix = np.array(self.matrix, np.float64)
        except (TypeError, ValueError):
            matrix = np.empty(0)
        if matrix.shape != (4, 4):
            raise ShapeError("Transformed: the matrix must be 4 × 4 numbers.")
        child = self.child
        if isinstance(child, Transformed):
            matrix, child = matrix @ np.array(child.matrix), child.child
        object.__setattr__(self, "child", child)
        object.__setattr__(self, "matrix", tuple(map(tuple, matrix.tolist())))

    @cached_property
    def _array(self) -> np.ndarray:
        return np.array(self.matrix)

    @cached_property
    def _singular_values(self) -> np.ndarray:
        return np.linalg.svd(self._array[:3, :3], compute_uv=False)

    def _total(self, matrix: np.ndarray | None) -> np.ndarray:
        return self._array if matrix is None else matrix @ self._array

    @property
    def _similar(self) -> bool:
        largest, _, least = self._singular_values
        return bool(largest - least <= _SIMILAR * largest)

    @cached_property
    def exactness(self) -> str:
        return BOUND if self.child.exactness == EXACT and not self._similar else self.child.exactness

    @cached_property
    def exact_outside(self) -> bool:
        return self.child.exact_outside and self._similar

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self.child.build(self._asked(p, slot), slot) * slot(float(self._singular_values[-1]))

    def _asked(self, p, slot):
        return undone(self._array, p, slot)

    def terms(self, matrix: np.ndarray, factor: float) -> list[Term]:
        return self.child.terms(matrix @ self._array, factor * float(self._singular_values[-1]))

    def relation(self) -> str:
        if not np.isfinite(self._array).all():
            return "Transformed: the matrix has a number that is not finite: give the shape an ordinary transform."
        if np.any(self._array[3] != (0.0, 0.0, 0.0, 1.0)):
            return "Transformed: the last row of the matrix must be 0, 0, 0, 1."
        if np.abs(self._array).max() > LARGEST:
            return f"Transformed: the matrix has a number above {LARGEST:g}: move and scale the shape less."
        largest, _, least = self._singular_values
        if least < max(SMALLEST, _FLAT * largest):
            return "Transformed: the matrix flattens the shape: give it a scale other than zero along every axis."
        return ""

    def volume(self) -> float | None:
        volume = self.child.volume()
        return None if volume is None else volume * abs(float(np.linalg.det(self._array[:3, :3])))

    def bounds(self, matrix=None):
        return self.child.bounds(self._total(matrix))

    def growth(self, matrix=None):
        return self.child.growth(self._total(matrix)) / self._singular_values[-1]

    def program(self, matrix=None):
        return self.child.program(self._total(matrix))


@frozen
class Guarded(Operator, abstract=True):
    """A bounded shape with a field that is at least the distance to the shape's box, so its ``growth`` is known.

    Not in ``SHAPES``: operators guard their children if they need to.
    """

    child: Shape = part("Shape")

    @cached_property
    def _box(self) -> Transformed:
        low, high = self.child.bounds()
        place = np.eye(4)
        place[:3, 3] = (low + high) / 2.0
        return Transformed(Box(tuple((high - low) / 2.0)), place)

    @cached_property
    def lipschitz(self):
        return max(self.child.lipschitz, 1.0)

    def build(self, p, slot):
        return Intersection(self.child, self._box).build(p, slot)

    def terms(self, matrix, factor):
        return Intersection(self.child, self._box).terms(matrix, factor)

    def bounds(self, matrix=None):
        return self._box.bounds(matrix)

    def growth(self, matrix=None):
        return self._box.growth(matrix)

    def program(self, matrix=None):
        return self.child.program(matrix)

    def volume(self):
        return self.child.volume()


def guarded(shape: Shape) -> Shape:
    """The same set of points, with a field of known ``growth`` if the shape is bounded."""
    return shape if not shape.bounded or np.isfinite(shape.growth()).all() else Guarded(shape)


def level_bounds(shape: Shape, level: float, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,), as in ``bounds``, of a box around {x : φ(x) ≤ level}."""
    low, high = shape.bounds(matrix)
    if level > 0.0:
        margin = level * shape.growth(matrix)
    else:
        # A ball of radius −level / L around such a point is inside the shape.
        least = level / shape.lipschitz
        margin = np.full(3, least) if matrix is None else least * np.linalg.norm(matrix[:3, :3], axis=1)
    low, high = low - margin, high + margin
    crossed = low > high
    low[crossed] = high[crossed] = (low[crossed] + high[crossed]) / 2.0
    return low, high
