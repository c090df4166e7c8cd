# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions with fields of the point, loops, conditions and parameters. ``test_expression`` has their safety."""

import dataclasses
import math
import warnings

import numpy as np
import pytest

from sdf_lights.graph import formula, numpy_evaluation
from sdf_lights.sdf.declarations import USAGE
from sdf_lights.sdf.examples import examples
from sdf_lights.sdf.expression import Declaration, Expression, ExpressionError, evaluate
from sdf_lights.sdf.expression_values import Work, less
from sdf_lights.sdf.functions import FUNCTIONS, MATHEMATICS, POINTS
from sdf_lights.sdf.shapes import SHAPES, Box, Difference, Field, Intersection, Sphere, Torus, Union
from sdf_lights.sdf.shapes.base import Slots
from sdf_lights.sdf.shapes.profiles import PROFILES, Profile

RNG = np.random.default_rng(5)
POINTS_NEAR = RNG.uniform(-1.5, 1.5, (500, 3))
X, Y, Z = POINTS_NEAR.T


def length(*components):
    return np.sqrt(sum(np.square(c) for c in components))


def field(text: str, values=None) -> np.ndarray:
    """Values of an expression that is a field, at ``POINTS_NEAR``; nowhere has it to be a shape."""
    lines = text.rstrip("\n").split("\n")
    shape = Expression("\n".join([*lines[:-1], f"field({lines[-1]}, bounds=1000)"])).shape(values)
    return numpy_evaluation.evaluate(shape.value, POINTS_NEAR, shape.numbers)


