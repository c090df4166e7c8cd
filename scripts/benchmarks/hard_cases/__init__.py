# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases in which a lamp's light is easily wrong or expensive, each with one figure and its limit.

A case is a function ``quick -> Figure`` whose docstring describes the measurement in one line. Its limit is known
before the measurement: an analytic value with its rounding and the standard error of the samples, a requirement of the
search, or a published figure. None of these modules needs Blender, except where a case says so.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Figure:
    """The measured value; it must not be above the limit. ``more`` are further numbers of the row."""

    value: float
    limit: float
    more: dict[str, float] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        return bool(math.isfinite(self.value) and self.value <= self.limit)


@dataclass(frozen=True)
class Case:
    """``slow``: it takes more than a few seconds. ``blender``: it renders in Blender, to compare with Cycles.
    ``opengl``: it needs an OpenGL 4.3 context."""

    name: str
    measure: Callable[[bool], Figure]
    slow: bool
    blender: bool
    opengl: bool

    @property
    def about(self) -> str:
        return " ".join((self.measure.__doc__ or "").split())

    @property
    def kind(self) -> str:
        """The name of its module."""
        return self.measure.__module__.rpartition(".")[2]


CASES: dict[str, Case] = {}


def case(name: str, slow: bool = False, blender: bool = False, opengl: bool = False):
    """Register a function as the case ``name``: words with hyphens, for the command line."""

    def register(measure):
        assert name not in CASES
        CASES[name] = Case(name, measure, slow, blender, opengl)
        return measure

    return register


for _module in ("rays", "light", "scattered", "faces", "cost", "single", "samples", "motion"):
    importlib.import_module(f".{_module}", __package__)
