# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Skies: the models of Blender's Sky Texture, as in Cycles.

A ``Sky`` holds the node's settings. ``numbers`` converts them to the numbers that the kernels of ``kernels.py`` read.
"""

from __future__ import annotations

import numpy as np

from ...frozen import frozen
from . import kernels
from .model import MODELS, Sky, numbers

__all__ = ["MODELS", "Sky", "Sun", "numbers", "radiance", "sky_map", "sun_of"]


@frozen
class Sun:
    """The disc of a sky's sun: unit vector to its middle, angle from there to its edge (radians), and the mean of its
    radiance over its solid angle, RGB, without the part hidden by the horizon."""

    direction: np.ndarray
    half_angle: float
    radiance: np.ndarray


def radiance(sky: Sky, directions: np.ndarray, disc: bool = True) -> np.ndarray:
    """Radiance (n, 3), scene-linear Rec. 709, of the sky along unit vectors (n, 3); float64."""
    directions = np.ascontiguousarray(directions, np.float64)
    found = np.empty(directions.shape)
    kernels.fill(sky.kind, disc, numbers(sky), directions, found)
    return found


def sky_map(sky: Sky, width: int, height: int) -> np.ndarray:
    """The sky without the sun's disc, (height, width, 3) float32, equirectangular.

    Row 0 is at the nadir. Column 0 is at longitude π (−X), and the longitude falls with the column, as in environment
    textures.
    """
    picture = np.empty((height, width, 3), np.float32)
    kernels.fill_map(sky.kind, numbers(sky), picture)
    return picture


def sun_of(sky: Sky) -> Sun | None:
    """The disc of the sun; None if it is invisible."""
    values = numbers(sky)
    if not sky.has_disc or values[kernels.HALF_ANGLE] <= 0.0:
        return None
    direction, half = sky.sun(), float(values[kernels.HALF_ANGLE])
    # Rings and sectors of equal solid angle.
    rings, sectors = 32, 64
    cosine = 1.0 - (1.0 - np.cos(half)) * (np.arange(rings) + 0.5) / rings
    sine, phi = np.sqrt(1.0 - cosine**2), 2.0 * np.pi * (np.arange(sectors) + 0.5) / sectors
    east = np.cross(direction, (1.0, 0.0, 0.0) if abs(direction[0]) < 0.7 else (0.0, 1.0, 0.0))
    east /= np.linalg.norm(east)
    north = np.cross(direction, east)
    around = np.multiply.outer(np.cos(phi), east) + np.multiply.outer(np.sin(phi), north)
    points = cosine[:, None, None] * direction + sine[:, None, None] * around
    points = points.reshape(-1, 3)
    found = np.empty(points.shape)
    kernels.fill(sky.kind, True, values, points, found)
    beside = np.empty(points.shape)
    kernels.fill(sky.kind, False, values, points, beside)
    return Sun(direction, half, (found - beside).mean(axis=0))
