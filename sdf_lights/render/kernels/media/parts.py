# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with media."""

from __future__ import annotations

import numpy as np

from ....jit import CallablePart
from . import apart, light_rays, stack, travel

# By index: the kernel, and its number of arguments.
KERNELS = {
    apart.BOUNDS: (stack.bounds, 1),
    apart.ENTER: (travel.enter, 1),
    apart.SCATTER: (travel.scatter, 1),
    apart.SHADOW: (light_rays.shadow, 8),
    apart.LAMP: (light_rays.lamp, 12),
    apart.SEEN_LAMP: (light_rays.seen_lamp, 4),
}

_parts: dict[tuple, CallablePart] = {}


def addresses(has_media: bool, records: tuple) -> np.ndarray:
    """The table "media_code", for blocks and workspaces of these ``records``. The code is kept for ever."""
    table = np.zeros(len(apart.PLACES), np.int64)
    if has_media:
        for place, (kernel, count) in KERNELS.items():
            key = place, tuple(map(str, records))
            if key not in _parts:
                _parts[key] = CallablePart(kernel, (), count, records)
            table[place] = _parts[key].address
    return table
