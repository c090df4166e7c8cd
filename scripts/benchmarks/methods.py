# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods to render a scene of lamps, their references, and errors: for benchmarks of whole renders.

The time of a picture is the processor time of all threads divided by the number of cores: the wall-clock time on an
idle machine.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import pathlib
import statistics
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import host
import numpy as np

from support.rivals import samplers

from . import errors, lamp_scenes, machine, pictures, references, simple_scenes, some_of
from .progress import Progress
from .resume import Parts

BOUNCES = (0, 4)
TARGET = 64  # samples of Cycles; all methods get their time
PAPER = "MIS"  # the sampler of Huang et al. 2026 with its balance heuristic, by our Sobol points
REFERENCE_SAMPLES, QUICK_REFERENCE_SAMPLES = 512, 64  # of each render of a reference
CLEAR = 0.01  # error of a reference at which it is good enough, relative to the least error that it judges
METRICS = {"rel_mse": errors.rel_mse, "mape": errors.mape, "flip": errors.flip}


@dataclass
class Method:
    """Pictures by one method, by their number of samples."""

    name: str
    sampler: str = ""  # of SDF Lights; "" is Cycles
    denoise: bool = False
    plain: bool = False  # every pixel takes equally many samples, and paths do not split
    surfaces: bool = False  # for Cycles: lamps are meshes that emit, instead of volumes
    pictures: dict[int, list[pictures.Picture]] = field(default_factory=dict)

    def render(self, samples: int, bounces: int, seed: int, device: str) -> pictures.Picture:
        scene = bpy.context.scene
        lamp_scenes.show(volumes=not self.sampler and not self.surfaces, surfaces=self.surfaces)
        if self.sampler:
            simple_scenes.plain_sdf_lights(scene, samples, bounces, device)
            scene.sdf_lights.seed, scene.sdf_lights.denoise = seed, self.denoise
            scene.sdf_lights.lamp_sampling = samplers.register(self.sampler, host.program().__name__).value
            scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = int(self.plain), not self.plain
        else:
            simple_scenes.plain_cycles(scene, samples, bounces)
            scene.cycles.seed, scene.cycles.use_denoising = seed, self.denoise
        return pictures.render()

    def keep(self, samples: int, bounces: int, seed: int, device: str) -> None:
        self.pictures.setdefault(samples, []).append(self.render(samples, bounces, seed, device))

    def seconds(self, samples: int) -> float:
        return statistics.median(picture.work for picture in self.pictures[samples]) / machine.cores()

    def rate(self) -> tuple[float, float]:
        """Seconds of a sample of the whole picture, and of the time before the first one."""
        fewer, *_, more = sorted(self.pictures)
        each = max((self.seconds(more) - self.seconds(fewer)) / (more - fewer), 1e-9)
        return each, self.seconds(more) - more * each

    def samples_in(self, seconds: float) -> float:
        """The number of samples for this time; below 1 if it does not even begin.

        Interpolated by time between the rendered numbers: with guided samples, the first ones take longer.
        """
        numbers = sorted(self.pictures)
        times = [self.seconds(samples) for samples in numbers]
        if times[0] < seconds < times[-1] and times == sorted(times):
            return float(np.interp(seconds, times, numbers))
        each, start = self.rate()
        return (seconds - start) / each

    def error(self, samples: int, reference: references.Reference) -> float:
        """Mean relative squared error, minus that of the reference."""
        found = np.mean([errors.rel_mse(picture.pixels, reference.pixels) for picture in self.pictures[samples]])
        return max(found - errors.rel_variance(reference.variance, reference.pixels), 0.01 * found)

    def curve(self, reference: references.Reference) -> list[tuple[float, float]]:
        return [(self.seconds(samples), self.error(samples, reference)) for samples in sorted(self.pictures)]

    def rows(self, scene: str, bounces: int, reference: references.Reference) -> list[dict]:
        """A row for each number of samples: time, and means of the errors with their least and largest of all seeds.

        ``rel_mse`` and its band are without the error of the reference.
        """
        found, truth = [], reference.pixels
        for samples, made in sorted(self.pictures.items()):
            row = dict(
                scene=scene,
                bounces=bounces,
                method=self.name,
                samples=samples,
                seeds=len(made),
                seconds=self.seconds(samples),
                clock=statistics.median(picture.seconds for picture in made),
            )
            for name, metric in METRICS.items():
                values = [metric(picture.pixels, truth) for picture in made]
                known = None not in values
                row |= {
                    name: float(np.mean(values)) if known else None,
                    f"{name}_low": min(values) if known else None,
                    f"{name}_high": max(values) if known else None,
                }
            less = self.error(samples, reference) / row["rel_mse"]
            row |= {name: row[name] * less for name in ("rel_mse", "rel_mse_low", "rel_mse_high")}
            worst = [errors.pixel_errors(picture.pixels, truth) for picture in made]
            means = [picture.pixels.mean() / truth.mean() for picture in made]
            spread = float(np.std(means, ddof=1) / math.sqrt(len(means))) if len(means) > 1 else None
            row |= dict(
                worst_999=float(np.mean([a for a, _ in worst])),
                worst_mean=float(np.mean([b for _, b in worst])),
                worst=max(b for _, b in worst),
                mean_ratio=float(np.mean(means)),
                mean_ratio_error=spread,
            )
            found.append(row)
        return found


