# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids against geometry: volumes and distances worked out by hand, special cases of one another, and errors."""

import math

import numpy as np
import pytest

from sdf_lights.graph import formula
from sdf_lights.sdf.program import NoClosedForm, Op
from sdf_lights.sdf.shapes import Box, Capsule, Cone, Cylinder, Sphere, Torus
from sdf_lights.sdf.shapes.balls import CutHollowSphere, CutSphere, DeathStar, Hemisphere, Lens, SolidAngle
from sdf_lights.sdf.shapes.polyhedra import (
    Bipyramid,
    Dodecahedron,
    HexagonalPrism,
    Icosahedron,
    Octahedron,
    Prism,
    Pyramid,
    RegularPyramid,
    RhombicDodecahedron,
    Rhombus,
    Tetrahedron,
    TriangularPrism,
    Wedge,
)
from sdf_lights.sdf.shapes.primitives import Frustum
from sdf_lights.sdf.shapes.solids import (
    Bicone,
    CappedTorus,
    CrossedBars,
    HalfSpace,
    InfiniteCylinder,
    Link,
    PieSlice,
    RoundCone,
    RoundedBox,
    RoundedCylinder,
    Slab,
    Tube,
)
from support.shapes.samples import points

PI, ROOT2, ROOT3, ROOT5 = math.pi, math.sqrt(2.0), math.sqrt(3.0), math.sqrt(5.0)
GOLDEN = 0.5 * (1.0 + ROOT5)


@pytest.mark.parametrize(
    "shape, volume",
    [
        # Edges of length 1: the radius is that of the circumscribed sphere.
        (Tetrahedron(math.sqrt(3.0 / 8.0)), 1.0 / (6.0 * ROOT2)),
        (Octahedron(1.0 / ROOT2), ROOT2 / 3.0),
        (Dodecahedron(0.5 * ROOT3 * GOLDEN), (15.0 + 7.0 * ROOT5) / 4.0),
        (Icosahedron(0.5 * math.sqrt(GOLDEN * ROOT5)), 5.0 * (3.0 + ROOT5) / 12.0),
        (RhombicDodecahedron(2.0 / ROOT3), 16.0 / 9.0 * ROOT3),
        (TriangularPrism(1.0 / ROOT3, 2.0), 2.0 * ROOT3 / 4.0),
        (HexagonalPrism(1.0, 2.0), 3.0 * ROOT3),
        (Prism(4, ROOT2, 3.0), 12.0),
        (Pyramid(1.0, 3.0), 4.0),
        (RegularPyramid(4, ROOT2, 3.0), 4.0),
        (Bipyramid(4, 1.0, 2.0), 4.0 / 3.0),
        (Rhombus((1.0, 2.0, 3.0)), 24.0),
        (Wedge((1.0, 2.0, 3.0)), 24.0),
        (RoundedBox((1.0, 2.0, 3.0), 0.0), 48.0),
        (RoundedBox(0.5, 0.5), PI / 6.0),
        (RoundedCylinder(1.0, 3.0, 0.0), 3.0 * PI),
        (RoundedCylinder(1.0, 5.0, 1.0), 13.613568165555769),
        (CrossedBars(3.0, 1.0), 7.0),
        (Tube(2.0, 3.0, 1.0), 9.0 * PI),
        (PieSlice(2.0, 3.0, PI / 2.0), 3.0 * PI),
        (CappedTorus(2.0, 1.0, 0.0), 4.0 / 3.0 * PI),
        (CappedTorus(2.0, 1.0, PI), 2.0 * PI**2 + 4.0 / 3.0 * PI),
        (Link(2.0, 1.0, 0.0), 4.0 * PI**2),
        (Link(2.0, 1.0, 3.0), 4.0 * PI**2 + 6.0 * PI),
        (RoundCone(1.0, 1.0, 3.0), 13.613568165555769),
        (Bicone(1.0, 3.0), PI),
        (Frustum(1.0, 0.0, 3.0), PI),
        (Frustum(2.0, 1.0, 3.0), 7.0 * PI),
        (SolidAngle(1.0, PI), 2.0 / 3.0 * PI),
        (SolidAngle(1.0, 2.0 * PI / 3.0), PI / 3.0),
        (CutSphere(2.0, 1.0), 5.0 / 3.0 * PI),
        (Hemisphere(1.0), 2.0 / 3.0 * PI),
        (Lens(1.0, 2.0), 4.0 / 3.0 * PI),
        # Two unit balls at distance 1 share 5π/12.
        (Lens(0.5 * ROOT3, 1.0), 5.0 / 12.0 * PI),
        (DeathStar(1.0, 1.0, 1.0), (4.0 / 3.0 - 5.0 / 12.0) * PI),
        # Half of a shell with half of a torus on its rim.
        (CutHollowSphere(2.0, 0.0, 2.0), 2.0 / 3.0 * PI * 26.0 + 2.0 * PI**2),
    ],
)
def test_volume_by_hand(shape, volume):
    assert shape.volume() == pytest.approx(volume, rel=1e-14)


