# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exit of light from below a surface."""

from __future__ import annotations

from ....jit import kernel
from ....vec import ZERO, add, average, dot, normalize, put, scale, vec
from ..geometry import shading_material_table
from ..path import AT_EXIT, path_table
from ..shading.closures import add_lambert
from ..shading.records import BENDS_EXITS, SUBSURFACE, closure_table, surface_table

WHITE = (1.0, 1.0, 1.0)


@kernel
def put_exit(workspace, position, direction, throughput):
    """Let the path leave at the hit in the workspace's ray, along ``direction``."""
    path = path_table(workspace)[0]
    put(path.throughput, throughput)
    put(path.start, position)
    put(path.direction, direction)
    path.event, path.kind, path.in_medium = AT_EXIT, 0, 0


@kernel
def emerge(block, workspace, unused):
    """Replace the closures of the workspace's surface by that of an exit: a white diffuse one.

    Its normal is that of the subsurface closures there, if their material bends it; ``shade`` has run before.
    """
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    n = ZERO
    if shading_material_table(block)[surface.material].flags & BENDS_EXITS:
        for index in range(surface.closure_count):
            if closures[index].kind == SUBSURFACE:
                n = add(n, scale(vec(closures[index].normal), average(vec(closures[index].weight))))
    n = normalize(n) if dot(n, n) > 0.0 else vec(surface.n)
    surface.closure_count = surface.evaluable = surface.subsurface = surface.portal = 0
    surface.pick_total, surface.holdout = 0.0, 0.0
    put(surface.emission, ZERO)
    put(surface.transparency, ZERO)
    add_lambert(workspace, WHITE, n, False)
    closures[0].pick = 1.0
    return 0.0
