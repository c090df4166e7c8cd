# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a ray caster: the nearest hits of many rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Hits:
    """Nearest hit of every ray: ``distance`` (inf: none), indices of instance and of triangle within its mesh, and
    barycentric coordinates of the second and third vertex."""

    distance: np.ndarray
    instance: np.ndarray
    triangle: np.ndarray
    u: np.ndarray
    v: np.ndarray

    @property
    def found(self) -> np.ndarray:
        """Whether each ray has a hit."""
        return np.isfinite(self.distance)

    @classmethod
    def none(cls, count: int) -> "Hits":
        """No hit of ``count`` rays."""
        nowhere = np.full(count, -1)
        return cls(np.full(count, np.inf), nowhere, nowhere, np.zeros(count), np.zeros(count))

    def select(self, rows: np.ndarray) -> "Hits":
        """Those of some rays, given as indices (n,) or as a mask (N,)."""
        return Hits(*(array[rows] for array in vars(self).values()))
