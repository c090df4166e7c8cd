# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that surfaces scatter again and again, by light paths and path reuse: in an integrating sphere.

A sphere of diffuse surfaces spreads all that it scatters evenly, wherever the lamp is. With the albedo ρ, the area A
and the power P, the radiance of what n bounces add is ρ/π · P/A · (ρ + … + ρⁿ) everywhere.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sdf_lights.render.scene import Camera, Instance, Lamp, Scene
from sdf_lights.render.settings import LampPaths, PathReuse
from sdf_lights.sdf.shapes import Sphere
from support.scenes import diffuse, look_at, scaling, sphere, translation

from . import Figure, case
from .stage import ALBEDO, FLOAT32, picture, settings

PIXELS = 16
POWER = 40.0  # W
BOUNCES = 3
COLUMNS, ROWS = 128, 64  # of the mesh
# Faces may be inside the sphere by this part of its radius, so the light is not quite even.
INSCRIBED = 1.0 - math.cos(math.pi / COLUMNS)
QUICK_SEEDS, SEEDS = 8, 24
# Of Student's distributions with as many seeds: standard errors that a mean exceeds by chance once in 16,000.
QUICK_ERRORS, ERRORS = 8.5, 4.9
MIDDLE = 0.0, 0.0, 0.0


def in_a_sphere(
    quick: bool,
    lamp_paths: LampPaths,
    path_reuse: PathReuse,
    lamp: tuple[float, float] = (0.1, 0.4),
    radius: float = 1.0,
    at: tuple[float, float, float] = MIDDLE,
) -> Figure:
    """The deviation of what bounces add. ``lamp``: radius of a ball and distance of its middle from the wall, as parts
    of the ``radius`` of the sphere around ``at``."""
    place = translation(*at) @ scaling(radius, radius, radius)
    size, distance = lamp
    scene = Scene(
        Camera(
            translation(*at) @ look_at(MIDDLE, (radius, 0.0, 0.0)),
            window=(-0.5, 0.5, -0.5, 0.5),
            clip=(1e-3 * radius, 4.0 * radius),
        ),
        PIXELS,
        PIXELS,
        meshes=[sphere(columns=COLUMNS, rows=ROWS, smooth=False)],
        materials=[diffuse((ALBEDO,) * 3)],
        instances=[Instance(0, place, (0,), "sphere")],
        lamps=[Lamp("ball", Sphere(size), place @ translation(distance - 1.0, 0.0, 0.0), POWER)],
    )

    def mean(bounces: int, seed: int) -> float:
        plain = settings(16 if quick else 64, seed, bounces=bounces)
        scene.settings = replace(plain, indirect_paths=4, lamp_paths=lamp_paths, path_reuse=path_reuse)
        return float(picture(scene).mean())

    seeds = range(QUICK_SEEDS if quick else SEEDS)
    found = np.array([mean(BOUNCES, seed) - mean(0, seed) for seed in seeds])
    a, b, c = (scene.meshes[0].positions.astype(float)[corner] for corner in scene.meshes[0].triangles.T)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() * radius**2
    expected = ALBEDO / math.pi * POWER / area * sum(ALBEDO**bounce for bounce in range(1, BOUNCES + 1))
    error = float(found.std(ddof=1) / math.sqrt(len(found)) / expected)
    lost = float(np.max(np.abs(at))) * FLOAT32 / radius  # by which float32 may move a corner
    limit = (QUICK_ERRORS if quick else ERRORS) * error + 2.0 * INSCRIBED + 3.0 * lost
    return Figure(abs(float(found.mean()) / expected - 1.0), limit, dict(standard_error=error))


@case("light-paths-in-a-sphere")
def light_paths(quick):
    """relative error of scattered light in a sphere, by light paths"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.NEVER)


@case("path-reuse-in-a-sphere")
def path_reuse(quick):
    """relative error of scattered light in a sphere, by path reuse"""
    return in_a_sphere(quick, LampPaths.NEVER, PathReuse.ALWAYS)


@case("scattered-light-in-a-sphere")
def both(quick):
    """relative error of scattered light in a sphere, by light paths and path reuse"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.ALWAYS)


@case("lamp-beside-a-wall")
def beside_a_wall(quick):
    """relative error of scattered light of a lamp 0.2 mm wide and 1 mm from the wall of a sphere 2 m wide, by light
    paths"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.NEVER, lamp=(1e-4, 1e-3))


@case("scattered-light-in-a-tiny-sphere")
def tiny(quick):
    """relative error of scattered light in a sphere 2 mm wide"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.ALWAYS, radius=1e-3)


@case("scattered-light-in-a-huge-sphere")
def huge(quick):
    """relative error of scattered light in a sphere 20 km wide"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.ALWAYS, radius=1e4)


@case("scattered-light-far-from-the-origin")
def far(quick):
    """relative error of scattered light 26 km from the origin, in a sphere 2 m wide"""
    return in_a_sphere(quick, LampPaths.ALWAYS, PathReuse.ALWAYS, at=(12345.678, -23456.789, 3456.789))
