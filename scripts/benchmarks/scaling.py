# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render time at equal error over the number of lamps, of parts of one lamp, of triangles, and of pixels.

Lamps are balls, bars and rings in equal parts, at random positions in the same box over the stage and at any angle,
some of them inside the boxes that stand there. For any number of lamps, they have the same density and fill the same
volume, so they give the same power and light; only their size and number differ. All are visible to the camera, so the
error includes that of pixels that a small lamp fills in part.

The error is the relative variance of a pixel, from renders with different seeds. It needs no reference, because an
unbiased method has no other error. The time at equal error is that of a sample times the number of samples for that
error, read off the curve of error over samples. The time before the first sample is given separately: it does not grow
with the size of a picture.
"""

from __future__ import annotations

import functools
import math
import statistics

import bpy
import host
import numpy as np
from scenery.materials import Graph
from scenery.modelling import add

from support.rivals import samplers

from . import errors, lamp_meshes, lamp_scenes, machine, pictures, simple_scenes, some_of
from .lamp_scenes import INTENSITY, add_lamp, turned
from .progress import Progress
from .resume import Parts

HELP = "render time at equal error against the number of lamps, parts, triangles and pixels"

LADDER = (4, 16, 64)
BOUNCES = 1
FILLED = 0.12  # m³, of all lamps together
LOW, HIGH = (-3.0, -2.5, 0.2), (3.0, 2.7, 3.2)  # box around the lamps


def _kinds(volume: float) -> list[str]:
    """A ball, a bar and a ring of that volume."""
    radius = (volume * 0.75 / math.pi) ** (1.0 / 3.0)
    half = (volume / 24.0) ** (1.0 / 3.0)
    tube = (volume / (6.0 * math.pi**2)) ** (1.0 / 3.0)
    return [
        f"sphere({radius:.6g})",
        f"box({half:.6g}, {half:.6g}, {3.0 * half:.6g})",
        f"torus({3.0 * tube:.6g}, {tube:.6g})",
    ]


def lamps(size: int, count: int) -> None:
    """A stage with ``count`` lamps."""
    simple_scenes.boxes_and_sphere(size)
    random = np.random.default_rng(3)
    kinds = _kinds(FILLED / count)
    for index in range(count):
        matrix = turned(*random.uniform(0.0, 360.0, 3), at=random.uniform(LOW, HIGH))
        add_lamp(
            f"Lamp {index}", kinds[index % len(kinds)], None, matrix, INTENSITY / FILLED, 0.3 + 0.7 * random.random(3)
        )


def balls(size: int, count: int) -> None:
    """A stage with one lamp that is the union of ``count`` balls."""
    simple_scenes.boxes_and_sphere(size)
    random = np.random.default_rng(4)
    radius = (FILLED / count * 0.75 / math.pi) ** (1.0 / 3.0)
    places = random.uniform(-1.0, 1.0, (count, 3))
    balls = ", ".join(f"translate(sphere({radius:.4g}), {x:.3g}, {y:.3g}, {z:.3g})" for x, y, z in places)
    add_lamp("Lamp", f"union({balls})" if count > 1 else balls, None, turned(at=(0.0, 0.3, 1.7)), INTENSITY / FILLED)


def triangles(size: int, count: int) -> None:
    """A stage with one torus, and an additional ball of about ``count`` triangles on the floor. The picture is larger
    than the others: its samples must take longer than the variation of its start."""
    lamp_scenes.SCENES["S1"].build(4 * size)
    rings = max(round(math.sqrt(count / 4.0)), 3)
    ball = lamp_meshes.mesh("Ball", lamp_meshes.sphere(0.4, 2 * rings, rings))
    graph = Graph("Ball")
    add(
        "Ball",
        ball,
        graph.finish(graph.node("ShaderNodeBsdfDiffuse", Color=(0.6, 0.6, 0.6))),
        location=(-0.9, -1.8, 0.4),
    )


def resolution(_, count: int) -> None:
    """A stage with one torus, in a picture of ``count`` pixels to a side."""
    lamp_scenes.SCENES["S1"].build(count)


CURVES = {  # the function that makes the scene, the numbers, and the two of them whose times are compared
    "lamps": (lamps, (1, 10, 100, 1000), (1000, 10)),
    "parts": (balls, (1, 10, 100), (100, 10)),
    "triangles": (triangles, (1_000, 30_000, 1_000_000, 10_000_000), (1_000_000, 1_000)),
    "resolution": (resolution, (48, 96, 192), (192, 48)),
}
QUICK = 1_000_000  # of anything, at most, in the quick form
BRIEF = dict(curves=["lamps"])


def arguments(parser) -> None:
    parser.add_argument(
        "--curves", type=some_of(CURVES), default=",".join(CURVES), help=f"of {', '.join(CURVES)}, with commas between"
    )
    parser.add_argument("--sampler", choices=samplers.SAMPLERS, default="CUT")


def _variance(renders: list[pictures.Picture]) -> float:
    """Relative squared error of a render, from several with different seeds."""
    pixels = np.array([picture.pixels for picture in renders])
    return errors.rel_variance(pixels.var(axis=0, ddof=1), pixels.mean(axis=0))


def measure(build, count: int, size: int, repeats: int, options) -> dict:
    """For a scene: ``start``, seconds before the first sample; ``each``, seconds of a sample of the whole picture;
    ``errors`` for each number in ``LADDER``; ``made_by``, the device."""
    build(size, count)
    scene = bpy.context.scene
    lamp_scenes.show(volumes=False)
    feedback = host.program("blender.feedback")

    def render(samples: int, seed: int) -> pictures.Picture:
        simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, options.device)
        scene.sdf_lights.seed = seed
        scene.sdf_lights.lamp_sampling = samplers.register(options.sampler, host.program().__name__).value
        return pictures.render()

    def seconds(made: list[pictures.Picture]) -> float:
        if feedback.made_by(scene.name).startswith("GPU") and "llvmpipe" not in feedback.made_by(scene.name):
            return statistics.median(picture.seconds for picture in made)
        return statistics.median(picture.work for picture in made) / machine.cores()

    render(1, 0)  # compiles, and fills caches
    first = seconds([render(1, seed) for seed in range(repeats)])
    found = []
    for samples in LADDER:
        made = [render(samples, seed) for seed in range(repeats)]
        found.append(_variance(made))
    each = max((seconds(made) - first) / (LADDER[-1] - 1), 1e-9)
    return dict(start=first - each, each=each, errors=found, made_by=feedback.made_by(scene.name))


def run(options) -> tuple[dict, list[dict]]:
    size = 48 if options.quick else 96
    repeats = max(options.repeats or (2 if options.quick else 5), 2)
    names = options.curves
    progress, parts = Progress(sum(len(CURVES[name][1]) for name in names)), Parts(options)
    summary, rows = {}, []
    for name in names:
        build, counts, (most, few) = CURVES[name]
        counts = [count for count in counts if count <= QUICK or not options.quick]
        found = {}
        for count in counts:
            progress.show(f"{count} {name}")
            found[count] = parts.of(f"{count} {name}", functools.partial(measure, build, count, size, repeats, options))
            progress.step()
        # An error that all reach without much extrapolation.
        level = math.exp(statistics.fmean(math.log(error) for one in found.values() for error in one["errors"][-2:]))
        times = {}
        for count, one in found.items():
            samples = errors.interpolated(list(zip(one["errors"], LADDER)), level)
            times[count] = samples * one["each"]
            rows.append(
                dict(
                    curve=name,
                    count=count,
                    made_by=one["made_by"],
                    rel_mse=level,
                    samples=samples,
                    seconds=times[count],
                    each=one["each"],
                    start=one["start"],
                )
                | {f"rel_mse_{n}": error for n, error in zip(LADDER, one["errors"])}
            )
        summary[f"time_ratio_{most}_to_{few}_{name}"] = times[most] / times[few]
    parts.finish()
    progress.close()
    return summary, rows
