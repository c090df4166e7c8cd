# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blended seams: where they are, how far they bulge, and that fields keep their bounds."""

import itertools
import math

import numpy as np
import pytest

from sdf_lights.sdf.program import NoClosedForm
from sdf_lights.sdf.shapes import (
    SHAPES,
    Box,
    Cylinder,
    Difference,
    Ellipsoid,
    Intersection,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.blends import Blend, Morph, SmoothIntersection, SmoothUnion
from sdf_lights.sdf.shapes.solids import HalfSpace
from support.shapes.samples import SHEAR, window

PROFILES = ("smooth", "cubic", "circular", "exponential", "round", "chamfer", "stairs")
SHARP = {"union": Union, "intersection": Intersection, "difference": Difference}
BLENDS = {name: shape for name, shape in SHAPES.items() if issubclass(shape, Blend)}
PARTS = (Box((0.5, 0.4, 0.3)), Transformed(Torus(0.4, 0.15), SHEAR), Ellipsoid((0.2, 0.3, 0.9)))

each_blend = pytest.mark.parametrize("blend", [pytest.param(s, id=n) for n, s in BLENDS.items()])


def _around(shape, count=20_000, seed=4):
    low, high = window(shape)
    return (low + high) / 2 + (high - low) * np.random.default_rng(seed).uniform(-0.8, 0.8, (count, 3))


def test_every_profile_comes_in_all_three_kinds():
    assert list(BLENDS) == [f"{profile}_{kind}" for profile, kind in itertools.product(PROFILES, SHARP)]


@each_blend
def test_a_blend_is_sharp_away_from_its_seam(blend):
    sharp = SHARP[blend.name().split("_")[1]]
    a, b = PARTS[0], Cylinder(0.15, 2.0)
    blended, at = blend(a, b, radius=0.2), _around(a)
    field, unblended = blended.distance(at), sharp(a, b).distance(at)
    x, y = a.distance(at), b.distance(at) * (-1.0 if sharp is Difference else 1.0)
    away = np.abs(x - y) >= 0.2
    assert 0.2 < away.mean() < 0.9
    np.testing.assert_array_equal(field[away], unblended[away])
    drop = (unblended - field) * (1.0 if sharp is Union else -1.0)
    greatest = 0.2 * blended.profile.greatest(*(field.default for field in blended.fields()[1:]))
    assert drop.min() > -1e-15 and 0.97 * greatest < drop.max() <= greatest + 1e-15


@each_blend
def test_slopes_of_the_drop_keep_gradients_convex(blend):
    """0 ≤ drop′ ≤ 1 as a function of the overlap: what all bounds of blends rest on."""
    planes = HalfSpace((1.0, 0.0, 0.0)), HalfSpace((0.0, 1.0, 0.0))
    kind = blend.name().split("_")[1]
    overlap = np.linspace(0.0, 0.3, 3001)
    at = np.zeros((len(overlap), 3))
    at[:, 0] = 0.3 - overlap  # fields of the planes: x and 0, or x and −0
    drop = np.abs(blend(*planes, radius=0.3).distance(at) - SHARP[kind](*planes).distance(at))
    slopes = np.diff(drop) / np.diff(overlap)
    assert drop[0] == 0.0 and slopes.min() > -1e-11 and slopes.max() < 1.0 + 1e-11


@pytest.mark.parametrize(
    "profile, at_the_corner",
    [
        ("smooth", 0.25),
        ("cubic", 1 / 6),
        ("circular", 1 - math.sqrt(0.5)),
        ("round", 1 - math.sqrt(0.5)),
        ("exponential", math.log(2 / (1 + math.exp(-8))) / 8),
        ("chamfer", 0.5),
        ("stairs", 0.5),
    ],
)
def test_seams_between_perpendicular_planes(profile, at_the_corner):
    """Half spaces x ≤ 0 and y ≤ 0: the seam is filled as far as the diagonal point (t, t) with t the greatest drop."""
    union = SHAPES[f"{profile}_union"](HalfSpace((1.0, 0.0, 0.0)), HalfSpace((0.0, 1.0, 0.0)), radius=1.0)
    assert union.distance(np.array([at_the_corner, at_the_corner, 5.0])) == pytest.approx(0.0, abs=1e-12)
    if profile in ("circular", "round"):  # the arc of radius 1 around (1, 1)
        angle = np.linspace(0.0, math.pi / 2, 50)
        arc = np.stack([1.0 - np.sin(angle), 1.0 - np.cos(angle), np.zeros(50)], axis=1)
        np.testing.assert_allclose(union.distance(arc), 0.0, atol=1e-15)
    if profile == "chamfer":
        np.testing.assert_allclose(union.distance(np.array([[0.3, 0.7, 0.0], [0.9, 0.1, 2.0]])), 0.0, atol=1e-15)
    if profile == "stairs":  # three steps: corners at (1/4, 3/4), (1/2, 1/2), (3/4, 1/4)
        inside = np.array([[0.24, 0.74, 0.0], [0.49, 0.49, 0.0], [0.74, 0.24, 0.0]])
        assert (union.distance(inside) < 0.0).all()
        outside = inside + np.array([[0.02, 0.0, 0.0], [0.0, 0.02, 0.0], [0.02, 0.02, 0.0]])
        assert (union.distance(outside) > 0.0).all()


@each_blend
def test_intersection_and_difference_are_unions_of_complements(blend):
    profile, kind = blend.name().split("_")
    union = SHAPES[f"{profile}_union"]
    x, y = HalfSpace((1.0, 0.2, 0.0)), HalfSpace((0.1, -1.0, 0.3), 0.1)

    def complement(half_space):
        return HalfSpace(tuple(-c for c in half_space.normal), -half_space.offset)

    at = np.random.default_rng(2).uniform(-1.0, 1.0, (1000, 3))
    expected = {
        "union": lambda: union(x, y).distance(at),
        "intersection": lambda: -union(complement(x), complement(y)).distance(at),
        "difference": lambda: -union(complement(x), y).distance(at),
    }[kind]()
    np.testing.assert_allclose(blend(x, y).distance(at), expected, atol=1e-14)


@each_blend
def test_bounds_of_blends_are_proven_and_not_idle(blend):
    shape = blend(*PARTS, radius=0.3)
    for matrix in (np.eye(4), SHEAR):
        low, high = shape.bounds(matrix)
        at = np.random.default_rng(5).uniform(-2.0, 2.0, (200_000, 3))
        inside = at[shape.distance(at) <= 0.0] @ matrix[:3, :3].T + matrix[:3, 3]
        assert (inside > low).all() and (inside < high).all()
    if "union" in blend.name():
        near = shape.bounds()[1] - Union(PARTS).bounds()[1]
        assert (near >= 0.0).all() and (near <= 0.3 * shape.growth()).all()
        apart = np.eye(4)
        apart[:3, 3] = 5.0
        far = (Box(), Transformed(Box(), apart))
        np.testing.assert_array_equal(blend(*far, radius=0.3).bounds(), Union(far).bounds())


def test_long_and_deep_blends_stay_cheap():
    rng = np.random.default_rng(6)
    parts = []
    for center in rng.uniform(-5.0, 5.0, (300, 3)):
        place = np.eye(4)
        place[:3, 3] = center
        parts.append(Transformed(Ellipsoid(), place))
    flat = SmoothUnion(parts, radius=0.5)
    low, high = flat.bounds()
    assert (low >= Union(parts).bounds()[0] - 0.5 * flat.growth()).all()
    deep = parts[0]
    for index, other in enumerate(parts[1:60]):
        deep = SmoothUnion(other, deep, radius=0.1 + 0.001 * index)  # neither absorbs the other
    assert deep.depth == 61 and np.isfinite(deep.bounds()).all()
    assert len(deep.terms(np.eye(4), 1.0)) < 60 * 4


def test_only_the_same_blends_become_one():
    a, b, c = Sphere(), Box(), Cylinder()
    assert SmoothUnion(SmoothUnion(a, b, radius=0.2), c, radius=0.2).children == (a, b, c)
    assert len(SmoothUnion(SmoothUnion(a, b, radius=0.2), c, radius=0.3).children) == 2
    assert len(SmoothUnion(a, SmoothUnion(b, c)).children) == 2  # a blend joins from left to right
    assert len(SmoothIntersection(Intersection(a, b), c).children) == 2
    assert SmoothUnion(a).formula() is a.formula() and SmoothUnion(a).exactness == a.exactness
    with pytest.raises(NoClosedForm):
        SmoothUnion(a, b).program()


@pytest.mark.parametrize(
    "shape, problem",
    [
        (SmoothUnion(Box(), Sphere(), radius=0.0), "Smooth Union: radius is 0, but must be at least 1e-06."),
        (SHAPES["stairs_union"](Box(), Sphere(), steps=2.5), "Stairs Union: steps is 2.5, but must be a whole number."),
        (Morph(Box(), Sphere(), 1.5), "Morph: amount is 1.5, but must be at most 1."),
    ],
)
def test_what_is_wrong_is_said(shape, problem):
    assert shape.validate() == problem


def test_a_morph_ends_in_its_shapes():
    first, second = PARTS[:2]
    at = _around(first)
    np.testing.assert_array_equal(Morph(first, second, 0.0).distance(at), first.distance(at))
    np.testing.assert_array_equal(Morph(first, second, 1.0).distance(at), second.distance(at))
    np.testing.assert_allclose(Morph(Sphere(1.0), Sphere(2.0), 0.3).distance(at), Sphere(1.3).distance(at), atol=1e-15)
