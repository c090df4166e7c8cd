# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with media."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import dispatch, light_rays, stack, travel, varying

# By index: the kernel, and its number of arguments.
KERNELS = {
    dispatch.BOUNDS: (stack.bounds, 1),
    dispatch.ENTER: (travel.enter, 1),
    dispatch.SCATTER: (travel.scatter, 1),
    dispatch.SHADOW: (light_rays.shadow, 8),
    dispatch.LAMP: (light_rays.lamp, 12),
    dispatch.SEEN_LAMP: (light_rays.seen_lamp, 4),
    dispatch.FADE: (travel.fade, 1),
}
# The same for scenes in which some medium varies in space.
VARYING = {
    dispatch.BOUNDS: (stack.bounds, 1),
    dispatch.ENTER: (varying.enter_varying, 1),
    dispatch.SCATTER: (varying.scatter_varying, 1),
    dispatch.SHADOW: (varying.shadow_varying, 8),
    dispatch.LAMP: (varying.lamp_varying, 12),
    dispatch.SEEN_LAMP: (varying.seen_lamp_varying, 4),
    dispatch.FADE: (varying.fade_varying, 1),
}


def addresses(has_media: bool, varies: bool, records: tuple) -> np.ndarray:
    """The table "media_code", for blocks and workspaces of these ``records``; ``varies``: whether some medium does."""
    kernels = (VARYING if varies else KERNELS) if has_media else {}
    return code_tables.addresses(kernels, len(dispatch.PLACES), records)
