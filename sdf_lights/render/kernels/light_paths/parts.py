# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with light paths."""

from __future__ import annotations

import numpy as np

from ....jit import CallablePart
from . import apart, connections, tree

KERNELS = {
    apart.CHOOSE: tree.choose,
    apart.CONNECT: connections.connect,
    apart.SHARE: connections.share,
    apart.FORESEE: connections.foresee,
    apart.WEIGH: connections.weigh,
}

_parts: dict[tuple, CallablePart] = {}


def addresses(has_light_paths: bool, records: tuple) -> np.ndarray:
    """The table "light_path_code", for blocks and workspaces of these ``records``. What it points at is kept for good."""
    table = np.zeros(len(apart.PLACES), np.int64)
    if has_light_paths:
        for place, kernel in KERNELS.items():
            key = place, tuple(map(str, records))
            if key not in _parts:
                _parts[key] = CallablePart(kernel, (), 1, records)
            table[place] = _parts[key].address
    return table