@pytest.mark.parametrize(
    "text, expected",
    [
        ("p.x", X),
        ("p.x + 2 * p.y - p.z / 4", X + 2 * Y - Z / 4),
        ("-p.x ** 2", -(X**2)),
        ("p.x % 0.5", X % 0.5),
        ("length(p) - 1", length(X, Y, Z) - 1),
        ("length(p.xz)", length(X, Z)),
        ("length(p.zyx - (1, 2, 3))", length(Z - 1, Y - 2, X - 3)),
        ("length(vec2(length(p.xy) - 1, p.z)) - 0.25", length(length(X, Y) - 1, Z) - 0.25),
        ("dot(p, (1, 2, 3))", X + 2 * Y + 3 * Z),
        ("cross(p, (0, 0, 1)).x", Y),
        ("normalize(p).y", Y / length(X, Y, Z)),
        ("max(abs(p) - (1, 2, 3), 0).z", np.maximum(abs(Z) - 3, 0)),
        ("min(p.x, p.y, p.z)", np.minimum(np.minimum(X, Y), Z)),
        ("mix(p.x, p.y, 0.25)", 0.75 * X + 0.25 * Y),
        ("clamp(p.x, -0.5, 0.5)", np.clip(X, -0.5, 0.5)),
        ("step(0, p.x)", (X >= 0) * 1.0),
        ("sign(p.x)", np.sign(X)),
        ("round(p.x)", np.floor(X + 0.5)),
        ("smoothstep(0, 1, p.x)", np.clip(X, 0, 1) ** 2 * (3 - 2 * np.clip(X, 0, 1))),
        ("vec3(p.xy, 2).z + vec3(1, p.yz).x + vec3(p.x).y + vec2(p.x).y", 3 + 2 * X),
        ("distance(p, (1, 0, 0))", length(X - 1, Y, Z)),
        ("p.x if p.y < 0 else p.z", np.where(Y < 0, X, Z)),
        ("select(p.x >= p.y, 1, 2)", np.where(X >= Y, 1, 2)),
        ("select(p.x > 0 and p.y > 0 or not p.z > 0, p.x, p.y)", np.where((X > 0) & (Y > 0) | ~(Z > 0), X, Y)),
        ("select(p.x > 0, p, 1).y", np.where(X > 0, Y, 1)),
        ("torus(1, 0.25)(p)", Torus(1, 0.25).distance(POINTS_NEAR)),
        ("sphere(1)(p - (1, 0, 0))", length(X - 1, Y, Z) - 1),
        ("distance(sphere(1), p)", length(X, Y, Z) - 1),
        ("circle(0.5)(p.xz)", length(X, Z) - 0.5),
        ("rotate_z(p, 90).x", -Y),
        ("rotate(p, 90, (0, 0, 2)).y", X),
        ("rotate(p.xy, 90).x", -Y),
        ("rotate(p, (90, 0, 0)).z", Y),
        ("rotate_x(p, 90 * p.z).x", X),
        ("repeat(p.x, 0.5)", X - 0.5 * np.floor(2 * X + 0.5)),
        ("repeat(p, (0, 1, 1)).x", X),
        ("fold(p, (2, 0, 0)).x", abs(X)),
        ("fold(p, (1, 0, 0), 0.25).x", np.where(X < 0.25, 0.5 - X, X)),
        ("mirror(p).x", abs(X)),
        ("length(polar(p, 5))", length(X, Y, Z)),
        ("box(1)(sphere(1)(p) * p)", Box(1.0).distance((length(X, Y, Z) - 1)[:, None] * POINTS_NEAR)),
        ("union(sphere(1), torus(1, 0.25))(p)", np.minimum(length(X, Y, Z) - 1, Torus(1, 0.25).distance(POINTS_NEAR))),
    ],
)
def test_fields(text, expected):
    np.testing.assert_allclose(field(text), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    "name",
    [
        name
        for name, word in FUNCTIONS.items()
        for form in (word, word.other)
        if form and form.group in (MATHEMATICS, POINTS) and name not in ("vec2", "vec3")
    ],
)
def test_words_mean_the_same_for_numbers_and_for_fields(name):
    word = FUNCTIONS[name].other or FUNCTIONS[name]
    given = {"value": (0.3, 0.6, 0.9), "scalar": 0.7, "vector": (0.5, 0.2, 0.8), "vector3": (0.8, 0.1, 0.4), "any": 0.4}
    plain, fields = [], []
    for index, argument in enumerate(word.arguments):
        if argument.kind == "condition":
            plain.append(less(0.2, 0.3))
            fields.append(less(formula.POINT.x, 0.3))
            continue
        if argument.kind == "number":
            plain.append(3.0)
            fields.append(3.0)
            continue
        value = np.multiply(given[argument.kind], 1.0 - 0.2 * index)
        plain.append(tuple(value.tolist()) if value.ndim else float(value))
        made = tuple(formula.POINT.x * (c / 0.2) for c in np.atleast_1d(value))
        fields.append(made if value.ndim else made[0])
    expected, found = word(Work(), plain, {}), word(Work(), fields, {})
    for a, b in zip(np.atleast_1d(expected), found if isinstance(found, tuple) else (found,)):
        at_point = numpy_evaluation.evaluate(b, np.array([0.2, 0.0, 0.0])) if isinstance(b, formula.Formula) else b
        assert at_point == pytest.approx(a, rel=1e-12, abs=1e-12)


# -- parameters -------------------------------------------------------------------------------------------------------

SLIDERS = [
    "a = slider(1, 0, 2)\nlength(p) - a",
    "a = slider(1, 0, 2)\nlength(p - (a, 2 * a, sin(a))) - 1",
    "a = slider(1, 0.5, 2)\ntorus(a, 0.2)(p) + a * a",
    "a = slider(1, 0.5, 2)\nb = a\nmax(length(p) - a - b, p.x * a / b)",
    "a = slider(1, 0.5, 2)\nselect(a < 1.5, p.x, p.y) - a",
    "a = slider(1, 0.5, 2)\nselect(a < 1.5 or p.x > 0, p.x, p.y)",
    "a = slider(1, 0.5, 2)\nif a > 1.2:\n  q = p.x\nelse:\n  q = p.y\nq",
    "a = integer(3, 1, 9)\nq = p\nfor i in range(a):\n  q = abs(q) * 2 - 1\nlength(q)",
    "a = integer(3, 1, 9)\ns = 1\nfor i in range(a):\n  s = s * 2\nlength(p) * s",
    "a = toggle(True)\nselect(a, p.x, p.y)",
    "a = integer(3, 1, 9)\ns = 0\nfor i in range(9):\n  s += i\n  if i >= a:\n    break\nlength(p) - s",
    "a = angle(30)\nrotate_z(p, a).x",
    "a = vector((1, 2, 3))\nlength(p - a)",
    "a = slider(1, 0.5, 2)\nrepeat(p, a).x",
    "a = slider(1, 0.5, 2)\nunion(sphere(a), field(length(p) - a))(p * a)",
]


