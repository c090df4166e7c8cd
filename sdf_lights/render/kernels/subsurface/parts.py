# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with subsurface scattering."""

from __future__ import annotations

import numpy as np

from ....jit import CallablePart
from . import apart, exits, walk

KERNELS = {apart.SCATTER: walk.scatter, apart.EMERGE: exits.emerge}

_parts: dict[tuple, CallablePart] = {}


def addresses(has_subsurface: bool, records: tuple) -> np.ndarray:
    """The table "subsurface_code", for blocks and workspaces of these ``records``. The code is kept for ever."""
    table = np.zeros(len(apart.PLACES), np.int64)
    if has_subsurface:
        for place, kernel in KERNELS.items():
            key = place, tuple(map(str, records))
            if key not in _parts:
                _parts[key] = CallablePart(kernel, (), 1, records)
            table[place] = _parts[key].address
    return table
