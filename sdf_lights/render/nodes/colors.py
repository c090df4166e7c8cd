# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute with colours: they adjust, split and combine them.

Colours are linear, in the working space of the file. Values are clamped to 0 and 1 only where Cycles' node does that.
"""

from __future__ import annotations

from collections.abc import Callable

from ...graph.formula import Vector, maximum, power, select
from .color_models import hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv
from .definition import NodeInputs, defines
from .maths import each, fraction, saturate, where_zero
from .working_space import luminance

# --- adjusting --------------------------------------------------------------------------------------------------------


@defines("ShaderNodeHueSaturation")
def hue_saturation(node: NodeInputs):
    """Hue, saturation and value, with a factor. The result is not negative."""
    color, factor = node.color("Color"), node.number("Fac")
    hue, saturation, value = rgb_to_hsv(color)
    hue = fraction(hue + node.number("Hue") + 0.5)
    saturation = saturate(saturation * node.number("Saturation"))
    changed = hsv_to_rgb(Vector(hue, saturation, value * node.number("Value")))
    return {"Color": each(lambda a, b: maximum(factor * b + (1.0 - factor) * a, 0.0), color, changed)}


@defines("ShaderNodeBrightContrast")
def bright_contrast(node: NodeInputs):
    """Brightness and contrast. The result is not negative."""
    contrast = node.number("Contrast")
    gain, offset = 1.0 + contrast, node.number("Bright") - contrast * 0.5
    return {"Color": each(lambda a: maximum(gain * a + offset, 0.0), node.color("Color"))}


@defines("ShaderNodeGamma")
def gamma(node: NodeInputs):
    """The colour to a power, component by component; components that are not positive stay unchanged."""
    exponent = node.number("Gamma")
    return {
        "Color": each(lambda a: where_zero(exponent, 1.0, select(0.0 < a, power(a, exponent), a)), node.color("Color"))
    }


@defines("ShaderNodeInvert")
def invert(node: NodeInputs):
    """One minus the colour, with a factor."""
    factor = node.number("Fac")
    return {"Color": each(lambda a: factor * (1.0 - a) + (1.0 - factor) * a, node.color("Color"))}


@defines("ShaderNodeRGBToBW")
def rgb_to_bw(node: NodeInputs):
    """The luminance."""
    return {"Val": luminance(node, node.color("Color"))}


# --- parts ------------------------------------------------------------------------------------------------------------

SEPARATIONS: dict[str, Callable[[Vector], Vector]] = {"RGB": lambda c: c, "HSV": rgb_to_hsv, "HSL": rgb_to_hsl}
COMBINATIONS: dict[str, Callable[[Vector], Vector]] = {"RGB": lambda c: c, "HSV": hsv_to_rgb, "HSL": hsl_to_rgb}


@defines("ShaderNodeSeparateColor", modes=SEPARATIONS)
def separate_color(node: NodeInputs):
    """A colour's components, or its hue, saturation, and value or lightness."""
    return dict(zip(("Red", "Green", "Blue"), SEPARATIONS[node.setting("mode")](node.color("Color"))))


@defines("ShaderNodeCombineColor", modes=COMBINATIONS)
def combine_color(node: NodeInputs):
    """A colour from its components, or from hue, saturation, and value or lightness."""
    parts = Vector(*(node.number(name) for name in ("Red", "Green", "Blue")))
    return {"Color": COMBINATIONS[node.setting("mode")](parts)}


@defines("ShaderNodeSeparateRGB")
def separate_rgb(node: NodeInputs):
    """The node of older files."""
    return dict(zip("RGB", node.color("Image")))


@defines("ShaderNodeCombineRGB")
def combine_rgb(node: NodeInputs):
    """The node of older files."""
    return {"Image": Vector(*map(node.number, "RGB"))}


@defines("ShaderNodeSeparateHSV")
def separate_hsv(node: NodeInputs):
    """The node of older files."""
    return dict(zip("HSV", rgb_to_hsv(node.color("Color"))))


@defines("ShaderNodeCombineHSV")
def combine_hsv(node: NodeInputs):
    """The node of older files."""
    return {"Color": hsv_to_rgb(Vector(*map(node.number, "HSV")))}


@defines("ShaderNodeSeparateXYZ")
def separate_xyz(node: NodeInputs):
    """A vector's components."""
    return dict(zip("XYZ", node.vector("Vector")))


@defines("ShaderNodeCombineXYZ")
def combine_xyz(node: NodeInputs):
    """A vector from its components."""
    return {"Vector": Vector(*map(node.number, "XYZ"))}
