# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for each kind of camera."""

from __future__ import annotations

from sdf_lights.render.scene import Camera, Projection, Scene

from .lamps import torus_room
from .matrices import look_at, scaling, translation
from .room import GREEN, HEIGHT, RED, WHITE, WIDTH, add, diffuse, room, torus_lamp


def depth_of_field(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A lens with five rotated, scaled blades, in focus on the middle of three balls; a lamp far out of focus."""
    scene = room(width, height)
    for i, color in enumerate((RED, WHITE, GREEN)):
        add(scene, 2, translation(i - 1.0, 1.2 * (i - 1), 0.5) @ scaling(0.4, 0.4, 0.4), diffuse(color))
    scene.camera.aperture, scene.camera.focus = 0.15, 5.5
    scene.camera.blades, scene.camera.blade_rotation, scene.camera.blade_ratio = 5, 0.3, 1.5
    scene.lamps.append(torus_lamp(0.0, 1.0, 2.2))
    return scene


def panorama(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Part of the room around an equirectangular camera between two lamps."""
    scene = room(width, height, max_bounces=2)
    scene.camera = Camera(
        look_at((0.2, 0.1, 1.3), (0, 2, 1.2)),
        Projection.EQUIRECTANGULAR,
        clip=(0.01, 100.0),
        window=(-3.0, 2.8, -1.2, 1.3),
    )
    scene.lamps += [torus_lamp(-0.9, 0.6, 1.6, 30.0, 0.6), torus_lamp(1.0, -0.8, 1.2, 20.0, 0.4)]
    return scene


def fisheye(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The room through a fisheye whose picture does not fill the frame."""
    scene = panorama(width, height)
    scene.camera = Camera(scene.camera.matrix, Projection.FISHEYE_EQUISOLID, (-0.9, 0.9, -0.7, 0.7), (0.01, 100.0), 3.0)
    return scene


def orthographic(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The torus room through an orthographic camera, clipped in depth."""
    scene = torus_room(width, height)
    half = 2.2 * height / width
    scene.camera = Camera(
        look_at((1.0, -5.0, 2.5), (0, 0, 1.4)),
        Projection.ORTHOGRAPHIC,
        window=(-2.2, 2.2, -half, half),
        clip=(0.1, 6.8),
    )
    return scene
