# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single operations: those of Numba are those of NumPy, and contain values at points of the intervals."""

import numpy as np
import pytest

from sdf_lights.graph import elementary_bounds, interval_kernels

ENDS = np.array([-np.inf, -7.0, -1.0, -1e-300, 0.0, 0.5, 2.0, 1e90, np.inf])
CASES = {
    "abs_bounds": (1, np.abs),
    "square_bounds": (1, np.square),
    "product_bounds": (2, np.multiply),
    "quotient_bounds": (2, np.divide),
    "unit_bounds": (2, lambda u, r: u / np.hypot(u, np.sqrt(r))),
}


def intervals(count: int) -> np.ndarray:
    """(n, 2 count) low and high of each operand: ends that are special, and random ones."""
    rng = np.random.default_rng(3)
    pairs = np.sort(np.concatenate([rng.choice(ENDS, (2000, count, 2)), rng.normal(size=(2000, count, 2))]), axis=2)
    return pairs[(pairs[..., 0] < np.inf).all(axis=1) & (pairs[..., 1] > -np.inf).all(axis=1)].reshape(-1, 2 * count)


def both(name: str, operands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n, 2) by Numba and by NumPy."""
    kernel = getattr(interval_kernels, name)
    with np.errstate(all="ignore"):
        arrays = np.stack(np.broadcast_arrays(*getattr(elementary_bounds, name)(*operands.T)), axis=1)
    return np.array([kernel(*map(float, row)) for row in operands]), arrays


@pytest.mark.parametrize("name", CASES)
def test_both_forms_agree_and_contain_values(name):
    count, function = CASES[name]
    operands = intervals(count)
    if name == "quotient_bounds":
        operands = operands[(operands[:, 2] > 0.0) | (operands[:, 3] < 0.0)]
    if name == "unit_bounds":
        operands = operands[operands[:, 2] >= 0.0]
    numbers, arrays = both(name, operands)
    known = ~np.isnan(arrays).any(axis=1)  # the product of zero and infinity, which only numbers settle
    assert known.mean() > 0.7
    np.testing.assert_allclose(numbers[known], arrays[known], rtol=1e-14, atol=1e-300)
    rng = np.random.default_rng(4)
    finite = np.clip(operands, -1e150, 1e150)
    for _ in range(20):
        at = [low + rng.random(len(low)) * (high - low) for low, high in zip(finite.T[::2], finite.T[1::2])]
        at = [np.clip(each, low, high) for each, low, high in zip(at, finite.T[::2], finite.T[1::2])]
        with np.errstate(all="ignore"):
            value = function(*at)
        slack = 1e-12 * np.abs(value) + 1e-300
        inside = (value >= numbers[:, 0] - slack) & (value <= numbers[:, 1] + slack)
        assert (inside | np.isnan(value) | np.isinf(value)).all()


@pytest.mark.parametrize("exponent", [2.0, 3.0, -1.0, -2.0, 0.0])
def test_powers(exponent):
    operands = np.concatenate([intervals(1), np.full((len(intervals(1)), 1), exponent)], axis=1)
    numbers, arrays = both("power_bounds", operands)
    np.testing.assert_allclose(numbers, arrays, rtol=1e-14)
    for part in (0.0, 0.3, 1.0):
        low, high = np.clip(operands[:, :2], -1e100, 1e100).T
        at = np.clip(low + part * (high - low), low, high)
        with np.errstate(all="ignore"):
            value = at**exponent
        known = np.isfinite(value)
        value, slack = value[known], 1e-12 * np.abs(value[known])
        assert ((value >= numbers[known, 0] - slack) & (value <= numbers[known, 1] + slack)).all()


@pytest.mark.parametrize("function, crest", [(np.sin, 0.25), (np.cos, 0.0)])
def test_waves(function, crest):
    rng = np.random.default_rng(5)
    low = rng.uniform(-20.0, 20.0, 500)
    high = low + 10.0 ** rng.uniform(-3.0, 1.0, 500)
    operands = np.stack([function(low), function(high), low, high, np.full(500, crest), np.full(500, 1e-9)], axis=1)
    numbers, arrays = both("wave_bounds", operands)
    np.testing.assert_array_equal(numbers, arrays)
    for part in np.linspace(0.0, 1.0, 101):
        value = function(low + part * (high - low))
        assert ((value >= numbers[:, 0] - 1e-12) & (value <= numbers[:, 1] + 1e-12)).all()
    short = high - low < 1.0
    assert (np.diff(numbers[short], axis=1)[:, 0] <= high[short] - low[short] + 1e-9).all()  # the slope is 1 at most


def test_angles():
    rng = np.random.default_rng(6)
    low = rng.uniform(-2.0, 2.0, (500, 2))
    high = low + rng.random((500, 2))
    cut = (low[:, 0] <= 0.0) & (high[:, 0] >= 0.0) & (low[:, 1] <= 0.0)
    operands = np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=1)
    arrays = np.stack(elementary_bounds.angle_bounds(*operands.T, cut), axis=1)
    numbers = np.array([interval_kernels.angle_bounds(*row, bool(c)) for row, c in zip(operands.tolist(), cut)])
    np.testing.assert_allclose(numbers, arrays, rtol=1e-14)
    for _ in range(50):
        y, x = (low + rng.random((500, 2)) * (high - low)).T
        value = np.arctan2(y, x)
        assert ((value >= numbers[:, 0] - 1e-12) & (value <= numbers[:, 1] + 1e-12)).all()
