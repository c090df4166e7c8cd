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
from .crossings import crossed, find_crossings
from .grid import BLOCK, CORNERS, SIDE, Grid, grid_tables
from .jumps import without_jumps
from .triangles import Triangles, nearest, triangles, winding

BAND = 5.0  # voxels on each side of the surface
FINENESS, PREVIEW = 128, 64  # voxels along the longest side, if nobody chooses their size; while a mesh is being edited
MOST_BLOCKS = 1 << 14  # with voxels: 8 million voxels
MOST_CORNERS = 1 << 22  # of blocks
INSIDE = 0.52  # winding number of the surface where there are no faces: above the half that flat sheets come near
CHANGE = 0.5  # of the winding number in a ball without open edges, as of leaks through one sheet
ROUGH, ROUGH_SHARE = 0.2, 0.3  # a bound of errors with this share of the square of ``FAR``, for a third of the time
ON_A_FACE = 1e-6  # voxels
# Voxels: sides are those of points beside the lattice, whose lines meet no corner of a mesh that was made on it.
ASIDE = 6.18e-8, 3.67e-8, 7.85e-8
UNKNOWN, KNOWN, COMPUTED = range(3)  # winding numbers at points of a lattice
_TASK = 24  # blocks between two looks whether to go on: some hundredths of a second


class GridError(ValueError):
    """A mesh has no grid: the rest of a sentence that names it."""


@kernel
def _margin(turns):
    """How far a winding number is from where a point changes its side, also if whole numbers are added to it."""
    rest = turns - math.floor(turns)
    return min(abs(rest - INSIDE), abs(rest - (1.0 - INSIDE)))


@kernel
def _side(turns):
    """A number that is another one where a point changes its side."""
    return math.floor(turns - INSIDE) + math.floor(turns - (1.0 - INSIDE))


@kernel
def _at(corners, moments, x, y, z, spacing, k, j, i, states, windings):
    """The winding number at a point of a lattice; what is there already is not computed again."""
    if states[k, j, i] != COMPUTED:
        states[k, j, i] = COMPUTED
        windings[k, j, i] = winding(corners, moments, x + spacing * i, y + spacing * j, z + spacing * k, 1.0)
    return windings[k, j, i]


@kernel
def _find_windings(
    corners, nodes, moments, rim, rim_nodes, rim_disks, x, y, z, spacing, crossings, states, pending, windings
):
    """Winding numbers at a lattice of points (m, m, m), which begins at x, y, z; m − 1 is a power of two. Most are not
    exact, only on the right side of ``INSIDE``.

    Apart from what faces add, the winding number is harmonic where no open edge is. In a ball where it differs by less
    than ``CHANGE`` from that of the middle, it does so by about ``CHANGE`` 3/2 s / (1 − s) at s radii, and by
    ``CHANGE`` s² from what the corners of a cube tell that is as large (its expansion in solid harmonics). So the
    middle of a cube far from open edges is enough, or that and its corners. Otherwise the cube is divided.
    """
    half, at = windings.shape[0] // 2, 0
    states[:] = UNKNOWN
    find_crossings(corners, nodes, x, y, z, spacing, crossings)
    pending[0], pending[1], pending[2], pending[3] = half, half, half, half
    depth = 4
    while depth > 0:
        depth -= 4
        k, j, i, half = pending[depth], pending[depth + 1], pending[depth + 2], pending[depth + 3]
        far, turns, alike = math.inf, 0.0, False
        if len(rim):
            middle = x + spacing * i, y + spacing * j, z + spacing * k
            far, at = nearest(rim, rim_nodes, rim_disks, middle[0], middle[1], middle[2], math.inf, at)
        s = math.sqrt(3.0) * half * spacing / far
        if s < 1.0:
            turns = _at(corners, moments, x, y, z, spacing, k, j, i, states, windings)
            alike = _margin(turns) > CHANGE * 1.5 * s / (1.0 - s)
            if not alike and _margin(turns) > CHANGE * s * s:
                alike = True
                for corner in range(8):
                    c = k + (half if corner & 4 else -half)
                    b = j + (half if corner & 2 else -half)
                    a = i + (half if corner & 1 else -half)
                    other = _at(corners, moments, x, y, z, spacing, c, b, a, states, windings)
                    other -= crossed(crossings, k, j, i, c, b, a)
                    if not (_margin(other) > CHANGE * s * s and _side(other) == _side(turns)):
                        alike = False
                        break
        if alike:
            for c in range(k - half, k + half + 1):
                for b in range(j - half, j + half + 1):
                    for a in range(i - half, i + half + 1):
                        if states[c, b, a] == UNKNOWN:
                            windings[c, b, a] = turns + crossed(crossings, k, j, i, c, b, a)
                            states[c, b, a] = KNOWN
        elif half == 1:
            for c in range(k - 1, k + 2):
                for b in range(j - 1, j + 2):
                    for a in range(i - 1, i + 2):
                        if states[c, b, a] == UNKNOWN:
                            px, py, pz = x + spacing * a, y + spacing * b, z + spacing * c
                            found = winding(corners, moments, px, py, pz, ROUGH_SHARE)
                            if _margin(found) < ROUGH:
                                found = winding(corners, moments, px, py, pz, 1.0)
                            windings[c, b, a], states[c, b, a] = found, KNOWN
        else:
            half //= 2
            for corner in range(8):
                pending[depth] = k + (half if corner & 4 else -half)
                pending[depth + 1] = j + (half if corner & 2 else -half)
                pending[depth + 2] = i + (half if corner & 1 else -half)
                pending[depth + 3] = half
                depth += 4


