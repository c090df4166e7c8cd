# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute with colours, or make them from a temperature or a wavelength.

Colours are linear, in the working space of the file. Values are clamped to 0 and 1 only where Cycles' node does that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...graph.formula import Formula, Vector, call, constant, floor, maximum, minimum, power, select
from . import lookups
from .definition import NodeInputs, defines
from .maths import each, fraction, saturate, where_equal, where_zero

# From CIE XYZ with the white of D65 to linear Rec. 709, as in Blender before 5.0. Later matrices are rounded
# differently.
_REC709 = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)

# To the linear working spaces of files since then: ITU-R BT.709 and BT.2020, and ACEScg (S-2014-004, adapted to D65 by
# Bradford's method).
WORKING_SPACES = {
    "Linear Rec.709": np.array(
        [[3.2409699, -1.5373832, -0.4986108], [-0.9692436, 1.8759675, 0.0415551], [0.0556301, -0.2039770, 1.0569715]]
    ),
    "Linear Rec.2020": np.array(
        [[1.7166512, -0.3556708, -0.2533663], [-0.6666844, 1.6164812, 0.0157685], [0.0176399, -0.0427706, 0.9421031]]
    ),
    "ACEScg": np.linalg.inv(
        [[0.652238, 0.128237, 0.169983], [0.267672, 0.674340, 0.057988], [-0.005382, 0.001369, 1.093071]]
    ),
}


def xyz_to_rgb(working_space: str | None) -> np.ndarray:
    """(3, 3) matrix from XYZ to the working space of that name; to Rec. 709 if there is none."""
    return WORKING_SPACES.get(working_space, _REC709)


def luminance_weights(working_space: str | None) -> tuple[float, ...]:
    """Weights of red, green and blue of the working space in the luminance."""
    return tuple(np.linalg.inv(xyz_to_rgb(working_space))[1].tolist())


def luminance(node: NodeInputs, color: Vector) -> Formula:
    """Luminance of a linear colour of the working space."""
    return color.dot(luminance_weights(node.setting("working_space")))


# --- hue --------------------------------------------------------------------------------------------------------------


def _hue(color: Vector, most: Formula, range_: Formula) -> Formula:
    """Hue, 0 to 1, of a colour that is not grey."""
    r, g, b = color
    red, green, blue = (g - b) / range_, 2.0 + (b - r) / range_, 4.0 + (r - g) / range_
    h = select(most <= r, select(red < 0.0, red + 6.0, red), select(most <= g, green, blue))
    return h * (1.0 / 6.0)


def rgb_to_hsv(color: Vector) -> Vector:
    """Smith 1978, "Color gamut transform pairs". With negative components the saturation may be any number."""
    most, least = color.greatest(), color.least()
    range_ = most - least
    saturation = where_zero(most, 0.0, where_equal(least, most, 0.0, range_ / most))
    return Vector(where_zero(saturation, 0.0, _hue(color, most, range_)), saturation, most)


def hsv_to_rgb(color: Vector) -> Vector:
    """Hues outside 0 to 1 are those of the last sixth."""
    hue, saturation, value = color
    h = where_zero(hue - 1.0, 0.0, hue) * 6.0
    share = h - floor(h)
    low, falling = value * (1.0 - saturation), value * (1.0 - saturation * share)
    rising = value * (1.0 - saturation * (1.0 - share))
    sixths = [
        (value, rising, low),
        (falling, value, low),
        (low, value, rising),
        (low, falling, value),
        (rising, low, value),
    ]
    result = (value, low, falling)
    for index, sixth in reversed(list(enumerate(sixths))):
        result = tuple(select(h < index + 1.0, a, b) for a, b in zip(sixth, result))
    return Vector(*(select(h < 0.0, a, b) for a, b in zip((value, low, falling), result)))


def rgb_to_hsl(color: Vector) -> Vector:
    """Hue, saturation, lightness; the saturation is at most 1."""
    most, least = color.greatest(), color.least()
    range_, total = most - least, most + least
    lightness = minimum(1.0, total * 0.5)
    saturation = range_ / select(lightness <= 0.5, total, 2.0 - total)
    return Vector(*(where_equal(least, most, 0.0, a) for a in (_hue(color, most, range_), saturation)), lightness)


