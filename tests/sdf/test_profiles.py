# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Profiles against geometry without their formulas, and what is swept from them against what every shape promises."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdf_lights.sdf.program import NoClosedForm
from sdf_lights.sdf.shapes import BOUND, EXACT, SHAPES, ShapeError, Sphere
from sdf_lights.sdf.shapes.polygons import MOST_POINTS, Plus, Polygon, Polygonal, Rectangle, RegularPolygon, Star
from sdf_lights.sdf.shapes.profiles import (
    PROFILES,
    Almond,
    Circle,
    Ellipse,
    HeartOutline,
    Moon,
    Profile,
    Ring,
    RoundedRectangle,
)
from sdf_lights.sdf.shapes.swept import Extrusion, PartialRevolution, Revolution
from support.shapes.samples import SHEAR
from tests.sdf import test_shapes as promises

# Straight and inward corners, an edge along x, and corners at the same height.
BAY = Polygon(
    (0.5, 0.0),
    (0.1, 0.12),
    (0.05, 0.5),
    (-0.2, 0.15),
    (-0.5, 0.3),
    (-0.5, 0.0),
    (-0.5, -0.3),
    (-0.2, -0.2),
    (-0.1, -0.2),
    (0.1, -0.5),
    (0.1, -0.1),
)
PENTAGRAM = Polygon(*((math.sin(0.8 * math.pi * k), math.cos(0.8 * math.pi * k)) for k in range(5)))

PROFILES_TO_TRY = {name: profile() for name, profile in PROFILES.items() if profile is not Polygon} | {
    "triangle": RegularPolygon(3.0, 0.4),
    "64 sides": RegularPolygon(64.0, 0.5),
    "thin star": Star(3.0, 0.5, 0.1),
    "star of 7": Star(7.0, 0.5, 0.4),
    "star with outward corners": Star(5.0, 0.5, 0.48),
    "thick plus": Plus(0.5, 0.45),
    "small moon": Moon(0.3, 0.5, 0.4),
    "bitten disk": Moon(0.5, 0.3, 0.6),
    "disk as almond": Almond(0.4, 0.4),
    "thin almond": Almond(0.01, 0.5),
    "stadium": RoundedRectangle(0.8, 0.4, 0.2),
    "thick ring": Ring(0.2, 0.35),
    "bay": BAY,
    "pentagram": PENTAGRAM,
}

each_profile = pytest.mark.parametrize("profile", [pytest.param(p, id=n) for n, p in PROFILES_TO_TRY.items()])


def _around(profile: Profile, count: int, seed: int) -> np.ndarray:
    """Random points (count, 3) of the profile's rectangle at twice its size; z is any."""
    ends = profile.support(np.array([(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)]))
    low, high = -ends[:2], ends[2:]
    at = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3))
    at[:, :2] = (low + high) / 2 + (high - low) * at[:, :2]
    return at


def _edge(profile: Profile) -> np.ndarray:
    """Points (n, 2) on the edge: where segments between random points cross it."""
    a, b = _around(profile, 20_000, 3), _around(profile, 20_000, 4)
    crossing = (profile.distance(a) <= 0.0) != (profile.distance(b) <= 0.0)
    a, b = a[crossing], b[crossing]
    a_inside = profile.distance(a) <= 0.0
    for _ in range(50):
        middle = (a + b) / 2
        like_a = ((profile.distance(middle) <= 0.0) == a_inside)[:, None]
        a, b = np.where(like_a, middle, a), np.where(like_a, b, middle)
    edge = a[:, :2]
    if isinstance(profile, Moon):  # few segments cross its horns
        x, y = profile.tip()
        assert math.hypot(x, y) == pytest.approx(profile.radius)
        assert math.hypot(x - profile.offset, y) == pytest.approx(profile.bite_radius)
        edge = np.concatenate([edge, [(x, y), (x, -y)]])
    return edge


@each_profile
def test_a_field_is_the_distance_or_less(profile):
    at = _around(profile, 2000, 1)
    field = np.abs(profile.distance(at))
    nearest, _ = cKDTree(_edge(profile)).query(at[:, :2])
    assert (field <= nearest + 1e-9).all()
    if profile.exactness == EXACT:
        # Between the points of the edge there are gaps, and few where it is short.
        assert np.quantile(nearest - field, 0.99) < 0.01


