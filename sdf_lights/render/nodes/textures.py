# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural textures. Those without a hash are formulas; the others call kernels of ``render/textures/``."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...graph.formula import Formula, Vector, atan2, call, clamp, constant, cos, floor, length, maximum, select, sin
from ...graph.functions import Function
from ..textures import gabor, noise, voronoi, white_noise
from ..textures.brick import brick
from .definition import NodeInputs, defines

# Cycles keeps coordinates away from the borders of cells, where rounding would decide.
_BESIDE, _WITHIN = 0.000001, 0.999999
_FULL_TURN = 2.0 * math.pi
_FULL_TURN_SINGLE = 6.2831854820251465  # in single precision


def _grey(value: Formula) -> Vector:
    return Vector(value, value, value)


def _since(node: NodeInputs, *version: int) -> bool:
    """Whether Blender is of this version or newer."""
    return tuple(node.setting("blender_version") or version) >= version


def _coordinates(node: NodeInputs, dimensions: int, scale: Formula | float = 1.0) -> list[Formula]:
    """x, y, z and w, as far as they exist; zeros for the rest."""
    zero = constant(0.0)
    if dimensions == 1:
        return [node.number("W") * scale, zero, zero, zero]
    x, y, z = node.vector("Vector") * scale
    return [x, y, z if dimensions > 2 else zero, node.number("W") * scale if dimensions > 3 else zero]


@defines("ShaderNodeTexNoise")
def noise_texture(node: NodeInputs):
    """All types, in one to four dimensions."""
    dimensions = int(node.setting("noise_dimensions")[0])
    colored = "Color" in node.wanted
    found = Function(
        "noise",
        noise.color(dimensions) if colored else noise.value(dimensions),
        (noise.KINDS[node.setting("noise_type")], int(node.setting("normalize"))),
        3 if colored else 1,
    )
    values = call(
        found,
        *_coordinates(node, dimensions, node.number("Scale")),
        *(node.number(name) for name in ("Detail", "Roughness", "Lacunarity", "Offset", "Gain", "Distortion")),
    )
    return {"Fac": values[0], "Color": Vector(*values) if colored else _grey(values[0])}


@defines("ShaderNodeTexVoronoi")
def voronoi_texture(node: NodeInputs):
    """All features, in one to four dimensions."""
    dimensions = int(node.setting("voronoi_dimensions")[0])
    hashing = voronoi.WHOLE if _since(node, 5, 0) else voronoi.FLOATS
    feature, normalize = node.setting("feature"), int(node.setting("normalize"))
    scale, randomness = node.number("Scale"), node.number("Randomness")
    place = _coordinates(node, dimensions, scale)
    zero = constant(0.0)
    outputs = {"Distance": zero, "Color": _grey(zero), "Position": _grey(zero), "W": zero, "Radius": zero}
    if feature == "N_SPHERE_RADIUS":
        (radius,) = call(Function("voronoi", voronoi.radius(dimensions, hashing)), *place, randomness)
        return outputs | {"Radius": radius}
    octaves = [node.number(name) for name in ("Detail", "Roughness", "Lacunarity")]
    if feature == "DISTANCE_TO_EDGE":
        function = Function("voronoi", voronoi.edge(dimensions, hashing), (normalize,))
        (distance,) = call(function, *place, *octaves, randomness)
        return outputs | {"Distance": distance}
    # In one dimension all metrics are the same.
    metric = voronoi.METRICS[node.setting("distance")] if dimensions > 1 else voronoi.EUCLIDEAN
    kind, static = voronoi.FEATURES[feature], (metric, normalize)
    given = (*place, *octaves, node.number("Smoothness"), node.number("Exponent"), randomness)
    if not node.wanted & {"Color", "Position", "W"}:
        (distance,) = call(Function("voronoi", voronoi.distance(kind, dimensions, hashing), static), *given)
        return outputs | {"Distance": distance}
    distance, r, g, b, *position = call(Function("voronoi", voronoi.cell(kind, dimensions, hashing), static, 8), *given)
    position = [select(abs(scale) <= 0.0, 0.0, value / scale) for value in position]
    if dimensions == 1:
        position = [zero, zero, zero, position[0]]
    return outputs | {
        "Distance": distance,
        "Color": Vector(r, g, b),
        "Position": Vector(*position[:3]),
        "W": position[3],
    }


