# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces of a lamp that coincide with surfaces: no speckles, no lost light, no light in wrong places."""

from __future__ import annotations

import math

import numpy as np

from sdf_lights.render.scene import Camera, Instance, Lamp, Projection, Scene
from sdf_lights.sdf.shapes import Box
from support.scenes import box, diffuse, look_at, quad, scaling, translation

from . import Figure, attraction, case
from .stage import ALBEDO, FLOAT32, deviation, floor, from_above, picture, places, settings

PIXELS = 32
WIDTH = 2.0  # m, of the floor that the camera sees
HALF = np.array((0.43, 0.31, 0.27))  # m, of a lamp that stands on the floor
DENSITY = 3.0  # W/(sr m³)
ORIGIN = (0.0, 0.0, 0.0)


def standing() -> list[Lamp]:
    """A box on the floor, whose lower face lies in the floor."""
    return [Lamp("lamp", Box(tuple(HALF)), translation(0.0, 0.0, HALF[2]), density=DENSITY)]


def beside(points: np.ndarray) -> np.ndarray:
    """Pixels (of ``places``) that see neither the lamp itself nor its edges."""
    pixel = WIDTH / PIXELS
    return (np.abs(points[:, :2]) > HALF[:2] + pixel).any(axis=1)


def lit(quick: bool) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of the floor, and their true values: light scattered there, and the lamp in front of it."""
    camera = from_above(ORIGIN, 2.0, WIDTH)
    found = picture(floor(camera, PIXELS, ORIGIN, 3.0, standing(), settings(256 if quick else 4096)))
    # The mean over each pixel, from 4 × 4 points.
    points = places(ORIGIN, WIDTH, 4 * PIXELS)
    low, high = np.array((-HALF[0], -HALF[1], 0.0)), np.array((HALF[0], HALF[1], 2.0 * HALF[2]))
    expected = ALBEDO / math.pi * attraction.of_box(low, high, points, DENSITY)
    expected += np.where((np.abs(points[:, :2]) < HALF[:2]).all(axis=1), 2.0 * HALF[2] * DENSITY, 0.0)
    return found, expected.reshape(PIXELS, 4, PIXELS, 4).mean(axis=(1, 3))


@case("lamp-on-a-floor-energy")
def energy(quick):
    """relative error of the light on a floor that a face of the lamp lies in"""
    found, expected = lit(quick)
    away = beside(places(ORIGIN, WIDTH, PIXELS)).reshape(found.shape)
    # The error of the mean of 4 × 4 points from the curvature over a pixel, relative to the lamp's height.
    return deviation(found[away], expected[away], (WIDTH / PIXELS / 4.0 / HALF[2]) ** 2 / 12.0)


@case("lamp-on-a-floor-acne")
def acne(quick):
    """largest relative error of a pixel of that floor, beside the lamp and under it: speckles would be near 1"""
    found, expected = lit(quick)
    points = places(ORIGIN, WIDTH, PIXELS)
    whole = beside(points) | (np.abs(points[:, :2]) < HALF[:2] - WIDTH / PIXELS).all(axis=1)
    errors = np.abs(found / expected - 1.0).ravel()[whole]
    # 0.1 is invisible as a speckle; the scatter of a correct pixel is a hundredth.
    return Figure(float(errors.max()), 0.1, dict(rms=float(np.sqrt(np.mean(errors**2)))))


@case("lamp-on-a-floor-leak")
def leak(quick):
    """light on a second floor 10 µm under the one that a face of the lamp lies in, relative to that on the first"""
    camera = from_above(ORIGIN, -2.0, WIDTH)
    scene = floor(camera, PIXELS, ORIGIN, 3.0, standing(), settings(64 if quick else 1024))
    scene.instances.append(Instance(0, translation(0.0, 0.0, -1e-5) @ scaling(3.0, 3.0, 1.0), (0,), "cellar"))
    top = picture(floor(from_above(ORIGIN, 2.0, WIDTH), PIXELS, ORIGIN, 3.0, standing(), settings(64)))
    return Figure(float(picture(scene).max() / top.max()), 0.0)


@case("lamp-in-a-box-leak")
def boxed(quick):
    """what a camera sees of a lamp that fills a box of the same size, relative to what it would see without the box"""
    matrix = translation(0.1, 0.2, 0.3) @ scaling(*HALF)
    lamps = [Lamp("lamp", Box((1.0, 1.0, 1.0)), matrix, density=DENSITY)]
    distance = 4.0
    camera = Camera(look_at((distance, -distance, 2.0), (0.1, 0.2, 0.3)), window=(-0.15, 0.15, -0.15, 0.15))
    made = []
    for instances in ([], [Instance(0, matrix, (0, 0, 0), "box")]):
        made.append(
            picture(
                Scene(
                    camera,
                    PIXELS,
                    PIXELS,
                    meshes=[box()],
                    materials=[diffuse((0.0,) * 3)],
                    instances=instances,
                    lamps=lamps,
                    settings=settings(64 if quick else 1024),
                )
            )
        )
    # A ray stops at the float32 box, which is within a rounding of its coordinates, seen along the ray, of the lamp's
    # face; grazing pixels see more of that, but not ten times.
    reach = 2.0 * distance * FLOAT32 * 10.0
    return Figure(float(made[1].mean() / made[0].mean()), reach / float(HALF.min()))


@case("lamp-behind-a-wall-leak")
def wall(quick):
    """light in a room behind a wall 1 mm thick, one side of which is a face of the lamp, relative to that before it"""
    depth = 1e-3
    lamps = [Lamp("lamp", Box(tuple(HALF)), translation(0.0, 0.0, HALF[2] + depth), density=DENSITY)]
    slab = Instance(1, translation(0.0, 0.0, 0.5 * depth) @ scaling(3.0, 3.0, 0.5 * depth), (0, 0, 0), "wall")
    made = []
    for height in (2.0, -2.0):
        eye = np.array((0.0, 0.0, height))
        camera = Camera(look_at(eye, ORIGIN, (0.0, 1.0, 0.0)), Projection.ORTHOGRAPHIC, (-1.0, 1.0, -1.0, 1.0))
        made.append(
            picture(
                Scene(
                    camera,
                    PIXELS,
                    PIXELS,
                    meshes=[quad(), box()],
                    materials=[diffuse((ALBEDO,) * 3)],
                    instances=[slab],
                    lamps=lamps,
                    settings=settings(64 if quick else 1024, bounces=2),
                )
            )
        )
    return Figure(float(made[1].max() / made[0].max()), 0.0)
