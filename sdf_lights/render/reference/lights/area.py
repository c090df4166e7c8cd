# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights. See ``emitter.py``."""

from __future__ import annotations

import numpy as np

from ...lights.area import AreaLight
from ..vectors import disk, dot
from .emitter import Emitter


class Area(Emitter):
    """Rectangle or ellipse that emits along its local −z: P watts are a radiance of P / (π · area).

    A smaller spread s (half angle) scales radiance by (tan s − tan θ) / (tan s − s), like the slats of a grid.
    """

    def __init__(self, light: AreaLight):
        super().__init__(light.visibility, light.cast_shadow)
        matrix = np.asarray(light.matrix, float)
        self.center, axes = matrix[:3, 3], matrix[:3, :2] * (0.5 * np.asarray(light.size, float))
        self.half = np.linalg.norm(axes, axis=0)
        self.u, self.v = (axes / np.maximum(self.half, 1e-300)).T
        self.normal = -matrix[:3, 2] / max(np.linalg.norm(matrix[:3, 2]), 1e-300)
        self.ellipse = light.ellipse
        self.area = float(np.prod(self.half)) * (np.pi if light.ellipse else 4.0)
        self.radiance = light.power / (np.pi * max(self.area, 1e-300)) * np.asarray(light.color, float)
        half_spread = 0.5 * light.spread
        self.singular = half_spread <= 0.0  # a parallel beam
        self.tan_spread = np.tan(half_spread) if half_spread < 0.5 * np.pi - 1e-6 else np.inf
        self.spread_gain = 1.0 / max(self.tan_spread - half_spread, 1e-12) if np.isfinite(self.tan_spread) else 1.0

    def _inside(self, offset):
        """Whether points, relative to the centre, project onto the light."""
        a, b = (offset @ axis / max(half, 1e-300) for axis, half in ((self.u, self.half[0]), (self.v, self.half[1])))
        return a**2 + b**2 <= 1.0 if self.ellipse else (np.abs(a) <= 1.0) & (np.abs(b) <= 1.0)

    def sample(self, rng, x):
        if self.singular:
            height = (x - self.center) @ self.normal
            lit = self._inside(x - self.center) & (height > 0.0)
            return (
                np.broadcast_to(-self.normal, x.shape),
                height,
                np.broadcast_to(np.pi * self.radiance, x.shape),
                np.where(lit, 1.0, 0.0),
            )
        place = self.half * (disk(rng, len(x)) if self.ellipse else 2.0 * rng.random((len(x), 2)) - 1.0)
        towards = self.center + place[:, :1] * self.u + place[:, 1:] * self.v - x
        distance = np.maximum(np.linalg.norm(towards, axis=1), 1e-300)
        wi = towards / distance[:, None]
        return wi, distance, *self._arrive(wi, distance)

    def _arrive(self, wi, distance):
        cosine = -dot(wi, np.broadcast_to(self.normal, wi.shape))
        facing = cosine > 0.0
        cosine = np.where(facing, cosine, 1.0)
        gain = np.where(facing, 1.0, 0.0)
        if np.isfinite(self.tan_spread):
            tangent = np.sqrt(np.maximum(1.0 - cosine**2, 0.0)) / cosine
            gain = gain * np.maximum(self.tan_spread - tangent, 0.0) * self.spread_gain
        pdf = np.where(facing, distance**2 / (cosine * max(self.area, 1e-300)), 0.0)
        return gain[:, None] * self.radiance, pdf

    def hit(self, origins, directions):
        if self.singular:
            return super().hit(origins, directions)
        cosine = -(directions @ self.normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (origins - self.center) @ self.normal / cosine
            inside = self._inside(origins + distance[:, None] * directions - self.center)
        found = (cosine > 0.0) & (distance > 0.0) & inside
        distance = np.where(found, distance, np.inf)
        radiance, pdf = self._arrive(directions, np.where(found, distance, 1.0))
        return distance, np.where(found[:, None], radiance, 0.0), np.where(found, pdf, 0.0)


EMITTERS = {AreaLight: Area}
