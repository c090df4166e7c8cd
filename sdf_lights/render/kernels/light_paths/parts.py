# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with light paths."""

from __future__ import annotations

import numpy as np

from .. import callable_parts
from . import apart, connections, tree

KERNELS = {
    apart.CHOOSE: tree.choose,
    apart.CONNECT: connections.connect,
    apart.SHARE: connections.share,
    apart.FORESEE: connections.foresee,
    apart.WEIGH: connections.weigh,
}


def addresses(has_light_paths: bool, records: tuple) -> np.ndarray:
    """The table "light_path_code", for blocks and workspaces of these ``records``."""
    return callable_parts.addresses(
        {place: (kernel, 1) for place, kernel in KERNELS.items()} if has_light_paths else {}, len(apart.PLACES), records
    )
