# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes that reuse paths."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import arrivals, dispatch

KERNELS = {dispatch.ARRIVE: (arrivals.arrive, 1), dispatch.EVALUATE: (arrivals.evaluate_arrival, 5)}


def addresses(reuses_paths: bool, records: tuple) -> np.ndarray:
    """The table "path_reuse_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(KERNELS if reuses_paths else {}, len(dispatch.PLACES), records)