@pytest.mark.parametrize(
    "shape",
    [
        SolidAngle(0.5, 4.5),
        CutSphere(0.5, 0.3),
        CutHollowSphere(0.5, -0.3, 0.3),
        CutHollowSphere(0.5, 0.4, 0.3),
        DeathStar(0.5, 0.7, 0.35),
        DeathStar(0.5, 0.2, 0.4),
        RoundedCylinder(0.5, 1.0, 0.4),
        RoundCone(0.5, 0.2, 0.4),
    ],
    ids=lambda shape: shape.name(),
)
def test_volume_of_solids_of_revolution(shape):
    n = 1200
    low, high = shape.bounds()
    across, z = (np.arange(n) + 0.5) / n * high[0], low[2] + (np.arange(n) + 0.5) / n * (high[2] - low[2])
    at = np.stack([*np.broadcast_arrays(across[:, None], 0.0, z)], axis=-1)
    cell = high[0] / n * (high[2] - low[2]) / n
    # Each column of cells is right but for the rounding of its ends, at random: far below one in a thousand.
    volume = (2.0 * PI * across[:, None] * (shape.distance(at) <= 0.0)).sum() * cell
    assert shape.volume() == pytest.approx(volume, rel=2e-4)


@pytest.mark.parametrize(
    "shape, at, distance",
    [
        (Tetrahedron(3.0), (2.0, 2.0, 2.0), 2.0 * ROOT3 - 3.0),
        (Tetrahedron(3.0), (0.0, 0.0, 0.0), -1.0),
        (Tetrahedron(3.0), (9.0, 0.0, 0.0), 9.0 - ROOT3),
        (Octahedron(1.0), (2.0, 0.0, 0.0), 1.0),
        (Octahedron(1.0), (0.0, 0.0, 0.0), -1.0 / ROOT3),
        (Octahedron(1.0), (3.0, 3.0, 0.0), 2.5 * ROOT2),
        (Icosahedron(1.0), (0.0, 2.0 * GOLDEN, 2.0), 2.0 * math.sqrt(GOLDEN * ROOT5) - 1.0),
        (Dodecahedron(1.0), (2.0, 2.0, 2.0), 2.0 * ROOT3 - 1.0),
        (Dodecahedron(ROOT3), (4.0, 0.0, 0.0), 4.0 - GOLDEN),
        (RhombicDodecahedron(1.0), (3.0, 0.0, 0.0), 2.0),
        (RhombicDodecahedron(1.0), (1.0, 1.0, 0.0), 1.0 / ROOT2),
        (Prism(4, ROOT2, 2.0), (3.0, 3.0, 0.0), 3.0 * ROOT2 - 1.0),
        (Prism(6, 2.0, 2.0), (0.0, 5.0, 5.0), 5.0),
        (Prism(3, 2.0, 2.0), (0.0, -3.0, 0.0), 2.0),
        (Prism(64, 1.0, 1.0), (0.0, 0.0, 0.0), -0.5),
        (Pyramid(3.0, 4.0), (0.0, 0.0, 5.0), 3.0),
        (Pyramid(3.0, 4.0), (6.0, 7.0, -2.0), 5.0),
        (Pyramid(3.0, 4.0), (0.0, 0.0, -1.0), -1.0),
        (Bipyramid(4, ROOT2, 8.0), (0.0, 0.0, 7.0), 3.0),
        (Wedge((2.0, 1.0, 2.0)), (0.0, 0.0, 0.0), 0.0),
        (Wedge((2.0, 1.0, 2.0)), (-2.0, 0.0, 2.0), 2.0 * ROOT2),
        (Rhombus((3.0, 4.0, 5.0)), (0.0, 0.0, 0.0), -2.4),
        (Rhombus((3.0, 4.0, 5.0)), (6.0, 0.0, 9.0), 5.0),
        (RoundCone(2.0, 1.0, 4.0), (0.0, 0.0, 6.0), 3.0),
        (RoundCone(1.0, 1.0, 4.0), (3.0, 0.0, 1.0), 2.0),
        (CutSphere(5.0, 3.0), (8.0, 0.0, 3.0), 4.0),
        (CutSphere(5.0, 3.0), (7.0, 0.0, -1.0), 5.0),
        (CutHollowSphere(5.0, 3.0, 2.0), (0.0, 0.0, 3.0), 3.0),
        (CutHollowSphere(5.0, 3.0, 2.0), (0.0, 0.0, 0.0), 4.0),
        (DeathStar(5.0, 5.0, 8.0), (0.0, 0.0, 4.0), 1.0),
        (DeathStar(5.0, 5.0, 8.0), (0.0, 0.0, 8.0), 5.0),
        (Lens(4.0, 4.0), (8.0, 0.0, 3.0), 5.0),
        (Lens(4.0, 4.0), (8.0, 0.0, 0.0), 4.0),
        (SolidAngle(5.0, PI / 2.0), (0.0, 0.0, -3.0), 3.0),
        (CappedTorus(2.0, 1.0, PI), (-3.0, 2.0, 4.0), 4.0),
        (Link(2.0, 1.0, 6.0), (2.0, 5.0, 1.0), 4.0),
        (CappedTorus(2.0, 1.0, 0.0), (-4.0, 0.0, 0.0), 5.0),
        (CrossedBars(6.0, 2.0), (0.0, 0.0, 0.0), -ROOT2),
        (CrossedBars(6.0, 2.0), (4.0, 4.0, 1.0), math.sqrt(10.0)),
        (HalfSpace((0.0, 3.0, 4.0), 2.0), (0.0, 3.0, 4.0), 3.0),
        (Slab(2.0), (7.0, 8.0, -3.0), 2.0),
        (InfiniteCylinder(1.0), (3.0, 4.0, 1e9), 4.0),
        (Bicone(3.0, 8.0), (0.0, 0.0, 0.0), -2.4),
    ],
)
def test_distance_by_hand(shape, at, distance):
    assert shape.distance(np.array(at)) == pytest.approx(distance, rel=1e-14, abs=1e-14)


