# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene of ``artist_scenes`` by both engines in turns: the difference of their means, and their errors at equal time.

Times are processor times of all threads. The time of a render of Cycles is the measure; ours takes as many samples as fit into it,
without what comes before the first sample, which ``scene_costs`` measures by itself. Denoised pictures are judged in the same way.
"""

from __future__ import annotations

import hashlib
import pathlib
import statistics

import bpy
import contact_sheet
import host
import numpy as np

from . import artist_scenes, errors, pictures, references, simple_scenes

CYCLES, OURS = ENGINES = ("CYCLES", host.ENGINE)
WIDTH, QUICK_WIDTH = 240, 96
FEW, MANY, QUICK_MANY = 4, 64, 16  # samples of Cycles; of ours for the rate
SEEDS = 3
REFERENCE_SAMPLES, QUICK_REFERENCE_SAMPLES = 512, 128  # of each of at least two renders of a reference
REFERENCE_SECONDS = 60.0
CLEAR = 0.05  # part of the least error judged, below which a reference is good enough
# What both engines have by default.
BOUNCES = dict(max_bounces=12, diffuse_bounces=4, glossy_bounces=4, transmission_bounces=12, volume_bounces=0)
TRANSPARENT = 8


def settings(scene, engine: str, samples: int, seed: int, device: str, denoise: bool = False) -> None:
    """The defaults of both, but for what trades error for bias: clamps, filters of glossy light, a noise threshold."""
    simple_scenes.plain_cycles(scene, samples, BOUNCES["max_bounces"])
    simple_scenes.plain_sdf_lights(scene, samples, BOUNCES["max_bounces"], device)
    for owner in (scene.cycles, scene.sdf_lights):
        for name, value in BOUNCES.items():
            if hasattr(owner, name):
                setattr(owner, name, value)
        owner.seed = seed
    scene.cycles.transparent_max_bounces = scene.sdf_lights.transparent_bounces = TRANSPARENT
    scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = 0, True
    scene.cycles.use_denoising = scene.sdf_lights.denoise = denoise
    scene.cycles.denoiser = "OPENIMAGEDENOISE"
    scene.render.engine = engine


def width_of(options) -> int:
    return options.size or (QUICK_WIDTH if options.quick else WIDTH)


def measure(name: str, options) -> dict:
    """Figures of a scene. RuntimeError where it cannot be rendered."""
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
    ours = max(round(many * each[CYCLES] / each[OURS]), 1)
    numbers = {CYCLES: many, OURS: ours}
    taken: dict[tuple[str, bool], list[pictures.Picture]] = {}
    for seed in range(max(seeds, 2)):  # the second tells how much is noise
        for denoise in (False,) if options.quick else (False, True):
            for engine in ENGINES:
                taken.setdefault((engine, denoise), []).append(render(engine, numbers[engine], seed, denoise))
    truth = _reference(name, scene, options)
    _complete(truth, scene, min(_error(taken[engine, False], truth) for engine in ENGINES), options)
    row = dict(samples=ours, cycles_samples=many, **_difference(taken[OURS, False], truth))
    for denoise, prefix in ((False, ""), (True, "denoised_")):
        if (OURS, denoise) in taken:
            row |= _at_equal_time({engine: taken[engine, denoise] for engine in ENGINES}, start, truth, prefix)
    row |= dict(
        samples_ratio=each[CYCLES] / each[OURS],
        reference_error=errors.rel_variance(truth.variance, truth.pixels),
        reference_renders=len(truth.renders),
    )
    if options.sheet:
        _keep(name, truth.pixels, np.mean([picture.pixels for picture in taken[OURS, False]], axis=0))
    return row


def _difference(made: list[pictures.Picture], truth: references.Reference) -> dict:
    """Of the mean of our pictures from the reference's, in the worst channel, without what noise may be; and that noise."""
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


def _error(made: list[pictures.Picture], truth: references.Reference) -> float:
    """Mean relative squared error, without that of the reference."""
    found = float(np.mean([errors.rel_mse(picture.pixels, truth.pixels) for picture in made]))
    return max(found - errors.rel_variance(truth.variance, truth.pixels), 0.01 * found)


def _at_equal_time(made: dict[str, list[pictures.Picture]], start: dict, truth, prefix: str) -> dict:
    """Errors of both, and Cycles' × its time over ours × our time, where both take about the same."""
    error = {engine: _error(made[engine], truth) for engine in ENGINES}
    work = {
        engine: max(statistics.median(picture.work for picture in made[engine]) - start[engine], 1e-6)
        for engine in ENGINES
    }
    return {
        f"{prefix}rel_mse": error[OURS],
        f"{prefix}cycles_rel_mse": error[CYCLES],
        f"{prefix}error_time_ratio": error[CYCLES] * work[CYCLES] / (error[OURS] * work[OURS]),
    }


def _reference(name: str, scene, options) -> references.Reference:
    """That of Cycles, with two renders at least; it depends on the scripts that build the scene."""
    digest = hashlib.sha256()
    here = pathlib.Path(__file__).parent
    for path in sorted(
        [*(here / "artist_scenes").glob("*.py"), *(host.REPOSITORY / "scripts" / "scenery").glob("*.py")]
    ):
        digest.update(path.read_bytes())
    samples = QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES
    size = scene.render.resolution_x
    truth = references.Reference(f"{name} {size} {samples} {BOUNCES} {bpy.app.version_string} {digest.hexdigest()}")
    if options.fresh:
        truth.forget()
    while len(truth.renders) < 2:
        truth.add(lambda seed: _reference_render(scene, samples, seed, options))
    return truth


def _complete(truth: references.Reference, scene, least: float, options) -> None:
    """Add renders until the reference is clear of the least error that it judges, or the time is spent."""
    limit = options.reference_seconds
    if limit is None:
        limit = 0.0 if options.quick else REFERENCE_SECONDS
    before, samples = truth.seconds, QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES
    while truth.seconds - before < limit and errors.rel_variance(truth.variance, truth.pixels) > CLEAR * least:
        truth.add(lambda seed: _reference_render(scene, samples, seed, options))


def _reference_render(scene, samples: int, seed: int, options) -> tuple[np.ndarray, float]:
    settings(scene, CYCLES, samples, seed % (1 << 31), options.device)
    picture = pictures.render()
    return picture.pixels, picture.seconds


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
