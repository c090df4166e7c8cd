# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` calls, compiled for scenes with light paths."""

from __future__ import annotations

import numpy as np

from .. import callable_parts
from . import apart, connections, tree

KERNELS = {
    apart.CHOOSE: (tree.choose, 1),
    apart.CONNECT: (connections.connect, 1),
    apart.TAKE: (connections.take, 3),
    apart.FORESEE: (connections.foresee, 1),
    apart.WEIGH: (connections.weigh, 1),
}


def addresses(has_light_paths: bool, records: tuple) -> np.ndarray:
    """The table "light_path_code", for blocks and workspaces of these ``records``."""
    return callable_parts.addresses(KERNELS if has_light_paths else {}, len(apart.PLACES), records)
