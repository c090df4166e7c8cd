# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes made by operators, for the tests of every shape: each operator on several kinds of children."""

import numpy as np

from sdf_lights.sdf.shapes import (
    Box,
    BoxFrame,
    Cone,
    Cylinder,
    Difference,
    Ellipsoid,
    Exclusive,
    Intersection,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.blends import (
    ChamferDifference,
    ChamferIntersection,
    ChamferUnion,
    CircularDifference,
    CircularIntersection,
    CircularUnion,
    CubicDifference,
    CubicIntersection,
    CubicUnion,
    ExponentialDifference,
    ExponentialIntersection,
    ExponentialUnion,
    Morph,
    RoundDifference,
    RoundIntersection,
    RoundUnion,
    SmoothDifference,
    SmoothIntersection,
    SmoothUnion,
    StairsDifference,
    StairsIntersection,
    StairsUnion,
)
from sdf_lights.sdf.shapes.displacement import NoiseDisplacement, WaveDisplacement
from sdf_lights.sdf.shapes.folds import IcosahedralFold, Kaleidoscope, Mirror, OctahedralFold, TetrahedralFold
from sdf_lights.sdf.shapes.layers import Elongate, Offset, Onion, Round, Shell
from sdf_lights.sdf.shapes.repetition import PolarRepetition, Repetition
from sdf_lights.sdf.shapes.solids import HalfSpace, Slab
from sdf_lights.sdf.shapes.warps import Bend, Taper, Twist


def moved(shape, x, y, z, size=1.0):
    matrix = np.diag([size, size, size, 1.0])
    matrix[:3, 3] = x, y, z
    return Transformed(shape, matrix)


SHEAR = np.array([(1.0, 0.4, 0.0, 0.3), (0.0, 0.8, -0.5, -0.2), (0.2, 0.0, 1.3, 0.1), (0.0, 0.0, 0.0, 1.0)])
CORNER = Difference(Box((0.5, 0.4, 0.3)), moved(Sphere(0.4), 0.4, 0.3, 0.3))
SHEARED = Transformed(Ellipsoid((0.6, 0.3, 0.2)), SHEAR)
PAIR = Union(Cylinder(0.15, 1.0), moved(Torus(0.3, 0.1), 0.1, 0.0, 0.2))

OPERATED = {
    "xor": Exclusive(Box(0.5), SHEARED, moved(Torus(0.4, 0.1), 0.3, 0.0, 0.1)),
    "smooth union": SmoothUnion(Box(0.4), SHEARED, moved(Torus(0.5, 0.15), 0.2, 0.3, 0.0), radius=0.3),
    "circular union": CircularUnion(CORNER, Sphere(0.4), radius=0.4),
    "exponential union": ExponentialUnion(Box(0.3), moved(Cone(), 0.2, 0.1, 0.3), radius=0.5),
    "chamfer union": ChamferUnion(Cylinder(0.2, 1.5), Box((0.5, 0.5, 0.1)), radius=0.2),
    "smooth difference": SmoothDifference(Box(0.5), SHEARED, Sphere(0.3), radius=0.1),
    "stairs difference": StairsDifference(Box(0.5), Sphere(0.6), radius=0.2, steps=3.0),
    "cubic intersection": CubicIntersection(Box(0.4), Sphere(0.5), Slab(0.5), radius=0.3),
    "blend of blends": SmoothDifference(
        SmoothUnion(CORNER, PAIR, radius=0.1), ChamferUnion(SHEARED, Sphere(0.2)), radius=0.05
    ),
    "cubic and smooth": CubicDifference(
        SmoothIntersection(Box(0.5), SHEARED, radius=0.1),
        CubicUnion(Sphere(0.2), moved(Torus(0.3, 0.1), 0.3, 0.0, 0.1), radius=0.2),
        radius=0.05,
    ),
    "circular and exponential": ExponentialDifference(
        CircularIntersection(Box(0.5), Sphere(0.6), radius=0.2),
        ExponentialIntersection(Cylinder(0.2, 2.0), moved(Box(0.3), 0.1, 0.0, 0.2), radius=0.1),
        radius=0.2,
    ),
    "circular and round": RoundDifference(
        RoundUnion(Box((0.5, 0.5, 0.1)), Cylinder(0.2, 1.2), radius=0.2),
        CircularDifference(Sphere(0.4), CORNER, radius=0.1),
        radius=0.1,
    ),
    "chamfers and stairs": ChamferDifference(
        StairsUnion(Box((0.6, 0.4, 0.1)), Cylinder(0.15, 1.0), radius=0.3, steps=2.0),
        ChamferIntersection(
            RoundIntersection(Sphere(0.3), Box(0.25), radius=0.1),
            StairsIntersection(Cylinder(0.3, 0.4), SHEARED, radius=0.1, steps=4.0),
            radius=0.05,
        ),
        radius=0.1,
    ),
    "morph": Morph(CORNER, SHEARED, 0.3),
    "grown frame": Offset(BoxFrame(0.5, 0.1), 0.05),
    "grown, sheared": Offset(SHEARED, 0.1),
    "shrunk": Offset(PAIR, -0.05),
    "rounded": Round(CORNER, 0.1),
    "onion of an onion": Onion(Onion(CORNER, 0.1), 0.02),
    "shell, cut": Difference(Shell(SHEARED, 0.03), HalfSpace((1.0, 0.5, 0.2), -0.1)),
    "elongated": Elongate(moved(CORNER, 0.1, 0.05, 0.0), (0.3, 0.0, 0.2)),
    "mirror image": Mirror(moved(CORNER, 0.2, 0.0, 0.1), (1.0, 0.5, 0.2)),
    "smooth mirror image": Mirror(Transformed(CORNER, SHEAR), (0.0, 1.0, 0.0), 0.1),
    "kaleidoscope": Kaleidoscope(moved(Transformed(Cone(0.3, 0.8), SHEAR), 0.6, 0.1, 0.0), 5.0),
    "tetrahedral": TetrahedralFold(moved(CORNER, 0.1, 0.3, 0.6)),
    "octahedral": OctahedralFold(moved(SHEARED, 0.0, 0.2, 0.7)),
    "icosahedral": IcosahedralFold(moved(Intersection(Sphere(0.3), Box((0.2, 0.2, 0.3))), 0.1, 0.0, 0.8)),
    "ring": PolarRepetition(moved(CORNER, 0.9, 0.2, 0.1), 7.0),
    "ring, overlapping": PolarRepetition(moved(Box((0.6, 0.4, 0.2)), 0.7, 0.0, 0.0), 9.0),
    "grid": Repetition(PAIR, (3.0, 2.0, 1.0), (0.7, 1.1, 1.0)),
    "grid of many": Repetition(Sphere(0.4), (5.0, 6.0, 4.0), (0.7, 0.9, 1.0)),
    "grid of many bounds": Repetition(moved(CORNER, 0.4, 0.1, 0.0), (5.0, 6.0, 4.0), (0.7, 0.9, 1.0)),
    "endless, cut": Intersection(Repetition(PAIR, (0.0, 0.0, 1.0), (0.9, 1.2, 1.0)), Cylinder(2.0, 3.0)),
    "mirrored apart": OctahedralFold(moved(Sphere(0.1), 0.2, 0.5, 0.9)),
    "ring apart": PolarRepetition(moved(Torus(0.2, 0.1), 1.0, 0.0, 0.0), 5.0),
    "endless": Repetition(Sphere(0.3), (0.0, 0.0, 0.0), (1.0, 0.8, 0.7)),
    "twisted": Twist(Box((0.3, 0.1, 0.7)), 2.5),
    "twisted, sheared": Twist(SHEARED, -1.5),
    "bent": Bend(Transformed(CORNER, np.diag([2.0, 1.0, 1.0, 1.0])), 0.6),
    "tapered": Taper(PAIR, 1.3, 0.4),
    "wavy": WaveDisplacement(CORNER, 0.05, (0.4, 0.5, 1e9), (0.1, 0.2, 0.0)),
    "noisy": NoiseDisplacement(SHEARED, 0.05, 0.3, 3.0, 11.0),
    "all together": Transformed(
        Twist(
            SmoothUnion(
                Round(PolarRepetition(moved(Box(0.15), 0.5, 0.0, 0.0), 5.0), 0.05), Cylinder(0.2, 1.2), radius=0.15
            ),
            1.0,
        ),
        SHEAR,
    ),
}
