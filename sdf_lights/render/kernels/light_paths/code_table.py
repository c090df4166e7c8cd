# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with light paths."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import connections, dispatch, tree

KERNELS = {
    dispatch.CHOOSE: tree.choose,
    dispatch.CONNECT: connections.connect,
    dispatch.SHARE: connections.share,
    dispatch.FORESEE: connections.foresee,
    dispatch.WEIGH: connections.weigh,
}


def addresses(has_light_paths: bool, records: tuple) -> np.ndarray:
    """The table "light_path_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(
        {place: (kernel, 1) for place, kernel in KERNELS.items()} if has_light_paths else {},
        len(dispatch.PLACES),
        records,
    )
