# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every shape promises, held against every shape."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdf_lights.graph import codegen_native, numpy_evaluation
from sdf_lights.sdf.program import INSTRUCTION, NoClosedForm, Op
from sdf_lights.sdf.shapes import (
    BOUND,
    EXACT,
    NONE,
    SHAPES,
    Box,
    BoxFrame,
    Capsule,
    Cone,
    Cylinder,
    Difference,
    Ellipsoid,
    Intersection,
    Primitive,
    Shape,
    ShapeError,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.polygons import Polygon
from sdf_lights.sdf.shapes.profiles import PROFILES, Profile
from support.shapes.samples import MIRROR, PRIMITIVES, SHAPES_TO_TRY, SHEAR, points, rotation, surface, varied, window


def each(shapes: dict[str, Shape]):
    return pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in shapes.items()])


each_shape = each(SHAPES_TO_TRY)
each_primitive = each(PRIMITIVES)

MATRICES = {"as it is": np.eye(4), "rotated": rotation(), "sheared": SHEAR, "mirrored": MIRROR}


def _scale(shape: Shape, at: np.ndarray) -> np.ndarray:
    """Size of the numbers that a distance at each point is made from: rounding is relative to it."""
    low, high = window(shape)
    return np.linalg.norm(at, axis=-1) + np.linalg.norm(high - low) + np.linalg.norm(low)


def _around(shape: Shape, count: int, seed: int) -> np.ndarray:
    """Random points (count, 3) of the shape's box at twice its size."""
    low, high = window(shape)
    return (low + high) / 2 + (high - low) * np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3))


def _parts(shape):
    """The shape or profile, and all that it is made of."""
    yield shape
    for field in dataclasses.fields(shape):
        value = getattr(shape, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Shape | Profile):
                yield from _parts(part)


def test_everything_is_tried():
    tried = {type(part) for shape in SHAPES_TO_TRY.values() for part in _parts(shape)}
    assert not (set(SHAPES.values()) | set(PROFILES.values())) - tried
    assert set(PRIMITIVES.items()) <= set(SHAPES_TO_TRY.items())  # no name stands for two shapes


# -- readings ---------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
@each_shape
def test_native_code_agrees_with_numpy(shape):
    at = points(shape)
    native = codegen_native.evaluate(shape.formula(), at, shape.parameters())
    error = np.abs(native - shape.distance(at)) / _scale(shape, at)
    assert error.max() < 1e-14


@each_shape
def test_every_value_is_finite(shape):
    assert np.isfinite(shape.distance(points(shape))).all()


def _other_numbers(shape: Shape) -> Shape:
    """The shape with every number changed a little."""
    if isinstance(shape, Polygon):
        return Polygon(1.05 * np.array(shape.points) + 0.003)
    numbers = {}
    for field in shape.fields():
        value = getattr(shape, field.name)
        change = (lambda v: v + 1.0) if field.whole else (lambda v: 1.05 * v + 0.003)
        numbers[field.name] = tuple(map(change, value)) if field.size == 3 else change(value)
    if isinstance(shape, Transformed):
        return Transformed(_other_numbers(shape.child), np.array(shape.matrix) @ np.diag([1.2, 0.9, 1.1, 1.0]))
    if "children" in {field.name for field in dataclasses.fields(shape)}:
        return type(shape)(*map(_other_numbers, shape.children), **numbers)
    parts = {
        field.name: _other_numbers(getattr(shape, field.name))
        for field in dataclasses.fields(shape)
        if field.metadata.get("part")
    }
    return dataclasses.replace(shape, **parts, **numbers)


@each_shape
def test_numbers_do_not_change_the_formula(shape):
    other = _other_numbers(shape)
    assert other.formula() is shape.formula()
    assert len(other.parameters()) == len(shape.parameters())
    assert not np.array_equal(other.parameters(), shape.parameters())


# -- distance and bounds ----------------------------------------------------------------------------------------------


