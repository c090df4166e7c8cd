# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Photometric files (IES, ANSI/IESNA LM-63): parsing, and intensity by direction, as in Cycles.

Files often deviate from the standard. Like Cycles, this accepts any angles and skips unneeded data. It converts types A
and B, and files without mirrored parts, to a table over the angles of type C.
"""

from __future__ import annotations

import math
import re

import numpy as np

from ..jit import kernel
from ..vec import normalize

WITHOUT_FILE = 100.0
"""Intensity, in every direction, without a readable file."""

_CANDELA = 4.0 * math.pi / 177.83  # watts of a light of one candela in all directions, for daylight (D65)
_CLOSE = 1e-4  # degrees
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
_WHOLE = re.compile(r"\s*([+-]?\d+)")


class IESError(Exception):
    """The reason why a file cannot be read: the end of a sentence."""


class _Numbers:
    """Reads the numbers of a text in sequence."""

    def __init__(self, text: str, place: int):
        self._text, self.place = text, place

    def next(self, pattern: re.Pattern = _NUMBER) -> float:
        found = pattern.match(self._text, self.place)
        if found is None:
            raise IESError("it has fewer numbers than it announces, or text between them")
        self.place = found.end()
        return float(found.group(1))

    def whole(self) -> int:
        return int(self.next(_WHOLE))

    def row(self, count: int) -> np.ndarray:
        # At least two characters per number: a wrong count must not reserve memory.
        if not 0 < count <= (len(self._text) - self.place) // 2 + 1:
            raise IESError(f"it says that it has {count} angles or values in one row")
        return np.array([self.next() for _ in range(count)])


def parse(text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Horizontal angles (h,) and vertical angles (v,) in radians, ascending, and intensities (h, v).

    Vertical angles are from the nadir, 0 to π, horizontal ones 0 to 2π as in type C. Raises ``IESError``.
    """
    text = text.replace(",", " ")
    start = text.find("\nTILT=")
    if start < 0:
        raise IESError("it has no line that begins with TILT=")
    if text.startswith("INCLUDE", start + 6):
        numbers = _Numbers(text, start + 13)
        numbers.next()
        for _ in range(2 * numbers.whole()):
            numbers.next()
    else:
        end = text.find("\n", start + 1)
        if end < 0:
            raise IESError("nothing follows its line TILT=")
        numbers = _Numbers(text, end)
    numbers.whole(), numbers.next()  # number of lamps, lumens of each
    factor = numbers.next()
    vertical_count, horizontal_count, kind = numbers.whole(), numbers.whole(), numbers.whole()
    if kind not in (1, 2, 3):
        raise IESError(f"its photometric type is {kind}; 1, 2 and 3 are known")
    numbers.whole(), numbers.next(), numbers.next(), numbers.next()  # unit, width, length, height
    factor *= numbers.next() * numbers.next() * _CANDELA  # ballast, and ballast with lamp
    numbers.next()  # watts
    vertical, horizontal = numbers.row(vertical_count), numbers.row(horizontal_count)
    values = factor * np.stack([numbers.row(vertical_count) for _ in range(horizontal_count)])
    convert = {1: _from_type_c, 2: _from_type_b, 3: _from_type_a}[kind]
    horizontal, vertical, values = convert(horizontal, vertical, values)
    return np.radians(horizontal), np.radians(vertical), values


def _close(a: float, b: float) -> bool:
    return abs(a - b) < _CLOSE


