# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes without inputs whose values are constant."""

from __future__ import annotations

from ...graph.formula import Vector
from .definition import NodeInputs, defines


@defines("ShaderNodeValue")
def value(node: NodeInputs):
    """A number."""
    return {"Value": node.own("Value")}


@defines("ShaderNodeRGB")
def rgb(node: NodeInputs):
    """A colour."""
    return {"Color": node.own("Color")}


@defines("FunctionNodeInputVector")
def vector_constant(node: NodeInputs):
    """A vector (since Blender 5.2)."""
    given = tuple(node.setting("vector"))[:3]
    return {"Vector": Vector(*(node.parameter(float(entry)) for entry in (*given, 0.0, 0.0, 0.0)[:3]))}


@defines("FunctionNodeInputInt")
def integer_constant(node: NodeInputs):
    """A whole number (since Blender 5.2)."""
    return {"Integer": node.parameter(float(node.setting("integer")))}


@defines("FunctionNodeInputBool")
def boolean_constant(node: NodeInputs):
    """0 or 1 (since Blender 5.2)."""
    return {"Boolean": node.parameter(float(node.setting("boolean")))}


@defines("GeometryNodeInputSceneTime")
def scene_time(node: NodeInputs):
    """Seconds and frame (since Blender 5.2)."""
    seconds, frame = node.setting("scene_time")
    return {"Seconds": node.parameter(seconds), "Frame": node.parameter(frame)}