def _hold_to_the_lipschitz_bound(shape, pairs: int, seed: int):
    rng = np.random.default_rng(seed)
    low, high = window(shape)
    a = (low + high) / 2 + (high - low) * rng.uniform(-1.5, 1.5, (pairs, 3))
    b = a + rng.normal(size=a.shape) * (high - low) * 10.0 ** rng.uniform(-7, 0, (pairs, 1))
    difference = np.abs(shape.distance(a) - shape.distance(b))
    rounding = 1e-15 * (_scale(shape, a) + _scale(shape, b))
    assert (difference <= shape.lipschitz * np.linalg.norm(a - b, axis=1) + rounding).all()


CERTIFIED = {n: s for n, s in SHAPES_TO_TRY.items() if s.certified and math.isfinite(s.lipschitz)}


@each(CERTIFIED)
def test_the_lipschitz_bound_holds(shape):
    _hold_to_the_lipschitz_bound(shape, 10_000, 7)


@pytest.mark.slow
@each(CERTIFIED)
def test_the_lipschitz_bound_holds_for_a_million_pairs(shape):
    for seed in range(10):
        _hold_to_the_lipschitz_bound(shape, 100_000, 100 + seed)


@each_shape
def test_what_is_exact_or_a_bound_has_slope_1(shape):
    assert shape.exactness in (EXACT, BOUND, NONE) and shape.lipschitz > 0.0
    if shape.exactness != NONE:
        assert shape.certified and shape.lipschitz <= 1.0


@each(CERTIFIED)
def test_the_field_never_exceeds_the_distance(shape):
    at = _around(shape, 500, 13)
    nearest, _ = cKDTree(surface(shape)).query(at)
    assert (np.abs(shape.distance(at)) <= shape.lipschitz * nearest + 1e-9).all()


def _reaches_the_surface(shape, at: np.ndarray) -> np.ndarray:
    """Whether there is a point of the surface as far away as the field says, in the direction of its gradient."""
    step = 1e-6
    offsets = step * np.eye(3)
    gradient = np.stack([shape.distance(at + o) - shape.distance(at - o) for o in offsets], axis=-1) / (2.0 * step)
    field = shape.distance(at)
    size = np.linalg.norm(gradient, axis=1)
    foot = at - (field / np.where(size > 0.0, size, 1.0))[:, None] * gradient
    return (size > 0.0) & (np.abs(shape.distance(foot)) < 1e-7)


@each_shape
def test_an_exact_field_is_the_distance(shape):
    reached = np.mean(_reaches_the_surface(shape, _around(shape, 3000, 23)))
    # Where two points of the surface are equally near there is no gradient: random points are hardly ever so close.
    if shape.exactness == EXACT:
        assert reached > 0.999
    else:
        assert reached < 0.999


def test_which_combinations_are_exact():
    assert Ellipsoid().exactness == BOUND
    assert Transformed(Box(), rotation()).exactness == EXACT
    assert Transformed(Box(), SHEAR).exactness == BOUND
    assert Union(Box()).exactness == EXACT and Union(Box(), Sphere()).exactness == BOUND


def _extent_by_search(shape, directions: np.ndarray) -> np.ndarray:
    """Greatest d · x of points x in the shape found by a random search, (n,), for unit directions d (n, 3)."""
    rng = np.random.default_rng(31)
    start = surface(shape)
    best = start[np.argmax(start @ directions.T, axis=0)]
    low, high = window(shape)
    for _ in range(30):
        spread = 10.0 ** rng.uniform(-3.5, -0.5, (len(best), 60, 1))
        near = best[:, None] + spread * (high - low) * rng.normal(size=(len(best), 60, 3))
        near[:, 0] = best
        inside = shape.distance(near) <= 1e-12
        inside[:, 0] = True
        along = np.where(inside, np.einsum("nmi,ni->nm", near, directions), -np.inf)
        best = near[np.arange(len(best)), np.argmax(along, axis=1)]
    return (best * directions).sum(axis=1)


