# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curved shapes, tubes, coils and periodic surfaces against the curves and functions that define them."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdf_lights.sdf.shapes import BOUND, EXACT, Ellipsoid, Transformed
from sdf_lights.sdf.shapes.coils import Helix, MobiusBand, Spiral, TorusKnot
from sdf_lights.sdf.shapes.curved import Droplet, Egg, Heart, Superellipsoid, Vesica
from sdf_lights.sdf.shapes.minimal_surfaces import (
    FischerKochS,
    Gyroid,
    Lidinoid,
    Neovius,
    PeriodicSheet,
    SchoenFrd,
    SchoenIwp,
    SchwarzD,
    SchwarzP,
)
from sdf_lights.sdf.shapes.tubes import BezierTube, FigureEight, Horseshoe


def _around(shape, count: int, seed: int) -> np.ndarray:
    """Random points (count, 3) of the shape's box at twice its size."""
    low, high = shape.bounds()
    return (low + high) / 2 + (high - low) * np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3))


# -- solids of arcs ---------------------------------------------------------------------------------------------------


def _arc(center, radius, first, last) -> np.ndarray:
    angles = np.linspace(first, last, 20_000)
    return np.asarray(center) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _vesica_outline(shape: Vesica) -> np.ndarray:
    """Distance from the axis and height of points of the surface: an arc through both points and the widest place."""
    w, h = shape.half_width, shape.half_height
    radius = (w * w + h * h) / (2.0 * w)
    opening = math.asin(h / radius)
    return _arc((w - radius, 0.0), radius, -opening, opening)


def _egg_outline(shape: Egg) -> np.ndarray:
    """Three arcs, of which each goes on in the direction that the one before ends in."""
    bottom, top, height = shape.bottom_radius, shape.top_radius, shape.height
    lower = 0.5 * (bottom - top - height)
    # The centre of the side lies on the line of the lower centre's normal, at height 0 of it, and is as far from the
    # surface of one ball as from that of the other.
    away = (height**2 - (bottom - top) ** 2) / (2.0 * (bottom - top))
    seam = math.atan2(height, away)
    return np.concatenate(
        [
            _arc((0.0, lower), bottom, -0.5 * math.pi, 0.0),
            _arc((-away, lower), away + bottom, 0.0, seam),
            _arc((0.0, lower + height), top, seam, 0.5 * math.pi),
        ]
    )


@pytest.mark.parametrize(
    "shape, outline",
    [
        (Vesica(), _vesica_outline),
        (Vesica(0.05, 0.7), _vesica_outline),
        (Vesica(0.5, 0.5), _vesica_outline),
        (Egg(), _egg_outline),
        (Egg(0.5, 0.05, 0.46), _egg_outline),
        (Egg(0.3, 0.29, 1.0), _egg_outline),
    ],
)
def test_solids_of_arcs_are_exact(shape, outline):
    at = _around(shape, 3000, 1)
    in_plane = np.stack([np.hypot(at[:, 0], at[:, 1]), at[:, 2]], axis=1)
    nearest, _ = cKDTree(outline(shape)).query(in_plane)
    # Points of the outline are less than 2e-4 apart: a foot between two of them is at most that much squared farther.
    field = shape.distance(at)
    clear = nearest > 1e-3
    np.testing.assert_allclose(np.abs(field)[clear], nearest[clear], rtol=0.0, atol=1e-5)


def test_a_vesica_and_an_egg_between_other_shapes():
    at = _around(Vesica(), 1000, 2)
    np.testing.assert_allclose(
        Vesica(0.5, 0.5).distance(at), Ellipsoid((0.5, 0.5, 0.5)).distance(at), rtol=0.0, atol=1e-15
    )
    assert Vesica(0.5, 0.5).volume() == pytest.approx(math.pi / 6.0, rel=1e-14)
    assert Egg(0.5, 0.5 - 1e-6, 1e-3).volume() == pytest.approx(math.pi / 6.0, rel=2e-3)