def hsl_to_rgb(color: Vector) -> Vector:
    """RGB of hue, saturation and lightness, all in [0, 1]."""
    hue, saturation, lightness = color
    h = hue * 6.0
    pure = abs(h - 3.0) - 1.0, 2.0 - abs(h - 2.0), 2.0 - abs(h - 4.0)
    chroma = (1.0 - abs(2.0 * lightness - 1.0)) * saturation
    return Vector(*((saturate(component) - 0.5) * chroma + lightness for component in pure))


# --- mixing -----------------------------------------------------------------------------------------------------------


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


# --- light ------------------------------------------------------------------------------------------------------------

# Cycles' fit to the colour of a black body of luminance 1 in Rec. 709, up to each temperature: red and green are a / t
# + b·t + c, blue is ((a·t + b)·t + c)·t + d.
_COLDEST, _HOTTEST = 800.0, 12000.0
_BELOW = (5.413294490189271, -0.20319390035873933, -0.0822535242887164)
_ABOVE = (0.8262954810464208, 0.9945080501520986, 1.566307710274283)
_BLACKBODY = (
    (
        965.0,
        (1.61919106e03, -2.05010916e-03, 5.02995757e00),
        (-4.88999748e02, 6.04330754e-04, -7.55807526e-02),
        (5.96945309e-11, -4.85742887e-08, -9.70622247e-05, -4.07936148e-03),
    ),
    (
        1167.0,
        (2.48845471e03, -1.11330907e-03, 3.22621544e00),
        (-7.55994277e02, 3.16730098e-04, 4.78306139e-01),
        (2.40430366e-11, 5.55021075e-08, -1.98503712e-04, 2.89312858e-02),
    ),
    (
        1449.0,
        (3.34143193e03, -4.86551192e-04, 1.76486769e00),
        (-1.02363977e03, 1.20223470e-04, 9.36662319e-01),
        (-1.40949732e-11, 1.89878968e-07, -3.56632824e-04, 9.10767778e-02),
    ),
    (
        1902.0,
        (4.09461742e03, -1.27446582e-04, 7.25731635e-01),
        (-1.26571316e03, 4.87340896e-06, 1.27054498e00),
        (-3.61460868e-11, 2.84822009e-07, -4.93211319e-04, 1.56723440e-01),
    ),
    (
        3315.0,
        (4.67028036e03, 2.91258199e-05, 1.26703442e-01),
        (-1.42529332e03, -4.01150431e-05, 1.43972784e00),
        (-1.97075738e-11, 1.75359352e-07, -2.50542825e-04, -2.22783266e-02),
    ),
    (
        6365.0,
        (4.59509185e03, 2.87495649e-05, 1.50345020e-01),
        (-1.17554822e03, -2.16378048e-05, 1.30408023e00),
        (-1.61997957e-13, -1.64216008e-08, 3.86216271e-04, -7.38077418e-01),
    ),
    (
        _HOTTEST,
        (3.78717450e03, 9.35907826e-06, 3.99075871e-01),
        (-5.00799571e02, -4.59832026e-06, 1.09098763e00),
        (6.72650283e-13, -2.73078809e-08, 4.24098264e-04, -7.52335691e-01),
    ),
)


def blackbody_rec709(t: Formula) -> Vector:
    """Colour of a black body at t kelvins, of luminance 1, clamped to 800 and 12000 K; negative out of gamut."""

    def coefficient(channel: int, index: int) -> Formula:
        *others, (_, *last) = _BLACKBODY
        value = constant(last[channel][index])
        for end, *row in reversed(others):
            value = select(t < end, row[channel][index], value)
        return value

    red, green = (coefficient(k, 0) / t + coefficient(k, 1) * t + coefficient(k, 2) for k in (0, 1))
    a, b, c, d = (coefficient(2, index) for index in range(4))
    inside = Vector(red, green, ((a * t + b) * t + c) * t + d)
    return Vector(
        *(
            select(t < _COLDEST, below, select(t < _HOTTEST, value, above))
            for below, value, above in zip(_BELOW, inside, _ABOVE)
        )
    )


