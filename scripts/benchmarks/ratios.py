# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Efficiency as ratios to something measured in the same process: greater is better.

Numbers are the same on every run, unless a ratio is ``timed``.
"""

from __future__ import annotations

import functools
import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sdf_lights.render.settings import LampSampling
from support.rivals import baselines
from support.rivals.baselines import DIMENSIONS, EVEN, LampBlock, Technique

from . import estimators

SAMPLES = 1 << 15  # of a variance and of a time: shorter ones depend on earlier work
TURNS = 11  # how often a time is taken
CLEAR = 1000.0  # minimum of both: variances near zero say little
RAYS = 1000
PAIRS = 4  # of renders with different seeds, whose difference tells their error


@dataclass(frozen=True)
class Ratio:
    """``quick``: it is part of the quick check."""

    measure: Callable[[], float]
    timed: bool = False
    quick: bool = True


RATIOS: dict[str, Ratio] = {}


# --- samplers at points -----------------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=4)
def _block(name: str) -> tuple[LampBlock, tuple, np.ndarray]:
    """A lamp of ``estimators.CASES``, the point that it lights, and the normal there."""
    _, _, shape, x, n, emission = next(case for case in estimators.CASES if case[0] == name)
    return LampBlock(shape, np.eye(4), emission=emission), x, np.asarray(n) / np.linalg.norm(n)


def _values(name: str, technique: Technique, count: int) -> tuple[np.ndarray, float]:
    block, x, n = _block(name)
    numbers = np.random.default_rng(2).random((count, DIMENSIONS))
    return baselines.values(technique, block.blocks, 0, x, n, numbers, EVEN)


def variance_ratio(name: str) -> float:
    """Variance of a sample by the paper's sampler over that of ours."""
    theirs, ours = (float(np.var(_values(name, technique, SAMPLES)[0])) for technique in (Technique.MIS, Technique.CUT))
    return min(theirs / max(ours, 1e-300), CLEAR)


def efficiency_ratio(name: str) -> float:
    """The same for variance times processor time."""
    times = {technique: [] for technique in (Technique.MIS, Technique.CUT)}
    for _ in range(TURNS):
        for technique, spent in times.items():
            spent.append(_values(name, technique, SAMPLES)[1])
    return variance_ratio(name) * statistics.median(times[Technique.MIS]) / statistics.median(times[Technique.CUT])


_QUICK = {
    "torus, above",
    "torus, inside",
    "torus, above, shell",
    "torus, 0.25 above",
    "frame, above",
    "frame, 0.1 from a bar",
    "shell, above",
    "blob, near",
    "Menger sponge, above",
}
for _name, *_ in estimators.CASES:
    _key = _name.replace(",", "").replace(" ", "_").replace("=", "").lower()
    RATIOS[f"variance_{_key}"] = Ratio(functools.partial(variance_ratio, _name), quick=_name in _QUICK)
    if _name in _QUICK:
        RATIOS[f"efficiency_{_key}"] = Ratio(functools.partial(efficiency_ratio, _name), timed=True)


# --- the search for crossings -----------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=64)
def _evaluations(name: str) -> dict[str, float]:
    """Evaluations of the field on a ray of a hard case, or of one of the simplest shapes of data, by each rule."""
    from sdf_lights.emitter.intersection.cover import RESOLUTION
    from sdf_lights.sdf.data.simplest import simplest
    from support import grids
    from support.lamps import oracle
    from support.lamps.hard_cases import HARD_CASES
    from support.lamps.rays import Traced
    from support.rivals import marching

    if name in OF_DATA:
        shape = simplest()[OF_DATA.index(name)]
        origins, toward = grids.rays_around(shape, RAYS, 5)
    else:
        shape = HARD_CASES[name].shape
        origins, toward = HARD_CASES[name].rays(shape, np.random.default_rng(5), RAYS)
    traced = Traced(shape)
    found = dict(ours=traced.trace(origins, toward)[:, 3].mean())
    for label, rule in (("published", marching.PUBLISHED), ("spheres", marching.SPHERES)):
        found[label] = traced.march(rule, origins, toward, RESOLUTION, oracle.steepness(shape))[:, 2].mean()
    return found


