# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Repetition against the union of all copies, written out."""

import itertools

import numpy as np
import pytest

from sdf_lights.sdf.program import NoClosedForm
from sdf_lights.sdf.shapes import EXACT, Box, Cylinder, Intersection, Sphere, Torus, Transformed, Union
from sdf_lights.sdf.shapes.repetition import PolarRepetition, Repetition
from sdf_lights.sdf.shapes.solids import InfiniteCylinder
from support.shapes.operated import CORNER, PAIR, SHEARED, moved

CHILDREN = {
    "exact": moved(Box((0.3, 0.4, 0.2)), 0.6, 0.2, 0.1),
    "exact outside": moved(PAIR, 0.6, 0.1, 0.0),
    "bound": moved(CORNER, 0.6, 0.3, 0.0),
    "sheared": moved(SHEARED, 0.9, 0.2, 0.0),
}
each_child = pytest.mark.parametrize("child", CHILDREN.values(), ids=CHILDREN)


def grid(child, count, spacing):
    """The union of all copies."""
    positions = itertools.product(*[(np.arange(n) - (n - 1) / 2) * s for n, s in zip(count, spacing)])
    return Union([moved(child, *position) for position in positions])


def ring(child, count):
    copies = []
    for angle in 2.0 * np.pi * np.arange(count) / count:
        turn = np.eye(4)
        turn[:2, :2] = (np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))
        copies.append(Transformed(child, turn))
    return Union(copies)


def around(shape, count=5000, beyond=1.0):
    low, high = shape.bounds()
    return np.random.default_rng(3).uniform(low - beyond, high + beyond, (count, 3))


def at_borders(shape, spacing, count=3000):
    """Points where the cell of a point changes, for cells centred on copies of even and of odd counts."""
    at = around(shape, count)
    rows = np.arange(count)
    axis = rows % 3
    nudge = np.random.default_rng(4).choice([-1e-9, 0.0, 1e-9], count)
    at[rows, axis] = (np.round(at[rows, axis] / spacing[axis] * 2.0) / 2.0) * spacing[axis] + nudge
    return at


@each_child
@pytest.mark.parametrize(
    "count, spacing", [((4, 3, 2), (0.9, 1.1, 1.5)), ((3, 1, 5), (0.45, 0.3, 0.2)), ((1, 1, 1), (1.0, 1.0, 1.0))]
)
def test_few_copies_are_their_union(child, count, spacing):
    shape, brute = Repetition(child, count, spacing), grid(child, count, spacing)
    assert shape.validate() == ""
    at = np.concatenate([around(shape), at_borders(shape, np.array(spacing))])
    np.testing.assert_allclose(shape.distance(at), brute.distance(at), atol=1e-14)
    np.testing.assert_array_equal(shape.program()["op"], brute.program()["op"])
    np.testing.assert_allclose(shape.bounds(), brute.bounds(), atol=1e-14)


@each_child
def test_many_copies_are_their_union(child):
    count, spacing = (6, 5, 4), (0.9, 1.0, 0.7)
    shape, brute = Repetition(child, count, spacing), grid(child, count, spacing)
    at = np.concatenate([around(shape), at_borders(shape, np.array(spacing))])
    field, expected = shape.distance(at), brute.distance(at)
    if child.exact_outside:
        np.testing.assert_allclose(field, expected, atol=1e-14)
    else:  # the field is held to half a spacing, and to the box around all copies
        clear = np.abs(expected) > 1e-12
        np.testing.assert_array_equal((field <= 0.0)[clear], (expected <= 0.0)[clear])
        np.testing.assert_allclose(field[expected < 0.0], expected[expected < 0.0], atol=1e-14)
    with pytest.raises(NoClosedForm):
        shape.program()


