# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed-form programs of the solids that cut others: half spaces, sectors and cones.

``matrix`` (4 × 4, None for the identity) transforms the whole, as in ``Shape.program``.
"""

from __future__ import annotations

import math

import numpy as np

from ..program import Op, combine, primitive

_FLAT = 1e-9  # cosine of the half angle below which a cone is a half space


def placed(matrix: np.ndarray | None, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """``matrix`` after a translation by (x, y, z)."""
    moved = np.eye(4)
    moved[:3, 3] = x, y, z
    return moved if matrix is None else matrix @ moved


def half_space(matrix: np.ndarray | None, normal, offset: float = 0.0) -> np.ndarray:
    """Program (instructions,), transformed by ``matrix`` (4 × 4), of {x : normal · x ≤ offset}; the normal need not
    have unit length."""
    normal = np.asarray(normal, np.float64)
    length = np.linalg.norm(normal)
    axis = normal / length
    frame = np.eye(4)
    frame[:3, 0] = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    frame[:3, 0] /= np.linalg.norm(frame[:3, 0])
    frame[:3, 1] = np.cross(axis, frame[:3, 0])
    frame[:3, 2] = axis
    frame[:3, 3] = axis * (offset / length)
    return primitive(Op.HALF_SPACE, frame if matrix is None else matrix @ frame, ())


def polyhedron(matrix: np.ndarray | None, normals, offsets) -> np.ndarray:
    """Program of {x : nᵢ · x ≤ offsetᵢ for all i}, with normals (n, 3) and offsets (n,) or one for all."""
    offsets = np.broadcast_to(offsets, len(normals))
    return combine(Op.INTERSECTION, [half_space(matrix, n, offset) for n, offset in zip(normals, offsets)])


def sector(matrix: np.ndarray | None, angle: float) -> np.ndarray:
    """Program, transformed by ``matrix`` (4 × 4), of the points less than angle/2 (radians) around the z axis from the
    half plane of positive x."""
    sine, cosine = math.sin(0.5 * angle), math.cos(0.5 * angle)
    sides = [half_space(matrix, (-sine, cosine, 0.0)), half_space(matrix, (-sine, -cosine, 0.0))]
    return combine(Op.INTERSECTION if angle <= math.pi else Op.UNION, sides)


def within_cone(body: np.ndarray, matrix: np.ndarray | None, angle: float, reach: float) -> np.ndarray:
    """Program, transformed by ``matrix`` (4 × 4), of the part of ``body``, itself a program, that is less than angle/2
    (radians) away from the positive z axis.

    The body must lie within ``reach`` of the origin.
    """
    cosine, sine = math.cos(0.5 * angle), math.sin(0.5 * angle)
    if abs(cosine) < _FLAT:
        return combine(Op.INTERSECTION, [body, half_space(matrix, (0.0, 0.0, -1.0))])
    height = math.copysign(2.0 * reach, cosine)
    opening = placed(matrix, z=0.5 * height) @ np.diag([1.0, 1.0, -math.copysign(1.0, cosine), 1.0])
    cone = primitive(Op.CONE, opening, (abs(height * sine / cosine), abs(height)))
    return combine(Op.INTERSECTION if cosine > 0.0 else Op.DIFFERENCE, [body, cone])
