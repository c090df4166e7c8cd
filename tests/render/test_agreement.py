# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer and the NumPy reference, which share no code, agree within their error bars on every pass.

Each renders a scene with ``SEEDS`` seeds. Means over blocks of pixels and over the whole picture are compared by
Welch's t test; their variances come from the seeds. The threshold makes a scene of two right renderers fail with
probability 1 − ``CONFIDENCE``, over all its channels and blocks together. Seeds are fixed.
"""

import numpy as np
import pytest
from scipy import stats

from sdf_lights import jit
from sdf_lights.render.film import NO_DEPTH, Film
from sdf_lights.render.reference.renderer import ReferenceRenderer
from support import scenes
from support.blocks import means
from support.scenes import media, strands

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SEEDS, CONFIDENCE = 6, 0.9999
SCENES = scenes.SCENES | media.MEDIA_SCENES | strands.STRAND_SCENES
PASSES = ("Combined", "Depth", "Position", "Normal", "Diffuse Color", "Denoising Albedo", "Emission", "SDF Lamps")
# The first surface of a path is left to chance in media: where both find it by other chances, its data differ.
WITH_MEDIA = ("Combined", "SDF Lamps")
# Of the default suite.
QUICK = (
    "torus_room",
    "blender_lights",
    "environment",
    "emissive_mesh",
    "glass",
    "principled_without_caustics",
    "textured",
    "instances",
    "transparent",
    "inside_lamp",
)

# Of a rolling shutter the reference builds the scene anew for each line of each sample. It integrates the volume of
# each shape that a lamp has while the shutter is open, and follows rays through networks in small steps.
COSTLY = ("rolling", "changing_lamps", "network_lamp")
CLOSELY = ("torus_room", "blender_lights", "principled_without_caustics")


def pictures(
    renderer, make, samples: int, passes: tuple[str, ...] = PASSES, size: tuple[int, int] = (32, 24)
) -> dict[str, np.ndarray]:
    """Every pass of the scenes ``make(width, height)``: (seeds, height, width, channels)."""
    found = {item: [] for item in passes}
    for seed in range(SEEDS):
        scene = make(*size)
        scene.settings.seed, scene.settings.threads = 100 + seed, 1
        film = Film(scene, passes)
        back_end = renderer(scene, film, lambda: False, lambda text: None)
        assert back_end.sample(0, samples, lambda: False, lambda part: None)
        back_end.finish()
        assert not film.discarded.any() and not scene.warnings
        for item in passes:
            value = film.read(item).astype(float)
            found[item].append(np.where(value == NO_DEPTH, 0.0, value))
    return {item: np.array(values) for item, values in found.items()}


def compare(name: str, samples: int, passes: tuple[str, ...] = PASSES) -> None:
    from sdf_lights.render.cpu.renderer import CpuRenderer

    size = (16, 12) if name in COSTLY else (32, 24)
    cpu, reference = (
        pictures(renderer, SCENES[name], samples, passes, size) for renderer in (CpuRenderer, ReferenceRenderer)
    )
    agree(cpu, reference, passes)


def agree(cpu: dict[str, np.ndarray], reference: dict[str, np.ndarray], passes: tuple[str, ...]) -> None:
    """Fail if two results of ``pictures`` differ by more than noise."""
    failures = []
    for item in passes:
        rounding = 1e-5 * max(np.abs(reference[item]).max(), 1e-3)  # of float32 rays
        for a, b in zip(means(cpu[item]), means(reference[item])):
            va, vb = (x.var(0, ddof=1) / SEEDS + 0.5 * rounding**2 for x in (a, b))
            t = (a.mean(0) - b.mean(0)) / np.sqrt(va + vb)
            degrees = (va + vb) ** 2 / ((va**2 + vb**2) / (SEEDS - 1))
            # Half of the error allowed goes to the blocks, half to the picture; every pass gets the same.
            level = (1.0 - CONFIDENCE) / (2 * len(passes) * t.size)
            p = 2.0 * stats.t.sf(np.abs(t), degrees)
            if p.min() < level:
                worst = int(p.argmin())
                failures.append(
                    f"{item}: {a.mean(0)[worst]:.5g} against {b.mean(0)[worst]:.5g} (t = {t[worst]:.1f}, "
                    f"{np.count_nonzero(p < level)} of {t.size} means)"
                )
    assert not failures, "; ".join(failures)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in QUICK else pytest.mark.slow)
        for name in scenes.SCENES | strands.STRAND_SCENES
    ],
)
def test_path_tracer_agrees_with_reference(name):
    compare(name, 1 if name in COSTLY else 4)


@pytest.mark.parametrize("name", ["fog_lamp"])
def test_media_agree_with_reference(name):
    compare(name, 4, WITH_MEDIA)


@pytest.mark.slow
@pytest.mark.parametrize("name", media.MEDIA_SCENES)
def test_media_agree_with_reference_closely(name):
    compare(name, 8, WITH_MEDIA)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSELY)
def test_path_tracer_agrees_with_reference_closely(name):
    """With error bars half as wide."""
    compare(name, 16)
