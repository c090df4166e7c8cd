# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with media."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import dispatch, light_rays, stack, travel

# By index: the kernel, and its number of arguments.
KERNELS = {
    dispatch.BOUNDS: (stack.bounds, 1),
    dispatch.ENTER: (travel.enter, 1),
    dispatch.SCATTER: (travel.scatter, 1),
    dispatch.SHADOW: (light_rays.shadow, 8),
    dispatch.LAMP: (light_rays.lamp, 12),
    dispatch.SEEN_LAMP: (light_rays.seen_lamp, 4),
}


def addresses(has_media: bool, records: tuple) -> np.ndarray:
    """The table "media_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(KERNELS if has_media else {}, len(dispatch.PLACES), records)
