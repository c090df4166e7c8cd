# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sunlight scattered once: Nishita et al. 1993, "Display of the Earth taking into account atmospheric scattering", at
21 wavelengths, as in Blender's sky of this name.

Lengths are metres. In Blender's tables, values are half a row and half a column away from the positions in
``atmosphere``; the tables made here do the same. In Blender 4.5, where this sky is called Nishita, rows differ slightly
(``early``).
"""

from __future__ import annotations

import numpy as np

from .atmosphere import COLUMNS, ROWS, distance_to_shell, heights_along
from .colour import CIE_1931, REC709_FROM_XYZ, WAVELENGTHS, planck

GROUND, SHELL = 6_360_000.0, 6_420_000.0  # radii
LOWEST, HIGHEST = 1.0, 59_999.0  # heights of a viewer
STEPS = 32  # along a viewing ray

_AIR_HEIGHT, _AEROSOL_HEIGHT = 8000.0, 1200.0  # at which their density has fallen to 1/e
_OZONE_HEIGHT, _OZONE_REACH = 25_000.0, 15_000.0  # of the middle of its layer, and from there to its end
_ASYMMETRY = 0.76  # of scattering by aerosols

# Rayleigh: refractive index and molecules per m³ of air. The Sun: a black body's radiance times its solid angle.
_AIR = 8.0 * np.pi**3 * (1.0002926**2 - 1.0) ** 2 / (3.0 * 2.504e25) / (1e-9 * WAVELENGTHS) ** 4
_AEROSOL, _AEROSOL_LOSS = 2e-5, 1.11  # scattering, and extinction over scattering
_OZONE = 1e-6 * np.array(
    [
        0.00325126849861,
        0.00585395365047,
        0.01977191155085,
        0.07309568762914,
        0.20084561514287,
        0.40383958096161,
        0.63551335912363,
        0.96707041180970,
        1.54797400424410,
        2.09038647233331,
        2.46128056164565,
        2.73551299461512,
        2.15125863128643,
        1.59051840791988,
        1.12356197979857,
        0.73527551487574,
        0.46450130357806,
        0.33096079921048,
        0.22512612292678,
        0.14879129266490,
        0.16828623364192,
    ]
)
_SUN = 6.790163e-5 * planck(5778.0, WAVELENGTHS)

# For a density that falls about exponentially along a ray; where the ray leaves the atmosphere the rule's variable is
# 25.
_NODES, _WEIGHTS = np.polynomial.laguerre.laggauss(8)
_RULE = [(node / 25.0, weight * np.exp(node) / 25.0) for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist())]

_EXTINCTION = np.array([_AIR, np.full_like(_AIR, _AEROSOL_LOSS * _AEROSOL), _OZONE])  # (kind of matter, wavelength)
_TO_RGB = (WAVELENGTHS[1] - WAVELENGTHS[0]) * CIE_1931 @ REC709_FROM_XYZ.T  # (wavelength, 3)


def _densities(height) -> list[np.ndarray]:
    """Air, aerosols and ozone at a height, relative to their maxima."""
    ozone = 1.0 - np.abs(height - _OZONE_HEIGHT) / _OZONE_REACH
    return [np.exp(height / -_AIR_HEIGHT), np.exp(height / -_AEROSOL_HEIGHT), np.maximum(ozone, 0.0)]


def _columns(radius, height, sine) -> np.ndarray:
    """Amount of matter of each kind from points out of the atmosphere along rays whose elevation has this sine: (3, …).

    Finite but meaningless if the ground is in the way.
    """
    way = distance_to_shell(radius, sine, SHELL)
    total = np.zeros((3, *np.shape(way)), way.dtype)
    for node, weight in _RULE:
        reached = heights_along(radius, height, sine, node * way)[1]
        for kind, density in enumerate(_densities(np.maximum(reached, 0.0))):
            total[kind] += weight * density
    return total * way


def sun_radiance(sine, altitude: float, densities, solid_angle: float) -> np.ndarray:
    """RGB (n, 3) of the sun's disc, without limb darkening, for directions whose elevations have these sines (n,).

    ``densities`` of air and aerosols; ozone does not dim the disc of this model.
    """
    height = np.clip(altitude, LOWEST, HIGHEST)
    air, aerosol, _ = _columns(GROUND + height, height, np.asarray(sine, np.float64))
    depth = densities[0] * np.outer(air, _AIR) + densities[1] * np.outer(aerosol, _EXTINCTION[1])
    return _SUN * np.exp(-depth) @ _TO_RGB / solid_angle


def table(elevation: float, altitude: float, densities, early: bool) -> np.ndarray:
    """The sky in the form of ``atmosphere``, for densities of air, aerosols and ozone."""
    height = np.clip(altitude, LOWEST, HIGHEST)
    radius = GROUND + height
    half = ROWS // 2
    latitude = 0.5 * np.pi * (1.0 + 0.5 / half if early else 1.0) * (np.arange(half) / half) ** 2
    azimuth = np.pi * (1.0 - np.arange(COLUMNS) / COLUMNS)
    densities = np.asarray(densities, np.float64)[:, None]
    upper = np.empty((half, COLUMNS, 3), np.float32)
    extinction = _EXTINCTION.astype(np.float32)
    for row in range(half):
        sine, cosine = np.sin(latitude[row]), np.cos(latitude[row])
        segment = distance_to_shell(radius, sine, SHELL) / STEPS
        along = (np.arange(STEPS) + 0.5) * segment
        radii, heights = heights_along(radius, height, sine, along)
        matter = densities * _densities(heights)
        passed = np.cumsum(matter, axis=1) * segment
        # To the sun, from every step of every azimuth: only the angle to the zenith matters.
        to_sun = cosine * np.cos(azimuth) * np.cos(elevation) + sine * np.sin(elevation)
        rise = ((radius * np.sin(elevation) + along[:, None] * to_sun) / radii[:, None]).astype(np.float32)
        nearest = radii[:, None] * np.sqrt(np.maximum(1.0 - rise * rise, 0.0))
        lit = (rise >= 0.0) | (nearest > GROUND)
        columns = _columns(radii.astype(np.float32)[:, None], heights.astype(np.float32)[:, None], rise)
        columns = columns * densities.astype(np.float32)[..., None] + passed.astype(np.float32)[..., None]
        seen = np.exp(-(np.moveaxis(columns, 0, -1) @ extinction)) * lit[..., None]
        seen = np.einsum("ks,sal->kal", (matter[:2] * segment).astype(np.float32), seen)
        rayleigh = 3.0 / (16.0 * np.pi) * (1.0 + to_sun**2)
        square = _ASYMMETRY**2
        mie = (
            3.0
            * (1.0 - square)
            * (1.0 + to_sun**2)
            / (8.0 * np.pi * (2.0 + square) * (1.0 + square - 2.0 * _ASYMMETRY * to_sun) ** 1.5)
        )
        spectrum = rayleigh[:, None] * _AIR * seen[0] + mie[:, None] * _AEROSOL * seen[1]
        upper[row] = spectrum * _SUN @ _TO_RGB
    # Below the horizon its colour fades to black.
    sine = np.sin(0.5 * np.pi * (1.0 - (np.arange(half) + (0.5 if early else 0.0)) / half) ** 2)
    fade = np.maximum(1.0 - 2.5 * sine, 0.0) ** 3
    return np.concatenate((fade[:, None, None].astype(np.float32) * upper[0], upper))
