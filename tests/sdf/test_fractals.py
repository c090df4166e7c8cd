# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractals against their definitions: as lists of copies, as digits, as orbits in plain Python."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdf_lights.sdf.shapes import SHAPES
from sdf_lights.sdf.shapes.fractals import (
    CantorDust,
    DodecahedronFlake,
    IcosahedronFlake,
    Kifs,
    KochCurve,
    KochSnowflake,
    MengerSponge,
    OctahedronFlake,
    SierpinskiTetrahedron,
)
from sdf_lights.sdf.shapes.orbits import ApollonianGasket, JuliaQuaternion, Mandelbox, Mandelbulb


def around(shape, count: int, seed: int = 1) -> np.ndarray:
    """Random points (count, 3) in a box a little larger than the shape's."""
    low, high = shape.bounds()
    return (low + high) / 2 + 0.6 * (high - low) * np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3))


def same_set(shape, at: np.ndarray, inside) -> None:
    """The sign of the field is that of ``inside``, except so close to the surface that rounding decides."""
    field = shape.distance(at)
    clear = np.abs(field) > 1e-12
    assert clear.mean() > 0.9 and 0.0 < np.mean(field <= 0.0) < 1.0
    np.testing.assert_array_equal((field <= 0.0)[clear], np.asarray(inside)[clear])


# -- copies -----------------------------------------------------------------------------------------------------------

CORNERS = {
    SierpinskiTetrahedron: [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)],
    OctahedronFlake: [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
    IcosahedronFlake: SHAPES["icosahedron"].corners,
    DodecahedronFlake: SHAPES["dodecahedron"].corners,
    CantorDust: list(itertools.product((-1, 1), repeat=3)),
}


@pytest.mark.parametrize(
    "shape, solid, ratio",
    [
        (SierpinskiTetrahedron(0.9, 3), SHAPES["tetrahedron"](0.9), 0.5),
        (OctahedronFlake(0.6, 3), SHAPES["octahedron"](0.6), 0.5),
        (IcosahedronFlake(0.5, 2), SHAPES["icosahedron"](0.5), (3.0 - math.sqrt(5.0)) / 2.0),
        (DodecahedronFlake(0.7, 2), SHAPES["dodecahedron"](0.7), 2.0 / (5.0 + math.sqrt(5.0))),
        (CantorDust((0.5, 0.4, 0.8), 0.3, 2), SHAPES["box"]((0.5, 0.4, 0.8)), 0.3),
    ],
    ids=["sierpinski", "octahedra", "icosahedra", "dodecahedra", "dust"],
)
def test_a_flake_is_the_union_of_its_copies_and_the_distance_to_it(shape, solid, ratio):
    corners = np.array(CORNERS[type(shape)], float)
    corners *= solid.half_size if isinstance(shape, CantorDust) else solid.radius / np.linalg.norm(corners[0])
    centers, scale = np.zeros((1, 3)), 1.0
    for _ in range(int(shape.levels)):
        centers = (centers[:, None] + scale * (1.0 - ratio) * corners).reshape(-1, 3)
        scale *= ratio
    at = around(shape, 1500)
    nearest = np.full(len(at), np.inf)
    for center in centers:
        nearest = np.minimum(nearest, scale * solid.distance((at - center) / scale))
    np.testing.assert_allclose(shape.distance(at), nearest, atol=1e-14)
    assert shape.volume() == pytest.approx(len(centers) * scale**3 * solid.volume(), rel=1e-13)


@pytest.mark.parametrize("level", range(5))
def test_the_sponge_has_no_point_with_two_ones_in_the_same_place_of_its_digits(level):
    shape = MengerSponge(0.7, level)
    at = around(shape, 20_000)
    at = at + 0.4 * at * (np.random.default_rng(2).uniform(size=(len(at), 1)) < 0.5)  # some well outside, too
    position = (at + 0.7) / 1.4
    inside = (np.abs(at) <= 0.7).all(axis=1)
    for place in range(1, level + 1):
        digits = np.floor(position * 3.0**place).astype(int) % 3
        inside &= (digits == 1).sum(axis=1) < 2
    same_set(shape, at, inside)
    assert shape.volume() == pytest.approx((20 / 27) ** level * 1.4**3, rel=1e-14)


def outline_of_koch(radius: float, level: int) -> np.ndarray:
    """Corners (n, 2), counter-clockwise."""
    points = radius * np.exp(1j * (math.pi / 2 + math.tau / 3 * np.arange(3)))
    for _ in range(level):
        side = (np.roll(points, -1) - points) / 3
        tip = points + side + side * np.exp(-1j * math.pi / 3)  # outside is to the right
        points = np.stack([points, points + side, tip, points + 2 * side], axis=1).ravel()
    return np.stack([points.real, points.imag], axis=1)