@each_child
def test_endless_rows_are_long_ones(child):
    spacing = (0.9, 1.0, 5.0)
    endless = Repetition(child, (0, 0, 1), spacing)
    long = grid(child, (9, 9, 1), spacing)
    at = np.random.default_rng(5).uniform(-1.5, 1.5, (5000, 3))
    field, expected = endless.distance(at), long.distance(at)
    clear = np.abs(expected) > 1e-12
    np.testing.assert_array_equal((field <= 0.0)[clear], (expected <= 0.0)[clear])
    if child.exact_outside:
        np.testing.assert_allclose(field, expected, atol=1e-14)
    low, high = endless.bounds()
    assert not endless.bounded and np.isinf([low[:2], high[:2]]).all()
    np.testing.assert_allclose([low[2], high[2]], np.array(child.bounds())[:, 2], atol=1e-15)
    assert Intersection(endless, Box(1.0)).bounded


@each_child
@pytest.mark.parametrize("count", [1, 2, 3, 6, 20, 100])
def test_a_ring_is_the_union_of_its_copies(child, count):
    shape, brute = PolarRepetition(child, count), ring(child, count)
    assert shape.validate() == ""
    at = around(shape, 2000)
    borders = around(shape, 1000)
    radius, turn = np.hypot(borders[:, 0], borders[:, 1]), np.pi / count * np.arange(len(borders))
    borders[:, 0], borders[:, 1] = radius * np.cos(turn), radius * np.sin(turn)
    at = np.concatenate([at, borders])
    np.testing.assert_allclose(shape.distance(at), brute.distance(at), atol=1e-13)


def test_only_copies_that_can_be_nearest_are_computed():
    def rounds(shape):
        return float(np.prod(shape._candidates))

    assert rounds(Repetition(Sphere(0.3), (100, 100, 100), (1.0, 1.0, 1.0))) == 8
    assert rounds(Repetition(Sphere(0.8), (100, 1, 1), (1.0, 1.0, 1.0))) == 3
    assert rounds(PolarRepetition(moved(Sphere(0.1), 2.0, 0.0, 0.0), 50)) == 2


def test_copies_that_are_apart_are_exact_and_have_a_volume():
    apart = Repetition(Sphere(0.4), (2, 3, 4), (1.0, 1.0, 1.0))
    assert apart.exactness == EXACT and apart.volume() == pytest.approx(24 * Sphere(0.4).volume())
    ring_ = PolarRepetition(moved(Torus(0.2, 0.1), 1.0, 0.0, 0.0), 5)
    assert ring_.exactness == EXACT and ring_.volume() == pytest.approx(5 * Torus(0.2, 0.1).volume())
    overlapping = Repetition(Sphere(0.6), (2, 1, 1), (1.0, 1.0, 1.0))
    assert overlapping.exactness != EXACT and overlapping.exact_outside and overlapping.volume() is None
    assert PolarRepetition(Sphere(), 5).volume() is None and PolarRepetition(Sphere(), 1).volume() is not None


def test_what_is_endless_along_another_axis_can_be_repeated():
    poles = Repetition(InfiniteCylinder(0.1), (3, 3, 1), (1.0, 1.0, 1.0))
    assert poles.validate() == "" and not poles.bounded
    at = np.random.default_rng(6).uniform(-2.0, 2.0, (2000, 3))
    np.testing.assert_allclose(poles.distance(at), grid(Cylinder(0.1, 100.0), (3, 3, 1), (1, 1, 1)).distance(at))


@pytest.mark.parametrize(
    "shape, problem",
    [
        (
            Repetition(Sphere(5.0), (0, 0, 0), (0.1, 0.1, 0.1)),
            "Repetition: more than 1000 copies overlap each other: make the spacing larger, or the count or the shape "
            "smaller.",
        ),
        (
            Repetition(InfiniteCylinder(0.1), (1, 1, 0)),
            "Repetition: a shape without end is repeated without end: give a count, or intersect it with a box.",
        ),
        (Repetition(Sphere(-1.0)), "Sphere: radius is -1, but must be at least 1e-06."),
        (Repetition(Sphere(), (1.5, 1.0, 1.0)), "Repetition: count is 1.5, but must be a whole number."),
    ],
)
def test_what_is_wrong_is_said(shape, problem):
    assert shape.validate() == problem