def _mirrored(angles: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Adds rows for the angles −a below the given ones, of which the first is 0."""
    return np.concatenate((-angles[:0:-1], angles)), np.concatenate((values[:0:-1], values))


def _from_type_a(horizontal, vertical, values):
    """Of car headlamps: both angles from the axis, −90° to 90°; those to the left may be missing."""
    if _close(horizontal[0], 0.0):
        horizontal, values = _mirrored(horizontal, values)
    return 180.0 - horizontal[::-1], vertical + 90.0, values[::-1]


def _from_type_b(horizontal, vertical, values):
    """Of floodlights with a horizontal polar axis: both angles are exchanged, and the light must be rotated."""
    horizontal, vertical, values = vertical, horizontal, values.T
    if _close(horizontal[0], 0.0):
        horizontal, values = _mirrored(horizontal, values)
    if _close(vertical[0], 0.0):
        vertical, values = _mirrored(vertical, values.T)
        values = values.T
    return horizontal + 90.0, vertical + 90.0, values


def _from_type_c(horizontal, vertical, values):
    """Of most luminaires: one angle, a quadrant, a half, or the full turn, which may lack its last angle, 360°."""
    if _close(horizontal[0], 90.0):
        horizontal = horizontal - 90.0
    if len(horizontal) == 1:
        return np.array([0.0, 360.0]), vertical, np.repeat(values, 2, axis=0)
    for half in (90.0, 180.0):
        if _close(horizontal[-1], half):
            horizontal = np.concatenate((horizontal, 2.0 * half - horizontal[-2::-1]))
            values = np.concatenate((values, values[-2::-1]))
    gap = 360.0 - horizontal[-1]
    if _close(horizontal[0], 0.0) and not _close(gap, 0.0):
        if _close(horizontal[-1] - horizontal[-2], gap) or _close(horizontal[1] - horizontal[0], gap):
            horizontal, values = np.append(horizontal, 360.0), np.concatenate((values, values[:1]))
    return horizontal, vertical, values


def pack(horizontal: np.ndarray, vertical: np.ndarray, values: np.ndarray, repeats_ends: bool = True) -> np.ndarray:
    """The table for ``intensity``, in one row (n,): both counts, the angles in radians, and the intensities with an
    additional row and column at both ends, for the cubic interpolation there.

    ``repeats_ends``: intensities continue beyond the ends; in Blender 4.5 they are 0 there. Cycles intends to continue
    at the other end if the angles close, but compares in single precision, in which 180° and 360° fall short. So this
    does not.
    """
    nothing = 0.0 * values[:, :1]
    low, high = (values[:, :1], values[:, -1:]) if repeats_ends else (nothing, nothing)
    if vertical[0] < 1e-7:
        low = values[:, min(1, len(vertical) - 1), None]
    values = np.concatenate((low, values, high), axis=1)
    nothing = 0.0 * values[:1]
    before, after = (values[:1], values[-2:-1]) if repeats_ends else (nothing, nothing)
    values = np.concatenate((before, values, after))
    return np.concatenate(([len(horizontal), len(vertical)], horizontal, vertical, values.ravel()))


def numbers_of(text: str, repeats_ends: bool = True) -> np.ndarray:
    """``pack`` of a file's text. Raises ``IESError``."""
    return pack(*parse(text), repeats_ends)


@kernel
def _interval(values, first, count, angle):
    """The last interval between ``count`` ascending angles that begins below an angle."""
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if values[first + middle] < angle:
            low = middle
        else:
            high = middle
    return low


@kernel
def _share(values, place, angle):
    """Position of an angle between two neighbours: 0 at the first, 1 at the second."""
    span = values[place + 1] - values[place]
    return (angle - values[place]) / span if span > 0.0 else 0.0


@kernel
def _cubic(a, b, c, d, x):
    """Catmull–Rom spline from b (x = 0) to c (x = 1)."""
    return b + 0.5 * x * (c - a + x * (2.0 * a - 5.0 * b + 4.0 * c - d + x * (3.0 * (b - c) + d - a)))


@kernel
def _along(values, place, x):
    return _cubic(values[place], values[place + 1], values[place + 2], values[place + 3], x)


@kernel
def intensity(values, first, d):
    """Intensity in a direction from the light, in its local space: −z is down, and the horizontal angle is 0 at −y.

    ``values`` is an array in which the result of ``pack`` begins at ``first``. 0 beyond the angles of the file.
    """
    d = normalize(d)
    rows, columns = int(values[first]), int(values[first + 1])
    turns, falls = first + 2, first + 2 + rows
    horizontal, vertical = math.atan2(d[0], d[1]) + math.pi, math.acos(min(max(-d[2], -1.0), 1.0))
    if rows < 2 or columns < 2 or vertical < values[falls] or vertical >= values[falls + columns - 1]:
        return 0.0
    if horizontal < values[turns] or horizontal > values[turns + rows - 1]:
        return 0.0
    row, column = _interval(values, turns, rows, horizontal), _interval(values, falls, columns, vertical)
    s, t = _share(values, turns + row, horizontal), _share(values, falls + column, vertical)
    width = columns + 2
    place = falls + columns + row * width + column
    return max(
        _cubic(
            _along(values, place, t),
            _along(values, place + width, t),
            _along(values, place + 2 * width, t),
            _along(values, place + 3 * width, t),
            s,
        ),
        0.0,
    )
