# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Radial tiling: the plane divided into the segments of a polygon with round corners.

A segment lies between two rays from the middle to corners. Its side is at distance 1. A corner is a circle tangent to
both sides; roundness tells where on half a side it begins, 0 at the corner and 1 in the middle. If the number of sides
is not whole, the last segment is narrower, and its two corners lie between sides of different lengths. Its side is then
nearer, so that its corners are as far away as all others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...graph.formula import (
    Formula,
    Vector,
    apply,
    atan2,
    clamp,
    constant,
    cos,
    floor,
    length,
    maximum,
    select,
    sin,
    sqrt,
    tan,
)
from .definition import NodeInputs, defines
from .maths import where_zero


class _Half(NamedTuple):
    """Half of a segment, from the middle of its side to a corner, in angles at the middle of the polygon."""

    roundness: Formula
    straight: Formula  # from the middle of the side to the round part
    tangent: Formula  # the length of that part
    bevel: Formula  # from the round part to the corner
    soft: Formula  # the part of that over which the coordinate along the side changes from lengths to angles

    def width(self, distance: Formula) -> Formula:
        """Length of the whole half if the side is at ``distance``."""
        return distance * self.tangent + self.soft * (0.5 * distance + 0.5) + self.roundness * self.bevel


def _half(angle: Formula, roundness: Formula) -> _Half:
    tangent = (1.0 - roundness) * tan(angle)
    straight = apply("atan", tangent)
    bevel = angle - straight
    return _Half(roundness, straight, tangent, bevel, (1.0 - roundness) * bevel)


def _corner_distance(away: Formula, own: Formula, other: Formula, roundness: Formula) -> Formula:
    """Distance of a round corner in a direction, if the side of ``other`` (half an angle) is at distance 1.

    ``away`` is the angle from the corner, positive on the side of ``own``.
    """
    radius = roundness * tan(other) / tan(0.5 * (own + other))
    x = cos(other) + (1.0 - roundness) * sin(other) * tan(other) - radius * cos(other)
    y = (radius - roundness) * sin(other)
    along = sin(away) * y + cos(away) * x
    return along + sqrt(maximum(along * along + radius * radius - x * x - y * y, 0.0))


def tiling(x: Formula, y: Formula, sides: Formula, roundness: Formula, normalizes: bool) -> dict[str, Formula | Vector]:
    """Outputs of the node at (x, y)."""
    sides, roundness = maximum(sides, 2.0), clamp(roundness, 0.0, 1.0)
    turn, distance = 2.0 * math.pi, length(x, y)
    around = where_zero(distance, 0.0, atan2(y, x))
    around = select(y < 0.0, around + turn, around)
    full, whole = math.pi / sides, floor(sides)
    # Half the angle of the last segment, or that of all segments if they are equal.
    rest = select(sides <= whole, full, math.pi - whole * full)
    index = floor(around / (2.0 * full))
    last = select(sides <= whole, 0.0, select(whole <= index, 1.0, 0.0))

    def in_last(then: Formula, otherwise: Formula) -> Formula:
        return select(last < 0.5, otherwise, then)

    angle = in_last(rest, full)
    signed = around - index * 2.0 * full - angle  # from the middle of the side
    away = angle - abs(signed)  # from the nearest corner
    # The corners of the last segment are the first of the first segment and the last of the one before it.
    nearest = index + select(signed < 0.0, 0.0, 1.0)
    uneven = maximum(last, select(nearest <= 0.0, 1.0, select(whole <= nearest, 1.0, 0.0)))
    beside = select(uneven < 0.5, full, rest)
    scale = cos(full) / cos(beside)  # scale of lengths that puts the side beside the corner at distance 1
    own_scale = in_last(scale, constant(1.0))
    half = _half(angle, in_last(roundness, roundness * sin(beside) / sin(full)))

    at_corner = distance / _corner_distance(in_last(-away, away), full, beside, roundness)
    round_ = select(away < half.bevel, 1.0, 0.0)

    def in_corner(then: Formula, otherwise: Formula) -> Formula:
        return select(round_ < 0.5, otherwise, then)

    # Distance of the side through the point, where the segment's own is at 1.
    level = in_corner(at_corner * scale / own_scale, distance * cos(signed))
    beyond = half.bevel - away
    adjacent = distance * cos(half.straight)
    softened = adjacent * beyond + 0.5 * (1.0 - adjacent) * beyond * beyond / half.soft
    curved = select(beyond < half.soft, softened, half.soft * 0.5 * (adjacent - 1.0) + beyond)
    along = in_corner(distance * sin(half.straight) + curved, level * tan(abs(signed)))
    if normalizes:
        straight = half.width(level)
        at_point = distance * sin(half.straight) + half.soft * 0.5 * (adjacent + 1.0) + half.roundness * half.bevel
        blend = where_zero(half.bevel, 0.0, beyond / half.bevel)
        divisor = in_corner(straight + blend * (at_point - straight), straight)
        two = select(maximum(sides - 2.0, roundness) <= 0.0, 1.0, 0.0)  # its sides are parallel and infinite
        along = select(two < 0.5, along / divisor, along)
    else:
        along = along * own_scale
    along = select(signed < 0.0, -along, along)
    level = level * own_scale
    along = where_zero(distance, 0.0, along)
    flat, ridge = (0.5 * along + 0.5, level) if normalizes else (along, level - 1.0)

    # The widths are those of the corners between equal sides.
    even, narrow = _half(full, roundness), _half(rest, roundness)
    narrow_width = narrow.tangent + narrow.soft * (0.5 + 0.5 * scale) + scale * roundness * narrow.bevel
    width = in_last(narrow_width, even.width(constant(1.0)))
    return {
        "Segment Coordinates": Vector(flat, ridge, constant(0.0)),
        "Segment ID": floor(sides * around * (1.0 / turn)),
        "Segment Width": select(maximum(sides - 2.0, roundness) <= 0.0, 0.0, width),
        "Segment Rotation": index * 2.0 * full + angle,
    }


@defines("ShaderNodeRadialTiling")
def radial_tiling(node: NodeInputs):
    """All outputs, with *Normalize* (since Blender 5.0)."""
    vector = node.vector("Vector")
    return tiling(vector.x, vector.y, node.number("Sides"), node.number("Roundness"), node.setting("normalize"))
