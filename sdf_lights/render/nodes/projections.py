# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Image coordinates of directions and points: on spheres and tubes, and in the light of lights."""

from __future__ import annotations

import math

from ...graph.formula import Formula, Vector, acos, atan2, clamp, length, select
from .definition import NodeInputs
from .variables import INCOMING, NORMAL, POSITION


def sphere_place(x: Formula, y: Formula, z: Formula) -> tuple[Formula, Formula]:
    """Image coordinates of a direction on a sphere around it."""
    distance = length(x, y, z)
    return _around(x, y), select(distance <= 0.0, 0.0, 1.0 - acos(clamp(z / distance, -1.0, 1.0)) * (1.0 / math.pi))


def _around(x: Formula, y: Formula) -> Formula:
    return select(abs(x) + abs(y) <= 0.0, 0.0, 0.5 - atan2(x, y) * (0.5 / math.pi))


def projected(vector: Vector, projection: str) -> tuple[Formula, Formula]:
    """Image coordinates of a point of the unit cube, on a sphere or a tube around its middle."""
    if projection not in ("SPHERE", "TUBE"):
        return vector.x, vector.y
    x, y, z = vector * 2.0 - 1.0
    return (_around(x, y), 0.5 * (z + 1.0)) if projection == "TUBE" else sphere_place(x, y, z)


def light_place(node: NodeInputs) -> tuple[Formula, Formula]:
    """Image coordinates of the light of a light, as in Cycles: of the direction on a sphere for point lights, of the
    direction in the cone of spot lights and suns, which the picture fills, of the point on area lights.

    The setting "light_shape" is "POINT"; "SPOT" and "SUN" with their angle; or "AREA" with the lengths of its sides.
    """
    kind, *sizes = node.setting("light_shape")
    matrix = [[node.parameter(float(entry)) for entry in row] for row in node.setting("light_matrix")]

    def local(vector: Vector, is_point: bool = False) -> Vector:
        return Vector(
            *(
                row[0] * vector.x + row[1] * vector.y + row[2] * vector.z + (row[3] if is_point else 0.0)
                for row in matrix
            )
        )

    if kind == "POINT":
        return sphere_place(*local(NORMAL))
    if kind == "AREA":
        across = local(POSITION, is_point=True)
        return tuple(0.5 + clamp(axis / node.parameter(float(size)), -0.5, 0.5) for axis, size in zip(across, sizes))
    (angle,) = sizes
    towards = local(INCOMING).normalized()
    if kind == "SPOT":
        factor = node.parameter(0.5 / math.tan(0.5 * angle)) / -towards.z
    else:  # equal areas of the picture are equal solid angles
        factor = node.parameter(-0.5 / math.sin(0.25 * angle) if angle > 0.0 else 0.0)
        factor = factor / length(towards.x, towards.y, towards.z - 1.0)
    return 0.5 + towards.x * factor, 0.5 + towards.y * factor