def test_a_droplet_is_a_ball_and_a_cone():
    drop = Droplet(0.3, 0.5)
    # Tangents from the point touch the ball at 4/5 of its radius from the axis.
    assert drop.distance(np.array([0.0, 0.0, 0.25])) == pytest.approx(0.0, abs=1e-16)
    assert drop.distance(np.array([0.24, 0.0, -0.25 + 0.18])) == pytest.approx(0.0, abs=1e-15)
    cone, cap = math.pi / 3.0 * 0.24**2 * 0.32, math.pi / 3.0 * 0.12**2 * (0.9 - 0.12)
    assert drop.volume() == pytest.approx(4.0 / 3.0 * math.pi * 0.3**3 - cap + cone, rel=1e-14)


@pytest.mark.parametrize("shape", [Heart(), Heart(0.2, 0.6, math.radians(20.0)), Heart(0.1, 0.5, math.pi)])
def test_a_heart_is_two_droplets(shape):
    low, _ = shape.bounds()
    drops = []
    for side in (-1.0, 1.0):
        lean = math.pi + side * 0.5 * shape.spread  # a droplet's point is at its top
        matrix = np.eye(4)
        cosine, sine = math.cos(lean), math.sin(lean)
        matrix[:3, :3] = [(cosine, 0.0, sine), (0.0, 1.0, 0.0), (-sine, 0.0, cosine)]
        matrix[:3, 3] = -matrix[:3, :3] @ (0.0, 0.0, 0.5 * shape.height)
        matrix[2, 3] -= 0.5 * (shape.height * math.cos(0.5 * shape.spread) + shape.radius)
        drops.append(Transformed(Droplet(shape.radius, shape.height), matrix))
    at = _around(shape, 4000, 3)
    both = np.minimum(*(drop.distance(at) for drop in drops))
    field = shape.distance(at)
    np.testing.assert_array_equal(field <= 0.0, both <= 0.0)
    np.testing.assert_allclose(field[both > 0.0], both[both > 0.0], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("r, t", [(1.0, 1.0), (2.0, 2.0), (1.0, 6.0), (8.0, 1.5), (20.0, 20.0)])
def test_superellipsoids_by_definition(r, t):
    a, b, c = 0.7, 0.5, 0.3
    shape = Superellipsoid((a, b, c), r, t)
    at = _around(shape, 5000, 4)
    x, y, z = np.abs(at).T
    inside = ((x / a) ** r + (y / b) ** r) ** (t / r) + (z / c) ** t <= 1.0
    clear = np.abs(shape.distance(at)) > 1e-12
    np.testing.assert_array_equal(shape.distance(at)[clear] <= 0.0, inside[clear])
    if r == t == 2.0:
        assert shape.volume() == pytest.approx(Ellipsoid((a, b, c)).volume(), rel=1e-14)
        np.testing.assert_allclose(shape.distance(at), Ellipsoid((a, b, c)).distance(at), rtol=0.0, atol=1e-14)
    if r == t == 1.0:
        assert shape.volume() == pytest.approx(8.0 * a * b * c / 6.0, rel=1e-14)


# -- tubes ------------------------------------------------------------------------------------------------------------


def _horseshoe(shape: Horseshoe) -> np.ndarray:
    half = 0.5 * shape.angle
    arc = shape.radius * np.stack([np.sin(t := np.linspace(-half, half, 20_000)), np.cos(t)], axis=1)
    leg = np.linspace(0.0, shape.leg, 5000)[:, None] * (math.cos(half), -math.sin(half))
    right = arc[-1] + leg
    return np.pad(np.concatenate([arc, right, right * (-1.0, 1.0)]), ((0, 0), (0, 1)))


def _figure_eight(shape: FigureEight) -> np.ndarray:
    r, d = shape.radius, shape.half_distance
    slope = math.asin(r / d)
    t = np.linspace(-0.5 * math.pi - slope, 0.5 * math.pi + slope, 20_000)
    arc = np.stack([d + r * np.cos(t), r * np.sin(t)], axis=1)
    straight = np.linspace(0.0, 1.0, 5000)[:, None] * arc[-1]
    return np.pad(
        np.concatenate([sign * part for sign in itertools.product((1.0, -1.0), repeat=2) for part in (arc, straight)]),
        ((0, 0), (0, 1)),
    )


def _bezier(shape: BezierTube) -> np.ndarray:
    t = np.linspace(0.0, 1.0, 40_000)[:, None]
    return (1.0 - t) ** 2 * shape.start + 2.0 * t * (1.0 - t) * np.array(shape.control) + t**2 * shape.end


def _hold_to_the_curve(shape, curve: np.ndarray, radius: float):
    at = _around(shape, 2000, 5)
    nearest, _ = cKDTree(curve).query(at)
    gap = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    # A foot between two points of the curve is nearer by less than half of their distance, and far away by much less.
    gap = gap[gap < 0.01].max()  # the others are between separate parts of the curve
    slack = np.minimum(0.5 * gap, gap**2 / np.maximum(nearest - gap, 1e-300)) + 1e-12
    field = shape.distance(at) + radius
    assert (field <= nearest + 1e-12).all() and (field >= nearest - slack).all()


@pytest.mark.parametrize(
    "shape, curve",
    [
        (Horseshoe(), _horseshoe),
        (Horseshoe(0.4, 0.1, math.pi, 0.0), _horseshoe),
        (Horseshoe(0.2, 0.05, 1.0, 0.6), _horseshoe),
        (Horseshoe(0.4, 0.05, 5.2, 0.1), _horseshoe),
        (Horseshoe(0.4, 0.05, 0.0, 0.3), _horseshoe),
        (FigureEight(), _figure_eight),
        (FigureEight(0.2, 0.201, 0.03), _figure_eight),
        (FigureEight(0.05, 0.6, 0.02), _figure_eight),
    ],
)
def test_tubes_follow_their_curves(shape, curve):
    assert shape.validate() == ""
    _hold_to_the_curve(shape, curve(shape), shape.minor_radius)


BEZIERS = {
    "straight": BezierTube((-0.5, 0.0, 0.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0), 0.1),
    "almost straight": BezierTube((-0.5, 0.0, 0.0), (1e-9, 1e-9, 0.0), (0.5, 0.0, 0.0), 0.1),
    "straight, not evenly": BezierTube((-0.5, 0.0, 0.0), (-0.4, 0.0, 0.0), (0.5, 0.0, 0.0), 0.1),
    "back on itself": BezierTube((-0.5, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), 0.1),
    "sharp": BezierTube((-0.05, 0.0, 0.0), (0.0, 2.0, 0.0), (0.05, 0.0, 0.0), 0.03),
    "a point": BezierTube((0.1, 0.2, 0.3), (0.1, 0.2, 0.3), (0.1, 0.2, 0.3), 0.2),
    "closed": BezierTube((0.1, 0.2, 0.3), (0.7, 0.2, 0.3), (0.1, 0.2, 0.3), 0.2),
}


@pytest.mark.parametrize(
    "shape",
    [
        BezierTube(),
        *BEZIERS.values(),
        *(BezierTube(*np.random.default_rng(seed).uniform(-0.5, 0.5, (3, 3)).tolist(), 0.05) for seed in range(12)),
    ],
)
def test_bezier_tubes_are_as_far_as_their_curve(shape):
    _hold_to_the_curve(shape, _bezier(shape), shape.radius)


def test_the_worst_points_of_a_bezier_curve():
    """On the evolute, where two roots of the cubic meet, and on the axis, where three may."""
    shape = BezierTube((-0.5, 0.25, 0.0), (0.0, -0.25, 0.0), (0.5, 0.25, 0.0), 0.01)  # y = x²
    x = np.linspace(-0.45, 0.45, 2001)
    evolute = np.stack([-4.0 * x**3, 0.5 + 3.0 * x**2, 0.0 * x], axis=1)
    axis = np.stack([0.0 * x, 0.5 + 0.2 * x, 0.0 * x], axis=1)
    for at in (evolute, axis):
        nearest, _ = cKDTree(_bezier(shape)).query(at)
        np.testing.assert_allclose(shape.distance(at) + 0.01, nearest, rtol=0.0, atol=1e-8)


def test_when_a_bezier_tube_is_exact():
    assert BezierTube().exactness == EXACT
    assert BEZIERS["straight"].exactness == EXACT
    assert BEZIERS["back on itself"].exactness == BEZIERS["sharp"].exactness == BOUND
    # The parabola y = x² has the radius of curvature 1/2 at its vertex.
    parabola = [(-0.5, 0.25, 0.0), (0.0, -0.25, 0.0), (0.5, 0.25, 0.0)]
    assert BezierTube(*parabola, 0.499).exactness == EXACT
    assert BezierTube(*parabola, 0.501).exactness == BOUND
    length = 0.5 * math.sqrt(2.0) + 0.5 * math.asinh(1.0)
    assert BezierTube(*parabola, 0.1).volume() == pytest.approx(
        math.pi * 0.01 * length + 4.0 / 3.0 * math.pi * 0.001, rel=1e-14
    )
    almost = BEZIERS["almost straight"]
    assert almost.volume() == pytest.approx(BEZIERS["straight"].volume(), rel=1e-9)


@pytest.mark.parametrize(
    "shape, problem",
    [
        (Vesica(0.6, 0.5), "Vesica: half width 0.6 is more than the half height 0.5: make it smaller, or use a lens."),
        (
            Egg(0.3, 0.3, 0.5),
            "Egg: top radius 0.3 must be less than the bottom radius 0.3: make it smaller, or use a capsule.",
        ),
        (
            Egg(0.5, 0.1, 0.3),
            "Egg: at height 0.3 one ball lies inside the other: make the height more than the difference "
            "of the radii, 0.4.",
        ),
        (
            Droplet(0.5, 0.4),
            "Droplet: at height 0.4 the point lies in the ball: make the height more than the radius 0.5.",
        ),
        (
            Horseshoe(0.4, 0.1, 5.0, 1.0),
            "Horseshoe: its ends run into each other: make the angle, the straight parts or the minor radius smaller.",
        ),
        (
            FigureEight(0.3, 0.3),
            "Figure Eight: half distance 0.3 must be more than the radius 0.3, for the straight parts "
            "to cross: make it larger.",
        ),
        (
            Helix(0.1, 0.2, 3.0, 0.2),
            "Helix: minor radius 0.2 is too much for a wire at a distance of 0.1 from the axis: make it smaller.",
        ),
        (
            Helix(0.01, 10.0, 1.0, 0.001),
            "Helix: the wire hardly turns around the axis: make it wider, or give it more turns.",
        ),
        (Spiral(0.3, 0.3, 0.0), "Spiral: its turns lie on one another: make the height larger, or one of the radii."),
        (
            TorusKnot(0.3, 0.25, 0.06),
            "Torus Knot: the wire reaches the axis: make the major radius larger, or the torus "
            "radius or the minor radius smaller.",
        ),
        (
            MobiusBand(0.1, 0.3),
            "Mobius Band: at a radius of 0.1 the band reaches the axis: make the radius larger, or the width smaller.",
        ),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(shape, problem):
    assert shape.validate() == problem


# -- coils and knots --------------------------------------------------------------------------------------------------


def _coil(shape: Helix | Spiral, turns: np.ndarray) -> np.ndarray:
    """Points of the middle of the wire, by turns from the middle of the coil."""
    if isinstance(shape, Helix):
        distance, height = shape.radius + 0.0 * turns, shape.pitch * turns
    else:
        way = turns / shape.turns + 0.5
        distance = shape.bottom_radius + (shape.top_radius - shape.bottom_radius) * way
        height = shape.height * (way - 0.5)
    return np.stack([distance * np.cos(math.tau * turns), distance * np.sin(math.tau * turns), height], axis=1)


COILS = {
    "helix": Helix(),
    "one turn": Helix(0.4, 0.3, 1.0, 0.05),
    "part of a turn": Helix(0.4, 0.3, 0.4, 0.05),
    "two turns and a bit": Helix(0.4, 0.2, 2.2, 0.05),
    "steep": Helix(0.2, 0.9, 1.3, 0.05),
    "tight": Helix(0.3, 0.11, 6.5, 0.05),
    "spiral": Spiral(),
    "flat": Spiral(0.1, 0.6, 0.0, 4.0, 0.03),
    "narrow at the top": Spiral(0.5, 0.2, 0.7, 2.5, 0.05),
}

each_coil = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in COILS.items()])


def _wire(shape) -> np.ndarray:
    return _coil(shape, np.linspace(-0.5, 0.5, 10_000) * shape.turns)


@each_coil
def test_a_coil_is_a_round_wire(shape):
    """What is well within the radius of the curve is inside, and what is well beyond it is outside."""
    assert shape.validate() == ""
    at = _around(shape, 8000, 6)
    to_wire, _ = cKDTree(_wire(shape)).query(at)
    inside = shape.distance(at) <= 0.0
    mean = shape.radius if isinstance(shape, Helix) else 0.5 * (shape.bottom_radius + shape.top_radius)
    # The wire is round in the limit of a thin one; and at the mean distance from the axis, so a spiral is less so.
    tolerance = shape.minor_radius / mean + (0.0 if isinstance(shape, Helix) else 0.1)
    assert inside[to_wire < (1.0 - tolerance) * shape.minor_radius].mean() > 0.99
    assert not inside[to_wire > (1.0 + tolerance) * shape.minor_radius].any()


@each_coil
def test_a_coil_has_its_ends(shape):
    ends = _coil(shape, np.array([-0.5, 0.5]) * shape.turns)
    onwards = _coil(shape, np.array([-0.5, 0.5]) * shape.turns * (1.0 + 1e-6)) - ends
    onwards /= np.linalg.norm(onwards, axis=1, keepdims=True)
    assert (shape.distance(ends) < 0.0).all()
    assert (shape.distance(ends + 0.8 * shape.minor_radius * onwards) < 0.0).all()
    assert (shape.distance(ends + 1.8 * shape.minor_radius * onwards) > 0.0).all()


@each_coil
def test_a_coil_is_continuous_where_its_formula_changes(shape):
    """Across the half planes of its ends, the one where the angle jumps, the axis, and half way between turns."""
    rng = np.random.default_rng(7)
    n = 20_000
    low, high = shape.bounds()
    distance = rng.uniform(0.0, 1.2 * high[0], n)
    height = low[2] + (high[2] - low[2]) * rng.uniform(-0.2, 1.2, n)
    angle = np.choose(
        rng.integers(0, 3, n),
        [np.full(n, math.pi), np.full(n, math.pi * shape.turns), np.full(n, -math.pi * shape.turns)],
    )
    at = np.stack([distance * np.cos(angle), distance * np.sin(angle), height], axis=1)
    at[:2000, :2] = 0.0
    between = _coil(shape, rng.uniform(-0.5, 0.5, 4000) * shape.turns)
    other = _coil(shape, np.zeros(1)) - _coil(shape, np.ones(1))
    at[2000:6000] = between + 0.5 * other + 0.05 * rng.normal(size=between.shape)
    step = rng.normal(size=at.shape) * 10.0 ** rng.uniform(-9, -2, (n, 1))
    change = np.abs(shape.distance(at + step) - shape.distance(at - step))
    assert (change <= 2.0 * np.linalg.norm(step, axis=1) + 1e-14).all()


def test_turns_can_be_counted():
    for turns in (1.0, 2.5, 3.0, 7.25):
        shape = Helix(0.3, 0.1, turns, 0.02)
        line = np.zeros((40_001, 3))
        line[:, 0], line[:, 2] = 0.3, np.linspace(-1.0, 1.0, len(line))
        inside = shape.distance(line) <= 0.0
        # At the angle 0 the wire is at 0, ±1, ±2 … turns from the middle.
        assert np.count_nonzero(inside[1:] & ~inside[:-1]) == 1 + 2 * math.floor(0.5 * turns)


def test_volumes_of_coils():
    section, mean = math.pi * 0.05**2 * math.hypot(0.4, 0.2 / math.tau) / 0.4, 0.4
    assert Helix(0.4, 0.2, 2.0, 0.05).volume() == pytest.approx(
        section * (2.0 * math.tau * mean + 4.0 / 3.0 * 0.05), rel=1e-14
    )
    assert Helix(0.4, 0.09, 2.0, 0.05).volume() is None  # the turns run into each other


KNOTS = {
    "trefoil": TorusKnot(),
    "other trefoil": TorusKnot(0.4, 0.15, 0.05, 3.0, 2.0),
    "ring": TorusKnot(0.4, 0.15, 0.05, 1.0, 0.0),
    "coil on a ring": TorusKnot(0.4, 0.15, 0.03, 1.0, 9.0),
    "chain": TorusKnot(0.4, 0.15, 0.05, 2.0, 4.0),
    "fine": TorusKnot(0.5, 0.15, 0.02, 5.0, 7.0),
}

each_knot = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in KNOTS.items()])