@pytest.mark.parametrize("text", SLIDERS)
def test_the_formula_stays_the_same_as_parameters_move(text):
    lines = text.split("\n")
    lamp = Expression("\n".join([*lines[:-1], f"field({lines[-1]}, bounds=10)"]))
    (about,) = lamp.parameters
    values = [about.minimum, about.maximum, 0.5 * about.minimum + 0.5 * about.maximum, about.default]
    shapes = [lamp.shape({"a": (v, v, v) if about.kind == "vector" and v is not about.default else v}) for v in values]
    assert len({shape.formula() for shape in shapes}) == 1
    assert len({shape.numbers for shape in shapes}) > 1


def test_constants_fold_and_numbers_of_parameters_do_not():
    assert evaluate("length(p) - sqrt(4) * 0.5").value is evaluate("length(p) - 1").value
    assert evaluate("length(p) - 1").numbers == ()
    assert Expression("a = slider(2, 1, 3)\nlength(p) - 2 * a").shape({"a": 3}).numbers == (6.0,)


def test_declarations():
    lamp = Expression(
        "size = slider(1, 0.1, 3)  # how large\ncount = integer(5, 1, 12)\nopen = toggle(True)# whether\n"
        "turn = angle(45)\nplace = vector((0, 0, 1), -2, 2)\nfree = vector(0.5 * (1, 1, 1))\n"
        "sphere(size + count) if open and turn > 40 else translate(sphere(), place + free)"
    )
    assert lamp.parameters == (
        Declaration("size", "slider", 1.0, 0.1, 3.0, "how large"),
        Declaration("count", "integer", 5.0, 1.0, 12.0, ""),
        Declaration("open", "toggle", 1.0, 0.0, 1.0, "whether"),
        Declaration("turn", "angle", 45.0, -360.0, 360.0, ""),
        Declaration("place", "vector", (0.0, 0.0, 1.0), -2.0, 2.0, ""),
        Declaration("free", "vector", (0.5, 0.5, 0.5), -10.0, 10.0, ""),
    )
    assert lamp.shape() == Sphere(6.0)
    assert lamp.shape({"count": 2.6, "size": 9}) == Sphere(6.0)  # whole, and held to the limits
    moved = lamp.shape({"open": False, "place": (9, 0, 0)})
    np.testing.assert_array_equal(np.array(moved.matrix)[:3, 3], (2.5, 0.5, 0.5))
    for name, bad in (("place", 1.0), ("place", (1, 2)), ("open", "yes"), ("place", (1, 2, math.nan))):
        with pytest.raises(ExpressionError, match=f"the value given for {name}"):
            lamp.shape({name: bad})


# -- shapes and fields ------------------------------------------------------------------------------------------------


def test_fields_become_shapes_where_shapes_are_wanted():
    ball = evaluate("length(p) - 1")
    assert isinstance(ball, Field) and not ball.children and ball.validate() == ""
    assert ball == evaluate("field(length(p) - 1)") and hash(ball) == hash(evaluate("length(p) - 1"))
    assert evaluate("union(length(p) - 1, box(1))") == Union(ball, Box(1.0))
    assert evaluate("box(1) | length(p) - 1") == Union(Box(1.0), ball)
    assert evaluate("box(1) - (length(p) - 1)") == Difference(Box(1.0), ball)
    assert evaluate("(length(p) - 1) & box(1)") == Intersection(ball, Box(1.0))
    half = evaluate("(length(p) - 1) & p.z")
    assert isinstance(half, Intersection) and half.bounded and not half.children[1].bounded
    moved = evaluate("translate(rotate(scale(length(p) - 1, 2), 30), 1, 2, 3)")
    np.testing.assert_allclose(moved.distance(POINTS_NEAR), 2 * (length(X - 1, Y - 2, Z - 3) / 2 - 1), atol=1e-12)


