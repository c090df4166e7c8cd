# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small shape of each kind of data, by which its kernels are compiled before a scene has one."""

from __future__ import annotations

import functools
import itertools

import numpy as np

from ..shapes import SHAPES, Shape
from .grid import GRID
from .network import EXAMPLE, NETWORK, read
from .outline import OUTLINE, Outline, windings
from .texture import TEXTURE
from .tube import TUBE, TUBE_ALONG, Tube, tube_table
from .voxels import mesh_grid

FUNCTIONS = OUTLINE, TUBE, TUBE_ALONG, GRID, NETWORK, TEXTURE


@functools.cache
def simplest() -> tuple[Shape, ...]:
    """Two squares that cross, a rod, a box without a lid, and the network that the add-on has."""
    square = np.array([[-0.3, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.3, 0.3]])
    outline = Outline.of([square, square + 0.1])
    windings(outline.segments, square)
    rod = Tube(tube_table(np.array([[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.5, 0.05]])))
    corners = 0.5 * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
    faces = np.array([triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))])
    sign = SHAPES["extrusion"](outline, 0.2, 0.01)  # type: ignore[call-arg]
    return sign, rod, mesh_grid(corners, faces, fineness=8), read(EXAMPLE).shape()
