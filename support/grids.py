# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes for grids, and rays through shapes."""

import numpy as np


def torus(major: float, minor: float, around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of a torus."""
    u, v = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, around, endpoint=False),
        np.linspace(0.0, 2.0 * np.pi, across, endpoint=False),
        indexing="ij",
    )
    far = major + minor * np.cos(v)
    vertices = np.stack([far * np.cos(u), far * np.sin(u), minor * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return vertices, faces


def joined(*meshes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """One mesh of several."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
    return (
        np.concatenate([vertices for vertices, _ in meshes]),
        np.concatenate([faces + start for (_, faces), start in zip(meshes, starts)]),
    )


def scan(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A mesh of about ``count`` triangles, like those from scanners: noisy, with holes and loose and doubled parts that
    cross."""
    rng = np.random.default_rng(11)
    side = int(np.sqrt(count / 8.0))
    vertices, faces = torus(0.7, 0.3, 2 * side, side)
    vertices = vertices * (1.0 + 0.05 * np.sin(9.0 * vertices[:, [1, 2, 0]])) + rng.normal(size=vertices.shape) * 4e-4
    middles = vertices[faces].mean(axis=1)
    centers = middles[rng.choice(len(faces), 20)]
    hole = (np.linalg.norm(middles[:, None] - centers, axis=2) < 0.03).any(axis=1)
    whole = vertices, faces[~hole]
    part = vertices + (0.01, 0.005, 0.0), faces[middles[:, 0] > 0.0]
    ball = 0.5 * vertices[:, [2, 0, 1]] + (0.5, 0.4, 0.1), faces[: len(faces) // 2]
    return joined(whole, part, ball)


def rays_around(shape, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (count, 3) of rays at the box of a shape from all sides."""
    rng = np.random.default_rng(seed)
    low, high = shape.bounds()
    targets = low + rng.random((count, 3)) * (high - low)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return targets - 2.0 * np.linalg.norm(high - low) * directions, directions
