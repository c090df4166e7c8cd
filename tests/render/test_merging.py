# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges of samples that are joined have no bias, even if each range decides by itself which pixels need samples."""

import dataclasses
import functools

import numpy as np
import pytest
import scipy.stats

from sdf_lights.render import session
from sdf_lights.render.merging import Layer, Share, merge
from support.scenes import torus_room

SIZE, BLOCK = (16, 12), 4
SEEDS, SAMPLES, RANGES = 24, 64, 4
CONFIDENCE = 0.999  # that pictures without bias pass, for all blocks and both cases together
SEEN, SEEN_IN_ALL = 0.02, 0.005  # relative bias, of a block and of the picture, that would be found
ADAPTIVE = {"threshold": dict(noise_threshold=0.1, min_samples=16), "guided": dict(guided_samples=True)}


def picture(seed: int, first: int, count: int, **changes) -> dict[str, np.ndarray]:
    scene = torus_room(*SIZE)
    scene.settings = dataclasses.replace(
        scene.settings, seed=seed, sample_offset=first, samples=count, threads=1, **changes
    )
    film = session.render(scene, ("Sample Count",))
    return {name: film.read(name) for name in ("Combined", "Sample Count")}


def blocks(pictures: list[np.ndarray]) -> np.ndarray:
    """(pictures, 1 + blocks) means over the pixels and channels of the whole and of blocks."""
    shape = len(pictures), SIZE[1] // BLOCK, BLOCK, SIZE[0] // BLOCK, BLOCK, 3
    found = np.array(pictures, float)[..., :3].reshape(shape).mean(axis=(2, 4, 5)).reshape(len(pictures), -1)
    return np.column_stack([found.mean(axis=1), found])


@functools.cache
def even() -> np.ndarray:
    """Blocks of pictures with other seeds, all of whose pixels have all samples."""
    found = [
        picture(1000 + seed, 0, RANGES * SAMPLES, noise_threshold=0.0, guided_samples=False) for seed in range(SEEDS)
    ]
    return blocks([passes["Combined"] for passes in found])


@pytest.mark.slow  # 80 renders
@pytest.mark.parametrize("case", ADAPTIVE)
def test_joined_ranges_of_adaptive_renders_have_no_bias(case):
    joined, counts = [], []
    for seed in range(SEEDS):
        parts = [
            Layer((Share(seed, first, SAMPLES),), picture(seed, first, SAMPLES, **ADAPTIVE[case]))
            for first in range(0, RANGES * SAMPLES, SAMPLES)
        ]
        counts += [part.passes["Sample Count"] for part in parts]
        joined.append(merge(parts)["Combined"])
    assert np.ptp(counts, axis=0).max() > 0.0 and np.ptp(counts[0]) > 0.0  # ranges and pixels differ
    found, expected = blocks(joined), even()
    error = np.sqrt((found.var(axis=0, ddof=1) + expected.var(axis=0, ddof=1)) / SEEDS)
    # Welch's degrees of freedom are at least those of one side.
    alpha = (1.0 - CONFIDENCE) / len(ADAPTIVE) / found.shape[1]
    limit = scipy.stats.t.ppf(1.0 - alpha / 2.0, SEEDS - 1) * error
    difference, mean = found.mean(axis=0) - expected.mean(axis=0), expected.mean(axis=0)
    print(case, "samples", np.mean(counts), "difference", difference / mean, "limit", limit / mean)
    assert (np.abs(difference) < limit).all()
    # The test sees much.
    assert limit[0] < SEEN_IN_ALL * mean[0] and (limit[1:] < SEEN * mean[1:]).all()
