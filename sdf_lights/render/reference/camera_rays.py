# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera rays with sampled lens and pixel filter; conventions are those of Cycles."""

from __future__ import annotations

import numpy as np

from ..scene import Projection, Scene
from ..settings import Filter
from .vectors import disk, dot, normalize


class Camera:
    """``pixel_angle``: angle (radians) of a pixel in the middle of the frame, 0 if rays are parallel."""

    def __init__(self, scene: Scene):
        self.scene, self.camera, self.settings = scene, scene.camera, scene.settings
        self.window, self.panorama = self.camera.window, self.camera.projection >= Projection.EQUIRECTANGULAR
        size = abs(self.window[1] - self.window[0]) / scene.width
        self.pixel_angle = self._angle() * size
        self.pixel_width = size if self.camera.projection is Projection.ORTHOGRAPHIC else 0.0

    def _angle(self) -> float:
        """Angle between the rays of two points of the window close to its origin, by their distance."""
        if self.camera.projection is Projection.PERSPECTIVE:
            return 1.0
        if self.camera.projection is Projection.ORTHOGRAPHIC:
            return 0.0
        step = 1e-6
        a, b = self._directions(np.array([step, 2.0 * step]), np.zeros(2))
        return float(np.linalg.norm(b - a)) / step

    def filter_offsets(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Offsets (count, 2) from the middle of a pixel, distributed as the pixel filter, by rejection."""
        width = self.settings.filter_width
        if self.settings.filter is Filter.BOX:
            return rng.random((count, 2)) - 0.5
        if self.settings.filter is Filter.GAUSSIAN:
            radius, weight = 1.5 * width, lambda x: np.exp(-8.0 * (x / width) ** 2)
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

    def _directions(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Directions (N, 3) of a panorama at points of its window, zero outside the picture."""
        camera, kind = self.camera, self.camera.projection
        if kind is Projection.EQUIRECTANGULAR:
            return np.stack([np.cos(y) * np.sin(x), np.sin(y), -np.cos(y) * np.cos(x)], -1)
        if kind is Projection.CYLINDER:
            return normalize(np.stack([np.sin(x), y, -np.cos(x)], -1))
        if kind is Projection.CUBEMAP_FACE:
            return normalize(np.stack([np.tan(x), np.tan(y), -np.ones_like(x)], -1))
        r, phi = np.hypot(x, y), np.arctan2(y, x)
        if kind is Projection.MIRROR_BALL:
            # The view along −z is mirrored by the ball's normal at (x, y).
            normal = np.stack([x, y, np.sqrt(np.maximum(1.0 - r * r, 0.0))], -1)
            directions = 2.0 * normal[:, 2:] * normal - [0.0, 0.0, 1.0]
            return np.where(r[:, None] <= 1.0, directions * [1.0, 1.0, -1.0], 0.0)
        theta = {
            Projection.FISHEYE_EQUIDISTANT: lambda: r,
            Projection.FISHEYE_EQUISOLID: lambda: np.where(r <= 1.0, 2.0 * np.arcsin(np.minimum(r, 1.0)), np.inf),
            Projection.FISHEYE_POLYNOMIAL: lambda: -np.polynomial.polynomial.polyval(r, camera.lens),
        }[kind]()
        shown = np.abs(theta) <= 0.5 * camera.field
        theta = np.where(shown & np.isfinite(theta), theta, 0.0)
        directions = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)], -1)
        return np.where((shown & np.isfinite(r))[:, None], directions, 0.0)

    def _eye(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rays from an eye that turns with the direction."""
        eye = self.camera.eye
        altitude = np.abs(np.arcsin(np.clip(directions[:, 1], -1.0, 1.0)))
        share = np.ones(len(directions))
        if eye.merge is not None:
            start, end = eye.merge
            fade = np.clip((altitude - start) / (end - start), 0.0, 1.0) if end > start else altitude > end
            share = np.where(altitude > end, 0.0, np.cos(0.5 * np.pi * fade))
        side = (share * eye.offset)[:, None] * normalize(np.cross(directions, [0.0, 1.0, 0.0]))
        if np.isfinite(eye.convergence):
            directions = normalize(eye.convergence * directions - side)
        return origins + side, directions

    def rays(self, x: np.ndarray, y: np.ndarray, rng: np.random.Generator):
        """(origins, unit directions, near, far) in world space of one sample of each of the pixels (x, y); far is
        negative where a panorama shows nothing."""
        camera, count = self.camera, len(x)
        frame = (np.stack([x, y], -1) + 0.5 + self.filter_offsets(rng, count)) / [self.scene.width, self.scene.height]
        left, right, bottom, top = self.window
        sx, sy = (np.array([left, bottom]) + frame * [right - left, top - bottom]).T
        one, zero = np.ones(count), np.zeros(count)
        origins, empty = np.zeros((count, 3)), np.zeros(count, bool)
        lens_x, lens_y = np.broadcast_to([[1.0, 0.0, 0.0]], (count, 3)), np.broadcast_to([[0.0, 1.0, 0.0]], (count, 3))
        if camera.projection is Projection.PERSPECTIVE:
            directions = np.stack([sx, sy, -one], -1)
        elif camera.projection is Projection.ORTHOGRAPHIC:
            origins, directions = np.stack([sx, sy, zero], -1), np.stack([zero, zero, -one], -1)
        else:
            directions = self._directions(sx, sy)
            lens_x = normalize(np.cross(directions, [0.0, 1.0, 0.0]))
            lens_y = np.cross(lens_x, directions)
            empty = ~directions.any(1)
            directions = np.where(empty[:, None], [0.0, 0.0, -1.0], directions)
        if camera.aperture > 0.0:
            focused = origins + camera.focus * directions
            lens = self._lens(rng, count)
            origins = origins + lens[:, :1] * lens_x + lens[:, 1:] * lens_y
            directions = (focused - origins) / camera.focus
        along = one if self.panorama else np.sqrt(dot(directions, directions))
        if self.panorama and camera.eye is not None:
            origins, directions = self._eye(origins, normalize(directions))
        matrix = np.asarray(camera.matrix, float)
        return (
            origins @ matrix[:3, :3].T + matrix[:3, 3],
            normalize(directions) @ matrix[:3, :3].T,
            np.where(empty, 0.0, camera.clip[0] * along),
            np.where(empty, -1.0, camera.clip[1] * along),
        )

    def window_place(self, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position in the frame, 0 to 1 from its lower left corner, of points (N, 3) in camera space; 0 for those
        behind a perspective camera."""
        x, y, depth = seen[:, 0], seen[:, 1], -seen[:, 2]
        if self.panorama:
            x, y = self._panorama_place(x, y, depth)
        elif self.camera.projection is Projection.PERSPECTIVE:
            safe = np.where(depth > 0.0, depth, 1.0)
            x, y = x / safe, y / safe
        left, right, bottom, top = self.window
        x, y = (x - left) / (right - left), (y - bottom) / (top - bottom)
        if self.camera.projection is Projection.PERSPECTIVE:
            x, y = (np.where(depth > 0.0, place, 0.0) for place in (x, y))
        return x, y

    def _panorama_place(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the window of a panorama; z points into the picture."""
        kind = self.camera.projection
        if kind in {Projection.EQUIRECTANGULAR, Projection.CYLINDER, Projection.CUBEMAP_FACE}:
            height = {
                Projection.EQUIRECTANGULAR: lambda: np.arctan2(y, np.hypot(x, z)),
                Projection.CYLINDER: lambda: y / np.maximum(np.hypot(x, z), 1e-300),
                Projection.CUBEMAP_FACE: lambda: np.arctan2(y, z),
            }[kind]()
            return np.arctan2(x, z), height
        phi, theta = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
        if kind is Projection.FISHEYE_EQUIDISTANT:
            radius = theta
        elif kind is Projection.FISHEYE_POLYNOMIAL:
            polynomial = np.polynomial.Polynomial(self.camera.lens)
            slope, radius = polynomial.deriv(), (-theta - self.camera.lens[0]) / self.camera.lens[1]
            for _ in range(20):
                radius = radius - (polynomial(radius) + theta) / slope(radius)
        else:
            radius = np.sin(0.5 * theta)
        return radius * np.cos(phi), radius * np.sin(phi)

    def depth(self, positions: np.ndarray) -> np.ndarray:
        """Depth (N,) of positions (N, 3) as in Blender: along the viewing axis; for panoramas the distance from the
        camera."""
        matrix = np.asarray(self.camera.matrix, float)
        offset = positions - matrix[:3, 3]
        if self.panorama:
            return np.sqrt(dot(offset, offset))
        return -offset @ matrix[:3, 2]