@pytest.mark.parametrize(
    "special, general",
    [
        (Cone(0.4, 1.1), Frustum(0.4, 0.0, 1.1)),
        (Cylinder(0.4, 1.1), Frustum(0.4, 0.4, 1.1)),
        (Box((0.3, 0.5, 0.7)), RoundedBox((0.3, 0.5, 0.7), 0.0)),
        (Sphere(0.6), RoundedBox(0.6, 0.6)),
        (Cylinder(0.4, 1.1), RoundedCylinder(0.4, 1.1, 0.0)),
        (Capsule(0.3, 0.5), RoundedCylinder(0.3, 1.1, 0.3)),
        (Capsule(0.3, 0.5), RoundCone(0.3, 0.3, 0.5)),
        (Torus(0.5, 0.2), CappedTorus(0.5, 0.2, 2.0 * PI)),
        (Sphere(0.5), Lens(0.5, 1.0)),
        (TriangularPrism(0.6, 0.8), Prism(3, 0.6, 0.8)),
        (HexagonalPrism(0.6, 0.8), Prism(6, 0.6, 0.8)),
        (Octahedron(0.6), Bipyramid(4, 0.6, 1.2)),
    ],
    ids=lambda shape: shape.name(),
)
def test_special_cases_are_the_same_field(special, general):
    at = points(special)
    difference = np.abs(special.distance(at) - general.distance(at))
    assert (difference <= 2e-15 * (1.0 + np.linalg.norm(at, axis=1))).all()


