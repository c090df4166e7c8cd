# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes made of shapes: sharp set operations and affine transforms."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..formula import Formula, Vector, maximum, minimum
from ..program import Op, combine
from .base import BOUND, EXACT, LARGEST, NONE, SMALLEST, Shape, ShapeError, Slots

_FLAT = 1e-9  # ratio of singular values below which a matrix counts as flat
_SIMILAR = 1e-12  # relative spread of singular values below which a matrix scales all directions alike


class SetOperation(Shape, abstract=True):
    """A combination of one or more shapes, given as arguments or, as with ``min``, as one sequence.

    Nested combinations of the same kind become one, so long chains stay shallow.
    """

    op: Op
    children: tuple[Shape, ...]

    def __init__(self, *children: Shape):
        if len(children) == 1 and isinstance(children[0], (tuple, list)):
            children = tuple(children[0])
        for child in children:
            if not isinstance(child, Shape):
                raise ShapeError(f"{self.label()} combines shapes, not {child!r:.40}.")
        parts, depth = [], 1
        for index, child in enumerate(children):
            absorbed = self._absorbs(index, child)
            parts.extend(child.children if absorbed else (child,))
            depth = max(depth, child.depth + (not absorbed))
        object.__setattr__(self, "children", tuple(parts))
        # Kept, and made from the arguments: a long chain must not count all its parts again at each link.
        object.__setattr__(self, "size", sum(child.size for child in children))
        object.__setattr__(self, "depth", depth)

    def _absorbs(self, index: int, child: Shape) -> bool:
        """Whether the argument ``child`` can be replaced by its parts."""
        return type(child) is type(self)

    @property
    def exactness(self) -> str:
        """The nearest surface may be one that the operation removed, so even of exact shapes this is only a bound."""
        kinds = {child.exactness for child in self.children}
        if len(self.children) == 1:
            return kinds.pop()
        return NONE if NONE in kinds else BOUND

    @property
    def lipschitz(self) -> float:
        return max(child.lipschitz for child in self.children)

    def _combine(self, fields: list[Formula]) -> Formula:
        raise NotImplementedError

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._combine([child.build(p, slot) for child in self.children])

    def program(self, matrix: np.ndarray | None = None) -> np.ndarray:
        return combine(self.op, [child.program(matrix) for child in self.children])

    def volume(self) -> float | None:
        return self.children[0].volume() if len(self.children) == 1 else None

    def relation(self) -> str:
        return "" if self.children else f"{self.label()}: it has no shapes to combine: give it at least one."


@dataclass(frozen=True, init=False)
class Union(SetOperation):
    """All points that are in at least one of the shapes."""

    op = Op.UNION

    children: tuple[Shape, ...] = ()

    def _combine(self, fields):
        return minimum(*fields)

    def bounds(self, matrix=None):
        lows, highs = zip(*(child.bounds(matrix) for child in self.children))
        return np.min(lows, axis=0), np.max(highs, axis=0)


@dataclass(frozen=True, init=False)
class Intersection(SetOperation):
    """The points that are in all of the shapes."""

    op = Op.INTERSECTION

    children: tuple[Shape, ...] = ()

    def _combine(self, fields):
        return maximum(*fields)

    def bounds(self, matrix=None):
        lows, highs = zip(*(child.bounds(matrix) for child in self.children))
        low = np.max(lows, axis=0)
        return low, np.maximum(low, np.min(highs, axis=0))


@dataclass(frozen=True, init=False)
class Difference(SetOperation):
    """The first shape without the others."""

    op = Op.DIFFERENCE

    children: tuple[Shape, ...] = ()

    def _absorbs(self, index, child):
        return index == 0 and super()._absorbs(index, child)

    def _combine(self, fields):
        return maximum(fields[0], *(-field for field in fields[1:]))

    def bounds(self, matrix=None):
        return self.children[0].bounds(matrix)


@dataclass(frozen=True)
class Transformed(Shape, abstract=True):
    """A shape moved by an affine matrix: rotation, uneven scale, shear and mirroring included.

    The field is σ·φ(M⁻¹x) with σ the least singular value of M: M⁻¹ stretches no length by more than 1/σ, so the
    Lipschitz bound of φ remains one, and a bound on the distance remains one. Not in ``SHAPES``: artists move shapes
    with ``translate``, ``rotate`` and ``scale``, or with objects.
    """

    child: Shape
    matrix: tuple[tuple[float, ...], ...] = dataclasses.field(
        default=tuple(map(tuple, np.eye(4).tolist())),
        metadata=dict(description="4 × 4 matrix that takes the shape to its place"))

    def __post_init__(self):
        if not isinstance(self.child, Shape):
            raise ShapeError(f"Transformed moves a shape, not {self.child!r:.40}.")
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
    def exactness(self) -> str:
        largest, _, least = self._singular_values
        similar = largest - least <= _SIMILAR * largest
        return BOUND if self.child.exactness == EXACT and not similar else self.child.exactness

    @property
    def lipschitz(self) -> float:
        return self.child.lipschitz

    def build(self, p: Vector, slot: Slots) -> Formula:
        rows = [(slot(tuple(row[:3])), slot(row[3])) for row in np.linalg.inv(self._array)[:3].tolist()]
        moved = Vector(*(row.dot(p) + offset for row, offset in rows))
        return self.child.build(moved, slot) * slot(float(self._singular_values[-1]))

    @property
    def children(self) -> tuple[Shape, ...]:
        return (self.child,)

    @property
    def size(self) -> int:
        return self.child.size

    @property
    def depth(self) -> int:
        return 1 + self.child.depth

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

    def program(self, matrix=None):
        return self.child.program(self._total(matrix))
