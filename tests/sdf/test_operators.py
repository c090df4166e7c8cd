# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields in parts, and what operators promise of the shapes that they are given."""

import numpy as np
import pytest

from sdf_lights.graph import numpy_evaluation
from sdf_lights.sdf.program import Op
from sdf_lights.sdf.shapes import (
    BOUND,
    EXACT,
    Box,
    BoxFrame,
    Cylinder,
    Difference,
    Ellipsoid,
    Exclusive,
    Family,
    Intersection,
    Operator,
    Primitive,
    ShapeError,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.operators import guarded, level_bounds
from support.shapes.operated import OPERATED, SHEAR
from support.shapes.samples import COMPOSITES, MIRROR, points, rotation, window

each_composite = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in (COMPOSITES | OPERATED).items()])

SETS = {
    "union": Union(Box(0.5), Transformed(Torus(), SHEAR), Sphere(0.4), Cylinder(0.1, 3.0), Ellipsoid()),
    "intersection": Intersection(Box(0.5), Sphere(0.6), Transformed(Box(0.5), rotation())),
    "difference": Difference(Box(0.5), Sphere(0.6), Torus(), Cylinder(0.2, 3.0)),
    "exclusive": Exclusive(Box(0.5), Sphere(0.6), Torus(0.6, 0.2), Cylinder(0.2, 3.0)),
}
each_set = pytest.mark.parametrize("shape", [pytest.param(s, id=n) for n, s in SETS.items()])


def run(terms, at):
    """Values of every term of a list at points, in order: (terms, points)."""
    stack, values = [], []
    for term in terms:
        operands = stack[len(stack) - term.arity :]
        del stack[len(stack) - term.arity :]
        coordinates = at
        if term.arity:
            coordinates = np.zeros_like(at)
            coordinates[:, : term.arity] = np.transpose(operands)
        values.append(numpy_evaluation.evaluate(term.formula, coordinates, term.parameters))
        stack.append(values[-1])
    assert len(stack) == 1
    return np.array(values)


def _operands(terms):
    """For each term, the indices of its operands."""
    stack, operands = [], []
    for index, term in enumerate(terms):
        operands.append(stack[len(stack) - term.arity :])
        del stack[len(stack) - term.arity :]
        stack.append(index)
    return operands


@each_composite
def test_terms_keep_their_promises(shape):
    """Far from each other the join of two operands is one of them; and no value changes faster than it says."""
    rng = np.random.default_rng(3)
    low, high = window(shape)
    center, extent = (low + high) / 2, high - low
    a = center + extent * rng.uniform(-1.0, 1.0, (4000, 3))
    b = a + rng.normal(size=a.shape) * extent * 10.0 ** rng.uniform(-6, 0, (len(a), 1))
    terms = shape.terms(np.eye(4), 1.0)
    at_a, at_b = run(terms, a), run(terms, b)
    apart = np.linalg.norm(a - b, axis=1)
    for index, (term, operands) in enumerate(zip(terms, _operands(terms))):
        assert (np.abs(at_a[index] - at_b[index]) <= term.lipschitz * apart + 1e-13 * (1.0 + apart)).all()
        if term.arity == 2 and np.isfinite(term.blend_width):
            x, y = at_a[operands]
            lesser, greater = np.minimum(x, y), np.maximum(x, y)
            expected = {
                Family.UNION: lesser,
                Family.INTERSECTION: greater,
                Family.DIFFERENCE: np.maximum(x, -y),
                Family.EXCLUSIVE: np.maximum(lesser, -greater),
            }[term.family]
            distance = {Family.DIFFERENCE: np.abs(x + y), Family.EXCLUSIVE: np.abs(np.abs(x) - np.abs(y))}.get(
                term.family, np.abs(x - y)
            )
            apart_enough = distance > term.blend_width
            np.testing.assert_array_equal(at_a[index][apart_enough], expected[apart_enough])


@each_set
def test_sharp_sets_by_their_members(shape):
    at = points(shape, 3000)
    fields = np.array([child.distance(at) for child in shape.children])
    inside = fields <= 0.0
    expected = {
        Union: inside.any(axis=0),
        Intersection: inside.all(axis=0),
        Difference: inside[0] & ~inside[1:].any(axis=0),
        Exclusive: inside.sum(axis=0) % 2 == 1,
    }[type(shape)]
    clear = (np.abs(fields) > 1e-12 * (1.0 + np.linalg.norm(at, axis=1))).all(axis=0)
    np.testing.assert_array_equal((shape.distance(at) <= 0.0)[clear], expected[clear])
    # Whatever it does with the signs, the nearest of all surfaces is never left out.
    assert (np.abs(shape.distance(at)) >= np.abs(fields).min(axis=0)).all()


