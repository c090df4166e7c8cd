# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The grids of media that vary in space, from the values of their formulas at the points of a lattice."""

from __future__ import annotations

from functools import reduce

import numpy as np

from ....interruption import check
from ...scene import Scene
from ..geometry import bounds_of, positions_of
from .cells import LEAST_SHARE, MARGIN
from .point import measure
from .records import CELL, GRID, NOTHING

# Cells along an edge of a grid, and of one whose medium reads voxels, which have finer details; fewer if there are many
# grids, down to ``LEAST_SIDE``.
SIDE, VOXEL_SIDE = 16, 32
LEAST_SIDE = 4
MOST_CELLS = 1 << 18
STEP = 1.0 / 32.0  # of the width of a scene: sections of rays in the world's medium
_SMALLEST = 1e-6  # metres: width of the box of a flat mesh
_SEED = 5


def least_section(center: np.ndarray, half: np.ndarray) -> float:
    """The scalar "media_step", in metres, for a scene in these boxes (instances, 3)."""
    width = ((center + half).max(axis=0) - (center - half).min(axis=0)).max() if len(center) else 0.0
    return STEP * max(float(width), 1.0)


def fill_grids(
    scene: Scene, block: np.ndarray, workspace: np.ndarray, tables: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The tables of grids, for a ``block`` (1,) and a ``workspace`` (1,) that are otherwise filled from ``tables``."""
    varies, bounds = tables["media"]["varies"] != NOTHING, tables["media_bounds"]["medium"]
    wanted = [
        sorted({int(bounds[each]) for each in instance.materials if bounds[each] >= 0 and varies[bounds[each]]})
        for instance in scene.instances
    ]
    count = sum(map(len, wanted))
    most = int((MOST_CELLS / max(count, 1)) ** (1.0 / 3.0))
    grids: list[tuple] = []
    cells: list[np.ndarray] = []
    first = 0
    boxes: dict[int, tuple] = {}
    for owner, media in enumerate(wanted):
        instance = scene.instances[owner]
        if media and instance.mesh not in boxes:
            boxes[instance.mesh] = bounds_of(positions_of(scene.meshes[instance.mesh]))
        voxels = any(attribute.kind == "grid" for attribute in instance.attributes)
        side = int(np.clip(most, LEAST_SIDE, VOXEL_SIDE if voxels else SIDE))
        for medium in media:
            check()
            low, high = boxes[instance.mesh]
            size = np.maximum(high - low, _SMALLEST)
            grids.append((low, size, first, medium, side))
            first += side**3
            cells.append(_cells(block, workspace, medium, owner, np.asarray(instance.matrix), low, size, side))
    return {
        "media_grids": np.array(grids, GRID),
        "media_first_grid": np.cumsum([0, *map(len, wanted)]).astype(np.int64),
        "media_cells": np.concatenate(cells) if cells else np.zeros(0, CELL),
    }


def _cells(block, workspace, medium: int, owner: int, matrix, low, size, side: int) -> np.ndarray:
    """(side³,) cells of a box, z outermost. Its points are irregular, so that they do not miss regular patterns."""
    count = 2 * side + 1
    lattice = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij")[::-1], -1).reshape(-1, 3)
    shift = np.random.default_rng(_SEED).uniform(-0.5, 0.5, lattice.shape)
    places = np.clip((lattice + shift) / (count - 1), 0.0, 1.0)
    points = np.ascontiguousarray((low + places * size) @ matrix[:3, :3].T + matrix[:3, 3])
    values = np.empty((len(points), 9))
    measure(block[0], workspace[0], medium, owner, points, values)
    values = values.reshape(count, count, count, 9)
    scattering, extinction = values[..., 0:3].mean(-1, keepdims=True), values[..., 3:6]
    # The bounds also see what is half a cell around.
    most, least = _windows(extinction, np.maximum, 2), _windows(extinction, np.minimum, 1)
    margin = MARGIN * (most - least)
    floor = np.where(most.max() > least.min(), LEAST_SHARE * float(extinction.max()), 0.0)
    least = np.maximum(least - margin, 0.0)
    cells = np.zeros((side,) * 3, CELL)
    cells["majorant"] = np.maximum((most + margin).max(-1), floor)
    cells["spread"] = np.where((most > least).any(-1), np.maximum((most + margin - least).max(-1), floor), floor)
    cells["least"], cells["mean"] = least, _windows(extinction, np.add, 1) / 27.0
    means = _windows(scattering, np.add, 1)[..., 0] / 27.0
    cells["scattering"] = np.maximum(means, LEAST_SHARE * float(scattering.max()))
    cells["glow"] = np.abs(values[..., 6:9]).max()  # of all: emission between the points of a cell must not be missed
    return cells.reshape(-1)


def _windows(values: np.ndarray, join: np.ufunc, reach: int) -> np.ndarray:
    """(side, side, side, n): ``join`` of the values (2 side + 1, …, n) up to ``reach`` points from the middle of each
    cell along each axis."""
    for axis in range(3):
        count = values.shape[axis]
        shifted = [
            np.take(values, np.clip(np.arange(1, count, 2) + offset, 0, count - 1), axis)
            for offset in range(-reach, reach + 1)
        ]
        values = reduce(join, shifted)
    return values
