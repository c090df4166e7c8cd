# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The IES Texture."""

from __future__ import annotations

import numpy as np

from ...graph.formula import call
from ...graph.functions import Function
from ...jit import kernel, table
from .. import ies
from .definition import NodeInputs, defines

_constants = table("constants", np.float64)


@kernel
def _ies(block, workspace, place, x, y, z):
    return ies.intensity(_constants(block), int(place), (x, y, z))


IES = Function("ies", _ies, (), 1, scene=True)
"""(place, x, y, z) → intensity; ``place`` is a parameter that is a ``Table`` of ``ies.numbers_of``."""


@defines("ShaderNodeTexIES")
def ies_texture(node: NodeInputs):
    """Intensity by direction, from a text of the file or from disk. ``ies_text`` is a setting that sync makes."""
    strength = node.number("Strength")
    try:
        numbers = ies.numbers_of(node.setting("ies_text") or "", node.setting("blender_version") >= (5, 0))
    except ies.IESError as error:
        node.report(f"its IES file cannot be read, as {error}; choose another. It shines alike in all directions")
        return {"Fac": strength * ies.WITHOUT_FILE}
    (intensity,) = call(IES, node.table(numbers[:, None]), *node.vector("Vector"))
    return {"Fac": strength * intensity}
