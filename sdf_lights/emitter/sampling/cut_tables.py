# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that cuts need of a lamp: the transform of its tree, and the tree in little memory."""

from __future__ import annotations

import functools
import heapq

import numpy as np

from ...affine import inverse
from ...jit import kernel, table
from ..building.build import BuiltLamp, volume_of
from ..lamps import PRIMITIVE
from ..tree import interior, moments
from ..tree.moments import CELL
from . import hidden
from .similar import similar

MOST_BOXES = 32  # in a cut
NEIGHBOURS, NEIGHBOUR_LEVELS = 0.2, 3  # fraction of a leaf's emission that is taken from the eight leaves around it
LEAST_BRIGHT = 0.02  # minimum emission of a box, relative to the mean: it was estimated

# Interior fraction of a box, and its part of the lamp, at which points are drawn from it, if testing one takes
# nanoseconds.
QUICK_FILL, QUICK_PART = 0.5, 1.0 / 256.0

PLACEMENT = np.dtype(
    [
        ("first_cell", np.int64),
        ("first_seen", np.int64),  # see ``hidden``
        ("matrix", np.float64, (3, 4)),  # tree space -> world, relative to the lamp's centre
        ("inverse", np.float64, (3, 4)),  # the inverse
        ("metric", np.float64, (3, 3)),  # scalar product of the world, in tree space
        ("factor", np.float64),  # world volume of a unit of tree space
        ("unit", np.float64, (3,)),  # length in tree space of a world metre along each of its axes
        ("extent", np.float64),  # m², mean square distance of the interior from its centroid, in the world
        ("centroid", np.float64, (3,)),  # in the world, relative to the lamp's centre
        ("thickness", np.float64),  # m in the world: mean of the boxes' least sides
        (
            "rough",
            np.float64,
        ),  # relative variance that its emission leaves in the boxes of a cut, at equal distances
        ("leaf_rough", np.float64),  # the same in the leaves of the tree, if they are chosen by their emission
        ("clear", np.int64),  # 1: no surface stands inside the lamp, as far as is known
    ],
    align=True,
)

STEP_DOWN = np.dtype(
    [  # the data of a cell needed to choose between it and its sibling, in little memory
        ("first", np.int32),  # as in CELL; −1 if points are drawn from the cell itself
        ("axis", np.int32),
        ("volume", np.float32),
        ("centroid", np.float32, (3,)),
        ("light", np.float32),  # m³: expected emission of the cell (``expected_light``)
        ("rough", np.float32),  # relative variance of the emission in the cell
    ],
    align=True,
)

# Fields on which the boxes of regions depend. The boxes are stored, so these must not move with a lamp.
OF_REGIONS = ("metric", "unit", "thickness")

TABLES = {"lamp_placements": PLACEMENT, "lamp_cells": CELL, "lamp_steps": STEP_DOWN, **hidden.TABLES}

placements = table("lamp_placements", PLACEMENT)
lamp_steps = table("lamp_steps", STEP_DOWN)


@functools.lru_cache(maxsize=32)
def uniform_cells(shape) -> np.ndarray:
    """``moments.cells`` of a shape."""
    return moments.cells(interior.tree(shape), volume_of(shape)[0])


@kernel
def roughness(cells, out):
    """``out``: relative variance of the emission in each cell, from the differences between the leaves below."""
    second = np.zeros(len(cells))
    for index in range(len(cells) - 1, -1, -1):
        cell = cells[index]
        if cell.first < 0:
            second[index] = cell.mass * cell.mass / cell.volume if cell.volume > 0.0 else 0.0
        else:
            second[index] = second[cell.first] + second[cell.first + 1]
        square = cell.mass * cell.mass
        out[index] = max(second[index] * cell.volume / square - 1.0, 0.0) if square > 0.0 else 0.0


@kernel
def expected_light(cells, out):
    """``out``: expected emission of each cell, for drawing points. A leaf has only few samples,
    which may have missed emission, so it gets a part of its neighbours' emission."""
    parent = np.zeros(len(cells), np.int64)
    for index in range(len(cells)):
        cell = cells[index]
        if cell.first >= 0:
            parent[cell.first] = parent[cell.first + 1] = index
            continue
        around = index
        for _ in range(NEIGHBOUR_LEVELS):
            around = parent[around]
        around_volume = cells[around].volume
        mean = cells[around].mass / around_volume if around_volume > 0.0 else 1.0
        out[index] = (1.0 - NEIGHBOURS) * cell.mass + (NEIGHBOURS * mean + LEAST_BRIGHT) * cell.volume
    for index in range(len(cells) - 1, -1, -1):
        if cells[index].first >= 0:
            out[index] = out[cells[index].first] + out[cells[index].first + 1]


def _rough_in_boxes(cells: np.ndarray, rough: np.ndarray) -> float:
    """``PLACEMENT.rough``: splits the box with the largest variance, as ``cut_boxes`` does."""
    first, uneven = cells["first"], -cells["mass"] * rough
    boxes = [(uneven[0], 0)]
    while len(boxes) < MOST_BOXES and boxes[0][0] < 0.0:
        low = first[boxes[0][1]]
        heapq.heapreplace(boxes, (uneven[low], low))
        heapq.heappush(boxes, (uneven[low + 1], low + 1))
    return -sum(left for left, _ in boxes) / max(cells["mass"][0], 1e-300)


def pack_cuts(built: list[BuiltLamp], sources: list) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps that were built from ``sources``: anything with a ``shape`` and a ``matrix``."""
    placed, used, known = np.zeros(len(built), PLACEMENT), 0, {}
    parts, drawn, uneven, light = [np.zeros(0, CELL)], [np.zeros(0, bool)], [np.zeros(0)], [np.zeros(0)]
    for row, lamp, source in zip(placed, built, sources):
        shape, matrix = source.shape, np.asarray(source.matrix, np.float64)
        if lamp.tree is None and lamp.emission is None:
            shape, matrix = similar(shape, matrix)
        tree = interior.tree(shape)
        factor = abs(float(np.linalg.det(matrix[:3, :3])))
        own = uniform_cells(shape) if lamp.emission is None else lamp.emission.emission_moments.cells
        if id(own) not in known:
            rough, expected = np.zeros(len(own)), np.zeros(len(own))
            roughness(own, rough)
            expected_light(own, expected)
            known[id(own)] = used, _thickness(own), _rough_in_boxes(own, rough)
            parts.append(own)
            drawn.append(_drawn(own, lamp.row["kind"][0] == PRIMITIVE) if lamp.emission is None else own["first"] < 0)
            uneven.append(rough)
            light.append(expected)
            used += len(own)
        to_world = matrix.copy()
        to_world[:3, 3] += to_world[:3, :3] @ tree.center - lamp.row["center"][0]
        row["first_seen"] = hidden.NONE
        row["first_cell"], thickness, row["rough"] = known[id(own)]
        row["clear"], row["leaf_rough"] = 1, lamp.emission.emission_moments.rough if lamp.emission is not None else 0.0
        row["thickness"], row["factor"] = thickness * factor ** (1.0 / 3.0), factor
        row["matrix"], row["inverse"] = to_world[:3], inverse(to_world)[:3]
        row["metric"] = to_world[:3, :3].T @ to_world[:3, :3]
        row["unit"] = 1.0 / np.sqrt(row["metric"].diagonal())
        row["extent"] = row["metric"].diagonal() @ own["spread"][0]
        row["centroid"] = to_world[:3, :3] @ own["centroid"][0] + to_world[:3, 3]
    cells, drawn = np.concatenate(parts), np.concatenate(drawn)
    steps = np.zeros(len(cells), STEP_DOWN)
    for name in ("axis", "volume", "centroid"):
        steps[name] = cells[name]
    steps["first"], steps["rough"] = np.where(drawn, -1, cells["first"]), np.concatenate(uneven)
    steps["light"] = np.concatenate(light)
    seen = np.zeros(0, hidden.SEEN)  # until places of the scene have looked
    return {"lamp_placements": placed, "lamp_cells": cells, "lamp_steps": steps, "lamp_seen": seen}


def _drawn(cells: np.ndarray, quick: bool) -> np.ndarray:
    """Cells from which points are drawn until one is inside. ``quick``: testing a point costs less than going further
    down; but only in small cells, because a point drawn again is not stratified in its cell."""
    volume, (x, y, z) = cells["volume"], (cells["high"] - cells["low"]).T
    size = x * y * z
    small = volume <= QUICK_PART * volume[:1]
    return (cells["direct"] != 0) | (quick & small & (volume >= QUICK_FILL * size))


def _thickness(cells: np.ndarray) -> float:
    """Mean over the volume of the least side of a point's box, in tree space."""
    low, high, volume = (cells[name][cells["first"] < 0] for name in ("low", "high", "volume"))
    return np.average(functools.reduce(np.minimum, (high - low).T), weights=volume + 1e-300)
