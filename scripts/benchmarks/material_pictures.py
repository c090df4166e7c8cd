# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One material of ``materials`` by both engines in turns: difference of the pictures, samples a second, error × time.

Both use the same settings. Times are processor times of all threads. The time of a sample comes from two numbers of
samples, so that time before the first sample does not count. References are Cycles' renders with many samples, kept in
the user's cache.
"""

from __future__ import annotations

import pathlib
import statistics

import bpy
import host
import numpy as np

from . import errors, materials, node_sheets, pictures, references
from .beside_cycles import GUIDED, complete, error_of, reference_of, settings
from .node_pictures import CYCLES, OURS, difference_of, warnings_of

SIZE, QUICK_SIZE = 72, 48  # pixels a side
FEW, MANY = 4, 68  # samples of the two timed renders
QUICK_MANY = 36
SEEDS, QUICK_SEEDS = 3, 2
REFERENCE_SAMPLES, QUICK_REFERENCE_SAMPLES = 256, 128  # of each of at least two renders of a reference
REFERENCE_SECONDS = 8.0  # maximum time for a reference beyond those


def failed(name: str, why: str) -> dict:
    """The row of a material without a picture."""
    return dict(material=name, nodes=None, mean_difference=None, error=why, warning="")


def measure(name: str, options) -> dict:
    """A row. A material that cannot be rendered has the reason, and no figures."""
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
    for seed in range(max(seeds, 2)):  # the second shows how much is noise
        for engine in (CYCLES, OURS, GUIDED):
            for samples in (FEW, many) if seed < seeds and engine != GUIDED else (many,):
                taken.setdefault((engine, samples), []).append(render(engine, samples, seed))
    truth = _reference(name, scene, options)
    clean = {key: [picture.pixels for picture in made] for key, made in taken.items()}
    least = min(
        np.mean([errors.rel_mse(pixels, truth.pixels) for pixels in clean[engine, many]]) for engine in (CYCLES, GUIDED)
    )
    seconds = options.reference_seconds
    if seconds is None:
        seconds = 0.0 if options.quick else REFERENCE_SECONDS
    complete(truth, scene, least, _reference_samples(options), seconds, options.device)
    made = clean[GUIDED, many] + clean[OURS, many]
    if options.sheets:
        node_sheets.keep(name, truth.pixels, np.mean(made, axis=0))

    each, work, error = {}, {}, {}
    for engine in (CYCLES, OURS):
        each[engine] = max(_work(taken[engine, many]) - _work(taken[engine, FEW]), 1e-6) / (many - FEW)
    work[CYCLES] = many * each[CYCLES]
    # The time before samples is the same for paths that split.
    work[GUIDED] = max(_work(taken[GUIDED, many]) - (_work(taken[OURS, FEW]) - FEW * each[OURS]), 1e-6)
    doubt = errors.rel_variance(truth.variance, truth.pixels)
    for engine in (CYCLES, GUIDED):
        error[engine] = error_of(taken[engine, many], truth)
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
    here = pathlib.Path(__file__).parent
    scripts = [
        *(here / "materials").glob("*.py"),
        *(host.REPOSITORY / "scripts" / "scenery").glob("*.py"),
        here / "node_data.py",
        here / "simple_scenes.py",
    ]
    return reference_of(name, scene, scripts, _reference_samples(options), options.fresh, options.device)


def _reference_samples(options) -> int:
    return QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES
