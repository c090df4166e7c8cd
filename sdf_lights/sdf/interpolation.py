# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes and emissions between two of them, for lamps that change while a shutter is open."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from ..affine import Arc
from .shapes.base import Parametric


def interpolated(start, end, part: float):
    """The shape, profile or emission at ``part``, 0 to 1, of the way between two of them.

    Numbers change on straight lines, and transforms as those of objects. Where two parts differ by more than numbers,
    as outlines do, the nearer one is taken. So are whole numbers, such as counts.
    """
    if start == end:
        return start
    nearer = start if part < 0.5 else end
    if type(start) is not type(end):
        return nearer
    whole = {field.name for field in start.fields() if field.whole} if isinstance(start, Parametric) else set()
    changes = {}
    for field in dataclasses.fields(start):
        a, b = getattr(start, field.name), getattr(end, field.name)
        if field.name in whole:
            changes[field.name] = getattr(nearer, field.name)
        elif _is_alike(a, b):
            changes[field.name] = _between(a, b, part)
        else:
            return nearer
    return start.replaced(**changes) if isinstance(start, Parametric) else dataclasses.replace(start, **changes)


def change(start, end) -> float:
    """The greatest relative change of a number between two shapes, profiles or emissions, 0 to 2; 0 where they differ
    by more than numbers, so ``interpolated`` jumps."""
    if start == end or type(start) is not type(end):
        return 0.0
    pairs = [(getattr(start, field.name), getattr(end, field.name)) for field in dataclasses.fields(start)]
    return max(map(_change, *zip(*pairs)), default=0.0) if all(_is_alike(a, b) for a, b in pairs) else 0.0


def _change(a, b) -> float:
    if isinstance(a, tuple):
        return max(map(_change, a, b), default=0.0)
    if type(a) is float:
        return abs(b - a) / max(abs(a), abs(b)) if a != b and math.isfinite(a + b) else 0.0
    return change(a, b) if dataclasses.is_dataclass(a) else 0.0


def _is_alike(a, b) -> bool:
    """Whether two values of a field differ by numbers alone."""
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(_is_alike, a, b))
    if type(a) is float and type(b) is float:  # not the address of a table
        return True
    return dataclasses.is_dataclass(a) and dataclasses.is_dataclass(b) or type(a) is type(b) and a == b


def _between(a: Any, b: Any, part: float):
    if isinstance(a, tuple):
        if len(a) == 4 and all(isinstance(row, tuple) and len(row) == 4 for row in a):
            return tuple(map(tuple, Arc(np.array(a), np.array(b)).at(part).tolist()))
        return tuple(_between(x, y, part) for x, y in zip(a, b))
    if type(a) is float:
        return a if a == b or not math.isfinite(a + b) else a + part * (b - a)
    return interpolated(a, b, part) if dataclasses.is_dataclass(a) else a
