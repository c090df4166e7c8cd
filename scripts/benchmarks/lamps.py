# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error at equal time of full renders of lamps: our samplers, and Cycles, for which a lamp is an emission volume.

The methods take turns, seed after seed. The error is the mean of ``errors.rel_mse`` over the seeds, minus the
contribution of the reference's own error. The time is the median of all renders. All methods get the time that Cycles
takes for ``TARGET`` samples. The number of samples for this time is found and rendered for each of our samplers. The
remaining difference in time is corrected along the sampler's curve of error over time.
"""

from __future__ import annotations

from statistics import fmean, geometric_mean

from . import errors, lamp_scenes, methods
from .methods import PAPER, TARGET, Method, arguments, of_scenes

__all__ = ["BRIEF", "HELP", "arguments", "run"]

HELP = "error at equal time of full renders of lamps: samplers, and Cycles' volumes"

THE_FIVE = lamp_scenes.THE_FIVE
# Of a picture's pixels: the 99.9th percentile, the greatest, and the greatest of all seeds, a single pixel.
WORST = "worst_999", "worst_mean", "worst"
QUICK = ("S1", "S4")  # scenes: one with a closed form along rays, one fractal
BRIEF = dict(only=["S1"], bounces=0, reference_seconds=0.5)


def measure(scene: str, bounces: int, options, progress) -> tuple[dict, list[dict]]:
    """One open scene: the comparison, and rows of all pictures."""
    repeats = options.repeats or (2 if options.quick else 5)
    ladder = (16, 64) if options.quick else (4, 16, 64)
    samplers = options.samplers
    # The paper has equally many samples in each pixel and paths that do not split; the effect of our guidance on it is
    # shown separately.
    ours = [Method(name, name, plain=place > 0) for place, name in enumerate(samplers)]
    if PAPER in samplers[1:]:
        ours.append(Method(f"{PAPER} guided", PAPER))
    with_cycles = options.cycles and lamp_scenes.SCENES[scene].volumes
    denoised = [Method(f"{samplers[0]} denoised", samplers[0], True)] if with_cycles else []
    cycles = [Method("Cycles"), Method("Cycles denoised", denoise=True)] if with_cycles else []
    truth = methods.by_paper()
    reference = methods.reference_of_scene(truth, bounces, options)
    for method in [*ours, *cycles]:
        method.render(1, bounces, 0, options.device)  # compiles, and fills caches
    for seed in range(repeats):
        progress.show(f"{scene}, {bounces} bounces, seed {seed}")
        for method in ours:
            for samples in ladder:
                method.keep(samples, bounces, seed, options.device)
        for method in cycles:
            method.keep(TARGET, bounces, seed, options.device)
        for method in denoised:
            for samples in ladder[:2]:
                method.keep(samples, bounces, seed, options.device)
    target = (cycles or ours)[0].seconds(TARGET)
    start = ours[0].rate()[1]
    progress.show(f"{scene}, {bounces} bounces, equal time")
    methods.fill_time(ours, target, repeats, bounces, options.device)
    judged = [*ours, *denoised, *cycles]
    methods.complete(
        reference, truth, judged, bounces, options, lambda what: progress.show(f"{scene}, {bounces} bounces, {what}")
    )

    curves = {method.name: method.curve(reference) for method in judged}
    rows = [row for method in judged for row in method.rows(scene, bounces, reference)]

    def at_target(name: str, error: str) -> float:
        return errors.interpolated([(row["seconds"], row[error]) for row in rows if row["method"] == name], target)

    best = ours[0].name
    found = dict(scene=scene, bounces=bounces, seconds=target, rel_mse=errors.interpolated(curves[best], target))
    for method in ours[1:]:
        found[f"{method.name} / {best}"] = errors.interpolated(curves[method.name], target) / found["rel_mse"]
        for error in WORST:
            found[f"{error} {method.name} / {best}"] = at_target(method.name, error) / at_target(best, error)
    if cycles:
        found["cycles"] = cycles[0].error(TARGET, reference) / found["rel_mse"]
        later, error = cycles[1].seconds(TARGET), cycles[1].error(TARGET, reference)
        found["cycles denoised"] = error / errors.interpolated(curves[best], later)
        found["both denoised"] = error / errors.interpolated(curves[denoised[0].name], later)
    found["start"] = start
    found["slope"] = 0.5 * errors.slope([(s, ours[0].error(s, reference)) for s in ladder])
    found["reference"] = methods.doubt(reference, judged)
    return found, rows


def _summary(found: list[dict], best: str) -> dict:
    five = [row for row in found if row["scene"] in THE_FIVE] or found
    summary = {}
    paper = f"{PAPER} / {best}"
    for bounces, key in ((0, "direct"), (4, "bounces")):
        rows = [row for row in five if row["bounces"] == bounces]
        if not rows:
            continue
        with_cycles = [row for row in rows if "cycles" in row]
        if with_cycles:
            summary[f"mse_ratio_cycles_{key}_geomean"] = geometric_mean(row["cycles"] for row in with_cycles)
            summary[f"mse_ratio_cycles_{key}_min"] = min(row["cycles"] for row in with_cycles)
            for name, label in (("cycles_denoised", "cycles denoised"), ("both_denoised", "both denoised")):
                summary[f"mse_ratio_{name}_{key}_geomean"] = geometric_mean(row[label] for row in with_cycles)
        if paper in rows[0]:
            summary[f"mse_ratio_paper_{key}_geomean"] = geometric_mean(row[paper] for row in rows)
            everywhere = [row for row in found if row["bounces"] == bounces]
            summary[f"mse_ratio_paper_{key}_min"] = min(row[paper] for row in everywhere)
            for error in WORST:
                summary[f"{error}_ratio_paper_{key}_min"] = min(row[f"{error} {paper}"] for row in everywhere)
            summary[f"mse_ratio_paper_guided_{key}_geomean"] = geometric_mean(
                row[f"{PAPER} guided / {best}"] for row in rows
            )
        summary[f"slope_{key}"] = fmean(row["slope"] for row in rows)
    return summary


def run(options) -> tuple[dict, list[dict]]:
    names = options.only or (QUICK if options.quick else list(lamp_scenes.SCENES))
    found, rows = of_scenes(names, 64 if options.quick else 96, measure, options)
    return _summary(found, options.samplers[0]), [*found, *rows]
