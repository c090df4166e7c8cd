# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables for subsurface scattering, and rays that see only one instance."""

from __future__ import annotations

import numpy as np

from ....jit import kernel, table
from ....replaced import replaced_on_gpu
from ....vec import transform_point, transform_vector
from ..geometry import instance_at
from ..ray_origins import clear_self_primitive
from ..rays import NONE, intersect_scene, ray_table
from . import dispatch

# For each instance the Embree scene with only that instance, in world space if it is baked, else in local space; 0:
# there is none.
TABLES = {**dispatch.TABLES, "inner_scenes": np.dtype(np.int64)}
SCALARS = [("has_subsurface", np.int64)]

inner_table = table("inner_scenes", np.int64)


@replaced_on_gpu
@kernel
def intersect_instance(block, workspace, index, o, d, t_min, t_max):
    """As ``rays.intersect``, with instance ``index`` alone and for any ray visibility."""
    instance = instance_at(block, index)
    if instance.baked == 0:
        o, d = transform_point(instance.inverse, o), transform_vector(instance.inverse, d)
    clear_self_primitive(ray_table(workspace)[0])
    found = intersect_scene(block, workspace, inner_table(block)[index], o, d, t_min, t_max, NONE)
    if found:
        ray_table(workspace)[0].geometry = index
    return found
