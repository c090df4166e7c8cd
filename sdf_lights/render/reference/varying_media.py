# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Media whose coefficients are formulas: their values at points, and flights to collisions by delta tracking.

Majorants are those of sections of each ray, from some points of it with a margin. Where the medium is denser, a null
collision has a negative weight (Novák et al. 2014), so any majorant gives the right mean. A flight ends there, too, and
whoever asked for it goes on with the weight: all that a ray meets on one flight counts in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from ..material import Material
from ..medium import Medium
from .emission_nodes import Directions
from .geometry import Geometry, Surface
from .nodes import Graph, Points

WORLD = -1
MOST, LEAST = 1e9, 1e-30  # 1/m: no coefficient is larger; none is smaller, except 0
SHORTEST = 1e-30  # length of a ray that has none: 0 would mean an infinite one

# A section of a ray is at least ``STEP`` metres long, and ``GROWTH`` times as long as its distance. Beyond ``FARTHEST``
# there is nothing.
STEP, GROWTH, FARTHEST = 0.4, 0.35, 1e5
POINTS = 8  # of a section
MARGIN = 0.5  # of the difference of the greatest and the least value there


@dataclass
class Rays:
    """Rays (N,) from ``start`` along ``direction`` (N, 3), of a ``kind`` of ``scene.Ray``, with their bounces ``depth``
    (N, 5)."""

    start: np.ndarray
    direction: np.ndarray
    kind: np.ndarray
    depth: np.ndarray

    def select(self, rows: np.ndarray) -> Rays:
        """Some of the rays, given as indices (n,)."""
        return Rays(self.start[rows], self.direction[rows], self.kind[rows], self.depth[rows])

    def at(self, distance: np.ndarray) -> np.ndarray:
        """(N, 3) points at these distances (N,)."""
        return self.start + distance[:, None] * self.direction


@dataclass
class Flight:
    """Where rays (N,) have come to: at a ``distance`` they ``collide``, or have ``stopped`` at a null collision with
    another ``weight`` than 1, or were to end. ``glow`` (N, 3): radiance of the medium on the way."""

    distance: np.ndarray
    collides: np.ndarray
    stopped: np.ndarray
    weight: np.ndarray
    glow: np.ndarray


