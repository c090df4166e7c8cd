# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes with a curve or a colour ramp, which is sampled into a table with as many rows as in Cycles."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Formula, Vector, call, floor
from . import lookups
from .definition import NodeInputs, defines
from .maths import saturate

ROWS = 257


@defines("ShaderNodeValToRGB", modes=("EASE", "CARDINAL", "LINEAR", "B_SPLINE", "CONSTANT"))
def color_ramp(node: NodeInputs):
    """All interpolations and colour modes."""
    ramp, position = node.setting("color_ramp"), node.number("Fac")
    # Blender's HSL ramps are NaN if a colour is brighter than white.
    values = np.nan_to_num([tuple(ramp.evaluate(row / (ROWS - 1))) for row in range(ROWS)], posinf=0.0, neginf=0.0)
    if ramp.interpolation == "CONSTANT":
        position = floor(saturate(position) * (ROWS - 1.0)) * (1.0 / (ROWS - 1))
    r, g, b, a = call(lookups.table_of(4), node.table(values), ROWS, position)
    return {"Color": Vector(r, g, b), "Alpha": a}


def _sampled(node: NodeInputs, columns: int):
    """Look-up of a curve mapping: a function from a number to its value in each of the first curves.

    With one curve more than ``columns``, that curve is applied before each of them.
    """
    mapping = node.setting("mapping")
    mapping.initialize()
    curves = list(mapping.curves)
    ends = [curve.points[end].location[0] for curve in curves for end in (0, len(curve.points) - 1)]
    low, high = min(ends), max(max(ends), min(ends) + 1e-6)
    positions = [low + (high - low) * row / (ROWS - 1) for row in range(ROWS)]
    if len(curves) > columns:
        positions = [mapping.evaluate(curves[columns], position) for position in positions]
    values = np.array([[mapping.evaluate(curve, position) for curve in curves[:columns]] for position in positions])
    look_up = lookups.table_of(columns, mapping.extend == "EXTRAPOLATED")
    start, first, scale = node.table(values), node.parameter(low), node.parameter(1.0 / (high - low))

    def curve(value: Formula) -> tuple[Formula, ...]:
        return call(look_up, start, ROWS, (value - first) * scale)

    return curve


def _mixed(factor: Formula, a: Formula, b: Formula) -> Formula:
    return (1.0 - factor) * a + factor * b


def _by_component(node: NodeInputs, given: Vector) -> Vector:
    curve, factor = _sampled(node, 3), node.number("Fac")
    return Vector(*(_mixed(factor, value, curve(value)[axis]) for axis, value in enumerate(given)))


@defines("ShaderNodeRGBCurve")
def rgb_curves(node: NodeInputs):
    """Combined and single channels, with a factor."""
    return {"Color": _by_component(node, node.color("Color"))}


@defines("ShaderNodeVectorCurve")
def vector_curves(node: NodeInputs):
    """With a factor."""
    return {"Vector": _by_component(node, node.vector("Vector"))}


@defines("ShaderNodeFloatCurve")
def float_curve(node: NodeInputs):
    """With a factor."""
    value = node.number("Value")
    return {"Value": _mixed(node.number("Factor"), value, _sampled(node, 1)(value)[0])}
