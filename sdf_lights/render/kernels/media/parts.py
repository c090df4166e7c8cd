# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with media."""

from __future__ import annotations

import numpy as np

from .. import callable_parts
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


def addresses(has_media: bool, records: tuple) -> np.ndarray:
    """The table "media_code", for blocks and workspaces of these ``records``."""
    return callable_parts.addresses(KERNELS if has_media else {}, len(apart.PLACES), records)
