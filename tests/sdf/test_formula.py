# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import gc
import pickle
import threading

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, formula_nodes, formula_text, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.operations import CONDITIONS, OPERATIONS
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
    before = len(formula_nodes._known)
    formula = f.sin(x * 123.456) + f.cos(y * 654.321)
    assert len(formula_nodes._known) > before
    del formula
    gc.collect()
    assert len(formula_nodes._known) == before


@pytest.mark.parametrize(
    "built, simple",
    [
        (x + 0.0, x),
        (0.0 + x, x),
        (x - 0.0, x),
        (x - x, f.constant(0.0)),
        (0.0 - x, -x),
        (x * 1.0, x),
        (-(-x), x),  # noqa: B002
        (x + -y, x - y),
        (-x + y, y - x),
        (x - -y, x + y),
        (-(x - y), y - x),
        (x * -1.0, -x),
        (-x * -y, x * y),
        (-x * y, -(x * y)),
        (-(x * 2.0), x * -2.0),
        (-x / y, -(x / y)),
        (x / -y, -(x / y)),
        (x / 4.0, x * 0.25),
        (x / -1.0, -x),
        (x * 0.0, f.constant(0.0)),
        (x / 1.0, x),
        (abs(abs(x)), abs(x)),
        (abs(-x), abs(x)),
        (abs(f.sqrt(x)), f.sqrt(x)),
        (abs(x * x), x * x),
        (abs(f.exp(x)), f.exp(x)),
        (f.sqrt(x * x), abs(x)),
        (f.length(x), abs(x)),
        (f.minimum(x, x), x),
        (f.maximum(x, x), x),
        (f.minimum(f.minimum(x, 2.0), 1.0), f.minimum(x, 1.0)),
        (f.maximum(1.0, f.maximum(x, 2.0)), f.maximum(x, 2.0)),
        (f.minimum(f.maximum(x, 2.0), 1.0), f.constant(1.0)),
        (f.maximum(f.minimum(x, 1.0), 1.0), f.constant(1.0)),
        (f.minimum(x, f.minimum(y, x)), f.minimum(x, y)),
        (f.minimum(x, f.maximum(y, x)), x),
        (f.select(x < y, z, z), z),
        (f.select(x < y, x, y), f.minimum(x, y)),
        (f.select(x <= y, y, x), f.maximum(x, y)),
        (f.select(f.constant(1.0) < 2.0, x, y), x),
        (f.select(f.constant(2.0) <= 1.0, x, y), y),
        (f.constant(2.0) + 3.0, f.constant(5.0)),
        (f.sqrt(f.constant(4.0)), f.constant(2.0)),
        (f.power(x, 1.0), x),
        (f.power(x, 0.0), f.constant(1.0)),
        (f.power(x, 2.0), x * x),
        (f.power(x, 5.0), x * ((x * x) * (x * x))),
        (f.power(x, -3.0), 1.0 / (x * (x * x))),
        (f.power(x, 0.5), f.sqrt(x)),
    ],
)
def test_simplification(built, simple):
    assert built is simple


@pytest.mark.parametrize(
    "kept", [f.power(x, 17.0), f.power(x, 2.5), x / 3.0, f.minimum(f.maximum(x, 1.0), 2.0), f.select(x < y, x, z)]
)
def test_what_is_not_simpler_stays(kept):
    assert kept.kind in ("power", "divide", "minimum", "select")


def test_random_formulas_keep_their_values_when_simplified():
    """Each is also computed operation by operation, on operands that are often equal, opposite or special constants."""
    rng = np.random.default_rng(4)
    at = rng.integers(-3, 4, (50, 3)) + rng.choice([0.0, 0.25], (50, 3))
    kinds = [kind for kind in formula_nodes._RULES if kind != "select"]
    tried = 0
    for _ in range(3000):
        parts = [(p, at[:, i]) for i, p in enumerate(f.POINT)]
        parts += [(f.constant(c), np.full(50, c)) for c in (-1.0, 0.0, 0.5, 1.0, 2.0, -3.0)]
        for _ in range(rng.integers(2, 7)):
            kind = kinds[rng.integers(len(kinds))]
            chosen = [
                parts[-1 if rng.random() < 0.5 else rng.integers(len(parts))] for _ in range(OPERATIONS[kind].arity)
            ]
            with np.errstate(all="ignore"):
                value = OPERATIONS[kind].meaning(*(v for _, v in chosen))
            parts.append((f.apply(kind, *(formula for formula, _ in chosen)), value))
            if not np.isfinite(value).all():
                break  # a value that is not finite is promised nothing from here on
            np.testing.assert_allclose(numpy_evaluation.evaluate(parts[-1][0], at), value, rtol=1e-13, atol=1e-13)
            tried += 1
    assert tried > 5000


