# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour in a lamp: places across its box, along its curve, and in a picture; the same on the processor and in GLSL."""

import math

import numpy as np
import pytest

from sdf_lights.emitter import build_lamp
from sdf_lights.graph import codegen_glsl
from sdf_lights.graph.tables import address_slots, as_float32, with_places
from sdf_lights.sdf.data.texture import MOST_PIXELS, texture_table
from sdf_lights.sdf.data.tube import Tube
from sdf_lights.sdf.emission import Emission, EmissionExpression, in_colours
from sdf_lights.sdf.expression import evaluate
from sdf_lights.sdf.resolver import Arrays
from sdf_lights.sdf.shapes import SHAPES, Box, Sphere, Transformed, Union
from support import glsl


def _glow(text: str, shape, points, **arrays):
    return EmissionExpression(text).emission(resolver=Arrays(**arrays)).placed(shape).evaluate(np.asarray(points))


def _helix(turns: float = 2.0, count: int = 400):
    t = np.linspace(0.0, 1.0, count)
    angle = 2.0 * math.pi * turns * t
    return np.column_stack([np.cos(angle), np.sin(angle), t]), t


def test_u_v_and_height_go_across_the_box():
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3)) * (0.5, 0.25, 2.0)
    found = _glow("(u, v, height)", Box((0.5, 0.25, 2.0)), points)
    np.testing.assert_allclose(found, 0.5 + 0.5 * points / (0.5, 0.25, 2.0), atol=1e-12)


def test_along_is_the_part_of_the_length_of_the_nearest_curve():
    points, t = _helix()
    radii = 0.05 + 0.02 * np.sin(9.0 * t)  # all parts are as long, and most are cones
    tube = Tube.of([(points, radii, False)])
    outside = points + 0.03 * np.random.default_rng(2).normal(size=points.shape)
    np.testing.assert_allclose(_glow("along", tube, outside)[:, 0], t, atol=0.02)
    middles = 0.5 * (points[1:] + points[:-1])
    np.testing.assert_allclose(_glow("along", tube, middles)[:, 0], 0.5 * (t[1:] + t[:-1]), atol=1e-3)


def test_along_of_each_path_begins_anew_and_follows_transforms_and_combinations():
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    tube = Tube.of([(line, 0.1, False), (line + (0.0, 1.0, 0.0), 0.1, False)])
    at = np.array([[0.75, 0.0, 0.0], [1.5, 1.0, 0.0], [9.0, 0.0, 0.0]])
    np.testing.assert_allclose(_glow("along", tube, at)[:, 0], [0.25, 0.5, 1.0], atol=1e-12)
    matrix = np.diag([2.0, 2.0, 2.0, 1.0])
    moved = Union(Sphere(0.01), Transformed(tube, matrix))
    np.testing.assert_allclose(_glow("along", moved, 2.0 * at)[:, 0], [0.25, 0.5, 1.0], atol=1e-12)
    ring = Tube.of([(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), 0.1, True)])
    np.testing.assert_allclose(_glow("along", ring, [[0.0, 0.5, 0.0]])[:, 0], [0.875], atol=1e-12)
    np.testing.assert_array_equal(_glow("along", Sphere(1.0), at)[:, 0], 0.0)


LINE = Tube.of([(np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), 0.2, False)])


@pytest.mark.parametrize(
    "shape, at, expected",
    [
        (SHAPES["onion"](LINE, 0.05), (1.0, 0.2, 0.0), 0.25),
        (SHAPES["offset"](LINE, 0.1), (3.0, 0.25, 0.0), 0.75),
        (SHAPES["wave_displacement"](LINE), (1.0, 0.1, 0.0), 0.25),
        (SHAPES["mirror"](LINE), (-1.0, 0.0, 0.0), 0.25),
        (SHAPES["twist"](LINE, 1.0), (1.0, 0.0, 0.0), 0.25),
        (SHAPES["elongate"](LINE, (1.0, 0.0, 0.0)), (3.0, 0.0, 0.0), 0.5),
        (SHAPES["morph"](Sphere(0.1), LINE, 0.5), (1.0, 0.0, 0.0), 0.25),
        (SHAPES["repetition"](LINE, (1, 3, 1), (9.0, 1.0, 9.0)), (3.0, 1.05, 0.0), 0.75),
        (SHAPES["repetition"](LINE, (0, 1, 1), (5.0, 1.0, 1.0)), (6.0, 0.0, 0.0), 0.25),
        (SHAPES["polar_repetition"](LINE, 4), (0.05, -3.0, 0.0), 0.75),
        (SHAPES["repetition"](Sphere(0.1), (3, 1, 1)), (1.0, 0.0, 0.0), 0.0),
    ],
)
def test_operators_ask_along_where_they_ask_their_shape(shape, at, expected):
    np.testing.assert_allclose(_glow("along", shape, [at])[0, 0], expected, atol=1e-9)


def test_distances_of_a_tube_are_what_they_were():
    """What is known of paths lies behind the segments, so nothing else reads it."""
    points, t = _helix(count=37)
    radii = 0.05 + 0.02 * np.sin(9.0 * t)
    tube = Tube.of([(points, radii, False)])
    np.testing.assert_allclose(tube.balls[:, 3].max(), radii.max())
    assert np.abs(tube.balls).max() < 1.0 + 1e-9
    at = np.random.default_rng(3).uniform(-1.2, 1.2, (300, 3))
    many = np.linspace(0.0, 1.0, 400)[:, None, None]
    centres = (points[:-1] + many * np.diff(points, axis=0)).reshape(-1, 3)
    sizes = (radii[:-1] + many[..., 0] * np.diff(radii)).ravel()
    expected = (np.linalg.norm(at[:, None] - centres, axis=2) - sizes).min(axis=1)
    np.testing.assert_allclose(tube.distance(at), expected, atol=1e-4)


