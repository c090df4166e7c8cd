# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path reuse: a surface where a branch of a path arrives gives its light to the paths of a group of pixels.

This module has the records, and the part of the integrator. ``cpu.path_reuse`` has the groups and the estimator.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, table
from ...vec import ZERO, largest, put, scale, vec
from ..settings import MOST_BRANCHES
from .geometry import TRIANGLES, instance_table, shading_material_table
from .path import COUNTS as PATH_COUNTS
from .path import REUSED, UNSHARED, WHITE, path_table, sample_table
from .shading.records import (
    DEPENDS_ON_VIEW,
    LAMBERT,
    MICROFACET,
    NEEDS_RAY,
    SUBSURFACE,
    TRACES_RAYS,
    VELVET,
    closure_table,
    surface_table,
)

# A group has one pixel of each of SIDE × SIDE pairs of neighbours. So light that is brighter than expected becomes
# scattered dots, not a square.
SIDE = 8
GROUP = SIDE * SIDE  # pixels whose paths share their branches

# A surface where a branch has arrived: a point of a triangle that a ray of this ``kind`` has met. ``even``: 1 if it
# scatters the same light in all directions. ``scale`` is a factor of its light, by Russian roulette. With the
# ``throughput`` (RGB) its light is a part of the branch's own sample. ``light_direction`` is that of the last light
# ray. ``number`` counts the arrivals that were shared, and ``uneven`` those of them that were not ``even``.
ARRIVAL = np.dtype(
    [
        ("position", "f8", 3),
        ("normal", "f8", 3),  # geometric, on the side of the branch
        ("u", "f8"),
        ("v", "f8"),
        ("instance", "i8"),
        ("primitive", "i8"),
        ("kind", "i8"),
        ("even", "i8"),
        ("number", "i8"),
        ("uneven", "i8"),
        ("scale", "f8"),
        ("throughput", "f8", 3),
        ("light_direction", "f8", 3),
    ],
    align=True,
)
# A surface where a path of the group divides: its throughput (RGB), its number of branches, and what it has taken from
# arrivals. From ``visible`` on: of the present arrival. ``value`` (RGB) is f |cos| G of
# the point, and ``pdf`` and ``area_pdf`` are densities of the arrival by solid angle, and by area for its kind of ray.
POINT = np.dtype(
    [
        ("throughput", "f8", 3),
        ("least_pdf", "f8"),
        ("branches", "i8"),
        ("pixel", "i8"),
        ("index", "i8"),
        ("sum", "f8"),
        ("squares", "f8"),
        ("visible", "i8"),
        ("direction", "f8", 3),
        ("value", "f8", 3),
        ("pdf", "f8"),
        ("area_pdf", "f8"),
    ],
    align=True,
)

# ``reuse_step``: of so many points of a group, one shares an arrival that is not even.
SCALARS = [("reuses_paths", np.int64), ("reuse_step", np.int64)]
TABLES = {"reuse_arrival": ARRIVAL, "reuse_points": POINT}
# The first path of a group, its branches with their rays, and the samples of its paths, in rows behind those of a path.
GROUP_START, GROUP_PATH = PATH_COUNTS["path"], PATH_COUNTS["path"] + 1
GROUP_RAY, GROUP_SAMPLE = PATH_COUNTS["ray"], PATH_COUNTS["sample"]
COUNTS = {
    "path": GROUP_PATH + GROUP * MOST_BRANCHES,
    "sample": GROUP_SAMPLE + GROUP,
    "ray": GROUP_RAY + GROUP * MOST_BRANCHES,
    "reuse_arrival": 1,
    "reuse_points": GROUP,
}

arrival_table = table("reuse_arrival", ARRIVAL)
point_table = table("reuse_points", POINT)


@kernel
def is_reusable(workspace):
    """Whether all that the surface of the workspace scatters is known for any pair of directions: no light passes
    straight, and no closure is compiled separately."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    for index in range(surface.closure_count):
        kind = closures[index].kind
        if kind > MICROFACET or kind == VELVET or kind == SUBSURFACE:
            return False
    return surface.closure_count > 0 and largest(vec(surface.transparency)) <= 0.0


@kernel
def arrive(block, workspace):
    """Let a branch that has met the surface of the workspace bring its light as an arrival, if all can share it.

    Its sample, as it is now, goes to row ``path.row``. The path goes on as if the camera saw the surface, so the sample
    of the workspace becomes the radiance from there.
    """
    path, surface, closures = path_table(workspace)[0], surface_table(workspace)[0], closure_table(workspace)
    path.reused = UNSHARED
    if path.last or surface.evaluable < surface.closure_count or not is_reusable(workspace):
        return
    if instance_table(block)[surface.instance].primitive != TRIANGLES:
        return
    flags = shading_material_table(block)[surface.material].flags
    if flags & (NEEDS_RAY | TRACES_RAYS):
        return
    arrival, samples = arrival_table(workspace)[0], sample_table(workspace)
    arrival.even = int(flags & DEPENDS_ON_VIEW == 0)
    for index in range(surface.closure_count):
        if closures[index].kind != LAMBERT:
            arrival.even = 0
    put(arrival.position, vec(surface.position))
    put(arrival.normal, vec(surface.ng))
    arrival.u, arrival.v = surface.barycentric[0], surface.barycentric[1]
    arrival.instance, arrival.primitive, arrival.kind = surface.instance, surface.primitive, path.kind
    arrival.scale = largest(vec(path.throughput)) / path.scale
    put(arrival.throughput, scale(vec(path.throughput), path.branch_weight / arrival.scale))
    samples[path.row] = samples[0]
    put(samples[0].combined, ZERO)
    put(samples[0].lamps, ZERO)
    put(path.throughput, WHITE)
    path.branch_weight, path.reused = 1.0, REUSED
