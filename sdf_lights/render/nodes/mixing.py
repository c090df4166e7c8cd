# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Mix node and its blending modes, as in Cycles."""

from __future__ import annotations

from collections.abc import Callable

from ...graph.formula import Formula, Vector, maximum, minimum, select
from .color_models import hsv_to_rgb, rgb_to_hsv
from .definition import NodeInputs, defines
from .maths import each, saturate, where_zero


def lerp(t: Formula, a: Formula, b: Formula) -> Formula:
    """Linear interpolation from a (t = 0) to b (t = 1)."""
    return a + t * (b - a)


def _overlay(t: Formula, a: Formula, b: Formula) -> Formula:
    dark = a * (1.0 - t + 2.0 * t * b)
    return select(a < 0.5, dark, 1.0 - (1.0 - t + 2.0 * t * (1.0 - b)) * (1.0 - a))


def _dodge(t: Formula, a: Formula, b: Formula) -> Formula:
    rest = 1.0 - t * b
    return where_zero(a, a, select(rest <= 0.0, 1.0, minimum(a / rest, 1.0)))


def _burn(t: Formula, a: Formula, b: Formula) -> Formula:
    rest = 1.0 - t + t * b
    return select(rest <= 0.0, 0.0, saturate(1.0 - (1.0 - a) / rest))


# By component: (factor, a, b) → result.
BLENDS: dict[str, Callable[[Formula, Formula, Formula], Formula]] = {
    "MIX": lambda t, a, b: (1.0 - t) * a + t * b,
    "DARKEN": lambda t, a, b: lerp(t, a, minimum(a, b)),
    "MULTIPLY": lambda t, a, b: a * (1.0 - t + t * b),
    "BURN": _burn,
    "LIGHTEN": lambda t, a, b: lerp(t, a, maximum(a, b)),
    "SCREEN": lambda t, a, b: 1.0 - (1.0 - t + t * (1.0 - b)) * (1.0 - a),
    "DODGE": _dodge,
    "ADD": lambda t, a, b: a + t * b,
    "OVERLAY": _overlay,
    "SOFT_LIGHT": lambda t, a, b: (1.0 - t) * a + t * a * ((1.0 - a) * b + 1.0 - (1.0 - b) * (1.0 - a)),
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2.0 * b - 1.0),
    "DIFFERENCE": lambda t, a, b: lerp(t, a, abs(a - b)),
    "EXCLUSION": lambda t, a, b: maximum(lerp(t, a, a + b - 2.0 * a * b), 0.0),
    "SUBTRACT": lambda t, a, b: a - t * b,
    "DIVIDE": lambda t, a, b: where_zero(b, a, (1.0 - t) * a + t * a / b),
}


def _with_hue(t: Formula, a: Vector, b: Vector, saturated: bool) -> Vector:
    """a with the hue of b, and its saturation too; unchanged if b is grey."""
    of_a, of_b = rgb_to_hsv(a), rgb_to_hsv(b)
    other = hsv_to_rgb(Vector(of_b.x, of_b.y if saturated else of_a.y, of_a.z))
    return Vector(*(where_zero(of_b.y, x, lerp(t, x, y)) for x, y in zip(a, other)))


def _saturation(t: Formula, a: Vector, b: Vector) -> Vector:
    of_a = rgb_to_hsv(a)
    other = hsv_to_rgb(Vector(of_a.x, (1.0 - t) * of_a.y + t * rgb_to_hsv(b).y, of_a.z))
    return Vector(*(where_zero(of_a.y, x, y) for x, y in zip(a, other)))


def _value(t: Formula, a: Vector, b: Vector) -> Vector:
    of_a = rgb_to_hsv(a)
    return hsv_to_rgb(Vector(of_a.x, of_a.y, (1.0 - t) * of_a.z + t * b.greatest()))


HUE_BLENDS: dict[str, Callable[[Formula, Vector, Vector], Vector]] = {
    "HUE": lambda t, a, b: _with_hue(t, a, b, False),
    "SATURATION": _saturation,
    "COLOR": lambda t, a, b: _with_hue(t, a, b, True),
    "VALUE": _value,
}

BLEND_TYPES = (*BLENDS, *HUE_BLENDS)

# Blends that clamp their result even with a factor of 0. Cycles leaves out all other nodes whose factor is 0.
_NEVER_LEFT_OUT = {"LIGHTEN", "DODGE", "BURN"}


def blended(node: NodeInputs, sockets: tuple[str, str, str], clamps_factor: bool, clamps_result: bool) -> Vector:
    """Mix of two colours; ``sockets`` are those of the factor and the colours."""
    kind = node.setting("blend_type")
    if kind not in BLEND_TYPES:
        node.report(f"the blending mode {kind} is not known, so it is Mix")
        kind = "MIX"
    factor, a, b = sockets
    varies = node.is_linked(a) or node.is_linked(b)
    left_out = varies and not node.is_linked(factor) and kind not in _NEVER_LEFT_OUT
    t, a, b = node.number(factor), node.color(a), node.color(b)
    t = saturate(t) if clamps_factor else t
    result = HUE_BLENDS[kind](t, a, b) if kind in HUE_BLENDS else each(lambda *x: BLENDS[kind](t, *x), a, b)
    if left_out:
        result = each(lambda x, y: where_zero(t, x, y), a, result)
    return each(saturate, result) if clamps_result else result


@defines("ShaderNodeMix", modes=("FLOAT", "VECTOR", *BLEND_TYPES))
def mix(node: NodeInputs):
    """Numbers, vectors with one factor or three, and colours in all blending modes. Rotations give A, because no
    material uses them."""
    kind, clamps = node.setting("data_type"), node.setting("clamp_factor")
    if kind == "RGBA":
        color = blended(node, ("Factor_Float", "A_Color", "B_Color"), clamps, node.setting("clamp_result"))
        return {"Result_Color": color}
    if kind == "VECTOR":
        uniform = node.setting("factor_mode") == "UNIFORM"
        factor = node.number("Factor_Float") if uniform else node.vector("Factor_Vector")
        factor = factor if isinstance(factor, Vector) else Vector(factor, factor, factor)
        factor = each(saturate, factor) if clamps else factor
        return {"Result_Vector": each(BLENDS["MIX"], factor, node.vector("A_Vector"), node.vector("B_Vector"))}
    if kind == "ROTATION":
        node.report("rotations are not mixed, so it gives A")
        return {"Result_Rotation": node.vector("A_Rotation")}
    factor = node.number("Factor_Float")
    factor = saturate(factor) if clamps else factor
    return {"Result_Float": BLENDS["MIX"](factor, node.number("A_Float"), node.number("B_Float"))}


@defines("ShaderNodeMixRGB", modes=BLEND_TYPES)
def mix_rgb(node: NodeInputs):
    """The node of older files, in all blending modes."""
    return {"Color": blended(node, ("Fac", "Color1", "Color2"), True, node.setting("use_clamp"))}