def test_a_field_that_is_cut():
    shape = evaluate("field(p.z - 0.5, bounds=(1, 2, 3))")
    inside = (Z < 0.5) & (abs(X) < 1) & (abs(Y) < 2) & (abs(Z) < 3)
    np.testing.assert_array_equal(shape.distance(POINTS_NEAR) < 0, inside)
    np.testing.assert_array_equal(shape.bounds(), [(-1, -2, -3), (1, 2, 3)])
    with pytest.raises(ExpressionError, match="half size is 0"):
        evaluate("field(p.z, bounds=(1, 0, 1))")


@pytest.mark.parametrize(
    "text",
    [
        "length(p) - 1",
        "length(p - (300, 0, 0)) - 100",
        "length(p - (0.5, 3, 0)) - 0.001",
        "abs(length(p) - 1) - 0.01",
        "max(abs(p.x), abs(p.y), abs(p.z)) - 1",
        "torus(1, 0.3)(rotate_z(p, 90 * p.z))",
        "p.x ** 4 + p.y ** 4 + p.z ** 4 - p.x ** 2 - p.y ** 2 - p.z ** 2 + 0.1",
        "(length(p) - 1) * (length(p - 3) - 1)",
        "length(p) - 1 + 0.2 * sin(10 * p.x) * sin(10 * p.y) * sin(10 * p.z)",
        "sphere(0.2)(polar(p, 6) - (1, 0, 0))",
        "0.5 - exp(-dot(p, p))",
        "log(length(p))",
        "sqrt(length(p) - 0.5) - 0.5",
        "max(length(p) - 1, 1 / (p.x * p.x + 1) - 0.9)",
        "d = 1000\nfor i in range(6):\n  d = min(d, length(p - (i, 0, 0)) - 0.3)\nd",
        "length(p) - 1 + 0.2 * noise(3 * p)",
    ],
)
def test_limits_of_fields(text):
    shape = evaluate(text)
    low, high = shape.bounds()
    assert shape.bounded and (low < high).all()
    around = np.random.default_rng(3).uniform(1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low, (40_000, 3))
    around[:20_000] = np.random.default_rng(4).uniform(-12, 12, (20_000, 3))
    inside = around[shape.distance(around) <= 0.0]
    assert ((inside >= low) & (inside <= high)).all()
    # Not much larger than it has to be: the farthest points of a dense sample reach most of the way on every side.
    dense = np.random.default_rng(5).uniform(low, high, (60_000, 3))
    found = dense[shape.distance(dense) <= 0.0]
    assert len(found) and (np.ptp(found, axis=0) > 0.5 * (high - low)).all()
    matrix = np.array([(0, 2, 0, 5), (-2, 0, 0, 0), (0, 0, 2, 0), (0, 0, 0, 1.0)])
    np.testing.assert_allclose(
        shape.bounds(matrix), [(2 * low[1] + 5, -2 * high[0], 2 * low[2]), (2 * high[1] + 5, -2 * low[0], 2 * high[2])]
    )


@pytest.mark.parametrize(
    "text",
    [
        "p.x",
        "sin(p.x) * sin(p.y) * sin(p.z)",
        "abs(p.z) - 0.1",
        "1 - length(p)",
        "sphere(0.2)(repeat(p, 1))",
        "sphere(0.2)(repeat(p, 30))",
        "length(p.xy) - 1",
        "union(length(p) - 1, p.x)",
        "half_space()",
    ],
)
def test_fields_without_limits_are_refused(text):
    with pytest.raises(ExpressionError, match="no limits.*intersect it with box"):
        evaluate(text)
    assert evaluate(f"({text}) & box(2)").bounded


