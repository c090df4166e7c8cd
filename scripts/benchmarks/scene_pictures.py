# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene of ``artist_scenes`` by both engines in turns: the difference of their means, and their errors at equal
time.

Times are processor times of all threads. Ours takes as many samples as fit into the time of a render of Cycles, without
the time before the first sample, which ``scene_costs`` measures separately. Denoised pictures are judged in the same
way.
"""

from __future__ import annotations

import argparse
import pathlib
import statistics

import contact_sheet
import host
import numpy as np

from . import artist_scenes, errors, pictures, references
from .beside_cycles import GUIDED, complete, error_of, reference_of, settings
from .node_pictures import CYCLES

ENGINES = (CYCLES, GUIDED)
WIDTH, QUICK_WIDTH = 240, 96
FEW, MANY, QUICK_MANY = 4, 64, 16  # samples of Cycles; of ours for the rate
SEEDS = 3  # at least; more where a few bright pixels decide the error
DOUBT = 0.1  # standard error of the ratio of errors, from which on no more seeds are rendered
SECONDS, QUICK_SECONDS = 120.0, 8.0  # processor time for these seeds
REFERENCE_SAMPLES, QUICK_REFERENCE_SAMPLES = 512, 128  # of each of at least two renders of a reference
REFERENCE_SECONDS = 60.0


def width_of(options) -> int:
    return options.size or (QUICK_WIDTH if options.quick else WIDTH)


def difference(name: str, width: int, samples: int, seeds: int) -> dict:
    """Difference of the mean of our pictures, with as many samples, from that of Cycles: ``mean_difference`` without
    the possible noise, ``mean_doubt`` that noise, and ``mean_ratio``."""
    options = argparse.Namespace(size=width, quick=True, fresh=False, device="CPU")
    scene = artist_scenes.build(name, width)
    made = []
    for seed in range(seeds):
        settings(scene, GUIDED, samples, seed, options.device)
        made.append(pictures.render())
    return _difference(made, _reference(name, scene, options))


def measure(name: str, options) -> dict:
    """Figures of a scene. RuntimeError if it cannot be rendered."""
    scene = artist_scenes.build(name, width_of(options))
    seeds = options.repeats or (1 if options.quick else SEEDS)
    many = QUICK_MANY if options.quick else MANY

    def render(engine: str, samples: int, seed: int, denoise: bool = False) -> pictures.Picture:
        settings(scene, engine, samples, seed, options.device, denoise)
        return pictures.render()

    for engine in ENGINES:
        render(engine, 1, 0)  # compiles, and loads what later renders have
    found = {(engine, samples): render(engine, samples, 100) for engine in ENGINES for samples in (FEW, many)}
    each, start = {}, {}
    for engine in ENGINES:
        few, all_ = found[engine, FEW].work, found[engine, many].work
        each[engine] = max((all_ - few) / (many - FEW), 1e-6)
        start[engine] = max(few - FEW * each[engine], 0.0)
    ours = max(round(many * each[CYCLES] / each[GUIDED]), 1)
    numbers = {CYCLES: many, GUIDED: ours}
    taken: dict[tuple[str, bool], list[pictures.Picture]] = {}
    truth = _reference(name, scene, options)
    seconds, seed = 0.0, 0
    while seed < max(seeds, 2) or (  # the second shows how much is noise
        not options.repeats
        and seconds < (QUICK_SECONDS if options.quick else SECONDS)
        and _doubt(*(taken[engine, False] for engine in ENGINES), truth) > DOUBT
    ):
        for denoise in (False,) if options.quick or seed >= seeds else (False, True):
            for engine in ENGINES:
                made = render(engine, numbers[engine], seed, denoise)
                taken.setdefault((engine, denoise), []).append(made)
                seconds += made.work
        seed += 1
    seconds = options.reference_seconds
    if seconds is None:
        seconds = 0.0 if options.quick else REFERENCE_SECONDS
    least = min(error_of(taken[engine, False], truth) for engine in ENGINES)
    complete(truth, scene, least, _reference_samples(options), seconds, options.device)
    row = dict(samples=ours, cycles_samples=many, **_difference(taken[GUIDED, False], truth))
    for denoise, prefix in ((False, ""), (True, "denoised_")):
        if (GUIDED, denoise) in taken:
            row |= _at_equal_time({engine: taken[engine, denoise] for engine in ENGINES}, start, truth, prefix)
    row |= dict(
        error_time_doubt=_doubt(*(taken[engine, False] for engine in ENGINES), truth),
        seeds=seed,
        samples_ratio=each[CYCLES] / each[GUIDED],
        reference_error=errors.rel_variance(truth.variance, truth.pixels),
        reference_renders=len(truth.renders),
    )
    if options.sheet:
        _keep(name, truth.pixels, np.mean([picture.pixels for picture in taken[GUIDED, False]], axis=0))
    return row


def _difference(made: list[pictures.Picture], truth: references.Reference) -> dict:
    """Difference of the mean of our pictures from the reference's, in the worst channel, without the possible noise;
    and that noise."""
    means = np.array([picture.pixels.mean(axis=(0, 1)) for picture in made])
    theirs = np.array([pixels.mean(axis=(0, 1)) for pixels in truth.renders])
    light = theirs.mean()
    noise = np.hypot(*(one.std(axis=0, ddof=1) / len(one) ** 0.5 for one in (means, theirs))).max() / light
    found = float(np.max(np.abs(means.mean(axis=0) - theirs.mean(axis=0))) / light)
    return dict(
        mean_difference=max(found * found - noise * noise, 0.0) ** 0.5,
        mean_ratio=float(means.mean() / light),
        mean_doubt=float(noise),
    )


def _doubt(these: list[pictures.Picture], those: list[pictures.Picture], truth: references.Reference) -> float:
    """Relative standard error of the ratio of two mean squared errors, from the scatter over seeds."""
    squares = 0.0
    for made in (these, those):
        found = np.array([errors.rel_mse(picture.pixels, truth.pixels) for picture in made])
        squares += found.var(ddof=1) / len(found) / found.mean() ** 2
    return float(squares**0.5)


def _at_equal_time(made: dict[str, list[pictures.Picture]], start: dict, truth, prefix: str) -> dict:
    """Errors of both, and Cycles' × its time over ours × our time, at about equal times."""
    error = {engine: error_of(made[engine], truth) for engine in ENGINES}
    work = {
        engine: max(statistics.median(picture.work for picture in made[engine]) - start[engine], 1e-6)
        for engine in ENGINES
    }
    return {
        f"{prefix}rel_mse": error[GUIDED],
        f"{prefix}cycles_rel_mse": error[CYCLES],
        f"{prefix}error_time_ratio": error[CYCLES] * work[CYCLES] / (error[GUIDED] * work[GUIDED]),
    }