@pytest.mark.parametrize("level", range(5))
def test_the_koch_curve_is_its_polygon_and_the_distance_to_it(level):
    shape = KochCurve(0.6, level)
    a = outline_of_koch(0.6, level)
    b = np.roll(a, -1, axis=0)
    at = np.random.default_rng(4).uniform(-0.8, 0.8, (1000, 2))
    side, from_a = b - a, at[:, None] - a
    along = np.clip((from_a * side).sum(-1) / (side**2).sum(-1), 0.0, 1.0)
    distance = np.linalg.norm(from_a - along[..., None] * side, axis=-1).min(axis=1)
    # An odd number of sides is crossed on the way to infinity along x.
    upwards, x, y = (a[:, 1] <= at[:, 1:]) != (b[:, 1] <= at[:, 1:]), *at.T[:, :, None]
    crossing = a[:, 0] + (y - a[:, 1]) / np.where(side[:, 1] == 0.0, 1.0, side[:, 1]) * side[:, 0] > x
    inside = (upwards & crossing).sum(axis=1) % 2 == 1
    field = shape.distance(np.insert(at, 2, 0.0, axis=1))
    np.testing.assert_allclose(field, np.where(inside, -distance, distance), atol=1e-14)
    area = 0.5 * abs((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    assert shape.area() == pytest.approx(area, rel=1e-13)
    assert KochSnowflake(0.6, level, 0.3).volume() == pytest.approx(0.3 * area, rel=1e-13)
    np.testing.assert_allclose(shape.support(at), (at @ a.T).max(axis=1), atol=1e-15)


def turn(p, axis: int, angle: float):
    u, v = (axis + 1) % 3, (axis + 2) % 3
    p = list(p)
    p[u], p[v] = math.cos(angle) * p[u] - math.sin(angle) * p[v], math.sin(angle) * p[u] + math.cos(angle) * p[v]
    return p


@pytest.mark.parametrize(
    "shape",
    [
        Kifs(),
        Kifs(0.4, 3, 1.8, (0.1, 0.3, 0.5), (0.3, -0.7, 1.1), (0.0, 0.5, -0.2)),
        Kifs(0.3, 8, 1.4, (0.2, -0.1, 0.5)),
    ],
    ids=["default", "turned", "slow"],
)
def test_the_kaleidoscope_is_its_rounds(shape):
    def inside(p):
        for _ in range(int(shape.levels)):
            for axis in range(3):
                p = turn(p, axis, shape.fold_angles[axis])
            p = sorted(map(abs, p))
            for axis in range(3):
                p = turn(p, axis, shape.angles[axis])
            p = [shape.scale * (a - c) + c for a, c in zip(p, shape.center)]
        return max(map(abs, p)) <= shape.half_size

    at = around(shape, 2500)
    same_set(shape, at, [inside(p) for p in at])


# -- orbits -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("power, rounds", [(8, 1), (8, 4), (8, 12), (2, 6), (3, 5), (5, 4), (2.5, 5), (6.3, 3)])
def test_the_mandelbulb_is_what_does_not_run_away(power, rounds):
    shape = Mandelbulb(0.5, power, rounds)
    limit = 2.0 ** (1.0 / (power - 1.0))

    def inside(p):
        z = p
        for _ in range(rounds):
            r = math.hypot(*z)
            if r > limit:
                return False
            polar, azimuth = power * math.atan2(math.hypot(z[0], z[1]), z[2]), power * math.atan2(z[1], z[0])
            direction = math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar)
            z = [r**power * a + b for a, b in zip(direction, p)]
        return math.hypot(*z) <= limit

    at = around(shape, 2500)
    same_set(shape, at, [inside(p) for p in at * (limit / 0.5)])


@pytest.mark.parametrize(
    "c, w, rounds",
    [
        ((-0.2, 0.6, 0.2, 0.2), 0.0, 8),
        ((-0.45, 0.447, 0.181, 0.306), 0.2, 6),
        ((0.0, 0.0, 0.0, 0.0), 0.3, 10),
        ((-1.0, 0.2, 0.0, 0.0), 0.0, 12),
        ((0.3, -0.5, 0.1, -0.4), -0.1, 3),
    ],
)
def test_the_julia_set_is_what_does_not_run_away(c, w, rounds):
    shape = JuliaQuaternion(0.6, c[:3], c[3], w, rounds)
    limit = (1.0 + math.sqrt(1.0 + 4.0 * math.hypot(*c))) / 2.0

    def product(p, q):
        (a, b), (c, d) = p, q  # pairs of complex numbers, as Cayley and Dickson have them
        return a * c - d.conjugate() * b, d * a + b * c.conjugate()

    def inside(p):
        q = complex(p[0], p[1]), complex(p[2], w)
        for _ in range(rounds):
            if math.hypot(*map(abs, q)) > limit:
                return False
            q = product(q, q)
            q = q[0] + complex(c[0], c[1]), q[1] + complex(c[2], c[3])
        return math.hypot(*map(abs, q)) <= limit

    at = around(shape, 2500)
    same_set(shape, at, [inside(p) for p in at * (limit / 0.6)])


@pytest.mark.parametrize(
    "scale, inner, rounds",
    [(2.0, 0.5, 8), (-2.0, 0.5, 10), (-1.5, 0.5, 12), (3.0, 0.25, 4), (1.3, 0.9, 6), (-9.0, 1.0, 2)],
)
def test_the_mandelbox_is_what_does_not_run_away(scale, inner, rounds):
    shape = Mandelbox(0.5, scale, inner, rounds)
    half = 2.0 * (scale + 1.0) / (scale - 1.0) if scale > 0.0 else 2.0
    limit = (2.0 * abs(scale) + half) / (abs(scale) - 1.0)

    def inside(p):
        if max(map(abs, p)) > half:
            return False
        z = p
        for _ in range(rounds):
            z = [2.0 - a if a > 1.0 else -2.0 - a if a < -1.0 else a for a in z]
            r = math.hypot(*z)
            factor = 1.0 / inner**2 if r < inner else 1.0 / r**2 if r < 1.0 else 1.0
            z = [scale * factor * a + b for a, b in zip(z, p)]
            if max(map(abs, z)) > limit:
                return False
        return True

    at = around(shape, 2500)
    same_set(shape, at, [inside(p) for p in at * (half / 0.5)])


def packed_balls(least: float) -> np.ndarray:
    """Balls (n, 4) of the packing in a ball of radius 1, centre and radius, of at least this radius.

    With k the curvature and c the centre of five spheres that touch one another: where one of them is replaced by the
    other sphere that touches the same four, k and k c become the sum of those four less the old value (Soddy).
    """
    corner = np.array(CORNERS[SierpinskiTetrahedron]) * math.sqrt(0.5)
    outer = 1.0 + math.sqrt(1.5)
    first = np.array([(*c, 1.0) for c in corner] + [(0.0, 0.0, 0.0, -1.0 / outer)])
    pending, seen, found = [first], set(), {}
    while pending:
        five = pending.pop()
        for index in range(5):
            ball = five.sum(axis=0) - 2.0 * five[index]
            if ball[3] <= 0.0 or 1.0 / ball[3] < least * outer:
                continue
            found[tuple(np.round(ball, 6))] = ball
            other = five.copy()
            other[index] = ball
            key = tuple(sorted(map(tuple, np.round(other, 6).tolist())))
            if key not in seen:
                seen.add(key)
                pending.append(other)
    balls = np.array([*first[:4], *found.values()])
    return np.concatenate([balls[:, :3], np.ones((len(balls), 1))], axis=1) / (balls[:, 3:] * outer)


def test_the_gasket_is_the_packing_of_soddy():
    balls = packed_balls(0.03)
    assert len(balls) > 200
    at = np.random.default_rng(6).normal(size=(6000, 3))
    at *= (np.random.default_rng(7).uniform(size=(6000, 1)) ** (1 / 3)) / np.linalg.norm(at, axis=1, keepdims=True)
    inside = np.array([(np.linalg.norm(balls[:, :3] - p, axis=1) <= balls[:, 3]).any() for p in at])
    assert (ApollonianGasket(1.0, 15).distance(at)[inside] <= 1e-12).all()
    for rounds in (1, 3, 15):
        # A point this deep inside is in a ball at least as large.
        assert inside[ApollonianGasket(1.0, rounds).distance(at) < -0.03].all()
    # The 5 first balls and the 5 that touch four of the first 5 and the sphere around: 4 on sides and the middle one.
    largest = balls[np.argsort(-balls[:, 3])][:15]
    inside = np.array([(np.linalg.norm(largest[:, :3] - p, axis=1) <= largest[:, 3]).any() for p in at])
    assert (ApollonianGasket(1.0, 1).distance(at)[inside] <= 1e-12).mean() > 0.9


# -- bounds -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape, least",
    [
        (Mandelbulb(), 0.3),
        (Mandelbulb(power=3), 0.2),
        (JuliaQuaternion(), 0.4),
        (Mandelbox(), 0.08),
        (ApollonianGasket(), 0.5),
        (MengerSponge(), 0.6),
        (Kifs(), 0.7),
    ],
)
def test_proven_bounds_are_not_idle(shape, least):
    """Median of the field over the distance to the nearest of many points inside, which is a little farther."""
    low, high = shape.bounds()
    at = np.random.default_rng(8).uniform(low, high, (100_000, 3))
    field = shape.distance(at)
    nearest, _ = cKDTree(at[field <= 0.0]).query(at[field > 0.0][:2000])
    ratio = field[field > 0.0][:2000] / nearest
    assert ratio.max() < 1.0 and np.median(ratio) > least


