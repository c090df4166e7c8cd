# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that Blender knows this package by, each computed here alone."""

_INNER = __package__.rpartition(".")[0]

ROOT = _INNER.rpartition(".")[0] or _INNER
"""Package of the add-on: Blender's key for preferences and user folders. As an extension ``bl_ext.<repository>.<id>``;
``sdf_lights`` where the package is imported without an add-on around it, as tests and scripts do."""

IS_EXTENSION = ROOT.startswith("bl_ext.")

ENGINE = "SDF_LIGHTS"
LABEL = "SDF Lights"

NODE_TREE = "SDFLIGHTS_NodeTree"
BESIDE_GROUP = "Lamps beside Cycles"
"""Light group of all lamps of a scene whose picture is added to that of Cycles."""
