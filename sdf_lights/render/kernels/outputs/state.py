# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The first scattering of a path, which its branches inherit."""

from __future__ import annotations

from ....jit import kernel
from ...settings import MOST_BRANCHES
from ..path import FIRST_BRANCH, path_table
from .records import LOBES, first_scattering_table

# Rows: those of paths, and one for light rays from the first scattering.
LIGHT_RAY = FIRST_BRANCH + MOST_BRANCHES


@kernel
def keep_first_scattering(block, workspace, row):
    """Store the first scattering of the path with the other state of a branch."""
    if block.outputs & LOBES:
        first_scattering_table(workspace)[row] = first_scattering_table(workspace)[0]


@kernel
def use_first_scattering(block, workspace, row):
    """Restore the first scattering of path number ``row``."""
    if block.outputs & LOBES:
        first_scattering_table(workspace)[0] = first_scattering_table(workspace)[row]


@kernel
def scattered_in_medium(block, workspace, row):
    """Record that a medium scatters the path, or, in row ``LIGHT_RAY``, its light ray, if nothing has scattered it
    before."""
    if block.outputs & LOBES and path_table(workspace)[0].bounce == 0:
        first_scattering_table(workspace)[row].in_medium = 1
