# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Zeros of grids along rays: against the search by balls in the same field, and against many points of the ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from sdf_lights.sdf.data.grid import CORNERS, SIDE, Grid, grid_tables
from sdf_lights.sdf.data.voxels import mesh_grid
from sdf_lights.sdf.shapes import SHAPES
from sdf_lights.sdf.shapes.operators import Transformed
from support import grids
from support.lamps.rays import Traced
from support.lamps.shapes_under_test import FieldOf

COUNTS = np.array([3, 2, 2])  # blocks of a grid of noise
SIZE = 0.07


@dataclass(frozen=True)
class Searched(FieldOf, abstract=True):
    """A grid whose zeros are searched as those of any other field."""

    def terms(self, matrix, factor):
        return [term._replace(zeros=None) for term in super().terms(matrix, factor)]


def _noise(seed: int, share: float) -> Grid:
    """A grid of random values, of which a ``share`` is outside: rays change sides in most voxels."""
    rng = np.random.default_rng(seed)
    lattice = np.ones(SIDE * COUNTS[::-1] + 1)
    lattice[1:-1, 1:-1, 1:-1] = rng.uniform(share - 1.0, share, lattice[1:-1, 1:-1, 1:-1].shape)
    blocks = np.argwhere(np.ones(COUNTS))
    values = np.stack([lattice[tuple(slice(SIDE * b, SIDE * b + CORNERS) for b in block[::-1])] for block in blocks])
    return Grid(*grid_tables(np.array([-0.3, 0.2, 1.0]), SIZE, np.ones(COUNTS[::-1] + 1), blocks, values, 1.0))


def _rays(shape, count: int, seed: int):
    """From all sides; some in a plane or along an axis of the grid, through corners of voxels, or from inside."""
    origins, directions = grids.rays_around(shape, count, seed)
    rng = np.random.default_rng(seed)
    flat, along, inside = (slice(k, None, 5) for k in range(3))
    directions[flat, 1] = 0.0
    directions[along] = np.eye(3)[rng.integers(0, 3, len(directions[along]))] * rng.choice([-1.0, 1.0])
    low, high = shape.bounds()
    target = low + SIZE * np.floor((high - low) / SIZE * rng.random((count, 3)))
    origins[flat] = target[flat] - 3.0 * directions[flat]
    origins[along] = target[along] - 5.0 * directions[along]
    origins[inside] = target[inside]
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


RING = mesh_grid(*grids.torus(0.7, 0.25, 96, 48), 2.0 / 50)
TURNED = np.array([[0.0, 1.3, 0.2, 5.0], [-0.8, 0.0, 0.0, 1.0], [0.1, 0.0, -2.0, 0.5], [0.0, 0.0, 0.0, 1.0]])


@pytest.mark.parametrize(
    "shape",
    [RING, Transformed(RING, TURNED), _noise(1, 0.5), _noise(2, 0.9)],
    ids=["ring", "turned", "noise", "holes"],
)
def test_rays_find_what_the_search_finds(shape):
    origins, directions = _rays(shape, 4000, 3)
    found = Traced(shape).trace(origins, directions)
    searched = Traced(Searched(shape)).trace(origins, directions)
    sure = searched[:, 2] < 1e-9
    assert sure.sum() > 300 and found[:, 0].max() >= 2
    assert np.abs(found - searched)[sure, 1].max() < 1e-8
    # Where a ray touches a surface, rounding decides whether it has an interval.
    assert np.mean(found[sure, 0] != searched[sure, 0]) < 2e-3
    assert (found[:, 2] == 0.0).all()


@pytest.mark.parametrize("shape", [RING, _noise(4, 0.5)], ids=["ring", "noise"])
def test_the_field_has_the_sign_that_the_intervals_say(shape):
    traced, points = Traced(shape), np.linspace(0.0, 6.0, 3001)[1:]
    for o, d in zip(*_rays(shape, 200, 5)):
        spans = traced.intervals(o, d)
        inside = ((spans[:, 0] < points[:, None]) & (points[:, None] < spans[:, 1])).any(axis=1)
        values = shape.distance(o + points[:, None] * d)
        certain = np.abs(values) > 1e-9
        assert np.array_equal(inside[certain], values[certain] < 0.0)


def test_a_ray_of_more_zeros_than_rows_says_so():
    shape = _noise(6, 0.5)
    origins, directions = _rays(shape, 500, 7)
    every, few = Traced(shape).trace(origins, directions), Traced(shape, rows=2).trace(origins, directions)
    many = every[:, 0] > 4
    assert many.mean() > 0.2 and (few[many, 0] <= 2).all() and (few[many, 2] > 0.0).all()


def test_a_grid_in_other_shapes_is_searched():
    """A ray's own way through a grid is no way through what bends space, or joins the grid with more."""
    origins, directions = _rays(RING, 500, 8)
    for shape in (
        SHAPES["twist"](RING, 0.7),
        SHAPES["union"](RING, SHAPES["sphere"](0.4)),
        SHAPES["onion"](RING, 0.03),
    ):
        found = Traced(shape).trace(origins, directions)
        points = origins[:, None] + np.linspace(0.0, 12.0, 3001)[:, None] * directions[:, None]
        inside = shape.distance(points.reshape(-1, 3)).reshape(points.shape[:2]) < 0.0
        assert abs(found[:, 1].sum() / (inside.sum() * 12.0 / 3000) - 1.0) < 0.01