def _reference(name: str, scene, options) -> references.Reference:
    scripts = [
        *(pathlib.Path(__file__).parent / "artist_scenes").glob("*.py"),
        *(host.REPOSITORY / "scripts" / "scenery").glob("*.py"),
    ]
    return reference_of(name, scene, scripts, _reference_samples(options), options.fresh, options.device)


def _reference_samples(options) -> int:
    return QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES


# -- contact sheet -----------------------------------------------------------------------------------------------------


def _path(name: str) -> pathlib.Path:
    folder = host.REPOSITORY / "build" / "artist_scenes"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name}.npz"


def _keep(name: str, cycles: np.ndarray, ours: np.ndarray) -> None:
    np.savez_compressed(_path(name), cycles=cycles.astype(np.float32), ours=ours.astype(np.float32))


def write_sheet(path: pathlib.Path, names: list[str]) -> None:
    """Pairs of pictures of all scenes that were kept, two pairs side by side."""
    cells = []
    for name in names:
        if _path(name).is_file():
            with np.load(_path(name)) as file:
                both = np.concatenate([file[key].astype(float)[::-1] for key in ("cycles", "ours")], axis=1)
            shown = contact_sheet.srgb(np.clip(both, 0.0, 1.0))
            cells.append(np.concatenate([shown, contact_sheet.caption(name.replace("_", " "), shown.shape[1])]))
    if cells:
        contact_sheet.write(path, contact_sheet.sheet(cells, 2))
