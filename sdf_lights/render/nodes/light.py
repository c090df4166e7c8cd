# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes about the light path and the falloff of light."""

from __future__ import annotations

from ...graph.formula import Formula, constant, floor, maximum, minimum, select
from ..scene import Ray
from .definition import NodeInputs, defines
from .variables import DEPTH, RAY_KIND, RAY_LENGTH, RAY_SINGULAR

_FARTHEST = 3.4028234663852886e38  # Cycles' distance of infinitely far objects: the greatest float32


def _is(kind: Ray) -> Formula:
    """1 if the incoming ray is of that kind, else 0."""
    rest = floor(RAY_KIND * (1.0 / kind))
    return rest - 2.0 * floor(rest * 0.5)


def _distance() -> Formula:
    """A ray from an infinitely distant light, or from the world, has length 0."""
    return select(RAY_LENGTH <= 0.0, _FARTHEST, RAY_LENGTH)


@defines("ShaderNodeLightPath")
def light_path(node: NodeInputs):
    """All outputs. Rays through translucent surfaces count as glossy, like those through glass."""
    camera, shadow, diffuse, transmission, volume = map(
        _is, (Ray.CAMERA, Ray.SHADOW, Ray.DIFFUSE, Ray.TRANSMISSION, Ray.VOLUME)
    )
    glossy = maximum(_is(Ray.GLOSSY), transmission)
    reflection = minimum(maximum(diffuse, _is(Ray.GLOSSY)), 1.0 - transmission)
    # Cycles counts one more bounce for sampled light, shadow rays, and rays to the world and to lights.
    further = constant(1.0)
    if node.setting("domain") not in ("WORLD", "LIGHT"):
        further = select(RAY_KIND <= 0.0, 1.0, shadow)
    depth, diffuse_depth, glossy_depth, transmission_depth, transparent_depth = DEPTH
    return {
        "Is Camera Ray": camera,
        "Is Shadow Ray": shadow,
        "Is Diffuse Ray": diffuse,
        "Is Glossy Ray": glossy,
        "Is Singular Ray": RAY_SINGULAR,
        "Is Reflection Ray": reflection,
        "Is Transmission Ray": transmission,
        "Is Volume Scatter Ray": volume,
        "Ray Length": _distance(),
        "Ray Depth": depth + further,
        "Diffuse Depth": diffuse_depth,
        "Glossy Depth": glossy_depth,
        "Transparent Depth": transparent_depth,
        "Transmission Depth": transmission_depth,
        "Portal Depth": constant(0.0),
    }


@defines("ShaderNodeLightFalloff")
def light_falloff(node: NodeInputs):
    """All outputs. An infinitely distant light keeps its strength."""
    strength, smooth = node.number("Strength"), maximum(node.number("Smooth"), 0.0)
    squared = RAY_LENGTH * RAY_LENGTH
    smoothed = select(smooth <= 0.0, strength, strength * squared / (smooth + squared))

    def output(falloff: Formula) -> Formula:
        return select(RAY_LENGTH <= 0.0, strength, smoothed * falloff)

    return {"Quadratic": output(constant(1.0)), "Linear": output(RAY_LENGTH), "Constant": output(squared)}
