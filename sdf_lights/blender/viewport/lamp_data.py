# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps of a dependency graph as plain data, which stays valid when Blender frees or moves its own."""

from __future__ import annotations

from typing import NamedTuple

import bpy

from ...render.errors import RenderError
from ...render.scene import Lamp, Ray
from ..sync.common import is_finite, matrix_of
from ..sync.lights import light_of


class Placed(NamedTuple):
    """A lamp and its transform. ``owner``: name of the object that is selected for it; for an instance, its instancer.
    ``light``: name of its Light. ``key`` identifies it from one redraw to the next. ``problem``: why it has its last
    good shape instead of the present one; empty if it has the present one."""

    lamp: Lamp
    owner: str
    light: str
    key: str
    problem: str = ""


class Collected(NamedTuple):
    """``errors``: sentences about unusable lamps, by the name of their Light."""

    lamps: list[Placed]
    errors: dict[str, str]


def collect(depsgraph: bpy.types.Depsgraph) -> Collected:
    """Every lamp, including instances, with its transform in the world.
    Raises RenderError with a sentence that names the lamp."""
    found = Collected([], {})
    for item in depsgraph.object_instances:
        # Nothing may refer to `item` after this iteration: Blender reuses it for the next instance.
        obj = item.object
        if obj.type != "LIGHT" or not item.show_self or not obj.data.sdf_lamp.use:
            continue
        light = obj.data.original.name_full
        matrix, problems = matrix_of(item.matrix_world), []
        try:
            if not is_finite(matrix):
                raise RenderError(
                    f"Lamp '{obj.name}' has a transform that is not finite: clear its location, rotation and scale."
                )
            own = matrix_of(obj.original.evaluated_get(depsgraph).matrix_world)
            lamp = light_of(obj, matrix, Ray.ALL, depsgraph, problems.append, None, own)
        except RenderError as error:
            found.errors[light] = str(error)
            continue
        owner = item.parent if item.is_instance and item.parent is not None else obj
        owner = owner.original.name_full
        key = f"{owner}/{obj.original.name_full}/{tuple(item.persistent_id) if item.is_instance else ''}"
        if problems:
            found.errors[light] = problems[0]
        found.lamps.append(Placed(lamp, owner, light, key, "".join(problems)))
    return found