@each_shape
def test_bounds_contain_and_primitives_touch_them(shape):
    found = surface(shape)
    for matrix in MATRICES.values():
        low, high = shape.bounds(matrix)
        world = found @ matrix[:3, :3].T + matrix[:3, 3]
        slack = 1e-9 * (1.0 + np.linalg.norm(world, axis=1).max())
        assert (world >= low - slack).all() and (world <= high + slack).all()
        assert np.isfinite([low, high]).all() or not shape.bounded
        np.testing.assert_array_equal(Transformed(shape, matrix).bounds(), (low, high))
        if isinstance(shape, Primitive) and shape.bounded and shape.exactness != NONE:
            # In the shape's own space a face of the box is a plane across a row of the matrix.
            rows = np.concatenate([-matrix[:3, :3], matrix[:3, :3]])
            lengths = np.linalg.norm(rows, axis=1)
            planes = np.concatenate([matrix[:3, 3] - low, high - matrix[:3, 3]]) / lengths
            size = np.linalg.norm(np.subtract(*shape.bounds()))
            if shape.exact_outside:
                # Far away, the distance to the shape is that to its tangent plane.
                normals, center = rows / lengths[:, None], np.add(*shape.bounds()) / 2
                far = 1e5 * size
                reached = normals @ center + far - shape.distance(center + far * normals)
                tolerance = 1e-5
            else:
                reached, tolerance = _extent_by_search(shape, rows / lengths[:, None]), 0.05
            assert (np.abs(planes - reached) <= tolerance * size).all()


@each_primitive
def test_size_does_not_matter(shape):
    at = points(shape)
    for factor in (2.0**-13, 2.0**20):
        lengths = {
            about.name: np.multiply(getattr(shape, about.name), factor)
            for about in shape.fields()
            if about.unit == "LENGTH"
        }
        scaled = dataclasses.replace(shape, **lengths)
        if scaled.validate() == "":
            error = np.abs(scaled.distance(factor * at) / factor - shape.distance(at)) / _scale(shape, at)
            assert error.max() < 1e-14


# -- volume -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape, volume",
    [
        (Sphere(2.0), 33.510321638291124),
        (Ellipsoid((1.0, 2.0, 3.0)), 25.132741228718345),
        (Box((1.0, 2.0, 3.0)), 48.0),
        (Torus(1.0, 0.35), 2.418053078266907),
        (Cylinder(2.0, 3.0), 37.69911184307752),
        (Cone(1.0, 3.0), math.pi),
        (Capsule(1.0, 3.0), 13.613568165555769),
        # Twelve bars: 4 of each length between the corner cubes, and 8 cubes.
        (BoxFrame((1.0, 1.5, 2.0), 0.25), 0.25**2 * 4 * (1.5 + 2.5 + 3.5) + 8 * 0.25**3),
        (BoxFrame((1.0, 1.0, 1.0), 1.0), 8.0),
        (Transformed(Box(0.5), SHEAR), abs(np.linalg.det(SHEAR))),
        (Transformed(Sphere(1.0), MIRROR), 4 / 3 * math.pi),
        (Union(Sphere(2.0)), 33.510321638291124),
    ],
)
def test_volume_by_hand(shape, volume):
    assert shape.volume() == pytest.approx(volume, rel=1e-14)


@each({n: s for n, s in SHAPES_TO_TRY.items() if s.bounded and s.volume() is not None})
def test_volume_against_counting(shape):
    low, high = shape.bounds()
    n = 100_000
    at = low + (high - low) * np.random.default_rng(17).uniform(size=(n, 3))
    fraction = np.mean(shape.distance(at) <= 0.0)
    expected = shape.volume() / np.prod(high - low)
    error = math.sqrt(max(expected * (1.0 - expected), 1.0 / n) / n)
    assert abs(fraction - expected) <= 4.0 * error  # one seed in 16,000 fails by chance


