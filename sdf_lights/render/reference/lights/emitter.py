# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The base of all lights except SDF lamps, with textbook sampling.

Every class has ``sample(rng, x) -> (wi, distance, radiance, pdf)`` for points x (N, 3), with pdf 0 where no light
reaches x, and ``hit(origins, directions) -> (distance, radiance, pdf)``, with distance inf for rays that miss. Where
``singular``, light comes from a single direction: ``radiance`` is then an irradiance, pdf is 1 and no ray hits it.
"""

from __future__ import annotations

import numpy as np

from ...scene import Ray
from ..emission_nodes import Emission

BACKGROUND = 1e30  # distance of infinitely far emitters


class Emitter:
    """A light of the reference: ``sample`` draws directions towards it, ``hit`` finds it along rays.

    ``singular``: rays cannot hit it.
    """

    singular = False
    nodes: Emission | None = None  # multiplies its radiance
    normal: np.ndarray | None = None  # of its surface; None: it faces the viewer

    def __init__(self, visibility: Ray, cast_shadow: bool = True):
        self.visibility, self.cast_shadow = Ray(visibility), cast_shadow

    def modulated(self, radiance, origins, directions, distance, kind):
        """``radiance`` (N, 3) that rays of a kind of ``scene.Ray`` hit (0 in light sampling), times the value of its
        nodes there."""
        if self.nodes is None:
            return radiance
        far = ~np.isfinite(distance) | (distance >= BACKGROUND)
        length = np.where(far, 0.0, distance)
        place = np.where(far[:, None], directions, origins + length[:, None] * directions)
        normal = np.broadcast_to(self.normal, directions.shape) if self.normal is not None else -directions
        return radiance * self.nodes.at(place, -directions, normal, kind, length)

    def sample(self, rng: np.random.Generator, x: np.ndarray):
        """For points x (N, 3): (directions wi, distances, radiance (N, 3), pdf per solid angle)."""
        raise NotImplementedError

    def hit(self, origins: np.ndarray, directions: np.ndarray):
        """For rays: (distances, inf without a hit; radiance (N, 3); pdf of ``sample`` at the origin)."""
        return np.full(len(origins), np.inf), np.zeros(origins.shape), np.zeros(len(origins))
