# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An SDF lamp as a light: ray intervals, samples and densities. See README.md."""

from .building.build import LampError, build_lamp
from .building.pack import new_spans, pack_lamps, pack_scalars
from .building.remarks import doubts, unresolved
from .lamps import SCALARS, TABLES, attenuated_radiance, intensity, radiance, trace, varies
from .sampling.projection import direction_pdf, interior_offset, sample_direction

__all__ = [
    "SCALARS",
    "TABLES",
    "LampError",
    "attenuated_radiance",
    "build_lamp",
    "direction_pdf",
    "doubts",
    "intensity",
    "new_spans",
    "pack_lamps",
    "pack_scalars",
    "radiance",
    "sample_direction",
    "trace",
    "unresolved",
    "varies",
    "interior_offset",
]
