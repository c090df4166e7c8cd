# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of connections to light paths, which are compiled separately, as in ``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Places of the addresses, which are 0 where a scene has no light paths.
PLACES = CHOOSE, CONNECT, RECORD_CONNECTED, PATH_WEIGHT, APPLY_PATH_WEIGHT, CONNECT_AGAIN = range(6)

_code = table("light_path_code", np.int64)


@kernel
def choose(block, workspace):
    """See ``tree.choose``."""
    call_part(_code(block)[CHOOSE], block, workspace, (0.0,), 1)


@kernel
def connect(block, workspace):
    """See ``connections.connect``."""
    call_part(_code(block)[CONNECT], block, workspace, (0.0,), 1)


@kernel
def connect_again(block, workspace):
    """See ``connections.connect_again``."""
    call_part(_code(block)[CONNECT_AGAIN], block, workspace, (0.0,), 1)


@kernel
def record_connected(block, workspace, wi):
    """See ``connections.record_connected``."""
    call_part(_code(block)[RECORD_CONNECTED], block, workspace, (wi[0], wi[1], wi[2]), 1)


@kernel
def estimated_path_weight(block, workspace):
    """See ``connections.estimated_path_weight``."""
    return call_part(_code(block)[PATH_WEIGHT], block, workspace, (0.0,), 1)[0]


@kernel
def apply_path_weight(block, workspace):
    """See ``connections.apply_path_weight``."""
    return call_part(_code(block)[APPLY_PATH_WEIGHT], block, workspace, (0.0,), 1)[0] > 0.0
