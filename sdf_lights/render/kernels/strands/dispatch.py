# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the kernels for curves and spheres, which are compiled separately, as in ``media.dispatch``."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Indices of the addresses, which are 0 in a scene with only triangles.
PLACES = (FILL,) = range(1)

TABLES = {"strand_code": np.dtype(np.int64)}
SCALARS = [("has_strands", np.int64)]
_code = table("strand_code", np.int64)


@kernel
def fill(block, workspace, secondary, wo, ray_kind, footprint):
    """See ``surface.fill``."""
    call_part(_code(block)[FILL], block, workspace, (secondary, wo[0], wo[1], wo[2], ray_kind, footprint), 1)
