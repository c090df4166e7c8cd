# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive triangles. See ``emitter.py``."""

from __future__ import annotations

import numpy as np

from ...scene import Ray
from ..vectors import dot, normalize
from .emitter import Emitter


class Triangles(Emitter):
    """All triangles whose material emits, sampled uniformly by area. The integrator evaluates their emission.

    ``instances`` and ``triangles`` (K,) name them, ``corners`` (K, 3, 3) are in world space.
    """

    def __init__(self, instances: np.ndarray, triangles: np.ndarray, corners: np.ndarray):
        super().__init__(Ray.ALL)
        self.instances, self.triangles, self.corners = instances, triangles, corners
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = 0.5 * np.linalg.norm(cross, axis=1)
        self.normals = normalize(cross)
        self.area = float(areas.sum())
        self.table = np.cumsum(areas / max(self.area, 1e-300))

    def sample_points(self, rng: np.random.Generator, x: np.ndarray):
        """(wi, distance, pdf, index of the triangle, u, v)."""
        count = len(x)
        index = np.minimum(np.searchsorted(self.table, rng.random(count), side="right"), len(self.table) - 1)
        root, v = np.sqrt(rng.random(count)), rng.random(count)
        u, v = root * (1.0 - v), root * v
        corners = self.corners[index]
        towards = (1.0 - u - v)[:, None] * corners[:, 0] + u[:, None] * corners[:, 1] + v[:, None] * corners[:, 2] - x
        distance = np.maximum(np.linalg.norm(towards, axis=1), 1e-300)
        wi = towards / distance[:, None]
        return wi, distance, self.density(distance, np.abs(dot(wi, self.normals[index]))), index, u, v

    def density(self, distance: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Density (N,) per solid angle of a point sampled at ``distance`` (N,) on a triangle seen at ``cosine``."""
        return np.where(cosine > 1e-9, distance**2 / (np.maximum(cosine, 1e-9) * self.area), 0.0)