@pytest.mark.parametrize(
    "amount, field, bound",
    [
        ("0.1 * sin(9 * p.x)", 0.1 * np.sin(9 * X), True),
        ("clamp(p.z, -0.1, 0.1)", np.clip(Z, -0.1, 0.1), True),
        ("0.1", 0.1, True),
        ("a", 0.1, True),
        ("p.z / 9", Z / 9, False),
        ("0.2 * noise(p)", None, False),
    ],
)
def test_displacement_by_a_field(amount, field, bound):
    shape = evaluate(f"a = slider(0.1, 0, 1)\ndisplace(sphere(1) | box(0.9), {amount})")
    assert (shape.exactness == "bound") == bound and shape.lipschitz == (1.0 if bound else math.inf)
    if field is None:
        return
    expected = np.minimum(length(X, Y, Z) - 1, Box(0.9).distance(POINTS_NEAR)) - field
    # The field is scaled, so that it stays a bound.
    np.testing.assert_array_equal(shape.distance(POINTS_NEAR) < 0, expected < 0)
    low, high = shape.bounds()
    inside = POINTS_NEAR[expected < 0]
    assert ((inside >= low) & (inside <= high)).all()
    if bound:
        differences = np.abs(np.diff(shape.distance(POINTS_NEAR)))
        assert (differences <= length(*np.diff(POINTS_NEAR, axis=0).T) * (1 + 1e-12)).all()


def test_fields_that_are_positive_everywhere_are_refused():
    with pytest.raises(ExpressionError, match="positive everywhere"):
        evaluate("length(p) + 1")


def test_fields_within_fields():
    """A field that is moved, cut and read again at another point, with a loop in it that stands in another loop."""
    text = (
        "a = slider(2, 1, 3)\nq = p\nfor i in range(3):\n  q = abs(q) - 1 / a\n"
        "inner = field(length(q) - a, bounds=9)\nd = 10\n"
        "for j in range(4):\n  d = min(d, inner(p * a - (j, 0, 0)) + 0.1 * j)\nd"
    )
    expected = np.full(500, 10.0)
    for j in range(4):
        at = POINTS_NEAR * 2 - (j, 0, 0)
        q = at
        for _ in range(3):
            q = abs(q) - 0.5
        expected = np.minimum(expected, np.maximum(length(*q.T) - 2, Box(9.0).distance(at)) + 0.1 * j)
    np.testing.assert_allclose(field(text), expected, rtol=1e-12, atol=1e-12)


# -- loops and conditions ---------------------------------------------------------------------------------------------


def test_loops_of_fields_are_loops_of_the_formula():
    text = "for i in range({}):\n  p = fold(abs(p), (1, -1, 0)) * 1.1 - 0.1\nfield(length(p), bounds=1)"
    short, long = evaluate(text.format(3)), evaluate(text.format(300))
    assert len(formula.order(short.value)) == len(formula.order(long.value))
    q = POINTS_NEAR
    for _ in range(3):
        q = abs(q)
        q = q + np.minimum(q[:, :1] - q[:, 1:2], 0) * (-1, 1, 0)
        q = q * 1.1 - 0.1
    np.testing.assert_allclose(numpy_evaluation.evaluate(short.value, POINTS_NEAR), length(*q.T), rtol=1e-12)


@pytest.mark.parametrize("count, expected", [(0, X), (1, X), (4, X + 0 + 1 + 2 + 3)])
def test_index_of_loops(count, expected):
    np.testing.assert_allclose(field(f"d = p.x\nfor i in range({count}):\n  d = d + i\nd"), expected, atol=1e-12)
    text = f"n = integer({count}, 0, 9)\nd = p.x\nfor i in range(n):\n  d += i\nd"
    np.testing.assert_allclose(field(text), expected, atol=1e-12)


@pytest.mark.parametrize("before", ["", "  d = d + 0.25\n"])
def test_break_ends_a_loop_where_its_condition_holds(before):
    text = (
        f"d = abs(p.x)\nn = 0\nfor i in range(20):\n{before}  if d > 2:\n    n = 100\n    break\n"
        "  d = d * 1.5\n  n += 1\nd + n"
    )
    expected = []
    for x in abs(X):
        d, n = x, 0
        for _ in range(20):
            d = d + 0.25 if before else d
            if d > 2:
                n = 100
                break
            d, n = d * 1.5, n + 1
        expected.append(d + n)
    np.testing.assert_allclose(field(text), expected, rtol=1e-12)


