# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of caustic paths: light paths of SDF lamps that only mirrors and sharp glass, or one narrow lobe, scatter
before a surface that the camera sees."""

from __future__ import annotations

import numpy as np

from ....jit import table

# Light (RGB) of a surface at the place (x, y) of the picture, in pixels, times the filter: what it adds to a pixel,
# before ``weight``. ``ratio`` is that of the densities of both strategies, which ``weight`` is made of. The path has
# been aimed at the target with this number, or −1.
RECORD = np.dtype(
    [("x", "f8"), ("y", "f8"), ("light", "f8", 3), ("weight", "f8"), ("ratio", "f8"), ("target", "i8")], align=True
)

# A ball around mirrors, sharp glass and narrow lobes. ``lines``: how many paths of a set cross a place there towards
# lamps, per étendue (1/(m² sr)), as an estimate; and ``lamp_pdf``, the density (1/sr) with which a light ray from
# there finds a point of a lamp.
TARGET = np.dtype([("position", "f8", 3), ("radius", "f8"), ("lines", "f8"), ("lamp_pdf", "f8")], align=True)

MOST_MIRRORS = 12  # between lamp and surface
# Of a material: caustic paths do not know its mirrors; or do where a look from the other side finds them, too; or do;
# and it may have narrow lobes besides.
UNKNOWN, MAY_DIFFER, KNOWN, NARROW = range(4)
BY_LOBE = -1  # value of ``path.caustic``
TARGETS = 48  # at most
UNAIMED = 0.15  # share of paths that start in any direction, so that no mirror is left out

TABLES = {
    "caustic_targets": TARGET,  # balls around mirrors and glass
    "caustic_chances": np.dtype(np.float64),  # of each target, for each lamp
    "caustic_power": np.dtype(np.float64),  # of each lamp and those before it (W), as far as caustic paths start there
    "caustic_density": np.dtype(np.float64),  # of each lamp, 1/m³: how many paths of a set start there; or 0
    "caustic_materials": np.dtype(np.int64),
    "caustic_code": np.dtype(np.int64),
}
SCALARS = [
    ("caustic_paths", np.int64),  # 1: strategy and tables are there
    ("caustic_samples", np.float64),  # of the BSDF at what a pixel sees, for each set of caustic paths
    ("caustic_lobes", np.int64),  # 1: narrow lobes scatter caustic paths, too
]

target_table = table("caustic_targets", TARGET)
chance_table = table("caustic_chances", np.float64)
power_table = table("caustic_power", np.float64)
density_table = table("caustic_density", np.float64)
material_table = table("caustic_materials", np.int64)
