# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights: one module per kind, found automatically.

A module has ``LIGHTS``: for each type of Blender's lights, its class and the function that reads it from Blender. Their
kernels are the modules of the same names in ``kernels/lights/kinds/``. The reference versions for tests are in
``reference/lights/``.
"""

from __future__ import annotations

import importlib
import pkgutil

from .reading import Kind

KINDS: dict[str, Kind] = {
    name: kind
    for item in pkgutil.iter_modules(__path__)
    for name, kind in getattr(importlib.import_module(f".{item.name}", __name__), "LIGHTS", {}).items()
}
