# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates hours of a user's work, at random, by a seed: edits, undos, renders, cancels; and measures the resources of
the process.

Only Linux reports memory and handles as they are read here.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import pathlib
import random

import bpy
import numpy as np

from sdf_lights.blender.sync import sync
from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.emitter.sampling.cut_tables import uniform_cells
from sdf_lights.emitter.tree.interior import KEPT
from sdf_lights.render import session
from sdf_lights.render.settings import Device
from sdf_lights.sdf.expression import evaluate

CLEAN_ALL_BUFFERS = 0  # of tbb/scalable_allocator.h

# Blender with a window may allocate with Intel's allocator, which keeps freed memory as long as its neighbours are in
# use. These environment variables make it use the C library, which reports the memory that the program itself holds; in
# one arena, as freed memory between that of other threads stays resident.
C_LIBRARY = {"LD_PRELOAD": "libc.so.6", "MALLOC_ARENA_MAX": "1"}

SHAPES = ["SPHERE", "TORUS", "BOX", "CAPSULE", "CONE"]
EXPRESSIONS = [
    "sphere({0}) | box(0.3)",
    "field(length(p) - {0}) & box(1)",
    "sphere({0}",  # an error
    "torus(0.4, 0.1)",
]


def memory() -> int:
    """Present resident bytes of this process, without freed memory."""
    gc.collect()
    # These allocators keep freed memory, and can release it on request. Blender with a window has the second.
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL("libtbbmalloc.so.2").scalable_allocation_command(CLEAN_ALL_BUFFERS, None)
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def handles() -> int:
    """Files, sockets and the like that are open."""
    return len(os.listdir("/proc/self/fd"))


def fill_caches() -> None:
    """Fill the caches of shapes and of the data that builds lamps: this memory is kept on purpose."""
    for number in range(KEPT // 2 + 1):
        for text in EXPRESSIONS[:2]:
            shape = evaluate(text.format(round(0.2 + 0.8 * number / KEPT, 5)))
            build_lamp("Kept", shape, np.eye(4))
            uniform_cells(shape)


class Actor:
    """A worker on a scene. ``step`` does one of ``kinds``, and counts it; it returns seconds to wait, in turn, for
    steps that take time by themselves."""

    def __init__(self, scene: bpy.types.Scene, seed: int):
        self.scene, self.random, self.made = scene, random.Random(seed), 0
        self.counts: dict[str, int] = {}
        self.kinds = [self.edit, self.edit, self.write, self.add, self.remove, self.undo, self.render, self.give_up]

    def lamps(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.data.objects if obj.type == "LIGHT" and obj.data.sdf_lamp.use]

    def step(self):
        act = self.random.choice(self.kinds)
        waits = act()
        self.counts[act.__name__] = self.counts.get(act.__name__, 0) + 1
        yield from waits or ()
        self.push(act.__name__)

    def push(self, name: str) -> None:
        """A step that can be undone."""
        bpy.ops.ed.undo_push(message=name)

    def edit(self) -> None:
        for obj in self.lamps()[:1]:
            lamp = obj.data.sdf_lamp
            lamp.source = "PRIMITIVE"
            lamp.shape = self.random.choice(SHAPES)
            obj.data.energy = self.random.uniform(1.0, 200.0)
            obj.location.x = self.random.uniform(-1.0, 1.0)

    def write(self) -> None:
        """An expression of a random kind, with a different number each time."""
        for obj in self.lamps()[-1:]:
            number = round(self.random.uniform(0.2, 0.6), 3)
            obj.data.sdf_lamp.source = "EXPRESSION"
            obj.data.sdf_lamp.expression = self.random.choice(EXPRESSIONS).format(number)

    def add(self) -> None:
        if len(self.lamps()) < 4:
            self.made += 1
            data = bpy.data.lights.new(f"Lamp {self.made}", "POINT")
            data.sdf_lamp.use = True
            self.scene.collection.objects.link(bpy.data.objects.new(data.name, data))

    def remove(self) -> None:
        if len(self.lamps()) > 1:
            bpy.data.lights.remove(self.lamps()[-1].data)

    def undo(self) -> None:
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()
            self.scene = bpy.context.scene

    def render(self) -> None:
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", self.random.choice([1, 2])
        bpy.ops.render.render()

    def read(self):
        """The scene, as for a render."""
        found = sync(bpy.context.evaluated_depsgraph_get())
        found.settings.device = Device(self.scene.sdf_lights.device)
        return found

    def give_up(self) -> None:
        """A render that is cancelled at one of its first checks for a cancel."""
        asked = iter(range(self.random.randrange(6)))
        session.render(self.read(), (), lambda: next(asked, None) is None)
