# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Loops of formulas in every reading, against loops of Python."""

import copy
import math
import pickle

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, formula_text, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.loops import LONGEST_LOOP, iterate

x, y, z = f.POINT
k, k1 = f.parameter(0), f.parameter(1)
POINTS = np.random.default_rng(1).normal(size=(203, 3))

each_reading = pytest.mark.parametrize(
    "reading",
    [
        pytest.param(numpy_evaluation, id="numpy"),
        pytest.param(
            codegen_native, id="native", marks=pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
        ),
    ],
)


def mandelbrot(count) -> tuple[f.Formula, ...]:
    """Last a, last b and rounds of z ← z² + c, from 0, with c = x + iy, while |z| < 2."""

    def step(a, b, n):
        return (a * a - b * b + x, 2.0 * a * b + y, n + 1.0), a * a + b * b < 4.0

    return iterate(count, (0.0, 0.0, 0.0), step, 30)


def expected(function, *arguments) -> np.ndarray:
    return np.array([function(*point, *arguments) for point in POINTS])


def agrees(reading, formula: f.Formula, values: np.ndarray, parameters=()) -> None:
    np.testing.assert_allclose(reading.evaluate(formula, POINTS, parameters), values, rtol=1e-13, atol=1e-13)


@each_reading
@pytest.mark.parametrize(
    "count, rounds",
    [
        (6.0, 6),
        (6.9, 6),
        (30.0, 30),
        (1000.0, 30),
        (math.inf, 30),
        (0.0, 0),
        (0.99, 0),
        (-3.0, 0),
        (-math.inf, 0),
        (math.nan, 0),
    ],
)
def test_rounds_and_stopping_are_those_of_a_python_loop(reading, count, rounds):
    def python(cx, cy, _):
        value, n = 0j, 0
        while n < rounds and abs(value) < 2.0:
            value, n = value * value + complex(cx, cy), n + 1
        return value.real, value.imag, n

    real, imaginary, n = expected(python).T
    results = mandelbrot(k)
    np.testing.assert_array_equal(reading.evaluate(results[2], POINTS, [count]), n)
    # A point that stays stays small; one that leaves is not followed: rounding grows by a factor of 4 a round at most.
    steady = n < 12
    for result, value in zip(results, (real, imaginary)):
        np.testing.assert_allclose(
            reading.evaluate(result, POINTS, [count])[steady], value[steady], rtol=1e-9, atol=1e-9
        )


@each_reading
def test_loops_in_loops(reading):
    def build(a, n):
        inner, m = iterate(k1, (a, 0.0), lambda s, m: ((0.5 * s + f.sin(y) * a, m + n), s < 3.0 + n), 10)
        return (inner + 0.1 * x, n + 0.25 * m + 1.0), a < 2.0 + x

    def python(px, py, pz, outer, inner):
        a, n = pz, 1.0
        for _ in range(outer):
            if not a < 2.0 + px:
                break
            s, m = a, 0.0
            for _ in range(inner):
                if not s < 3.0 + n:
                    break
                s, m = 0.5 * s + math.sin(py) * a, m + n
            a, n = s + 0.1 * px, n + 0.25 * m + 1.0
        return a + 7.0 * n

    a, n = iterate(k, (z, 1.0), build, 20)
    agrees(reading, a + 7.0 * n, expected(python, 5, 3), [5.0, 3.0])
    agrees(reading, a + 7.0 * n, expected(python, 20, 0), [99.0, 0.0])


