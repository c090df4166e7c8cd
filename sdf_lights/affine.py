# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Affine matrices: inverses, and whether they stretch.

In most builds of NumPy, ``numpy.linalg.inv`` calls OpenBLAS, which wakes a thread for each core even for 4 × 4
matrices. These threads then spin for a tenth of a second, beside the threads of the next work.
"""

from __future__ import annotations

import numpy as np

# Rows and columns of the cofactor of each entry, already transposed.
_COLUMN, _ROW = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
_FIRST = ((_ROW + 1) % 3, (_COLUMN + 1) % 3), ((_ROW + 2) % 3, (_COLUMN + 2) % 3)
_SECOND = ((_ROW + 1) % 3, (_COLUMN + 2) % 3), ((_ROW + 2) % 3, (_COLUMN + 1) % 3)
_UNIT = np.eye(3)


def inverse_linear(linear: np.ndarray) -> np.ndarray:
    """Inverses of the matrices ``linear`` (…, 3, 3). Raises ``LinAlgError`` if one has none.

    By cofactors, which stay exact under scales along rows and columns, and one step of Newton's iteration, which
    corrects the cancellation in cofactors of a shear.
    """
    linear = np.asarray(linear, float)
    (a, b), (c, d) = _FIRST, _SECOND
    found = linear[..., *a] * linear[..., *b] - linear[..., *c] * linear[..., *d]
    determinant = (found[..., 0, :] * linear[..., :, 0]).sum(axis=-1)
    if not (np.isfinite(determinant) & (determinant != 0.0)).all():
        raise np.linalg.LinAlgError("Singular matrix")
    found /= determinant[..., None, None]
    return found + found @ (_UNIT - linear @ found)


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverses of affine matrices (…, 4, 4), whose last rows are 0, 0, 0, 1. Raises ``LinAlgError`` if one has none."""
    matrix = np.asarray(matrix, float)
    found = np.zeros_like(matrix)
    linear = inverse_linear(matrix[..., :3, :3])
    found[..., :3, :3], found[..., 3, 3] = linear, 1.0
    found[..., :3, 3] = -(linear @ matrix[..., :3, 3:])[..., 0]
    return found


def stretch(matrices: np.ndarray) -> np.ndarray:
    """(N,) bool: whether affine matrices (N, 4, 4) change angles, by scales that differ or by shear."""
    linear = np.asarray(matrices, float).reshape(-1, 4, 4)[:, :3, :3]
    squares = linear.transpose(0, 2, 1) @ linear
    mean = np.trace(squares, axis1=1, axis2=2)[:, None, None] / 3.0
    return (np.abs(squares - mean * _UNIT) > 1e-5 * mean).any((1, 2))
