# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Primitives of the same proportions are one shape, where they were."""

import numpy as np
import pytest

from sdf_lights.emitter.building import build
from sdf_lights.emitter.sampling import cut_tables
from sdf_lights.emitter.sampling.similar import Placed, similar
from sdf_lights.sdf import shapes
from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.shapes.primitives import Frustum
from support.scenes import rotation, scaling, translation

MATRIX = translation(1.0, -2.0, 0.5) @ rotation("x", 30.0) @ scaling(1.0, 0.5, 2.0)
SHAPES = [
    *(shapes.Sphere(0.1 * size) for size in range(1, 5)),
    shapes.Torus(0.3, 0.1),
    shapes.Torus(0.6, 0.2),
    shapes.Box((0.3, 0.2, 0.1)),
    shapes.Capsule(0.2, 0.0),
    shapes.Cylinder(0.02, 3.0),
    Frustum(0.1, 0.3, 0.2),
    Expression("scale(sphere(2), 0.3)").shape(),
    Expression("translate(rotate_x(torus(1, 0.2), 20), 1, 2, 3)").shape(),
]


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_it_is_the_same_in_the_world(shape):
    found = similar(shape, MATRIX)
    expected = shape.volume() * np.linalg.det(MATRIX)
    assert found.shape.volume() * np.linalg.det(found.matrix) == pytest.approx(expected, rel=1e-8)
    points = np.random.default_rng(1).normal(0.0, 0.4, (500, 3))
    world = points @ MATRIX[:3, :3].T + MATRIX[:3, 3]
    there = (world - found.matrix[:3, 3]) @ np.linalg.inv(found.matrix[:3, :3]).T
    distance, own = shape.distance(points), found.shape.distance(there)
    clear = np.abs(distance) > 1e-6
    np.testing.assert_array_equal(np.sign(distance[clear]), np.sign(own[clear]))


def test_a_shape_without_proportions_is_left_alone():
    shape = Expression("sphere(0.3) - box(0.2)").shape()
    assert similar(shape, MATRIX).shape is shape
    assert similar(Frustum(0.0, 0.3, 0.2), MATRIX).shape == Frustum(0.0, 0.3, 0.2)


def test_lamps_of_the_same_proportions_share_boxes():
    def cells(*made):
        built = [build.build_lamp("", shape, MATRIX) for shape in made]
        sources = [Placed(shape, MATRIX) for shape in made]
        return len(cut_tables.pack_cuts(built, sources)["lamp_cells"])

    assert cells(*SHAPES[:4]) == cells(SHAPES[0])
    assert cells(*SHAPES[:6]) == cells(SHAPES[0]) + cells(SHAPES[4])
