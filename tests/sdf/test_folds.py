# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds against the images of what is in their chamber; layers of a field."""

import math

import numpy as np
import pytest

from sdf_lights.sdf.program import NoClosedForm
from sdf_lights.sdf.shapes import BOUND, EXACT, Box, BoxFrame, Capsule, Sphere, Transformed
from sdf_lights.sdf.shapes.folds import IcosahedralFold, Kaleidoscope, Mirror, OctahedralFold, TetrahedralFold
from sdf_lights.sdf.shapes.layers import Elongate, Offset, Onion, Round, Shell
from sdf_lights.sdf.shapes.repetition import PolarRepetition
from sdf_lights.sdf.shapes.solids import RoundedBox
from support.shapes.operated import CORNER, PAIR, SHEARED, moved

FOLDS = {
    "mirror": (lambda child: Mirror(child, (1.0, -0.5, 2.0)), 2),
    "kaleidoscope, 1": (lambda child: Kaleidoscope(child, 1.0), 2),
    "kaleidoscope, 7": (lambda child: Kaleidoscope(child, 7.0), 14),
    "tetrahedral": (TetrahedralFold, 24),
    "octahedral": (OctahedralFold, 48),
    "icosahedral": (IcosahedralFold, 120),
}
each_fold = pytest.mark.parametrize("fold, order", FOLDS.values(), ids=FOLDS)
AT = np.random.default_rng(1).uniform(-2.0, 2.0, (5000, 3))


@each_fold
@pytest.mark.parametrize("child", [moved(PAIR, 0.2, 0.4, 0.9), SHEARED], ids=["beside", "around the origin"])
def test_the_field_is_the_same_in_all_chambers(fold, order, child):
    shape = fold(child)
    elements, normals = shape._elements(), shape._normals()
    assert len(elements) == order
    assert len({tuple(e.round(9).ravel() + 0.0) for e in elements}) == order
    in_chamber = AT[(AT @ normals.T >= 0.0).all(axis=1)]
    assert len(in_chamber) == pytest.approx(len(AT) / order, rel=0.5)
    for element in elements:
        np.testing.assert_allclose(shape.distance(in_chamber @ element.T), child.distance(in_chamber), atol=1e-12)


@each_fold
def test_the_edges_of_chambers_are_no_cracks(fold, order):
    """Across a wall of the chamber the field is continuous."""
    shape = fold(CORNER)
    for normal in shape._normals():
        unit = normal / np.linalg.norm(normal)
        on_wall = AT - np.outer(AT @ unit, unit)
        difference = shape.distance(on_wall + 1e-9 * unit) - shape.distance(on_wall - 1e-9 * unit)
        assert np.abs(difference).max() < 3e-9


@each_fold
def test_what_is_clear_of_the_walls_is_copied_whole(fold, order):
    normals = fold(Sphere())._normals()
    center = np.linalg.lstsq(normals, np.linalg.norm(normals, axis=1), rcond=None)[0]  # 1 m away from each wall
    child = moved(Sphere(0.5), *center)
    shape = fold(child)
    assert shape.exactness == EXACT and shape.volume() == pytest.approx(order * Sphere(0.5).volume())
    assert fold(CORNER).exactness != EXACT and fold(CORNER).volume() is None
    assert len(shape.program()) == 2 * order - 1


def test_nested_folds_stay_cheap():
    shape = CORNER
    for index in range(20):
        shape = [IcosahedralFold, PolarRepetition, OctahedralFold, Kaleidoscope][index % 4](moved(shape, 0.1, 0.2, 0.3))
    assert shape.validate() == "" and np.isfinite(shape.bounds()).all() and shape.exactness == BOUND
    assert np.isfinite(shape.growth()).all() and len(shape.terms(np.eye(4), 1.0)) == 1
    with pytest.raises(NoClosedForm):
        OctahedralFold(IcosahedralFold(CORNER)).program()


