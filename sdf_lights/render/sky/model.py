# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a sky, and the numbers that kernels read."""

from __future__ import annotations

import functools
import math

import numpy as np

from ...frozen import frozen
from . import hosek_wilkie, multiple_scattering, preetham, single_scattering

MODELS = ("PREETHAM", "HOSEK_WILKIE", "NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")
"""Blender's names of sky types; "NISHITA" is the name before 5.0 for the two last."""

# Positions of a sky's numbers: the sun's direction, then those of its kind.
SUN = 0
SHAPES = 3  # analytic: coefficients of three channels, each with a factor at its end
HALF_ANGLE, LOWEST, SPAN, HORIZON, BESIDE, BOTTOM, TOP, TABLE = 3, 4, 5, 6, 7, 8, 11, 14

ANALYTIC_PREETHAM, ANALYTIC_HOSEK, TABULATED = range(3)  # kinds: each has its own kernel

_SMALLEST_SUN = 0.0005  # radians
_EARTH = 6_371_000.0  # radius for the horizon that hides the sun, metres
_KEPT = 4  # cached tables of earlier settings


@frozen
class Sky:
    """A sky texture: names, units and meaning are those of Blender's node.

    ``aerosol_density`` is called dust density in Blender 4.5. Angles are radians, ``altitude`` metres; ``sun_size`` is
    the sun's diameter as an angle, ``sun_rotation`` turns clockwise from +Y seen from above.
    """

    model: str = "MULTIPLE_SCATTERING"
    sun_disc: bool = True
    sun_size: float = 0.009512
    sun_intensity: float = 1.0
    sun_elevation: float = math.radians(15.0)
    sun_rotation: float = 0.0
    altitude: float = 100.0
    air_density: float = 1.0
    aerosol_density: float = 1.0
    ozone_density: float = 1.0
    sun_direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    turbidity: float = 2.2
    ground_albedo: float = 0.3

    @property
    def kind(self) -> int:
        """The kernel that the model needs."""
        return {"PREETHAM": ANALYTIC_PREETHAM, "HOSEK_WILKIE": ANALYTIC_HOSEK}.get(self.model, TABULATED)

    @property
    def has_disc(self) -> bool:
        """Whether the disc of the sun is part of the sky."""
        return self.sun_disc and self.kind == TABULATED

    def sun(self) -> np.ndarray:
        """Unit vector to the sun."""
        if self.kind != TABULATED:
            direction = _unit(np.asarray(self.sun_direction, np.float64), (0.0, 0.0, 1.0))
            if self.kind == ANALYTIC_HOSEK and direction[2] < 0.0:  # its sun does not sink below the horizon
                return _unit(direction * (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))
            return direction
        across = math.cos(self.sun_elevation)
        return np.array(
            [across * math.sin(self.sun_rotation), across * math.cos(self.sun_rotation), math.sin(self.sun_elevation)]
        )

    def elevation(self) -> float:
        """Elevation of the sun, −π/2 to π/2."""
        return math.asin(min(max(self.sun()[2], -1.0), 1.0))


def _unit(vector: np.ndarray, otherwise: tuple[float, float, float]) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else np.array(otherwise)


def numbers(sky: Sky) -> np.ndarray:
    """The numbers for the kernels of ``sky.kind``, one row of float64."""
    sun = sky.sun()
    if sky.kind == ANALYTIC_PREETHAM:
        return np.concatenate((sun, preetham.coefficients(sun, sky.turbidity).ravel()))
    if sky.kind == ANALYTIC_HOSEK:
        return np.concatenate((sun, hosek_wilkie.coefficients(sun, sky.turbidity, sky.ground_albedo).ravel()))
    densities = (sky.air_density, sky.aerosol_density, sky.ozone_density)
    table = _table(sky.model, sky.elevation(), sky.altitude, densities)
    return np.concatenate((sun, _disc(sky), table.ravel()))


@functools.lru_cache(maxsize=_KEPT)
def _table(model: str, elevation: float, altitude: float, densities) -> np.ndarray:
    if model == "MULTIPLE_SCATTERING":
        return multiple_scattering.table(elevation, altitude, densities)
    return single_scattering.table(elevation, altitude, densities, early=model == "NISHITA")


def _disc(sky: Sky) -> np.ndarray:
    """Numbers of the sun's disc, from ``HALF_ANGLE`` to before ``TABLE``; the half angle is 0 if there is none.

    The radiance at the lower and at the upper edge is computed; values in between are interpolated by elevation.
    """
    early = sky.model == "NISHITA"
    size = max(sky.sun_size, _SMALLEST_SUN)
    half, elevation = 0.5 * size, sky.elevation()
    # Cycles computes this difference in single precision, which changes the brightness of small suns by percents.
    solid_angle = 2.0 * math.pi * float(np.float32(1.0) - np.float32(math.cos(np.float32(half))))
    low, high = elevation - half, elevation + half
    densities = (sky.air_density, sky.aerosol_density, sky.ozone_density)
    if sky.model == "MULTIPLE_SCATTERING":
        radiance = multiple_scattering.sun_radiance(np.sin([low, high]), sky.altitude, densities, solid_angle)
    elif high > 0.0:
        radiance = single_scattering.sun_radiance(np.sin([max(low, 0.0), high]), sky.altitude, densities, solid_angle)
    else:
        radiance = np.zeros((2, 3))
    if early:
        # There the disc replaces the sky, and only the part of it above the horizon is interpolated.
        low, horizon, beside = max(low, 0.0), 0.0, 0.0
    else:
        horizon, beside = -math.acos(_EARTH / (_EARTH + sky.altitude)), 1.0
    shown = sky.sun_disc and high > (0.0 if early else horizon)
    return np.concatenate(
        ([half if shown else 0.0, low, max(high - low, 1e-9), horizon, beside], sky.sun_intensity * radiance.ravel())
    )
