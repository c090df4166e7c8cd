# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every shape promises, held against every shape."""

import dataclasses
import math

import numpy as np
import pytest

from sdf_lights.sdf import read_native
from sdf_lights.sdf.program import INSTRUCTION, NoClosedForm, Op
from sdf_lights.sdf.shapes import BOUND, EXACT, SHAPES, Box, BoxFrame, Capsule, Cone, Cylinder, Difference, Ellipsoid
from sdf_lights.sdf.shapes import Intersection, Primitive, Shape, ShapeError, Sphere, Torus, Transformed, Union
from tests.sdf.samples import MIRROR, PRIMITIVES, SHAPES_TO_TRY, SHEAR, points, rotation

each_shape = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in SHAPES_TO_TRY.items()])
each_primitive = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in PRIMITIVES.items()])

MATRICES = {"rotated": rotation(), "sheared": SHEAR, "mirrored": MIRROR}


def _scale(shape: Shape, at: np.ndarray) -> np.ndarray:
    """Size of the numbers that a distance at each point is made from: rounding is relative to it."""
    low, high = shape.bounds()
    return np.linalg.norm(at, axis=-1) + np.linalg.norm(high - low) + np.linalg.norm(low)


# -- readings ---------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not read_native.AVAILABLE, reason="no Numba")
@each_shape
def test_native_code_agrees_with_numpy(shape):
    at = points(shape)
    native = read_native.evaluate(shape.formula(), at, shape.parameters())
    error = np.abs(native - shape.distance(at)) / _scale(shape, at)
    assert error.max() < 1e-14


@each_shape
def test_every_value_is_finite(shape):
    assert np.isfinite(shape.distance(points(shape))).all()


@each_shape
def test_numbers_do_not_change_the_formula(shape):
    def other(s):
        changed = {f.name: tuple(1.1 * v for v in getattr(s, f.name)) if f.size == 3 else 1.1 * getattr(s, f.name)
                   for f in s.fields()}
        if isinstance(s, Transformed):
            return Transformed(other(s.child), np.array(s.matrix) @ np.diag([1.2, 0.9, 1.1, 1.0]))
        if s.children:
            return type(s)(*map(other, s.children))
        return dataclasses.replace(s, **changed)

    assert other(shape).formula() is shape.formula()
    assert len(other(shape).parameters()) == len(shape.parameters())
    assert not np.array_equal(other(shape).parameters(), shape.parameters())


# -- distance and bounds ----------------------------------------------------------------------------------------------


@each_shape
def test_the_lipschitz_bound_holds(shape):
    rng = np.random.default_rng(7)
    low, high = shape.bounds()
    center, extent = (low + high) / 2, high - low
    a = center + extent * rng.uniform(-1.5, 1.5, (100_000, 3))
    b = a + rng.normal(size=a.shape) * extent * 10.0 ** rng.uniform(-7, 0, (len(a), 1))
    difference = np.abs(shape.distance(a) - shape.distance(b))
    rounding = 1e-15 * (_scale(shape, a) + _scale(shape, b))
    assert (difference <= shape.lipschitz * np.linalg.norm(a - b, axis=1) + rounding).all()


def _surface(shape, count: int = 6000) -> np.ndarray:
    """At least ``count`` points on the surface: where segments between random points cross it."""
    rng = np.random.default_rng(11)
    low, high = shape.bounds()
    center, extent = (low + high) / 2, high - low
    found = []
    while sum(map(len, found)) < count:
        ends = center + 0.75 * extent * rng.uniform(-1.0, 1.0, (2, 30_000, 3))
        inside = shape.distance(ends) <= 0.0
        crossing = inside[0] != inside[1]
        a, b = ends[0][crossing], ends[1][crossing]
        a_inside = inside[0][crossing]
        for _ in range(50):
            middle = (a + b) / 2
            like_a = (shape.distance(middle) <= 0.0) == a_inside
            a, b = np.where(like_a[:, None], middle, a), np.where(like_a[:, None], b, middle)
        found.append(a)
    return np.concatenate(found)


@each_shape
def test_the_field_never_exceeds_the_distance(shape):
    surface = _surface(shape)
    rng = np.random.default_rng(13)
    low, high = shape.bounds()
    at = (low + high) / 2 + (high - low) * rng.uniform(-1.0, 1.0, (300, 3))
    nearest = np.array([np.sqrt(((surface - p) ** 2).sum(axis=1).min()) for p in at])
    assert (np.abs(shape.distance(at)) <= nearest + 1e-9).all()


def _reaches_the_surface(shape, at: np.ndarray) -> np.ndarray:
    """Whether there is a point of the surface as far away as the field says, in the direction of its gradient."""
    step = 1e-6
    offsets = step * np.eye(3)
    gradient = np.stack([shape.distance(at + o) - shape.distance(at - o) for o in offsets], axis=-1) / (2.0 * step)
    field = shape.distance(at)
    foot = at - field[:, None] * gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    return np.abs(shape.distance(foot)) < 1e-7


