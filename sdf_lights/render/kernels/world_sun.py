# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The disc of a sky's sun in the nodes of a world: smaller than a cell of the world's map, so it is sampled
separately."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...frozen import frozen
from ...graph.formula import CALL, CONSTANT, Formula, order
from ..nodes.variables import POSITION
from ..sky.model import HALF_ANGLE, SUN

LEAST_SHARE, MOST_SHARE = 0.1, 0.9  # of samples, to the sun


@frozen
class WorldMap:
    """The map of a world for light sampling: ``values`` (rows, columns), and a disc that gets the share ``sun_share``
    of samples. ``sun_radiance`` is the disc's mean brightness."""

    values: np.ndarray
    sun: np.ndarray | None = None
    half_angle: float = 0.0
    sun_share: float = 0.0
    sun_radiance: float = 0.0

    @property
    def mean(self) -> float:
        """Mean brightness over the sphere, including the disc."""
        return _mean(self.values) + 0.5 * (1.0 - math.cos(self.half_angle)) * self.sun_radiance


@frozen
class Disc:
    """Unit vector to the sun, and the angle from there to its edge."""

    direction: np.ndarray
    half_angle: float

    def points(self) -> np.ndarray:
        """Unit vectors (n, 3) in the disc, of equal solid angle."""
        rings, sectors = 4, 8
        cosine = 1.0 - (1.0 - math.cos(self.half_angle)) * (np.arange(rings) + 0.5) / rings
        phi = 2.0 * math.pi * (np.arange(sectors) + 0.5) / sectors
        side = np.cross(self.direction, np.eye(3)[np.argmin(np.abs(self.direction))])
        side /= np.linalg.norm(side)
        up = np.cross(self.direction, side)
        around = np.multiply.outer(np.cos(phi), side) + np.multiply.outer(np.sin(phi), up)
        points = cosine[:, None, None] * self.direction + np.sqrt(1.0 - cosine**2)[:, None, None] * around
        return points.reshape(-1, 3)

    def separate(self, values: np.ndarray, radiance: float) -> WorldMap:
        """The map (height, width) without the disc, whose mean brightness is ``radiance``.

        Cells whose middle lies in the disc get the values around it.
        """
        rows, columns = values.shape
        latitude = np.pi * ((np.arange(rows) + 0.5) / rows - 0.5)
        longitude = 2.0 * np.pi * (0.5 - (np.arange(columns) + 0.5) / columns)
        across = np.multiply.outer(
            np.cos(latitude), self.direction[0] * np.cos(longitude) + self.direction[1] * np.sin(longitude)
        )
        cosine = across + (self.direction[2] * np.sin(latitude))[:, None]
        near = cosine >= math.cos(min(self.half_angle + 3.0 * np.pi / rows, np.pi))
        inside = cosine >= math.cos(self.half_angle) - 1e-9
        if not inside.any() or not (near & ~inside).any():
            rest = values
        else:
            rest = np.where(inside, values[near & ~inside].mean(), values)
        solid_angle = 2.0 * math.pi * (1.0 - math.cos(self.half_angle))
        sun, sky = solid_angle * radiance, 4.0 * math.pi * _mean(rest)
        if not sun > 0.0:
            return WorldMap(rest)
        share = min(max(sun / (sun + sky), LEAST_SHARE), MOST_SHARE)
        return WorldMap(rest, self.direction, self.half_angle, share, radiance)


def _mean(values: np.ndarray) -> float:
    """Mean over the sphere of an equirectangular map."""
    weight = np.diff(np.sin(np.pi * (np.arange(len(values) + 1) / len(values) - 0.5)))
    return float(0.5 * weight @ values.mean(axis=1, dtype=np.float64))


def find_disc(roots: Sequence[Formula], numbers: np.ndarray, constants: np.ndarray) -> Disc | None:
    """The disc of the only sky with a sun among the formulas of a world, whose parameters are ``numbers`` (n,); None if
    there is none, several, or a rotated one. ``constants`` holds the skies' numbers."""
    discs = []
    for node in order(*roots):
        if node.kind != CALL or node.value.name != "sky" or not node.value.static[1]:
            continue
        place, *direction = node.operands
        first = int(place.value if place.kind == CONSTANT else numbers[place.value])
        if tuple(direction) != tuple(POSITION):
            return None
        if constants[first + HALF_ANGLE] > 0.0:
            discs.append(Disc(np.array(constants[first + SUN : first + SUN + 3]), float(constants[first + HALF_ANGLE])))
    return discs[0] if len(discs) == 1 else None
