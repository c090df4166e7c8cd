# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume of a program by columns: the exact length inside along one direction, integrated over the other two.

The columns are skew to the bounding box, so that no face of an axis-aligned shape lies along them: the length is then a
continuous function of the column's place. It is sampled in square strata; each holds two independent estimates, and
the strata where those differ most are divided until the sum is precise enough.

Columns come in pairs that mirror each other in the stratum's centre: nothing is lost where the length is linear, so
only creases and curvature are left to the error. Strata are divided until their pairs promise the accuracy; then all
columns are drawn anew, because strata that were left alone since their pairs happened to agree would bias the sum. The
second draw gives two independent values of every stratum: the volume is unbiased, and so is the error made of their
differences.
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel
from .hashing import following, uniform
from .intervals import rows_needed, solve

SKEW = (0.3819660112501051, 0.2360679774997897)  # what a column moves by in x and y while z crosses the box
SAFETY = 4.0  # standard errors that the stated bound is made of
GRID = 80  # strata along each side of the first pass
MOST_STRATA = 24_000
INHERITED = 1.0 / 32.0  # least part of a stratum's variance that each of its quarters is taken to have
SHARED = 1.0 / 8.0  # least part of a neighbour's variance
STRATUM = np.dtype([("u", np.float64), ("v", np.float64), ("width", np.float64), ("height", np.float64),
                    ("integral", np.float64), ("variance", np.float64)])


@kernel
def _column(program, low, size, u, v, spans):
    """Length inside of the column through (u, v) of the unit box's middle plane, as a part of the box's height."""
    o = (low[0] + u * size[0], low[1] + v * size[1], low[2] + 0.5 * size[2])
    d = (SKEW[0] * size[0], SKEW[1] * size[1], size[2])
    total = 0.0
    for k in range(solve(program, o, d, spans)):
        total += spans[k, 1] - spans[k, 0]
    return total


@kernel
def _pairs(program, low, size, stratum, state, spans):
    """Two estimates of the integral of the length over a stratum, each a pair of columns in opposite quarters of it."""
    centre_u, centre_v = stratum.u + 0.5 * stratum.width, stratum.v + 0.5 * stratum.height
    first, second = 0.0, 0.0
    for side in range(2):
        state = following(state)
        du = 0.5 * stratum.width * uniform(state)
        state = following(state)
        dv = 0.5 * stratum.height * uniform(state) * (1.0 - 2.0 * side)
        pair = _column(program, low, size, centre_u + du, centre_v + dv, spans)
        pair += _column(program, low, size, centre_u - du, centre_v - dv, spans)
        first, second = second, 0.5 * pair * stratum.width * stratum.height
    return first, second, state


@kernel
def _explore(program, low, size, stratum, least, state, spans):
    """First draw: sets the integral, and the variance that the second draw will have."""
    first, second, state = _pairs(program, low, size, stratum, state, spans)
    stratum.integral = 0.5 * (first + second)
    stratum.variance = max(0.125 * (first - second) ** 2, least)
    return state


@kernel
def _measure(program, low, size, stratum, state, spans):
    """Second draw: sets the integral and an unbiased estimate of its variance."""
    first, second, state = _pairs(program, low, size, stratum, state, spans)
    third, fourth, state = _pairs(program, low, size, stratum, state, spans)
    stratum.integral = 0.25 * (first + second + third + fourth)
    stratum.variance = 0.0625 * (first + second - third - fourth) ** 2
    return state


@kernel
def _sums(strata, count):
    integral, variance = 0.0, 0.0
    for index in range(count):
        integral += strata[index].integral
        variance += strata[index].variance
    return integral, variance


@kernel
def _share(strata, index, neighbour):
    strata[index].variance = max(strata[index].variance, SHARED * strata[neighbour].variance)


@kernel
def _spread(strata, grid):
    """Let every stratum of the first grid expect some of its neighbours' variance.

    Creases are curves: where one crosses a stratum it crosses a neighbour too, though a few columns of one may miss it.
    """
    count = grid * grid
    for index in range(count):
        if index % grid < grid - 1:
            _share(strata, index, index + 1)
        if index + grid < count:
            _share(strata, index, index + grid)
    for index in range(count - 1, -1, -1):
        if index % grid > 0:
            _share(strata, index, index - 1)
        if index >= grid:
            _share(strata, index, index - grid)


@kernel
def integrate(program, low, size, strata, grid, accuracy, spans):
    """Volume of a program inside the box (low, size), and the standard error of that estimate.

    ``strata`` is the workspace: an array of ``STRATUM`` whose length limits the work. Strata are divided until the
    standard error is expected to be below ``accuracy`` times the volume.
    """
    state = np.uint64(1)
    count = grid * grid
    for index in range(count):
        stratum = strata[index]
        stratum.width, stratum.height = (1.0 + SKEW[0]) / grid, (1.0 + SKEW[1]) / grid
        stratum.u = index % grid * stratum.width - 0.5 * SKEW[0]
        stratum.v = index // grid * stratum.height - 0.5 * SKEW[1]
        state = _explore(program, low, size, stratum, 0.0, state, spans)
    _spread(strata, grid)
    while True:
        integral, variance = _sums(strata, count)
        if variance <= (accuracy * integral) ** 2 or count + 3 > len(strata):
            break
        threshold = variance / count
        for index in range(count):
            stratum = strata[index]
            if stratum.variance < threshold or count + 3 > len(strata):
                continue
            inherited = INHERITED * stratum.variance
            stratum.width *= 0.5
            stratum.height *= 0.5
            for part in range(1, 4):
                child = strata[count]
                child.width, child.height = stratum.width, stratum.height
                child.u = stratum.u + (part & 1) * stratum.width
                child.v = stratum.v + (part >> 1) * stratum.height
                state = _explore(program, low, size, child, inherited, state, spans)
                count += 1
            state = _explore(program, low, size, stratum, inherited, state, spans)
    for index in range(count):
        state = _measure(program, low, size, strata[index], state, spans)
    integral, variance = _sums(strata, count)
    box = size[0] * size[1] * size[2]
    return integral * box, np.sqrt(variance) * box


def estimate(program: np.ndarray, low: np.ndarray, high: np.ndarray, accuracy: float = 2e-5) -> tuple[float, float]:
    """Volume of a program, and a bound on its error: ``SAFETY`` standard errors, so about one in 10,000 exceeds it.

    ``low`` and ``high`` are the corners of a box around it, in the space the instructions' ``inverse`` starts from. At
    most some 300,000 columns are used; the bound says how far they went. Returns (0, 0) for an empty program.
    """
    size = np.subtract(high, low)
    if not np.all(size > 0.0):
        return 0.0, 0.0
    spans = np.empty((rows_needed(program)[0], 2))
    strata = np.empty(MOST_STRATA, STRATUM)
    volume, error = integrate(program, tuple(low), tuple(size), strata, GRID, accuracy, spans)
    return volume, SAFETY * error
