# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces on the CPU: materials compiled to tables, shaded, evaluated and sampled by kernels. See README.md."""

import numpy as np

from ...scene import Scene
from ...tables import albedo
from .. import textures
from . import energy, program
from .program import MATERIAL, uv_layers
from .records import CLOSURE, SURFACE, WORKSPACE_COUNTS, WORKSPACE_TABLES
from .scattering import evaluate, has_lobes, sample, transmits
from .surface import shade, transparency

__all__ = [
    "CLOSURE", "MATERIAL", "SURFACE", "TABLES", "WORKSPACE_COUNTS", "WORKSPACE_TABLES", "evaluate", "has_lobes",
    "pack_materials", "sample", "shade", "transmits", "transparency", "uv_layers"]

TABLES = {**program.TABLES, **textures.TABLES, **energy.TABLES}


def pack_materials(scene: Scene) -> dict[str, np.ndarray]:
    """Everything that the kernels here read of a scene: ``TABLES``. See ``program.pack_materials``."""
    return {**program.pack_materials(scene), "albedo": albedo.load()}