def _slopes(shape, pairs: int, seed: int) -> np.ndarray:
    """Change of the field over distance for random pairs of points, beyond what rounding may do."""
    low, high = shape.bounds()
    rng, size = np.random.default_rng(seed), high - low
    a = (low + high) / 2 + size * rng.uniform(-0.7, 0.7, (pairs, 3))
    b = a + rng.normal(size=a.shape) * size * 10.0 ** rng.uniform(-6, -0.5, (pairs, 1))
    change = np.abs(shape.distance(a) - shape.distance(b)) - 1e-15 * np.linalg.norm(size)
    return change / np.linalg.norm(a - b, axis=1)


OTHER_NUMBERS = [
    Mandelbulb(power=2, rounds=10),
    Mandelbulb(power=3, rounds=8),
    Mandelbulb(power=16),
    Mandelbox(scale=-2, rounds=10),
    Mandelbox(scale=2, rounds=8),
    Mandelbox(scale=1.2, inner_radius=0.1),
    JuliaQuaternion(constant=(-1.0, 0.2, 0.0)),
    ApollonianGasket(rounds=10),
    Kifs(levels=12),
    MengerSponge(levels=6),
    KochSnowflake(levels=9),
]


@pytest.mark.parametrize("shape", OTHER_NUMBERS, ids=lambda s: s.label())
def test_the_slope_is_at_most_1_for_other_numbers(shape):
    assert shape.certified and shape.lipschitz == 1.0 and _slopes(shape, 5000, 14).max() <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("shape", OTHER_NUMBERS, ids=lambda s: s.label())