def test_joins_are_as_shallow_as_can_be():
    terms = Union([Transformed(Sphere(), np.eye(4) + 0.1 * i) for i in range(64)]).terms(np.eye(4), 1.0)
    deepest = depth = 0
    for term in terms:
        depth += 1 - term.arity
        deepest = max(deepest, depth)
    assert len(terms) == 127 and deepest == 7
    assert [term.arity for term in Difference(*[Sphere()] * 5).terms(np.eye(4), 1.0)] == [0, 0, 0, 2, 0, 0, 2, 2, 2]


def test_exclusive_has_a_program():
    program = Exclusive(Box(), Sphere(), Torus()).program()
    assert [row["op"] for row in program] == [Op.BOX, Op.SPHERE, Op.EXCLUSIVE, Op.TORUS, Op.EXCLUSIVE]
    assert Exclusive(Box(), Sphere()).volume() is None and Exclusive(Box()).volume() == 1.0
    assert Exclusive(Exclusive(Box(), Sphere()), Torus()) == Exclusive(Box(), Exclusive(Sphere(), Torus()))


class Unproven(Primitive, abstract=True):
    """A ball with the field of one whose bound is only a measured one."""

    exactness = "none"
    certified = False
    lipschitz = 3.0

    def build(self, p, slot):
        return 3.0 * (p.length() - 1.0)

    def support(self, directions):
        return np.linalg.norm(directions, axis=1)


class Slab(Primitive, abstract=True):
    """|z| ≤ 1, without end."""

    bounded = False

    def build(self, p, slot):
        return abs(p.z) - 1.0

    def bounds(self, matrix=None):
        return np.full(3, -np.inf), np.full(3, np.inf)


def test_properties_pass_through_operators():
    moved = Transformed(Unproven(), SHEAR)
    for shape in (Union(Box(), Unproven()), moved, Difference(moved, Box()), Exclusive(Box(), moved)):
        assert not shape.certified and shape.lipschitz == 3.0 and shape.exactness == "none"
    assert Union(Box(), Sphere()).certified and Union(Box(), Sphere()).exactness == BOUND
    assert Transformed(Box(), rotation()).exactness == EXACT and isinstance(moved, Operator)
    assert Intersection(Slab(), Box()).bounded and not Union(Slab(), Box()).bounded
    assert Difference(Box(), Slab()).bounded and not Difference(Slab(), Box()).bounded
    assert not Exclusive(Slab(), Box()).bounded and not Transformed(Slab(), SHEAR).bounded
    assert Union(Box(), Sphere()).exact_outside and not Intersection(Box(), Sphere()).exact_outside
    assert Transformed(Union(Box(), Sphere()), rotation()).exact_outside
    assert not Transformed(Union(Box(), Sphere()), SHEAR).exact_outside


@pytest.mark.parametrize(
    "shape", [*SETS.values(), Transformed(BoxFrame(0.5, 0.3), SHEAR), Box(), Transformed(Torus(), MIRROR)]
)
@pytest.mark.parametrize("level", [-0.05, 0.0, 0.4])
def test_level_bounds_contain_what_is_below_the_level(shape, level):
    shape = guarded(shape)
    low, high = shape.bounds()
    at = np.random.default_rng(9).uniform(low - 2.0, high + 2.0, (200_000, 3))
    below = at[shape.distance(at) <= level]
    assert len(below)
    for matrix in (np.eye(4), SHEAR):
        low, high = level_bounds(shape, level, matrix)
        moved = below @ matrix[:3, :3].T + matrix[:3, 3]
        assert np.isfinite(low).all() and (moved >= low - 1e-12).all() and (moved <= high + 1e-12).all()


def test_a_guarded_shape_is_the_same_set_and_grows():
    shape = Transformed(Ellipsoid((2.0, 0.5, 0.1)), SHEAR)
    at = points(shape)
    field = shape.distance(at)
    clear = np.abs(field) > 1e-12 * (1.0 + np.linalg.norm(at, axis=1))
    np.testing.assert_array_equal((guarded(shape).distance(at) <= 0.0)[clear], (field <= 0.0)[clear])
    slab = Slab()
    assert guarded(Box()) == Box() and guarded(slab) is slab


@pytest.mark.parametrize("make", [lambda: Union(Box(), wide=1.0), lambda: Exclusive(Box(), 2.0)])
def test_what_an_operator_does_not_take_is_refused(make):
    with pytest.raises(ShapeError):
        make()
