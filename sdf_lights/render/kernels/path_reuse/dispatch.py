# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of path reuse, which is compiled separately, as in ``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Places of the addresses, which are 0 where paths do not share.
PLACES = ARRIVE, EVALUATE, CONNECT_POINTS, DENSITY = range(4)

_code = table("path_reuse_code", np.int64)


@kernel
def arrive(block, workspace):
    """See ``arrivals.arrive``."""
    call_part(_code(block)[ARRIVE], block, workspace, (0.0,), 1)


@kernel
def evaluate_arrival(block, workspace, wi, kinds, ray):
    """See ``arrivals.evaluate_arrival``."""
    found = call_part(_code(block)[EVALUATE], block, workspace, (wi[0], wi[1], wi[2], kinds, ray), 5)
    return (found[0], found[1], found[2]), found[3], found[4]


@kernel
def connect_points(block, workspace):
    """See ``vertices.connect_points``."""
    call_part(_code(block)[CONNECT_POINTS], block, workspace, (0.0,), 1)


@kernel
def density_of_vertices(block, workspace):
    """See ``vertices.density_of_vertices``."""
    return call_part(_code(block)[DENSITY], block, workspace, (0.0,), 1)[0]
