# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sums of a sample, and how they are added to the film."""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel, table
from ..path import sample_table
from .records import data_number_table, film_data_table, film_light_table, output_sum_table

_count = table("film_count", np.int32)


@kernel
def clear(block, workspace, unused):
    """Set all sums of the sample to 0."""
    sums = output_sum_table(workspace)
    for index in range(len(sums)):
        sums[index] = 0.0
    return 0.0


@kernel
def add_sample(block, workspace, pixel):
    """Add the sums of the sample to the film, after its pixel has counted it."""
    pixel = np.int64(pixel)
    sums, columns, size = output_sum_table(workspace), block.light_columns, block.data_columns
    branches = sample_table(workspace)[0].branches
    light = film_light_table(block)
    at = 2 * columns * pixel
    for index in range(columns):
        light[at + index] += sums[index]
        light[at + columns + index] += branches * sums[columns + index]
    data, numbers = film_data_table(block), data_number_table(block)
    at = size * pixel
    first = _count(block)[pixel] == 1
    for index in range(size):
        value = sums[2 * columns + index]
        if numbers[index]:
            if first:
                data[at + index] = value
        elif abs(value) < math.inf:
            data[at + index] += value
    return 0.0
