# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of this package in Blender, each computed only here."""

_INNER = __package__.rpartition(".")[0]

ROOT = _INNER.rpartition(".")[0] or _INNER
"""Package of the add-on: Blender's key for preferences and user folders. For an extension it is
``bl_ext.<repository>.<id>``; it is ``sdf_lights`` if the package is imported without an add-on, as in tests and
scripts."""

IS_EXTENSION = ROOT.startswith("bl_ext.")

ENGINE = "SDF_LIGHTS"
LABEL = "SDF Lights"

NODE_TREE = "SDFLIGHTS_NodeTree"
BESIDE_GROUP = "Lamps beside Cycles"
"""Light group of all lamps in a scene whose picture is added to that of Cycles."""