@each({n: s for n, s in SHAPES_TO_TRY.items() if not s.bounded})
def test_what_has_no_end_has_no_finite_volume(shape):
    assert shape.volume() in (None, math.inf)


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
    if op == Op.CONE:
        return (np.abs(p[:, 2]) <= b / 2) & (across <= a * (0.5 - p[:, 2] / b))
    if op == Op.HALF_SPACE:
        return p[:, 2] <= 0.0
    if op == Op.SPONGE:
        inside = (np.abs(p) <= a).all(axis=1)
        for place in range(1, int(b) + 1):
            inside &= (np.floor((p / a + 1.0) / 2.0 * 3.0**place) % 3 == 1).sum(axis=1) < 2
        return inside
    assert op == Op.FRUSTUM
    height = parameters[2]
    return (np.abs(p[:, 2]) <= height / 2) & (across <= a + (b - a) * (0.5 + p[:, 2] / height))


def _inside_program(program, at):
    stack = []
    for row in program:
        if row["op"] < Op.UNION:
            local = at @ row["inverse"][:, :3].T + row["inverse"][:, 3]
            stack.append(_inside_primitive(row["op"], row["parameters"], local))
        else:
            assert row["arity"] == 2
            b, a = stack.pop(), stack.pop()
            stack.append(
                {Op.UNION: a | b, Op.INTERSECTION: a & b, Op.DIFFERENCE: a & ~b, Op.EXCLUSIVE: a ^ b}[row["op"]]
            )
    (result,) = stack
    return result


def _has_program(shape) -> bool:
    try:
        return len(shape.program()) > 0
    except NoClosedForm:
        return False


@each({n: s for n, s in SHAPES_TO_TRY.items() if _has_program(s)})
def test_the_program_is_the_same_set(shape):
    at = points(shape)
    field = shape.distance(at)
    clear = np.abs(field) > 1e-9 * _scale(shape, at)  # nearer than that rounding decides
    assert clear.mean() > 0.8
    for matrix in (None, SHEAR, MIRROR):
        program = shape.program(matrix)
        assert program.dtype == INSTRUCTION
        world = at if matrix is None else at @ matrix[:3, :3].T + matrix[:3, 3]
        np.testing.assert_array_equal(_inside_program(program, world)[clear], field[clear] <= 0.0)


def test_a_shape_without_closed_form_says_so():
    @dataclasses.dataclass(frozen=True)
    class Blob(Primitive, abstract=True):
        """A shape of which only the formula is known."""

        def build(self, p, slot):
            return p.length() - 1.0

    with pytest.raises(NoClosedForm, match="Blob"):
        Union(Sphere(), Blob()).program()


def _evaluated(terms, at):
    stack = []
    for term in terms:
        if term.arity:
            operands = stack[-term.arity :]
            del stack[-term.arity :]
            # Operands take the place of the coordinates; there are at most three.
            at_operands = np.stack([*operands, *[np.zeros(len(at))] * (3 - term.arity)], axis=-1)
            stack.append(numpy_evaluation.evaluate(term.formula, at_operands, term.parameters))
        else:
            stack.append(numpy_evaluation.evaluate(term.formula, at, term.parameters))
    (result,) = stack
    return result


def _torn(shape, at: np.ndarray) -> np.ndarray:
    """Whether the field jumps within rounding of each point: that of a broken power of a Mandelbulb does."""
    steps = 1e-13 * _scale(shape, at)[:, None, None] * np.concatenate([np.eye(3), -np.eye(3)])
    return np.ptp(shape.distance(at[:, None] + steps), axis=1) > 1e-12 * _scale(shape, at)


