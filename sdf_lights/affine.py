# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Affine matrices: inverses, whether they stretch, and what lies between two of them.

In most builds of NumPy, ``numpy.linalg.inv`` calls OpenBLAS, which wakes a thread for each core even for 4 × 4
matrices. These threads then spin for a tenth of a second, beside the threads of the next work.
"""

from __future__ import annotations

import math

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


class Arc:
    """Affine matrices between two (4, 4): rotation along the shortest arc, translation and scale on straight lines.

    Shoemake and Duff 1992, "Matrix animation and polar decomposition". ``angle``: of the rotation, in radians.
    """

    def __init__(self, start: np.ndarray, end: np.ndarray):
        self._start, self._end = start, end
        self._turn, self._stretch = zip(*(_polar(pose[:3, :3]) for pose in (start, end)))
        self._axis, self.angle = _axis_angle(self._turn[0].T @ self._turn[1])

    def at(self, part: float) -> np.ndarray:
        """The matrix (4, 4) after ``part`` of the way, 0 to 1."""
        straight = self._start + part * (self._end - self._start)
        if part in (0.0, 1.0) or self.angle == 0.0:
            return straight
        stretch = self._stretch[0] + part * (self._stretch[1] - self._stretch[0])
        straight[:3, :3] = self._turn[0] @ _rotation(self._axis, part * self.angle) @ stretch
        return straight


def _polar(linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and stretch (3, 3) whose product is ``linear``; mirroring belongs to the stretch."""
    left, scales, right = np.linalg.svd(linear)
    sign = np.sign(np.linalg.det(left @ right)) or 1.0
    return sign * left @ right, sign * right.T @ np.diag(scales) @ right


def _axis_angle(rotation: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit axis and angle, 0 to π, of a rotation."""
    twist = 0.5 * np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = float(np.linalg.norm(twist)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return twist / sine, angle
    # Half a turn: the axis is the eigenvector of 1.
    square = 0.5 * (rotation + np.eye(3))
    column = square[:, int(np.argmax(square.diagonal()))]
    return column / max(float(np.linalg.norm(column)), 1e-300), angle


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
