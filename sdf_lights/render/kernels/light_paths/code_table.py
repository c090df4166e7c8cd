# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with light paths."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import connections, dispatch, tree

KERNELS = {
    dispatch.CHOOSE: (tree.choose, 1),
    dispatch.CONNECT: (connections.connect, 1),
    dispatch.CONNECT_AGAIN: (connections.connect_again, 1),
    dispatch.RECORD_CONNECTED: (connections.record_connected, 3),
    dispatch.PATH_WEIGHT: (connections.estimated_path_weight, 1),
    dispatch.APPLY_PATH_WEIGHT: (connections.apply_path_weight, 1),
}


def addresses(has_light_paths: bool, records: tuple) -> np.ndarray:
    """The table "light_path_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(KERNELS if has_light_paths else {}, len(dispatch.PLACES), records)