def test_a_smooth_mirror_draws_its_halves_together():
    child = moved(Sphere(0.3), 0.5, 0.0, 0.0)
    sharp, smooth = Mirror(child), Mirror(child, smoothness=0.45)
    assert sharp.distance(np.zeros(3)) > 0.0 > smooth.distance(np.zeros(3))
    np.testing.assert_allclose(smooth.distance(AT), smooth.distance(AT * (-1.0, 1.0, 1.0)), atol=1e-14)
    with pytest.raises(NoClosedForm):
        smooth.program()
    assert Mirror(child, (0.0, 0.0, 0.0)).validate() == (
        "Mirror: the normal has no length: give at least one of its components a value other than 0."
    )


# -- layers -----------------------------------------------------------------------------------------------------------


def test_layers_by_hand():
    np.testing.assert_allclose(Round(Box(0.4), 0.1).distance(AT), RoundedBox(0.5, 0.1).distance(AT), atol=1e-15)
    np.testing.assert_allclose(Offset(Sphere(0.5), 0.2).distance(AT), Sphere(0.7).distance(AT), atol=1e-15)
    np.testing.assert_allclose(Offset(Sphere(0.5), -0.2).distance(AT), Sphere(0.3).distance(AT), atol=1e-15)
    radius = np.linalg.norm(AT, axis=1)
    np.testing.assert_allclose(Onion(Sphere(1.0), 0.2).distance(AT), np.abs(radius - 1.0) - 0.1, atol=1e-15)
    np.testing.assert_allclose(Shell(Sphere(1.0), 0.2).distance(AT), np.abs(radius - 0.9) - 0.1, atol=1e-15)
    np.testing.assert_allclose(
        Elongate(Sphere(0.3), (0.0, 0.0, 0.5)).distance(AT), Capsule(0.3, 1.0).distance(AT), atol=1e-15
    )


@pytest.mark.parametrize("child", [Sphere(0.5), CORNER, SHEARED, PAIR, Transformed(BoxFrame(), np.diag([1, 2, 3, 1]))])
def test_boxes_of_layers_are_as_tight_as_the_field_allows(child):
    low, high = child.bounds()
    np.testing.assert_allclose(Shell(child, 0.1).bounds(), (low, high), atol=1e-15)
    for layer, level in ((Offset(child, 0.1), 0.1), (Round(child, 0.2), 0.2), (Onion(child, 0.2), 0.1)):
        margin = level * layer._guarded.growth()
        np.testing.assert_allclose(layer.bounds(), (low - margin, high + margin))
    np.testing.assert_allclose(Offset(child, -0.01).bounds(), (low + 0.01, high - 0.01))
    # Nothing is left: a box without extent.
    assert np.equal(*Offset(child, -10.0).bounds()).all()


def test_nested_walls_as_thin_as_a_hair():
    wall = Onion(Onion(Onion(CORNER, 0.1), 0.01), 1e-4)
    assert wall.validate() == "" and len(wall.terms(np.eye(4), 1.0)) == len(CORNER.terms(np.eye(4), 1.0)) + 3
    at = np.random.default_rng(2).uniform(-0.8, 0.8, (1000, 3))
    layers = np.abs(np.abs(np.abs(CORNER.distance(at)) - 0.05) - 0.005) - 5e-5
    np.testing.assert_allclose(wall.distance(at), layers, atol=1e-15)


def test_elongation_moves_parts_apart():
    shape = Elongate(PAIR, (0.3, 0.2, 0.4))
    half = np.array([0.3, 0.2, 0.4])
    outside = AT + np.sign(AT) * half
    np.testing.assert_allclose(shape.distance(outside), PAIR.distance(AT), atol=1e-14)
    between = AT * (0.29 / 2.0, 0.0, 0.0) + AT * (0.0, 1.0, 1.0)
    section = between * (0.0, 1.0, 1.0)
    np.testing.assert_allclose(
        shape.distance(between + np.sign(section) * half * (0, 1, 1)), PAIR.distance(section), atol=1e-14
    )


def test_angles_of_the_kaleidoscope():
    wedge = Kaleidoscope(moved(Sphere(0.1), 1.0, 0.2, 0.0), 4.0)
    angle = math.atan2(0.2, 1.0)
    for turn in range(4):
        for side in (angle, -angle):
            direction = math.tau * turn / 4 + side
            center = math.hypot(1.0, 0.2) * np.array([math.cos(direction), math.sin(direction), 0.0])
            assert wedge.distance(center) == pytest.approx(-0.1, abs=1e-12)
