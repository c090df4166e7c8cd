# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps to start from: expressions with a colour and a power, each with a picture. This module imports no bpy."""

from __future__ import annotations

import functools
import pathlib
import tomllib
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

FOLDER = pathlib.Path(__file__).parent


class Preset(NamedTuple):
    """A lamp. ``temperature`` in kelvins, 0 if it has a ``color`` instead; ``power`` in watts, unless it has a
    ``density``.

    The parameters of its ``expression``, or of the primitive ``shape`` in its place, have ``values``. ``emission`` is
    the name of a preset of ``sdf.emission_presets``, whose parameters have ``emission_values``, or a text in the
    language of emissions. Values are as Blender's properties hold them: angles in radians. ``sources`` are curves and
    pictures that the expression names, as ``preset_sources`` makes them.
    """

    name: str
    title: str
    expression: str
    power: float
    temperature: float = 0.0
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    emission: str = "uniform"
    emission_values: Mapping[str, float | list[float]] = MappingProxyType({})
    camera_brightness: float = 1.0
    shape: str = ""
    values: Mapping[str, float | list[float]] = MappingProxyType({})
    density: float | None = None
    sources: Mapping[str, Mapping] = MappingProxyType({})

    @property
    def picture(self) -> pathlib.Path:
        """Path of its picture."""
        return FOLDER / f"{self.name}.png"


@functools.cache
def presets() -> dict[str, Preset]:
    """Every preset by name, in the order of the file."""
    with open(FOLDER / "presets.toml", "rb") as file:
        read = tomllib.load(file)
    return {
        name: Preset(
            name,
            **about | {"expression": about["expression"].strip(), "color": tuple(about.get("color", (1.0, 1.0, 1.0)))},
        )
        for name, about in read.items()
    }