def arguments(parser, known=lamp_scenes.SCENES) -> None:
    """Options of benchmarks that render lamps by several methods, for ``known`` scenes."""
    parser.add_argument(
        "--only", type=some_of(known), metavar="SCENES", help=f"with commas between: {', '.join(known)}"
    )
    parser.add_argument(
        "--samplers",
        type=some_of(samplers.SAMPLERS),
        default=f"CUT,{PAPER}",
        help=f"of {', '.join(samplers.SAMPLERS)}, with commas between; the first is the judged one",
    )
    parser.add_argument("--bounces", type=int, choices=BOUNCES, help="of light; default: each of them")
    parser.add_argument("--no-cycles", dest="cycles", action="store_false", help="compare only our samplers")
    picture_arguments(parser)


def picture_arguments(parser) -> None:
    """Options of all benchmarks that judge pictures."""
    parser.add_argument("--size", type=int, help="pixels to a side")
    parser.add_argument("--reference-seconds", type=float, help="maximum time for one reference")
    parser.add_argument("--fresh", action="store_true", help="make references again")
    parser.add_argument(
        "--pictures", type=pathlib.Path, metavar="FOLDER", help="keep pictures here, for ./scripts/report"
    )


def by_paper() -> Method:
    """The method that renders references of lamps.

    The paper's sampler of lamps, a different one from ours. The rest is as efficient as possible: paths split, and
    noisy pixels take more samples, so the error is small in half the time.
    """
    return Method("reference", PAPER)


def _reference_samples(options) -> int:
    return QUICK_REFERENCE_SAMPLES if options.quick else REFERENCE_SAMPLES


def reference_of_scene(truth: Method, bounces: int, options) -> references.Reference:
    """The reference of the open scene, by the method ``truth``."""
    bpy.context.view_layer.update()
    version = (host.REPOSITORY / "blender_manifest.toml").read_text(encoding="utf-8")
    reference = references.Reference(
        f"{references.fingerprint()} {truth.name} {bounces} {_reference_samples(options)} {version}"
    )
    if options.fresh:
        reference.forget()
    return reference


def least_error(reference: references.Reference, methods: list[Method]) -> float:
    """The least error that a reference judges."""
    return min(method.error(samples, reference) for method in methods for samples in method.pictures)


def complete(
    reference: references.Reference,
    truth: Method,
    methods: list[Method],
    bounces: int,
    options,
    told: Callable[[str], None],
) -> None:
    """Add renders by ``truth`` to a reference until it is good enough, or the time has passed."""
    seconds = options.reference_seconds
    if seconds is None:
        seconds = 2.0 if options.quick else 60.0
    before = reference.seconds

    def render(seed: int) -> tuple[np.ndarray, float]:
        picture = truth.render(_reference_samples(options), bounces, seed, options.device)
        return picture.pixels, picture.work / machine.cores()

    told("reference")
    while len(reference.renders) < 2 or reference.seconds - before < seconds:
        if len(reference.renders) >= 2:
            part = doubt(reference, methods)
            told(f"reference, standard error {math.sqrt(part):.2f} of the least error, {math.sqrt(CLEAR):g} wanted")
            if part < CLEAR:
                break
        reference.add(render)


def doubt(reference: references.Reference, methods: list[Method]) -> float:
    """Error of a reference relative to the least error that it judges."""
    return errors.rel_variance(reference.variance, reference.pixels) / least_error(reference, methods)


def take_turns(
    methods: list[Method], ladder, seeds: int, bounces: int, device: str, told: Callable[[str], None]
) -> None:
    """Pictures of all methods, for each number of samples in ``ladder``, seed after seed."""
    for method in methods:
        method.render(1, bounces, 0, device)  # compiles, and fills caches
    for seed in range(seeds):
        told(f"seed {seed}")
        for method in methods:
            for samples in ladder:
                method.keep(samples, bounces, seed, device)


def fill_time(methods: list[Method], seconds: float, seeds: int, bounces: int, device: str) -> None:
    """Pictures with as many samples as each method can take in the time."""
    for method in methods:
        samples = max(round(method.samples_in(seconds)), 1)
        for seed in range(seeds if samples not in method.pictures else 0):
            method.keep(samples, bounces, seeds + seed, device)


def keep_pictures(folder: pathlib.Path, name: str, pictures: dict[str, np.ndarray]) -> str:
    """Keep pictures by name, in a file, and return its hash; half floats are precise enough for viewing."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.npz"
    np.savez_compressed(path, **{key: pixels.astype(np.float16) for key, pixels in pictures.items()})
    return hashlib.sha256(path.read_bytes()).hexdigest()


def of_scenes(names, size: int, measure: Callable, options) -> tuple[list[dict], list[dict]]:
    """The results of ``measure(name, bounces, options, progress)``, a comparison and rows, for each scene and number of
    bounces.

    ``size``: pixels per side, unless the options have others. An interrupted run continues.
    """
    bounces = BOUNCES if options.bounces is None else [options.bounces]
    progress, parts = Progress(len(names) * len(bounces)), Parts(options)
    found, rows = [], []
    for name, count in itertools.product(names, bounces):

        def one():
            lamp_scenes.SCENES[name].build(options.size or size)
            return measure(name, count, options, progress)

        compared, more = parts.of(f"{name} {count}", one)
        found.append(compared)
        rows += more
        progress.step()
    parts.finish()
    progress.close()
    return found, rows
