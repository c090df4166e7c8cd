# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that nodes of materials trace, over arrays of points: occlusion, bevels, hits in a direction.

Directions are unit vectors, (N, 3), distances (N,) metres. ``local``: only the point's own object is hit.
"""

from __future__ import annotations

import numpy as np

from ..scene import Ray
from .geometry import Geometry, Hits, Surface
from .vectors import cosine_hemisphere, dot, frame, normalize

SHARP = 8.0  # density from which on a scattered ray sees a bevel
PAST_SHIFT = 1.1  # a ray from a bump's shifted point begins this many times the shift away


def _next(geometry: Geometry, local: bool, instance: np.ndarray, origins, directions, near, far, kind: Ray) -> Hits:
    """Nearest hits beyond the distance ``near``, measured from the origins."""
    near, far = np.array(near, float), np.broadcast_to(far, len(origins))
    result, going = Hits.none(len(origins)), np.flatnonzero(near < far)
    while len(going):
        start = origins[going] + near[going, None] * directions[going]
        hits = geometry.intersect(start, directions[going], far[going] - near[going], np.full(len(going), int(kind)))
        distance = near[going] + hits.distance
        met = hits.found & (~np.array(local) | (hits.instance == instance[going]))
        hits.distance = distance
        for target, values in zip(vars(result).values(), vars(hits).values()):
            target[going[met]] = values[met]
        again = hits.found & ~met
        near[going] = distance + geometry.epsilon
        going = going[again]
    return result


def occlusion(geometry: Geometry, surface: Surface, rng, local: bool, distance, samples, direction) -> np.ndarray:
    """Fraction (N,) of ``samples`` cosine-distributed rays around ``direction`` that hit nothing up to ``distance``."""
    result = np.ones(len(distance))
    for count in np.unique(samples.astype(int)):
        rows = np.flatnonzero((samples.astype(int) == count) & (distance > 0.0))
        if count < 1 or not len(rows):
            continue
        part, free = surface.select(rows), np.zeros(len(rows))
        for _ in range(count):
            way = cosine_hemisphere(rng, direction[rows])
            start = geometry.offset(part.position, part.ng, way)
            hits = _next(
                geometry,
                local,
                part.instance,
                start,
                way,
                np.zeros(len(rows)),
                distance[rows],
                Ray.ALL if local else Ray.SHADOW,
            )
            free += ~hits.found
        result[rows] = free / count
    return result


def _falloff(radius: np.ndarray, r: np.ndarray) -> np.ndarray:
    return 10.0 / np.pi * np.maximum(radius - r, 0.0) ** 3 / radius**5


def _falloff_radius(u: np.ndarray) -> np.ndarray:
    """Distance on the unit disk within which the fraction u of ``_falloff`` lies, by bisection."""
    low, high = np.zeros(len(u)), np.ones(len(u))
    for _ in range(50):
        x = 0.5 * (low + high)
        below = x**2 * (10.0 + x * (-20.0 + x * (15.0 - 4.0 * x))) < u
        low, high = np.where(below, x, low), np.where(below, high, x)
    return 0.5 * (low + high)


def bevel(geometry: Geometry, surface: Surface, rng, radius, samples, own: np.ndarray) -> np.ndarray:
    """Mean normals (N, 3) of the object around points, up to ``radius``; ``own`` if nothing is found."""
    result = own.copy()
    blurred = (surface.depth[:, 1] > 0) | (surface.ray_pdf > 0.0) & (surface.ray_pdf < SHARP)
    for count in np.unique(samples.astype(int)):
        rows = np.flatnonzero((samples.astype(int) == count) & (radius > 0.0) & ~blurred)
        if count < 1 or not len(rows):
            continue
        part = surface.select(rows)
        total = sum(_probe(geometry, part, radius[rows], rng) for _ in range(count))
        total *= np.where(part.backfacing, -1.0, 1.0)[:, None]
        seen = dot(total, total) > 0.0
        result[rows[seen]] = normalize(total[seen])
    return result


def _probe(geometry: Geometry, surface: Surface, radius: np.ndarray, rng) -> np.ndarray:
    """Sum (N, 3) of the weighted normals that one ray through the sphere around each point finds.

    King et al. 2013, "BSSRDF importance sampling": three axes, combined by the power heuristic.
    """
    count = len(radius)
    axes = np.stack([surface.ng, *frame(surface.ng)], 1)
    picks = np.array([0.5, 0.25, 0.25])
    axis = np.searchsorted(np.cumsum(picks), rng.random(count), side="right").clip(0, 2)
    rows = np.arange(count)
    along, first, second = (axes[rows, (axis + step) % 3] for step in range(3))
    r, angle = radius * _falloff_radius(rng.random(count)), 2.0 * np.pi * rng.random(count)
    height = np.sqrt(np.maximum(radius**2 - r**2, 0.0))
    aside = first * (r * np.cos(angle))[:, None] + second * (r * np.sin(angle))[:, None]
    start, total, near = surface.position + along * height[:, None] + aside, np.zeros((count, 3)), np.zeros(count)
    going = rows
    while len(going):
        hits = _next(
            geometry,
            True,
            surface.instance[going],
            start[going],
            -along[going],
            near[going],
            2.0 * height[going],
            Ray.ALL,
        )
        going, hits = going[hits.found], hits.select(hits.found)
        found = geometry.surface(hits, -along[going])
        chances = picks * np.abs(np.einsum("nij,nj->ni", axes[going], found.ng))
        weight = chances[np.arange(len(going)), axis[going]] / np.maximum((chances**2).sum(1), 1e-300)
        away = np.linalg.norm(found.position - surface.position[going], axis=-1)
        weight *= _falloff(radius[going], away) / np.maximum(_falloff(radius[going], r[going]), 1e-300)
        total[going] += found.ns * (weight * np.where(found.backfacing, -1.0, 1.0))[:, None]
        near[going] = hits.distance + geometry.epsilon
    return total


def raycast(geometry: Geometry, surface: Surface, local: bool, origins, directions, distance, shift) -> np.ndarray:
    """(10, N): as ``kernels.probes.raycast``. ``shift`` (N,): how far bump mapping has moved the points."""
    count = len(distance)
    here = (shift == 0.0) & (origins == surface.position).all(1)
    start = np.where(here[:, None], geometry.offset(surface.position, surface.ng, directions), origins)
    length = np.maximum(np.linalg.norm(directions, axis=-1), 1e-300)
    unit = directions / length[:, None]
    hits = _next(
        geometry,
        local,
        surface.instance,
        start,
        unit,
        PAST_SHIFT * shift * length,
        np.where(distance > 0.0, distance * length, 0.0),
        Ray.ALL,
    )
    result = np.zeros((10, count))
    result[2] = distance
    rows = np.flatnonzero(hits.found)
    hits = hits.select(rows)
    found = geometry.surface(hits, unit[rows])
    result[0, rows], result[1, rows] = 1.0, found.instance == surface.instance[rows]
    result[2, rows], result[3:6, rows] = hits.distance / length[rows], found.ns.T
    result[6, rows], result[7, rows] = found.instance, found.triangle
    result[8, rows], result[9, rows] = hits.u, hits.v
    return result
