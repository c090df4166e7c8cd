# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flicker of an animation with few samples: the change of pixels from frame to frame beyond the motion itself.

The lamp moves slightly in each frame. The change of a converged render of the same frames is subtracted, so the rest is
noise: with independent seeds, twice the variance of a frame. Noise that stays in place from frame to frame would give
less. Limits are therefore 1: relative to independent frames, plus four standard errors, and relative to another sampler
or engine at as many samples.
"""

from __future__ import annotations

import functools

import numpy as np

from sdf_lights.render.settings import LampSampling
from support.scenes import SCENES, torus_lamp

from . import Figure, case
from .stage import STANDARD_ERRORS, picture, settings

FRAMES, QUICK_FRAMES = 12, 5
STEP = 0.04  # m a frame
SAMPLES = 4
WIDTH, HEIGHT = 48, 36
TRUE_SAMPLES, QUICK_TRUE_SAMPLES = 1024, 256
BOUNCES, MORE_BOUNCES = 1, 4


def frame(index: int, samples: int, seed: int, sampling: LampSampling, bounces: int) -> np.ndarray:
    scene = SCENES["torus_room"](WIDTH, HEIGHT)
    scene.settings = settings(samples, seed, sampling, bounces)
    scene.lamps = [torus_lamp(x=index * STEP)]
    return picture(scene)


@functools.lru_cache(maxsize=4)
def truth(quick: bool, bounces: int) -> np.ndarray:
    """(frames, height, width) of converged renders."""
    # Their noise adds to the flicker, at most 2 %. With more bounces, where samples are expensive, fewer are taken.
    samples = QUICK_TRUE_SAMPLES if quick or bounces > BOUNCES else TRUE_SAMPLES
    return np.array(
        [
            frame(index, samples, 10_000 + index, LampSampling.CUT, bounces)
            for index in range(QUICK_FRAMES if quick else FRAMES)
        ]
    )


def changes(pictures: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(frames − 1,) mean squared change of a frame beyond the change of the truth, relative to the mean light."""
    return np.mean(np.diff(pictures - known, axis=0) ** 2, axis=(1, 2)) / known.mean() ** 2


@functools.lru_cache(maxsize=8)
def flicker(quick: bool, sampling: LampSampling, same_seed: bool, bounces: int) -> tuple[np.ndarray, float]:
    """``changes`` with few samples, and their expected value for independent frames."""
    known = truth(quick, bounces)
    first, second = (
        np.array(
            [
                frame(index, SAMPLES, seed if same_seed else seed + 2 * index, sampling, bounces)
                for index in range(len(known))
            ]
        )
        for seed in (0, 1)
    )
    # Two seeds of the same frame differ by twice its variance, too.
    return changes(first, known), float(np.mean((first - second) ** 2) / known.mean() ** 2)


def _judged(quick: bool, same_seed: bool, bounces: int = BOUNCES) -> Figure:
    found, independent = flicker(quick, LampSampling.CUT, same_seed, bounces)
    error = float(found.std(ddof=1) / np.sqrt(len(found)) / independent)
    return Figure(
        float(found.mean() / independent), 1.0 + STANDARD_ERRORS * error, dict(rms_change=float(np.sqrt(found.mean())))
    )


def _to_the_paper(quick: bool, bounces: int = BOUNCES) -> Figure:
    ours, theirs = (
        flicker(quick, sampling, False, bounces)[0].mean() for sampling in (LampSampling.CUT, LampSampling.MIS)
    )
    return Figure(float(ours / theirs), 1.0)


@case("flicker", slow=True)
def with_new_seeds(quick):
    """mean squared flicker at 4 samples with another seed each frame, to that of independent frames"""
    return _judged(quick, same_seed=False)


@case("flicker-of-one-seed", slow=True)
def with_one_seed(quick):
    """the same with one seed for all frames: noise that stays where it is does not flicker"""
    return _judged(quick, same_seed=True)


@case("flicker-against-the-paper", slow=True)
def against_the_paper(quick):
    """mean squared flicker at 4 samples, to that of the paper's sampler by the same pattern"""
    return _to_the_paper(quick)


@case("flicker-bounces", slow=True)
def with_more_bounces(quick):
    """with four bounces: mean squared flicker at 4 samples, another seed each frame, to that of independent frames"""
    return _judged(quick, same_seed=False, bounces=MORE_BOUNCES)


@case("flicker-bounces-of-one-seed", slow=True)
def with_more_bounces_and_one_seed(quick):
    """with four bounces: the same with one seed for all frames"""
    return _judged(quick, same_seed=True, bounces=MORE_BOUNCES)


@case("flicker-bounces-against-the-paper", slow=True)
def against_the_paper_with_more_bounces(quick):
    """with four bounces: mean squared flicker at 4 samples, to that of the paper's sampler by the same pattern"""
    return _to_the_paper(quick, MORE_BOUNCES)


def _to_cycles(quick: bool, bounces: int) -> Figure:
    # Blender is not there for the other cases.
    import bpy

    from benchmarks import lamp_scenes, pictures, simple_scenes

    lamp_scenes.SCENES["S1"].build(48)
    movers = [
        thing for name in (lamp_scenes.LAMPS, lamp_scenes.VOLUMES) for thing in bpy.data.collections[name].objects
    ]
    scene, start = bpy.context.scene, [thing.matrix_world.copy() for thing in movers]

    def made(index: int, samples: int, seed: int, cycles: bool) -> np.ndarray:
        for thing, matrix in zip(movers, start):
            moved = matrix.copy()
            moved[0][3] += index * STEP
            thing.matrix_world = moved
        lamp_scenes.show(volumes=cycles)
        if cycles:
            simple_scenes.plain_cycles(scene, samples, bounces)
            scene.cycles.seed = seed
        else:
            simple_scenes.plain_sdf_lights(scene, samples, bounces, "CPU")
            scene.sdf_lights.seed = seed
        return pictures.render().pixels.mean(axis=2)

    count = 4 if quick else FRAMES
    known = np.array([made(index, QUICK_TRUE_SAMPLES, 10_000 + index, False) for index in range(count)])
    ours, theirs = (
        changes(np.array([made(index, SAMPLES, index, cycles) for index in range(count)]), known).mean()
        for cycles in (False, True)
    )
    return Figure(float(ours / theirs), 1.0, dict(ours=float(ours), cycles=float(theirs)))


@case("flicker-against-cycles", slow=True, blender=True)
def against_cycles(quick):
    """mean squared flicker at 4 samples, to that of Cycles at as many, whose lamp is a volume"""
    return _to_cycles(quick, BOUNCES)


@case("flicker-bounces-against-cycles", slow=True, blender=True)
def against_cycles_with_more_bounces(quick):
    """with four bounces: the same to that of Cycles"""
    return _to_cycles(quick, MORE_BOUNCES)
