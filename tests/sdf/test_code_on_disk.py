# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Machine code of formulas on disk: read where it is the same code, made again where it is not or is damaged."""

import ctypes
from collections import OrderedDict

import numpy as np
import pytest

from sdf_lights import kernel_cache
from sdf_lights.graph import codegen_native, native_emission
from sdf_lights.graph import formula as f
from sdf_lights.graph.folding import Folding
from sdf_lights.graph.functions import Function
from sdf_lights.graph.loops import iterate
from sdf_lights.jit import CallablePart, kernel

pytestmark = pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")

x, y, z = f.POINT
k = f.parameter(0)
POINTS = np.random.default_rng(1).normal(size=(19, 3))
PLACES = {f.POSITION: codegen_native.Place(0, "f8")}


@kernel
def _twice(a):
    return 2.0 * a


TWICE = Function("twice", _twice)


@pytest.fixture
def start(tmp_path, monkeypatch):
    """A function after which no code is in memory, as in a new process, that gives the number of modules made since."""
    made = []
    for name in ("module", "surface_module"):
        original = getattr(native_emission, name)
        monkeypatch.setattr(native_emission, name, lambda *given, original=original: made.append(1) or original(*given))
    monkeypatch.setattr(codegen_native, "_folder", lambda: tmp_path / "formulas")
    monkeypatch.setattr(codegen_native, "_compiled", OrderedDict())

    def restart() -> int:
        codegen_native._compiled.clear()
        count = len(made)
        made.clear()
        return count

    return restart


def test_a_second_process_makes_no_code(start):
    looped = iterate(k, (x, 1.0), lambda a, b: ((a * b + y, b + 1.0), a < 50.0), 20)[0]
    formula = f.sin(x) + f.power(abs(y), k) * looped + f.atan2(y, z)
    first = codegen_native.evaluate(formula, POINTS, [3.0])
    assert start() == 1
    np.testing.assert_array_equal(codegen_native.evaluate(formula, POINTS, [3.0]), first)
    assert start() == 0
    codegen_native.evaluate(formula + 1.0, POINTS, [3.0])
    assert start() == 1


def test_damaged_code_is_made_again(start, tmp_path):
    first = codegen_native.evaluate(f.exp(x) + k, POINTS, [2.0])
    start()
    (path,) = (tmp_path / "formulas").iterdir()
    path.write_bytes(path.read_bytes()[:-9] + b"elsewhere")
    np.testing.assert_array_equal(codegen_native.evaluate(f.exp(x) + k, POINTS, [2.0]), first)
    assert start() == 1
    assert str(path.parent) in kernel_cache.refused()


def _at_surface(formula: f.Formula, places: dict, point: np.ndarray) -> float:
    part = CallablePart(_twice, (), 1, None)
    code = codegen_native.compiled_at_surface((formula,), places, lambda function, operands: part.address)
    numbers, value = np.array([0.25]), np.zeros(1)
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 3, ctypes.c_void_p, ctypes.c_void_p)
    signature(code.address)(0, 0, point.ctypes.data, numbers.ctypes.data, value.ctypes.data)
    return float(value[0])


def test_code_at_surfaces_calls_functions_and_knows_where_variables_are(start):
    formula = f.call(TWICE, x + k)[0] + y
    point = np.array([3.0, 5.0, 7.0, 9.0])
    for _ in range(2):
        assert _at_surface(formula, PLACES, point) == 2.0 * 3.25 + 5.0
        codegen_native._compiled.clear()
    assert start() == 1
    assert _at_surface(formula, {f.POSITION: codegen_native.Place(8, "f8")}, point) == 2.0 * 5.25 + 7.0
    assert start() == 1


def test_descriptions_differ_where_code_does():
    def loop(step, limit=9, going=None):
        return iterate(k, (x, y), lambda a, b: (step(a, b), going and going(a)), limit)[0]

    different = [
        x + y,
        x - y,
        y - x,
        x + 0.5,
        x + 0.25,
        f.sqrt(k),
        f.sqrt(f.parameter(1)),
        f.call(TWICE, x)[0],
        loop(lambda a, b: (a + b, b)),
        loop(lambda a, b: (b, a + b)),
        loop(lambda a, b: (a + b, b), 8),
        loop(lambda a, b: (a + b, b), going=lambda a: a < 3.0),
        loop(lambda a, b: (a + b, b), going=lambda a: a < 4.0),
    ]
    assert len({codegen_native._description((formula,)) for formula in different}) == len(different)
    assert codegen_native._description((x + y, x)) != codegen_native._description((x, x + y))


@pytest.mark.parametrize("formula", [f.power(x, k), x / k, x * k])
def test_numbers_leave_a_folded_formula_its_nodes(formula):
    """But 0 and 1, which end operations."""

    def shape(number: float) -> list[str]:
        # Sorted, as 2·x may be known as x·2 to the process.
        return sorted(node.kind for node in f.order(Folding([number]).fold(formula)))

    assert shape(2.0) == shape(0.5) == shape(-1.0) == shape(-4.0) == shape(0.3)
    assert len(shape(1.0)) < len(shape(2.0))
