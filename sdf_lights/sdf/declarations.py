# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters that an expression declares, as in ``size = slider(1, 0, 3)  # in metres``."""

from __future__ import annotations

import math
from typing import NamedTuple

from .expression_values import Condition, Live, Misuse, components, kind_of
from .shapes.base import LARGEST

LONGEST_NAME = 40  # letters; Blender's properties have at most 63

USAGE = {
    "slider": "name = slider(default, minimum, maximum)",
    "integer": "name = integer(default, minimum, maximum)",
    "angle": "name = angle(default, minimum, maximum), in degrees",
    "toggle": "name = toggle(True)",
    "vector": "name = vector((x, y, z), minimum, maximum)",
}
"""The syntax of each kind of parameter."""

LIMITS = {"angle": (-360.0, 360.0), "vector": (-10.0, 10.0)}
"""Limits of kinds that need no declared limits."""

_TAKES = {
    "toggle": "True or False",
    "vector": "a vector of three numbers, and optional limits",
    "angle": "a number of degrees, and optional limits",
}


class Declaration(NamedTuple):
    """A parameter. ``kind`` is the word that declares it, a key of ``USAGE``; angles are in degrees.

    ``default`` is a float, or a 3-tuple for a vector; a toggle is 0.0 or 1.0. Limits are those of each component.
    """

    name: str
    kind: str
    default: float | tuple[float, float, float]
    minimum: float
    maximum: float
    description: str

    def held(self, value) -> float | tuple[float, float, float]:
        """A value clamped to the limits; whole for an integer. Raises ``ValueError`` if it is not a number."""
        if self.kind == "vector":
            x, y, z = value
            return self._held(x), self._held(y), self._held(z)
        return self._held(value)

    def _held(self, value) -> float:
        value = float(value)
        if math.isnan(value):
            raise ValueError
        value = min(max(value, self.minimum), self.maximum)
        return float(math.floor(value + 0.5)) if self.kind in ("integer", "toggle") else value

    def live(self, value):
        """The value of the name in the expression, for a clamped value."""
        if self.kind == "vector":
            return tuple(map(Live, value))
        return Condition(Live(value)) if self.kind == "toggle" else Live(value, self.maximum)


def declare(name: str, kind: str, given: list, description: str) -> Declaration:
    """The declaration with the given arguments. Raises ``Misuse`` if they are wrong."""
    cure = f"write {USAGE[kind]}"
    if len(name) > LONGEST_NAME:
        raise Misuse(f"the name {name:.20}… of the parameter is too long", f"use at most {LONGEST_NAME} letters")
    kinds = list(map(kind_of, given))
    first = {"toggle": "condition", "vector": "vector"}.get(kind, "number")
    lengths = [1] if kind == "toggle" else [1, 3] if kind in LIMITS else [3]
    if (
        kinds != [first, "number", "number"][: len(kinds)]
        or len(kinds) not in lengths
        or (kind == "vector" and len(given[0]) != 3)
    ):
        raise Misuse(f"{kind} takes {_TAKES.get(kind, 'three numbers')}", cure)
    if kind == "toggle":
        return Declaration(name, kind, given[0].truth, 0.0, 1.0, description)
    default, minimum, maximum = given if len(given) == 3 else (given[0], *LIMITS[kind])
    for component in components(default):
        if not minimum <= component <= maximum or minimum == maximum:
            raise Misuse(f"the default {component:g} is not between {minimum:g} and {maximum:g}", cure)
    if max(abs(minimum), abs(maximum)) > LARGEST:
        raise Misuse(f"a limit is beyond {LARGEST:g}", cure)
    if kind == "integer" and any(number != math.floor(number) for number in (default, minimum, maximum)):
        raise Misuse("integer takes whole numbers", cure)
    return Declaration(name, kind, default, minimum, maximum, description)
