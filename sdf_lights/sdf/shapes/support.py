# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tight boxes from support functions.

The support of a set along a direction d is the greatest d · x of its points x. That of the convex hull is the same.
That of a union is the greater of two. That of a Minkowski sum (a ball around every point, for example) is the sum of
two. Directions are (n, 3) arrays and need not have unit length; supports are (n,).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def bounds(support: Callable[[np.ndarray], np.ndarray], matrix: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Corners (low, high) of the smallest axis-aligned box around ``matrix`` (4 × 4, None for the identity) applied to
    the set with the given support function."""
    matrix = np.eye(4) if matrix is None else np.asarray(matrix, np.float64)
    linear, center = matrix[:3, :3], matrix[:3, 3]
    # The greatest eᵢ · Mx is that of (Mᵀeᵢ) · x, and Mᵀeᵢ is row i of M.
    low, high = np.split(support(np.concatenate([-linear, linear])), 2)
    return center - low, center + high


def of_points(directions: np.ndarray, points) -> np.ndarray:
    """Support of points (m, 3), and so of any polyhedron with these corners."""
    return (directions @ np.asarray(points, np.float64).T).max(axis=1)


def of_ball(directions: np.ndarray, radius: float) -> np.ndarray:
    """Support (n,), in directions (n, 3), of a ball around the origin."""
    return radius * np.linalg.norm(directions, axis=1)


def of_segment(directions: np.ndarray, half_length: float) -> np.ndarray:
    """Support (n,), in directions (n, 3), of the part of the z axis within ``half_length`` of the origin."""
    return half_length * np.abs(directions[:, 2])


def of_disk(directions: np.ndarray, radius: float) -> np.ndarray:
    """Support (n,), in directions (n, 3), of a disk in the xy plane, around the origin."""
    return radius * np.hypot(directions[:, 0], directions[:, 1])


def of_cap(directions: np.ndarray, radius: float, height: float) -> np.ndarray:
    """Support (n,), in directions (n, 3), of the part above z = ``height`` of a sphere around the origin."""
    length = np.linalg.norm(directions, axis=1)
    rim = of_disk(directions, np.sqrt(max(radius**2 - height**2, 0.0))) + height * directions[:, 2]
    return np.where(directions[:, 2] * radius >= height * length, radius * length, rim)
