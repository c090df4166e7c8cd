# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of connections to light paths, which are compiled separately, as in ``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Places of the addresses, which are 0 where a scene has no light paths.
PLACES = CHOOSE, CONNECT, TAKE, FORESEE, WEIGH = range(5)

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
def take(block, workspace, wi):
    """See ``connections.take``."""
    call_part(_code(block)[TAKE], block, workspace, (wi[0], wi[1], wi[2]), 1)


@kernel
def foresee(block, workspace):
    """See ``connections.foresee``."""
    return call_part(_code(block)[FORESEE], block, workspace, (0.0,), 1)[0]


@kernel
def weigh(block, workspace):
    """See ``connections.weigh``."""
    return call_part(_code(block)[WEIGH], block, workspace, (0.0,), 1)[0] > 0.0
