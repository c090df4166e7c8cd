# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that read tables, in each reading of a formula."""

import pickle

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, interval_evaluation, lipschitz, numpy_evaluation
from sdf_lights.graph.formula import POINT, Formula, call, length, parameter
from sdf_lights.graph.functions import Function, TableFunction
from sdf_lights.graph.gradient import gradient
from sdf_lights.graph.interval_interpreter import BOXES, DEEPEST_LOOP, SIZE, enclose
from sdf_lights.graph.interval_tape import tape
from sdf_lights.graph.tables import table, tables_of
from sdf_lights.jit import doubles_at, kernel


@kernel
def _line(address, x, y):
    numbers = doubles_at(address)
    return numbers[0] * x + numbers[1] * y


@kernel
def _line_slope(address, x, y):
    numbers = doubles_at(address)
    return numbers[0], numbers[1]


@kernel
def _line_bounds(address, x_low, x_high, y_low, y_high):
    numbers = doubles_at(address)
    a, b = numbers[0], numbers[1]
    low = min(a * x_low, a * x_high) + min(b * y_low, b * y_high)
    high = max(a * x_low, a * x_high) + max(b * y_low, b * y_high)
    return low - 1e-9, high + 1e-9, a, a, b, b


LINE = TableFunction(
    "line",
    _line,
    bounds=Function("line_bounds", _line_bounds, results=6),
    derivatives=Function("line_slope", _line_slope, results=2),
    lipschitz=5.0,
)


def _formula() -> Formula:
    (value,) = call(LINE, parameter(0), length(POINT.x, POINT.z), POINT.y * parameter(1))
    return value


def _meant(points, numbers):
    return numbers[0] * np.hypot(points[..., 0], points[..., 2]) + 2.0 * numbers[1] * points[..., 1]


@pytest.mark.parametrize("evaluate", [numpy_evaluation.evaluate, codegen_native.evaluate])
def test_values_are_those_of_the_table_that_a_parameter_names(evaluate):
    points = np.random.default_rng(1).normal(size=(21, 3))
    for numbers in ((3.0, 4.0), (-1.0, 0.5)):  # the same code reads both
        held = table(np.array(numbers))
        np.testing.assert_allclose(evaluate(_formula(), points, [held.address, 2.0]), _meant(points, numbers))


def test_tables_of_the_same_numbers_are_one_and_known_by_their_addresses():
    held = table(np.array([3.0, 4.0]))
    assert table(np.array([3.0, 4.0])) is held and table(np.array([3.0, 5.0])) is not held
    assert pickle.loads(pickle.dumps(held)) is held
    assert tables_of(_formula(), np.array([held.address, 2.0])) == (held,)


def test_bounds_and_gradients_hold_in_boxes():
    held, rng = table(np.array([3.0, 4.0])), np.random.default_rng(2)
    numbers = np.array([held.address, 2.0])
    low = rng.normal(size=(BOXES, 3))
    high = low + rng.random((BOXES, 3))
    points = low + rng.random((50, BOXES, 3)) * (high - low)
    values = numpy_evaluation.evaluate(_formula(), points, numbers)
    slopes = np.stack([numpy_evaluation.evaluate(g, points, numbers) for g in gradient(_formula())], axis=-1)
    step = 1e-6
    ahead = numpy_evaluation.evaluate(_formula(), points + [step, 0.0, 0.0], numbers)
    np.testing.assert_allclose((ahead - values) / step, slopes[..., 0], atol=1e-4)

    least, most = interval_evaluation.enclose(_formula(), low, high, numbers)
    assert (least <= values).all() and (values <= most).all()
    steepest = lipschitz.lipschitz(_formula(), low, high, numbers)
    assert (np.linalg.norm(slopes, axis=-1) <= steepest).all() and steepest.max() < 12.0

    written = tape(_formula())
    registers = np.zeros((written.registers, SIZE, BOXES))
    for axis in range(3):
        registers[axis, :2] = low[:, axis], high[:, axis]
        registers[axis, 2 + 2 * axis : 4 + 2 * axis] = 1.0
    rounds = np.empty((DEEPEST_LOOP, 2), np.int64)
    enclose(written.instructions, 0, len(written.instructions), numbers, 0, registers, rounds)
    found = registers[written.result]
    np.testing.assert_allclose(found[:2], [least, most], atol=1e-6)
    for axis in range(3):
        assert (found[2 + 2 * axis] <= slopes[..., axis] + 1e-9).all()
        assert (slopes[..., axis] <= found[3 + 2 * axis] + 1e-9).all()