SMOOTH = (
    "smooth combination",
    "smooth combination, grazing",
    "smooth combination, from inside",
    "smooth combination, from far away",
    "torus, stretched and twisted",
    "smooth combination of 10",
)


# as ``simplest`` has them; a ray through a grid looks into cells instead
OF_DATA = ("outline", "tube", "grid", "network")


def evaluations_ratio(rule: str, names: tuple[str, ...] = SMOOTH) -> float:
    """Evaluations by another rule over ours, the geometric mean over fields."""
    return math.exp(statistics.fmean(math.log(found[rule] / found["ours"]) for found in map(_evaluations, names)))


def evaluations_by_parts() -> float:
    """Evaluations on a ray through 10 parts, relative to those through 200."""
    return _evaluations("smooth combination of 10")["ours"] / _evaluations("smooth combination of 200")["ours"]


RATIOS["evaluations_published"] = Ratio(functools.partial(evaluations_ratio, "published"))
RATIOS["evaluations_spheres"] = Ratio(functools.partial(evaluations_ratio, "spheres"))
RATIOS["evaluations_of_10_to_200_parts"] = Ratio(evaluations_by_parts)
RATIOS |= {f"evaluations_{name}": Ratio(functools.partial(evaluations_ratio, "spheres", (name,))) for name in OF_DATA}


# --- whole renders ----------------------------------------------------------------------------------------------------


def _noise(name: str, sampling: LampSampling, bounces: int) -> float:
    """Mean absolute error of pixels of 16 samples, relative: a few bright ones do not dominate it, so it is
    reproducible."""
    from support.scenes import SCENES

    from .hard_cases.stage import picture, settings

    total = []
    for pair in range(PAIRS):
        made = []
        for seed in (2 * pair, 2 * pair + 1):
            scene = SCENES[name](32, 24)
            scene.settings = settings(16, seed, sampling, bounces)
            made.append(picture(scene))
        total.append(np.mean(np.abs(made[0] - made[1]) / (made[0] + made[1] + 0.01 * made[0].mean())))
    return float(np.mean(total))


def picture_ratio(name: str, bounces: int) -> float:
    """Square of the error of a picture by the paper's sampler over that by ours, at equal samples."""
    theirs, ours = (_noise(name, sampling, bounces) for sampling in (LampSampling.MIS, LampSampling.CUT))
    return (theirs / ours) ** 2


for _name, _bounces, _quick in (
    ("torus_room", 0, True),
    ("torus_room", 2, False),
    ("frame_lamp", 0, True),
    ("inside_lamp", 0, True),
    ("varying_lamps", 0, True),
    ("field_lamps", 0, True),
    ("glossy_metal", 1, True),
    ("panorama", 2, False),
):
    RATIOS[f"picture_{_name}_{_bounces}_bounces"] = Ratio(
        functools.partial(picture_ratio, _name, _bounces), quick=_quick
    )


def samples_ratio(bounces: int) -> float:
    """Samples per second of processor time over those of Cycles, with one point light; medians of renders that take
    turns."""
    from . import pictures, simple_scenes

    scene = simple_scenes.boxes_and_sphere(96)
    simple_scenes.add_point_light()
    few, many = 4, 68
    spent = {(cycles, samples): [] for cycles in (False, True) for samples in (few, many)}
    for turn in range(6):
        for (cycles, samples), times in spent.items():
            if cycles:
                simple_scenes.plain_cycles(scene, samples, bounces)
            else:
                simple_scenes.plain_sdf_lights(scene, samples, bounces, "CPU")
            made = pictures.render()
            if turn:  # the first compiles
                times.append(made.work)
    ours, theirs = (
        statistics.median(long - short for short, long in zip(spent[cycles, few], spent[cycles, many]))
        for cycles in (False, True)
    )
    return theirs / ours


RATIOS["samples_to_cycles_direct"] = Ratio(functools.partial(samples_ratio, 0), timed=True)
RATIOS["samples_to_cycles_4_bounces"] = Ratio(functools.partial(samples_ratio, 4), timed=True, quick=False)
