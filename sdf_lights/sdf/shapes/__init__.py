# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shape, and ``SHAPES``, the registry by name."""

from .base import BOUND, EXACT, NONE, SHAPES, Family, Parameter, Shape, ShapeError, Term
from .primitives import Box, BoxFrame, Capsule, Cone, Cylinder, Ellipsoid, Primitive, Sphere, Torus
from .operators import Difference, Intersection, SetOperation, Transformed, Union

__all__ = [
    "BOUND", "EXACT", "NONE", "SHAPES", "Family", "Parameter", "Shape", "ShapeError", "Term",
    "Difference", "Intersection", "SetOperation", "Transformed", "Union",
    "Box", "BoxFrame", "Capsule", "Cone", "Cylinder", "Ellipsoid", "Primitive", "Sphere", "Torus"]
