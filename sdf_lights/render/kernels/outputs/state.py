# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a path was scattered first, which its branches take along."""

from __future__ import annotations

from ....jit import kernel
from ...settings import MOST_BRANCHES
from ..path import FIRST_BRANCH, path_table
from .records import LOBES, first_scattering_table

# Rows: as those of paths, and one for light rays from where a path scatters first.
LIGHT_RAY = FIRST_BRANCH + MOST_BRANCHES


@kernel
def keep_first_scattering(block, workspace, row):
    """Keep how the path was scattered first with the other state of a branch."""
    if block.outputs & LOBES:
        first_scattering_table(workspace)[row] = first_scattering_table(workspace)[0]


@kernel
def use_first_scattering(block, workspace, row):
    """Make how path number ``row`` was scattered first that of the path itself."""
    if block.outputs & LOBES:
        first_scattering_table(workspace)[0] = first_scattering_table(workspace)[row]


@kernel
def scattered_in_medium(block, workspace, row):
    """Note that a medium scatters the path, or, in row ``LIGHT_RAY``, its light ray, where nothing has scattered it before."""
    if block.outputs & LOBES and path_table(workspace)[0].bounce == 0:
        first_scattering_table(workspace)[row].in_medium = 1
