# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sunlight scattered any number of times, at four wavelengths that represent the spectrum: García Liñán 2024, "Fast
spectral sky rendering", as in Blender's sky of this name. Scattering after the first is a fit.

Lengths are kilometres.
"""

from __future__ import annotations

import numpy as np

from .atmosphere import COLUMNS, ROWS, distance_to_shell, heights_along
from .colour import REC709_FROM_XYZ

GROUND, THICKNESS = 6371.0, 100.0
SHELL = GROUND + THICKNESS
LOWEST, HIGHEST = 0.001, 99.999  # heights of a viewer
STEPS = 64  # along any ray
_SINES, _HEIGHTS = 256, 64  # of the table of transmittance

_ASYMMETRY = 0.8  # of scattering by aerosols
_ALBEDO = 0.3  # of the ground

# At 630, 560, 490 and 430 nm, for the air of cities.
_SUN = np.array([1.679, 1.828, 1.986, 1.307])
_AIR = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])
_AEROSOL = 1.3681e20 * np.array([1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22])
_AEROSOL_ABSORPTION = 1.3681e20 * np.array([2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23])
_OZONE = 334.5 * 3.78547397e20 * np.array([3.472e-25, 3.914e-25, 1.349e-25, 11.03e-27])
_EXTINCTION = np.array([_AIR, _AEROSOL + _AEROSOL_ABSORPTION, _OZONE])  # (kind of matter, wavelength), 1/km
_AEROSOL_HEIGHT, _AEROSOL_EVERYWHERE = 0.73, 2e6 / 1.3681e20
_MANIFOLD = 0.02 * np.array([0.217, 0.347, 0.594, 1.0])  # light from all directions that air has scattered before
_TO_RGB = (
    np.array(
        [
            (53.386917738564668023, 22.981337506691024754, 0.0),
            (43.904844466369358263, 71.347795700053393866, 0.102506867965741307),
            (1.6137278251608962005, 18.422960591455485011, 31.742921188390805758),
            (20.762668673810577145, 2.3614213523314368527, 110.48009643252140334),
        ]
    )
    @ REC709_FROM_XYZ.T
)


def _matter(height, densities) -> np.ndarray:
    """Density of air, aerosols and ozone at heights (…): (3, …), in the units of the coefficients."""
    logarithm = np.log(np.maximum(height, 1e-4))
    return np.stack(
        [
            densities[0] * np.exp(-0.07771971 * height**1.16364243),
            densities[1] * (np.exp(height / -_AEROSOL_HEIGHT) + _AEROSOL_EVERYWHERE),
            densities[2] * np.exp((logarithm - 3.22261) ** 2 * -5.55555555 - logarithm),
        ]
    )


def _transmittance(height, sine, densities) -> np.ndarray:
    """Transmittance from points at heights (n,) out of the atmosphere along rays whose elevations have the sines (m,):
    (wavelength, n, m).

    The ground is no obstacle; the air below it is that at its surface.
    """
    height, sine = np.asarray(height, np.float64)[:, None], np.asarray(sine, np.float64)
    step = distance_to_shell(GROUND + height, sine, SHELL) / STEPS
    radius, height, sine, along = (np.asarray(a, np.float32) for a in (GROUND + height, height, sine, step))
    columns = np.zeros((3, *step.shape), np.float32)
    for index in range(STEPS):
        reached = heights_along(radius, height, sine, (index + 0.5) * along)[1]
        columns += _matter(np.maximum(reached, 0.0), densities)
    return np.exp(-np.einsum("kl,kns->lns", _EXTINCTION, columns * step))


def sun_radiance(sine, altitude: float, densities, solid_angle: float) -> np.ndarray:
    """RGB (n, 3) of the sun's disc, without limb darkening, for directions whose elevations have these sines (n,)."""
    height = np.clip(altitude / 1000.0, LOWEST, HIGHEST)
    return (_SUN[:, None] * _transmittance([height], sine, densities)[:, 0]).T @ _TO_RGB / solid_angle


def table(elevation: float, altitude: float, densities) -> np.ndarray:
    """The sky in the form of ``atmosphere``, for densities of air, aerosols and ozone."""
    known = _transmittance(np.linspace(0.0, THICKNESS, _HEIGHTS), np.linspace(-1.0, 1.0, _SINES), densities).astype(
        np.float32
    )
    steps = np.diff(known, axis=1)
    height = np.clip(altitude / 1000.0, LOWEST, HIGHEST)
    radius = GROUND + height
    line = (np.arange(ROWS) + 0.5) / ROWS * 2.0 - 1.0
    latitude = 0.5 * np.pi * np.copysign(line * line, line)
    azimuth = np.pi * (1.0 - (np.arange(COLUMNS) + 0.5) / COLUMNS)
    sky = np.empty((ROWS, COLUMNS, 3), np.float32)
    for row in range(ROWS):
        sky[row] = _row(latitude[row], azimuth, elevation, radius, height, known, steps, densities)
    return sky


