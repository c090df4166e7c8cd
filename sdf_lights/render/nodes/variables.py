# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The variables of a surface in formulas of materials, and the surface one small step further.

World space, metres. ``kernels/shading/records.py`` has their positions in memory.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...graph.formula import Formula, Vector, maximum, select, variable
from ...graph.substitution import rewritten


def _vector(name: str) -> Vector:
    return Vector(*(variable(name, axis) for axis in range(3)))


POSITION = _vector("position")
INCOMING = _vector("incoming")
"""Unit vector towards the viewer."""
NORMAL = _vector("normal")
"""Unit shading normal, on the side of the viewer."""
TRUE_NORMAL = _vector("true_normal")
"""Unit geometric normal, on the side of the viewer."""
OBJECT_NORMAL = _vector("object_normal")
"""Interpolated shading normal in object space: not normalised, never flipped."""
BACKFACING = variable("backfacing")
"""1 if the viewer is behind the surface, else 0."""
BARYCENTRIC = variable("barycentric", 0), variable("barycentric", 1)
"""Barycentric coordinates of the second and third vertex of the triangle."""
RAY_KIND = variable("ray_kind")
"""``scene.Ray`` of the incoming ray; 0 when light sampling evaluates emission."""
RAY_SINGULAR = variable("ray_singular")
RAY_LENGTH = variable("ray_length")
DEPTH = tuple(variable("depth", index) for index in range(5))
"""Bounces so far: all, diffuse, glossy, transmission, transparent."""

EDGES = _vector("dpdu"), _vector("dpdv")
"""From the first vertex of the triangle to the two others."""
BUMP_STEP = variable("bump_step")
"""A tenth of a pixel's width at the point."""


def where(value: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """``then`` if a number, which is 0 or 1, is 1."""
    return select(value < 0.5, otherwise, then)


def footprint_axes() -> tuple[Vector, Vector]:
    """Perpendicular unit vectors in the plane of the triangle, which Cycles uses as the sides of a pixel."""
    x, y, z = TRUE_NORMAL
    diagonal = maximum(abs(x - y), abs(x - z)) <= 0.0
    # Perpendicular to (1, 1, 1), or to (−1, 1, 1) if the normal is along that.
    first = Vector(z - y, select(diagonal, x + z, x - z), select(diagonal, -x - y, y - x)).normalized()
    return first, TRUE_NORMAL.cross(first)


def shifted(formula: Formula, along: Vector, step: Formula = BUMP_STEP) -> Formula:
    """The formula at ``step`` metres along a unit vector in the plane of the triangle."""
    moved = {POSITION[axis]: POSITION[axis] + along[axis] * step for axis in range(3)}
    # The vector as a sum of both edges: Cramer's rule, in the direction of the normal.
    normal = EDGES[0].cross(EDGES[1])
    share = step / maximum(normal.dot(normal), 1e-300)
    for index, other in enumerate((along.cross(EDGES[1]), EDGES[0].cross(along))):
        moved[BARYCENTRIC[index]] = BARYCENTRIC[index] + other.dot(normal) * share
    return rewritten((formula,), moved, lambda node: node)[0]


def as_vector(values: Sequence[Formula]) -> Vector:
    """The first three of the values."""
    return Vector(*values[:3])
