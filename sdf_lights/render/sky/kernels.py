# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance of a sky along a direction, from the result of ``model.numbers``.

``values`` is an array in which the sky's numbers begin at ``first``. Directions are used as in Cycles, even if they are
not unit vectors: z is the sine of the elevation.
"""

import math

from ...jit import kernel
from ...vec import add, length, lerp, madd, scale, sub
from .atmosphere import COLUMNS, ROWS
from .colour import REC709_FROM_XYZ
from .model import (
    ANALYTIC_HOSEK,
    ANALYTIC_PREETHAM,
    BESIDE,
    BOTTOM,
    HALF_ANGLE,
    HORIZON,
    LOWEST,
    SHAPES,
    SPAN,
    SUN,
    TABLE,
    TOP,
)

_NEAR_HORIZON = math.cos(0.5 * math.pi - 0.001)  # both analytic models are constant below this elevation
_LIMB = 0.6  # fraction of its radiance that the sun's disc lacks at its edge
_R, _G, _B = (tuple(row) for row in REC709_FROM_XYZ.tolist())


@kernel
def _triple(values, place):
    return (values[place], values[place + 1], values[place + 2])


@kernel
def _sine(d):
    return min(max(d[2], -1.0), 1.0)


@kernel
def _angle_to_sun(values, first, d):
    """Cosine of the angle between the sun and a direction."""
    sun, sine = _triple(values, first + SUN), _sine(d)
    across = math.hypot(d[0], d[1])
    flat = (d[0] * sun[0] + d[1] * sun[1]) / across if across > 0.0 else sun[0]
    return min(max(flat * math.sqrt(1.0 - sine * sine) + sine * sun[2], -1.0), 1.0)


@kernel
def _perez(values, place, cosine, gamma):
    return (
        values[place + 5]
        * (1.0 + values[place] * math.exp(values[place + 1] / cosine))
        * (1.0 + values[place + 2] * math.exp(values[place + 3] * gamma) + values[place + 4] * math.cos(gamma) ** 2)
    )


@kernel
def preetham(values, first, d):
    """Radiance (RGB) of Preetham's sky along d; its numbers begin at ``first`` in ``values``."""
    cosine, gamma = max(_sine(d), _NEAR_HORIZON), math.acos(_angle_to_sun(values, first, d))
    place = first + SHAPES
    high = _perez(values, place, cosine, gamma)
    x, y = _perez(values, place + 6, cosine, gamma), _perez(values, place + 12, cosine, gamma)
    if y == 0.0:
        return (_R[1] * high, _G[1] * high, _B[1] * high)
    x, z = x / y * high, (1.0 - x - y) / y * high
    return (
        _R[0] * x + _R[1] * high + _R[2] * z,
        _G[0] * x + _G[1] * high + _G[2] * z,
        _B[0] * x + _B[1] * high + _B[2] * z,
    )


@kernel
def _hosek_wilkie(values, place, cosine, gamma, cosine_gamma):
    """Contribution of one channel to RGB."""
    a, b, c, d, e = values[place], values[place + 1], values[place + 2], values[place + 3], values[place + 4]
    f, g, h, i = values[place + 5], values[place + 6], values[place + 7], values[place + 8]
    square = cosine_gamma * cosine_gamma
    halo = (1.0 + square) / (1.0 + i * i - 2.0 * i * cosine_gamma) ** 1.5
    value = (
        values[place + 9]
        * (1.0 + a * math.exp(b / (cosine + 0.01)))
        * (c + d * math.exp(e * gamma) + f * square + g * halo + h * math.sqrt(cosine))
    )
    return scale(_triple(values, place + 10), value)


@kernel
def hosek_wilkie(values, first, d):
    """Radiance (RGB) of Hosek and Wilkie's sky along d; its numbers begin at ``first`` in ``values``."""
    cosine, cosine_gamma = max(_sine(d), _NEAR_HORIZON), _angle_to_sun(values, first, d)
    gamma, place = math.acos(cosine_gamma), first + SHAPES
    total = _hosek_wilkie(values, place, cosine, gamma, cosine_gamma)
    total = add(total, _hosek_wilkie(values, place + 13, cosine, gamma, cosine_gamma))
    return add(total, _hosek_wilkie(values, place + 26, cosine, gamma, cosine_gamma))


