# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import RenderError
from ..scene import RGB, Light
from .reading import Kind


@dataclass
class AreaLight(Light):
    """A rectangle or ellipse that emits to one side."""

    power: float
    color: RGB = (1.0, 1.0, 1.0)
    ellipse: bool = False  # disk or ellipse, else square or rectangle
    size: tuple[float, float] = (1.0, 1.0)  # full extent along local x and y, before the matrix
    spread: float = np.pi

    @property
    def strength(self) -> float:
        """See ``scene.Light``."""
        return self.power


def is_round(data) -> bool:
    """Whether Blender's light is a disk or an ellipse."""
    return data.shape in {"DISK", "ELLIPSE"}


def sides(data) -> np.ndarray:
    """Full extent (2,) of Blender's light, in metres before its scale."""
    return np.array((data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size))


def _read(data, name, matrix, power, common) -> AreaLight:
    ellipse, size = is_round(data), tuple(sides(data).tolist())
    # Scaled by the object as in Blender: each axis by its own length.
    stretch = float(np.prod(np.linalg.norm(matrix[:3, :2], axis=0)))
    area = size[0] * size[1] * stretch * (math.pi / 4 if ellipse else 1.0)
    if area <= 0.0:
        raise RenderError(f"Area light '{name}' has no area: it is left out; set its size and its scale.")
    power = power if data.normalize else power * area
    return AreaLight(name, matrix, power, ellipse=ellipse, size=size, spread=data.spread, **common)


def _nodes_see(data, scale) -> tuple:
    return "AREA", *np.maximum(sides(data) * scale[:2], 1e-30)


LIGHTS = {"AREA": Kind(_read, _nodes_see)}
