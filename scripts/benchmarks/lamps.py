# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error at equal time of full renders of lamps: our samplers, and Cycles, for which a lamp is a volume that emits.

The methods take turns with one seed after the other. The error is the mean of ``errors.rel_mse`` over the seeds, less
what the reference's own error adds; the time is the median of the processor time of a render, of all threads together,
by the number of cores: what the clock shows on an idle machine. The time that all methods are given is what Cycles
takes for ``TARGET`` samples. The number of samples that a sampler of ours has time for is found and rendered; what is
left of a difference in time is made up for along the sampler's curve of error against time.
"""

from __future__ import annotations

import itertools
import math
import statistics
from dataclasses import dataclass, field

import bpy
import numpy as np

import host
from sdf_lights.render.settings import LampSampling

from . import errors, lamp_scenes, machine, pictures, references, scenes, some_of
from .progress import Progress
from .resume import Parts

HELP = "error at equal time of full renders of lamps: samplers, and Cycles' volumes"

BOUNCES = (0, 4)
TARGET = 64  # samples of Cycles, whose time all methods get
PAPER = "MIS"  # the sampler of Huang et al. 2026 with its balance heuristic, by our Sobol points
REFERENCE_SAMPLES = 256  # of each render of a reference, by ``PAPER``
CLEAR = 0.01  # error of a reference, as part of the least one that it judges, at which it is good enough
THE_FIVE = ("S1", "S2", "S3", "S4", "S5")


@dataclass
class Method:
    """Pictures by one way to render, by their number of samples."""

    name: str
    sampler: str = ""  # of SDF Lights; "" is Cycles
    denoise: bool = False
    paths: int = 0  # ``indirect_paths``
    pictures: dict[int, list[pictures.Picture]] = field(default_factory=dict)

    def render(self, samples: int, bounces: int, seed: int, device: str) -> pictures.Picture:
        scene = bpy.context.scene
        lamp_scenes.show(volumes=not self.sampler)
        if self.sampler:
            scenes.plain_sdf_lights(scene, samples, bounces, device)
            scene.sdf_lights.seed, scene.sdf_lights.denoise = seed, self.denoise
            scene.sdf_lights.lamp_sampling, scene.sdf_lights.indirect_paths = self.sampler, self.paths
        else:
            scenes.plain_cycles(scene, samples, bounces)
            scene.cycles.seed, scene.cycles.use_denoising = seed, self.denoise
        return pictures.render()

    def keep(self, samples: int, bounces: int, seed: int, device: str) -> None:
        self.pictures.setdefault(samples, []).append(self.render(samples, bounces, seed, device))

    def seconds(self, samples: int) -> float:
        return statistics.median(picture.work for picture in self.pictures[samples]) / machine.cores()

    def rate(self) -> tuple[float, float]:
        """Seconds of a sample of the whole picture, and those before the first one."""
        fewer, *_, more = sorted(self.pictures)
        each = max((self.seconds(more) - self.seconds(fewer)) / (more - fewer), 1e-9)
        return each, self.seconds(more) - more * each

    def samples_in(self, seconds: float) -> int:
        """How many samples it has time for."""
        each, start = self.rate()
        return max(round((seconds - start) / each), 1)

    def error(self, samples: int, reference: references.Reference) -> float:
        """Mean relative squared error, without that of the reference."""
        found = np.mean([errors.rel_mse(picture.pixels, reference.pixels) for picture in self.pictures[samples]])
        return max(found - errors.rel_variance(reference.variance, reference.pixels), 0.01 * found)

    def curve(self, reference: references.Reference) -> list[tuple[float, float]]:
        return [(self.seconds(samples), self.error(samples, reference)) for samples in sorted(self.pictures)]


def arguments(parser) -> None:
    names = lamp_scenes.SCENES
    parser.add_argument(
        "--only", type=some_of(names), metavar="SCENES", help=f"with commas between: {', '.join(names)}")
    samplers = [sampling.value for sampling in LampSampling]
    parser.add_argument(
        "--samplers", type=some_of(samplers), default=f"CUT,{PAPER}",
        help=f"of {', '.join(samplers)}, with commas between; the first is the one that is judged")
    parser.add_argument("--bounces", type=int, choices=BOUNCES, help="of light; default: each of them")
    parser.add_argument("--no-cycles", dest="cycles", action="store_false", help="compare our samplers alone")
    parser.add_argument("--size", type=int, help="pixels to a side")
    parser.add_argument("--reference-seconds", type=float, help="most time that is spent on one reference")
    parser.add_argument("--fresh", action="store_true", help="make references anew")


def _rows(name: str, bounces: int, methods: list[Method], reference) -> list[dict]:
    rows, expected = [], reference.pixels.mean()
    for method in methods:
        for samples, made in sorted(method.pictures.items()):
            worst = [errors.pixel_errors(picture.pixels, reference.pixels) for picture in made]
            means = [picture.pixels.mean() / expected for picture in made]
            rows.append(dict(
                scene=name, bounces=bounces, method=method.name, samples=samples, seconds=method.seconds(samples),
                clock=statistics.median(picture.seconds for picture in made), rel_mse=method.error(samples, reference),
                mape=float(np.mean([errors.mape(picture.pixels, reference.pixels) for picture in made])),
                flip=errors.flip(made[0].pixels, reference.pixels), worst_999=float(np.mean([a for a, _ in worst])),
                worst=max(b for _, b in worst), mean_ratio=float(np.mean(means)),
                mean_ratio_error=float(np.std(means, ddof=1) / math.sqrt(len(means))) if len(means) > 1 else None))
    return rows


def _complete(reference, methods: list[Method], bounces: int, seconds: float, device: str) -> None:
    """Add renders to a reference until it is clear of what it judges, or the time is spent."""
    truth, spent = Method(PAPER, PAPER, paths=1), 0.0
    while len(reference.renders) < 2 or spent < seconds:
        if len(reference.renders) >= 2:
            least = min(method.error(samples, reference) for method in methods for samples in method.pictures)
            if errors.rel_variance(reference.variance, reference.pixels) < CLEAR * least:
                break

        def render(seed: int) -> np.ndarray:
            nonlocal spent
            picture = truth.render(REFERENCE_SAMPLES, bounces, seed, device)
            spent += picture.work / machine.cores()
            return picture.pixels

        reference.add(render)


def measure(scene: str, bounces: int, options, progress) -> tuple[dict, list[dict]]:
    """One scene, that is open: what is compared at equal time, and rows of all pictures."""
    repeats = options.repeats or (2 if options.quick else 5)
    ladder = (16, 64) if options.quick else (4, 16, 64, 256)
    samplers = options.samplers
    # The paper's paths do not divide; what dividing alone does for it is told apart.
    ours = [Method(name, name, paths=min(place, 1)) for place, name in enumerate(samplers)]
    if bounces and PAPER in samplers[1:]:
        ours.append(Method(f"{PAPER} divided", PAPER))
    with_cycles = options.cycles and lamp_scenes.SCENES[scene].volumes
    denoised = [Method(f"{samplers[0]} denoised", samplers[0], True)] if with_cycles else []
    cycles = [Method("Cycles"), Method("Cycles denoised", denoise=True)] if with_cycles else []
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
            for samples in ladder[-3:-1] if len(ladder) > 2 else ladder:
                method.keep(samples, bounces, seed, options.device)
    target = (cycles or ours)[0].seconds(TARGET)
    start = ours[0].rate()[1]
    progress.show(f"{scene}, {bounces} bounces, equal time")
    for method in ours:
        samples = method.samples_in(target)
        for seed in range(repeats if samples not in method.pictures else 0):
            method.keep(samples, bounces, repeats + seed, options.device)
    progress.show(f"{scene}, {bounces} bounces, reference")
    version = (host.REPOSITORY / "blender_manifest.toml").read_text(encoding="utf-8")
    reference = references.Reference(f"{references.fingerprint()} {bounces} {REFERENCE_SAMPLES} {version}")
    if options.fresh:
        reference.renders.clear()
    methods = [*ours, *denoised, *cycles]
    limit = options.reference_seconds
    _complete(reference, methods, bounces, (5.0 if options.quick else 60.0) if limit is None else limit, options.device)

    curves = {method.name: method.curve(reference) for method in methods}
    best = ours[0].name
    found = dict(scene=scene, bounces=bounces, seconds=target, rel_mse=errors.interpolated(curves[best], target))
    for method in ours[1:]:
        found[f"{method.name} / {best}"] = errors.interpolated(curves[method.name], target) / found["rel_mse"]
    if cycles:
        found["cycles"] = cycles[0].error(TARGET, reference) / found["rel_mse"]
        later, error = cycles[1].seconds(TARGET), cycles[1].error(TARGET, reference)
        found["cycles denoised"] = error / errors.interpolated(curves[best], later)
        found["both denoised"] = error / errors.interpolated(curves[denoised[0].name], later)
    found["start"] = start
    found["slope"] = 0.5 * errors.slope([(s, ours[0].error(s, reference)) for s in ladder])
    least = min(method.error(samples, reference) for method in methods for samples in method.pictures)
    found["reference"] = errors.rel_variance(reference.variance, reference.pixels) / least
    return found, _rows(scene, bounces, methods, reference)


def _geomean(values) -> float:
    return math.exp(statistics.fmean(map(math.log, values)))


def _summary(found: list[dict], best: str) -> dict:
    five = [row for row in found if row["scene"] in THE_FIVE] or found
    summary = {}
    paper = f"{PAPER} / {best}"
    for bounces, key in ((0, "direct"), (4, "bounces")):
        rows = [row for row in five if row["bounces"] == bounces]
        if not rows:
            continue
        if "cycles" in rows[0]:
            summary[f"mse_ratio_cycles_{key}_geomean"] = _geomean(row["cycles"] for row in rows)
            summary[f"mse_ratio_cycles_{key}_min"] = min(row["cycles"] for row in rows)
            summary[f"mse_ratio_cycles_denoised_{key}_geomean"] = _geomean(row["cycles denoised"] for row in rows)
            summary[f"mse_ratio_both_denoised_{key}_geomean"] = _geomean(row["both denoised"] for row in rows)
        if paper in rows[0]:
            summary[f"mse_ratio_paper_{key}_geomean"] = _geomean(row[paper] for row in rows)
            summary[f"mse_ratio_paper_{key}_min"] = min(
                row[paper] for row in found if row["bounces"] == bounces)
        summary[f"slope_{key}"] = statistics.fmean(row["slope"] for row in rows)
    return summary


def run(options) -> tuple[dict, list[dict]]:
    names = options.only or (THE_FIVE if options.quick else list(lamp_scenes.SCENES))
    bounces = BOUNCES if options.bounces is None else [options.bounces]
    size = options.size or (128 if options.quick else 256)
    progress, parts = Progress(len(names) * len(bounces)), Parts(options)
    found, rows = [], []
    for name, count in itertools.product(names, bounces):

        def one():
            lamp_scenes.SCENES[name].build(size)
            return measure(name, count, options, progress)

        compared, more = parts.of(f"{name} {count}", one)
        found.append(compared)
        rows += more
        progress.step()
    parts.finish()
    progress.close()
    return _summary(found, options.samplers[0]), [*found, *rows]