_AXES = {"X": 0, "Y": 1, "Z": 2}


@defines("ShaderNodeTexWave")
def wave_texture(node: NodeInputs):
    """Bands and rings of all directions and profiles."""
    p = (node.vector("Vector") * node.number("Scale") + _BESIDE) * _WITHIN
    if node.setting("wave_type") == "BANDS":
        axis = _AXES.get(node.setting("bands_direction"))
        place = (p.x + p.y + p.z) * 10.0 if axis is None else p[axis] * 20.0
    else:
        axis = _AXES.get(node.setting("rings_direction"))
        place = length(*(value for index, value in enumerate(p) if index != axis)) * 20.0
    function = Function("noise", noise.free_value(3), (noise.FBM, 1))
    (moved,) = call(
        function,
        *(p * node.number("Detail Scale")),
        0.0,
        node.number("Detail"),
        node.number("Detail Roughness"),
        2.0,
        0.0,
        1.0,
    )
    place = place + node.number("Phase Offset") + node.number("Distortion") * (moved * 2.0 - 1.0)
    profile = node.setting("wave_profile")
    if profile == "SIN":
        value = 0.5 + 0.5 * sin(place - 0.5 * math.pi)
    else:
        turns = place * (1.0 / _FULL_TURN)
        value = turns - floor(turns) if profile == "SAW" else 2.0 * abs(turns - floor(turns + 0.5))
    return {"Fac": value, "Color": _grey(value)}


def _remainder(a: Formula, period: float) -> Formula:
    """The rest of a, with its sign, after removing whole periods."""
    size = abs(a)
    rest = size - period * floor(size * (1.0 / period))
    return select(a < 0.0, -rest, rest)


# For each step: which of x, y and z it changes, the signs of their sum, and the sign of the result.
_TURBULENCE = (
    (1, cos, (1, -1, 1), -1),
    (0, cos, (1, -1, -1), 1),
    (2, sin, (-1, -1, -1), 1),
    (0, cos, (-1, 1, -1), -1),
    (1, sin, (-1, 1, 1), -1),
    (1, cos, (-1, 1, 1), -1),
    (0, cos, (1, 1, 1), 1),
    (2, sin, (1, 1, -1), 1),
    (0, cos, (-1, -1, 1), -1),
    (1, sin, (1, -1, 1), -1),
)


def _signed_sum(values: Sequence[Formula], signs: Sequence[int]) -> Formula:
    x, y, z = (value if sign > 0 else -value for value, sign in zip(values, signs))
    return x + y + z


@defines("ShaderNodeTexMagic")
def magic_texture(node: NodeInputs):
    """Sums of nested sines, with as many levels as the node's depth."""
    scale, strength = node.number("Scale"), node.number("Distortion")
    vector = node.vector("Vector")
    before, after = (scale, 5.0) if _since(node, 5, 2) else (1.0, 5.0 * scale)
    p = [_remainder(value * before, _FULL_TURN_SINGLE) * after for value in vector]
    values = [sin(_signed_sum(p, (1, 1, 1))), cos(_signed_sum(p, (-1, 1, -1))), -cos(_signed_sum(p, (-1, -1, 1)))]
    depth = node.setting("turbulence_depth")
    if depth > 0:
        values = [value * strength for value in values]
    for axis, function, signs, sign in _TURBULENCE[:depth]:
        values[axis] = function(_signed_sum(values, signs)) * (sign * strength)
    whole = select(abs(strength) <= 0.0, 1.0, 2.0 * strength)
    color = Vector(*(0.5 - value / whole for value in values))
    return {"Color": color, "Fac": (color.x + color.y + color.z) * (1.0 / 3.0)}