def test_loops_inside_loops():
    text = "d = p.x\nfor i in range(3):\n  e = p.y\n  for j in range(4):\n    e = e * 0.5 + i * j + d\n  d = d + e\nd"
    expected = X
    for i in range(3):
        e = Y
        for j in range(4):
            e = e * 0.5 + i * j + expected
        expected = expected + e
    np.testing.assert_allclose(field(text), expected, rtol=1e-12)


def test_loops_put_shapes_together():
    assert evaluate("s = sphere(1)\nfor i in range(3):\n  s = s | box(i + 1)\ns") == Union(
        Sphere(1.0), Box(1.0), Box(2.0), Box(3.0)
    )
    assert evaluate("n = 0\nfor i in range(5):\n  n += i\nsphere(n)") == Sphere(10.0)
    # The radius of a shape has to be a number, so these rounds are written one after another.
    rings = field("d = 9\nfor i in range(3):\n  for j in range(2):\n    d = min(d, torus(1 + i, 0.1 + 0.1 * j)(p))\nd")
    np.testing.assert_allclose(
        rings,
        np.min([Torus(1.0 + i, 0.1 + 0.1 * j).distance(POINTS_NEAR) for i in range(3) for j in range(2)], axis=0),
        atol=1e-12,
    )


def test_conditions_choose_values_of_names():
    text = "a = p.y\nif p.x > 0.5:\n  a = p.x\n  b = 1\nelif p.x > 0:\n  a = p.z\na"
    np.testing.assert_allclose(field(text), np.where(X > 0.5, X, np.where(X > 0, Z, Y)))
    lamp = Expression("open = toggle(True)\nif open:\n  s = sphere(1)\nelse:\n  s = box(1)\ns")
    assert lamp.shape() == Sphere(1.0) and lamp.shape({"open": False}) == Box(1.0)
    assert evaluate("if 1 < 2 and not 2 < 1:\n  s = sphere(1)\nelse:\n  s = sphere(sqrt(-1))\ns") == Sphere(1.0)