@each_reading
def test_loops_side_by_side_keep_their_states_apart(reading):
    """Their states, and so the first nodes of their bodies, are the same objects."""
    (one,) = iterate(3.0, (x,), lambda a: ((f.cos(a * a) + a * a,), None), 5)
    (two,) = iterate(2.0, (y,), lambda a: ((f.sin(a * a) - a * a,), None), 5)

    def python(px, py, _):
        for _ in range(3):
            px = math.cos(px * px) + px * px
        for _ in range(2):
            py = math.sin(py * py) - py * py
        return px - py

    kept = np.abs(POINTS[:, :2]).max(axis=1) < 1.2  # elsewhere repeated squares magnify rounding
    values = reading.evaluate(one - two, POINTS[kept])
    np.testing.assert_allclose(values, expected(python)[kept], rtol=1e-12, atol=1e-12)

    (nested,) = iterate(
        2.0,
        (z,),
        lambda b: (
            (
                iterate(1.0, (b,), lambda a: ((a * a + x,), None), 2)[0]
                - iterate(2.0, (b,), lambda a: ((0.1 * (a * a),), None), 2)[0],
            ),
            None,
        ),
        5,
    )

    def python_nested(px, _, b):
        for _ in range(2):
            c = 0.1 * (b * b)
            b = b * b + px - 0.1 * (c * c)
        return b

    kept = np.abs(POINTS).max(axis=1) < 1.2
    values = reading.evaluate(nested, POINTS[kept])
    np.testing.assert_allclose(values, expected(python_nested)[kept], rtol=1e-12, atol=1e-12)


@each_reading
def test_a_result_can_go_on_into_other_loops(reading):
    (first,) = iterate(4.0, (x,), lambda a: ((0.5 * a + 1.0,), None), 9)
    (rounds,) = iterate(k, (1.0,), lambda a: ((2.0 * a,), None), 9)
    (second,) = iterate(rounds, (first + y,), lambda a: ((0.5 * a + first,), a < 3.0 * first), 9)

    def python(px, py, _):
        for _ in range(4):
            px = 0.5 * px + 1.0
        a = px + py
        for _ in range(4):
            a = 0.5 * a + px if a < 3.0 * px else a
        return a

    agrees(reading, second, expected(python), [2.0])


@each_reading
def test_a_loop_of_parameters_alone(reading):
    total, factor = iterate(k, (0.0, 1.0), lambda a, b: ((a + b, b * k1), b < 50.0), 100)
    agrees(reading, total + x * factor, 15.0 + 16.0 * POINTS[:, 0], [4.0, 2.0])
    agrees(reading, total + x * factor, 63.0 + 64.0 * POINTS[:, 0], [90.0, 2.0])
    np.testing.assert_array_equal(reading.evaluate(total, POINTS, [90.0, 2.0]), np.full(len(POINTS), 63.0))


@each_reading
def test_a_condition_that_does_not_change_holds_for_all_rounds_or_none(reading):
    def loop(going):
        return iterate(5.0, (x,), lambda a: ((a + 1.0,), going), 5)[0]

    for parameter in (0.0, 2.0):
        agrees(reading, loop(k < 1.0), POINTS[:, 0] + (5.0 if parameter < 1.0 else 0.0), [parameter])
    agrees(reading, loop(x < y), POINTS[:, 0] + np.where(POINTS[:, 0] < POINTS[:, 1], 5.0, 0.0))
    agrees(reading, loop(f.sqrt(y) < 1e9), POINTS[:, 0] + np.where(POINTS[:, 1] >= 0.0, 5.0, 0.0))  # NaN stops


@each_reading
def test_small_bodies(reading):
    agrees(reading, iterate(4.0, (x, y), lambda a, b: ((b, a), None), 9)[0], POINTS[:, 0])
    agrees(reading, iterate(5.0, (x, y), lambda a, b: ((b, a), None), 9)[0], POINTS[:, 1])
    agrees(reading, iterate(5.0, (x,), lambda a: ((2.0,), None), 9)[0], np.full(len(POINTS), 2.0))
    agrees(
        reading,
        iterate(k, (x,), lambda a: ((y,), a < 0.0), 9)[0],
        np.where(POINTS[:, 0] < 0.0, POINTS[:, 1], POINTS[:, 0]),
        [3.0],
    )
    assert iterate(5.0, (), lambda: ((), None), 9) == ()
    assert iterate(0.5, (x, 1.0), lambda a, b: ((b, a), None), 9) == (x, f.constant(1.0))


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
@pytest.mark.parametrize("count", [1, 8, 13])
def test_lanes_stop_on_their_own(count):
    at = np.stack([np.arange(count) * 1.0, np.zeros(count), np.zeros(count)], axis=-1)
    (steps,) = iterate(20.0, (0.0,), lambda n: ((n + 1.0,), n < x), 20)
    np.testing.assert_array_equal(codegen_native.evaluate(steps, at), np.arange(count))


