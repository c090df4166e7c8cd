# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths that the CPU traces for the GPU. That takes little time beside the samples that are connected with them.

A pilot on the CPU decides whether they pay, before the GPU compiles anything. So there is one program, and a seed gives
the same choice on all machines.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from .cpu.light_paths import LightPaths
from .cpu.pilot import pilot_pixels
from .cpu.renderer import CpuRenderer
from .errors import RenderError
from .film import Film
from .scene import Scene
from .settings import CausticPaths, LampPaths, PathReuse

LASTING = "light_path_materials", "light_path_sources"
OF_SET = "light_path_nodes", "light_path_tops", "light_path_vertices"
SCALARS = "light_path_follows", "light_path_all", "light_path_roulette", "light_path_first_node"


class LightPathsByCpu:
    """The light paths that a renderer of the CPU has found for a scene: see ``interfaces.LightPathTracer``."""

    def __init__(self, renderer: CpuRenderer, light_paths: LightPaths):
        self._renderer, self._light_paths = renderer, light_paths
        light_paths.rest()
        self.tables = {name: renderer.packed.table(name) for name in LASTING}
        self.scalars = {name: renderer.packed.block[name][0].item() for name in SCALARS}

    def use(self, sample: int) -> tuple[int, dict[str, np.ndarray]]:
        """See ``interfaces.LightPathTracer``."""
        end = self._light_paths.use(sample)
        return end, {name: self._renderer.packed.table(name) for name in OF_SET}

    def finish(self) -> None:
        """See ``interfaces.LightPathTracer``."""
        self._renderer.finish()


def traced_by_cpu(
    scene: Scene, film: Film, cancelled: Callable[[], bool], say: Callable[[str], None]
) -> LightPathsByCpu | None:
    """The light paths of a scene, for paths into ``film`` that do not split; None if it has none, or if they are not
    worth it. The film has no samples yet, and gets none. ``cancelled`` and ``say`` are as in ``interfaces.BackEnd``.
    """
    if not _are_tried(scene, film):
        return None
    settings = dataclasses.replace(scene.settings, path_reuse=PathReuse.NEVER, caustic_paths=CausticPaths.NEVER)
    own = dataclasses.replace(scene, settings=settings, warnings=[])
    try:
        renderer = CpuRenderer(own, film, cancelled, say)
        found = renderer.light_paths_of_whole_paths(cancelled) if renderer.ready else None
    except RenderError as error:
        scene.warnings.append(f"The GPU renders without paths from lamps: {error}")
        return None
    if found is None:
        renderer.finish()
        return None
    return LightPathsByCpu(renderer, found)


def _are_tried(scene: Scene, film: Film) -> bool:
    """Whether it takes the CPU's tables of a scene to know more."""
    settings = scene.settings
    return (
        settings.lamp_paths is not LampPaths.NEVER
        and settings.max_bounces > 0
        and scene.shutter is None
        and (settings.lamp_paths is LampPaths.ALWAYS or pilot_pixels(film, settings.samples) is not None)
    )