class Formulas:
    """The coefficients of one medium: in an instance, its ``owner``, or in the world."""

    def __init__(self, medium: Medium, owner: int, geometry: Geometry):
        varying = medium.varying
        roots = (*varying.scattering, varying.absorption, varying.emission)
        self._graph = Graph(Material("volume", None, parameters=varying.parameters), roots)
        self._owner, self._images = max(owner, 0), geometry.scene.images
        self._points, self._geometry = Points, geometry
        if owner == WORLD:
            self._points, self._geometry = Directions, SimpleNamespace(scene=geometry.scene, mesh_of=np.zeros(1, int))

    def at(self, rays: Rays, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Scattering (N, parts, 3) of each way, absorption and emission (N, 3) at points x (N, 3) of the rays."""
        count, zero, back = len(x), np.zeros_like(x), -rays.direction
        nothing, number = np.zeros(count), np.zeros(count, int)
        surface = Surface(
            x,
            back,
            back,
            back,
            number > 0,
            number + self._owner,
            number,
            np.tile((1.0, 0.0, 0.0), (count, 1)),
            number > 0,
            nothing + SHORTEST,
            rays.kind,
            number > 0,
            rays.depth,
            nothing,
            number,
            zero,
            number - 1,
        )
        points = self._points(self._graph, surface, self._geometry, self._images, nothing)
        *scattering, absorption, emission = (points.value(root, 3) for root in self._graph.roots)
        parts = np.zeros((count, len(scattering), 3))
        for index, value in enumerate(scattering):
            parts[:, index] = _amount(value)
        return parts, _amount(absorption), _amount(emission) - _amount(-emission)


def _amount(values: np.ndarray) -> np.ndarray:
    """Coefficients: 0 where they are negative or not a number."""
    return np.where(values >= LEAST, np.minimum(values, MOST), 0.0)


class VaryingMedia:
    """The media of ``Media`` together, of which some vary: ``formulas`` by their columns. ``constant`` are the
    extinction and the emission (columns, 3) of the others. Of each way of scattering, its column (parts,), and its
    coefficient (parts, 3) where that is a number."""

    def __init__(
        self,
        formulas: dict[int, Formulas],
        constant: tuple[np.ndarray, np.ndarray],
        part_column: np.ndarray,
        parts: np.ndarray,
    ):
        self._formulas, self._columns = formulas, np.array(sorted(formulas), int)
        fixed = np.isin(np.arange(len(constant[0])), self._columns, invert=True)[:, None]
        self._extinction, self._emission = (values * fixed for values in constant)
        self._part_column, self._parts = part_column, parts * fixed[part_column]

    def coefficients(self, inside: np.ndarray, rays: Rays, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Scattering of all parts (N, parts, 3), extinction and emission (N, 3) at points x (N, 3) of rays."""
        there = inside > 0
        parts = there[:, self._part_column, None] * self._parts
        extinction, emission = there @ self._extinction, there @ self._emission
        for column, formulas in self._formulas.items():
            rows = np.flatnonzero(there[:, column])
            if not len(rows):
                continue
            scattering, absorption, glow = formulas.at(rays.select(rows), x[rows])
            parts[np.ix_(rows, np.flatnonzero(self._part_column == column))] = scattering
            extinction[rows] += scattering.sum(1) + absorption
            emission[rows] += glow
        return parts, extinction, emission

    def _majorant(self, rng, inside, channel, rays: Rays, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(N,) of the extinction between distances (N,)."""
        share = (np.arange(POINTS) + np.where(np.arange(POINTS) % (POINTS - 1), rng.random(POINTS) - 0.5, 0.0)) / (
            POINTS - 1
        )
        length = np.where(np.isfinite(end), end - begin, 0.0)
        values = []
        for each in share:
            _, extinction, _ = self.coefficients(inside, rays, rays.at(begin + each * length))
            values.append(extinction[np.arange(len(channel)), channel])
        most, least = np.max(values, 0), np.min(values, 0)
        return most + MARGIN * (most - least)

    def fly(self, rng, inside: np.ndarray, channel: np.ndarray, rays: Rays, length: np.ndarray) -> Flight:
        """Flights of light of the channels (N,) up to a ``length`` (N,)."""
        count = len(channel)
        found = Flight(
            length.astype(float), np.zeros(count, bool), np.zeros(count, bool), np.ones(count), np.zeros((count, 3))
        )
        t, end, majorant = np.zeros((3, count))
        varies = (inside[:, self._columns] > 0).any(1)
        alive = np.flatnonzero(length > 0.0)
        while len(alive):
            new = alive[t[alive] >= end[alive]]
            size = np.where(varies[new], np.maximum(STEP, GROWTH * t[new]), np.inf)
            end[new] = np.minimum(t[new] + size, length[new])
            majorant[new] = self._majorant(rng, inside[new], channel[new], rays.select(new), t[new], end[new])
            bound = majorant[alive]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                way = np.where(bound > 0.0, -np.log1p(-rng.random(len(alive))) / bound, np.inf)
            here = np.minimum(t[alive] + way, end[alive])
            self._gather(rng, inside, rays, found, alive, t[alive], here)
            meets = t[alive] + way < end[alive]
            t[alive] = here
            self._collide(rng, inside, channel, rays, found, alive[meets], here[meets], majorant)
            goes_on = ~found.collides[alive] & ~found.stopped[alive] & (here < length[alive])
            alive = alive[goes_on & (~varies[alive] | (here < FARTHEST))]
        return found

    def _gather(self, rng, inside, rays: Rays, found: Flight, rows, begin: np.ndarray, end: np.ndarray) -> None:
        """Add the emission between distances."""
        length = end - begin
        rows, begin, length = (values[np.isfinite(length)] for values in (rows, begin, length))
        part = rays.select(rows)
        _, _, emission = self.coefficients(inside[rows], part, part.at(begin + rng.random(len(rows)) * length))
        found.glow[rows] += emission * length[:, None]

    def _collide(self, rng, inside, channel, rays: Rays, found: Flight, rows, distance, majorant) -> None:
        """What happens to the ``rows`` at collisions, which may be null collisions."""
        part, bound = rays.select(rows), majorant[rows]
        _, extinction, _ = self.coefficients(inside[rows], part, part.at(distance))
        extinction = extinction[np.arange(len(rows)), channel[rows]]
        denser = extinction > bound
        total = np.where(denser, 2.0 * extinction - bound, bound)
        real = rng.random(len(rows)) * total < extinction
        ends = real | denser
        found.collides[rows], found.stopped[rows] = real, denser & ~real
        found.distance[rows[ends]] = distance[ends]
        found.weight[rows] = total / bound * np.where(denser & ~real, -1.0, 1.0)