def test_the_slope_is_at_most_1_for_a_million_pairs(shape):
    assert max(_slopes(shape, 100_000, seed).max() for seed in range(10)) <= 1.0


def test_what_a_broken_power_tears_is_little():
    """Pairs of points on both sides of the half plane y = 0, x < 0, or near the axis below 0; others keep the bound."""
    shape = Mandelbulb(0.5, 2.5, 4)
    assert not shape.certified and Mandelbulb(0.5, 5.0).certified
    slope = _slopes(shape, 200_000, 9)
    assert 0.0 < np.mean(slope > 1.0 + 1e-6) < 1e-4


def test_a_mandelbox_that_does_not_grow_is_refused():
    assert Mandelbox(scale=1.05).validate() == "Mandelbox: scale is 1.05, but must be at least 1.1, or at most -1.1."
    assert Mandelbox(scale=-1.0).validate() and not Mandelbox(scale=-1.1).validate()


@pytest.mark.parametrize(
    "shape",
    [
        Mandelbulb(power=2, rounds=30),
        Mandelbulb(power=32, rounds=30),
        JuliaQuaternion(2.0, 2.0, 2.0, 2.0, 30),
        Mandelbox(scale=10.0, rounds=30),
        Mandelbox(scale=-1.1, inner_radius=0.05, rounds=30),
        ApollonianGasket(rounds=30),
        MengerSponge(levels=12),
        CantorDust(ratio=0.05, levels=12),
        DodecahedronFlake(levels=12),
        KochSnowflake(levels=12),
        Kifs(levels=12, scale=10.0, center=(5.0, -3.0, 1.0)),
    ],
    ids=lambda s: s.label(),
)
def test_the_ends_of_the_limits_are_finite(shape):
    rng = np.random.default_rng(10)
    at = np.concatenate(
        [
            around(shape, 2000),
            np.zeros((1, 3)),
            1e12 * rng.normal(size=(50, 3)),
            1e-300 * rng.normal(size=(50, 3)),
            *(t * np.eye(3) for t in (1e-9, 0.5, 1.0, -1.0, 1e6)),
        ]
    )
    assert shape.validate() == "" and np.isfinite(shape.distance(at)).all()
    assert np.isfinite(np.concatenate(shape.bounds())).all()
