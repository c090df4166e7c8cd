# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Primitives of the same proportions, as one shape in several sizes: their lamps share the boxes of their cuts.

So a thousand balls with different radii cost one tree and not gigabytes.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from ...sdf.shapes import Shape, Transformed

DIGITS = 9  # significant digits of proportions; values that differ by rounding count as equal


class Placed(NamedTuple):
    """A shape and the 4 × 4 matrix that maps it to the world."""

    shape: Shape
    matrix: np.ndarray


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def similar(shape: Shape, matrix: np.ndarray) -> Placed:
    """The same primitive in the same position, with its new matrix (4 × 4). If all its numbers are lengths, its first
    number becomes 1.

    Transforms in the shape become part of the matrix. Other shapes stay as they are.
    """
    matrix = np.asarray(matrix, np.float64)
    while isinstance(shape, Transformed):
        shape, matrix = shape.child, matrix @ np.array(shape.matrix)
    numbers = shape.fields()
    if not numbers or len(numbers) < len(dataclasses.fields(shape)) or any(one.unit != "LENGTH" for one in numbers):
        return Placed(shape, matrix)
    values = [getattr(shape, one.name) for one in numbers]
    size = float(np.ravel(values[0])[0])
    if not size > 0.0:
        return Placed(shape, matrix)
    unit = [
        tuple(_rounded(part / size) for part in value) if isinstance(value, tuple) else _rounded(value / size)
        for value in values
    ]
    return Placed(type(shape)(*unit), matrix @ np.diag([size, size, size, 1.0]))