def _distance_to_ground(radius: float, sine: float) -> float:
    """Distance to the ground along a ray from above it; 0 if it misses.

    Cycles rounds every operation to single precision. That loses up to 6 % of the distance from a height of a metre,
    and the haze in front of the ground is proportional to this distance.
    """
    radius, ground = np.float32(radius), np.float32(GROUND)
    fall = radius * np.float32(sine)
    root = fall * fall - (radius * radius - ground * ground)
    return 0.0 if fall > 0.0 or root < 0.0 else float(-fall - np.sqrt(root))


def _row(latitude, azimuth, elevation, radius, height, known, steps, densities) -> np.ndarray:
    sine, cosine = np.sin(latitude), np.cos(latitude)
    step = (_distance_to_ground(radius, sine) or distance_to_shell(radius, sine, SHELL)) / STEPS
    along = (np.arange(STEPS) + 0.5) * step
    radii, heights = heights_along(radius, height, sine, along)
    heights = np.maximum(heights, 0.0)
    matter = _matter(heights, densities)
    extinction = _EXTINCTION.T @ matter  # (wavelength, step)
    depth = step * np.cumsum(extinction, axis=1)
    passed = np.exp(step * extinction - depth) - np.exp(-depth)
    weight = _SUN[:, None] * passed / np.maximum(extinction, 1e-7)
    air, aerosol = weight * np.outer(_AIR, matter[0]), weight * np.outer(_AEROSOL, matter[1])

    # To the sun, from every step of every azimuth: only the angle to the zenith matters.
    to_sun = cosine * np.cos(azimuth) * np.cos(elevation) + sine * np.sin(elevation)
    rise = ((radius * np.sin(elevation) + along[:, None] * to_sun) / radii[:, None]).astype(np.float32)
    level = np.minimum(heights / THICKNESS, 1.0) * (_HEIGHTS - 1)
    lower = np.minimum(level.astype(np.int64), _HEIGHTS - 2)
    level = (level - lower).astype(np.float32)[:, None]
    place = np.clip(0.5 * rise + 0.5, 0.0, 1.0) * np.float32(_SINES - 1)
    column = np.minimum(place.astype(np.int64), _SINES - 2)
    place -= column
    first = column + _SINES * np.arange(STEPS)[:, None]
    solid_angle = 2.0 * np.pi * (1.0 - np.sqrt(np.maximum(1.0 - (GROUND / radii) ** 2, 0.0)))  # of the ground
    around = 1.0 / (1.0 + 5.0 * np.exp(np.float32(-17.92) * rise))
    single, diffuse = np.empty((2, 4, COLUMNS)), np.empty((4, COLUMNS))
    # One wavelength at a time: arrays that stay in the cache.
    for index, (at_ground, flow) in enumerate(zip(known[:, 0], np.stack((air, aerosol), axis=1).astype(np.float32))):
        here = known[index, lower] + level * steps[index, lower]
        low = here.take(first, mode="clip")
        single[:, index] = flow @ (low + place * (here.take(first + 1, mode="clip") - low))
        low = at_ground.take(column, mode="clip")
        ground = (low + place * (at_ground.take(column + 1, mode="clip") - low)) * rise
        flow = flow[0] + flow[1]
        # Upwards, from the ground and from here: where nothing comes down, nothing came to the ground either.
        to_ground = np.divide(at_ground[-1], here[:, -1], out=np.zeros(STEPS, np.float32), where=here[:, -1] > 0.0)
        diffuse[index] = (flow * to_ground * solid_angle * (_ALBEDO / (4.0 * np.pi**2))).astype(np.float32) @ ground
        diffuse[index] += _MANIFOLD[index] * (flow @ around)
    rayleigh = 3.0 / (16.0 * np.pi) * (1.0 + to_sun**2)
    square = _ASYMMETRY**2
    mie = (1.0 - square) / (4.0 * np.pi * (1.0 + square - 2.0 * _ASYMMETRY * to_sun) ** 1.5)
    return (rayleigh * single[0] + mie * single[1] + diffuse).T @ _TO_RGB
