# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Environment textures: pictures of all directions."""

from __future__ import annotations

import math

from ...graph.formula import Formula, Vector, acos, atan2, clamp, maximum, select, sqrt
from .definition import NodeInputs, defines
from .images import sampled


def equirectangular(direction: Vector) -> tuple[Formula, Formula]:
    """Image coordinates of a unit vector: −X at both sides, +X in the middle, +Y a quarter to the left of it, +Z at the
    top.

    The zero vector gets the lower left corner.
    """
    u = 0.5 - atan2(direction.y, direction.x) * (0.5 / math.pi)
    v = 1.0 - acos(clamp(direction.z, -1.0, 1.0)) * (1.0 / math.pi)
    nothing = abs(direction.x) + abs(direction.y) + abs(direction.z) <= 0.0
    return select(nothing, 0.0, u), select(nothing, 0.0, v)


def mirror_ball(direction: Vector) -> tuple[Formula, Formula]:
    """Image coordinates of a unit vector, in a picture of a mirror ball seen along +Y."""
    towards = 1.0 - direction.y
    width = sqrt(maximum(2.0 * towards, 0.0))
    share = select(width <= 0.0, 1.0, 1.0 / width)
    return 0.5 * (direction.x * share + 1.0), 0.5 * (direction.z * share + 1.0)


@defines("ShaderNodeTexEnvironment")
def environment_texture(node: NodeInputs):
    """Equirectangular and mirror ball. Beyond its edges the picture repeats, as in Cycles."""
    direction = node.vector("Vector").normalized()
    project = mirror_ball if node.setting("projection") == "MIRROR_BALL" else equirectangular
    r, g, b, _ = sampled(node, *project(direction))
    return {"Color": Vector(r, g, b)}