def _knot(shape: TorusKnot) -> np.ndarray:
    """All of its closed wires: as many as the greatest common divisor of the two numbers of turns says."""
    p, q = int(shape.around_axis), int(shape.around_tube)
    rings = math.gcd(p, q)
    t = np.linspace(0.0, math.tau, 8000)
    wires = []
    for ring in range(rings):
        around, across = p // rings * t, q // rings * t + math.tau * ring / p
        distance = shape.major_radius + shape.radius * np.cos(across)
        height = shape.radius * np.sin(across)
        wires.append(np.stack([distance * np.cos(around), distance * np.sin(around), height], axis=1))
        np.testing.assert_allclose(wires[-1][0], wires[-1][-1], atol=1e-14)
    return np.concatenate(wires)


@each_knot
def test_a_knot_is_a_round_closed_wire(shape):
    assert shape.validate() == ""
    curve = _knot(shape)
    assert (shape.distance(curve) < 0.0).all()
    at = _around(shape, 8000, 8)
    to_wire, _ = cKDTree(curve).query(at)
    inside = shape.distance(at) <= 0.0
    # The curve bends across the half plane, at most as much as its torus does inside and its tube around.
    tolerance = 1.5 * shape.minor_radius / min(shape.radius, shape.major_radius - shape.radius)
    assert inside[to_wire < (1.0 - tolerance) * shape.minor_radius].all()
    assert not inside[to_wire > (1.0 + tolerance) * shape.minor_radius].any()