def _stripes() -> np.ndarray:
    pixels = np.ones((2, 4, 4), np.float32)
    pixels[..., :3] = [[(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]] * 2
    return pixels


def test_a_picture_has_its_colours_where_its_pixels_are():
    box = Box((1.0, 1.0, 0.1))
    at = np.array([[(2 * i + 1) / 4 - 1.0, 0.0, 0.0] for i in range(4)])
    found = _glow('image_color("P", u, v)', box, at, images={"P": _stripes()})
    np.testing.assert_allclose(found, [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], atol=1e-6)
    between = _glow('image_color("P", u, v)', box, [[-0.5, 0.0, 0.0]], images={"P": _stripes()})
    np.testing.assert_allclose(between, [(0.5, 0.5, 0.0)], atol=1e-6)
    upper = np.zeros((2, 2, 3), np.float32)
    upper[0] = 1.0  # rows come from the top
    found = _glow('image_color("P", u, v)', box, [[0.0, 0.9, 0.0], [0.0, -0.9, 0.0]], images={"P": upper})
    np.testing.assert_allclose(found[:, 0], [1.0, 0.0], atol=1e-6)


def test_transparent_pixels_lend_no_colour():
    pixels = _stripes()
    pixels[:, 0, :] = 0.0
    found = _glow('image_color("P", u, v)', Box(1.0), [[-0.5, 0.0, 0.0]], images={"P": pixels})
    np.testing.assert_allclose(found, [(0.0, 1.0, 0.0)], atol=1e-6)


def test_large_pictures_are_scaled_down_to_their_mean():
    rng = np.random.default_rng(4)
    pixels = rng.random((1500, 1501, 3), np.float32)
    table = texture_table(pixels)
    assert len(table.array) <= 4 * MOST_PIXELS + 4
    np.testing.assert_allclose(table.array[4::4].mean(), pixels[..., 0].mean(), rtol=1e-3)
    assert texture_table(np.full((1, 5_000_000, 1), 0.5, np.float32)).array[0] <= MOST_PIXELS


def test_a_lamp_in_own_colours_has_them_around_its_middle():
    table = texture_table(_stripes()[::-1])
    glow = in_colours(Emission((EmissionExpression("2").emission().colour[0],) * 3), table, 2.0, 1.0)
    found = glow.placed(Box((1.0, 0.5, 0.1))).evaluate(np.array([[-0.75, 0.2, 0.0], [0.75, 0.2, 0.0]]))
    np.testing.assert_allclose(found, [(2, 0, 0), (2, 2, 2)], atol=1e-6)


@pytest.mark.parametrize("text", ["ramp(along, 0, (1, 0, 0), 1, (0, 0.2, 1))", 'image_color("P", along, v)'])
def test_the_power_is_that_of_the_lamp(text):
    points, _ = _helix(count=60)
    tube = Tube.of([(points, 0.1, False)])
    emission = EmissionExpression(text).emission(resolver=Arrays(images={"P": _stripes()}))
    lamp = build_lamp("Lamp", tube, np.eye(4), power=60.0, emission=emission)
    low, high = tube.bounds()
    at = low + np.random.default_rng(5).random((400_000, 3)) * (high - low)
    at = at[tube.distance(at) < 0.0]
    volume = len(at) / 400_000 * np.prod(high - low)
    colours = emission.placed(tube).evaluate(at).mean(axis=0) * lamp.glow["scale"][0]
    # Blender's power is that of white: of the mean of the channels.
    assert 4.0 * math.pi * volume * colours.mean() == pytest.approx(60.0, rel=0.03)


@pytest.mark.parametrize("text", ["(along, 0.5 * along, u)", 'image_color("P", along, 2 * v - 0.5)'])
def test_glsl_has_the_same_colours(text):
    points, t = _helix(count=40)
    shape = Tube.of([(points, 0.05 + 0.02 * np.sin(9.0 * t), False), (points + 0.3, 0.05, False)])
    placed = EmissionExpression(text).emission(resolver=Arrays(images={"P": _stripes()})).placed(shape)
    at = np.random.default_rng(6).uniform(-1.2, 1.2, (2000, 3)).astype(np.float32)
    numbers, tables = with_places(placed.parameters, address_slots(*placed.colour))
    first = len(numbers)
    numbers = np.concatenate([numbers, *(as_float32(table) for table in tables)])
    written: set[str] = set()
    source = f"#define table_number(i) k[{first} + (i)]\n"
    source += codegen_glsl.function(placed.colour[0], "red", written=written)
    found = glsl.evaluate(source, "red", at, numbers)
    expected = placed.evaluate(at.astype(float))[:, 0]
    assert np.mean(np.abs(found - expected) > 1e-4) < 2e-3  # both ends may be equally near
    again = codegen_glsl.function(placed.colour[1], "green", written=written)
    assert "vec3 tube_nearest" in source and "tube_nearest(int table" not in again


def test_words_of_colours_say_what_they_lack():
    with pytest.raises(Exception, match="there is no image 'Q': did you mean 'P'|such as 'P'"):
        _glow('image_color("Q", u, v)', Box(1.0), [[0.0, 0, 0]], images={"P": _stripes()})
    shape = evaluate('sphere(0.5)(p) - 0.1 * image_color("P", p.x, p.y).x', resolver=Arrays(images={"P": _stripes()}))
    assert shape.bounded and shape.distance(np.array([0.1, 0.0, 0.0])) == pytest.approx(-0.5, abs=1e-6)
