# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel and layer weight nodes: how reflective a surface is for the view."""

from __future__ import annotations

from ...graph.formula import Formula, clamp, maximum, power, select, sqrt
from .definition import NodeInputs, defines
from .variables import BACKFACING, INCOMING, where

_LEAST = 1e-5  # Cycles' minimum of indices and similar values


def dielectric(cosine: Formula, eta: Formula) -> Formula:
    """Reflectance of a dielectric for unpolarised light (Fresnel), of index ``eta`` relative to the near side."""
    c = abs(cosine)
    squared = eta * eta - 1.0 + c * c
    g = sqrt(maximum(squared, 0.0))
    across = (g - c) / (g + c)
    ratio = (c * (g + c) - 1.0) / (c * (g - c) + 1.0)
    return select(squared <= 0.0, 1.0, 0.5 * across * across * (1.0 + ratio * ratio))


@defines("ShaderNodeFresnel")
def fresnel(node: NodeInputs):
    """From outside and inside."""
    eta = maximum(node.number("IOR"), _LEAST)
    cosine = INCOMING.dot(node.normal("Normal"))
    return {"Fac": dielectric(cosine, where(BACKFACING, 1.0 / eta, eta))}


@defines("ShaderNodeLayerWeight")
def layer_weight(node: NodeInputs):
    """Both outputs."""
    blend, cosine = node.number("Blend"), INCOMING.dot(node.normal("Normal"))
    eta = maximum(1.0 - blend, _LEAST)
    share = clamp(blend, 0.0, 1.0 - _LEAST)
    exponent = select(share < 0.5, 2.0 * share, 0.5 / (1.0 - share))
    return {
        "Fresnel": dielectric(cosine, where(BACKFACING, eta, 1.0 / eta)),
        "Facing": 1.0 - power(abs(cosine), exponent),
    }