@pytest.mark.parametrize(
    "profile", [pytest.param(p, id=n) for n, p in PROFILES_TO_TRY.items() if isinstance(p, Polygonal)]
)
def test_straight_edges_are_where_the_outline_says(profile):
    at = _around(profile, 2000, 2)
    field, corners = profile.distance(at), profile.outline()
    np.testing.assert_allclose(np.abs(field), _to_segments(corners, at[:, :2]), rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(field < 0.0, _turns(corners, at[:, :2]) % 2 == 1)


@each_profile
def test_the_support_is_that_of_the_edge(profile):
    directions = np.random.default_rng(5).normal(size=(40, 2))
    reached = (directions @ _edge(profile).T).max(axis=1)
    support = profile.support(directions)
    assert (support >= reached - 1e-9).all() and (support <= reached + 0.05).all()


def _counted(profile: Profile, of) -> tuple[float, float]:
    """Integral of a function of x over the profile, and the standard error, from random points."""
    at = _around(profile, 200_000, 6)
    values = np.where(profile.distance(at) <= 0.0, of(at[:, 0]), 0.0)
    ends = profile.support(np.array([(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)]))
    size = 4.0 * np.prod(ends[:2] + ends[2:])
    return size * values.mean(), size * values.std() / math.sqrt(len(at))


@each_profile
def test_area_and_moments_against_counting(profile):
    if profile.area() is None:
        assert profile is PENTAGRAM
        return
    counted, error = _counted(profile, np.ones_like)
    assert abs(profile.area() - counted) <= 4.0 * error
    for offset in (0.0, 0.1, 0.7):
        if profile.moment(offset) is not None:
            counted, error = _counted(profile, lambda x: np.maximum(x + offset, 0.0))
            assert abs(profile.moment(offset) - counted) <= 4.0 * error


def test_areas_by_hand():
    assert Rectangle(2.0, 3.0).area() == pytest.approx(6.0, rel=1e-14)
    assert RegularPolygon(4.0, 1.0).area() == pytest.approx(2.0, rel=1e-14)
    assert Almond(0.5, 0.5).area() == pytest.approx(0.25 * math.pi, rel=1e-14)
    assert Ring(1.0, 0.5).area() == pytest.approx(math.pi * (1.25**2 - 0.75**2), rel=1e-14)
    assert HeartOutline(1.0 + math.sqrt(0.5)).area() == pytest.approx(1.0 + 0.25 * math.pi, rel=1e-14)
    assert Moon(1.0, 1.0, 1e-3).area() == pytest.approx(2e-3, rel=1e-6)  # twice the radius times the offset
    assert Polygon((0, 0), (1, 0), (0, 1)).area() == pytest.approx(0.5, rel=1e-14)
    # Pappus: the area times the way of its centre. Turned about its own line: a ball, a cone.
    assert Revolution(Circle(0.2), 0.7).volume() == pytest.approx(2.0 * math.pi**2 * 0.7 * 0.2**2, rel=1e-14)
    assert Revolution(Circle(0.2), 0.0).volume() == pytest.approx(4.0 / 3.0 * math.pi * 0.2**3, rel=1e-14)
    cone = Revolution(Polygon((0, 0), (0.5, 0), (0, 2)))
    assert cone.volume() == pytest.approx(math.pi * 0.25 * 2.0 / 3.0, rel=1e-14)
    assert PartialRevolution(Circle(0.2), 0.7, 1.0).volume() == pytest.approx(math.pi * 0.7 * 0.2**2, rel=1e-14)
    # The two formulas of the moment of an almond agree where one takes over from the other.
    assert Almond(0.01, 1.0000001).moment(0.0) == pytest.approx(Almond(0.01, 0.9999999).moment(0.0), rel=1e-6)


# -- polygons against segments and winding numbers --------------------------------------------------------------------


def _to_segments(corners: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Distance of each point (n, 2) from the closed line."""
    a, along = corners, np.roll(corners, -1, axis=0) - corners
    way = ((at[:, None] - a) * along).sum(axis=-1) / (along**2).sum(axis=-1)
    feet = a + np.clip(way, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(at[:, None] - feet, axis=-1).min(axis=1)


def _turns(corners: np.ndarray, at: np.ndarray) -> np.ndarray:
    """How often the closed line goes around each point (n, 2)."""
    from_point = corners - at[:, None]
    angles = np.arctan2(from_point[..., 1], from_point[..., 0])
    steps = (np.roll(angles, -1, axis=1) - angles + math.pi) % math.tau - math.pi
    return np.rint(steps.sum(axis=1) / math.tau)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 8, 11, 16, 23, 32, 40])
def test_polygons_of_random_points(count):
    rng = np.random.default_rng(count)
    at = rng.uniform(-1.5, 1.5, (4000, 2))
    # Around the origin, so that the line does not cross itself; and anywhere, so that it does.
    angles = np.sort(rng.uniform(0.0, math.tau, count))
    simple = rng.uniform(0.2, 1.0, (count, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for corners in (simple, simple[::-1], rng.uniform(-1.0, 1.0, (count, 2))):
        polygon = Polygon(*corners)
        assert polygon.check() == ""
        field = polygon.distance(np.pad(at, ((0, 0), (0, 1))))
        np.testing.assert_allclose(np.abs(field), _to_segments(corners, at), rtol=0.0, atol=1e-14)
        np.testing.assert_array_equal(field < 0.0, _turns(corners, at) % 2 == 1)


@pytest.mark.parametrize("seed", range(6))
def test_closed_forms_of_winding_polygons(seed):
    """A band along a random walk: pockets in pockets."""
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.uniform(0.15, 0.45, 12))
    radii = 0.25 + 0.08 * angles + 0.02 * rng.normal(size=12)
    walk = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    polygon = Polygon(*walk, *(0.8 * walk[::-1]))
    assert polygon.simple and polygon.exactness == EXACT
    for shape in (Extrusion(polygon, 0.3), Revolution(polygon, 0.2), PartialRevolution(polygon, 1.0, 2.0)):
        low, high = shape.bounds()
        at = (low + high) / 2 + 0.6 * (high - low) * rng.uniform(-1.0, 1.0, (3000, 3))
        field = shape.distance(at)
        clear = np.abs(field) > 1e-9
        assert (field[clear] < 0.0).any() and clear.mean() > 0.99
        inside = promises._inside_program(shape.program(SHEAR), at @ SHEAR[:3, :3].T + SHEAR[:3, 3])
        np.testing.assert_array_equal(inside[clear], field[clear] < 0.0)


def test_whether_polygons_are_simple():
    assert BAY.simple and BAY.exactness == EXACT
    assert not PENTAGRAM.simple
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    assert Polygon(*square, (0, 0)).simple  # closed by hand
    assert Polygon(*square, (0, 0)).area() == pytest.approx(1.0, rel=1e-15)
    touching = Polygon((0, 0), (1, 0), (1, 1), (0.5, 0.0), (0, 1))
    spike = Polygon((0, 0), (1, 0), (2, 0), (1, 0), (1, 1))
    for polygon in (touching, spike):
        assert polygon.exactness == BOUND and polygon.area() is None and polygon.check() == ""
        with pytest.raises(NoClosedForm, match="polygon"):
            Extrusion(polygon).program()


def test_points_of_polygons():
    triangle = Polygon((0, 0), (1, 0), (0, 1))
    assert triangle == Polygon([(0, 0), (1, 0), (0, 1)]) == Polygon((0, 0, 5.0), (1, 0), (0, 1, -1.0))
    assert hash(triangle) == hash(Polygon(np.array([(0, 0), (1, 0), (0, 1)])))
    other = Polygon((0.1, 0), (1.2, 0.3), (0, 1))
    assert other.formula() is triangle.formula() and other != triangle
    assert Polygon((0, 0), (1, 0), (1, 1), (0, 1)).formula() is not triangle.formula()
    for points in ([(0, 0), (1, 0), 3.0], [(0, 0), (1, 0), (1, 2, 3, 4)], [(0, 0), "ab", (0, 1)]):
        with pytest.raises(ShapeError, match="a point must be two or three numbers"):
            Polygon(*points)


# -- swept ------------------------------------------------------------------------------------------------------------


def _solids(profile: Profile) -> dict:
    solids = {
        "extruded": Extrusion(profile, 0.4),
        "rounded": Extrusion(profile, 0.4, 0.05),
        "revolved": Revolution(profile, 1.2),
        "through the axis": Revolution(profile, 0.2),
        "about its middle": Revolution(profile, 0.0),
        "partly": PartialRevolution(profile, 1.1, 2.0),
        "mostly": PartialRevolution(profile, 0.1, 5.0),
    }
    return {name: solid for name, solid in solids.items() if solid.validate() == ""}


SOLIDS = [
    pytest.param(solid, id=f"{name} {how}")
    for name, profile in PROFILES_TO_TRY.items()
    for how, solid in _solids(profile).items()
]


def _hold_promises(shape):
    for promise in (
        promises.test_every_value_is_finite,
        promises.test_the_lipschitz_bound_holds,
        promises.test_what_is_exact_or_a_bound_has_slope_1,
        promises.test_the_field_never_exceeds_the_distance,
        promises.test_bounds_contain_and_primitives_touch_them,
        promises.test_the_terms_are_the_field,
    ):
        promise(shape)
    if shape.exactness == EXACT:
        promises.test_an_exact_field_is_the_distance(shape)
    if shape.volume() is not None:
        promises.test_volume_against_counting(shape)
    try:
        shape.program()
    except NoClosedForm:
        return
    promises.test_the_program_is_the_same_set(shape)


@pytest.mark.parametrize("solid", SOLIDS[::9])
def test_some_solids_keep_the_promises(solid):
    _hold_promises(solid)


@pytest.mark.slow
@pytest.mark.parametrize("solid", SOLIDS)
def test_every_solid_keeps_the_promises(solid):
    _hold_promises(solid)
    promises.test_native_code_agrees_with_numpy(solid)


@pytest.mark.parametrize("points", [3.0, 4.0, 7.0])
def test_needles_have_a_closed_form(points):
    """Arms of a star with angles too small for the sines of their edges."""
    star = SHAPES["star_prism"](points, 1e9, 4.5e-6)
    at = np.random.default_rng(8).uniform(-1e-5, 1e-5, (3000, 3))
    field = star.distance(at)
    clear = np.abs(field) > 1e-10
    assert clear.mean() > 0.99 and 0.1 < np.mean(field < 0.0) < 0.9
    np.testing.assert_array_equal(promises._inside_program(star.program(), at)[clear], field[clear] < 0.0)


def test_which_solids_are_exact():
    for profile in PROFILES_TO_TRY.values():
        assert Extrusion(profile).exactness == profile.exactness
        assert Revolution(profile, 5.0).exactness == PartialRevolution(profile, 5.0).exactness == profile.exactness
        assert Extrusion(profile, 0.3, 0.01).exactness == BOUND
    assert Revolution(Star(), 0.0).exactness == EXACT and Revolution(Star(), 0.1).exactness == BOUND
    assert Revolution(BAY, 0.0).exactness == BOUND


def test_the_least_boxes():
    low, high = Extrusion(Circle(0.5), 0.2).bounds()
    np.testing.assert_allclose([low, high], [(-0.5, -0.5, -0.1), (0.5, 0.5, 0.1)], rtol=1e-15)
    low, high = PartialRevolution(Rectangle(0.2, 0.4), 1.0, math.pi).bounds()
    np.testing.assert_allclose([low, high], [(0.0, -1.1, -0.2), (1.1, 1.1, 0.2)], atol=1e-15)


@pytest.mark.parametrize("name", ["star_prism", "plus_prism", "crescent", "heart_prism"])
def test_prisms_say_what_is_wrong_in_their_own_name(name):
    shape = SHAPES[name]
    assert len(shape.fields()) == len(dataclasses.fields(shape))  # numbers alone make it
    wrong = {"star_prism": "inner_radius", "plus_prism": "half_width", "crescent": "offset", "heart_prism": "width"}
    assert shape(**{wrong[name]: 0.0 if name == "heart_prism" else 5.0}).validate().startswith(shape.label() + ":")


@pytest.mark.parametrize(
    "shape, problem",
    [
        (Extrusion(Circle(-1.0)), "Circle: radius is -1, but must be at least 1e-06."),
        (Extrusion(Star(2.5)), "Star: points is 2.5, but must be at least 3."),
        (Extrusion(Star(3.5)), "Star: points is 3.5, but must be a whole number."),
        (
            Extrusion(Circle(), 0.2, 0.11),
            "Extrusion: rounding 0.11 is more than half of the height 0.2: make the rounding smaller.",
        ),
        (
            Extrusion(Moon(0.5, 0.2, 0.1)),
            "Moon: at an offset of 0.1 the circles do not cross: make it more than 0.3 and less than 0.7.",
        ),
        (
            Extrusion(Polygon((0, 0), (1, 1))),
            f"Polygon: it has 2 points: give it at least 3 and at most {MOST_POINTS}.",
        ),
        (
            Extrusion(Polygon((0, 0), (1, 1), (2, 2))),
            "Polygon: all its points lie on one straight line: move one of them aside.",
        ),
        (
            Extrusion(Polygon((0, 0), (1, math.nan), (2, 2))),
            "Polygon: a point has a coordinate that is not a finite number: give it an ordinary one.",
        ),
        (
            Revolution(Polygon((-2, 0), (-1, 0), (-1, 1)), 0.5),
            "Revolution: the whole profile is beyond the axis: make the offset more than 0.5 larger.",
        ),
        (Revolution(Ellipse(0.0)), "Ellipse: radius x is 0, but must be at least 1e-06."),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(shape, problem):
    assert shape.validate() == problem


def test_only_profiles_are_swept():
    with pytest.raises(ShapeError, match="Extrusion sweeps a profile"):
        Extrusion(Sphere())


def test_profiles_describe_themselves():
    assert not set(PROFILES) & set(SHAPES)
    for name, profile in PROFILES.items():
        assert profile.name() == name and profile.summary().endswith(".")
        for field in profile.fields():
            assert field.description and not hasattr(Profile, field.name)
