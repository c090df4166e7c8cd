# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions of emissions: what they say at points of shapes, their colours, and what they refuse."""

import numpy as np
import pytest

from sdf_lights.graph import codegen_native
from sdf_lights.sdf.emission import EmissionExpression, ExpressionError
from sdf_lights.sdf.emission_presets import presets
from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.shapes import Box, Sphere, Torus, Transformed, Union

RNG = np.random.default_rng(3)
POINTS = RNG.uniform(-0.5, 0.5, (400, 3))
SPHERE = Sphere(0.5)
INSIDE = POINTS[SPHERE.distance(POINTS) < 0.0]


def colours(text, points=INSIDE, shape=SPHERE, values=None):
    return EmissionExpression(text).emission(values).placed(shape).evaluate(points)


def test_depth_and_height():
    moved = np.eye(4)
    moved[:3, 3] = 1.0, 2.0, 3.0
    found = colours("(depth, height, p.x)", INSIDE + moved[:3, 3], Transformed(SPHERE, moved))
    assert np.allclose(found[:, 0], 0.5 - np.linalg.norm(INSIDE, axis=1), atol=1e-12)
    assert np.allclose(found[:, 1], INSIDE[:, 2] + 0.5, atol=1e-12)
    assert np.allclose(found[:, 2], np.maximum(INSIDE[:, 0] + 1.0, 0.0))


def test_one_number_is_grey():
    assert np.array_equal(colours("p.x + 1"), np.repeat(INSIDE[:, :1] + 1.0, 3, axis=1))


@pytest.mark.parametrize(
    "text, varies",
    [
        ("2", False),
        ("(1, 0.5, 0)", False),
        ("t = slider(2000, 800, 9000)\nblackbody(t)", False),
        ("depth", True),
        ("height", True),
        ("p.x", True),
        ("s = slider(1, 0, 2)\nlength(p) * s", True),
        ("0 * depth + 1", False),
    ],
)
def test_whether_it_varies(text, varies):
    assert EmissionExpression(text).emission().varies is varies


@pytest.mark.parametrize("text", ["p.x", "sqrt(p.x)", "log(p.x + 0.1) + 1", "1 / max(p.x, 0)", "-1 / max(p.x, 0)"])
def test_dark_where_negative_or_undefined(text):
    """In every reading; the formula as written keeps what is wrong, to be reported."""
    placed = EmissionExpression(text).emission().placed(SPHERE)
    x = INSIDE[:, 0]
    with np.errstate(all="ignore"):
        expected = {
            "p.x": x,
            "sqrt(p.x)": np.sqrt(x),
            "log(p.x + 0.1) + 1": np.log(x + 0.1) + 1.0,
            "1 / max(p.x, 0)": 1.0 / np.maximum(x, 0.0),
            "-1 / max(p.x, 0)": -1.0 / np.maximum(x, 0.0),
        }[text]
        assert np.any(~(expected >= 0.0) | (expected == np.inf))
        expected = np.where((expected > 0.0) & (expected < np.inf), expected, 0.0)
    assert np.allclose(placed.evaluate(INSIDE)[:, 1], expected, rtol=1e-12)
    assert np.allclose(codegen_native.evaluate(placed.colour[1], INSIDE, placed.parameters), expected, rtol=1e-12)


def test_parameters_are_slots():
    expression = EmissionExpression("a = slider(1, 0, 4)  # how much\nt = angle(90)\na * depth * sin(radians(t))")
    assert [(p.name, p.default, p.description) for p in expression.parameters] == [
        ("a", 1.0, "how much"),
        ("t", 90.0, ""),
    ]
    one, other = expression.emission(), expression.emission({"a": 3.0, "t": 30.0})
    assert one.colour == other.colour and one.numbers != other.numbers
    assert np.allclose(other.placed(SPHERE).evaluate(INSIDE), 1.5 * one.placed(SPHERE).evaluate(INSIDE))
    assert one == expression.emission() and hash(one) == hash(expression.emission())


def test_a_shape_of_other_numbers_has_the_same_formulas():
    emission = EmissionExpression("exp(-depth / 0.1) * height").emission()
    assert emission.placed(Torus(1.0, 0.2)).colour == emission.placed(Torus(2.0, 0.3)).colour


