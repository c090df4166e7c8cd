# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Other methods for the scenes of ``indirect``: Cycles and the paper's sampler, by error × time over ours.

A rival takes as many samples as fit into the time of our render, with all that comes before the first sample. No
reference is needed: the error is the variance of renders with different seeds, relative as in ``errors.rel_mse``.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import demo_scene
import host
import numpy as np

from support.rivals import samplers

from . import artist_scenes, beside_cycles, errors, lamp_scenes, methods, pictures, simple_scenes

INTERIORS = ("living_room_day", "living_room_night", "kitchen", "neon_bar", "demo_points")
MOST_SAMPLES = 4096
FEW, MORE = 1, 5  # samples of the renders that tell the time of a sample


@dataclass(frozen=True)
class Rival:
    """``render(samples, seed)`` renders the open scene."""

    render: Callable[[int, int], pictures.Picture]

    def pictures(self, seconds: float, seeds: int) -> list[pictures.Picture]:
        """With as many samples as fit into the processor time."""
        self.render(FEW, 0)  # compiles, and fills caches
        few, more = (self.render(samples, 0).work for samples in (FEW, MORE))
        each = max((more - few) / (MORE - FEW), 1e-4)
        samples = min(max(round(FEW + (seconds - few) / each), 1), MOST_SAMPLES)
        return [self.render(samples, seed) for seed in range(seeds)]


def by_cycles(bounces: int, surfaces: bool = False, guiding: bool = False, denoise: bool = False) -> Rival:
    """Cycles, whose lamps are volumes; or meshes that emit, for its light tree, with path guiding or without. Its
    pictures are denoised or not."""

    def render(samples: int, seed: int) -> pictures.Picture:
        scene = bpy.context.scene
        lamp_scenes.show(volumes=not surfaces, surfaces=surfaces)
        simple_scenes.plain_cycles(scene, samples, bounces)
        scene.cycles.seed, scene.cycles.use_light_tree = seed, True
        scene.cycles.use_guiding, scene.cycles.use_denoising = guiding, denoise
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
        try:
            return pictures.render()
        finally:
            lamp_scenes.show()

    return Rival(render)


def by_paper(bounces: int, device: str) -> Rival:
    """Our engine with the paper's sampler of lamps: paths split and samples are allocated as with ours. The paper has
    neither light paths nor path reuse."""

    def render(samples: int, seed: int) -> pictures.Picture:
        scene = bpy.context.scene
        simple_scenes.plain_sdf_lights(scene, samples, bounces, device)
        settings = scene.sdf_lights
        settings.seed, settings.indirect_paths, settings.guided_samples = seed, 0, True
        settings.lamp_sampling = samplers.register(methods.PAPER, host.program().__name__).value
        settings.lamp_paths = settings.path_reuse = settings.caustic_paths = "NEVER"
        try:
            return pictures.render()
        finally:
            settings.lamp_sampling = "CUT"

    return Rival(render)


def by_cycles_defaults(device: str) -> Rival:
    """Cycles with its own defaults."""

    def render(samples: int, seed: int) -> pictures.Picture:
        beside_cycles.settings(bpy.context.scene, beside_cycles.CYCLES, samples, seed, device)
        return pictures.render()

    return Rival(render)


def build_interior(name: str, size: int) -> bpy.types.Scene:
    """A room without SDF lamps; "demo_points" is the room of the demo, whose lamps are point lights of the same
    power."""
    if name != "demo_points":
        return artist_scenes.build(name, size)
    host.register_extension()
    demo_scene.build()
    scene = bpy.context.scene
    for light in bpy.data.lights:
        light.sdf_lamp.use, light.shadow_soft_size = False, 0.05
    scene.render.resolution_x, scene.render.resolution_y = size, size * 9 // 16
    scene.render.resolution_percentage = 100
    scene.camera.data.dof.use_dof = False
    return scene


def cost(made: list[pictures.Picture]) -> float:
    """Error × time: the variance of pictures of several seeds, relative to their mean, times the median of their
    times."""
    stack = np.array([picture.pixels for picture in made])
    variance = stack.var(axis=0, ddof=1)
    return errors.rel_variance(variance, stack.mean(axis=0)) * statistics.median(picture.work for picture in made)


def ratio(rival: Rival, ours: list[pictures.Picture], seeds: int) -> float:
    """Error × time of a rival over that of ``ours``."""
    return cost(rival.pictures(statistics.median(picture.work for picture in ours), seeds)) / cost(ours)