def test_a_prism_with_many_sides_becomes_a_cylinder():
    at = points(Cylinder(0.5, 0.5))
    # The polygon lies within radius · (1 − cos(π/64)) of its circle.
    difference = np.abs(Prism(64, 0.5, 0.5).distance(at) - Cylinder(0.5, 0.5).distance(at))
    assert (difference <= 0.5 * (1.0 - math.cos(PI / 64.0)) + 1e-14 * np.linalg.norm(at, axis=1)).all()


@pytest.mark.parametrize(
    "shape",
    [Prism(), RegularPyramid(), Bipyramid(), Dodecahedron(), SolidAngle(), CappedTorus()],
    ids=lambda shape: shape.name(),
)
def test_no_trigonometry_of_the_point(shape):
    """It costs twenty multiplications, where a reflection costs seven."""
    assert not {"sin", "cos", "tan", "atan", "atan2", "asin", "acos"} & {n.kind for n in formula.order(shape.formula())}


def test_edges_whose_tori_overlap_themselves_have_no_closed_form():
    with pytest.raises(NoClosedForm, match="Rounded Cylinder"):
        RoundedCylinder(0.4, 1.2, 0.3).program()
    assert Op.TORUS in RoundedCylinder(0.4, 1.2, 0.2).program()["op"]


@pytest.mark.parametrize(
    "shape, problem",
    [
        (Frustum(0.0, 0.0, 1.0), "both radii"),
        (RoundedBox(0.5, 0.6), "make the radius smaller"),
        (RoundedCylinder(0.5, 0.2, 0.3), "at most 0.1"),
        (Tube(0.5, 1.0, 0.5), "leaves no hole"),
        (CrossedBars(1.0, 1.0), "make the bars thinner"),
        (RoundCone(1.0, 0.2, 0.8), "one ball lies inside the other"),
        (CappedTorus(0.2, 0.3), "overlaps itself"),
        (CappedTorus(0.5, 0.2, 6.0), "at 343.775° the ends overlap"),
        (Link(0.2, 0.3), "overlaps itself"),
        (HalfSpace((0.0, 0.0, 0.0)), "the normal has no length"),
        (CutSphere(0.5, -0.5), "does not meet the ball"),
        (CutHollowSphere(0.5, 0.6), "does not meet the ball"),
        (CutHollowSphere(0.5, 0.49, 0.3), "the rim overlaps itself"),
        (Lens(0.5, 1.1), "make the lens thinner"),
        (DeathStar(0.5, 0.3, 0.9), "does not reach the ball"),
        (DeathStar(0.5, 0.3, 0.1), "one ball lies inside the other"),
        (Prism(2, 0.5, 1.0), "at least 3"),
        (Prism(65, 0.5, 1.0), "at most 64"),
        (Prism(4.5, 0.5, 1.0), "a whole number"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(shape, problem):
    assert problem in shape.validate() and shape.validate().endswith(".")