@each_shape
def test_an_exact_field_is_the_distance(shape):
    rng = np.random.default_rng(23)
    low, high = shape.bounds()
    at = (low + high) / 2 + 0.7 * (high - low) * rng.uniform(-1.0, 1.0, (5000, 3))
    reached = np.mean(_reaches_the_surface(shape, at))
    # Where two points of the surface are equally near there is no gradient: random points are hardly ever so close.
    if shape.exactness == EXACT:
        assert reached > 0.999
    else:
        assert reached < 0.99


def test_which_shapes_are_exact():
    assert {n for n, s in PRIMITIVES.items() if s.exactness != EXACT} == {"ellipsoid"}
    assert Transformed(Box(), rotation()).exactness == EXACT
    assert Transformed(Box(), SHEAR).exactness == BOUND
    assert Union(Box()).exactness == EXACT and Union(Box(), Sphere()).exactness == BOUND


@each_shape
@pytest.mark.parametrize("matrix", [pytest.param(m, id=n) for n, m in MATRICES.items()])
def test_bounds_contain_and_primitives_touch_them(shape, matrix):
    low, high = shape.bounds(matrix)
    surface = _surface(shape, 2000) @ matrix[:3, :3].T + matrix[:3, 3]
    slack = 1e-9 * (high - low)
    assert (surface >= low - slack).all() and (surface <= high + slack).all()
    if isinstance(shape, Primitive):
        # A thousand points and more a shape come within a tenth of every face of a box that is not too large; a box
        # touches with its corners alone, which scattered points come less close to.
        reach = np.concatenate([surface.min(axis=0) - low, high - surface.max(axis=0)]) / np.tile(high - low, 2)
        assert reach.max() < 0.1
    np.testing.assert_array_equal(Transformed(shape, matrix).bounds(), (low, high))


# -- volume -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape, volume", [
    (Sphere(2.0), 33.510321638291124), (Ellipsoid((1.0, 2.0, 3.0)), 25.132741228718345), (Box((1.0, 2.0, 3.0)), 48.0),
    (Torus(1.0, 0.35), 2.418053078266907), (Cylinder(2.0, 3.0), 37.69911184307752), (Cone(1.0, 3.0), math.pi),
    (Capsule(1.0, 3.0), 13.613568165555769),
    # Twelve bars: 4 of each length between the corner cubes, and 8 cubes.
    (BoxFrame((1.0, 1.5, 2.0), 0.25), 0.25**2 * 4 * (1.5 + 2.5 + 3.5) + 8 * 0.25**3),
    (BoxFrame((1.0, 1.0, 1.0), 1.0), 8.0),
    (Transformed(Box(0.5), SHEAR), abs(np.linalg.det(SHEAR))), (Transformed(Sphere(1.0), MIRROR), 4 / 3 * math.pi),
    (Union(Sphere(2.0)), 33.510321638291124)])
def test_volume_by_hand(shape, volume):
    assert shape.volume() == pytest.approx(volume, rel=1e-14)


@each_shape
def test_volume_against_counting(shape):
    if shape.volume() is None:
        assert not isinstance(shape, Primitive)
        return
    low, high = shape.bounds()
    box = np.prod(high - low)
    n = 200_000
    at = low + (high - low) * np.random.default_rng(17).uniform(size=(n, 3))
    fraction = np.mean(shape.distance(at) <= 0.0)
    expected = shape.volume() / box
    error = math.sqrt(expected * (1.0 - expected) / n)
    assert abs(fraction - expected) <= 4.0 * error  # one seed in 16,000 fails by chance


# -- the program ------------------------------------------------------------------------------------------------------


def _inside_primitive(op, parameters, p):
    """Membership by definition, independent of the formulas."""
    across = np.hypot(p[:, 0], p[:, 1])
    a, b = parameters[:2]
    if op == Op.SPHERE:
        return (p**2).sum(axis=1) <= a * a
    if op == Op.BOX:
        return (np.abs(p) <= parameters[:3]).all(axis=1)
    if op == Op.TORUS:
        return (across - a) ** 2 + p[:, 2] ** 2 <= b * b
    if op == Op.CAPSULE:
        beyond = np.maximum(np.abs(p[:, 2]) - b / 2, 0.0)
        return across**2 + beyond**2 <= a * a
    if op == Op.CYLINDER:
        return (across <= a) & (np.abs(p[:, 2]) <= b / 2)
    assert op == Op.CONE
    return (np.abs(p[:, 2]) <= b / 2) & (across <= a * (0.5 - p[:, 2] / b))


def _inside_program(program, at):
    stack = []
    for row in program:
        if row["op"] < Op.UNION:
            local = at @ row["inverse"][:, :3].T + row["inverse"][:, 3]
            stack.append(_inside_primitive(row["op"], row["parameters"], local))
        else:
            assert row["arity"] == 2
            b, a = stack.pop(), stack.pop()
            stack.append({Op.UNION: a | b, Op.INTERSECTION: a & b, Op.DIFFERENCE: a & ~b}[row["op"]])
    (result,) = stack
    return result


