# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of what curves and spheres need, which is compiled apart, as ``media.apart`` is."""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Places of the addresses, which are 0 where a scene has triangles alone.
PLACES = (FILL,) = range(1)

TABLES = {"strand_code": np.dtype(np.int64)}
SCALARS = [("has_strands", np.int64)]
_code = table("strand_code", np.int64)


@kernel
def fill(block, workspace, secondary, wo, ray_kind, footprint):
    """See ``surface.fill``."""
    call_part(_code(block)[FILL], block, workspace, (secondary, wo[0], wo[1], wo[2], ray_kind, footprint), 1)
