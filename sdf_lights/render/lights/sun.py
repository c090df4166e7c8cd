# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sun lights."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..scene import RGB, Light
from .reading import Kind


@dataclass
class SunLight(Light):
    """A light at infinite distance: one direction, or a disk of directions."""

    strength: float  # irradiance, W/m²
    color: RGB = (1.0, 1.0, 1.0)
    angle: float = 0.0  # angular diameter


def _read(data, name, matrix, power, common) -> SunLight:
    solid = math.pi * math.sin(0.5 * data.angle) ** 2  # ∫ cosine over the sun's disk
    strength = power * solid if solid > 0.0 and not data.normalize else power
    return SunLight(name, matrix, strength, angle=data.angle, **common)


LIGHTS = {"SUN": Kind(_read, lambda data, scale: ("SUN", data.angle))}
