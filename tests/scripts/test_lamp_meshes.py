# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that stand for lamps in other engines: closed, turned outwards, and as large as the lamp."""

import math

import numpy as np
import pytest

pytest.importorskip("bpy")

from benchmarks import lamp_meshes

BALL = 4.0 / 3.0 * math.pi
FRAME = 8.0 * 0.8**3 - (BALL * 1.08**3 - 2.0 * math.pi * 0.28**2 * (3.0 * 1.08 - 0.28))

SOLIDS = {  # what makes the mesh, its volume, and how near it is to that
    "torus": (lambda: lamp_meshes.torus(1.0, 0.35, 48, 24), 2.0 * math.pi**2 * 0.35**2, 1e-12),
    "box": (lambda: lamp_meshes.box((0.5, 1.0, 2.0)), 8.0, 1e-12),
    "ball": (lambda: lamp_meshes.sphere(2.0, 32, 16), 8.0 * BALL, 1e-12),
    "sponge": (lambda: lamp_meshes.sponge(0.75, 2), 1.5**3 * (20.0 / 27.0) ** 2, 1e-12),
    "frame": (
        lambda: lamp_meshes.difference(lamp_meshes.box((0.8,) * 3), lamp_meshes.sphere(1.08, 64, 32)),
        FRAME,
        1e-2,
    ),
    "isosurface": (
        lambda: lamp_meshes.isosurface(
            lambda p: np.hypot(np.hypot(p[:, 0], p[:, 1]) - 1.0, p[:, 2]) - 0.35,
            (-1.35, -1.35, -0.35),
            (1.35, 1.35, 0.35),
            40,
        ),
        2.0 * math.pi**2 * 0.35**2,
        1e-2,
    ),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_a_mesh_is_closed_and_as_large_as_the_lamp(name):
    make, volume, tolerance = SOLIDS[name]
    vertices, faces = solid = make()
    edges = np.concatenate([faces[:, [k, (k + 1) % faces.shape[1]]] for k in range(faces.shape[1])])
    # Each edge is passed as often one way as the other; where a sponge touches itself, twice.
    ways, counts = np.unique(edges, axis=0, return_counts=True)
    back = {(b, a): count for (a, b), count in zip(ways.tolist(), counts.tolist())}
    assert all(back.get((a, b)) == count for (a, b), count in zip(ways.tolist(), counts.tolist()))
    assert lamp_meshes.volume(solid) == pytest.approx(volume, rel=tolerance)


def test_vertices_of_an_isosurface_lie_on_it():
    vertices, _ = lamp_meshes.isosurface(lambda p: np.linalg.norm(p, axis=1) - 0.7, (-0.7,) * 3, (0.7,) * 3, 12)
    assert np.abs(np.linalg.norm(vertices, axis=1) - 0.7).max() < 1e-7


def test_a_mirrored_solid_still_faces_outwards():
    solid = lamp_meshes.box((0.5, 0.5, 0.5))
    mirrored = lamp_meshes.moved(solid, np.diag([-2.0, 1.0, 3.0, 1.0]))
    assert lamp_meshes.volume(mirrored) == pytest.approx(6.0)
