# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of a floor under lamps of extreme size, position and shape, compared with the attraction of the same
bodies."""

from __future__ import annotations

import math

import numpy as np

from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.render.scene import Camera, Lamp, Scene
from sdf_lights.sdf.shapes import Difference, Sphere
from support.lamps.shapes_under_test import sheared
from support.scenes import look_at, rotation, scaling, translation

from . import Figure, attraction, case
from .stage import (
    ALBEDO,
    FLOAT32,
    STANDARD_ERRORS,
    deviation,
    floor,
    from_above,
    picture,
    places,
    settings,
    volumes_unknown,
)

PIXELS = 16
POWER = 40.0  # W
BALL = Sphere(1.0)
ORIGIN = (0.0, 0.0, 0.0)
THIN = 3e-4  # of the radius of a shell
PATCH = 1e-2  # width of the visible floor, relative to ``size``
# Maximum relative effect on a pixel of the curvature of the irradiance over it: (width/distance)²/4.
CURVATURE = (PATCH / PIXELS) ** 2


def rounding(lamps: list[Lamp], expected: float, at=ORIGIN) -> float:
    """Maximum relative error of the pixels' mean for any number of samples: float32, volumes of boxes."""
    up = np.array((0.0, 0.0, 1.0))
    unknown = math.hypot(*(volumes_unknown(lamp, np.asarray(at, float), up) for lamp in lamps))
    return CURVATURE + 16.0 * FLOAT32 + STANDARD_ERRORS * unknown * ALBEDO / math.pi / expected


def under(matrices: list[np.ndarray], quick: bool, size: float = 1.0, at=ORIGIN, lost: float = 0.0) -> Figure:
    """A floor at ``at`` under unit balls with these matrices, which are above it and about ``size`` away.

    ``lost``: metres by which float32 may move the floor.
    """
    shift = translation(*at)
    lamps = [Lamp(f"lamp {index}", BALL, shift @ matrix, POWER) for index, matrix in enumerate(matrices)]
    camera = from_above(at, 0.05 * size, PATCH * size)
    found = picture(floor(camera, PIXELS, at, 0.1 * size, lamps, settings(64 if quick else 1024)))
    points = places(ORIGIN, PATCH * size, PIXELS)
    expected = sum(attraction.of_ellipsoid(matrix, points, (0.0, 0.0, 1.0)) for matrix in matrices)
    expected *= ALBEDO / math.pi * attraction.intensity(POWER)
    # The light of bodies above falls off no faster than the cube of the distance.
    return deviation(found, expected.reshape(found.shape), rounding(lamps, expected.mean(), at) + 3.0 * lost / size)


def ball(radius: float, *at: float) -> np.ndarray:
    return translation(*at) @ scaling(radius, radius, radius)


@case("one-millimetre-lamp")
def one_millimetre_lamp(quick):
    """relative error of the light of a ball 1 mm wide, 1 m away"""
    return under([ball(5e-4, 0.3, -0.2, 1.0)], quick)


@case("ten-kilometres-away")
def ten_kilometres_away(quick):
    """relative error of the light of a ball 1 m wide, 10 km away"""
    return under([ball(0.5, 3e3, -2e3, 1e4)], quick)


@case("tiny-scene")
def tiny_scene(quick):
    """relative error of the light in a scene 1 mm large"""
    return under([ball(4e-4, 3e-4, -2e-4, 1e-3)], quick, 1e-3)


@case("huge-scene")
def huge_scene(quick):
    """relative error of the light in a scene 10 km large"""
    return under([ball(4e3, 3e3, -2e3, 1e4)], quick, 1e4)


@case("far-from-the-origin")
def far_from_the_origin(quick):
    """relative error of the light 26 km from the origin, of a lamp 1 m away"""
    at = (12345.678, -23456.789, 3456.789)
    return under([ball(0.4, 0.3, -0.2, 1.0)], quick, at=at, lost=float(np.max(np.abs(at))) * FLOAT32)


@case("stretched-1-to-10000")
def stretched(quick):
    """relative error of the light of a ball stretched 1 : 10,000, 10 m long and 1 mm thin"""
    turned = translation(0.3, -0.1, 1.2) @ rotation("z", 30.0) @ rotation("y", 3.0) @ rotation("x", 20.0)
    return under([turned @ scaling(5.0, 0.05, 5e-4)], quick)


@case("sheared")
def sheared_ball(quick):
    """relative error of the light of a ball that is sheared by 3 and turned"""
    matrix = translation(0.1, 0.2, 1.3) @ rotation("x", 25.0) @ sheared(3.0) @ scaling(0.2, 0.2, 0.3)
    return under([matrix], quick)


@case("mirrored")
def mirrored(quick):
    """relative error of the light of a ball that is mirrored, sheared and stretched"""
    matrix = translation(0.1, 0.2, 1.3) @ rotation("y", 25.0) @ scaling(-0.4, 0.2, 0.3) @ sheared(1.0)
    return under([matrix], quick)