# text, line, column, words of the message, words of the cure
MISTAKES = [
    ("p", 1, 1, "the last line is a vector", "negative inside"),
    ("sphere(1) + sin(p.x)", 1, 1, "between a shape and a field", "shape(p)"),
    ("sphere(p.x)", 1, 1, "radius of sphere differs from point to point", "with p yourself"),
    ("box((1, p.x, 1))", 1, 1, "differs from point to point", "number"),
    ("rotate(sphere(1), p.x)", 1, 1, "rotates as a whole", "rotate the point"),
    ("select(p.x > 0, sphere(1), box(1))", 1, 1, "cannot choose between shapes", "their fields"),
    ("p.x > 0", 1, 1, "the last line is a condition", "shape"),
    ("length(p) > 1 > 0", 1, 1, "comparison is not part", "and"),
    ("p > 1", 1, 1, "a vector cannot be compared", "numbers"),
    ("p.x == 1", 1, 1, "comparison is not part", "<="),
    ("p.x != 1", 1, 5, "means nothing", "not"),
    ("select(p.x > 0, p.y > 0, 1)", 1, 1, "one side is a condition, the other a number", "one kind"),
    ("select(1, 2, 3)", 1, 1, "must be a condition", "select("),
    ("if p.x:\n  a = 1\nsphere(1)", 1, 4, "not a condition", "compare"),
    ("p.xy + p", 1, 1, "vectors of two and of three", "p.xy or p"),
    ("dot(p.xy, p)", 1, 1, "vectors of two", "one kind"),
    ("p.xyxy", 1, 1, "not part of a vector", ".xy"),
    ("p.xy.z", 1, 1, "not part of a vector", ".xy"),
    ("sphere(1)(p, p)", 1, 1, "one point", "shape(p)"),
    ("sphere(1)(p.xy)", 1, 1, "in space", "three"),
    ("circle(1)(p)", 1, 1, "in the plane", "two components"),
    ("extrusion(sphere(1))", 1, 1, "must be a profile", "extrusion"),
    ("circle(1)", 1, 1, "the last line is a profile", "shape"),
    ("field(1)", 1, 1, "the same at all points", "length(p)"),
    ("for i in p:\n  a = 1\nsphere(1)", 1, 10, "runs over a range", "range(count)"),
    ("for i in range(1, 2):\n  a = 1\nsphere(1)", 1, 10, "runs over a range", "range(count)"),
    ("for i in range(2.5):\n  a = 1\nsphere(1)", 1, 16, "2.5 is not a whole number", "whole"),
    ("for i in range(10 ** 9):\n  a = 1\nsphere(1)", 1, 16, "1e+09 rounds is too long", "1000"),
    ("for i in range(p.x):\n  a = 1\nsphere(1)", 1, 16, "the number of rounds is a field", "whole"),
    ("n = integer(3, 1, 5)\nfor i in range(2 * n):\n  a = 1\nsphere(1)", 2, 16, "no greatest value", "integer("),
    ("for i in range(3):\n  a = i\nsphere(a)", 3, 8, "a is not a known name", "above"),
    ("for i in range(3):\nsphere(1)", 2, 1, "expected an indented block", "missing"),
    ("for i in range(3):\n  a = 1\nelse:\n  a = 2\nsphere(1)", 4, 3, "no else", "leave"),
    ("a = p.x\nfor i in range(3):\n  a = p\nfield(a)", 2, 1, "a is a field before the loop, and a vector", "one kind"),
    ("break", 1, 1, "break is not allowed", "loop"),
    ("for i in range(3):\n  break\nsphere(1)", 2, 3, "not allowed", "if"),
    ("while 1:\n  a = 1", 1, 1, "while is not part", "name = value"),
    ("def f(x):\n  return x", 1, 1, "def is not part", "name"),
    ("(lambda: 1)", 1, 2, "lambda is not part", "name"),
    ("p[0]", 1, 2, "means nothing", "( )"),
    ("for i in range(3):\n  a = slider(1, 0, 2)\nsphere(1)", 2, 7, "cannot be declared in a block", "top"),
    ("a = toggle(1)\nsphere(1)", 1, 5, "True or False", "toggle(True)"),
    ("a = integer(1.5, 0, 3)\nsphere(a)", 1, 5, "whole numbers", "integer("),
    ("a = vector((1, 2))\nsphere(1)", 1, 5, "takes a vector", "vector(("),
    ("a = vector((1, 2, 30))\nsphere(1)", 1, 5, "the default 30 is not between -10 and 10", "vector(("),
    (f"{'a' * 41} = slider(1, 0, 2)\nsphere(1)", 1, 45, "too long", "40"),
    ("prism(5.5)", 1, 1, "must be a whole number", "change"),
    ("|".join(f"(length(p) - {i + 1})" for i in range(17)), 1, 1, "too many parts that are fields", "min and max"),
    ("s = sphere()\nunion(" + ", ".join("s" * 2001) + ")", 2, 1, "too many parts", "2000"),
    ("s = sphere()\nfor i in range(101):\n  s = difference(box(), s)\ns", 3, 7, "too many parts", "100 combinations"),
    ("sphere(1)" + " " * 10_000, 1, 1, "10009 characters", "10000"),
    ("for i in range(900):\n  for j in range(900):\n    p = p * 2\nlength(p) - 1", 3, 9, "many operations", "fewer"),
    ("n = 0\nfor i in range(900):\n  for j in range(900):\n    n = n + 1\nsphere(n)", 4, 9, "too many steps", "fewer"),
]


@pytest.mark.parametrize("text, line, column, message, cure", MISTAKES)
def test_mistakes_are_located_and_explained(text, line, column, message, cure):
    with pytest.raises(ExpressionError) as caught:
        evaluate(text)
    error = caught.value
    assert message in error.message and cure in error.cure, str(error)
    assert (error.line, error.column) == (line, column), str(error)


