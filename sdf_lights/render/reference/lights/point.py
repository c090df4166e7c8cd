# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Point and spot lights. See ``emitter.py``."""

from __future__ import annotations

import numpy as np

from ...lights.point import PointLight, SpotLight
from ..vectors import disk, dot, normalize, to_world, uniform_cone, uniform_sphere
from .emitter import Emitter


class SphereLight(Emitter):
    """Point and spot lights: a point, a sphere, or with soft falloff a disk that faces the lit point.

    P watts are a radiant intensity of P / 4π, and so a radiance of P / (4π · πr²).
    """

    def __init__(self, light: PointLight):
        super().__init__(light.visibility, light.cast_shadow)
        matrix = np.asarray(light.matrix, float)
        self.center, self.radius, self.disk = matrix[:3, 3], light.radius, light.soft_falloff
        self.intensity = light.power / (4.0 * np.pi) * np.asarray(light.color, float)
        self.singular = light.radius == 0.0
        self.to_local = None
        if isinstance(light, SpotLight):
            self.to_local = np.linalg.inv(matrix[:3, :3])
            self.cosine = np.cos(light.angle / 2.0)
            self.smooth = (1.0 - self.cosine) * light.blend

    def _radiance(self, wi):
        """Intensity (for a point) or radiance sent along −wi; a spot fades by a smooth step in the cosine."""
        value = self.intensity if self.singular else self.intensity / (np.pi * self.radius**2)
        if self.to_local is None:
            return np.broadcast_to(value, wi.shape)
        z = normalize(wi @ self.to_local.T)[:, 2] - self.cosine
        f = np.clip(z / self.smooth, 0.0, 1.0) if self.smooth > 0.0 else (z > 0.0).astype(float)
        return value * (f * f * (3.0 - 2.0 * f))[:, None]

    def sample(self, rng, x):
        to = self.center - x
        square = np.maximum(dot(to, to), 1e-300)
        axis = to / np.sqrt(square)[:, None]
        if self.singular:
            return axis, np.sqrt(square), self._radiance(axis) / square[:, None], np.ones(len(x))
        if self.disk:
            place = self.radius * disk(rng, len(x))
            towards = to + to_world(np.concatenate([place, np.zeros((len(x), 1))], 1), axis)
            distance = np.linalg.norm(towards, axis=1)
            wi = towards / distance[:, None]
        else:
            r2 = self.radius**2
            inside = square <= r2
            sine2 = np.minimum(r2 / square, 1.0)
            cone = uniform_cone(rng, axis, sine2 / (1.0 + np.sqrt(1.0 - sine2)))
            wi = np.where(inside[:, None], uniform_sphere(rng, len(x)), cone)
        distance, radiance, pdf = self.hit(x, wi)
        return wi, distance, radiance, pdf

    def hit(self, origins, directions):
        if self.singular:
            return super().hit(origins, directions)
        to = self.center - origins
        square, along, r2 = dot(to, to), dot(to, directions), self.radius**2
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.disk:
                distance = square / along
                found = (along > 0.0) & (distance**2 - square <= r2)
                pdf = distance**2 * np.sqrt(square) / (along * np.pi * r2)
                radiance = self._radiance(directions)
            else:
                root = along**2 - square + r2
                inside = square <= r2
                distance = along + np.where(inside, 1.0, -1.0) * np.sqrt(np.maximum(root, 0.0))
                found = (root >= 0.0) & (distance > 0.0)
                sine2 = np.minimum(r2 / square, 1.0)
                height = sine2 / (1.0 + np.sqrt(1.0 - sine2))
                pdf = 1.0 / (2.0 * np.pi * np.where(inside, 2.0, height))
                whole = np.broadcast_to(self.intensity / (np.pi * r2), directions.shape)
                radiance = np.where(inside[:, None], whole, self._radiance(directions))
        return np.where(found, distance, np.inf), np.where(found[:, None], radiance, 0.0), np.where(found, pdf, 0.0)


EMITTERS = {PointLight: SphereLight, SpotLight: SphereLight}
