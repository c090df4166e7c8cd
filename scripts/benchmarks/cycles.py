# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time of full renders: samplers of SDF Lights, and Cycles with lamps as volumes and as mesh lights.

Every method renders every scene with the same numbers of samples and the same seeds, in turns. It also renders with as
many samples as fit into the time of Cycles' largest number of samples for volumes. A volume in Cycles is the same lamp,
and has the same reference. A mesh light, the emissive surface of the same mesh with equal power, is a different lamp:
its picture converges to something else, so it has its own reference, rendered by Cycles. The comparison with a lamp is
about noise, not about the picture; ``surface_mape`` is the difference of the two references.
"""

from __future__ import annotations

import argparse
import itertools
import statistics

import numpy as np

from . import errors, lamp_scenes, methods
from .methods import METRICS, Method, of_scenes

HELP = "error against time of full renders: samplers, Cycles' volumes, Cycles' mesh lights"

VOLUMES, SURFACES = "Cycles volume", "Cycles mesh light"
SEEDS = 8
QUICK = ("S1", "S4")  # scenes
BRIEF = dict(only=["S4"], bounces=4, reference_seconds=0.5)
LIGHT = {0: "direct", 4: "bounces"}


def _ladder(text: str) -> list[int]:
    samples = [int(part) for part in text.split(",")]
    if min(samples) < 1 or len(set(samples)) < 2 or samples != sorted(samples):
        raise argparse.ArgumentTypeError("must be two or more numbers of samples, few first, with commas between")
    return samples


def arguments(parser) -> None:
    methods.arguments(parser)
    parser.add_argument("--ladder", type=_ladder, help="samples a pixel, with commas between (default: 4,16,64,256)")


def measure(scene: str, bounces: int, options, progress) -> tuple[dict, list[dict]]:
    """One open scene: the comparison at equal time, and rows of all pictures."""
    seeds = options.repeats or (2 if options.quick else SEEDS)
    ladder = options.ladder or ((4, 16) if options.quick else (4, 16, 64, 256))
    ours = [Method(name, name, plain=place > 0) for place, name in enumerate(options.samplers)]
    volume, surface = Method(VOLUMES), Method(SURFACES, surfaces=True)
    peers = [volume, surface] if options.cycles else []
    by_paper, by_surfaces = methods.by_paper(), Method(SURFACES, surfaces=True)
    truth = methods.reference_of_scene(by_paper, bounces, options)
    surface_truth = methods.reference_of_scene(by_surfaces, bounces, options)

    def told(what: str) -> None:
        progress.show(f"{scene}, {bounces} bounces, {what}")

    methods.take_turns([*ours, *peers], ladder, seeds, bounces, options.device, told)
    target = (peers or ours)[0].seconds(ladder[-1])
    told("equal time")
    methods.fill_time([*ours, *peers[1:]], target, seeds, bounces, options.device)
    same = [*ours, *peers[:1]]
    methods.complete(truth, by_paper, same, bounces, options, told)
    judged = [(method, truth) for method in same]
    found = dict(
        scene=scene,
        bounces=bounces,
        seconds=target,
        samples=ladder[-1],
        reference=methods.doubt(truth, same),
        reference_renders=len(truth.renders),
        reference_seconds=truth.seconds,
    )
    if peers:
        methods.complete(
            surface_truth, by_surfaces, [surface], bounces, options, lambda what: told(f"mesh light's {what}")
        )
        judged.append((surface, surface_truth))
        found |= dict(
            surface_reference=methods.doubt(surface_truth, [surface]),
            surface_reference_renders=len(surface_truth.renders),
            surface_reference_seconds=surface_truth.seconds,
            surface_mape=errors.mape(surface_truth.pixels, truth.pixels),
            surface_mean_ratio=float(surface_truth.pixels.mean() / truth.pixels.mean()),
        )
    rows = [row for method, reference in judged for row in method.rows(scene, bounces, reference)]
    for metric in METRICS:
        for method, _ in judged:
            curve = [(row["samples"], row[metric]) for row in rows if row["method"] == method.name]
            # By samples, because most of the time of a short render comes before the first sample.
            samples = method.samples_in(target)
            known = samples >= 1.0 and all(value is not None for _, value in curve)
            found[f"{metric} {method.name}"] = errors.interpolated(curve, samples) if known else None
    if options.pictures:

        def nearest(method: Method) -> np.ndarray:
            samples = min(method.pictures, key=lambda count: abs(method.seconds(count) - target))
            return method.pictures[samples][0].pixels

        kept = {method.name: nearest(method) for method, _ in judged} | {"reference": truth.pixels}
        if peers:
            kept["reference of the mesh light"] = surface_truth.pixels
        found["renders"] = methods.keep_pictures(options.pictures, f"{scene} {bounces}", kept)
    return found, rows


def summary_of(found: list[dict], rows: list[dict], best: str) -> dict:
    """Geometric means over the scenes: errors of Cycles over those of the sampler ``best``."""
    summary = {}
    for bounces, light in LIGHT.items():
        here = [row for row in found if row["bounces"] == bounces]
        at = {
            (row["scene"], row["method"]): row
            for row in rows
            if here and row["bounces"] == bounces and row["samples"] == here[0]["samples"]
        }
        for name, metric in itertools.product((VOLUMES, SURFACES), METRICS):
            ratios = dict(
                equal_time=[(row.get(f"{metric} {name}"), row.get(f"{metric} {best}")) for row in here],
                equal_samples=[
                    (at[row["scene"], name][metric], at[row["scene"], best][metric])
                    for row in here
                    if (row["scene"], name) in at
                ],
            )
            for kind, pairs in ratios.items():
                known = [theirs / ours for theirs, ours in pairs if theirs is not None and ours is not None]
                if known:
                    summary[f"{metric}_ratio_{name.lower().replace(' ', '_')}_{light}_{kind}"] = (
                        statistics.geometric_mean(known)
                    )
    return summary


def run(options) -> tuple[dict, list[dict]]:
    names = options.only or (QUICK if options.quick else lamp_scenes.THE_FIVE)
    names = [name for name in names if lamp_scenes.SCENES[name].volumes]
    found, rows = of_scenes(names, 48 if options.quick else 256, measure, options)
    return summary_of(found, rows, options.samplers[0]), [*found, *rows]
