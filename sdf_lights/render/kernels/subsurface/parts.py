# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with subsurface scattering."""

from __future__ import annotations

import numpy as np

from .. import callable_parts
from . import apart, exits, walk

KERNELS = {apart.SCATTER: walk.scatter, apart.EMERGE: exits.emerge}


def addresses(has_subsurface: bool, records: tuple) -> np.ndarray:
    """The table "subsurface_code", for blocks and workspaces of these ``records``."""
    return callable_parts.addresses(
        {place: (kernel, 1) for place, kernel in KERNELS.items()} if has_subsurface else {}, len(apart.PLACES), records
    )