@each_shape
def test_the_terms_are_the_field(shape):
    at = points(shape)
    if not shape.certified:
        at = at[~_torn(shape, at)]
    for matrix in (np.eye(4), SHEAR):
        factor = float(np.linalg.svd(matrix[:3, :3], compute_uv=False)[-1])
        world = at @ matrix[:3, :3].T + matrix[:3, 3]
        field = factor * shape.distance((world - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T)
        error = np.abs(_evaluated(shape.terms(matrix, factor), world) - field)
        assert (error <= 1e-13 * max(1.0, min(shape.lipschitz, 1e3)) * _scale(shape, world)).all()


# -- parameters -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape, problem",
    [
        (Sphere(-1.0), "Sphere: radius is -1, but must be at least 1e-06."),
        (Sphere(math.nan), "Sphere: radius is nan, but must be a finite number."),
        (Box((1.0, 0.0, 1.0)), "Box: half size is 0, but must be at least 1e-06."),
        (Cylinder(1.0, 1e30), "Cylinder: height is 1e+30, but must be at most 1e+09."),
        (
            Torus(0.5, 0.6),
            "Torus: minor radius 0.6 is more than the major radius 0.5, so the tube overlaps itself: "
            "make the minor radius smaller.",
        ),
        (
            BoxFrame(0.5, 0.6),
            "Box Frame: thickness 0.6 is more than the least half size 0.5, so the bars overlap: "
            "make the thickness smaller.",
        ),
        (Union(), "Union: it has no shapes to combine: give it at least one."),
        (Difference(Sphere(), Union(Box(), Sphere(0.0))), "Sphere: radius is 0, but must be at least 1e-06."),
        (
            Transformed(Sphere(), np.diag([1.0, 0.0, 1.0, 1.0])),
            "Transformed: the matrix flattens the shape: give it a scale other than zero along every axis.",
        ),
        (
            Transformed(Sphere(), np.full((4, 4), np.nan)),
            "Transformed: the matrix has a number that is not finite: give the shape an ordinary transform.",
        ),
        (Transformed(Sphere(-1.0), np.eye(4)), "Sphere: radius is -1, but must be at least 1e-06."),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(shape, problem):
    assert shape.validate() == problem


@pytest.mark.slow
@each_primitive
@pytest.mark.parametrize("seed", range(4))
def test_other_numbers_keep_the_promises(shape, seed):
    other = varied(shape, seed)
    promises = [
        test_every_value_is_finite,
        test_numbers_do_not_change_the_formula,
        test_what_is_exact_or_a_bound_has_slope_1,
        test_bounds_contain_and_primitives_touch_them,
        test_the_terms_are_the_field,
    ]
    if other.certified and math.isfinite(other.lipschitz):
        promises += [test_the_lipschitz_bound_holds, test_the_field_never_exceeds_the_distance]
    if other.exactness == EXACT:
        promises.append(test_an_exact_field_is_the_distance)
    if other.bounded and other.volume() is not None:
        promises.append(test_volume_against_counting)
    if _has_program(other):
        promises.append(test_the_program_is_the_same_set)
    for promise in promises:
        promise(other)


@each_shape
def test_good_parameters_are_accepted(shape):
    assert shape.validate() == ""


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sphere("wide"),
        lambda: Box((1.0, 2.0)),
        lambda: Union(Sphere(), 1.0),
        lambda: Union(1.0),
        lambda: Transformed(Sphere(), np.eye(3)),
        lambda: Transformed(1.0),
        lambda: Sphere(None),
        lambda: Sphere(10**400),
        lambda: Transformed(Sphere(), "matrix"),
    ],
)
def test_what_is_not_a_number_or_a_shape_is_refused(make):
    with pytest.raises(ShapeError):
        make()


@each_primitive
def test_fields_describe_themselves(shape):
    assert shape.fields() and shape.summary().endswith(".")
    for field in shape.fields():
        assert field.description and not field.description.endswith(".")
        assert field.unit in ("LENGTH", "ANGLE", "NONE") and not hasattr(Shape, field.name)
        components = field.default if field.size == 3 else (field.default,)
        assert all(field.minimum <= c <= field.soft_maximum <= field.maximum for c in components)


def test_names_of_shapes():
    assert SHAPES["box_frame"] is BoxFrame and BoxFrame.label() == "Box Frame"
    assert all(name.isidentifier() and name == name.lower() == shape.name() for name, shape in SHAPES.items())
    assert {"sphere", "prism", "half_space", "union"} <= set(SHAPES)


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
