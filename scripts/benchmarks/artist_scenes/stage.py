# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What scenes share: the register, and how one is opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import host

ASPECT = 9 / 16  # height of pictures relative to their width


@dataclass(frozen=True)
class ArtistScene:
    name: str
    about: str
    build: Callable[[bpy.types.Scene], None]


SCENES: dict[str, ArtistScene] = {}


def scene(about: str):
    """Register a function that fills an empty scene, under its own name."""

    def register(build):
        SCENES[build.__name__] = ArtistScene(build.__name__, about, build)
        return build

    return register


def build(name: str, width: int) -> bpy.types.Scene:
    """Open a new file with the scene of that name; a picture of so many pixels across."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    opened = bpy.context.scene
    opened.render.resolution_x, opened.render.resolution_y = width, round(width * ASPECT)
    opened.render.resolution_percentage = 100
    opened.render.use_compositing = opened.render.use_sequencer = False
    SCENES[name].build(opened)
    bpy.context.view_layer.update()
    return opened
