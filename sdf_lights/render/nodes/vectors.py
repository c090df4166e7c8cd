# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that move and rotate vectors."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Vector, call, constant, cos, select, sin
from . import lookups
from .definition import NodeInputs, defines
from .geometry import transformed
from .maths import divide, each
from .variables import as_vector


def turned(vector: Vector, angles: Vector, back: bool = False) -> Vector:
    """Rotated about x, then y, then z; ``back``: the inverse."""
    axes = range(3)
    for axis in reversed(axes) if back else axes:
        i, j = (axis + 1) % 3, (axis + 2) % 3
        c, s = cos(angles[axis]), sin(angles[axis])
        if back:
            s = -s
        values = list(vector)
        values[i], values[j] = c * vector[i] - s * vector[j], s * vector[i] + c * vector[j]
        vector = Vector(*values)
    return vector


@defines("ShaderNodeMapping", modes=("POINT", "TEXTURE", "VECTOR", "NORMAL"))
def mapping(node: NodeInputs):
    """All types."""
    vector, rotation, scale = (node.vector(name) for name in ("Vector", "Rotation", "Scale"))
    kind = node.setting("vector_type")
    if kind == "TEXTURE":
        return {"Vector": each(divide, turned(vector - node.vector("Location"), rotation, back=True), scale)}
    if kind == "NORMAL":
        return {"Vector": turned(each(divide, vector, scale), rotation).normalized()}
    vector = turned(vector * scale, rotation)
    return {"Vector": vector + node.vector("Location") if kind == "POINT" else vector}


_AXES = {"X_AXIS": (1.0, 0.0, 0.0), "Y_AXIS": (0.0, 1.0, 0.0), "Z_AXIS": (0.0, 0.0, 1.0)}


@defines("ShaderNodeVectorRotate", modes=("AXIS_ANGLE", *_AXES, "EULER_XYZ"))
def vector_rotate(node: NodeInputs):
    """All types, with *Invert*."""
    kind, inverts = node.setting("rotation_type"), node.setting("invert")
    vector, center = node.vector("Vector"), node.vector("Center")
    arm = vector - center
    if kind == "EULER_XYZ":
        return {"Vector": turned(arm, node.vector("Rotation"), back=inverts) + center}
    angle = node.number("Angle")
    cosine, sine = cos(angle), -sin(angle) if inverts else sin(angle)
    if kind in _AXES:
        return {"Vector": arm.rotated(map(constant, _AXES[kind]), cosine, sine) + center}
    axis = node.vector("Axis")
    around = arm.rotated(axis.normalized(), cosine, sine) + center
    length = axis.length()
    return {"Vector": each(lambda a, b: select(length <= 0.0, a, b), vector, around)}


_TO_WORLD = {"OBJECT": lookups.FROM_OBJECT, "CAMERA": lookups.FROM_CAMERA}
_FROM_WORLD = {"OBJECT": lookups.TO_OBJECT, "CAMERA": lookups.TO_CAMERA}


def _by_matrix(node: NodeInputs, matrix: np.ndarray, kind: str, vector: Vector) -> Vector:
    """A point, vector or normal by a matrix (4, 4) of parameters."""
    linear = np.linalg.inv(matrix[:3, :3]).T if kind == "NORMAL" else matrix[:3, :3]
    offset = matrix[:3, 3] * (kind == "POINT")
    return transformed(node, np.column_stack([linear, offset]), vector)


@defines("ShaderNodeVectorTransform", modes=("POINT", "VECTOR", "NORMAL"))
def vector_transform(node: NodeInputs):
    """Between world, object and camera. The world has no object space of its own."""
    kind, start, end = (node.setting(name) for name in ("vector_type", "convert_from", "convert_to"))
    vector, light = node.vector("Vector"), node.setting("light_matrix")
    if start == end:
        return {"Vector": vector}
    for space, functions in ((start, _TO_WORLD), (end, _FROM_WORLD)):
        if space == "WORLD" or (space == "OBJECT" and node.setting("domain") == "WORLD"):
            continue
        if space == "OBJECT" and light is not None:
            matrix = np.vstack([light, (0.0, 0.0, 0.0, 1.0)])
            vector = _by_matrix(node, np.linalg.inv(matrix) if functions is _TO_WORLD else matrix, kind, vector)
        else:
            vector = as_vector(call(functions[space][kind], *vector))
        if kind == "NORMAL":
            vector = vector.normalized()
    return {"Vector": vector}


@defines("ShaderNodeNormal")
def normal(node: NodeInputs):
    """Both outputs."""
    direction = node.own("Normal").normalized()
    return {"Normal": direction, "Dot": direction.dot(node.vector("Normal").normalized())}
