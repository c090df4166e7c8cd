# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Converged pictures with a known error, made of independent renders that are kept between runs.

A reference is the mean of renders by one estimator with different seeds; their differences give its own error. Each is
a file in the user's cache, so an interrupted run continues where it stopped, and a later one can add to it. Files are
named by a hash of the data that Blender passes to the engine and of the extension's version. A reference that is
outdated for another reason shows, because the mean of every judged picture is compared with it, too.
"""

from __future__ import annotations

import hashlib
import os
import pathlib
from collections.abc import Callable

import bpy
import numpy as np

FIRST_SEED = 1_000_000  # in addition to those of the judged pictures


def folder() -> pathlib.Path:
    """``$SDF_LIGHTS_REFERENCES``, or a folder in the user's cache."""
    given = os.environ.get("SDF_LIGHTS_REFERENCES")
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or pathlib.Path.home() / ".cache"
    path = pathlib.Path(given) if given else pathlib.Path(base) / "sdf-lights" / "references"
    path.mkdir(parents=True, exist_ok=True)
    return path


class Reference:
    """Mean of renders of one scene; ``key`` contains everything that they depend on."""

    def __init__(self, key: str):
        self._path = folder() / (hashlib.sha256(key.encode()).hexdigest()[:24] + ".npz")
        self.forget()
        if self._path.is_file():
            with np.load(self._path) as file:
                for pixels, seconds in zip(file["renders"].astype(float), file["seconds"]):
                    self._note(pixels, float(seconds))

    def forget(self) -> None:
        """Begin again; the files stay until the first render is added."""
        self.renders: list[np.ndarray] = []
        self._times: list[float] = []
        self._mean = self._squares = 0.0

    def _note(self, pixels: np.ndarray, seconds: float) -> None:
        """Add a render to the mean and the sum of squares about it: there may be hundreds."""
        self.renders.append(pixels)
        self._times.append(seconds)
        change = pixels - self._mean
        self._mean = self._mean + change / len(self.renders)
        self._squares = self._squares + change * (pixels - self._mean)

    def add(self, render: Callable[[int], tuple[np.ndarray, float]]) -> None:
        """One more render, by a function of the seed that also returns its time in seconds; saved at once."""
        self._note(*render(FIRST_SEED + len(self.renders)))
        part = self._path.with_suffix(".part.npz")
        # Compression hardly reduces noise.
        np.savez(part, renders=np.array(self.renders, np.float32), seconds=np.array(self._times))
        os.replace(part, self._path)

    @property
    def seconds(self) -> float:
        """Total time of all renders."""
        return sum(self._times)

    @property
    def pixels(self) -> np.ndarray:
        return self._mean

    @property
    def variance(self) -> np.ndarray:
        """Variance of each of the ``pixels``."""
        count = len(self.renders)
        return self._squares / (count - 1) / count if count > 1 else np.full(self.renders[0].shape, np.inf)


def fingerprint() -> str:
    """Hash of the open scene: meshes, lamps, materials, camera and picture size."""
    digest = hashlib.sha256()

    def note(*values) -> None:
        digest.update(repr(values).encode())

    scene = bpy.context.scene
    note(scene.render.resolution_x, scene.render.resolution_y)
    for thing in sorted(scene.objects, key=lambda thing: thing.name):
        note(thing.name, thing.type, [round(value, 9) for row in thing.matrix_world for value in row])
        if thing.type == "MESH":
            positions = np.empty(3 * len(thing.data.vertices), np.float32)
            thing.data.vertices.foreach_get("co", positions)
            digest.update(positions.tobytes())
            for slot in thing.material_slots:
                for node in slot.material.node_tree.nodes:
                    note(node.bl_idname, getattr(node, "distribution", ""))
                    for socket in node.inputs:
                        value = getattr(socket, "default_value", None)
                        note(socket.is_linked, tuple(value) if hasattr(value, "__len__") else value)
        elif thing.type == "LIGHT":
            lamp = thing.data.sdf_lamp
            note(lamp.expression, lamp.emission.source, lamp.density, tuple(thing.data.color))
        elif thing.type == "CAMERA":
            note(thing.data.angle, thing.data.clip_start, thing.data.clip_end)
    return digest.hexdigest()
