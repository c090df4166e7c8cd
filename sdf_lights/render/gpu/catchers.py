# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers. On the CPU, a path that has hit one continues once more in a second scene with only the catchers. On
the GPU it continues in the same scene: rays pass through all other objects, which give no light.
``shaders_glsl/film.glsl`` has the conditions.
"""

from __future__ import annotations

from ...jit import kernel
from ..kernels.lights import linking
from ..kernels.lights.records import emitter_table
from ..scene import Scene
from .bvh import CATCHER
from .translate import INT, Value


def changing(bits: int) -> dict[str, Value]:
    """Numbers of the block that change while a path is among catchers alone: nothing is added to the passes whose
    ``bits`` of ``outputs`` the film has, and no medium fills the world."""
    return {
        "outputs": Value(INT, f"(bare ? 0 : {bits})", possible=frozenset([0, bits])),
        "world_medium": Value(INT, "(bare ? -1 : scene.world_medium)"),
    }


@kernel
def is_bare(block):
    """Whether the path is among catchers alone; written as GLSL."""
    return False


@kernel
def may_light(block, emitter, bounces):
    """Replaces ``lights.may_light``."""
    row = emitter_table(block)[emitter]
    return bounces <= row.max_bounces and not (is_bare(block) and row.beside_catchers != 0)


@kernel
def is_in_light_tree(block, number, emitter):
    """Replaces ``lights.is_in_light_tree``."""
    if is_bare(block) and emitter_table(block)[emitter].beside_catchers != 0:
        return False
    if number == 0:
        return True
    leaf, endless = linking.place_in(block, number, emitter)
    return leaf >= 0 or endless >= 0


def mask(scene: Scene, index: int, rays: int) -> int:
    """Kinds of rays that see an instance, marked if it is a catcher."""
    return rays | CATCHER if scene.instances[index].catcher else rays
