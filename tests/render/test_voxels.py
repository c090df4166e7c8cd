# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of voxels: what is packed is what is read, interpolated between voxels."""

import itertools

import numpy as np
import pytest

from sdf_lights.render.kernels.textures import cubic_weight
from sdf_lights.render.kernels.voxels import BY_CHANCE, CUBIC, LINEAR, _between
from sdf_lights.render.voxels import BRICK, HEAD, TooManyVoxels, packed

FIRST, SHAPE = np.array([-13, 2, -5]), (21, 9, 18)


def reader(values, background):
    """What gives parts of ``values``, whose first voxel is ``FIRST``; the background around it."""

    def read(start, counts):
        found = np.full((*counts, values.shape[3]), background, np.float32)
        for place in itertools.product(*map(range, counts)):
            at = np.array(start) + place - FIRST
            if (at >= 0).all() and (at < values.shape[:3]).all():
                found[place] = values[tuple(at)]
        return found

    return read


def grid(values, background=0.0, matrix=None):
    width = np.full(values.shape[3], background)
    last = FIRST + values.shape[:3] - 1
    return packed(reader(values, background), FIRST, last, width, np.eye(4) if matrix is None else matrix)[0]


def between(numbers, p, mode):
    """Interpolated values at a point in object space."""
    matrix = numbers[:12].reshape(3, 4).astype(float)
    return np.array(_between(numbers, 0, tuple(matrix[:, :3] @ p + matrix[:, 3]), mode))


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("mode, weight", [(LINEAR, lambda t, i: (1.0 - t, t)[i]), (CUBIC, cubic_weight)])
def test_between_voxels(channels, mode, weight):
    generator = np.random.default_rng(0)
    values = generator.uniform(0.0, 1.0, (*SHAPE, channels)).astype(np.float32)
    numbers, read = grid(values, 0.25), reader(values, 0.25)
    count = 2 if mode == LINEAR else 4
    for p in generator.uniform(FIRST - 1.0, FIRST + SHAPE, (60, 3)):
        whole = np.floor(p).astype(int)
        around = read(whole - (count // 2 - 1), (count,) * 3).astype(float)
        for axis in range(3):
            shares = [weight(p[axis] - whole[axis], i) for i in range(count)]
            around = np.tensordot(shares, around, (0, 0))
        np.testing.assert_allclose(between(numbers, p, mode)[:channels], around, rtol=1e-4, atol=1e-5)


def test_a_voxel_by_chance_has_the_linear_mean():
    values = np.random.default_rng(1).uniform(0.0, 1.0, (*SHAPE, 1)).astype(np.float32)
    numbers, p = grid(values), FIRST + (3.3, 4.6, 5.1)
    near = p + np.random.default_rng(2).uniform(-1e-3, 1e-3, (4000, 3))
    found = np.array([between(numbers, each, BY_CHANCE)[0] for each in near])
    corners = values[3:5, 4:6, 5:7, 0].ravel()
    assert np.isin(found.astype(np.float32), corners).all() and len(np.unique(found)) == 8
    assert abs(found.mean() - between(numbers, p, LINEAR)[0]) < 4.0 * found.std() / np.sqrt(len(found))


def test_matrices_lead_to_voxels():
    values = np.random.default_rng(3).uniform(0.0, 1.0, (*SHAPE, 1)).astype(np.float32)
    matrix = np.array([[0.1, 0.02, 0.0, 1.0], [0.0, 0.2, 0.0, -2.0], [0.01, 0.0, -0.3, 0.5], [0.0, 0.0, 0.0, 1.0]])
    numbers = grid(values, matrix=matrix)
    for place in ((0, 0, 0), (4, 7, 9), (20, 8, 17)):
        p = matrix[:3, :3] @ (FIRST + place) + matrix[:3, 3]
        assert between(numbers, p, LINEAR)[0] == pytest.approx(values[place][0], abs=1e-4)


def test_bricks_of_one_value_are_stored_once():
    values = np.zeros((64, 64, 64, 1), np.float32)
    values[3, 3, 3], values[40:] = 1.0, 2.0
    numbers = grid(values)
    places = int(numbers[12:15].prod())
    assert places > 700 and len(numbers) - HEAD - places < 0.4 * places * BRICK


def test_what_is_no_number_is_zero():
    values = np.full((*SHAPE, 1), np.nan, np.float32)
    values[2:] = np.inf
    assert np.isfinite(grid(values)).all()


def test_huge_boxes_are_refused():
    with pytest.raises(TooManyVoxels):
        packed(lambda start, counts: None, np.zeros(3), np.full(3, 1e6), np.zeros(1), np.eye(4))
