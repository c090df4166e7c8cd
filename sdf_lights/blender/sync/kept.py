# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render engine keeps from one frame to the next, where Blender's *Persistent Data* is on.

Blender then keeps the engine and its dependency graph, whose updates name everything that was evaluated anew since the last
render: meshes and hair of all else are what they were, at the same address. Pixels of files are known by what is in the file.
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
    """A mesh, and what its reader knows of it. ``owners``: addresses of the objects and data that it was made of."""

    mesh: Mesh
    known: object
    owners: frozenset[int]


class Kept:
    """What is kept; ``back_end`` belongs to who renders (``Scene.kept``)."""

    def __init__(self) -> None:
        self.back_end: dict = {}
        self._meshes: dict[Hashable, Entry] = {}
        self._pixels: dict[Hashable, np.ndarray] = {}
        self._ages: dict[tuple[str, Hashable], int] = {}

    def begin(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Forget what has changed since the last render, and what no view layer has used for one frame."""
        changed = {update.id.original.as_pointer() for update in depsgraph.updates if update.is_updated_geometry}
        self._meshes = {key: entry for key, entry in self._meshes.items() if not entry.owners & changed}
        oldest = len(depsgraph.scene.view_layers)
        self._ages = {key: age + 1 for key, age in self._ages.items() if age < oldest}
        self._meshes = {key: entry for key, entry in self._meshes.items() if ("mesh", key) in self._ages}
        self._pixels = {key: pixels for key, pixels in self._pixels.items() if ("pixels", key) in self._ages}

    def mesh(self, key: Hashable, owners: frozenset[int]) -> Entry | None:
        """A mesh that is as it was, without its motion. What is at its address may be another one by now, of other
        ``owners``."""
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
        """Pixels of a file, or of the ``data`` that are packed in its place, in a form: those that are kept, or what ``read``
        gives."""
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
    """Addresses of all that decides what the data of an instance are."""
    objects = [item.object, item.parent] if item.is_instance and item.parent is not None else [item.object]
    found = {obj.original.as_pointer() for obj in objects}
    return frozenset(found | {obj.original.data.as_pointer() for obj in objects if obj.original.data is not None})
