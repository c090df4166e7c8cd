# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera rays, with the lens and the pixel filter sampled; conventions are those of Cycles."""

from __future__ import annotations

import numpy as np

from ..scene import Projection, Scene
from ..settings import Filter
from .vectors import disk, dot, normalize


class Camera:
    """``pixel_angle``: angle (radians) of a pixel in the middle of the frame, 0 where rays are parallel."""

    def __init__(self, scene: Scene):
        self.scene, self.camera, self.settings = scene, scene.camera, scene.settings
        panorama = self.camera.projection is Projection.EQUIRECTANGULAR
        self.window = (*self.camera.longitude, *self.camera.latitude) if panorama else self.camera.window
        parallel = self.camera.projection is Projection.ORTHOGRAPHIC
        self.pixel_angle = 0.0 if parallel else abs(self.window[1] - self.window[0]) / scene.width

    def filter_offsets(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Offsets (count, 2) from the middle of a pixel, distributed as the pixel filter, by rejection."""
        width = self.settings.filter_width
        if self.settings.filter is Filter.BOX:
            return rng.random((count, 2)) - 0.5
        if self.settings.filter is Filter.GAUSSIAN:
            radius, weight = 1.5 * width, lambda x: np.exp(-8.0 * (x / width)**2)
        else:
            radius = width
            terms = (0.35875, 0.48829, 0.14128, 0.01168)  # Harris 1978
            weight = lambda x: sum(a * np.cos(k * np.pi * x / width) for k, a in enumerate(terms))
        offsets = np.zeros(2 * count)
        missing = np.arange(2 * count)
        while len(missing):
            trial = radius * (2.0 * rng.random(len(missing)) - 1.0)
            accepted = rng.random(len(missing)) < weight(trial)
            offsets[missing[accepted]] = trial[accepted]
            missing = missing[~accepted]
        return offsets.reshape(count, 2)

    def _lens(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Points of the lens (count, 2) in metres; ``blade_rotation`` is the angle of the middle of a side."""
        camera = self.camera
        if camera.blades < 3:
            points = disk(rng, count)
        else:
            corner = rng.integers(camera.blades, size=count)
            corners = camera.blade_rotation + (2.0 * (corner + np.array([[0], [1]])) - 1.0) * np.pi / camera.blades
            a, b = np.sort(rng.random((2, count)), axis=0)  # uniform in the triangle of the centre and two corners
            shares = np.stack([a, b - a])
            points = np.stack([(shares * np.cos(corners)).sum(0), (shares * np.sin(corners)).sum(0)], -1)
        return camera.aperture * points / [camera.blade_ratio, 1.0]

    def rays(self, x: np.ndarray, y: np.ndarray, rng: np.random.Generator):
        """(origins, unit directions, near, far) in world space of one sample of each of the pixels (x, y)."""
        camera, count = self.camera, len(x)
        frame = (np.stack([x, y], -1) + 0.5 + self.filter_offsets(rng, count)) / [self.scene.width, self.scene.height]
        left, right, bottom, top = self.window
        sx, sy = (np.array([left, bottom]) + frame * [right - left, top - bottom]).T
        one, zero = np.ones(count), np.zeros(count)
        origins = np.zeros((count, 3))
        lens_x, lens_y = np.broadcast_to([[1.0, 0.0, 0.0]], (count, 3)), np.broadcast_to([[0.0, 1.0, 0.0]], (count, 3))
        if camera.projection is Projection.PERSPECTIVE:
            directions = np.stack([sx, sy, -one], -1)
        elif camera.projection is Projection.ORTHOGRAPHIC:
            origins, directions = np.stack([sx, sy, zero], -1), np.stack([zero, zero, -one], -1)
        else:
            directions = np.stack([np.cos(sy) * np.sin(sx), np.sin(sy), -np.cos(sy) * np.cos(sx)], -1)
            lens_x = normalize(np.cross(directions, [0.0, 1.0, 0.0]))
            lens_y = np.cross(lens_x, directions)
        if camera.aperture > 0.0:
            focused = origins + camera.focus * directions
            lens = self._lens(rng, count)
            origins = origins + lens[:, :1] * lens_x + lens[:, 1:] * lens_y
            directions = (focused - origins) / camera.focus
        along = one if camera.projection is Projection.EQUIRECTANGULAR else np.sqrt(dot(directions, directions))
        matrix = np.asarray(camera.matrix, float)
        return (origins @ matrix[:3, :3].T + matrix[:3, 3], normalize(directions) @ matrix[:3, :3].T,
                camera.clip[0] * along, camera.clip[1] * along)

    def depth(self, positions: np.ndarray) -> np.ndarray:
        """Depth as in Blender: along the viewing axis, from the camera for panoramas."""
        matrix = np.asarray(self.camera.matrix, float)
        offset = positions - matrix[:3, 3]
        if self.camera.projection is Projection.EQUIRECTANGULAR:
            return np.sqrt(dot(offset, offset))
        return -offset @ matrix[:3, 2]