def test_python_gives_no_hints_of_its_own():
    """Its parser has warnings for those who write Python."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        evaluate("field(length(p) - (1if p.x > 0 else 2)) & box(3)")
    assert not told


# -- words and examples -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*SHAPES, *PROFILES])
def test_every_shape_and_operator_is_a_word(name):
    """With its defaults, and with every number given by position and by name."""
    shape = SHAPES.get(name) or PROFILES[name]
    parts = {"shape": "sphere(0.6)", "profile": "circle(0.3)"}
    given = [parts[f.metadata["part"]] for f in dataclasses.fields(shape) if "part" in f.metadata]
    if any(f.name == "children" for f in dataclasses.fields(shape)):
        given = ["sphere(0.6)", "box(0.5)", "torus(0.6, 0.2)"]
    if name == "polygon":
        given = ["(0, 0)", "(1, 0)", "(0, 1)"]
    numbers = []
    for about in shape.fields():
        value = np.degrees(about.default) if about.unit == "ANGLE" else about.default
        numbers.append((about.name, repr(tuple(map(float, value)) if about.size == 3 else float(value))))
    text = "extrusion({})" if issubclass(shape, Profile) else "({}) & box(9)"
    plain, by_position, by_name = (
        evaluate(text.format(f"{name}({', '.join([*given, *more])})"))
        for more in ([], [value for _, value in numbers], [f"{key}={value}" for key, value in numbers])
    )
    assert by_name == by_position
    np.testing.assert_allclose(by_name.distance(POINTS_NEAR), plain.distance(POINTS_NEAR), rtol=1e-9, atol=1e-9)


def test_angles_of_shapes_are_degrees():
    assert evaluate("solid_angle(1, 60)").angle == pytest.approx(math.pi / 3)


@pytest.mark.parametrize("name", examples())
def test_examples(name):
    example = examples()[name]
    lamp = Expression(example.text)
    assert example.text.startswith(f"# {example.title}\n") and example.text.endswith("\n") and lamp.parameters
    shape = lamp.shape()
    assert shape.validate() == "" and shape.bounded
    low, high = shape.bounds()
    points = np.random.default_rng(2).uniform(low, high, (4_000, 3))
    inside = (shape.distance(points) < 0).mean()
    assert 0.001 < inside < 0.999 and np.isfinite(shape.distance(points)).all()
    for about in lamp.parameters:  # every slider from end to end, and it does something
        ends = [(v, v, v) if about.kind == "vector" else v for v in (about.minimum, about.maximum)]
        moved = [lamp.shape({about.name: end}) for end in ends]
        assert all(other.validate() == "" for other in moved)
        few = points[:1000]
        assert any((other.distance(few) != shape.distance(few)).any() for other in moved), about.name
        if about.kind in ("slider", "angle", "vector"):
            assert all(other.formula() is shape.formula() for other in moved), about.name


def test_there_is_an_example_of_every_kind_of_thing():
    texts = [example.text for example in examples().values()]
    assert len(texts) >= 16
    features = [
        *USAGE,
        "for ",
        "if ",
        "field(",
        "p.",
        " & ",
        " | ",
        "noise_displacement(",
        "repeat(",
        "polar(",
        "polygon(",
        "extrusion(",
        "smooth_union(",
        "polar_repetition(",
        "displace(",
    ]
    for feature in features:
        assert any(feature in text for text in texts), feature


def test_slots_are_those_that_are_used():
    """What one line needs is not carried by another."""
    text = "a = slider(1, 0, 2)\nb = slider(2, 0, 3)\nunion(length(p) - a, length(p - 1) - b)"
    one, other = evaluate(text).children
    assert one.numbers == (1.0,) and other.numbers == (2.0,)
    assert formula.slots(one.formula()) == formula.slots(other.formula()) == 1


def test_a_field_in_a_formula_is_the_formula():
    """Built at the point, with its own numbers as slots, a field is what was written."""
    shape = evaluate("a = slider(1, 0, 2)\nlength(p) - a")
    slots = Slots()
    assert shape.build(formula.POINT, slots) is shape.formula() is shape.value and slots.values == [1.0]
    (term,) = shape.terms(np.eye(4), 0.5)
    np.testing.assert_allclose(
        numpy_evaluation.evaluate(term.formula, POINTS_NEAR, term.parameters),
        0.5 * (length(X, Y, Z) - 1),
        rtol=1e-12,
        atol=1e-12,
    )
