# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a ray caster: the nearest hits of many rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Hits:
    """Nearest hit of every ray: ``distance`` (inf: none), indices of instance and of triangle within its mesh, and
    barycentric coordinates of the second and third vertex, or Embree's of a curve; ``point`` (N, 3) is the hit in the
    world."""

    distance: np.ndarray
    instance: np.ndarray
    triangle: np.ndarray
    u: np.ndarray
    v: np.ndarray
    point: np.ndarray

    @property
    def found(self) -> np.ndarray:
        """Whether each ray has a hit."""
        return np.isfinite(self.distance)

    @classmethod
    def none(cls, count: int) -> "Hits":
        """No hit of ``count`` rays."""
        return cls(np.full(count, np.inf), *np.full((2, count), -1), *np.zeros((2, count)), np.zeros((count, 3)))

    def select(self, rows: np.ndarray) -> "Hits":
        """Those of some rays, given as indices (n,) or as a mask (N,)."""
        return Hits(*(array[rows] for array in vars(self).values()))
