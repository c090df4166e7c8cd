# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media, in the world and in meshes: homogeneous ones, and the means of others.

A path through media carries the light of one channel of RGB, drawn where it begins, three times. So its extinction is
one number, and distances to collisions are drawn by it: all that a ray meets before its collision counts in full.
"""

from __future__ import annotations

import numpy as np

from ..kernels.media.pack import is_only_a_bound
from ..medium import some_varies
from ..scene import OPEN_SET, Ray, Scene
from .geometry import Geometry, Surface
from .vectors import dot, to_world

WORLD = -1
CROSSINGS = 64  # of the ray that finds the media around a camera


class Media:
    """All media of a scene, one column for each of the world's and of those that an instance has by a material."""

    def __init__(self, scene: Scene, geometry: Geometry):
        if some_varies(scene):
            scene.warnings.append(
                "The NumPy reference renders volumes that vary in space by their means: choose the CPU for them."
            )
        self.geometry = geometry
        self.owners: list[int] = []
        media = []
        self._columns = np.full((len(scene.instances), max(len(scene.materials), 1)), -1)
        self.only = np.array([is_only_a_bound(material) for material in scene.materials] or [False])

        def add(medium, owner: int) -> int:
            if medium is None or medium.does_nothing:
                return -1
            media.append(medium)
            self.owners.append(owner)
            return len(media) - 1

        add(scene.world.medium, WORLD)
        for index, instance in enumerate(scene.instances):
            for material in sorted(set(instance.materials)):
                self._columns[index, material] = add(scene.materials[material].medium, index)
        self.count = len(media)
        self._sets = [OPEN_SET if owner == WORLD else scene.instances[owner].light_set for owner in self.owners]
        self._extinction = np.array([medium.extinction for medium in media]).reshape(-1, 3)
        self._emission = np.array([medium.emission for medium in media]).reshape(-1, 3)
        parts = [(column, part) for column, medium in enumerate(media) for part in medium.scattering]
        self._scattering = np.zeros((self.count, 3))
        for column, part in parts:
            self._scattering[column] += part.coefficient
        # Phase functions are mixed by the means of their colours, as in Cycles.
        self._part_column = np.array([column for column, _ in parts], int)
        self._part_weight = np.array([np.mean(part.coefficient) for _, part in parts])
        self._g, self._alpha = (np.array([getattr(part, name) for _, part in parts]) for name in ("g", "alpha"))

    # --- where rays are: (N, columns) int, 0 outside of a medium, else the more the later a ray has entered it --------------

    def outside(self, count: int) -> np.ndarray:
        """(count, columns): in the world's medium alone."""
        return np.tile((np.array(self.owners, int) == WORLD).astype(int), (count, 1))

    def around(self, positions: np.ndarray) -> np.ndarray:
        """(N, columns) bool: the media around cameras. A mesh contains a point if a ray leaves it without having
        entered it."""
        inside, start, going = self.outside(len(positions)), positions.copy(), np.arange(len(positions))
        if self._columns.max(initial=-1) < 0:
            return inside
        entered, up = np.zeros_like(inside), np.tile((0.0, 0.0, 1.0), (len(positions), 1))
        for _ in range(CROSSINGS):
            kinds = np.full(len(going), int(Ray.CAMERA))
            hits = self.geometry.intersect(start[going], up[going], np.full(len(going), np.inf), kinds)
            going, hits = going[hits.found], hits.select(hits.found)
            if not len(going):
                break
            surface = self.geometry.surface(hits, up[going])
            column = self._column(surface)
            new = (column >= 0) & (entered[going, column] == 0)
            for table, rows in ((inside, new & surface.backfacing), (entered, new & ~surface.backfacing)):
                table[going[rows], column[rows]] = table[going[rows]].max(1) + 1
            start[going] = self.geometry.offset(surface.position, surface.ng, up[going])
        return inside

    def crossed(self, inside: np.ndarray, surface: Surface, passes: np.ndarray) -> np.ndarray:
        """``inside`` behind surfaces, where rays pass (N,) through them."""
        if not self.count:
            return inside
        column, inside = self._column(surface), inside.copy()
        rows = np.flatnonzero(passes & (column >= 0))
        own = inside[rows, column[rows]]
        entered = np.where(own > 0, own, inside[rows].max(1, initial=0) + 1)
        inside[rows, column[rows]] = np.where(surface.backfacing[rows], 0, entered)
        return inside

    def only_bounds(self, surface: Surface) -> np.ndarray:
        """(N,) whether surfaces do nothing but bound a medium."""
        return self.only[self._material(surface)]

    def _column(self, surface: Surface) -> np.ndarray:
        return self._columns[surface.instance, self._material(surface)]

    def _material(self, surface: Surface) -> np.ndarray:
        return self.geometry.material(surface.instance, surface.triangle).astype(int)

    # --- what happens there -------------------------------------------------------------------------------------------

    def extinction(self, inside: np.ndarray, channel: np.ndarray) -> np.ndarray:
        """(N,) of the channels (N,), in 1/m."""
        return ((inside > 0) * self._extinction[:, channel].T).sum(1)

    def albedo(self, inside: np.ndarray, channel: np.ndarray) -> np.ndarray:
        """(N,) part of the extinction that is scattering."""
        extinction = self.extinction(inside, channel)
        scattering = ((inside > 0) * self._scattering[:, channel].T).sum(1)
        return scattering / np.where(extinction > 0.0, extinction, 1.0)

    def emission(self, inside: np.ndarray) -> np.ndarray:
        """(N, 3) radiance gained per metre."""
        return (inside > 0) @ self._emission

    def free_path(self, rng: np.random.Generator, inside: np.ndarray, channel: np.ndarray) -> np.ndarray:
        """(N,) distances to collisions; infinite where there is none."""
        extinction = self.extinction(inside, channel)
        drawn = -np.log1p(-rng.random(len(channel)))
        return np.where(extinction > 0.0, drawn / np.where(extinction > 0.0, extinction, 1.0), np.inf)

    def transmittance(self, inside: np.ndarray, channel: np.ndarray, length: np.ndarray) -> np.ndarray:
        """(N, 1) over lengths (N,), which may be infinite."""
        extinction = self.extinction(inside, channel)
        return np.exp(-np.where(extinction > 0.0, extinction * length, 0.0))[:, None]

    def light_set(self, inside: np.ndarray) -> np.ndarray:
        """(N,) for light linking: that of the medium that each ray has entered last."""
        return np.array(self._sets, int)[np.argmax(inside, 1)]

    def weights(self, inside: np.ndarray) -> np.ndarray:
        """(N, parts) of phase functions, which add up to 1."""
        weights = (inside[:, self._part_column] > 0) * self._part_weight
        total = weights.sum(1, keepdims=True)
        return weights / np.where(total > 0.0, total, 1.0)