@each_shape
@pytest.mark.parametrize("matrix", [None, SHEAR, MIRROR], ids=["as it is", "sheared", "mirrored"])
def test_the_program_is_the_same_set(shape, matrix):
    program = shape.program(matrix)
    assert program.dtype == INSTRUCTION
    at = points(shape, 20_000)
    field = shape.distance(at)
    world = at if matrix is None else at @ matrix[:3, :3].T + matrix[:3, 3]
    clear = np.abs(field) > 1e-9 * _scale(shape, at)  # nearer than that rounding decides
    assert clear.mean() > 0.8
    np.testing.assert_array_equal(_inside_program(program, world)[clear], field[clear] <= 0.0)


def test_a_shape_without_closed_form_says_so():
    @dataclasses.dataclass(frozen=True)
    class Blob(Primitive, abstract=True):
        """A shape of which only the formula is known."""

        def build(self, p, slot):
            return p.length() - 1.0

    with pytest.raises(NoClosedForm, match="Blob"):
        Union(Sphere(), Blob()).program()


# -- parameters -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape, problem", [
    (Sphere(-1.0), "Sphere: radius is -1, but must be at least 1e-06."),
    (Sphere(math.nan), "Sphere: radius is nan, but must be a finite number."),
    (Box((1.0, 0.0, 1.0)), "Box: half size is 0, but must be at least 1e-06."),
    (Cylinder(1.0, 1e30), "Cylinder: height is 1e+30, but must be at most 1e+09."),
    (Torus(0.5, 0.6), "Torus: minor radius 0.6 is more than the major radius 0.5, so the tube overlaps itself: "
                      "make the minor radius smaller."),
    (BoxFrame(0.5, 0.6), "Box Frame: thickness 0.6 is more than the least half size 0.5, so the bars overlap: "
                         "make the thickness smaller."),
    (Union(), "Union: it has no shapes to combine: give it at least one."),
    (Difference(Sphere(), Union(Box(), Sphere(0.0))), "Sphere: radius is 0, but must be at least 1e-06."),
    (Transformed(Sphere(), np.diag([1.0, 0.0, 1.0, 1.0])),
     "Transformed: the matrix flattens the shape: give it a scale other than zero along every axis."),
    (Transformed(Sphere(), np.full((4, 4), np.nan)),
     "Transformed: the matrix has a number that is not finite: give the shape an ordinary transform."),
    (Transformed(Sphere(-1.0), np.eye(4)), "Sphere: radius is -1, but must be at least 1e-06.")])
def test_what_is_wrong_is_said_in_a_sentence(shape, problem):
    assert shape.validate() == problem


@each_shape
def test_good_parameters_are_accepted(shape):
    assert shape.validate() == ""


@pytest.mark.parametrize("make", [
    lambda: Sphere("wide"), lambda: Box((1.0, 2.0)), lambda: Union(Sphere(), 1.0), lambda: Union(1.0),
    lambda: Transformed(Sphere(), np.eye(3)),
    lambda: Transformed(1.0), lambda: Sphere(None), lambda: Sphere(10**400), lambda: Transformed(Sphere(), "matrix")])
def test_what_is_not_a_number_or_a_shape_is_refused(make):
    with pytest.raises(ShapeError):
        make()


@each_primitive
def test_fields_describe_themselves(shape):
    assert shape.fields() and shape.summary().endswith(".")
    for field in shape.fields():
        assert field.description and not field.description.endswith(".")
        assert field.unit in ("LENGTH", "ANGLE", "NONE")
        components = field.default if field.size == 3 else (field.default,)
        assert all(field.minimum <= c <= field.soft_maximum <= field.maximum for c in components)


def test_names_of_shapes():
    assert SHAPES["box_frame"] is BoxFrame and BoxFrame.label() == "Box Frame"
    assert list(SHAPES) == ["sphere", "ellipsoid", "box", "box_frame", "torus", "capsule", "cylinder", "cone",
                            "union", "intersection", "difference"]


def test_shapes_are_values():
    assert Box(0.5) == Box((0.5, 0.5, 0.5)) and hash(Box(0.5)) == hash(Box((0.5, 0.5, 0.5)))
    assert Union(Sphere(), Box()) == Union([Sphere(), Box()])
    with pytest.raises(dataclasses.FrozenInstanceError):
        Sphere().radius = 2.0


def test_chains_stay_shallow():
    a, b, c = Sphere(), Box(), Torus()
    assert Union(Union(a, b), c).children == (a, b, c)
    assert Difference(Difference(a, b), c).children == (a, b, c)
    inner = Difference(a, Difference(b, c))
    assert inner.children == (a, Difference(b, c)) and inner.depth == 3
    once = Transformed(Transformed(a, SHEAR), MIRROR)
    assert once.child is a and np.array_equal(once.matrix, MIRROR @ SHEAR)
    chain = a
    for _ in range(1500):
        chain = Union(chain, b)
    assert chain.size == 1501 and chain.depth == 2
    assert np.isfinite(chain.distance(np.zeros((1, 3)))).all()


def test_disjoint_parts_have_a_box_without_extent():
    apart = np.eye(4)
    apart[0, 3] = 10.0
    low, high = Intersection(Sphere(), Transformed(Sphere(), apart)).bounds()
    assert (high >= low).all() and np.prod(high - low) == 0.0

