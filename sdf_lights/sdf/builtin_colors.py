# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour functions of the expression language. Colours are vectors of scene-linear red, green and blue (Rec.
709)."""

from __future__ import annotations

from collections.abc import Callable

from .builtin_numbers import where
from .expression_values import Misuse, Scalar, Work, compute, has_field, is_live, kind_of, maximum, minimum, spread
from .functions import COLOURS, FUNCTIONS, Argument, Function, word

MOST_STOPS = 32

COLDEST, HOTTEST = 800.0, 12000.0  # kelvin; Blender's Blackbody node has the same limits


@word(COLOURS, cost=40)
def blackbody(temperature: Scalar):
    """Colour of a glowing body at a temperature in kelvins, from 800 to 12000, as in Blender's node Blackbody.

    Its brightness is always 1: hotter is bluer, not brighter.
    """
    # Krystek 1985, "An algorithm to calculate correlated colour temperature", Color Research & Application 10(1): the
    # chromaticity (u, v) of Planck's spectrum. Converted to Rec. 709 with luminance 1; colours outside the gamut are
    # clipped. It is smooth, so it has tight bounds in the boxes of a lamp. Cycles' fit in pieces, which nodes of
    # materials use (render/nodes/spectra.py), differs from it by 0.003 at most, and by 0.007 at 800 K.
    t = minimum(maximum(temperature, COLDEST), HOTTEST)
    u = (0.860117757 + t * (1.54118254e-4 + t * 1.28641212e-7)) / (1.0 + t * (8.42420235e-4 + t * 7.08145163e-7))
    v = (0.317398726 + t * (4.22806245e-5 + t * 4.20481691e-8)) / (1.0 + t * (t * 1.61456053e-7 - 2.89741816e-5))
    x, z = 1.5 * u / v, 0.5 * (4.0 - u) / v - 5.0
    rows = ((3.2404542, -1.5371385, -0.4985314), (-0.9692660, 1.8760108, 0.0415560), (0.0556434, -0.2040259, 1.0572252))
    return tuple(maximum(a * x + b + c * z, 0.0) for a, b, c in rows)


def _linear(value: Scalar, position: Scalar, above: Scalar) -> Scalar:
    return minimum(maximum((value - position) / maximum(above - position, 1e-9), 0.0), 1.0)


def _ease(value: Scalar, position: Scalar, above: Scalar) -> Scalar:
    t = _linear(value, position, above)
    return t * t * (3.0 - 2.0 * t)


def _constant(value: Scalar, position: Scalar, above: Scalar) -> Scalar:
    return where(value < above, 0.0, 1.0)


def _ramp(name: str, between: Callable, description: str) -> None:
    """Adds a colour ramp. ``between`` returns how far, from 0 to 1, a value is from one stop's colour to the next."""
    usage = f"{name}(value, position, colour, position, colour, …)"

    def call(slots: Work, *given):
        value, stops = given[0], list(zip(given[1::2], given[2::2]))
        if len(given) != 1 + 2 * len(stops) or not stops:
            raise Misuse(f"{name} takes a value, and a position and a colour for each stop", f"write {usage}")
        if len(stops) > MOST_STOPS:
            raise Misuse(f"{name} has too many stops", f"use at most {MOST_STOPS}")
        for number in (value, *(position for position, _ in stops)):
            if kind_of(number) not in ("number", "field"):
                raise Misuse(f"the value and the positions of {name} are numbers or fields", f"write {usage}")
        fixed = [p for p, _ in stops if not has_field(p) and not is_live(p)]
        if fixed != sorted(fixed):
            raise Misuse(f"the stops of {name} are not in order", "put lower positions first")
        return compute(slots, lambda value, *stops: _at(between, value, stops), value, *given[1:])

    FUNCTIONS[name] = Function(
        name, COLOURS, (Argument("value", "value"),), call, description, variadic=True, usage=usage, cost=10
    )


def _at(between: Callable, value: Scalar, stops: tuple):
    """Colour of a ramp at a value. Beyond its first and last stop it has the colour of that stop."""
    positions, colours = stops[::2], stops[1::2]
    result = colours[0]
    for position, above, colour in zip(positions, positions[1:], colours[1:]):
        t = between(value, position, above)
        result = spread(lambda a, b: a + (b - a) * t, result, colour)
    return result


_ramp(
    "ramp",
    _linear,
    "A colour ramp: linear from each stop's colour to the next. A colour is a vector, or a number for grey. Positions "
    "are in order.",
)
_ramp("ramp_ease", _ease, "A colour ramp that is smooth at its stops.")
_ramp("ramp_constant", _constant, "A colour ramp that keeps the colour of each stop up to the next.")
