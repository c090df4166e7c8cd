# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sampling pattern. Statistical tests use fixed seeds; a right pattern fails a bound with probability < 0.01 %."""

import hashlib

import numpy as np
import pytest
from scipy import stats

from sdf_lights.jit import kernel
from sdf_lights.render.kernels.samplers import get_1d, get_2d, get_3d, get_4d, pixel_seed


@kernel
def _fill(seeds, dimensions, first, out):
    for row in range(len(seeds)):
        for index in range(out.shape[1]):
            u = get_4d(first + index, seeds[row], dimensions[row])
            out[row, index, 0] = u[0]
            out[row, index, 1] = u[1]
            out[row, index, 2] = u[2]
            out[row, index, 3] = u[3]


@kernel
def _seeds(width, height, seed, out):
    for y in range(height):
        for x in range(width):
            out[y, x] = pixel_seed(x, y, seed)


def seeds(width, height, seed=0):
    out = np.zeros((height, width), np.uint32)
    _seeds(width, height, seed, out)
    return out


def points(rows, count, first=0, dimensions=0):
    """(rows, count, 4) points from index ``first`` on, each row of another pixel."""
    rows = np.atleast_1d(rows).astype(np.uint32).ravel()
    out = np.zeros((len(rows), count, 4))
    _fill(rows, np.broadcast_to(np.asarray(dimensions, np.int64), len(rows)).copy(), first, out)
    return out


@pytest.mark.parametrize("first", [0, 1 << 12, (1 << 20) + (1 << 12), (1 << 32) - (1 << 12)])
@pytest.mark.parametrize("power", [0, 1, 2, 5, 8, 11])
def test_elementary_intervals(power, first):
    """Each aligned block of 2^k points puts one point in every elementary interval of area 2^-k of the first two axes,
    and one in every 2^k-th of each axis."""
    count = 1 << power
    for u in points(seeds(3, 1, 5), count, first, [0, 1, 77]):
        for split in range(power + 1):
            columns, rows = 1 << split, 1 << power - split
            cells = (u[:, 0] * columns).astype(int) * rows + (u[:, 1] * rows).astype(int)
            assert len(set(cells)) == count
        for axis in range(4):
            assert len(set((u[:, axis] * count).astype(int))) == count


def test_low_dimensional_projections_are_stratified():
    """Sobol pairs other than the first are no (0, 2)-sequences, but far better than random: t ≤ 2 for these."""
    u = points(seeds(1, 1), 1 << 10)[0]
    for a in range(4):
        for b in range(a):
            cells = (u[:, a] * 16).astype(int) * 16 + (u[:, b] * 16).astype(int)
            assert np.all(np.bincount(cells, minlength=256) == 4)


def test_sets_of_fewer_dimensions_are_prefixes():
    for index in (0, 3, 12345):
        u = get_4d(index, np.uint32(9), 4)
        assert get_1d(index, np.uint32(9), 4) == u[0]
        assert get_2d(index, np.uint32(9), 4) == u[:2]
        assert get_3d(index, np.uint32(9), 4) == u[:3]


def test_range():
    u = points(seeds(64, 64), 64)
    assert u.min() >= 0.0 and u.max() < 1.0 and u.max() > 0.99999


def test_every_sample_is_uniform_over_pixels():
    for index in (0, 1, 1000003):
        u = points(seeds(128, 128), 1, index, 3)[:, 0]
        for axis in range(4):
            assert stats.kstest(u[:, axis], "uniform").pvalue > 1e-4


def test_jitter_within_a_cell_is_uniform_and_not_shared():
    """What full Owen scrambling has over a random shift: points are offset independently in their cells."""
    u = points(seeds(1, 1), 1 << 12, 0, 2)[0, :, :2]
    offset = u * (1 << 12) % 1.0
    for axis in range(2):
        assert stats.kstest(offset[:, axis], "uniform").pvalue > 1e-4
    assert abs(np.corrcoef(offset.T)[0, 1]) < 4 / np.sqrt(len(offset))


def _independent(a, b, bins=16):
    """χ² test of the joint histogram of two uniform samples, and their correlation."""
    cells = (a * bins).astype(int) * bins + (b * bins).astype(int)
    assert stats.chisquare(np.bincount(cells, minlength=bins * bins)).pvalue > 1e-4
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(len(a))


def test_pixels_are_independent():
    grid = seeds(129, 129)
    here = points(grid[:-1, :-1], 2)
    for other in (grid[1:, :-1], grid[:-1, 1:], grid[1:, 1:], seeds(128, 128, 1)):
        there = points(other, 2)
        for sample in range(2):
            _independent(here[:, sample, 0], there[:, sample, 0])


@pytest.mark.parametrize("other", [1, 2, 3, 64])
def test_sets_are_independent(other):
    """Over pixels at a fixed sample, and, since each set is shuffled for itself, over the samples of one pixel."""
    rows = seeds(128, 128)
    _independent(points(rows, 1, 5, 0)[:, 0, 0], points(rows, 1, 5, other)[:, 0, 0])
    pair = points(np.full(2, rows[3, 4]), 1 << 14, 0, [0, other])
    for axis in range(4):
        _independent(pair[0, :, axis], pair[1, :, axis])


def test_convergence():
    """RMSE over 64 pixels of a smooth integral falls nearly as N^-1.5 (Owen 1997); random numbers: N^-0.5."""
    counts = 2 ** np.arange(3, 12)
    u = points(seeds(8, 8), counts[-1])
    f = np.sin(2.0 * u[..., 0]) * np.exp(u[..., 1] * (0.5 + u[..., 0]))
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (x + 1), 0.5 * w
    exact = np.einsum("i,j,ij->", w, w, np.sin(2.0 * x)[:, None] * np.exp(x[None, :] * (0.5 + x[:, None])))
    errors = [np.sqrt(np.mean((f[:, :count].mean(axis=1) - exact) ** 2)) for count in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope < -1.3


def test_unbiased_at_any_count():
    """Also between powers of two the mean over pixels is right: 5 standard errors."""
    u = points(seeds(64, 64), 7)
    f = (u[..., 0] * u[..., 1] ** 2).mean(axis=1)
    assert abs(f.mean() - 1 / 6) < 5 * f.std() / np.sqrt(len(f))


def test_same_bits_on_every_machine_and_run():
    u = points(seeds(4, 4, 11), 64, 0, 9)
    assert u.tobytes() == points(seeds(4, 4, 11), 64, 0, 9).tobytes()
    assert hashlib.sha256(u.tobytes()).hexdigest()[:16] == "c720eae1d47d5e60"