NESTED = [
    ball(0.6, 0.1, -0.1, 1.1),
    ball(0.2, 0.2, -0.1, 1.2),
    ball(0.5, 0.5, 0.1, 1.0),
    translation(-0.2, 0.1, 1.2) @ scaling(0.9, 0.1, 0.1),
    ball(0.6, 0.1, -0.1, 1.1),
]


@case("nested-lamps-on-a-floor")
def nested_lamps_on_a_floor(quick):
    """relative error of the light of five lamps, nested, overlapping, and two the same: it is the sum"""
    return under(NESTED, quick)


@case("nested-lamps-seen")
def nested_lamps_seen(quick):
    """largest error of a pixel that sees the same lamps, relative to the sum of what it sees of each"""

    def seen(matrices):
        camera = Camera(look_at((0.1, -4.0, 1.1), (0.1, 0.0, 1.1)), window=(-0.4, 0.4, -0.4, 0.4))
        lamps = [Lamp("lamp", BALL, matrix, POWER) for matrix in matrices]
        return picture(Scene(camera, PIXELS, PIXELS, lamps=lamps, settings=settings(16)))

    total = sum(seen([matrix]) for matrix in NESTED)
    return Figure(float(np.abs(seen(NESTED) - total).max() / total.max()), 1e-12)


@case("thin-shell-on-a-floor")
def thin_shell(quick):
    """relative error of the light of a shell 3e-4 of its radius thick, which is that of a point (Newton)"""
    radius, at = 0.5, (0.3, -0.2, 1.0)
    shell = Difference(Sphere(radius), Sphere(radius * (1.0 - THIN)))
    lamps = [Lamp("shell", shell, translation(*at), POWER)]
    camera = from_above(ORIGIN, 0.05, PATCH)
    found = picture(floor(camera, PIXELS, ORIGIN, 0.1, lamps, settings(64 if quick else 1024)))
    expected = attraction.of_ellipsoid(ball(radius, *at), places(ORIGIN, PATCH, PIXELS), (0.0, 0.0, 1.0))
    expected *= ALBEDO / math.pi * attraction.intensity(POWER)
    # Its volume is an estimate, whose error makes it brighter or darker as a whole, and is known here.
    row = build_lamp("shell", shell, np.eye(4)).row
    volume = 4.0 / 3.0 * math.pi * radius**3 * (1.0 - (1.0 - THIN) ** 3)
    off = abs(float(row["volume"][0]) / volume - 1.0)
    if off > row["volume_error"][0]:
        raise ValueError("its volume is off by more than it promises")
    return deviation(found, expected.reshape(found.shape), rounding(lamps, expected.mean()) + off)


@case("near-plane-in-a-lamp")
def near_plane(quick):
    """largest relative error of a pixel whose camera stands in a lamp, which begins at the clipping plane"""
    density, near, half, radius = 0.7, 0.25, 0.8, 1.5
    camera = Camera(look_at((0.0, 0.0, 0.0), (1.0, 2.0, 0.5)), window=(-half, half, -half, half), clip=(near, 100.0))
    lamp = Lamp("haze", Sphere(radius), np.eye(4), density=density)
    # The box filter of one pixel: the mean of 1/cos over it, by Simpson's rule on 64 × 64 parts.
    found = picture(Scene(camera, PIXELS, PIXELS, lamps=[lamp], settings=settings(4096 if quick else 65536)))
    parts = 64
    weights = np.r_[1.0, np.tile([4.0, 2.0], parts // 2)[:-1], 1.0] / (3.0 * parts)
    edges = np.linspace(-half, half, PIXELS * parts + 1)
    index = np.arange(PIXELS)[:, None] * parts + np.arange(parts + 1)
    along = np.sqrt(1.0 + edges[:, None] ** 2 + edges[None, :] ** 2)[index[:, None, :, None], index[None, :, None, :]]
    expected = density * (radius - near * np.einsum("ijkl,k,l->ij", along, weights, weights))
    # Sobol points integrate such a smooth function with an error of 1/samples.
    return Figure(float(np.abs(found / expected - 1.0).max()), (1.0 / 4096 if quick else 1.0 / 65536))


@case("surface-in-a-lamp")
def surface_in_a_lamp(quick):
    """relative error of how much lighter one side of a sheet in a lamp is than the other: that is the attraction"""
    matrix = translation(0.2, -0.1, 0.15) @ rotation("y", 20.0) @ scaling(0.9, 0.5, 0.6)
    lamps = [Lamp("lamp", BALL, matrix, POWER)]
    width = 1e-3
    sides = []
    for height in (width, -width):
        camera = from_above(ORIGIN, height, width)
        sides.append(picture(floor(camera, PIXELS, ORIGIN, 5.0, lamps, settings(1024 if quick else 8192))))
    # What the camera sees of the lamp in front of the sheet is the same on both sides.
    difference = sides[0] - sides[1]
    expected = attraction.of_ellipsoid(matrix, np.zeros((1, 3)), (0.0, 0.0, 1.0))[0]
    expected *= ALBEDO / math.pi * attraction.intensity(POWER)
    return deviation(difference, np.full(difference.shape, expected), rounding(lamps, expected) + width**2)
