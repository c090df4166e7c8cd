# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Point and spot lights."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..scene import RGB, Light
from .reading import Kind


@dataclass
class PointLight(Light):
    """A point, a sphere, or with soft falloff a disk that faces the lit point."""

    power: float
    color: RGB = (1.0, 1.0, 1.0)
    radius: float = 0.0
    soft_falloff: bool = True

    @property
    def strength(self) -> float:
        """See ``scene.Light``."""
        return self.power


@dataclass
class SpotLight(PointLight):
    """A point light whose intensity falls to 0 at the edge of a cone about its local −z."""

    angle: float = 0.785398  # full cone angle
    blend: float = 0.15


def _shared(data, power, common) -> tuple[float, dict]:
    """Power and keyword arguments of both. Without ``normalize``, Blender's power is per square metre."""
    radius = data.shadow_soft_size
    if not data.normalize:
        power *= 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0
    return power, common | dict(radius=radius, soft_falloff=data.use_soft_falloff)


def _read_point(data, name, matrix, power, common) -> PointLight:
    power, common = _shared(data, power, common)
    return PointLight(name, matrix, power, **common)


def _read_spot(data, name, matrix, power, common) -> SpotLight:
    power, common = _shared(data, power, common)
    return SpotLight(name, matrix, power, angle=data.spot_size, blend=data.spot_blend, **common)


LIGHTS = {
    "POINT": Kind(_read_point, lambda data, scale: ("POINT",)),
    "SPOT": Kind(_read_spot, lambda data, scale: ("SPOT", data.spot_size)),
}
