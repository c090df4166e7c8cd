# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Straight transmission of a light ray through a surface where only the closures know it."""

from ....jit import kernel
from ....vec import vec
from .records import surface_table
from .surface import shade


@kernel
def shaded_transparency(block, workspace, _):
    """RGB that passes straight through ``workspace.surface``."""
    shade(block, workspace)
    return vec(surface_table(workspace)[0].transparency)
