# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hue, saturation, and value or lightness of colours, as formulas. All components are in [0, 1] for colours in
gamut."""

from __future__ import annotations

from ...graph.formula import Formula, Vector, floor, minimum, select
from .maths import saturate, where_equal, where_zero


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
