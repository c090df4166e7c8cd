# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes and transforms for the emitter's tests."""

from dataclasses import dataclass

import numpy as np

from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.shapes import (
    Box,
    BoxFrame,
    Capsule,
    Cone,
    Cylinder,
    Difference,
    Ellipsoid,
    Intersection,
    Shape,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.base import part
from sdf_lights.sdf.shapes.blends import SmoothUnion
from sdf_lights.sdf.shapes.fractals import MengerSponge
from sdf_lights.sdf.shapes.layers import Onion
from sdf_lights.sdf.shapes.primitives import Frustum
from sdf_lights.sdf.shapes.warps import Twist


@dataclass(frozen=True)
class FieldOf(Shape, abstract=True):
    """A shape that hides its closed forms, so that its field is traced, sampled and measured."""

    child: Shape = part("The shape")

    def build(self, p, slot):
        return self.child.build(p, slot)

    def terms(self, matrix, factor):
        return self.child.terms(matrix, factor)

    def bounds(self, matrix=None):
        return self.child.bounds(matrix)

    @property
    def lipschitz(self):
        return self.child.lipschitz

    @property
    def certified(self):
        return self.child.certified


def moved(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def turned(angle, axis=2):
    matrix = np.eye(4)
    i, j = [k for k in range(3) if k != axis]
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
    return matrix


def scaled(x, y, z):
    return np.diag([x, y, z, 1.0])


def sheared(amount):
    matrix = np.eye(4)
    matrix[0, 1] = amount
    return matrix


PRIMITIVES = {
    "sphere": Sphere(0.8),
    "ellipsoid": Ellipsoid((0.9, 0.5, 0.3)),
    "box": Box((0.7, 0.4, 0.2)),
    "box_frame": BoxFrame((0.6, 0.5, 0.4), 0.08),
    "torus": Torus(0.7, 0.2),
    "horn_torus": Torus(0.5, 0.5),
    "capsule": Capsule(0.25, 0.9),
    "cylinder": Cylinder(0.4, 0.9),
    "cone": Cone(0.5, 0.9),
    "frustum": Frustum(0.2, 0.6, 0.9),
}

COMPOSITES = {
    "frame": Difference(Box((0.8, 0.8, 0.8)), Sphere(1.08)),
    "nested": Union(
        Difference(Torus(0.7, 0.3), Box((0.4, 2.0, 2.0))),
        Intersection(Sphere(0.5), Difference(Cylinder(0.3, 2.0), Transformed(Capsule(0.1, 0.5), turned(1.2, 0)))),
    ),
    "apart": Union(
        Transformed(Sphere(0.3), moved(-0.9)),
        Transformed(Cone(0.3, 0.8), moved(0.8) @ turned(0.5, 0)),
        Transformed(Torus(0.3, 0.1), moved(z=0.9)),
    ),
    "coincident": Difference(
        Union(Transformed(Box((0.3, 0.5, 0.4)), moved(-0.3)), Transformed(Box((0.4, 0.5, 0.4)), moved(0.4))),
        Transformed(Box((0.2, 0.5, 0.2)), moved(0.1, 0.0, 0.2)),
        Transformed(Cylinder(0.1, 0.8), moved(-0.4)),
    ),
    "thin": Difference(Sphere(0.8), Sphere(0.78)),
    "sponge": MengerSponge(0.7, 2.0),
    "carved_sponge": Difference(
        Transformed(MengerSponge(0.8, 3.0), turned(0.5, 0) @ sheared(0.3)),
        Transformed(Sphere(0.7), moved(0.5, 0.4, 0.3)),
        MengerSponge(0.5, 1.0),
    ),
    "twenty": Difference(
        Union(*(Transformed(Capsule(0.08, 1.4), turned(0.6 * k, 0) @ turned(0.35 * k, 1)) for k in range(8))),
        *(Transformed(Sphere(0.17), moved(*(0.5 * np.cos([k, 1.7 * k, 2.3 * k])))) for k in range(6)),
        *(Transformed(Torus(0.6, 0.03 + 0.01 * k), turned(0.9 * k, k % 3)) for k in range(6)),
    ),
}

SHAPES = {**PRIMITIVES, **COMPOSITES}

FIELDS = {
    "blob": SmoothUnion(
        Transformed(Sphere(0.4), moved(-0.4)),
        Transformed(Sphere(0.3), moved(0.3, 0.1)),
        Transformed(Box((0.1, 0.6, 0.2)), turned(0.5)),
        radius=0.3,
    ),
    "rings": Onion(Torus(0.6, 0.25), 0.05),
    "twisted": Twist(Box((0.3, 0.2, 0.7)), 2.0),
    # No Lipschitz bound is known for all of space.
    "formula": Expression("field(length(p) - 0.7 + 0.1 * sin(9 * p.x) * sin(9 * p.y) * sin(9 * p.z))").shape({}),
    "twenty_as_field": FieldOf(COMPOSITES["twenty"]),
}

LAMPS = {**SHAPES, **FIELDS}

PLACEMENTS = {
    "turned": moved(1.0, -2.0, 0.5) @ turned(0.7, 0) @ turned(0.3, 1),
    "uneven": turned(0.6, 2) @ scaled(2.0, 1.0, 0.5),
    "sheared": moved(0.2, 0.1, -0.3) @ sheared(1.5) @ turned(0.4, 1),
    "mirrored": turned(1.0, 1) @ scaled(-1.0, 1.3, 0.8),
    "stretched": turned(0.4, 0) @ scaled(100.0, 1.0, 0.01),
    "far": moved(1e4, -2e4, 3e4) @ turned(0.5, 2),
    "tiny": moved(3.0, 2.0, 1.0) @ scaled(1e-3, 1e-3, 1e-3),
}
