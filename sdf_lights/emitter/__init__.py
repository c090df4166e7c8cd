# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An SDF lamp as a light: ray intervals, samples and densities. See README.md."""

from .lamps import (
    SCALARS, TABLES, LampError, build_lamp, direction_pdf, doubts, intensity, new_spans, pack_lamps, pack_scalars,
    radiance, sample_direction, trace, unresolved, varies, way_inside)

__all__ = [
    "SCALARS", "TABLES", "LampError", "build_lamp", "direction_pdf", "doubts", "intensity", "new_spans", "pack_lamps",
    "pack_scalars", "radiance", "sample_direction", "trace", "unresolved", "varies", "way_inside"]