@kernel
def _row(values, place, column, part):
    return lerp(_triple(values, place + 3 * column), _triple(values, place + 3 * column + 3), part)


@kernel
def tabulated(values, first, d):
    """Bilinear between the elevations and azimuths of ``atmosphere``; components may be below zero."""
    sun, elevation = _triple(values, first + SUN), math.asin(_sine(d))
    azimuth = math.atan2(abs(sun[0] * d[1] - sun[1] * d[0]), sun[0] * d[0] + sun[1] * d[1])
    x = COLUMNS * (1.0 - azimuth / math.pi) - 0.5
    y = 0.5 * ROWS * (1.0 + math.copysign(math.sqrt(abs(elevation) * 2.0 / math.pi), elevation)) - 0.5
    x, y = min(max(x, 0.0), COLUMNS - 1.0), min(max(y, 0.0), ROWS - 1.0)
    column, row = min(int(x), COLUMNS - 2), min(int(y), ROWS - 2)
    place = first + TABLE + 3 * COLUMNS * row
    return lerp(_row(values, place, column, x - column), _row(values, place + 3 * COLUMNS, column, x - column), y - row)


@kernel
def sees_sun(values, first, d):
    """Angle from the middle of the sun's disc, relative to its radius; 2 outside it, or if the ground hides it."""
    half = values[first + HALF_ANGLE]
    if half <= 0.0 or math.asin(_sine(d)) <= values[first + HORIZON]:
        return 2.0
    sun = _triple(values, first + SUN)
    angle = 2.0 * math.atan2(length(sub(d, sun)), length(add(d, sun)))
    return angle / half if angle < half else 2.0


@kernel
def sun_radiance(values, first, d, away):
    """RGB of the sun's disc along a direction for which ``sees_sun`` returns ``away`` < 1."""
    place = first + BOTTOM
    height = (math.asin(_sine(d)) - values[first + LOWEST]) / values[first + SPAN]
    darkening = 1.0 - _LIMB * (1.0 - math.sqrt(max(1.0 - away * away, 0.0)))
    return scale(lerp(_triple(values, place), _triple(values, place + TOP - BOTTOM), height), darkening)


@kernel
def sky_radiance(kind, with_sun, values, first, d):
    """RGB along d, with the sun's disc or without."""
    if kind == ANALYTIC_PREETHAM:
        radiance = preetham(values, first, d)
    elif kind == ANALYTIC_HOSEK:
        radiance = hosek_wilkie(values, first, d)
    else:
        away = sees_sun(values, first, d) if with_sun else 2.0
        radiance = tabulated(values, first, d)
        if away < 1.0:
            radiance = madd(sun_radiance(values, first, d, away), values[first + BESIDE], radiance)
    return (max(radiance[0], 0.0), max(radiance[1], 0.0), max(radiance[2], 0.0))


@kernel
def fill(kind, with_sun, values, directions, radiance):
    """``sky_radiance`` along directions (n, 3), into ``radiance`` (n, 3)."""
    for i in range(directions.shape[0]):
        r, g, b = sky_radiance(kind, with_sun, values, 0, (directions[i, 0], directions[i, 1], directions[i, 2]))
        radiance[i, 0], radiance[i, 1], radiance[i, 2] = r, g, b


@kernel
def fill_map(kind, values, picture):
    """An equirectangular picture (height, width, 3) of the sky without the sun's disc: see ``sky_map``."""
    height, width = picture.shape[0], picture.shape[1]
    for row in range(height):
        latitude = math.pi * ((row + 0.5) / height - 0.5)
        for column in range(width):
            longitude = 2.0 * math.pi * (0.5 - (column + 0.5) / width)
            across = math.cos(latitude)
            d = (across * math.cos(longitude), across * math.sin(longitude), math.sin(latitude))
            r, g, b = sky_radiance(kind, False, values, 0, d)
            picture[row, column, 0], picture[row, column, 1], picture[row, column, 2] = r, g, b
