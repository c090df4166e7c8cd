# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions at the previous and the next frame, for the pass Vector. As in Cycles, the motion blur settings of objects
have no effect, and the pass is empty if motion blur is on."""

from __future__ import annotations

import bpy
import numpy as np

from ...render.passes import BY_NAME
from ...render.scene import Camera
from ..passes import is_enabled
from .motion import Key, Motion, Placed, Seen, Wish, is_wanted, same_place

# Since this version Cycles also gives the motion of the background.
_BACKGROUND_MOVES = (5, 1, 0)


def has_vectors(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether the pass Vector is rendered and not empty."""
    return is_enabled(BY_NAME["Vector"], depsgraph.view_layer) and not is_wanted(depsgraph)


class NeighborFrames(Motion):
    """Records surfaces and cameras at both frames, and writes them into a scene."""

    def _wish(self, *owners: bpy.types.Object | None) -> Wish:
        return Wish(1, True)

    def _span(self) -> tuple[float, float]:
        return -1.0, 2.0

    def _give(
        self, placed: dict[Key, Placed], wishes: dict[Key, Wish], deforms: set[int], seen: list[Seen], steps: int
    ) -> bool:
        for key, place in placed.items():
            if place.instance < 0 or any(key not in each.places for each in seen):
                continue  # it appears or disappears
            instance, found = self._scene.instances[place.instance], [each.places[key] for each in seen]
            if any(not np.array_equal(matrix, instance.matrix) for matrix in found):
                instance.around = np.stack(found)
            if instance.mesh in deforms and all(instance.mesh in each.forms for each in seen):
                mesh = self._scene.meshes[instance.mesh]
                mesh.shifts = np.stack([each.forms[instance.mesh].positions - mesh.positions for each in seen])
        return True

    def _give_camera(self, view: Camera, seen: list[Camera]) -> bool:
        if any(not same_place(at, view) for at in seen):
            view.around = tuple(seen)
        return True

    def _finish(self) -> None:
        self._scene.background_moves = bpy.app.version >= _BACKGROUND_MOVES
