# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Inverses of matrices, against those of exact numbers."""

from fractions import Fraction

import numpy as np
import pytest

from sdf_lights import affine

RNG = np.random.default_rng(20)


def exact_inverse(matrix: np.ndarray) -> np.ndarray:
    """Gauss and Jordan, in fractions."""
    size = len(matrix)
    rows = [
        [Fraction(float(x)) for x in row] + [Fraction(int(i == j)) for j in range(size)] for i, row in enumerate(matrix)
    ]
    for i in range(size):
        pivot = next(r for r in range(i, size) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for r in range(size):
            if r != i:
                rows[r] = [x - rows[r][i] * y for x, y in zip(rows[r], rows[i])]
    return np.array([[float(x) for x in row[size:]] for row in rows])


def placed(linear) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = 10.0 * RNG.standard_normal(3)
    return matrix


def stretched() -> np.ndarray:
    return np.diag(10.0 ** RNG.uniform(-4, 4, 3)) @ RNG.standard_normal((3, 3)) @ np.diag(10.0 ** RNG.uniform(-2, 2, 3))


MATRICES = {
    "unit": lambda: np.eye(3),
    "any": lambda: RNG.standard_normal((3, 3)),
    "stretch": stretched,
    "mirror": lambda: np.diag([-1.0, 1.0, 1.0]) @ RNG.standard_normal((3, 3)),
    "shear": lambda: np.eye(3) + np.triu(RNG.uniform(-1e4, 1e4, (3, 3)), 1),
    "tiny": lambda: 1e-9 * RNG.standard_normal((3, 3)),
}


@pytest.mark.parametrize("kind", MATRICES)
def test_it_is_as_exact_as_its_condition_allows(kind):
    for _ in range(100):
        matrix = placed(MATRICES[kind]())
        expected = exact_inverse(matrix)
        condition = np.linalg.cond(matrix[:3, :3])
        assert np.abs(affine.inverse(matrix) - expected).max() <= 4e-16 * condition * np.abs(expected).max()


def test_scales_and_moves_are_undone_exactly():
    matrix = np.diag([2.0, -0.25, 1e4, 1.0])
    matrix[:3, 3] = (3.0, -5.0, 1e6)
    np.testing.assert_array_equal(affine.inverse(matrix), exact_inverse(matrix))


def test_stacks():
    linear = RNG.standard_normal((5, 4, 3, 3))
    np.testing.assert_allclose(
        affine.inverse_linear(linear) @ linear, np.broadcast_to(np.eye(3), linear.shape), atol=1e-12
    )
    assert affine.inverse_linear(linear[:0]).shape == (0, 4, 3, 3)


@pytest.mark.parametrize("linear", [np.zeros((3, 3)), np.diag([1.0, 0.0, 1.0]), np.full((3, 3), np.nan)])
def test_without_an_inverse(linear):
    with pytest.raises(np.linalg.LinAlgError):
        affine.inverse(placed(linear))
