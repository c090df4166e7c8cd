# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that add samples to the film."""

import math

import numpy as np

from ...jit import kernel, table
from ..film import CHANNELS, DISCARDED, HALF_BIT, LEAST_SAMPLES, Film
from .path import MOST_BRANCHES, sample_table

TABLES = {
    **{f"film_{name}": np.dtype(np.float64) for name in CHANNELS},
    "film_count": np.dtype(np.int32), "film_surfaces": np.dtype(np.int32), "film_active": np.dtype(np.uint8),
    "film_discarded": np.dtype(np.int32), "film_direct": np.dtype(np.float64), "film_indirect": np.dtype(np.float64)}
SCALARS = [("film_x", np.int64), ("film_y", np.int64), ("film_width", np.int64)]

_combined = table("film_combined", np.float64)
_half = table("film_half", np.float64)
_lamps = table("film_lamps", np.float64)
_emission = table("film_emission", np.float64)
_normal = table("film_normal", np.float64)
_albedo = table("film_albedo", np.float64)
_diffuse_albedo = table("film_diffuse_albedo", np.float64)
_position = table("film_position", np.float64)
_depth = table("film_depth", np.float64)
_count = table("film_count", np.int32)
_surfaces = table("film_surfaces", np.int32)
_active = table("film_active", np.uint8)
_discarded = table("film_discarded", np.int32)
_direct = table("film_direct", np.float64)
_indirect = table("film_indirect", np.float64)

_KINDS = len(DISCARDED)
_NAN, _INFINITE = range(_KINDS)

START = 2  # branches, until the two halves of a pixel's samples tell how noisy they are
# Time that a sample takes before its path divides, in surfaces that a branch meets. Measured: 3 with plain materials in the
# open, less than 1 in a room of principled ones; too many branches cost more than too few.
COST = 1.0


def pack_film(film: Film) -> dict[str, np.ndarray]:
    """The film's own arrays: kernels write into them."""
    return {
        **{f"film_{name}": array for name, array in film.sums.items()}, "film_count": film.count,
        "film_surfaces": film.surfaces, "film_active": film.active, "film_discarded": film.discarded,
        "film_direct": film.direct.ravel(), "film_indirect": film.indirect.ravel()}


def film_scalars(film: Film) -> dict[str, int]:
    return {"film_x": film.window[0], "film_y": film.window[1], "film_width": film.width}


@kernel
def pixel_index(block, x, y):
    return (y - block.film_y) * block.film_width + x - block.film_x


@kernel
def is_active(block, pixel):
    return _active(block)[pixel] != 0


@kernel
def _add(sums, pixel, value):
    if len(sums) > 0:
        at = 3 * pixel
        sums[at] += value[0]
        sums[at + 1] += value[1]
        sums[at + 2] += value[2]


@kernel
def _put(sums, pixel, value):
    if len(sums) > 0:
        at = 3 * pixel
        sums[at] = value[0]
        sums[at + 1] = value[1]
        sums[at + 2] = value[2]


@kernel
def add_sample(block, workspace, pixel, index):
    """Add the workspace's ``sample``, number ``index`` of its pixel. One that is not finite counts as black, and is told."""
    sample = sample_table(workspace)[0]
    _count(block)[pixel] += 1
    combined = sample.combined
    total = combined[0] + combined[1] + combined[2] + sample.alpha
    # Not math.isfinite: it subtracts the value from itself, which reassociation folds to zero for a sum.
    if not abs(total) < math.inf:
        _discarded(block)[_KINDS * pixel + (_NAN if math.isnan(total) else _INFINITE)] += 1
        return
    sums = _combined(block)
    at = 4 * pixel
    sums[at] += combined[0]
    sums[at + 1] += combined[1]
    sums[at + 2] += combined[2]
    sums[at + 3] += sample.alpha
    direct, indirect = _direct(block), _indirect(block)
    whole = combined[0] + combined[1] + combined[2]
    before = sample.direct if sample.direct >= 0.0 else whole
    direct[2 * pixel] += before
    indirect[4 * pixel] += whole - before
    if index & HALF_BIT:
        direct[2 * pixel + 1] += before
        indirect[4 * pixel + 1] += whole - before
    indirect[4 * pixel + 2] += sample.branches
    indirect[4 * pixel + 3] += sample.met
    if index & HALF_BIT:
        _add(_half(block), pixel, combined)
    _add(_lamps(block), pixel, sample.lamps)
    _add(_emission(block), pixel, sample.emission)
    if sample.found:
        surfaces = _surfaces(block)
        _add(_normal(block), pixel, sample.normal)
        _add(_albedo(block), pixel, sample.albedo)
        _add(_diffuse_albedo(block), pixel, sample.diffuse_albedo)
        if surfaces[pixel] == 0:
            _put(_position(block), pixel, sample.position)
            depth = _depth(block)
            if len(depth) > 0:
                depth[pixel] = sample.depth
        surfaces[pixel] += 1


@kernel
def branches_before(block, pixel):
    """How many branches the paths of a pixel had."""
    return np.int64(_indirect(block)[4 * pixel + 2])


@kernel
def best_branches(block, x0, y0, x1, y1):
    """Into how many branches paths of a tile should divide, by how noisy its samples were until now.

    With k branches the mean of a pixel has the variance D + I/k, and a sample takes the time C + k: their product is least
    for k = √(C · I/D). Half of the samples tell the variances, as in ``Film.noise``; those of pixels are weighed by
    1/brightness, as ``Film.update_active`` does. The number depends on past samples only, and the mean of a sample on
    none of it, so nothing is biased.
    """
    direct, indirect, count = _direct(block), _indirect(block), _count(block)
    first, second, met, branches = 0.0, 0.0, 0.0, 0.0
    for y in range(y0, y1):
        for x in range(x0, x1):
            pixel = pixel_index(block, x, y)
            n = count[pixel]
            if n < LEAST_SAMPLES or not is_active(block, pixel):
                continue
            half = n // (2 * HALF_BIT) * HALF_BIT + max(n % (2 * HALF_BIT) - HALF_BIT, 0)
            a, b = direct[2 * pixel] / n, indirect[4 * pixel] / n
            weight = 1.0 / max(a + b, 1e-8)
            first += weight * (a - direct[2 * pixel + 1] / half) ** 2
            second += weight * (b - indirect[4 * pixel + 1] / half) ** 2 * indirect[4 * pixel + 2] / n
            branches += indirect[4 * pixel + 2]
            met += indirect[4 * pixel + 3]
    if branches == 0.0:
        return START
    cost = COST * branches / max(met, 1.0)
    return int(min(max(math.sqrt(cost * second / max(first, 1e-12 * second + 1e-300)) + 0.5, 1.0), float(MOST_BRANCHES)))