def test_vectors():
    at = np.random.default_rng(5).normal(size=(100, 3))
    axis = np.array([0.6, 0.0, 0.8])
    p, u = f.POINT, f.Vector(*map(f.constant, axis))

    def values(vector):
        return np.stack([numpy_evaluation.evaluate(a, at) for a in vector], axis=-1)

    np.testing.assert_allclose(values(p.cross(u)), np.cross(at, axis), atol=1e-15)
    np.testing.assert_allclose(values(p.normalized()), at / np.linalg.norm(at, axis=1, keepdims=True), atol=1e-15)
    np.testing.assert_allclose(values(p.reflected(u)), at - 2.0 * np.outer(at @ axis, axis), atol=1e-15)
    np.testing.assert_array_equal(values(2.0 * p + 1.0), 2.0 * at + 1.0)
    np.testing.assert_array_equal(values((1.0, 2.0, 3.0) - p), (1.0, 2.0, 3.0) - at)
    np.testing.assert_array_equal(values(p.minimum(0.5).maximum(u)), np.maximum(np.minimum(at, 0.5), axis))
    np.testing.assert_array_equal(numpy_evaluation.evaluate(p.greatest() - p.least(), at), np.ptp(at, axis=1))
    turned = values(p.rotated((0.0, 0.0, 1.0), 0.0, 1.0))
    np.testing.assert_array_equal(turned, np.stack([-at[:, 1], at[:, 0], at[:, 2]], axis=-1))
    turned = values(p.rotated(u, np.cos(0.7), np.sin(0.7)))
    np.testing.assert_allclose(turned @ axis, at @ axis, atol=1e-14)
    across, before = turned - np.outer(at @ axis, axis), at - np.outer(at @ axis, axis)
    np.testing.assert_allclose((across * before).sum(axis=1), np.cos(0.7) * (before**2).sum(axis=1), atol=1e-14)
    assert (values(f.Vector(x * 0.0, y * 0.0, z * 0.0).normalized()) == 0.0).all()


def test_undefined_constants_stay_to_be_seen():
    formula = f.sqrt(f.constant(-1.0))
    assert formula.kind == "sqrt"
    assert np.isnan(numpy_evaluation.evaluate(formula, np.zeros((1, 3)))).all()
    with pytest.raises(ValueError, match="cannot be NaN"):
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
    for kind, operation in OPERATIONS.items():
        if kind == "select":
            yield kind, f.select(x < y, x, z)
        elif kind in CONDITIONS:
            yield kind, f.select(f.apply(kind, x, y), f.constant(1.0), f.constant(2.0))
        else:
            yield kind, f.apply(kind, *f.POINT[: operation.arity])
            yield kind + " of parameters", f.apply(kind, *map(f.parameter, range(operation.arity))) + x


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
@pytest.mark.parametrize("formula", [pytest.param(formula, id=kind) for kind, formula in _samples()])
def test_every_operation_reads_the_same(formula):
    rng = np.random.default_rng(2)
    points = rng.normal(size=(1001, 3)) * 10.0 ** rng.uniform(-3, 3, (1001, 1))
    points[:4] = [(0, 0, 0), (1, 1, 1), (-1, 1, 0), (0, -1, 2)]
    parameters = np.array([0.3, 0.7])
    expected = numpy_evaluation.evaluate(formula, points, parameters)
    # The absolute part is for sums that cancel: their terms are about 1.
    np.testing.assert_allclose(codegen_native.evaluate(formula, points, parameters), expected, rtol=1e-14, atol=1e-15)


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 17])
def test_native_code_takes_any_number_of_points(count):
    points = np.random.default_rng(3).normal(size=(count, 3))
    np.testing.assert_array_equal(codegen_native.evaluate(x + 2.0 * y, points), points[:, 0] + 2.0 * points[:, 1])


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
def test_missing_parameters_are_refused():
    with pytest.raises(ValueError, match="has 2 parameters, not 1"):
        codegen_native.evaluate(f.parameter(1) + x, np.zeros((1, 3)), [1.0])


@pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")
def test_values_of_parameters_recompile_nothing():
    first = codegen_native.compiled(Torus(1.0, 0.3).formula())
    gc.collect()
    assert codegen_native.compiled(Torus(2.0, 0.1).formula()) is first
    assert codegen_native.compiled(Cone().formula()) is not first


def test_a_deep_formula_is_read_without_recursion():
    deep = x
    for i in range(5000):
        deep = f.sqrt(deep * deep + float(i + 1))
    point = np.array([(0.5, 0.0, 0.0)])
    assert numpy_evaluation.evaluate(deep, point)[0] == pytest.approx((0.25 + 5000 * 5001 / 2) ** 0.5)
    assert formula_text.text(deep).endswith("sqrt(a4998 * a4998 + 5000)")


def test_text():
    assert formula_text.text(Torus().formula()) == "a0 = sqrt(x * x + y * y) - k0\nsqrt(a0 * a0 + z * z) - k1"
    assert formula_text.text(x - (y - z)) == "x - (y - z)"
    # What commutes stands in the order in which it was first made, here or in another test.
    sums, thirds = ("(x + y)", "(y + x)"), ("(x * 3)", "(3 * x)")
    products = [text for total in sums for text in (f"z * {total}", f"{total} * z")]
    assert formula_text.text((x + y) * -z / (x * 3.0)) in {f"-({p} / {t})" for p in products for t in thirds}
    assert formula_text.text(f.exp(-x) * y) == "exp(-x) * y"
    assert formula_text.text(-(x + 1.0) - f.select(x <= 0.1, -2.0, y)) == "-(x + 1) - select(x <= 0.1, -2, y)".replace(
        "0.1", f"{0.1:.17g}"
    )
