# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that a render engine keeps from one frame to the next, if Blender's *Persistent Data* is on.

Blender then keeps the engine and its dependency graph. Its updates name everything that was evaluated again since the
last render. All other meshes and hair are unchanged, at the same address. Pixels of files are identified by the content
of the file.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import NamedTuple

import bpy
import numpy as np

from ...render.scene import Mesh


class Entry(NamedTuple):
    """A mesh, and its reader's data. ``owners``: addresses of the objects and data that it was made of."""

    mesh: Mesh
    known: object
    owners: frozenset[int]


class Kept:
    """The kept data. ``back_end`` belongs to the renderer (``Scene.kept``)."""

    def __init__(self) -> None:
        self.back_end: dict = {}
        self._meshes: dict[Hashable, Entry] = {}
        self._pixels: dict[Hashable, np.ndarray] = {}
        self._ages: dict[tuple[str, Hashable], int] = {}

    def begin(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Drop everything that has changed since the last render, and everything that no view layer used for one
        frame."""
        changed = {update.id.original.as_pointer() for update in depsgraph.updates if update.is_updated_geometry}
        self._meshes = {key: entry for key, entry in self._meshes.items() if not entry.owners & changed}
        oldest = len(depsgraph.scene.view_layers)
        self._ages = {key: age + 1 for key, age in self._ages.items() if age < oldest}
        self._meshes = {key: entry for key, entry in self._meshes.items() if ("mesh", key) in self._ages}
        self._pixels = {key: pixels for key, pixels in self._pixels.items() if ("pixels", key) in self._ages}

    def mesh(self, key: Hashable, owners: frozenset[int]) -> Entry | None:
        """An unchanged mesh, without its motion. Another mesh, with other ``owners``, may be at its address by now."""
        entry = self._meshes.get(key)
        if entry is None or entry.owners != owners:
            return None
        self._ages["mesh", key] = 0
        still = replace(entry.mesh, motion=None, motion_normals=None, motion_radii=None, shifts=None)
        return entry._replace(mesh=still)

    def keep_mesh(self, key: Hashable, entry: Entry) -> None:
        """Keep a mesh until one of its owners changes."""
        self._meshes[key], self._ages["mesh", key] = entry, 0

    def pixels(self, path: str, data: bytes | None, form: Hashable, read: Callable[[], np.ndarray]) -> np.ndarray:
        """Pixels (height, width, channels) of a file, or of its packed
        ``data``, in a form: the kept ones, or the result of ``read``."""
        if data is None:
            about = os.stat(path)
            key: Hashable = (path, about.st_mtime_ns, about.st_size, form)
        else:
            key = (hashlib.blake2b(data).digest(), form)
        if key not in self._pixels:
            self._pixels[key] = read()
        self._ages["pixels", key] = 0
        return self._pixels[key]


def owners_of(item: bpy.types.DepsgraphObjectInstance) -> frozenset[int]:
    """Addresses of everything that determines the data of an instance."""
    objects = [item.object, item.parent] if item.is_instance and item.parent is not None else [item.object]
    found = {obj.original.as_pointer() for obj in objects}
    return frozenset(found | {obj.original.data.as_pointer() for obj in objects if obj.original.data is not None})
