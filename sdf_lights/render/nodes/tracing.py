# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that trace rays from the surface. The rays are those of ``kernels/probes.py``."""

from __future__ import annotations

from ...graph.formula import Formula, Vector, call, constant, select
from ...graph.functions import Function
from ..kernels import probes
from .definition import WITHOUT_SURFACE, NodeInputs, defines
from .geometry import ZERO
from .normals import unit_or
from .variables import NORMAL, POSITION, as_vector

OCCLUSION = [
    Function("occlusion", probes.occlusion, (local,), 1, scene=True, of_object=True, traces=True) for local in (0, 1)
]
"""(distance, samples, direction) → the open fraction; selected by whether only the object itself counts."""
BEVEL = Function("bevel", probes.bevel, (), 3, scene=True, of_object=True, traces=True)
"""(radius, samples, normal) → mean normal."""
RAYCAST = [
    Function("raycast", probes.raycast, (local,), 10, scene=True, of_object=True, traces=True) for local in (0, 1)
]
"""(origin, direction, length, point of the surface) → the results of ``probes.raycast``."""


def _has_rays(node: NodeInputs) -> bool:
    """Worlds, lights and volumes are no surfaces."""
    return node.setting("domain") not in WITHOUT_SURFACE


@defines("ShaderNodeAmbientOcclusion")
def ambient_occlusion(node: NodeInputs):
    """Both outputs, with *Inside* and *Only Local*. A distance of zero means the distance in the world's settings."""
    free: Formula = constant(1.0)
    if _has_rays(node):
        distance = node.number("Distance")
        if not node.is_linked("Distance"):
            distance = select(distance <= 0.0, node.parameter(float(node.setting("occlusion_distance"))), distance)
        direction = node.normal("Normal") * (-1.0 if node.setting("inside") else 1.0)
        samples = node.parameter(float(node.setting("samples")))
        (free,) = call(OCCLUSION[bool(node.setting("only_local"))], distance, samples, *direction)
    return {"Color": node.color("Color") * free, "AO": free}


@defines("ShaderNodeBevel")
def bevel(node: NodeInputs):
    """Mean normals around the point, of the same object. Widely scattered rays see no bevel, as in Cycles."""
    if not _has_rays(node):
        return {"Normal": NORMAL}
    found = as_vector(call(BEVEL, node.number("Radius"), node.parameter(float(node.setting("samples"))), *NORMAL))
    if not node.is_given("Normal"):
        return {"Normal": found}
    return {"Normal": unit_or(node.vector("Normal") + (found - NORMAL), NORMAL)}


@defines("ShaderNodeRaycast")
def raycast(node: NodeInputs):
    """All outputs except attributes, with *Only Local* (since Blender 5.1)."""
    attributes = {name: constant(0.0) for name in node.wanted if name.startswith("Attribute_")}
    if attributes:
        node.report("attributes that its rays read are not supported, so they are zero")
    origin = node.vector("Position") if node.is_given("Position") else POSITION
    direction, distance = node.normal("Direction"), node.number("Length")
    if not _has_rays(node):
        return {
            "Is Hit": constant(0.0),
            "Self Hit": constant(0.0),
            "Hit Distance": distance,
            "Hit Position": ZERO,
            "Hit Normal": ZERO,
            **attributes,
        }
    found = call(RAYCAST[bool(node.setting("only_local"))], *origin, *direction, distance, *POSITION)
    place = origin + direction * found[2]
    return {
        "Is Hit": found[0],
        "Self Hit": found[1],
        "Hit Distance": found[2],
        "Hit Position": Vector(*(axis * found[0] for axis in place)),
        "Hit Normal": Vector(*found[3:6]),
        **attributes,
    }
