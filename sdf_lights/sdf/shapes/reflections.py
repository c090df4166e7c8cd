# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mirror symmetry of regular solids: reflections that lead every point into one chamber.

Cutting space along all planes of symmetry leaves the chambers; H. S. M. Coxeter, "Regular Polytopes", chapter 5, has
the groups. Points in the chamber stay. The maps are continuous and change no length locally.
"""

from __future__ import annotations

import math

from ...graph.formula import Vector, maximum, minimum

GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))


def reflected(p: Vector, normal: tuple[float, float, float]) -> Vector:
    """p, or its mirror image if it is behind the plane through the origin with this unit normal."""
    behind = minimum(p.dot(normal), 0.0)
    return Vector(*(q - behind * (2.0 * component) for q, component in zip(p, normal)))


def into_tetrahedral_chamber(p: Vector) -> Vector:
    """p with z ≥ y ≥ |x|: one of 24 chambers, between (0, 0, 1), (1, 1, 1) and (−1, 1, 1)."""
    # Reflections in z = ±y, then in y = ±x, of which the latter may leave y above z.
    a, b = abs(p.z + p.y), abs(p.z - p.y)
    z, y = (a + b) * 0.5, (a - b) * 0.5
    a, b = abs(y + p.x), abs(y - p.x)
    y, x = (a + b) * 0.5, (a - b) * 0.5
    return Vector(x, minimum(y, z), maximum(y, z))


def into_octahedral_chamber(p: Vector) -> Vector:
    """p with z ≥ y ≥ x ≥ 0: one of 48 chambers, between (0, 0, 1), (0, 1, 1) and (1, 1, 1)."""
    a, b, c = abs(p)
    return Vector(minimum(a, b, c), maximum(minimum(a, b), minimum(maximum(a, b), c)), maximum(a, b, c))


def into_icosahedral_chamber(p: Vector) -> Vector:
    """p in one of 120 chambers, between (0, 0, 1), (1, 0, φ) and (0, 1/φ, φ), with the golden ratio φ.

    These directions are axes of order 2, of order 5 and of order 3.
    """
    # An octant has 15 chambers. No sequence of fewer than five reflections maps them all to one. Of those that do, this
    # one has the most in coordinate planes.
    long, short = 0.5 * GOLDEN, 0.5 / GOLDEN
    p = reflected(reflected(abs(p), (0.5, -long, short)), (-long, -short, 0.5))
    return reflected(Vector(abs(p.x), abs(p.y), p.z), (-0.5, -long, short))
