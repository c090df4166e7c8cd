# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make a colour from a temperature or a wavelength, in the working space of the file."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Formula, Vector, call, constant, maximum, select
from . import lookups
from .definition import NodeInputs, defines
from .maths import each
from .working_space import REC709, transformed, xyz_to_rgb

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


def blackbody_in(working_space: str | None, t: Formula) -> Vector:
    """``blackbody_rec709`` in the working space of a file; negative out of gamut."""
    return transformed(xyz_to_rgb(working_space) @ np.linalg.inv(REC709), blackbody_rec709(t))


@defines("ShaderNodeBlackbody")
def blackbody(node: NodeInputs):
    """800 to 12000 K."""
    color = blackbody_in(node.setting("working_space"), node.number("Temperature"))
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
