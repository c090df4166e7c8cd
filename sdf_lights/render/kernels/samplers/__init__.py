# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sampling patterns: one module each, as in ``interfaces.Sampler``, found by its name.

All kernels draw from one of them, which is chosen when this module is imported. ``SDF_LIGHTS_SAMPLER`` names it, for
comparisons. ``TABLES`` of a module are the arrays that its kernels read.
"""

import importlib
import os
import pkgutil

NAMES = tuple(sorted(item.name for item in pkgutil.iter_modules(__path__)))
NAME = os.environ.get("SDF_LIGHTS_SAMPLER", "sobol")
if NAME not in NAMES:
    raise ImportError(f"SDF_LIGHTS_SAMPLER is '{NAME}', which is not a sampler: set it to one of {', '.join(NAMES)}.")

chosen = importlib.import_module(f".{NAME}", __name__)
TABLES = getattr(chosen, "TABLES", {})
pixel_seed, get_1d, get_2d, get_3d, get_4d = (
    getattr(chosen, name) for name in ("pixel_seed", "get_1d", "get_2d", "get_3d", "get_4d")
)
