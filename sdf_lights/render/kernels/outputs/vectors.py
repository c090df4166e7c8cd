# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Vector: the motion in pixels from the previous frame, and to the next frame. As in Cycles, for hair and
points it is the motion of their middle.
"""

from __future__ import annotations

import numpy as np

from ....affine import inverse
from ....jit import kernel
from ....vec import ZERO, add, madd, transform_point, transform_vector, vec
from ...scene import Primitive, Scene
from ..camera import camera_record, camera_table, pixel_of
from ..geometry import TRIANGLES, instance_at, triangle_table
from ..path import path_table
from ..shading.records import surface_table
from ..strands.surface import curve_at, vertex
from .records import (
    DATA_NAMES,
    SHIFT,
    VECTOR_INSTANCE,
    VECTOR_TABLES,
    data_place_table,
    output_sum_table,
    shift_table,
    vector_camera_table,
    vector_instance_table,
)

_VECTOR, _SPHERES = DATA_NAMES["vector"], int(Primitive.SPHERES)


def pack_vectors(scene: Scene, wanted: bool) -> dict[str, np.ndarray]:
    """``VECTOR_TABLES``; empty unless the pass is ``wanted``."""
    if not wanted:
        return {name: np.zeros(0, dtype) for name, dtype in VECTOR_TABLES.items()}
    cameras = scene.camera.around or (scene.camera, scene.camera)
    records = np.zeros(len(scene.instances), VECTOR_INSTANCE)
    first, shifts, count = {}, [np.zeros((0, 3), np.float32)], 0
    for record, instance in zip(records, scene.instances):
        matrix, mesh = np.asarray(instance.matrix, np.float64), scene.meshes[instance.mesh]
        back = inverse(matrix)
        for at, there in enumerate((matrix, matrix) if instance.around is None else instance.around):
            record["pose"][at], record["turn"][at] = (there @ back)[:3], there[:3]
        if mesh.shifts is not None and instance.mesh not in first:
            first[instance.mesh] = count
            shifts.append(mesh.shifts.reshape(-1, 3))
            count += len(shifts[-1])
        record["shifts"], record["vertex_count"] = first.get(instance.mesh, -1), len(mesh.positions)
    return {
        "vector_cameras": np.concatenate([camera_record(camera, scene) for camera in cameras]),
        "vector_instances": records,
        "vector_shifts": np.concatenate(shifts).astype(np.float32).reshape(-1).view(SHIFT),
    }


@kernel
def _middle(block, instance, surface):
    """World position that moves."""
    if instance.primitive == TRIANGLES:
        return vec(surface.position)
    if instance.primitive == _SPHERES:
        row = instance.triangles + surface.primitive
        p = vertex(block, instance, np.int64(triangle_table(block)[row].v[0]))
    else:
        p, _ = curve_at(block, instance, np.int64(surface.primitive), surface.barycentric[0])
    return p if instance.baked else transform_point(instance.matrix, p)


@kernel
def _shift(block, instance, moved, surface, at):
    """Displacement of the surface in local space."""
    if moved.shifts < 0:
        return ZERO
    row = triangle_table(block)[instance.triangles + surface.primitive]
    u = surface.barycentric[0]
    v = surface.barycentric[1] if instance.primitive == TRIANGLES else 0.0
    total = ZERO
    for corner in range(3):
        weight = 1.0 - u - v if corner == 0 else u if corner == 1 else v
        shift = shift_table(block)[moved.shifts + at * moved.vertex_count + row.v[corner]]
        total = madd(total, weight, vec(shift.d))
    return total


@kernel
def _add(block, workspace, here, before, after):
    sums = output_sum_table(workspace)
    place = 2 * block.light_columns + data_place_table(block)[_VECTOR]
    sums[place] += before[0] - here[0]
    sums[place + 1] += before[1] - here[1]
    sums[place + 2] += here[0] - after[0]
    sums[place + 3] += here[1] - after[1]
    sums[place + 4] += 1.0


@kernel
def _pixel(block, moved, instance, surface, middle, at):
    place = add(
        transform_point(moved.pose[at], middle),
        transform_vector(moved.turn[at], _shift(block, instance, moved, surface, at)),
    )
    return pixel_of(vector_camera_table(block)[at], place, False)


@kernel
def add_vector(block, workspace, unused):
    """Add the motion of the surface that the camera sees."""
    surface = surface_table(workspace)[0]
    instance, moved = instance_at(block, surface.instance), vector_instance_table(block)[surface.instance]
    middle = _middle(block, instance, surface)
    _add(
        block,
        workspace,
        pixel_of(camera_table(block)[0], middle, False),
        _pixel(block, moved, instance, surface, middle, 0),
        _pixel(block, moved, instance, surface, middle, 1),
    )
    return 0.0


@kernel
def add_background_vector(block, workspace, unused):
    """Add the motion of the background, which is infinitely far."""
    way, cameras = vec(path_table(workspace)[0].direction), vector_camera_table(block)
    _add(
        block,
        workspace,
        pixel_of(camera_table(block)[0], way, True),
        pixel_of(cameras[0], way, True),
        pixel_of(cameras[1], way, True),
    )
    return 0.0
