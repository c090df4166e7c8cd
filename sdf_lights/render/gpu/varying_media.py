# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that vary in space: their grids, which the CPU measures by the machine code of the same formulas, and kernels
for scenes that have no other media, or none of that kind in the world."""

from __future__ import annotations

import numpy as np

from ...jit import fill_table, kernel, new_tables
from ..kernels import path, shading
from ..kernels.media import cells, tracking, varying
from ..kernels.media.grids import fill_grids
from ..kernels.media.records import workspace_counts
from ..kernels.packing import BLOCK, TABLES
from ..kernels.workspace import WORKSPACE, WORKSPACE_TABLES
from ..scene import Scene

# Without sections of rays in the world, the numbers of a ray are few: (module that uses it, name) -> their count.
FEW_NUMBERS = {(module, "LOCAL_RAYS"): cells.WORLD_SECTIONS for module in (tracking, varying)}


def grids_of(
    scene: Scene, tables: dict[str, np.ndarray], scalars: dict[str, float], graphs: shading.Graphs
) -> dict[str, np.ndarray]:
    """The tables of ``fill_grids``. ``tables`` are those of the CPU, as far as formulas and media read them;
    ``graphs``: the formulas."""
    tables = {**tables, "graph_addresses": graphs.addresses((BLOCK, WORKSPACE))}
    tables = {name: np.ascontiguousarray(array).view(TABLES[name]) for name, array in tables.items() if name in TABLES}
    block = _record(BLOCK, tables)
    for name in scalars.keys() & set(BLOCK.names):
        block[name] = scalars[name]
    counts = {**path.COUNTS, **shading.WORKSPACE_COUNTS, **workspace_counts(tables)}
    own, other = (new_tables({name: WORKSPACE_TABLES[name] for name in counts}, counts) for _ in range(2))
    workspace, secondary = _record(WORKSPACE, own), _record(WORKSPACE, other)
    fill_table(workspace, "secondary", secondary)
    return fill_grids(scene, block, workspace, tables)


def _record(dtype: np.dtype, tables: dict[str, np.ndarray]) -> np.ndarray:
    """A block (1,) that points to ``tables``."""
    record = np.zeros(1, dtype)
    for name, table in tables.items():
        fill_table(record, name, table)
    return record


@kernel
def no_sections(block, workspace, medium, start, d, length, step, rays):
    """Replaces ``cells.divide_world_ray`` if the world's medium does not vary."""
    return


@kernel
def no_section_at(rays, t):
    """Replaces ``cells.world_section_at``, likewise."""
    return -1


@kernel
def one_varies(inside):
    """Replaces ``varying.none_varies`` if all media vary."""
    return False
