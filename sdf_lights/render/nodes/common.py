# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions that nodes of many materials call, for compiling them in advance."""

from __future__ import annotations

from ...graph.formula import CALL, Formula, Vector, order
from ...graph.functions import Function
from . import lookups
from .definition import node_outputs

_VORONOI = dict(voronoi_dimensions="3D", distance="EUCLIDEAN", normalize=False)

# For each node: its settings, and the outputs that are used together.
_NODES = (
    *(
        ("ShaderNodeTexNoise", dict(noise_dimensions=size, noise_type="FBM", normalize=normalize), (output,))
        for size in ("2D", "3D")
        for normalize in (True, False)
        for output in ("Fac", "Color")
    ),
    *(
        ("ShaderNodeTexVoronoi", dict(_VORONOI, feature=feature), (output,))
        for feature in ("F1", "F2", "SMOOTH_F1")
        for output in ("Distance", "Color")
    ),
    ("ShaderNodeTexVoronoi", dict(_VORONOI, feature="DISTANCE_TO_EDGE"), ("Distance",)),
    ("ShaderNodeTexBrick", dict(offset=0.5, offset_frequency=2, squash=1.0, squash_frequency=2), ("Color",)),
    *(("ShaderNodeTexWhiteNoise", dict(noise_dimensions="3D"), (output,)) for output in ("Value", "Color")),
)


def calls() -> list[tuple[Function, int]]:
    """Each function with its number of operands."""
    found = {(lookups.ATTRIBUTE, 3): None, (lookups.IMAGE, 3): None, (lookups.table_of(4), 3): None}
    for name, settings, wanted in _NODES:
        outputs = node_outputs(name, [], {}, settings, set(wanted))
        for output in wanted:
            found |= {(node.value, len(node.operands)): None for node in _nodes(outputs[output]) if node.kind == CALL}
    return list(found)


def _nodes(output: Formula | Vector) -> list[Formula]:
    return order(*(output if isinstance(output, Vector) else (output,)))
