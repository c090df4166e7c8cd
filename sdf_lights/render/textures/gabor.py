# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Gabor Texture: Lagae et al. 2009, "Procedural noise using sparse Gabor convolution", with the sampling and
the weights of Tavernier et al. 2019, "Making Gabor noise fast and normalized", and the phase of Tricard et al. 2019,
"Procedural phasor noise".

``KERNELS[dimensions](coordinates …, frequency, anisotropy, direction …) -> (value, phase, intensity)``; the direction
is an angle from the x axis in two dimensions, a vector in three.

The impulses of a cell are a loop without branches or calls, which compilers vectorise: polynomials replace the
exponential and the trigonometric functions.
"""

import math

import numpy as np

from ...jit import kernel
from ...vec import normalize
from .hashing import bits, hash_3, hash_4, unit

_IMPULSES = 8  # of a cell

# Six standard deviations of a sum of as many impulses with weights ±1, each with the mean square of a kernel.
_SPREAD_2D = 6.0 * math.sqrt(0.5 * _IMPULSES * 0.25)
_SPREAD_3D = 6.0 * math.sqrt(0.5 * _IMPULSES * 0.25 / math.sqrt(2.0))


def _polynomial(function, degree: int, end: float) -> tuple[float, ...]:
    """Coefficients, the highest first, of a polynomial that approximates a function from 0 to ``end``: to 1e-8 with
    those below."""
    fitted = np.polynomial.Chebyshev.interpolate(function, degree, (0.0, end)).convert(kind=np.polynomial.Polynomial)
    return tuple(map(float, fitted.coef[::-1]))


# A Gaussian times a Hann window, as a function of the squared distance. Beyond 1 it is 0.
_E10, _E9, _E8, _E7, _E6, _E5, _E4, _E3, _E2, _E1, _E0 = _polynomial(
    lambda square: np.exp(-np.pi * square) * (0.5 + 0.5 * np.cos(np.pi * square)), 10, 1.0
)
# As a function of the square of a number of turns up to a half.
_C7, _C6, _C5, _C4, _C3, _C2, _C1, _C0 = _polynomial(lambda q: np.cos(2.0 * np.pi * np.sqrt(q)), 7, 0.25)
_S7, _S6, _S5, _S4, _S3, _S2, _S1, _S0 = _polynomial(
    lambda q: 2.0 * np.pi * np.sinc(2.0 * np.sqrt(np.maximum(q, 0.0))), 7, 0.25
)


@kernel
def _envelope(square):
    s = square if square < 1.0 else 1.0
    low = (((_E4 * s + _E3) * s + _E2) * s + _E1) * s + _E0
    return (((((_E10 * s + _E9) * s + _E8) * s + _E7) * s + _E6) * s + _E5) * (s * s * s * s * s) + low


@kernel
def _cosine(turns):
    turns -= math.floor(turns + 0.5)
    q = turns * turns
    return ((((((_C7 * q + _C6) * q + _C5) * q + _C4) * q + _C3) * q + _C2) * q + _C1) * q + _C0


@kernel
def _sine(turns):
    turns -= math.floor(turns + 0.5)
    q = turns * turns
    return (((((((_S7 * q + _S6) * q + _S5) * q + _S4) * q + _S3) * q + _S2) * q + _S1) * q + _S0) * turns


@kernel
def _outputs(cosine, sine, spread):
    phase = (math.atan2(sine, cosine) + math.pi) * (0.5 / math.pi)
    return 0.5 * sine / spread + 0.5, phase, math.sqrt(cosine * cosine + sine * sine) / spread


@kernel
def _cell_2d(i, j, x, y, frequency, isotropy, turn):
    """Sum over the impulses of the cell (i, j) at a point relative to the cell's corner: cosine and sine part.

    ``turn``: the direction, in turns.
    """
    column, row = bits(i), bits(j)
    cosine, sine = 0.0, 0.0
    for impulse in range(_IMPULSES):
        place = bits(3 * impulse + 1)
        dx, dy = x - unit(hash_3(column, row, place)), y - unit(hash_3(place, column, row))
        around = turn + isotropy * 0.5 * (unit(hash_3(column, row, bits(3 * impulse))) - 0.5)
        along = frequency * (dx * _cosine(around) + dy * _sine(around))
        size = _envelope(dx * dx + dy * dy)
        size = -size if unit(hash_3(column, row, bits(3 * impulse + 2))) < 0.5 else size
        cosine += size * _cosine(along)
        sine += size * _sine(along)
    return cosine, sine


@kernel
def _gabor_2d(x, y, frequency, anisotropy, angle):
    frequency, isotropy = max(0.001, frequency), 1.0 - min(max(0.0, anisotropy), 1.0)
    turn = angle * (0.5 / math.pi)
    i, j = int(math.floor(x)), int(math.floor(y))
    x, y = x - i, y - j
    cosine, sine = 0.0, 0.0
    for b in range(-1, 2):
        for a in range(-1, 2):
            more = _cell_2d(i + a, j + b, x - a, y - b, frequency, isotropy, turn)
            cosine += more[0]
            sine += more[1]
    return _outputs(cosine, sine, _SPREAD_2D)


@kernel
def _cell_3d(i, j, k, x, y, z, frequency, isotropy, polar, azimuth):
    """As ``_cell_2d``, with the direction from the z axis and about it in turns."""
    column, row, layer = bits(i), bits(j), bits(k)
    cosine, sine = 0.0, 0.0
    for impulse in range(_IMPULSES):
        place, seed, weight = bits(3 * impulse + 1), bits(3 * impulse), bits(3 * impulse + 2)
        dx, dy, dz = (
            x - unit(hash_4(column, row, layer, place)),
            y - unit(hash_4(layer, column, place, row)),
            z - unit(hash_4(place, layer, row, column)),
        )
        tilt = polar + isotropy * 0.5 * unit(hash_4(column, row, layer, seed))
        turn = azimuth + isotropy * 0.5 * unit(hash_4(layer, column, seed, row))
        u, v, w = _sine(tilt) * _cosine(turn), _sine(tilt) * _sine(turn), _cosine(tilt)
        along = frequency * (dx * u + dy * v + dz * w)
        size = _envelope(dx * dx + dy * dy + dz * dz)
        size = -size if unit(hash_4(column, row, layer, weight)) < 0.5 else size
        cosine += size * _cosine(along)
        sine += size * _sine(along)
    return cosine, sine


@kernel
def _gabor_3d(x, y, z, frequency, anisotropy, direction_x, direction_y, direction_z):
    frequency, isotropy = max(0.001, frequency), 1.0 - min(max(0.0, anisotropy), 1.0)
    u, v, w = normalize((direction_x, direction_y, direction_z))
    polar = math.acos(min(max(-1.0, w), 1.0)) * (0.5 / math.pi)
    azimuth = math.atan2(v, u) * (0.5 / math.pi)
    i, j, k = int(math.floor(x)), int(math.floor(y)), int(math.floor(z))
    x, y, z = x - i, y - j, z - k
    cosine, sine = 0.0, 0.0
    for c in range(-1, 2):
        for b in range(-1, 2):
            for a in range(-1, 2):
                more = _cell_3d(i + a, j + b, k + c, x - a, y - b, z - c, frequency, isotropy, polar, azimuth)
                cosine += more[0]
                sine += more[1]
    return _outputs(cosine, sine, _SPREAD_3D)


KERNELS = {2: _gabor_2d, 3: _gabor_3d}