@each_knot
def test_half_planes_cut_a_knot_as_often_as_it_goes_around(shape):
    for angle in np.random.default_rng(9).uniform(-math.pi, math.pi, 5):
        out, up = np.meshgrid(np.linspace(-0.3, 0.3, 301), np.linspace(-0.3, 0.3, 301), indexing="ij")
        distance = shape.major_radius + out
        at = np.stack([distance * np.cos(angle), distance * np.sin(angle), up], axis=-1)
        middle = np.hypot(out, up) - shape.radius
        ring = np.argsort(np.abs(middle).ravel())[:2000]  # along the circle in which the torus is cut
        order = ring[np.argsort(np.arctan2(up.ravel()[ring], out.ravel()[ring]))]
        inside = shape.distance(at.reshape(-1, 3)[order]) <= 0.0
        wires = np.count_nonzero(inside & ~np.roll(inside, 1))
        assert wires == shape.around_axis or inside.all() == (wires == 0)


@pytest.mark.parametrize("half_turns", [0.0, 1.0, -1.0, 2.0, 3.0, -8.0])
def test_a_mobius_band_turns_as_often_as_it_says(half_turns):
    shape = MobiusBand(0.4, 0.3, 0.05, half_turns)
    turn, u, v = np.random.default_rng(10).uniform(-1.0, 1.0, (3, 20_000))
    turn, u, v = math.pi * turn, 0.05 * u, 0.3 * v
    angle = 0.5 * half_turns * turn
    distance, height = 0.4 + u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle)
    at = np.stack([distance * np.cos(turn), distance * np.sin(turn), height], axis=1)
    inside = (np.abs(u) <= 0.025) & (np.abs(v) <= 0.15)
    np.testing.assert_array_equal(shape.distance(at) <= 0.0, inside)
    # No seam where the angle jumps.
    distance, height = np.random.default_rng(11).uniform((0.2, -0.2), (0.6, 0.2), (5000, 2)).T
    before, after = (np.stack([-distance, side * 1e-9 * np.ones(5000), height], axis=1) for side in (-1.0, 1.0))
    np.testing.assert_allclose(shape.distance(before), shape.distance(after), rtol=0.0, atol=1e-7)


