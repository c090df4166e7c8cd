# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections to light paths, which the CPU traces: see ``interfaces.LightPathTracer``."""

from __future__ import annotations

from ...jit import kernel
from ..kernels.light_paths.records import MOST_NODES, MOST_TOPS, TABLES
from ..kernels.path import NOWHERE
from .streamed import StreamedTables

# Another set of light paths comes for other samples. No program depends on the numbers of vertices.
ROWS = {"light_path_nodes": MOST_NODES, "light_path_tops": MOST_TOPS, "light_path_vertices": 0}


def streamed() -> StreamedTables:
    """The tables that ``LightPathTracer.use`` gives."""
    return StreamedTables({name: (TABLES[name], most) for name, most in ROWS.items()})


@kernel
def may_connect_again(block, path):
    """Replaces ``integrator.may_connect_again``. Paths do not split here, so any surface may be the first one that is
    connected."""
    return block.light_path_follows or path.connects == NOWHERE
