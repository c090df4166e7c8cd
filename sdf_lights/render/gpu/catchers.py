# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers. On the CPU, a path that has hit one continues once more in a second scene with only the catchers. On
the GPU it continues in the same scene: rays pass through all other objects, which give no light.
``shaders_glsl/film.glsl`` has the conditions.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ..film import Film
from ..kernels.geometry import instance_table
from ..kernels.lights import triangle
from ..kernels.lights.kinds import TRIANGLE
from ..kernels.lights.records import emitter_table
from ..kernels.outputs import code_table, dispatch
from ..kernels.outputs.pack import pack_outputs
from ..kernels.outputs.records import CATCHERS, LIGHT
from ..scene import Scene
from .bvh import CATCHER
from .translate import INT, Value

# Numbers of the block that change while a path is among catchers alone: no medium fills the world there.
CHANGING = {
    "outputs": Value(INT, f"(bare ? 0 : {LIGHT | CATCHERS})", possible=frozenset([0, LIGHT | CATCHERS])),
    "world_medium": Value(INT, "(bare ? -1 : scene.world_medium)"),
}

CODE = {
    place: code_table.KERNELS[place][1]
    for place in (dispatch.CLEAR, dispatch.LIGHT, dispatch.CATCH, dispatch.RELEASE, dispatch.BARE)
}


@kernel
def is_bare(block):
    """Whether the path is among catchers alone; written as GLSL."""
    return False


@kernel
def reaches(block, emitter, bounces):
    """Replaces ``lights.reaches``."""
    row = emitter_table(block)[emitter]
    if is_bare(block) and row.kind == TRIANGLE:
        if not instance_table(block)[triangle.rows(block)[row.index].instance].catcher:
            return False
    return bounces <= row.max_bounces


def pack(scene: Scene, film: Film, emitters: list, instances: np.ndarray) -> tuple[dict, dict]:
    """Tables and scalars needed only by catchers, as in ``outputs.pack.pack_outputs``."""
    tables, scalars = pack_outputs(scene, film, emitters, instances)
    named = ("light_places", "data_places", "emitter_groups", "instance_groups", "emitter_passes")
    return {name: tables[name] for name in named}, {**scalars, "outputs": LIGHT | CATCHERS}


def mask(scene: Scene, index: int, rays: int) -> int:
    """Kinds of rays that see an instance, marked if it is a catcher."""
    return rays | CATCHER if scene.instances[index].catcher else rays


def columns(film: Film) -> int:
    """Number of sums of a sample beside ``film.CHANNELS``; 0 without catchers."""
    return film.light_sums.shape[1] + film.data_sums.shape[1] if film.catches else 0
