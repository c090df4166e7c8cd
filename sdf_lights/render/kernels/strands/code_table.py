# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``dispatch.py`` calls, compiled for scenes with curves or spheres."""

from __future__ import annotations

import numpy as np

from .. import code_tables
from . import dispatch, surface


def addresses(has_strands: bool, records: tuple) -> np.ndarray:
    """The table "strand_code", for blocks and workspaces of these ``records``."""
    return code_tables.addresses(
        {dispatch.FILL: (surface.fill, 6)} if has_strands else {}, len(dispatch.PLACES), records
    )
