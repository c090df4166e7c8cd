# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``apart.py`` calls, compiled for scenes with curves or spheres."""

from __future__ import annotations

import numpy as np

from ....jit import CallablePart
from . import apart, surface

_parts: dict[tuple, CallablePart] = {}


def addresses(has_strands: bool, records: tuple) -> np.ndarray:
    """The table "strand_code", for blocks and workspaces of these ``records``. The code is kept for ever."""
    table = np.zeros(len(apart.PLACES), np.int64)
    if has_strands:
        key = tuple(map(str, records))
        if key not in _parts:
            _parts[key] = CallablePart(surface.fill, (), 6, records)
        table[apart.FILL] = _parts[key].address
    return table
