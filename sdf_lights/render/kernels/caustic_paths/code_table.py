# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with caustic paths."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import dispatch, weights

KERNELS = {
    dispatch.FOLLOW: (weights.follow, 5),
    dispatch.LEFT_TO_PATH: (weights.left_to_path, 3),
    dispatch.MEET: (weights.meet, 1),
    dispatch.LEFT_TO_VERTEX: (weights.left_to_vertex, 5),
}


def addresses(has_caustic_paths: bool, records: tuple) -> np.ndarray:
    """The table "caustic_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(KERNELS if has_caustic_paths else {}, len(dispatch.PLACES), records)
