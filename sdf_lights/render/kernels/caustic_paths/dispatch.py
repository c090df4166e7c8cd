# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of what paths from the camera leave to caustic paths, which is compiled separately, as in
``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Places of the addresses, which are 0 where a scene has no caustic paths.
PLACES = FOLLOW, LEFT_TO_PATH, MEET, LEFT_TO_VERTEX = range(4)

_code = table("caustic_code", np.int64)


@kernel
def follow(block, workspace, wi, pdf, kind):
    """See ``weights.follow``."""
    call_part(_code(block)[FOLLOW], block, workspace, (wi[0], wi[1], wi[2], pdf, kind), 1)


@kernel
def left_to_path(block, workspace, lamp, count, t_to):
    """See ``weights.left_to_path``."""
    return call_part(_code(block)[LEFT_TO_PATH], block, workspace, (lamp, count, t_to), 1)[0]


@kernel
def meet(block, workspace):
    """See ``weights.meet``."""
    call_part(_code(block)[MEET], block, workspace, (0.0,), 1)


@kernel
def left_to_vertex(block, workspace, wi, pdf, pdf_there):
    """See ``weights.left_to_vertex``."""
    return call_part(_code(block)[LEFT_TO_VERTEX], block, workspace, (wi[0], wi[1], wi[2], pdf, pdf_there), 1)[0]
