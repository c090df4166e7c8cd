# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The variables of a surface that formulas of materials have, and the surface a small step further.

World space, metres. ``kernels/shading/records.py`` says where each lies in memory.
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
"""Shading normal in object space as it was interpolated: not normalised, never flipped."""
BACKFACING = variable("backfacing")
"""1 where the viewer is behind the surface, else 0."""
BARYCENTRIC = variable("barycentric", 0), variable("barycentric", 1)
"""Coordinates of the second and third vertex of the triangle."""
RAY_KIND = variable("ray_kind")
"""``scene.Ray`` of the ray that has arrived; 0 where light sampling looks at emission."""
RAY_SINGULAR = variable("ray_singular")
RAY_LENGTH = variable("ray_length")
DEPTH = tuple(variable("depth", index) for index in range(5))
"""Bounces so far: all, diffuse, glossy, transmission, transparent."""

EDGES = _vector("dpdu"), _vector("dpdv")
"""From the first vertex of the triangle to the two others."""
BUMP_STEP = variable("bump_step")
"""A tenth of a pixel's width at the point."""


def where(value: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """``then`` where a number that is 0 or 1 is 1."""
    return select(value < 0.5, otherwise, then)


def footprint_axes() -> tuple[Vector, Vector]:
    """Unit vectors across each other in the plane of the triangle, along which Cycles has the sides of a pixel lie."""
    x, y, z = TRUE_NORMAL
    diagonal = maximum(abs(x - y), abs(x - z)) <= 0.0
    # Across (1, 1, 1), or across (−1, 1, 1) where the normal is along that.
    first = Vector(z - y, select(diagonal, x + z, x - z), select(diagonal, -x - y, y - x)).normalized()
    return first, TRUE_NORMAL.cross(first)


def shifted(formula: Formula, along: Vector, step: Formula = BUMP_STEP) -> Formula:
    """The formula ``step`` metres along a unit vector in the plane of the triangle."""
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