class Phase:
    """Points in media, in the place of ``materials.Shading``: the phase function of all media there."""

    def __init__(self, media: Media, inside: np.ndarray, direction: np.ndarray):
        self.media, self.inside, self.direction = media, inside, direction

    def select(self, rows: np.ndarray) -> Phase:
        """The same for some rows, given as indices (n,) or as a mask (N,)."""
        return Phase(self.media, self.inside[rows], self.direction[rows])

    def evaluate(self, wi: np.ndarray, kinds: Ray = Ray.ALL) -> tuple[np.ndarray, np.ndarray]:
        """Phase function (N, 3), 0 if no ray of these ``kinds`` is scattered in media, and the density (N,) of
        ``sample``."""
        media, weights, cosine = self.media, self.media.weights(self.inside), dot(self.direction, wi)[:, None]
        g, alpha = media._g, media._alpha
        own = (1.0 - g**2) / (4.0 * np.pi * (1.0 + g**2 - 2.0 * g * cosine) ** 1.5)
        draine = own * (1.0 + alpha * cosine**2) / (1.0 + alpha * (1.0 + 2.0 * g**2) / 3.0)
        value = (weights * draine).sum(1) * bool(kinds & Ray.VOLUME)
        return np.repeat(value[:, None], 3, 1), (weights * own).sum(1)

    def sample(self, rng: np.random.Generator) -> np.ndarray:
        """Directions (N, 3), by Henyey and Greenstein's functions with the g of the parts."""
        count, total = len(self.direction), np.cumsum(self.media.weights(self.inside), 1)
        part = (rng.random(count)[:, None] >= total).sum(1).clip(0, total.shape[1] - 1)
        g, u, angle = self.media._g[part], rng.random(count), 2.0 * np.pi * rng.random(count)
        even = np.abs(g) < 1e-3
        g = np.where(even, 1.0, g)
        ratio = (1.0 - g**2) / np.where(even, 1.0, 1.0 - g + 2.0 * g * u)
        cosine = np.where(even, 1.0 - 2.0 * u, (1.0 + g**2 - ratio**2) / (2.0 * g)).clip(-1.0, 1.0)
        sine = np.sqrt(1.0 - cosine**2)
        return to_world(np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], 1), self.direction)


def points_of(position: np.ndarray, direction: np.ndarray) -> Surface:
    """Points (N, 3) of rays in media, in the place of surfaces; their instance is −1."""
    count, zero = len(position), np.zeros_like(position)
    nothing, number = np.zeros(count), np.zeros(count, int)
    return Surface(
        position,
        zero,
        zero,
        -direction,
        number > 0,
        number - 1,
        number,
        zero,
        number > 0,
        nothing,
        number,
        number > 0,
        np.zeros((count, 5), int),
        nothing,
        number,
        zero,
        number - 1,
    )
