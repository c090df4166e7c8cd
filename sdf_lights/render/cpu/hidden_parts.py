# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the parts of lamps that hardly any surface of a scene sees: see ``emitter.sampling.hidden``."""

from __future__ import annotations

import numpy as np

from ...emitter.sampling import hidden
from ..kernels.hidden_parts import look_at_parts
from ..kernels.light_paths.places import AWAY, find_places
from ..scene import Scene
from ..settings import LampSampling
from .block import PackedScene, Workspace

RAYS = 512  # of the camera, to find places
HITS = 2
POINTS, FEWEST_POINTS = 2048, 512  # of a lamp
MOST_POINTS = 8192  # of all lamps: 10 ms
LOOKS = 4  # at each point


def find_hidden_parts(scene: Scene, packed: PackedScene, workspace: Workspace) -> list[np.ndarray | None]:
    """Sums of ``hidden.sums_of`` of each lamp; None where nothing is hidden, and where it is not known: in moving
    scenes, without cuts, and where there are many lamps."""
    count = len(packed.lamps)
    found: list[np.ndarray | None] = [None] * count
    if not count or packed.moves or scene.settings.lamp_sampling is not LampSampling.CUT:
        return found
    points = min(POINTS, MOST_POINTS // count)
    if points < FEWEST_POINTS:
        return found
    places = np.zeros((RAYS * HITS, 3))
    places = places[: find_places(workspace.scene, workspace.block, scene.width, scene.height, HITS, AWAY, places)]
    if not len(places):
        return found
    for lamp in range(count):
        looks = np.zeros((hidden.CELLS, 2), np.int64)
        look_at_parts(workspace.scene, workspace.block, lamp, points, LOOKS, places, looks)
        found[lamp] = hidden.sums_of(looks)
    return found
