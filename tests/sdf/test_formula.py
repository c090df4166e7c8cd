# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import gc
import pickle
import threading

import numpy as np
import pytest

from sdf_lights.sdf import formula as f
from sdf_lights.sdf import read_native, read_numpy, read_text
from sdf_lights.sdf.shapes import Cone, Torus

x, y, z = f.POINT
k = f.parameter(0)


def test_the_same_expression_is_the_same_object():
    assert f.sqrt(x * x + k) is f.sqrt(x * x + f.parameter(0))
    assert x + y is y + x and f.minimum(x, y) is f.minimum(y, x)
    assert x - y is not y - x
    assert f.constant(0.0) is not f.constant(-0.0)


def test_copies_and_pickles_are_the_same_object():
    formula = Torus().formula()
    assert copy.deepcopy(formula) is formula
    assert pickle.loads(pickle.dumps(formula)) is formula


def test_threads_agree_on_one_object():
    found, start = [], threading.Barrier(8)

    def build():
        start.wait()
        found.append([f.sin(x * float(i) + k) for i in range(200)])

    threads = [threading.Thread(target=build) for _ in range(8)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(a is b for other in found[1:] for a, b in zip(found[0], other))


def test_unused_formulas_are_forgotten():
    gc.collect()
    before = len(f._known)
    formula = f.sin(x * 123.456) + f.cos(y * 654.321)
    assert len(f._known) > before
    del formula
    gc.collect()
    assert len(f._known) == before


@pytest.mark.parametrize("built, simple", [
    (x + 0.0, x), (0.0 + x, x), (x - 0.0, x), (x - x, f.constant(0.0)), (0.0 - x, -x), (-(-x), x), (x * 1.0, x),
    (x * 0.0, f.constant(0.0)), (x / 1.0, x), (abs(abs(x)), abs(x)), (abs(-x), abs(x)), (abs(f.sqrt(x)), f.sqrt(x)),
    (f.minimum(x, x), x), (f.maximum(x, x), x), (f.select(x < y, z, z), z), (f.constant(2.0) + 3.0, f.constant(5.0)),
    (f.sqrt(f.constant(4.0)), f.constant(2.0)), (f.apply("power", x, 1.0), x)])
def test_simplification(built, simple):
    assert built is simple


def test_undefined_constants_stay_to_be_seen():
    formula = f.sqrt(f.constant(-1.0))
    assert formula.kind == "sqrt"
    assert np.isnan(read_numpy.evaluate(formula, np.zeros((1, 3)))).all()
    with pytest.raises(ValueError):
        f.constant(float("nan"))


def test_conditions_stand_only_in_select():
    with pytest.raises(TypeError):
        (x < y) + 1.0
    with pytest.raises(TypeError):
        f.select(x, y, z)
    with pytest.raises(TypeError):
        bool(x < y)


def _samples():
    """Each operation on operands that reach all of its domain and leave it."""
    for kind, operation in f.OPERATIONS.items():
        if kind == "select":
            yield kind, f.select(x < y, x, z)
        elif kind in f.CONDITIONS:
            yield kind, f.select(f.apply(kind, x, y), f.constant(1.0), f.constant(2.0))
        else:
            yield kind, f.apply(kind, *f.POINT[:operation.arity])
            yield kind + " of parameters", f.apply(kind, *map(f.parameter, range(operation.arity))) + x


@pytest.mark.skipif(not read_native.AVAILABLE, reason="no Numba")
@pytest.mark.parametrize("formula", [pytest.param(formula, id=kind) for kind, formula in _samples()])
def test_every_operation_reads_the_same(formula):
    rng = np.random.default_rng(2)
    points = rng.normal(size=(1001, 3)) * 10.0 ** rng.uniform(-3, 3, (1001, 1))
    points[:4] = [(0, 0, 0), (1, 1, 1), (-1, 1, 0), (0, -1, 2)]
    parameters = np.array([0.3, 0.7])
    expected = read_numpy.evaluate(formula, points, parameters)
    # The absolute part is for sums that cancel: their terms are about 1.
    np.testing.assert_allclose(read_native.evaluate(formula, points, parameters), expected, rtol=1e-14, atol=1e-15)


@pytest.mark.skipif(not read_native.AVAILABLE, reason="no Numba")
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 17])
def test_native_code_takes_any_number_of_points(count):
    points = np.random.default_rng(3).normal(size=(count, 3))
    np.testing.assert_array_equal(read_native.evaluate(x + 2.0 * y, points), points[:, 0] + 2.0 * points[:, 1])


@pytest.mark.skipif(not read_native.AVAILABLE, reason="no Numba")
def test_missing_parameters_are_refused():
    with pytest.raises(ValueError):
        read_native.evaluate(f.parameter(1) + x, np.zeros((1, 3)), [1.0])


@pytest.mark.skipif(not read_native.AVAILABLE, reason="no Numba")
def test_values_of_parameters_recompile_nothing():
    first = read_native.compiled(Torus(1.0, 0.3).formula())
    gc.collect()
    assert read_native.compiled(Torus(2.0, 0.1).formula()) is first
    assert read_native.compiled(Cone().formula()) is not first


def test_a_deep_formula_is_read_without_recursion():
    deep = x
    for i in range(5000):
        deep = f.sqrt(deep * deep + float(i + 1))
    point = np.array([(0.5, 0.0, 0.0)])
    assert read_numpy.evaluate(deep, point)[0] == pytest.approx((0.25 + 5000 * 5001 / 2) ** 0.5)
    assert read_text.text(deep).endswith("sqrt(a4998 * a4998 + 5000)")


def test_text():
    assert read_text.text(Torus().formula()) == "a0 = sqrt(x * x + y * y) - k0\nsqrt(a0 * a0 + z * z) - k1"
    assert read_text.text(x - (y - z)) == "x - (y - z)"
    assert read_text.text((x + y) * -z / (x * 2.0)) == "(x + y) * -z / (x * 2)"
    assert read_text.text(-(x + 1.0) - f.select(x <= 0.1, -2.0, y)) == "-(x + 1) - select(x <= 0.1, -2, y)".replace(
        "0.1", f"{0.1:.17g}")
