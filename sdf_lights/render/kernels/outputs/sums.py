# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sums of a sample, and how they are added to the film."""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel, table
from ..path import sample_table
from .records import (
    MATTES,
    data_number_table,
    film_data_table,
    film_light_table,
    film_matte_table,
    instance_matte_table,
    material_matte_table,
    matte_hit_table,
    matte_place_table,
    output_sum_table,
)

_count = table("film_count", np.int32)


@kernel
def clear(block, workspace, unused):
    """Set all sums of the sample to 0."""
    sums = output_sum_table(workspace)
    for index in range(len(sums)):
        sums[index] = 0.0
    if block.outputs & MATTES:
        matte_hit_table(workspace)[0].instance = 0
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
    if block.outputs & MATTES:
        _add_mattes(block, workspace, pixel)
    return 0.0


@kernel
def _add_mattes(block, workspace, pixel):
    places, hits = matte_place_table(block), matte_hit_table(workspace)
    size = 2 * block.matte_slots
    for row in range(1, hits[0].instance + 1):
        hit = hits[row]
        own = instance_matte_table(block)[hit.instance]
        for kind in range(3):
            if places[kind] >= 0:
                number = (
                    material_matte_table(block)[hit.material] if kind == 1 else own.object if kind == 0 else own.asset
                )
                _cover(block, (pixel * block.matte_kinds + places[kind]) * size, number, hit.weight)


@kernel
def _cover(block, start, number, weight):
    """Add to the objects that cover a pixel, in the slots from ``start`` on. As in Cycles, objects without a slot count
    in the last one."""
    slots, last = film_matte_table(block), block.matte_slots - 1
    for slot in range(last + 1):
        at = start + 2 * slot
        if slots[at] == 0.0 and slots[at + 1] == 0.0:
            slots[at] = number
        if slots[at] == number or slot == last:
            slots[at + 1] += weight
            return
