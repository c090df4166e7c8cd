# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Elementary functions of native code against NumPy's, on all of their domains and off them."""

import numpy as np
import pytest

from sdf_lights.graph import codegen_native, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.operations import OPERATIONS

pytestmark = pytest.mark.skipif(not codegen_native.AVAILABLE, reason="no Numba")

ULP = 2.0**-52
SPECIAL = np.array(
    [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        -0.5,
        np.pi,
        -np.pi,
        np.pi / 2,
        1e5,
        -1e5,
        1e-308,
        5e-324,
        1e308,
        710.0,
        -750.0,
        np.inf,
        -np.inf,
        np.nan,
        0.66,
        2.0**0.5,
        0.5**0.5,
    ]
)


def wide(rng, low: float, high: float, signed: bool = True) -> np.ndarray:
    """Random numbers whose magnitudes are spread over all powers of ten between."""
    numbers = 10.0 ** rng.uniform(low, high, 20_000)
    return numbers * rng.choice([-1.0, 1.0], numbers.shape) if signed else numbers


CASES = {  # operands, and errors relative to the result and in units of 1
    "sin": (lambda r: [wide(r, -8, 5)], 5 * ULP, 5 * ULP),
    "cos": (lambda r: [wide(r, -8, 5)], 5 * ULP, 5 * ULP),
    "tan": (lambda r: [r.uniform(-1.5, 1.5, 20_000)], 5 * ULP, 0.0),
    "asin": (lambda r: [np.clip(wide(r, -8, 0.1), -1, 1)], 5 * ULP, 0.0),
    "acos": (lambda r: [np.clip(wide(r, -8, 0.1), -1, 1)], 5 * ULP, 0.0),
    "atan": (lambda r: [wide(r, -20, 20)], 5 * ULP, 0.0),
    "exp": (lambda r: [r.uniform(-699, 699, 20_000)], 5 * ULP, 0.0),
    "log": (lambda r: [np.concatenate([wide(r, -300, 300, False), r.uniform(0.9, 1.1, 20_000)])], 5 * ULP, ULP / 8),
    "atan2": (lambda r: [wide(r, -20, 20), wide(r, -20, 20)], 5 * ULP, 0.0),
    "power": (lambda r: [wide(r, -2, 2, False), r.uniform(-5, 5, 20_000)], 1e-14, 0.0),
}


def read(kind: str, operands: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    points = np.stack([*operands, *[operands[0]] * (3 - len(operands))], axis=-1)
    formula = f.apply(kind, *f.POINT[: len(operands)])
    return codegen_native.evaluate(formula, points), numpy_evaluation.evaluate(formula, points)


@pytest.mark.parametrize("kind", CASES)
def test_errors_are_a_few_units_in_the_last_place(kind):
    operands, relative, absolute = CASES[kind]
    native, expected = read(kind, operands(np.random.default_rng(12)))
    assert np.isfinite(expected).all()
    np.testing.assert_array_less(np.abs(native - expected), relative * np.abs(expected) + absolute + 1e-320)


@pytest.mark.parametrize("kind", CASES)
def test_special_operands_give_what_numpy_gives(kind):
    """Alone, and among seven others that are none."""
    rng = np.random.default_rng(13)
    for special in SPECIAL:
        operands = [rng.uniform(0.1, 0.9, 16) for _ in range(OPERATIONS[kind].arity)]
        for place in range(len(operands)):
            changed = [o.copy() for o in operands]
            changed[place][3] = special
            native, expected = read(kind, changed)
            np.testing.assert_allclose(native, expected, rtol=1e-14, atol=5 * ULP)
        native, expected = read(kind, [np.full(8, special)] * len(operands))
        np.testing.assert_allclose(native, expected, rtol=1e-14, atol=5 * ULP)
