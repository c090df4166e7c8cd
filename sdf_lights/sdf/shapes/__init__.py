# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shape, and ``SHAPES``, the registry by name."""

from .base import BOUND, EXACT, NONE, SHAPES, Family, Parameter, Shape, ShapeError, Term
from .primitives import Box, BoxFrame, Capsule, Cone, Cylinder, Ellipsoid, Primitive, Sphere, Torus
from . import balls, polyhedra, solids
from .field import Field
from .operators import Difference, Exclusive, Intersection, Operator, SetOperation, Transformed, Union
from . import coils, curved, minimal_surfaces, swept, tubes
from . import fractals, orbits
from . import blends, displacement, folds, layers, repetition, warps  # all in SHAPES

__all__ = [
    "BOUND",
    "EXACT",
    "NONE",
    "SHAPES",
    "Family",
    "Parameter",
    "Shape",
    "ShapeError",
    "Term",
    "Difference",
    "Exclusive",
    "Intersection",
    "Operator",
    "SetOperation",
    "Transformed",
    "Union",
    "Box",
    "BoxFrame",
    "Capsule",
    "Cone",
    "Cylinder",
    "Ellipsoid",
    "Primitive",
    "Sphere",
    "Torus",
]
