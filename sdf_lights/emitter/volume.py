# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume of a program by columns: the exact length inside along one direction, integrated over the other two.

The columns are skew to the bounding box, so that no face of an axis-aligned shape lies along them: the length is then a
continuous function of the column's place. It is sampled in square strata; each holds two independent estimates, and
the strata where those differ most are divided until the sum is precise enough.

An estimate is two pairs of columns that mirror each other in the stratum's centre: nothing is lost where the length
is linear, so only creases and curvature are left to the error. Their difference measures that error without bias. (The
choice of what to divide looks at the same differences, which favours strata that were lucky; ``SAFETY`` covers it,
as the tests against known volumes confirm.)
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel
from .hashing import following, uniform
from .intervals import rows_needed, solve

SKEW = (0.3819660112501051, 0.2360679774997897)  # of a column: x and y it moves by while z crosses the box; 1/φ² and 1/φ³
SAFETY = 4.0  # standard errors that the stated bound is made of
GRID = 24  # strata along each side of the first pass
STRATUM = np.dtype([("u", np.float64), ("v", np.float64), ("width", np.float64), ("height", np.float64),
                    ("first", np.float64), ("second", np.float64)])


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
def _estimate(program, low, size, stratum, state, spans):
    """Integral of the column length over a stratum from four columns, one in each quarter."""
    centre_u, centre_v = stratum.u + 0.5 * stratum.width, stratum.v + 0.5 * stratum.height
    total = 0.0
    for side in range(2):
        state = following(state)
        du = 0.5 * stratum.width * uniform(state)
        state = following(state)
        dv = 0.5 * stratum.height * uniform(state)
        if side == 1:
            dv = -dv
        total += _column(program, low, size, centre_u + du, centre_v + dv, spans)
        total += _column(program, low, size, centre_u - du, centre_v - dv, spans)
    return 0.25 * total * stratum.width * stratum.height


@kernel
def _fill(program, low, size, strata, index, u, v, width, height, state, spans):
    stratum = strata[index]
    stratum.u, stratum.v, stratum.width, stratum.height = u, v, width, height
    stratum.first = _estimate(program, low, size, stratum, state, spans)
    for _ in range(4):
        state = following(state)
    stratum.second = _estimate(program, low, size, stratum, state, spans)
    for _ in range(4):
        state = following(state)
    return state


@kernel
def integrate(program, low, size, strata, grid, accuracy, spans):
    """Volume of a program inside the box (low, size), and the standard error of that estimate.

    ``strata`` is the workspace: an array of ``STRATUM`` whose length limits the work, eight columns a row and step.
    Stops when the standard error is below ``accuracy`` times the volume.
    """
    state = np.uint64(1)
    count = 0
    width, height = (1.0 + SKEW[0]) / grid, (1.0 + SKEW[1]) / grid
    for i in range(grid):
        for j in range(grid):
            u, v = i * width - 0.5 * SKEW[0], j * height - 0.5 * SKEW[1]
            state = _fill(program, low, size, strata, count, u, v, width, height, state, spans)
            count += 1
    while True:
        total, variance = 0.0, 0.0
        for index in range(count):
            stratum = strata[index]
            total += 0.5 * (stratum.first + stratum.second)
            variance += 0.25 * (stratum.first - stratum.second) ** 2
        goal = accuracy * total
        if variance <= goal * goal or count + 3 > len(strata):
            break
        threshold = variance / count
        before = count
        for index in range(before):
            stratum = strata[index]
            if 0.25 * (stratum.first - stratum.second) ** 2 < threshold or count + 3 > len(strata):
                continue
            u, v, width, height = stratum.u, stratum.v, 0.5 * stratum.width, 0.5 * stratum.height
            for part in range(4):
                place = index if part == 0 else count
                count += 0 if part == 0 else 1
                state = _fill(
                    program, low, size, strata, place, u + (part & 1) * width, v + (part >> 1) * height, width, height,
                    state, spans)
    box = size[0] * size[1] * size[2]
    return total * box, np.sqrt(variance) * box


def estimate(program: np.ndarray, low: np.ndarray, high: np.ndarray, accuracy: float = 2e-5) -> tuple[float, float]:
    """Volume of a program, and a bound on its error that holds but for one case in thousands (``SAFETY``).

    ``low`` and ``high`` are the corners of a box around it, in the space the instructions' ``inverse`` starts from. At
    most about 300,000 columns are used; the bound says how far they went. Returns (0, 0) for an empty program.
    """
    size = np.subtract(high, low)
    if not np.all(size > 0.0):
        return 0.0, 0.0
    spans = np.empty((rows_needed(program)[0], 2))
    strata = np.empty(24_000, STRATUM)
    for grid in (GRID, 4 * GRID):  # the finer grid finds what is left where the first one saw nothing
        volume, error = integrate(program, tuple(low), tuple(size), strata, grid, accuracy, spans)
        if volume > 0.0:
            break
    return volume, SAFETY * error
