# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One material of ``materials`` by both engines in turns: the difference of their pictures, samples a second, error by time.

Both take the same settings; times are processor times of all threads, and those of a sample are told from two numbers
of samples, so that nothing counts that comes before the first one. References are Cycles' renders of many samples,
kept in the user's cache.
"""

from __future__ import annotations

import hashlib
import pathlib
import statistics

import bpy
import host
import numpy as np

from . import errors, materials, node_sheets, pictures, references, simple_scenes
from .node_pictures import CYCLES, OURS, difference_of, warnings_of

SIZE, QUICK_SIZE = 72, 48  # pixels a side
FEW, MANY = 4, 68  # samples that times are told from
QUICK_MANY = 36
SEEDS, QUICK_SEEDS = 3, 2
REFERENCE_SAMPLES, QUICK_REFERENCE_SAMPLES = 256, 128  # of each of at least two renders of a reference
REFERENCE_SECONDS = 8.0  # most time for a reference beyond those
CLEAR = 0.05  # part of the least error judged, below which a reference is good enough
GUIDED = "guided"  # our engine as it is by default: noisy pixels take more samples, paths divide
# What both engines have by default.
LIMITS = dict(max_bounces=12, diffuse_bounces=4, glossy_bounces=4, transmission_bounces=12, volume_bounces=0)
TRANSPARENT = 8


def settings(scene, engine: str, samples: int, seed: int, device: str) -> None:
    simple_scenes.plain_cycles(scene, samples, LIMITS["max_bounces"])
    simple_scenes.plain_sdf_lights(scene, samples, LIMITS["max_bounces"], device)
    for owner in (scene.cycles, scene.sdf_lights):
        for name, value in LIMITS.items():
            if hasattr(owner, name):
                setattr(owner, name, value)
        owner.seed = seed
    scene.cycles.transparent_max_bounces = scene.sdf_lights.transparent_bounces = TRANSPARENT
    scene.render.engine = CYCLES if engine == CYCLES else OURS
    if engine == GUIDED:
        scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = 0, True


def failed(name: str, why: str) -> dict:
    """The row of a material of which there is no picture."""
    return dict(material=name, nodes=None, mean_difference=None, error=why, warning="")


def measure(name: str, options) -> dict:
    """A row. A material that cannot be rendered says why, and has no figures."""
    try:
        scene = materials.build(name, options.size or (QUICK_SIZE if options.quick else SIZE))
        graph = bpy.data.objects[name].data.materials[0].node_tree
        row = failed(name, "") | dict(nodes=len(graph.nodes))
        return row | _figures(name, scene, options) | dict(warning=" ".join(warnings_of(scene.name)))
    except Exception as error:  # of Blender, of the script of the scene, or of either engine
        return failed(name, f"{type(error).__name__}: {str(error).removeprefix('Error: ').strip()}")


def _figures(name: str, scene, options) -> dict:
    seeds = options.repeats or (QUICK_SEEDS if options.quick else SEEDS)
    many = QUICK_MANY if options.quick else MANY
    taken: dict[tuple[str, int], list[pictures.Picture]] = {}

    def render(engine: str, samples: int, seed: int) -> pictures.Picture:
        settings(scene, engine, samples, seed, options.device)
        return pictures.render()

    render(CYCLES, 1, 0)
    render(OURS, 1, 0)  # compiles
    for seed in range(max(seeds, 2)):  # the second tells how much is noise
        for engine in (CYCLES, OURS, GUIDED):
            for samples in (FEW, many) if seed < seeds and engine != GUIDED else (many,):
                taken.setdefault((engine, samples), []).append(render(engine, samples, seed))
    truth = _reference(name, scene, options)
    clean = {key: [picture.pixels for picture in made] for key, made in taken.items()}
    least = min(
        np.mean([errors.rel_mse(pixels, truth.pixels) for pixels in clean[engine, many]]) for engine in (CYCLES, GUIDED)
    )
    _complete(truth, least, options)
    made = clean[GUIDED, many] + clean[OURS, many]
    if options.sheets:
        node_sheets.keep(name, truth.pixels, np.mean(made, axis=0))

    each, work, error = {}, {}, {}
    for engine in (CYCLES, OURS):
        each[engine] = max(_work(taken[engine, many]) - _work(taken[engine, FEW]), 1e-6) / (many - FEW)
    work[CYCLES] = many * each[CYCLES]
    # What comes before samples is the same for paths that divide.
    work[GUIDED] = max(_work(taken[GUIDED, many]) - (_work(taken[OURS, FEW]) - FEW * each[OURS]), 1e-6)
    doubt = errors.rel_variance(truth.variance, truth.pixels)
    for engine in (CYCLES, GUIDED):
        found = float(np.mean([errors.rel_mse(pixels, truth.pixels) for pixels in clean[engine, many]]))
        error[engine] = max(found - doubt, 0.01 * found)
    ours, light = np.mean(made, axis=(0, 1, 2)), truth.pixels.mean(axis=(0, 1))
    pair = difference_of(
        [(plain + guided) / 2.0 for plain, guided in zip(clean[OURS, many], clean[GUIDED, many])], truth.renders
    )
    pixels = truth.pixels[..., 0].size
    # Of the mean of a channel, from the variances of its pixels.
    variance = truth.variance.sum(axis=(0, 1)) + np.var(made, axis=0, ddof=1).sum(axis=(0, 1)) / len(made)
    return dict(
        mean_difference=float(np.max(np.abs(ours - light)) / light.mean()),
        mean_doubt=float(np.sqrt(variance.max()) / pixels / light.mean()),
        mean_ratio=float(ours.mean() / light.mean()),
        block_difference=pair.mean,
        block_doubt=pair.mean_doubt,
        samples_per_second=pixels / each[OURS],
        cycles_samples_per_second=pixels / each[CYCLES],
        samples_ratio=each[CYCLES] / each[OURS],
        rel_mse=error[GUIDED],
        cycles_rel_mse=error[CYCLES],
        work=work[GUIDED],
        cycles_work=work[CYCLES],
        samples=many,
        error_time_ratio=error[CYCLES] * work[CYCLES] / (error[GUIDED] * work[GUIDED]),
        reference_error=doubt,
        reference_renders=len(truth.renders),
    )


def _work(made: list[pictures.Picture]) -> float:
    return statistics.median(picture.work for picture in made)


def _reference(name: str, scene, options) -> references.Reference:
    """That of Cycles for a material, with two renders at least; it depends on the scripts that build the scene."""
    digest = hashlib.sha256()
    here = pathlib.Path(__file__).parent
    for path in sorted(
        [
            *(here / "materials").glob("*.py"),
            *(host.REPOSITORY / "scripts" / "scenery").glob("*.py"),
            here / "node_data.py",
            here / "simple_scenes.py",
        ]
    ):
        digest.update(path.read_bytes())
    truth = references.Reference(
        f"{name} {scene.render.resolution_x} {_reference_samples(options)} {LIMITS} "
        f"{bpy.app.version_string} {digest.hexdigest()}"
    )
    if options.fresh:
        truth.forget()
    while len(truth.renders) < 2:
        truth.add(lambda seed: _reference_render(scene, seed, options))
    return truth


def _complete(truth: references.Reference, least: float, options) -> None:
    """Add renders until the reference is clear of the least error that it judges, or the time is spent."""
    limit = options.reference_seconds
    if limit is None:
        limit = 0.0 if options.quick else REFERENCE_SECONDS
    before = truth.seconds
    while truth.seconds - before < limit and errors.rel_variance(truth.variance, truth.pixels) > CLEAR * least:
        truth.add(lambda seed: _reference_render(bpy.context.scene, seed, options))


def _reference_samples(options) -> int:
    return QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES


def _reference_render(scene, seed: int, options) -> tuple[np.ndarray, float]:
    settings(scene, CYCLES, _reference_samples(options), seed % (1 << 31), options.device)
    picture = pictures.render()
    return picture.pixels, picture.seconds