# -- periodic surfaces ------------------------------------------------------------------------------------------------


def _all(function, x, y, z):
    """Sum over the three cyclic exchanges of the coordinates."""
    return function(x, y, z) + function(y, z, x) + function(z, x, y)


_sin, _cos = np.sin, np.cos

SURFACES = {
    Gyroid: lambda x, y, z: _all(lambda a, b, c: _sin(a) * _cos(b), x, y, z),
    SchwarzP: lambda x, y, z: _all(lambda a, b, c: _cos(a), x, y, z),
    SchwarzD: lambda x, y, z: _cos(x) * _cos(y) * _cos(z) - _sin(x) * _sin(y) * _sin(z),
    Neovius: lambda x, y, z: 3.0 * _all(lambda a, b, c: _cos(a), x, y, z) + 4.0 * _cos(x) * _cos(y) * _cos(z),
    SchoenIwp: lambda x, y, z: _all(lambda a, b, c: 2.0 * _cos(a) * _cos(b) - _cos(2.0 * a), x, y, z),
    SchoenFrd: lambda x, y, z: (
        4.0 * _cos(x) * _cos(y) * _cos(z) - _all(lambda a, b, c: _cos(2.0 * a) * _cos(2.0 * b), x, y, z)
    ),
    FischerKochS: lambda x, y, z: _all(lambda a, b, c: _cos(2.0 * a) * _sin(b) * _cos(c), x, y, z),
    Lidinoid: lambda x, y, z: (
        0.5 * _all(lambda a, b, c: _sin(2.0 * a) * _cos(b) * _sin(c) - _cos(2.0 * a) * _cos(2.0 * b), x, y, z) + 0.15
    ),
}

