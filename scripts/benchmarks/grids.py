# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long signed distance grids of meshes take to build, per million voxels."""

from __future__ import annotations

import statistics
import time

import numpy as np

from .resume import in_parts

HELP = (
    "time to build signed distance grids of meshes: closed, with a hole, cracked, like a scan, of a million triangles"
)

TURNS = 5
VOXEL = 2.0 / 128  # metres


def _ring() -> tuple[np.ndarray, np.ndarray]:
    from support import grids

    return grids.torus(0.7, 0.25, 256, 128)


def _cut_ring() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = _ring()
    middles = vertices[faces].mean(axis=1)
    return vertices, faces[(middles[:, 0] < 0.6) | (middles[:, 2] < 0.1)]


def _scan() -> tuple[np.ndarray, np.ndarray]:
    from support import grids

    return grids.scan(300_000)


def _cracked_ring() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = _ring()
    vertices = vertices[faces.ravel()]
    vertices = vertices + np.random.default_rng(3).normal(size=vertices.shape) * 2e-4
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _fine_ring() -> tuple[np.ndarray, np.ndarray]:
    from support import grids

    return grids.torus(0.7, 0.25, 1000, 500)


MESHES = {
    "ring": _ring,
    "ring with a hole": _cut_ring,
    "cracked ring": _cracked_ring,
    "scan": _scan,
    "fine ring": _fine_ring,
}


def measure(name: str, turns: int = TURNS) -> dict:
    """The row of a mesh: the least time, the median of processor times, and the size of the grid. Other work lengthens
    times, and processor times much less."""
    from sdf_lights.sdf.data.voxels import mesh_grid

    vertices, faces = MESHES[name]()
    mesh_grid(vertices, faces, 0.1)  # compiles
    spent = []
    for _ in range(turns):
        wall, work = time.perf_counter(), time.process_time()
        grid = mesh_grid(vertices, faces, VOXEL)
        spent.append((time.perf_counter() - wall, time.process_time() - work))
    seconds, work = min(wall for wall, _ in spent), statistics.median(work for _, work in spent)
    millions = 1e-6 * grid.voxels
    return dict(
        grid_of=name,
        triangles=len(faces),
        voxels=grid.voxels,
        seconds=seconds,
        processor_seconds=work,
        seconds_per_million=seconds / millions,
        processor_seconds_per_million=work / millions,
        megabytes_per_million=1e-6 * grid.bytes / millions,
    )


def run(options) -> tuple[dict, list[dict]]:
    turns = options.repeats or (1 if options.quick else TURNS)
    rows = in_parts(MESHES, lambda name: measure(name, turns), options)
    summary = {
        f"build_processor_seconds_of_a_million_voxels_{row['grid_of'].replace(' ', '_')}": row[
            "processor_seconds_per_million"
        ]
        for row in rows
    }
    return summary | dict(megabytes_of_a_million_voxels=max(row["megabytes_per_million"] for row in rows)), rows
