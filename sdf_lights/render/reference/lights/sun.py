# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sun lights. See ``emitter.py``."""

from __future__ import annotations

import numpy as np

from ...lights.sun import SunLight
from ..vectors import dot, normalize, uniform_cone
from .emitter import BACKGROUND, Emitter


class Sun(Emitter):
    """Irradiance ``strength`` on surfaces that face the sun, from a disk of uniform radiance in the sky."""

    def __init__(self, light: SunLight):
        super().__init__(light.visibility, light.cast_shadow)
        self.direction = normalize(np.asarray(light.matrix, float)[:3, 2])
        self.irradiance = light.strength * np.asarray(light.color, float)
        half = min(0.5 * light.angle, 0.5 * np.pi)
        self.singular = half == 0.0
        if not self.singular:
            self.one_minus_cos = 2.0 * np.sin(0.5 * half) ** 2
            self.radiance = self.irradiance / (np.pi * np.sin(half) ** 2)

    def sample(self, rng, x):
        axis = np.broadcast_to(self.direction, x.shape)
        far = np.full(len(x), np.inf)
        if self.singular:
            return axis, far, np.broadcast_to(self.irradiance, x.shape), np.ones(len(x))
        pdf = np.full(len(x), 1.0 / (2.0 * np.pi * self.one_minus_cos))
        return uniform_cone(rng, axis, self.one_minus_cos), far, np.broadcast_to(self.radiance, x.shape), pdf

    def hit(self, origins, directions):
        """The distance of a hit is a huge number, because inf means that there is none."""
        if self.singular:
            return super().hit(origins, directions)
        difference = directions - self.direction
        found = 0.5 * dot(difference, difference) <= self.one_minus_cos
        return (
            np.where(found, BACKGROUND, np.inf),
            np.where(found[:, None], self.radiance, 0.0),
            np.where(found, 1.0 / (2.0 * np.pi * self.one_minus_cos), 0.0),
        )


EMITTERS = {SunLight: Sun}
