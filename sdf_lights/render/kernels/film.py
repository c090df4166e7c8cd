# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that add samples to the film."""

import math

import numpy as np

from ...jit import kernel, table
from ...vec import scale, sub, vec
from ..film import CHANNELS, DISCARDED, DIVIDED, HALF_BIT, SQUARES, Film
from .outputs import dispatch as outputs
from .path import sample_table

TABLES = {
    **{f"film_{name}": np.dtype(np.float64) for name in CHANNELS},
    "film_count": np.dtype(np.int32),
    "film_surfaces": np.dtype(np.int32),
    "film_active": np.dtype(np.uint8),
    "film_discarded": np.dtype(np.int32),
    "film_squares": np.dtype(np.float64),
    "film_divided": np.dtype(np.float64),
    "film_branches": np.dtype(np.int32),
    "film_rate": np.dtype(np.float64),
}
SCALARS = [("film_x", np.int64), ("film_y", np.int64), ("film_width", np.int64)]

_combined = table("film_combined", np.float64)
_half = table("film_half", np.float64)
_lamps = table("film_lamps", np.float64)
_scattered = table("film_scattered", np.float64)
_scattered_half = table("film_scattered_half", np.float64)
_scattered_lamps = table("film_scattered_lamps", np.float64)
_emission = table("film_emission", np.float64)
_environment = table("film_environment", np.float64)
_normal = table("film_normal", np.float64)
_albedo = table("film_albedo", np.float64)
_diffuse_albedo = table("film_diffuse_albedo", np.float64)
_position = table("film_position", np.float64)
_depth = table("film_depth", np.float64)
_count = table("film_count", np.int32)
_surfaces = table("film_surfaces", np.int32)
_active = table("film_active", np.uint8)
_discarded = table("film_discarded", np.int32)
_squares = table("film_squares", np.float64)
_divided = table("film_divided", np.float64)
_branches = table("film_branches", np.int32)
_rate = table("film_rate", np.float64)

_KINDS = len(DISCARDED)
_NAN, _INFINITE = range(_KINDS)


def pack_film(film: Film) -> dict[str, np.ndarray]:
    """The film's own arrays: kernels write into them."""
    return {
        **{f"film_{name}": array for name, array in film.sums.items()},
        "film_count": film.count,
        "film_surfaces": film.surfaces,
        "film_active": film.active,
        "film_discarded": film.discarded,
        "film_squares": film.squares.ravel(),
        "film_divided": film.divided.ravel(),
        "film_branches": film.branches,
        "film_rate": film.rate,
    }


def film_scalars(film: Film) -> dict[str, int]:
    """Scalars of the block: the position of the film in the frame."""
    return {"film_x": film.window[0], "film_y": film.window[1], "film_width": film.width}


@kernel
def pixel_index(block, x, y):
    """Index of the pixel (x, y) of the frame in the arrays of the film."""
    return (y - block.film_y) * block.film_width + x - block.film_x


@kernel
def is_active(block, pixel):
    """Whether the pixel takes more samples."""
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
    """Add the workspace's ``sample``, number ``index`` of its pixel. A sample that is not finite counts as black, and
    is counted."""
    _count(block)[pixel] += 1
    if not _is_finite(block, workspace, pixel):
        return
    if block.outputs:
        outputs.add_sample(block, workspace, pixel)
    _add_light(block, workspace, pixel, index)


@kernel
def begin_sample(block, workspace, pixel):
    """Count a sample of a pixel, and add the surfaces that the camera sees to passes. With ``end_sample`` later, this
    is ``add_sample``, if no pass has parts of the light."""
    _count(block)[pixel] += 1
    if block.outputs:
        outputs.add_sample(block, workspace, pixel)


@kernel
def end_sample(block, workspace, pixel, index):
    """Add the light of a sample that ``begin_sample`` has counted."""
    if _is_finite(block, workspace, pixel):
        _add_light(block, workspace, pixel, index)


@kernel
def _is_finite(block, workspace, pixel):
    """Whether the workspace's ``sample`` is finite; else it is counted as discarded."""
    sample = sample_table(workspace)[0]
    combined = sample.combined
    total = combined[0] + combined[1] + combined[2] + sample.alpha
    # Not math.isfinite: it subtracts the value from itself, which reassociation folds to zero for a sum.
    if abs(total) < math.inf:
        return True
    _discarded(block)[_KINDS * pixel + (_NAN if math.isnan(total) else _INFINITE)] += 1
    return False


@kernel
def _add_light(block, workspace, pixel, index):
    """Add the workspace's ``sample`` to all but the passes of ``outputs``."""
    sample = sample_table(workspace)[0]
    combined = sample.combined
    sums, half = _combined(block), index & HALF_BIT != 0
    before, lamps = (sample.before, sample.lamps_before) if sample.divided else (combined, sample.lamps)
    at = 4 * pixel
    sums[at] += before[0]
    sums[at + 1] += before[1]
    sums[at + 2] += before[2]
    sums[at + 3] += sample.alpha
    if half:
        _add(_half(block), pixel, before)
    _add(_lamps(block), pixel, lamps)
    squares, divided = _squares(block), _divided(block)
    whole, at = combined[0] + combined[1] + combined[2], SQUARES * pixel
    squares[at] += (before[0] + before[1] + before[2]) ** 2
    squares[at + 1] += whole * whole
    squares[at + 2] += whole
    squares[at + 3] += sample.spread
    at = DIVIDED * pixel
    divided[at] += sample.branches
    divided[at + 1] += sample.branches if half else 0.0
    divided[at + 2] += sample.met
    divided[at + 3] += 1.0 / sample.branches
    divided[at + 4] += sample.cuts
    if sample.divided:
        after = scale(sub(vec(combined), vec(before)), sample.branches)
        _add(_scattered(block), pixel, after)
        if half:
            _add(_scattered_half(block), pixel, after)
        _add(_scattered_lamps(block), pixel, scale(sub(vec(sample.lamps), vec(lamps)), sample.branches))
    _add(_emission(block), pixel, sample.emission)
    _add(_environment(block), pixel, sample.environment)
    _add(_diffuse_albedo(block), pixel, sample.diffuse_albedo)
    if sample.found:
        surfaces = _surfaces(block)
        _add(_normal(block), pixel, sample.normal)
        _add(_albedo(block), pixel, sample.albedo)
        if surfaces[pixel] == 0:
            _put(_position(block), pixel, sample.position)
            depth = _depth(block)
            if len(depth) > 0:
                depth[pixel] = sample.depth
        surfaces[pixel] += 1


@kernel
def samples_due(block, pixel, samples):
    """Indices (first, end) of the next samples of a pixel, so that pixels of rate 1 have ``samples`` then."""
    first = np.int64(_count(block)[pixel])
    return first, max(np.int64(samples * _rate(block)[pixel] + 0.5), 1, first)


@kernel
def samples_had(block, pixel):
    """The number of samples that pixels of rate 1 have at least, by those of this pixel."""
    return max(np.int64((_count(block)[pixel] - 0.5) / _rate(block)[pixel]), 0)


@kernel
def branches_of(block, pixel):
    """Number of branches of a pixel's paths."""
    return np.int64(_branches(block)[pixel])


@kernel
def branches_before(block, pixel):
    """Number of branches that the paths of a pixel had."""
    return np.int64(_divided(block)[DIVIDED * pixel])
