# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of lamps: for previews of lights in the Properties editor, and for assets.

Blender's preview scene for lights shows a ball lit by the light. A lamp has a shape, so its preview shows the lamp
itself, against a dark background, with a fixed brightness in the picture.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..render.scene import Camera, Lamp, Scene, World
from ..render.settings import Device, Settings

FROM = np.array([0.45, -0.85, 0.35])  # direction towards the camera
HALF_FIELD = 0.18  # half of the picture's width, at one metre from the camera
MARGIN = 1.1
GROUND = (0.02, 0.02, 0.02)
BRIGHT = 0.8  # mean radiance of the visible lamp
# The visible area of a shape of volume V is at most about this times V to the power of two thirds, unless it is thin
# everywhere.
SILHOUETTE = 3.0


def framed(scene: Scene) -> Scene:
    """The preview scene of its first lamp: only the lamp, before a dark background, in the middle of the picture."""
    from .viewport.facts import measured  # not at the top: it imports Numba

    lamp = scene.lamps[0]
    facts = measured(lamp.shape, lamp.emission)
    low, high = np.asarray(facts.low), np.asarray(facts.high)
    extent = np.maximum(high - low, 1e-9)
    middle = 0.5 * (low + high)
    shown = min(float(np.mean(extent[[1, 0, 0]] * extent[[2, 2, 1]])), SILHOUETTE * facts.volume ** (2.0 / 3.0))
    back = FROM / np.linalg.norm(FROM)
    distance = MARGIN * 0.5 * float(np.linalg.norm(extent)) / HALF_FIELD
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    matrix[:3, 3] = middle + distance * back
    across, up = (HALF_FIELD * side / min(scene.width, scene.height) for side in (scene.width, scene.height))
    camera = Camera(matrix, window=(-across, across, -up, up), clip=(1e-3 * distance, 1e3 * distance))
    alone = dataclasses.replace(
        lamp, matrix=np.eye(4), power=4.0 * math.pi * BRIGHT * max(shown, 1e-12), density=None, camera_brightness=1.0
    )
    return Scene(
        camera,
        scene.width,
        scene.height,
        lamps=[alone],
        world=World(GROUND),
        settings=scene.settings,
        border=scene.border,
    )


def picture_of(lamp: Lamp, size: int, samples: int = 8) -> np.ndarray:
    """(size, size, 4) display values of a lamp, row 0 at the bottom. Raises RenderError."""
    from ..render import session  # not at the top: it imports Numba

    settings = Settings(samples=samples, noise_threshold=0.0, max_bounces=0)
    if size * size * samples < 1 << 12:  # too few to justify compiling machine code
        settings.device = Device.REFERENCE
    scene = framed(Scene(Camera(None), size, size, lamps=[lamp], settings=settings))
    light = np.maximum(session.render(scene, ("Combined",)).read("Combined")[..., :3].astype(float), 0.0)
    light = 1.0 - np.exp(-1.5 * light)
    shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    return np.concatenate([shown, np.ones((size, size, 1))], axis=2).astype(np.float32)