each_surface = pytest.mark.parametrize("sheet", [pytest.param(s, id=s.name()) for s in SURFACES])


def test_every_surface_is_tried():
    assert set(PeriodicSheet.__subclasses__()) == set(SURFACES)


@each_surface
def test_sheets_by_definition(sheet):
    shape = sheet((0.5, 0.4, 0.3), 0.7, 0.05)
    at = _around(shape, 5000, 12)
    value = SURFACES[sheet](*(math.tau / 0.7 * at).T)
    expected = np.abs(value) * 0.7 / (math.tau * sheet.slope) - 0.025
    field = shape.distance(at)
    in_block = (np.abs(at) < (0.5, 0.4, 0.3)).all(axis=1) & (expected > -1e-3)
    np.testing.assert_allclose(field[in_block], np.maximum(expected, field)[in_block], rtol=0.0, atol=1e-14)
    deep = in_block & ((np.array([0.5, 0.4, 0.3]) - np.abs(at)).min(axis=1) > 0.01)
    np.testing.assert_allclose(field[deep], expected[deep], rtol=0.0, atol=1e-14)


@each_surface
def test_the_slope_of_a_surface_is_proven_and_tight(sheet):
    """|∇F|² on a grid, and how much larger it can be in between: see the module's documentation."""
    coarse, fine, most = 16, 160, 2
    t = math.tau * np.arange(coarse) / coarse
    coefficients = np.fft.fftn(SURFACES[sheet](*np.meshgrid(t, t, t, indexing="ij"))) / coarse**3
    frequencies = np.arange(-most, most + 1)
    block = coefficients[np.ix_(frequencies, frequencies, frequencies)]
    assert np.abs(coefficients).sum() == pytest.approx(np.abs(block).sum(), rel=1e-12)  # there are no others
    used = np.abs(block).max(axis=(1, 2)) > 1e-12
    degree = np.abs(frequencies[used]).max()

    waves = np.exp(1j * np.outer(math.tau * np.arange(fine) / fine, frequencies))
    squared = 0.0
    for axis in range(3):
        part = block * np.expand_dims(1j * frequencies, [other for other in range(3) if other != axis])
        for _ in range(3):
            part = np.tensordot(part, waves, axes=(0, 1))
        squared = squared + part.real**2
    found = math.sqrt(squared.max())
    assert found <= sheet.slope * (1.0 + 1e-12) and sheet.slope <= 1.01 * found
    if sheet not in (Gyroid, SchwarzP):  # these are shown by hand
        assert found * math.cos(math.pi * 2 * degree / fine) ** -1.5 <= sheet.slope
