# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes that reuse paths."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import arrivals, dispatch, vertices

KERNELS = {dispatch.ARRIVE: (arrivals.arrive, 1), dispatch.EVALUATE: (arrivals.evaluate_arrival, 5)}
WITH_LIGHT_PATHS = {
    dispatch.CONNECT_POINTS: (vertices.connect_points, 1),
    dispatch.DENSITY: (vertices.density_of_vertices, 1),
}


def addresses(reuses_paths: bool, connects: bool, records: tuple) -> np.ndarray:
    """The table "path_reuse_code", for blocks and workspaces of these ``records``."""
    kernels = (KERNELS if reuses_paths else {}) | (WITH_LIGHT_PATHS if reuses_paths and connects else {})
    return code_tables.addresses(kernels, len(dispatch.PLACES), records)