@pytest.mark.parametrize(
    "text, at",
    [
        ("ramp(p.x, -0.2, 0, 0.2, 1)", lambda x: np.interp(x, [-0.2, 0.2], [0, 1])),
        ("ramp(p.x, -0.3, 1, 0, 0.25, 0.1, 4)", lambda x: np.interp(x, [-0.3, 0, 0.1], [1, 0.25, 4])),
        ("ramp_constant(p.x, -0.3, 1, 0, 0.25, 0.1, 4)", lambda x: np.where(x < 0, 1, np.where(x < 0.1, 0.25, 4))),
        ("ramp_ease(p.x, -0.2, 0, 0.2, 1)", lambda x: (t := np.interp(x, [-0.2, 0.2], [0, 1])) * t * (3 - 2 * t)),
        ("s = slider(0.2, 0, 1)\nramp(p.x, 0, 0, s, 2)", lambda x: np.interp(x, [0, 0.2], [0, 2])),
    ],
)
def test_ramps(text, at):
    assert np.allclose(colours(text)[:, 0], at(INSIDE[:, 0]), atol=1e-9)


def test_ramps_of_colours():
    found = colours("ramp(height, 0, (1, 0, 0), 0.5, 1, 1, (0, 0, 2))")
    h = INSIDE[:, 2] + 0.5
    assert np.allclose(
        found, np.stack([np.interp(h, [0, 0.5, 1], stops) for stops in ((1, 1, 0), (0, 1, 0), (0, 1, 2))], axis=1)
    )


def test_blackbody():
    """Chromaticities of Planck's spectrum, CIE 1931 2° observer, as tables give them; luminance 1."""
    table = {
        2000: (0.5267, 0.4133),
        2856: (0.4476, 0.4074),
        4000: (0.3805, 0.3768),
        6500: (0.3135, 0.3237),
        10000: (0.2807, 0.2884),
    }
    to_xyz = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
    )
    for temperature, (x, y) in table.items():
        xyz = to_xyz @ colours(f"blackbody({temperature})")[0]
        assert xyz[1] == pytest.approx(1.0, abs=1e-3)
        assert xyz[:2] / xyz.sum() == pytest.approx((x, y), abs=6e-4)
    assert np.array_equal(colours("blackbody(100)"), colours("blackbody(800)"))
    assert np.array_equal(colours("blackbody(1e5)"), colours("blackbody(12000)"))
    assert np.all(colours("blackbody(20000 * p.x)") >= 0.0)


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "empty"),
        ("sphere(1)", "is a shape"),
        ("(1, 2)", "is a vector"),
        ("1 < 2", "is a condition"),
        ("x = 3", "does not say"),
        ("depth & sphere(1)", "depth or the height"),
        ("sphere(depth)(p)", "must be a number"),
        ("sqrt(-1)", "undefined"),
        ("ramp(p.x, 0)", "position and a colour"),
        ("ramp(p.x)", "position and a colour"),
        ("ramp(p.x, 1, 0, 0, 1)", "not in order"),
        ("ramp(p, 0, 1)", "are numbers"),
        ("ramp(p.x, 0, (1, 2), 1, (1, 2, 3))", "cannot be combined"),
        ("displace(sphere(1), height)(p)", "depth or the height"),
        ("ramp(p.x, " + ", ".join(f"{i}, {i}" for i in range(40)) + ")", "too many stops"),
    ],
)
def test_refusals(text, message):
    with pytest.raises(ExpressionError, match=message):
        EmissionExpression(text)


def test_depth_is_no_word_of_shapes():
    with pytest.raises(ExpressionError, match="depth is not a known name"):
        Expression("depth - 0.1")


@pytest.mark.parametrize("name", presets())
def test_presets(name):
    """Bright somewhere in a lamp of ordinary size, dark or undefined nowhere that matters, compiled as interpreted."""
    emission = EmissionExpression(presets()[name].text).emission()
    for shape in (SPHERE, Union(Box(0.4), Torus(0.6, 0.1))):
        placed = emission.placed(shape)
        found = placed.evaluate(INSIDE)
        assert np.isfinite(found).all() and found.mean() > 0.01
        code = codegen_native.compiled(*placed.colour)
        points = np.ascontiguousarray(INSIDE[: len(INSIDE) // 8 * 8].T)
        values = np.empty_like(points)
        codegen_native._SIGNATURE(code.address)(
            points.shape[1], points.ctypes.data, placed.parameters.ctypes.data, values.ctypes.data
        )
        assert np.allclose(values.T, found[: points.shape[1]], rtol=1e-9, atol=1e-12)
