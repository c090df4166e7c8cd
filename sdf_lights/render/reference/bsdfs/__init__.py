# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The BSDFs of ``render.bsdfs`` over arrays of points, one module each, found automatically.

``NODES`` of a module has, for a kind of node, the function that adds its lobes: ``add(builder, node, weight)``, for the
``Builder`` of ``materials.py`` and weights (N, 1).
"""

import importlib
import pkgutil

NODES = {
    kind: add
    for item in pkgutil.iter_modules(__path__)
    for kind, add in importlib.import_module(f".{item.name}", __name__).NODES.items()
}
