# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Words of data, without Blender: texts in quotes, what a resolver is asked, and what is said where it knows
nothing."""

import numpy as np
import pytest

from sdf_lights.graph import tables
from sdf_lights.sdf.data.tube import Tube
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.expression import Expression, ExpressionError, evaluate
from sdf_lights.sdf.resolver import Arrays, Cache, PlaceholderResolver, Request
from sdf_lights.sdf.shapes import Box, Sphere


def _square(size: int = 32) -> np.ndarray:
    pixels = np.zeros((size, size, 4), np.float32)
    pixels[size // 4 : -size // 4, size // 4 : -size // 4] = 1.0
    return pixels


def _cube() -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([(x, y, z) for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (-0.4, 0.4)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))])


@pytest.fixture
def arrays() -> Arrays:
    return Arrays({"Logo": _square(), "a # 'b' \\": _square()}, {"Cube": _cube()}, {"Ball": Sphere(0.5)})


class _Asked:
    """A resolver that notes what it is asked."""

    def __init__(self):
        self.requests: list[Request] = []

    def find(self, request):
        self.requests.append(request)
        return Box()


@pytest.mark.parametrize(
    "written, said",
    [
        ('"OPEN"', "OPEN"),
        ("'OPEN'", "OPEN"),
        ('"it\'s # (all [one] text;"', "it's # (all [one] text;"),
        ('"灯 ✓ é"', "灯 ✓ é"),
        (r'"two\nlines"', "two\nlines"),
        (r'"a \"b\" \\ \x41\u00e9"', 'a "b" \\ Aé'),
        ('""', ""),
        ('"for if lambda import"', "for if lambda import"),
    ],
)
def test_a_text_in_quotes_says_what_stands_there(written, said):
    asked = _Asked()
    Expression(f"a = 1\n\n  text({written}, 2)  # a 'remark").shape(resolver=asked)
    (request,) = asked.requests
    assert (request.kind, request.name, request.get("size")) == ("text", said, 2.0)


@pytest.mark.parametrize(
    "text, line, column, problem, cure",
    [
        ('box(1)\ntext("OPEN', 2, 6, "has no end", 'write " after it'),
        ("text('a\nb')", 1, 6, "has no end", "write ' after it"),
        ('text("a" "b")', 1, 6, "two texts", "comma"),
        ('text("a""b")', 1, 9, "right after", "comma"),
        ('f"{p}"', 1, 2, "right after", "comma"),
        ('"""a"""', 1, 3, "right after", "comma"),
        (r'image("C:\logo.png")', 1, 10, r"\l means nothing", r"write \\ for one \, or /"),
        ('sphere("a")', 1, 1, "must be a number, not a text", "write sphere"),
        ("object(1)", 1, 1, "must be a text in quotes, not a number", "write object"),
        ('"a" + 1', 1, 1, "between a text and a number", ""),
        ('"a" < "b"', 1, 1, "a text cannot be compared", ""),
        ('"a"', 1, 1, "the last line is a text", "shape"),
        ('x = slider("a", 0, 1)\nbox(x)', 1, 5, "takes three numbers", ""),
        ('select(p.x > 0, "a", "b")', 1, 1, "cannot choose between texts", ""),
        ('image("Logo", part="red")', 1, 1, "part of image is 'red'", "'opaque', 'bright' or 'dark'"),
        ('text("a", thickness=-1)', 1, 1, "thickness of text is -1", "from 1e-06"),
    ],
)
def test_mistakes_with_texts_are_located_and_explained(text, line, column, problem, cure):
    with pytest.raises(ExpressionError) as caught:
        Expression(text)
    error = caught.value
    assert (error.line, error.column) == (line, column)
    assert problem in error.message and cure in error.cure


def test_columns_after_a_text_are_those_of_the_line():
    with pytest.raises(ExpressionError) as caught:
        Expression('text("é灯 (") | spere(1)')
    assert (caught.value.line, caught.value.column) == (1, 16)


def test_what_is_not_known_is_said_with_the_nearest_name(arrays):
    for text, message in (
        ('object("Bal")', "there is no object 'Bal': did you mean 'Ball'?"),
        ('image("logo")', "there is no image 'logo': did you mean 'Logo'?"),
        ('mesh("x")', "there is no mesh 'x': make one, or write the name of another, such as 'Cube'."),
        ('text("a")', "a text needs Blender's fonts: open the lamp in Blender, or use image or mesh."),
    ):
        with pytest.raises(ExpressionError) as caught:
            evaluate(text, resolver=arrays)
        assert str(caught.value).endswith(message)
    with pytest.raises(ExpressionError, match="needs a resolver"):
        evaluate('object("Ball")')


def test_data_work_wherever_a_shape_does(arrays):
    points = np.random.default_rng(1).uniform(-0.8, 0.8, (500, 3))
    ball, cube = Sphere(0.5), arrays.find(Request("mesh", "Cube", (("voxel_size", 0.0),)))
    for text, expected in (
        ('object("Ball") | mesh("Cube")', np.minimum(ball.distance(points), cube.distance(points))),
        ('translate(object("Ball"), (0.1, 0, 0))', ball.distance(points - (0.1, 0.0, 0.0))),
        ('object("Ball")(p) + 0.05', ball.distance(points) + 0.05),
        ('n = "Ball"\nobject(n) - mesh("Cube")', np.maximum(ball.distance(points), -cube.distance(points))),
        ('on = toggle(False)\nobject("Nothing" if on else "Ball")', ball.distance(points)),
    ):
        np.testing.assert_allclose(evaluate(text, resolver=arrays).distance(points), expected, atol=1e-9)
    picture = evaluate('image("Logo", width=2, thickness=0.5)', resolver=arrays)
    np.testing.assert_allclose(picture.bounds(), [[-0.5, -0.5, -0.25], [0.5, 0.5, 0.25]], atol=1e-6)
    assert evaluate(r'image("a # \'b\' \\", part="bright")', resolver=arrays).volume() > 0.0


def test_a_field_of_data_keeps_its_tables():
    """An emission and a field hold addresses; the memory there must not be used for something else."""
    rod = Tube.of([(np.array([[0.0, 0.0, -0.4], [0.0, 0.0, 0.4]]), 0.123, False)])
    resolver = Arrays(shapes={"Rod": rod})
    shape = Expression('object("Rod")(p) - 0.01').shape(resolver=resolver)
    placed = EmissionExpression('exp(-9 * abs(object("Rod")(p)))').emission(resolver=resolver).placed(Sphere(0.5))
    assert placed.tables == (rod.data,) and tables.tables_among(shape.numbers) == (rod.data,)
    points = np.random.default_rng(2).uniform(-0.3, 0.3, (50, 3))
    np.testing.assert_allclose(shape.distance(points), rod.distance(points) - 0.01)
    np.testing.assert_allclose(placed.evaluate(points)[:, 0], np.exp(-9.0 * np.abs(rod.distance(points))))


def test_an_expression_is_checked_before_its_data_are_there():
    expression = Expression('size = slider(1, 0, 2)\nobject("Later")(p / size) + 3')
    assert [parameter.name for parameter in expression.parameters] == ["size"]
    assert expression.data == {("object", "Later")}
    assert Expression("sphere(1)").data == frozenset()


def test_results_are_made_anew_when_the_data_change(arrays):
    cache, made = Cache(2), []
    expression = Expression('object("Ball")')

    def ask(key="key"):
        def make(resolver):
            made.append(key)
            return expression.shape(resolver=resolver)

        return cache.get(key, arrays, make)

    assert ask() is ask() and made == ["key"]
    arrays.shapes["Ball"] = Sphere(0.2)
    assert ask() == Sphere(0.2) and made == ["key"] * 2
    del arrays.shapes["Ball"]
    with pytest.raises(ExpressionError):
        ask()
    assert PlaceholderResolver().find(Request("object", "any")) == Box()
