# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers. As in Cycles, a path from the camera splits where it hits one: one part continues normally, the
other in a scene with only the catchers. The ratio of both is the effect of the objects on the light of the catcher.
"""

from __future__ import annotations

import numpy as np

from ....jit import kernel
from ....vec import average, mul, vec
from .. import lights
from ..emission_graphs import modulated
from ..path import CAMERA, CAUGHT, CAUGHT_RAY, KEPT_SAMPLE, clear_sample, path_table, sample_table
from ..rays import ray_table
from .records import DATA_NAMES, data_place_table, output_sum_table

_BARE, _CAUGHT, _BACKDROP, _UNCAUGHT = (DATA_NAMES[name] for name in ("bare", "caught", "backdrop", "uncaught"))


@kernel
def _add(block, workspace, name, value):
    place = data_place_table(block)[name]
    if place >= 0:
        sums, start = output_sum_table(workspace), 2 * block.light_columns + place
        for axis in range(3):
            sums[start + axis] += value[axis]


@kernel
def _backdrop(block, path):
    """Radiance (RGB) of the world behind a catcher."""
    world = lights.world_emitter(block)
    if block.transparent_film or not lights.visibility(block, world) & CAMERA:
        return (0.0, 0.0, 0.0)
    return lights.world_radiance(block, vec(path.direction))


@kernel
def catch(block, workspace, unused):
    """Store the path that has hit a catcher, and its ray, if it is the first."""
    path = path_table(workspace)[0]
    if path.catches:
        return 0.0
    path_table(workspace)[CAUGHT] = path
    ray_table(workspace)[CAUGHT_RAY] = ray_table(workspace)[0]
    path.catches = 1
    sums, throughput, places = output_sum_table(workspace), vec(path.throughput), data_place_table(block)
    start = 2 * block.light_columns
    sums[start + places[_CAUGHT]] = 1.0
    sums[start + places[_UNCAUGHT]] = max(sample_table(workspace)[0].alpha - average(throughput), 0.0)
    radiance = _backdrop(block, path)
    if block.emission_graphs:
        world, direction = lights.world_emitter(block), vec(path.direction)
        radiance = modulated(block, workspace, world, radiance, vec(path.origin), direction, np.inf, CAMERA)
    _add(block, workspace, _BACKDROP, mul(throughput, radiance))
    return 0.0


@kernel
def release(block, workspace, unused):
    """Restore the path that has hit a catcher, with a separate sample. Returns 0 if there is none."""
    sums, place = output_sum_table(workspace), data_place_table(block)[_CAUGHT]
    samples, start = sample_table(workspace), 2 * block.light_columns
    if sums[start + place] == 0.0:
        sums[start + data_place_table(block)[_UNCAUGHT]] = samples[0].alpha
        return 0.0
    samples[KEPT_SAMPLE] = samples[0]
    clear_sample(workspace)
    path_table(workspace)[0] = path_table(workspace)[CAUGHT]
    ray_table(workspace)[0] = ray_table(workspace)[CAUGHT_RAY]
    return 1.0


@kernel
def add_bare(block, workspace, unused):
    """Add the contribution of that path to the film, and restore the earlier sample."""
    samples = sample_table(workspace)
    _add(block, workspace, _BARE, vec(samples[0].combined))
    samples[0] = samples[KEPT_SAMPLE]
    return 0.0
