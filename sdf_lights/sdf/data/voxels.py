# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance grids of meshes: distances to triangles, signs by the winding number, in blocks near the surface.

A mesh with holes has its surface there where the winding number is one half. Distances near it are bounded by those
along edges of voxels, so that the field does not jump there.
"""

from __future__ import annotations

import contextvars
import math
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...interruption import Interrupted, check
from ...jit import kernel
from .grid import BLOCK, CORNERS, SIDE, Grid, grid_tables
from .triangles import Triangles, nearest, triangles, winding

BAND = 5.0  # voxels on each side of the surface
FINENESS, PREVIEW = 128, 64  # voxels along the longest side, if nobody chooses their size; while a mesh is being edited
MOST_BLOCKS = 1 << 14  # with voxels: 8 million voxels
MOST_CORNERS = 1 << 22  # of blocks
INSIDE = 0.52  # winding number of the surface where there are no faces: above the half that flat sheets come near
NEAR_WHOLE = 0.3  # from a whole number, up to which a winding number is taken for the same as that of a point nearby
ON_A_FACE = 1e-6  # voxels
NARROWER, LEVELS = 0.75, 12  # distances at which points are chosen: a factor, and how often
_TASK = 24  # blocks between two looks whether to go on: some hundredths of a second


class GridError(ValueError):
    """A mesh has no grid: the rest of a sentence that names it."""


@kernel(forceinline=True)
def _reach(turns, distance, closed):
    """How far from a point, whose nearest face is at a ``distance``, the winding number is as near to the same whole
    number.

    It is harmonic where no face is, and constant if the mesh is ``closed``. Else what lacks it to a whole number m is
    at most m (1 + s) / (1 − s)² at s distances from the point (Harnack's inequality), as long as it has one sign there,
    which neighbours of faces that hardly leak have.
    """
    if closed:
        return distance
    lacks = max(abs(turns - math.floor(turns + 0.5)), 1e-3)
    c = NEAR_WHOLE / lacks
    return distance * (2.0 * c + 1.0 - math.sqrt(8.0 * c + 1.0)) / (2.0 * c) if c > 1.0 else 0.0


@kernel
def _fill(values, known, k, j, i, radius, turns):
    """Give a value to all points (m, m, m) that are nearer than ``radius`` points and not ``known``."""
    m, reach = len(values), int(radius)
    for c in range(max(k - reach, 0), min(k + reach + 1, m)):
        for b in range(max(j - reach, 0), min(j + reach + 1, m)):
            for a in range(max(i - reach, 0), min(i + reach + 1, m)):
                square = (a - i) * (a - i) + (b - j) * (b - j) + (c - k) * (c - k)
                if not known[c, b, a] and square < radius * radius:
                    values[c, b, a], known[c, b, a] = turns, True


@kernel
def _measure(corners, nodes, moments, closed, corner, size, starts, step, band, distances, windings):
    """Distances and winding numbers (n, m, m, m) at lattices of points
    ``step`` voxels apart, which begin at ``starts``.

    Distances above ``band`` need not be exact: they are above it. A winding number counts for all points of the lattice
    that are closer than ``_reach``, so those far from faces are found first: they are few, and most of the others are
    near them.
    """
    m, guess, spacing = distances.shape[1], 0, size * step * (1.0 + 1e-9)
    known = np.empty((m, m, m), np.bool_)
    for block in range(len(starts)):
        x, y = corner[0] + size * starts[block, 0], corner[1] + size * starts[block, 1]
        z = corner[2] + size * starts[block, 2]
        most = 0.0
        for k in range(m):
            for j in range(m):
                for i in range(m):
                    found, guess = nearest(
                        corners, nodes, x + size * step * i, y + size * step * j, z + size * step * k, band, guess
                    )
                    distances[block, k, j, i], known[k, j, i] = found, False
                    most = max(most, found)
        least = min(most, band)
        for level in range(LEVELS + 1):
            least = NARROWER * least if level < LEVELS else 0.0
            for k in range(m):
                for j in range(m):
                    for i in range(m):
                        found = distances[block, k, j, i]
                        if known[k, j, i] or found < least:
                            continue
                        turns = winding(
                            corners, nodes, moments, x + size * step * i, y + size * step * j, z + size * step * k
                        )
                        windings[block, k, j, i], known[k, j, i] = turns, True
                        _fill(windings[block], known, k, j, i, _reach(turns, min(found, band), closed) / spacing, turns)


def _in_tasks(work, count: int, each: int) -> None:
    """``work(first, last)`` for parts of so many things, in threads; asks between them whether to go on."""
    starts = range(0, count, each)
    if not count:
        return
    work(0, min(each, count))  # alone: else each thread would compile
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        jobs = [pool.submit(contextvars.copy_context().run, work, at, min(at + each, count)) for at in starts[1:]]
        try:
            for job in jobs:
                job.result()
                check()
        except Interrupted:
            for job in jobs:
                job.cancel()
            raise


class _Builder:
    """The grid of one mesh while it is made."""

    def __init__(self, mesh: Triangles, low: np.ndarray, high: np.ndarray, size: float):
        self.mesh, self.size = mesh, size
        room = (BAND + 1.0) * size
        self.counts = np.maximum(np.ceil((high - low + 2.0 * room) / (SIDE * size)), 1).astype(np.int64)
        self.corner = 0.5 * (low + high) - 0.5 * SIDE * size * self.counts
        self.band = float(np.float32(BAND * size))

    def measured(self, starts: np.ndarray, side: int, step: float, most: float) -> tuple[np.ndarray, np.ndarray]:
        """Distances and winding numbers (n, side, side, side) at lattices that begin at ``starts`` (n, 3), in
        voxels."""
        mesh = self.mesh
        distances = np.empty((len(starts), side, side, side))
        windings = np.empty_like(distances)
        starts = np.ascontiguousarray(starts, np.float64)

        def work(first: int, last: int) -> None:
            part = slice(first, last)
            _measure(
                mesh.corners,
                mesh.nodes,
                mesh.moments,
                mesh.closed,
                self.corner,
                self.size,
                starts[part],
                step,
                most,
                distances[part],
                windings[part],
            )

        _in_tasks(work, len(starts), max(_TASK * BLOCK // side**3, 1))
        return distances, windings

    def build(self) -> Grid:
        coarse = self.coarse()
        shape = coarse.shape
        cells = np.stack([coarse[c : shape[0] - 1 + c, b : shape[1] - 1 + b, a : shape[2] - 1 + a]
                          for c in (0, 1) for b in (0, 1) for a in (0, 1)])  # fmt: skip
        # A block has voxels if the surface may be near it: the distance at a corner tells, or a sign that changes.
        reach = self.band + math.sqrt(3.0) * SIDE * self.size
        near = (np.abs(cells) < reach).all(axis=0) | ((cells > 0.0).any(axis=0) & (cells <= 0.0).any(axis=0))
        kept: dict[tuple[int, int, int], int] = {}
        blocks, values, pending = np.zeros((0, 3), np.int64), [], np.argwhere(near)[:, ::-1]
        while len(pending):
            if len(kept) + len(pending) > 8 * MOST_BLOCKS:
                raise GridError("has too many voxels: choose a larger voxel size.")
            pending = self.near_enough(pending) if not kept else pending
            found = self.signed(pending)
            values.append(found)
            kept |= {tuple(block): len(kept) + n for n, block in enumerate(pending.tolist())}
            blocks = np.concatenate([blocks, pending])
            if len(blocks) > MOST_BLOCKS:
                raise GridError("has too many voxels: choose a larger voxel size.")
            pending = self.missing(coarse, pending, found, kept)
        joined = np.concatenate(values) if values else np.zeros((0, CORNERS, CORNERS, CORNERS))
        if not (joined < 0.0).any():
            raise GridError(
                "has no inside at this voxel size: close it, give it a Solidify modifier, or choose smaller voxels."
            )
        joined = self.without_jumps(blocks, joined)
        return Grid(*grid_tables(self.corner, self.size, coarse, blocks, joined, self.band))

    def coarse(self) -> np.ndarray:
        """Distances (z, y, x) at all corners of blocks. Raises GridError for too many voxels."""
        counts = self.counts + 1
        if np.prod(counts.astype(float)) > MOST_CORNERS:
            raise GridError("has too many voxels: choose a larger voxel size.")
        places = SIDE * np.stack(np.meshgrid(*map(np.arange, counts[::-1]), indexing="ij"), axis=-1)[..., ::-1]
        distances, windings = self.measured(places.reshape(-1, 3), 1, 1.0, math.inf)
        shape = tuple(counts[::-1])
        return _with_signs(distances, windings, ON_A_FACE * self.size).reshape(shape)

    def near_enough(self, blocks: np.ndarray) -> np.ndarray:
        """Those of the blocks (n, 3) to whose middle the surface is near, or whose winding number changes (open
        meshes)."""
        half = 0.5 * math.sqrt(3.0) * SIDE * self.size
        distances, windings = self.measured(SIDE * blocks + SIDE / 2, 1, 1.0, math.inf)
        near = distances.ravel() < self.band + half
        if not self.mesh.closed:
            # Somewhere in a hole the winding number is one half, and nearby it is close to that.
            near |= np.abs(np.abs(windings.ravel()) - INSIDE) < 0.2
        return blocks[near]

    def signed(self, blocks: np.ndarray) -> np.ndarray:
        """Distances (n, CORNERS, CORNERS, CORNERS) with signs, to the width of the band."""
        distances, windings = self.measured(SIDE * blocks, CORNERS, 1.0, self.band * (1.0 + 1e-9))
        return np.clip(_with_signs(distances, windings, ON_A_FACE * self.size), -self.band, self.band)

    def missing(self, coarse, blocks, values, kept) -> np.ndarray:
        """Neighbours of blocks that are tiles, although not all voxels at their face are as far as the band with their
        sign."""
        wanted = set()
        for axis in range(3):
            for side in (0, 1):
                faces = np.take(values, -side, axis=3 - axis).reshape(len(values), -1)
                low, high = faces.min(axis=1), faces.max(axis=1)
                beside = blocks.copy()
                beside[:, axis] += 2 * side - 1
                within = (beside >= 0).all(axis=1) & (beside < self.counts).all(axis=1)
                at = np.clip(beside, 0, self.counts - 1)
                sign = coarse[at[:, 2], at[:, 1], at[:, 0]] > 0.0
                good = np.where(sign, low >= self.band, high <= -self.band)
                wanted |= {tuple(block) for block in beside[within & ~good].tolist()} - kept.keys()
        return np.array(sorted(wanted), np.int64).reshape(-1, 3)

    def without_jumps(self, blocks: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Values (n, CORNERS, CORNERS, CORNERS) whose sign does not change from one voxel to the next faster than by
        their distance."""
        if self.mesh.closed:
            return values
        check()
        own = np.arange(CORNERS)
        lattice = np.stack(np.meshgrid(own, own, own, indexing="ij"), axis=-1)[..., ::-1].reshape(-1, 3)
        size = SIDE * self.counts + 1
        places = (SIDE * blocks[:, None] + lattice).reshape(-1, 3)
        keys = places[:, 0] + size[0] * (places[:, 1] + size[1] * places[:, 2])
        keys, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        sizes, positive = np.abs(values.ravel()[first]), values.ravel()[first] > 0.0
        pairs = []
        for stride in (1, size[0], size[0] * size[1]):
            place = np.minimum(np.searchsorted(keys, keys + stride), len(keys) - 1)
            there = np.flatnonzero(keys[place] == keys + stride)
            pairs.append((there, place[there]))
        check()
        for a, b in pairs:
            apart = positive[a] != positive[b]
            a, b = a[apart], b[apart]
            together = sizes[a] + sizes[b]
            with np.errstate(all="ignore"):
                scale = np.minimum(self.size / together, 1.0)
            jumps = together > self.size
            for end in (a, b):
                np.minimum.at(sizes, end[jumps], (scale * sizes[end])[jumps])
        for _ in range(math.ceil(BAND) + 1):
            check()
            for a, b in pairs:
                same = positive[a] == positive[b]
                a, b = a[same], b[same]
                np.minimum.at(sizes, a, sizes[b] + self.size)
                np.minimum.at(sizes, b, sizes[a] + self.size)
        return np.where(positive, sizes, -sizes)[inverse.ravel()].reshape(values.shape)


def _with_signs(distances: np.ndarray, windings: np.ndarray, least: float) -> np.ndarray:
    """A mesh that is inside out winds the other way, and is meant to have an inside all the same.

    Nearer than ``least`` a point is on a face, and rounding decides how often that winds around it.
    """
    inside = (np.abs(windings) > INSIDE) & (distances > least)
    return np.where(inside, -1.0, 1.0) * np.maximum(distances, least)


def mesh_grid(vertices: np.ndarray, faces: np.ndarray, voxel_size: float = 0.0, fineness: int = FINENESS) -> Grid:
    """The grid of a mesh with vertices (n, 3) in metres and triangles (m, 3), of voxels of ``voxel_size`` metres.

    A size of 0 divides the longest side into ``fineness``. Raises GridError.
    """
    vertices, faces = np.asarray(vertices, np.float64).reshape(-1, 3), np.asarray(faces, np.int64).reshape(-1, 3)
    if not len(faces):
        raise GridError("has no faces, so it has no inside: give it faces.")
    if not np.isfinite(vertices[faces]).all():
        raise GridError("has a vertex that is not a finite number: remove it.")
    used = vertices[faces.ravel()]
    low, high = used.min(axis=0), used.max(axis=0)
    longest = float((high - low).max())
    if not voxel_size > 0.0:
        voxel_size = longest / fineness
    try:
        mesh = triangles(vertices, faces)
    except ValueError:
        raise GridError("has no area, so it has no inside: move its vertices apart.") from None
    check()
    if longest / voxel_size > 1e5:
        raise GridError("has too many voxels: choose a larger voxel size.")
    return _Builder(mesh, low, high, voxel_size).build()
