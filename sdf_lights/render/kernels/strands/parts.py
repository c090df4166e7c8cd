# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``apart.py`` calls, compiled for scenes with curves or spheres."""

from __future__ import annotations

import numpy as np

from .. import callable_parts
from . import apart, surface


def addresses(has_strands: bool, records: tuple) -> np.ndarray:
    """The table "strand_code", for blocks and workspaces of these ``records``."""
    return callable_parts.addresses({apart.FILL: (surface.fill, 6)} if has_strands else {}, len(apart.PLACES), records)
