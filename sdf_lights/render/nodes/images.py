# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures: image coordinates of a point, and the look-up."""

from __future__ import annotations

from ...graph.formula import Formula, Vector, call, clamp, minimum, select
from . import lookups
from .definition import NodeInputs, defines
from .geometry import to_object, transformed_normal
from .projections import projected
from .variables import NORMAL


def faces(vector: Vector, normal: Vector) -> list[tuple[Formula, Formula]]:
    """Image coordinates of a point on the faces of a cube across x, y and z, on the sides that face the normal: none of
    them is mirrored."""
    x, y, z = vector
    return [
        (select(normal.x < 0.0, 1.0 - y, y), z),
        (select(normal.y > 0.0, 1.0 - x, x), z),
        (select(normal.z > 0.0, 1.0 - y, y), x),
    ]


def face_weights(normal: Vector, blend: Formula) -> list[Formula]:
    """Weights of a cube's faces across x, y and z for a surface with this normal; their sum is 1.

    The absolute components of the normal, compared in pairs, are a point of a triangle whose corners are the faces. A
    face is alone if it has more than (1 + ``blend``) / 2 of its sum with either of the others. Two mix if the third has
    less than (1 - ``blend``) / 2 of its sum with them. In the middle all three mix.
    """
    n = Vector(*map(abs, normal))
    n = n * (1.0 / (n.x + n.y + n.z))
    limit = 0.5 * (1.0 + blend)

    def alone(axis: int) -> Formula:
        """Positive if the face is alone."""
        return minimum(*(n[axis] - limit * (n[axis] + n[other]) for other in range(3) if other != axis))

    def without(axis: int) -> Formula:
        """Positive if the other two mix."""
        return (1.0 - limit) * (n[axis - 2] + n[axis - 1]) - n[axis]

    def share(axis: int, other: int) -> Formula:
        """Weight of the face across ``axis`` if it mixes with one other."""
        return clamp((n[axis] / (n[axis] + n[other]) - 0.5 * (1.0 - blend)) / blend, 0.0, 1.0)

    weights = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        middle = ((2.0 - limit) * n[axis] + (limit - 1.0)) / (2.0 * limit - 1.0)
        # Pairs are tried in this order: the third is z, x, y.
        pairs = middle
        for third in (1, 0, 2):
            mixed = 0.0 if third == axis else _share_of_pair(share, axis, third)
            pairs = select(without(third) <= 0.0, pairs, mixed)
        both = select(minimum(-alone(a), -alone(b)) < 0.0, 0.0, pairs)
        weights.append(select(alone(axis) <= 0.0, both, 1.0))
    return weights


def _share_of_pair(share, axis: int, third: int) -> Formula:
    """Weight of the face across ``axis`` if all but the ``third`` mix."""
    first, second = {2: (0, 1), 0: (1, 2), 1: (0, 2)}[third]
    return share(first, second) if axis == first else 1.0 - share(first, second)


def sampled(node: NodeInputs, u: Formula, v: Formula) -> tuple[Formula, ...]:
    """RGBA of the node's image at image coordinates. The colour is divided by alpha if the node's alpha is used."""
    return call(lookups.IMAGE, node.image("Alpha" in node.wanted), u, v)


def _object_normal(node: NodeInputs) -> Vector:
    if node.setting("domain") == "WORLD":
        return NORMAL
    light = node.setting("light_matrix")
    return to_object(NORMAL, "NORMAL") if light is None else transformed_normal(node, light, NORMAL)


def _box(node: NodeInputs) -> list[Formula]:
    vector = node.vector("Vector")
    place = node.image("Alpha" in node.wanted, tiled=False)
    normal = _object_normal(node)
    sides = faces(vector, normal)
    if not node.setting("projection_blend"):
        # One face alone: that of the largest component; x if there are several.
        x, y, z = map(abs, normal)
        is_y, is_z = minimum(y - x, y - z), minimum(z - x, z - y)
        u, v = (select(is_z <= 0.0, select(is_y <= 0.0, a, b), c) for a, b, c in zip(*sides))
        return list(call(lookups.IMAGE, place, u, v))
    weights = face_weights(normal, node.parameter(float(node.setting("projection_blend"))))
    total = [0.0] * 4
    for weight, (u, v) in zip(weights, sides):
        # A face without weight is not looked up.
        found = call(lookups.IMAGE, select(weight <= 0.0, -1.0, place), u, v)
        total = [sum_ + weight * channel for sum_, channel in zip(total, found)]
    return total


@defines("ShaderNodeTexImage")
def image_texture(node: NodeInputs):
    """All projections."""
    projection = node.setting("projection")
    if projection == "BOX":
        r, g, b, a = _box(node)
    else:
        r, g, b, a = sampled(node, *projected(node.vector("Vector"), projection))
    return {"Color": Vector(r, g, b), "Alpha": a}