@defines("ShaderNodeTexChecker")
def checker_texture(node: NodeInputs):
    """Cubes of two colours."""
    p = (node.vector("Vector") * node.number("Scale") + _BESIDE) * _WITHIN
    count = floor(p.x) + floor(p.y) + floor(p.z)
    odd = count - 2.0 * floor(0.5 * count)
    first, second = node.color("Color1"), node.color("Color2")
    color = Vector(*(select(odd < 0.5, b, a) for a, b in zip(first, second)))
    return {"Color": color, "Fac": odd}


@defines("ShaderNodeTexBrick")
def brick_texture(node: NodeInputs):
    """Rows of bricks in the xy plane."""
    x, y, _ = node.vector("Vector") * node.number("Scale")
    sizes = (node.number(name) for name in ("Mortar Size", "Mortar Smooth", "Bias", "Brick Width", "Row Height"))
    rows = (
        node.parameter(float(node.setting(name)))
        for name in ("offset", "offset_frequency", "squash", "squash_frequency")
    )
    tint, mortar = call(Function("brick", brick, (), 2), x, y, *sizes, *rows)
    first, second, between = (node.color(name) for name in ("Color1", "Color2", "Mortar"))
    stone = first + (second - first) * tint
    return {"Color": stone + (between - stone) * mortar, "Fac": mortar}


@defines("ShaderNodeTexGradient")
def gradient_texture(node: NodeInputs):
    """All types."""
    x, y, z = node.vector("Vector")
    kind = node.setting("gradient_type")
    if kind == "LINEAR":
        value = x
    elif kind == "QUADRATIC":
        value = maximum(x, 0.0) * maximum(x, 0.0)
    elif kind == "EASING":
        value = clamp(x, 0.0, 1.0)
        value = value * value * (3.0 - 2.0 * value)
    elif kind == "DIAGONAL":
        value = (x + y) * 0.5
    elif kind == "RADIAL":
        value = atan2(y, x) * (1.0 / _FULL_TURN) + 0.5
    else:
        value = maximum(_WITHIN - length(x, y, z), 0.0)
        value = value * value if kind == "QUADRATIC_SPHERE" else value
    value = clamp(value, 0.0, 1.0)
    return {"Color": _grey(value), "Fac": value}


@defines("ShaderNodeTexWhiteNoise")
def white_noise_texture(node: NodeInputs):
    """A value and a colour for every point of one to four dimensions."""
    dimensions = int(node.setting("noise_dimensions")[0])
    place = _coordinates(node, dimensions)[:dimensions]
    if "Color" not in node.wanted:
        (value,) = call(Function("white_noise", white_noise.VALUE[dimensions]), *place)
        return {"Value": value, "Color": _grey(value)}
    color = call(Function("white_noise", white_noise.COLOR[dimensions], (), 3), *place)
    return {"Value": color[0], "Color": Vector(*color)}


@defines("ShaderNodeTexGabor")
def gabor_texture(node: NodeInputs):
    """In two and three dimensions."""
    dimensions = int(node.setting("gabor_type")[0])
    place = _coordinates(node, dimensions, node.number("Scale"))[:dimensions]
    direction = node.vector("Orientation 3D") if dimensions == 3 else [node.number("Orientation 2D")]
    value, phase, intensity = call(
        Function("gabor", gabor.KERNELS[dimensions], (), 3),
        *place,
        node.number("Frequency"),
        node.number("Anisotropy"),
        *direction,
    )
    return {"Value": value, "Phase": phase, "Intensity": intensity}


@defines("ShaderNodeTexPointDensity")
def point_density(node: NodeInputs):
    """Zero, as without points (until Blender 4.5). Points of an object are not supported."""
    if node.setting("object") is not None:
        node.report("the points of its object are not supported, so its density is zero")
    return {"Color": _grey(constant(0.0)), "Density": constant(0.0)}
