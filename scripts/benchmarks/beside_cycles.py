# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene rendered by both engines with their defaults, and references by Cycles, kept in the user's cache."""

from __future__ import annotations

import hashlib
import pathlib
from collections.abc import Iterable

import bpy
import numpy as np

from . import errors, pictures, references, simple_scenes
from .node_pictures import CYCLES, OURS

GUIDED = "guided"  # our engine with its defaults: noisy pixels take more samples, paths split
CLEAR = 0.05  # fraction of the least judged error, below which a reference is good enough
# The defaults of both engines.
LIMITS = dict(max_bounces=12, diffuse_bounces=4, glossy_bounces=4, transmission_bounces=12, volume_bounces=0)
TRANSPARENT = 8
FILTER_GLOSSY = 1.0  # Cycles' default: without it a lake in the sun causes light that few samples of either engine find


def settings(scene, engine: str, samples: int, seed: int, device: str, denoise: bool = False) -> None:
    """``engine`` is CYCLES, OURS or GUIDED; without clamps and noise thresholds."""
    simple_scenes.plain_cycles(scene, samples, LIMITS["max_bounces"])
    simple_scenes.plain_sdf_lights(scene, samples, LIMITS["max_bounces"], device)
    for owner in (scene.cycles, scene.sdf_lights):
        for name, value in LIMITS.items():
            if hasattr(owner, name):
                setattr(owner, name, value)
        owner.seed = seed
    scene.cycles.transparent_max_bounces = scene.sdf_lights.transparent_bounces = TRANSPARENT
    scene.cycles.blur_glossy = scene.sdf_lights.filter_glossy = FILTER_GLOSSY
    scene.cycles.use_denoising = scene.sdf_lights.denoise = denoise
    if denoise:
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    scene.render.engine = CYCLES if engine == CYCLES else OURS
    if engine == GUIDED:
        scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = 0, True


def reference_of(
    name: str, scene, scripts: Iterable[pathlib.Path], samples: int, fresh: bool, device: str
) -> references.Reference:
    """The reference by Cycles, from two renders at least; it depends on the ``scripts`` that build the scene."""
    digest = hashlib.sha256()
    for path in sorted(scripts):
        digest.update(path.read_bytes())
    truth = references.Reference(
        f"{name} {scene.render.resolution_x} {samples} {LIMITS} {FILTER_GLOSSY} {bpy.app.version_string} {digest.hexdigest()}"
    )
    if fresh:
        truth.forget()
    while len(truth.renders) < 2:
        _add(truth, scene, samples, device)
    return truth


def complete(truth: references.Reference, scene, least: float, samples: int, seconds: float, device: str) -> None:
    """Add renders until the reference is good enough for the ``least`` error that it judges, or the ``seconds`` have
    passed."""
    before = truth.seconds
    while truth.seconds - before < seconds and errors.rel_variance(truth.variance, truth.pixels) > CLEAR * least:
        _add(truth, scene, samples, device)


def _add(truth: references.Reference, scene, samples: int, device: str) -> None:
    def render(seed: int) -> tuple[np.ndarray, float]:
        settings(scene, CYCLES, samples, seed % (1 << 31), device)
        picture = pictures.render()
        return picture.pixels, picture.seconds

    truth.add(render)


def error_of(made: list[pictures.Picture], truth: references.Reference) -> float:
    """Mean relative squared error of pictures, minus that of the reference."""
    found = float(np.mean([errors.rel_mse(picture.pixels, truth.pixels) for picture in made]))
    return max(found - errors.rel_variance(truth.variance, truth.pixels), 0.01 * found)