def test_the_same_loop_is_the_same_object():
    first, again = mandelbrot(k), mandelbrot(k)
    assert all(a is b for a, b in zip(first, again))
    assert mandelbrot(k1)[0] is not first[0]
    # A name the body gives its states does not matter, nor does where constants come from.
    (one,) = iterate(k, (x,), lambda a: ((a + (2.0 - 1.0),), a < k1), 7)
    (two,) = iterate(f.parameter(0), (x,), lambda other: ((f.constant(1.0) + other,), f.parameter(1) > other), 7)
    assert one is two
    assert iterate(k, (x,), lambda a: ((a + 1.0,), a < k1), 8)[0] is not one
    assert copy.deepcopy(one) is one and pickle.loads(pickle.dumps(one)) is one


def test_parameters_of_a_body_count():
    (result,) = iterate(2.0, (x,), lambda a: ((a * f.parameter(6),), None), 3)
    assert f.slots(result) == 7
    (nested,) = iterate(2.0, (x,), lambda a: (iterate(1.0, (a,), lambda b: ((f.parameter(8),), None), 3), None), 3)
    assert f.slots(nested) == 9


@pytest.mark.parametrize(
    "count, initial, body, limit, problem",
    [
        (x, (y,), lambda a: ((a,), None), 3, "depend on a variable"),
        (k, (y,), lambda a: ((a, a), None), 3, "one value for each state"),
        (k, (y,), lambda a: ((a,), a), 3, "comparison or None"),
        (k, (y,), lambda a: (iterate(a, (a,), lambda b: ((b,), None), 3), None), 3, "states of a loop"),
    ],
)
def test_what_cannot_be_a_loop(count, initial, body, limit, problem):
    with pytest.raises(TypeError, match=problem):
        iterate(count, initial, body, limit)


@pytest.mark.parametrize("limit", [0, -1, LONGEST_LOOP + 1])
def test_loops_have_a_limit(limit):
    with pytest.raises(ValueError, match="rounds"):
        iterate(k, (x,), lambda a: ((a,), None), limit)


def test_a_body_that_fails_leaves_nothing_behind():
    before = iterate(k, (x,), lambda a: ((a + 1.0,), None), 3)[0]
    with pytest.raises(ZeroDivisionError):
        iterate(k, (x,), lambda a: 1 / 0, 3)
    assert iterate(k, (x,), lambda a: ((a + 1.0,), None), 3)[0] is before


def test_text():
    # Nothing that commutes: which of two orders is written depends on what was built before.
    a, b = iterate(k, (0.0, x), lambda a, b: ((a * a - b, b / a - a * a), a * a - b < 4.0), 30)
    assert formula_text.text(a - b) == "\n".join(
        [
            "s0, s1 = 0, x",
            "repeat k0 times, at most 30:",
            "    a0 = s0 * s0",
            "    a1 = a0 - s1",
            "    stop unless a1 < 4",
            "    s0, s1 = a1, s1 / s0 - a0",
            "s0 - s1",
        ]
    )
    (nested,) = iterate(2.0, (z,), lambda b: (iterate(k, (b,), lambda a: ((a / b,), None), 3), None), 5)
    (after,) = iterate(1.0, (nested,), lambda b: ((b / nested,), None), 5)
    assert formula_text.text(after) == "\n".join(
        [
            "s0 = z",
            "repeat 2 times, at most 5:",
            "    s1 = s0",
            "    repeat k0 times, at most 3:",
            "        s1 = s1 / s0",
            "    s0 = s1",
            "s2 = s0",
            "repeat 1 times, at most 5:",
            "    s2 = s2 / s0",
            "s2",
        ]
    )