@kernel
def _distances(corners, nodes, disks, x, y, z, spacing, band, guess, distances):
    """Distances at a lattice of points (m, m, m), which begins at x, y, z. Those above ``band`` need not be exact: they
    are above it. Leaves near the first and the last one are ``guess`` and the result."""
    m = len(distances)
    side = 3 if m % 3 == 0 else 1
    reach = math.sqrt(3.0) * (side // 2) * spacing * (1.0 + 1e-9)
    for cube in range((m // side) ** 3):
        i, j, k = cube % (m // side) * side, cube // (m // side) % (m // side) * side, cube // (m // side) ** 2 * side
        # Most cubes far from faces need one distance.
        middle = x + spacing * (i + side // 2), y + spacing * (j + side // 2), z + spacing * (k + side // 2)
        found, guess = nearest(corners, nodes, disks, middle[0], middle[1], middle[2], band + reach, guess)
        if found > band + reach:
            distances[k : k + side, j : j + side, i : i + side] = found - reach
            continue
        at_middle = found
        for c in range(k, k + side):
            for b in range(j, j + side):
                for a in range(i, i + side):
                    found = at_middle
                    if 2 * (a - i) != side - 1 or 2 * (b - j) != side - 1 or 2 * (c - k) != side - 1:
                        px, py, pz = x + spacing * a, y + spacing * b, z + spacing * c
                        found, guess = nearest(corners, nodes, disks, px, py, pz, band, guess)
                    distances[c, b, a] = found
    return guess


@kernel
def _measure(
    corners, nodes, moments, disks, rim, rim_nodes, rim_disks, corner, size, starts, step, band, distances, windings
):
    """Distances and winding numbers (n, m, m, m) at lattices of points ``step`` voxels apart, which begin at
    ``starts``.

    Distances above ``band`` need not be exact: they are above it.
    """
    m, guess, spacing = distances.shape[1], 0, size * step
    crossings, states = np.empty((3, m, m, m), np.int64), np.empty((m, m, m), np.int8)
    pending = np.empty(4 * 8 * 4, np.int64)
    for block in range(len(starts)):
        x, y = corner[0] + size * starts[block, 0], corner[1] + size * starts[block, 1]
        z = corner[2] + size * starts[block, 2]
        guess = _distances(corners, nodes, disks, x, y, z, spacing, band, guess, distances[block])
        x, y, z = x + ASIDE[0] * size, y + ASIDE[1] * size, z + ASIDE[2] * size
        if m == 1:
            windings[block, 0, 0, 0] = winding(corners, moments, x, y, z, 1.0)
            continue
        _find_windings(
            corners, nodes, moments, rim, rim_nodes, rim_disks, x, y, z, spacing, crossings, states, pending,
            windings[block],
        )  # fmt: skip


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
        self.mesh, self.size, self.closed = mesh, size, not len(mesh.rim)
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
                *mesh,
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
        if not self.closed:
            check()
            joined = without_jumps(blocks, self.counts, joined, self.size)
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
        if not self.closed:
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
    is_used = np.zeros(len(vertices), bool)
    is_used[faces] = True
    used = vertices[is_used]
    if not np.isfinite(used).all():
        raise GridError("has a vertex that is not a finite number: remove it.")
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
