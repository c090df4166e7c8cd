# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Simple meshes."""

from __future__ import annotations

import numpy as np

from sdf_lights.render.scene import Mesh


def quad(name: str = "quad") -> Mesh:
    """Square of side 2 in the plane z = 0, facing +z, with UVs from 0 to 1."""
    positions = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    uv = (positions[:, :2] * 0.5 + 0.5)[triangles]
    tangents = np.tile(np.array([1, 0, 0, 1], np.float32), (2, 3, 1))
    return Mesh(name, positions, triangles, uvs={"": uv}, tangents={"": tangents})


def box(name: str = "box", inside_out: bool = False) -> Mesh:
    """Cube from −1 to 1. Its material slots are x, y and z for the faces normal to those axes."""
    positions, triangles, slots = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.zeros((4, 3), np.float32)
            corners[:, axis] = sign
            corners[:, (axis + 1) % 3] = np.array([-1, 1, 1, -1]) * sign
            corners[:, (axis + 2) % 3] = [-1, -1, 1, 1]
            first = len(positions)
            positions.extend(corners)
            faces = np.array([[0, 1, 2], [0, 2, 3]])
            triangles.extend((faces[:, ::-1] if inside_out else faces) + first)
            slots += [axis, axis]
    return Mesh(name, np.array(positions, np.float32), np.array(triangles, np.int32), slots=np.array(slots, np.int32))


def sphere(name: str = "sphere", columns: int = 20, rows: int = 10, smooth: bool = True) -> Mesh:
    """Unit sphere of 2 · columns · (rows − 1) triangles about the z axis."""
    theta = np.linspace(0, np.pi, rows + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    rings = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)
    positions = np.concatenate([[[0, 0, 1.0]], rings.reshape(-1, 3), [[0, 0, -1.0]]]).astype(np.float32)
    triangles = []
    last = len(positions) - 1
    for i in range(columns):
        j = (i + 1) % columns
        triangles.append((0, 1 + i, 1 + j))
        for row in range(rows - 2):
            a, b = 1 + row * columns + i, 1 + row * columns + j
            triangles += [(a, a + columns, b + columns), (a, b + columns, b)]
        triangles.append((last, last - columns + j, last - columns + i))
    triangles = np.array(triangles, np.int32)
    return Mesh(name, positions, triangles, normals=positions[triangles] if smooth else None)
