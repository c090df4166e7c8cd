# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points on the bodies of lamps, for operators that use the bounds of an object. A light has no bounds in Blender."""

from __future__ import annotations

import functools

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.shapes import Shape
from ..lamp import shape_of

CELLS = 20  # cells along each side of a shape's bounding box
STEPS = 4  # steps towards the surface
NEAR = 0.05  # of a cell: points this near count as on the surface


@functools.lru_cache(maxsize=128)
def points_of(shape: Shape) -> np.ndarray:
    """Points (n, 3) on the surface of a shape, in its local space, even if it is thin; none if it is unbounded.

    Grid points near the surface move to it along the gradient of the field.
    """
    box = np.stack(shape.bounds())
    size = box[1] - box[0]
    if not np.isfinite(box).all() or not np.all(size > 0.0):
        return np.zeros((0, 3))
    cell = size / CELLS
    sides = [low + extent * (np.arange(CELLS) + 0.5) for low, extent in zip(box[0], cell)]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    diagonal, aside = float(np.linalg.norm(cell)), 1e-3 * float(cell.min())
    slope = shape.lipschitz if np.isfinite(shape.lipschitz) else np.inf
    points = points[np.abs(shape.distance(points)) <= slope * diagonal]
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            ahead = [shape.distance(points + side) - shape.distance(points - side) for side in aside * np.eye(3)]
            gradient = np.stack(ahead, axis=-1) / (2.0 * aside)
            steep = np.maximum(np.sum(gradient * gradient, axis=-1), 1e-30)
            step = (shape.distance(points) / steep)[:, None] * gradient
            points = (
                points - step * np.minimum(diagonal / np.maximum(np.linalg.norm(step, axis=-1), 1e-30), 1.0)[:, None]
            )
        off = np.abs(shape.distance(points)) / np.sqrt(steep)
    return points[(off <= NEAR * diagonal) & np.all((points >= box[0] - aside) & (points <= box[1] + aside), axis=-1)]


def is_lamp(obj: bpy.types.Object) -> bool:
    """Whether an object is an SDF lamp."""
    return obj.type == "LIGHT" and obj.data.sdf_lamp.use


def points_in_world(obj: bpy.types.Object) -> np.ndarray:
    """Points (n, 3) on the surface of a lamp in the world; none if it has no shape at present."""
    matrix = np.array(obj.matrix_world, np.float64)
    try:
        points = points_of(shape_of(obj.data.sdf_lamp, matrix))
    except (ArithmeticError, RenderError):
        return np.zeros((0, 3))
    return points @ matrix[:3, :3].T + matrix[:3, 3] if np.isfinite(matrix).all() else np.zeros((0, 3))
