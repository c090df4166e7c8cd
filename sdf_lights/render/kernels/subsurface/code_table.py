# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for scenes with subsurface scattering."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import dispatch, exits, walk

KERNELS = {dispatch.SCATTER: walk.scatter, dispatch.EMERGE: exits.emerge}


def addresses(has_subsurface: bool, records: tuple) -> np.ndarray:
    """The table "subsurface_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(
        {place: (kernel, 1) for place, kernel in KERNELS.items()} if has_subsurface else {},
        len(dispatch.PLACES),
        records,
    )
