# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the kernels for subsurface scattering, which are compiled separately, as in ``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Indices of the addresses, which are 0 if light enters no surface of a scene.
PLACES = SCATTER, EMERGE = range(2)

TABLES = {"subsurface_code": np.dtype(np.int64)}
_code = table("subsurface_code", np.int64)


@kernel
def scatter(block, workspace):
    """See ``walk.scatter``."""
    return call_part(_code(block)[SCATTER], block, workspace, (0.0,), 1)[0] > 0.0


@kernel
def emerge(block, workspace):
    """See ``exits.emerge``."""
    call_part(_code(block)[EMERGE], block, workspace, (0.0,), 1)