def transformed(matrix: np.ndarray, vector: Vector) -> Vector:
    """A matrix (3, 3) of numbers times a vector."""
    return Vector(*(vector.dot(row) for row in matrix.tolist()))


@defines("ShaderNodeBlackbody")
def blackbody(node: NodeInputs):
    """800 to 12000 K."""
    to_working_space = xyz_to_rgb(node.setting("working_space")) @ np.linalg.inv(_REC709)
    color = transformed(to_working_space, blackbody_rec709(node.number("Temperature")))
    return {"Color": each(lambda a: maximum(a, 0.0), color)}


# Colour matching functions of the CIE 1931 standard observer (CIE 15), 380 to 780 nm in steps of 5 nm, times 10000.
_FIRST, _STEP = 380.0, 5.0
_MATCHING = (
    np.array(
        [
            [
                14,
                22,
                42,
                76,
                143,
                232,
                435,
                776,
                1344,
                2148,
                2839,
                3285,
                3483,
                3481,
                3362,
                3187,
                2908,
                2511,
                1954,
                1421,
                956,
                580,
                320,
                147,
                49,
                24,
                93,
                291,
                633,
                1096,
                1655,
                2257,
                2904,
                3597,
                4334,
                5121,
                5945,
                6784,
                7621,
                8425,
                9163,
                9786,
                10263,
                10567,
                10622,
                10456,
                10026,
                9384,
                8544,
                7514,
                6424,
                5419,
                4479,
                3608,
                2835,
                2187,
                1649,
                1212,
                874,
                636,
                468,
                329,
                227,
                158,
                114,
                81,
                58,
                41,
                29,
                20,
                14,
                10,
                7,
                5,
                3,
                2,
                2,
                1,
                1,
                1,
                0,
            ],
            [
                0,
                1,
                1,
                2,
                4,
                6,
                12,
                22,
                40,
                73,
                116,
                168,
                230,
                298,
                380,
                480,
                600,
                739,
                910,
                1126,
                1390,
                1693,
                2080,
                2586,
                3230,
                4073,
                5030,
                6082,
                7100,
                7932,
                8620,
                9149,
                9540,
                9803,
                9950,
                10000,
                9950,
                9786,
                9520,
                9154,
                8700,
                8163,
                7570,
                6949,
                6310,
                5668,
                5030,
                4412,
                3810,
                3210,
                2650,
                2170,
                1750,
                1382,
                1070,
                816,
                610,
                446,
                320,
                232,
                170,
                119,
                82,
                57,
                41,
                29,
                21,
                15,
                10,
                7,
                5,
                4,
                2,
                2,
                1,
                1,
                1,
                0,
                0,
                0,
                0,
            ],
            [
                65,
                105,
                201,
                362,
                679,
                1102,
                2074,
                3713,
                6456,
                10391,
                13856,
                16230,
                17471,
                17826,
                17721,
                17441,
                16692,
                15281,
                12876,
                10419,
                8130,
                6162,
                4652,
                3533,
                2720,
                2123,
                1582,
                1117,
                782,
                573,
                422,
                298,
                203,
                134,
                87,
                57,
                39,
                27,
                21,
                18,
                17,
                14,
                11,
                10,
                8,
                6,
                3,
                2,
                2,
                1,
            ]
            + [0] * 31,
        ]
    ).T
    * 1e-4
)
_BRIGHTEST = 2.52  # Cycles divides by it, so no colour exceeds 1 by much


@defines("ShaderNodeWavelength")
def wavelength(node: NodeInputs):
    """380 to 780 nm, black elsewhere."""
    rows = len(_MATCHING)
    colors = _MATCHING @ xyz_to_rgb(node.setting("working_space")).T / _BRIGHTEST
    row = (node.number("Wavelength") - _FIRST) * (1.0 / _STEP)
    found = call(lookups.table_of(3, extrapolates=True), node.table(colors), rows, row * (1.0 / (rows - 1)))[:3]
    # Cycles rounds towards zero, so the table starts one step below the first wavelength.
    visible = maximum(-1.0 - row, row - (rows - 1.0))
    return {"Color": Vector(*(select(visible < 0.0, maximum(a, 0.0), 0.0) for a in found))}
