# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds and transforms of many positions, which are computed part by part, are those of all at once."""

import numpy as np
import pytest

from sdf_lights.render.kernels.geometry import bounds_of
from sdf_lights.render.kernels.rays import world_positions

COUNTS = 1, 63, 64, 65, 8191, 8192, 20000


@pytest.mark.parametrize("count", COUNTS)
def test_bounds_are_the_least_and_greatest_coordinates(count):
    positions = np.random.default_rng(count).normal(size=(count, 3)).astype(np.float32)
    low, high = bounds_of(positions)
    assert (low == positions.min(axis=0)).all()
    assert (high == positions.max(axis=0)).all()
    assert low.dtype == high.dtype == np.float64


def test_the_bounds_of_every_other_point_are_theirs():
    positions = np.random.default_rng(1).normal(size=(1000, 3)).astype(np.float32)[::2]
    low, high = bounds_of(positions)
    assert (low == positions.min(axis=0)).all()
    assert (high == positions.max(axis=0)).all()


@pytest.mark.parametrize("count", [0, *COUNTS])
def test_positions_in_the_world_are_rounded_once(count):
    random = np.random.default_rng(count)
    positions, matrix = random.normal(size=(count, 3)).astype(np.float32), random.normal(size=(4, 4))
    exact = np.einsum("ij,vj->vi", matrix[:3, :3], positions.astype(np.float64)) + matrix[:3, 3]
    found = world_positions(positions, matrix)
    assert found.shape == (count, 3)
    # Within half a unit in the last place, and the rounding of float64 before that.
    assert (np.abs(found - exact) <= 0.500001 * np.spacing(np.abs(found)) + 1e-14).all()
