# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media, in the world and in meshes. Those that vary in space are in ``varying_media``.

A path through media carries the light of one channel of RGB, drawn where it begins, three times. So its extinction is
one number, and distances to collisions are drawn by it: all that a ray meets before its collision counts in full.
"""

from __future__ import annotations

import numpy as np

from ..kernels.media.pack import is_only_a_bound
from ..scene import OPEN_SET, Ray, Scene
from .geometry import Geometry, Surface
from .varying_media import WORLD, Flight, Formulas, Rays, VaryingMedia
from .vectors import dot, to_world

CROSSINGS = 64  # of the ray that finds the media around a camera


class Media:
    """All media of a scene, one column for each of the world's and of those that an instance has by a material."""

    def __init__(self, scene: Scene, geometry: Geometry):
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
        formulas = {
            column: Formulas(medium, owner, geometry)
            for column, (medium, owner) in enumerate(zip(media, self.owners))
            if medium.varying is not None
        }
        coefficients = np.array([part.coefficient for _, part in parts]).reshape(-1, 3)
        constant = self._extinction, self._emission
        self._varying = VaryingMedia(formulas, constant, self._part_column, coefficients) if formulas else None

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

    def _of_channel(self, values: np.ndarray, inside: np.ndarray, channel: np.ndarray) -> np.ndarray:
        """(N,) sums of ``values`` (columns, 3) of the channels (N,)."""
        return ((inside > 0) * values[:, channel].T).sum(1)

    def fly(self, rng, inside: np.ndarray, channel: np.ndarray, rays: Rays, length: np.ndarray) -> Flight:
        """Flights of light of the channels (N,) to collisions, up to a ``length`` (N,), which may be infinite."""
        if self._varying is not None:
            return self._varying.fly(rng, inside, channel, rays, length)
        extinction, count = self._of_channel(self._extinction, inside, channel), len(channel)
        drawn = -np.log1p(-rng.random(count))
        free = np.where(extinction > 0.0, drawn / np.where(extinction > 0.0, extinction, 1.0), np.inf)
        glow = (inside > 0) @ self._emission
        distance = np.minimum(free, length)
        glow = glow * np.where(glow.any(1), distance, 0.0)[:, None]
        return Flight(distance, free < length, np.zeros(count, bool), np.ones(count), glow)

    def transmittance(self, rng, inside: np.ndarray, channel: np.ndarray, rays: Rays, length: np.ndarray) -> Flight:
        """As ``fly``, of light that nothing but the end of its way has to be told of: without collisions if no medium
        varies, but with the transmittance as its weight."""
        if self._varying is not None:
            return self._varying.fly(rng, inside, channel, rays, length)
        extinction, count = self._of_channel(self._extinction, inside, channel), len(channel)
        left, nowhere = np.exp(-np.where(extinction > 0.0, extinction * length, 0.0)), np.zeros(count, bool)
        return Flight(length, nowhere, nowhere, left, np.zeros((count, 3)))

    def scattering(
        self, inside: np.ndarray, channel: np.ndarray, rays: Rays, x: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """At collisions x (N, 3) of rays: the part (N,) of the extinction that is scattering, and the weights (N,
        parts) of phase functions, which add up to 1."""
        if self._varying is not None:
            parts, extinction, _ = self._varying.coefficients(inside, rays, x)
            rows = np.arange(len(channel))
            scattering, extinction = parts.sum(1)[rows, channel], extinction[rows, channel]
            weights = parts.mean(2)
        else:
            scattering, extinction = (
                self._of_channel(values, inside, channel) for values in (self._scattering, self._extinction)
            )
            weights = (inside[:, self._part_column] > 0) * self._part_weight
        total = weights.sum(1, keepdims=True)
        return scattering / np.where(extinction > 0.0, extinction, 1.0), weights / np.where(total > 0.0, total, 1.0)

    def light_set(self, inside: np.ndarray) -> np.ndarray:
        """(N,) for light linking: that of the medium that each ray has entered last."""
        return np.array(self._sets, int)[np.argmax(inside, 1)]


class Phase:
    """Points in media, in the place of ``materials.Shading``: the phase function of all media there, by the ``weights``
    of ``Media.scattering``."""

    def __init__(self, media: Media, inside: np.ndarray, weights: np.ndarray, direction: np.ndarray):
        self.media, self.inside, self.weights, self.direction = media, inside, weights, direction

    def select(self, rows: np.ndarray) -> Phase:
        """The same for some rows, given as indices (n,) or as a mask (N,)."""
        return Phase(self.media, self.inside[rows], self.weights[rows], self.direction[rows])

    def evaluate(self, wi: np.ndarray, kinds: Ray = Ray.ALL) -> tuple[np.ndarray, np.ndarray]:
        """Phase function (N, 3), 0 if no ray of these ``kinds`` is scattered in media, and the density (N,) of
        ``sample``."""
        media, weights, cosine = self.media, self.weights, dot(self.direction, wi)[:, None]
        g, alpha = media._g, media._alpha
        own = (1.0 - g**2) / (4.0 * np.pi * (1.0 + g**2 - 2.0 * g * cosine) ** 1.5)
        draine = own * (1.0 + alpha * cosine**2) / (1.0 + alpha * (1.0 + 2.0 * g**2) / 3.0)
        value = (weights * draine).sum(1) * bool(kinds & Ray.VOLUME)
        return np.repeat(value[:, None], 3, 1), (weights * own).sum(1)

    def sample(self, rng: np.random.Generator) -> np.ndarray:
        """Directions (N, 3), by Henyey and Greenstein's functions with the g of the parts."""
        count, total = len(self.direction), np.cumsum(self.weights, 1)
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
