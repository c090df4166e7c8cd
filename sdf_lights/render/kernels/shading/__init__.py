# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces: materials compiled to tables; kernels shade, evaluate and sample them. See README.md."""

import numpy as np

from ...scene import Scene
from ...tables import albedo, sheen
from .. import textures
from . import energy, material_compiler, material_records, special
from .caustics import SCALARS
from .graphs import Graphs
from .material_records import MATERIAL, NO_GRAPH, WITH_SHEEN
from .records import CLOSURE, SURFACE, WORKSPACE_COUNTS, WORKSPACE_TABLES
from .scattering import evaluate, has_lobes, sample, transmits
from .special_lobes import LOBE_SHEEN
from .surface import shade, transparency

__all__ = [
    "CLOSURE",
    "Graphs",
    "MATERIAL",
    "NO_GRAPH",
    "SCALARS",
    "SURFACE",
    "TABLES",
    "WORKSPACE_COUNTS",
    "WORKSPACE_TABLES",
    "evaluate",
    "has_lobes",
    "pack_materials",
    "sample",
    "shade",
    "transmits",
    "transparency",
]

TABLES = {**material_records.TABLES, **textures.TABLES, **energy.TABLES, **special.TABLES}


def pack_materials(scene: Scene) -> tuple[dict[str, np.ndarray], Graphs]:
    """All tables of a scene that these kernels read: ``TABLES`` except the addresses of its graphs, which come from
    ``graphs.addresses`` and ``special.addresses``. See ``material_compiler.pack_materials``."""
    tables, graphs = material_compiler.pack_materials(scene)
    lobes = tables["lobes"]
    fibers = np.any((lobes["kind"] == LOBE_SHEEN) | (lobes["features"] & WITH_SHEEN != 0))
    looked_up = {"albedo": albedo.load(), "sheen": sheen.load().ravel() if fibers else np.zeros(1)}
    return {**tables, **looked_up, **special.tables(lobes)}, graphs
