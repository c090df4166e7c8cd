# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples a second, compared with Cycles in the same process, and the cost of a CPU render before its first sample.

Boxes and a glossy sphere lit by one point light, with direct light only and with four bounces, and then all with a
Principled BSDF, which tells what that costs. The engines take turns.
A rate is the additional samples of a long render over its additional time, compared with a short one, so that no
engine's start-up counts; medians of all turns. With ``--device gpu`` the CPU takes turns, too, and so does Cycles on
the graphics card, if there is one. All of them then render the lamp scenes, where GPU and CPU have the same settings:
paths that neither split nor have light paths, the same number of samples in every pixel, lamps by cuts, the default of
both, and in another turn by projection with MIS.
"""

from __future__ import annotations

import functools
import os
import statistics

import bpy

from sdf_lights.render.settings import LampSampling

from . import gpu_parts, lamp_scenes, pictures, programs, simple_scenes, some_of, startup, turns
from .progress import Progress
from .resume import Parts

HELP = "samples a second against Cycles in the same process, and start-up"


def arguments(parser) -> None:
    startup.arguments(parser)
    parser.add_argument("--size", type=int, help="pixels along a side (default: 256; lamp scenes 128)")
    parser.add_argument("--only", help="lamp scenes, separated by commas (default: all)")
    parser.add_argument(
        "--cards",
        type=some_of(simple_scenes.CYCLES_ON_CARDS),
        help="back ends of Cycles for graphics cards, separated by commas (default: all that find a card)",
    )
    programs.processes_argument(parser)


PLAIN, PRINCIPLED = "diffuse and glossy", "Principled"
ENGINES = ("SDF Lights", "Cycles")
ON_CPU = "SDF Lights on the CPU"  # takes turns, too, if the device is the GPU
BY_PROJECTION = "SDF Lights, by projection", "SDF Lights on the CPU, by projection"
ON_CARD = "Cycles on the graphics card, "  # and its back end
SECONDS = 0.5  # that additional samples take at least
CASES = ((0, PLAIN), (4, PLAIN), (4, PRINCIPLED))  # bounces and surfaces
LAMP_SCENES = (*lamp_scenes.THE_FIVE, "blob")  # the last has no closed form
BRIEF = dict(repeats=1)


def _cards(options) -> list[str]:
    return [kind for kind in simple_scenes.cycles_cards() if not options.cards or kind in options.cards]


def _engines(options) -> tuple[str, ...]:
    if options.device != "GPU":
        return ENGINES
    return (*ENGINES, ON_CPU, *(f"{ON_CARD}{kind}" for kind in _cards(options)))


def _prepare(name: str, scene, samples: int, bounces: int, device: str) -> None:
    if name.startswith("Cycles"):
        simple_scenes.plain_cycles(scene, samples, bounces, name.removeprefix(ON_CARD) if ON_CARD in name else "CPU")
    else:
        simple_scenes.plain_sdf_lights(scene, samples, bounces, "CPU" if name in (ON_CPU, BY_PROJECTION[1]) else device)
        # They make samples fewer and better.
        scene.sdf_lights.lamp_paths = scene.sdf_lights.path_reuse = "NEVER"
        scene.sdf_lights.caustic_paths = "NEVER"
        sampling = LampSampling.MIS if name in BY_PROJECTION else LampSampling.CUT
        scene.sdf_lights.lamp_sampling = sampling.value


def _lamp_scenes(options) -> list[str]:
    names = options.only.split(",") if options.only else list(LAMP_SCENES)
    return names[:1] if options.quick else names


def _seconds(options) -> float:
    return 0.0 if options.device == "REFERENCE" or options.quick else SECONDS


def measure(bounces: int, surfaces: str, options) -> list[dict]:
    """A row for each engine; they take turns."""
    size = options.size or (128 if options.quick else 256)
    few, many = (1, 33) if options.quick else (8, 136)
    repeats = 3 if options.quick else 5
    if options.device == "REFERENCE":
        size, few, many, repeats = options.size or 64, 1, 3, 1 if options.quick else 5
    repeats = options.repeats or repeats
    scene = simple_scenes.boxes_and_sphere(size)
    simple_scenes.add_point_light()
    if surfaces == PRINCIPLED:
        simple_scenes.make_principled()
    engines = _engines(options)

    def render(engine: str, samples: int) -> pictures.Picture:
        _prepare(engine, scene, samples, bounces, options.device)
        return pictures.render()

    found = turns.rates(engines, few, many, repeats, render, _seconds(options))
    rows = [
        dict(
            engine=name,
            bounces=bounces,
            surfaces=surfaces,
            samples=rate.samples,
            pixels=size * size,
            repeats=repeats,
            samples_per_second=rate.per_second(size * size),
            fastest=rate.per_second(size * size, min),
            slowest=rate.per_second(size * size, max),
            mean=rate.mean,
            first_render_seconds=rate.first,
        )
        for name, rate in found.items()
    ]
    if options.device == "GPU":
        rows[0] |= gpu_parts.seconds(lambda: render(engines[0], few + found[engines[0]].samples))
    return rows


def rates(options, parts: Parts, progress: Progress) -> tuple[dict, list[dict]]:
    rows, summary, plain = [], {}, ()
    for bounces, surfaces in CASES:
        name = f"{bounces} bounces, {surfaces}"
        progress.show(name)
        found = parts.of(name, functools.partial(measure, bounces, surfaces, options))
        speeds = ours, theirs = [row["samples_per_second"] for row in found[:2]]
        rows += found
        if surfaces == PRINCIPLED:
            summary["principled_samples_per_second_ratio_to_cycles"] = ours / theirs
            summary["principled_cost"], summary["principled_cost_cycles"] = (
                before / speed for before, speed in zip(plain, speeds)
            )
        else:
            key = "direct" if bounces == 0 else f"{bounces}_bounces"
            summary[f"samples_per_second_{key}"] = ours
            summary[f"samples_per_second_ratio_to_cycles_{key}"] = ours / theirs
            plain = speeds
        progress.step()
    # The claim is about both, so the smaller of the two ratios is used.
    summary["samples_per_second_ratio_to_cycles"] = min(
        value for name, value in summary.items() if name.startswith("samples_per_second_ratio_to_cycles_")
    )
    return summary, rows


def on_lamp_scene(name: str, options) -> dict:
    """Samples a second of the GPU, of Cycles, for which lamps are volumes, and of the CPU: direct light, with the same
    estimators on GPU and CPU: cuts, and projection with MIS."""
    size = options.size or 128
    few, many = (1, 5) if options.quick else (4, 36)
    repeats = options.repeats or (1 if options.quick else 5)
    engines, cards = (*_engines(options), *BY_PROJECTION), _cards(options)
    lamp_scenes.SCENES[name].build(size)

    def render(engine: str, samples: int) -> pictures.Picture:
        lamp_scenes.show(volumes=engine.startswith("Cycles"))
        _prepare(engine, bpy.context.scene, samples, 0, options.device)
        return pictures.render()

    found = turns.rates(engines, few, many, repeats, render, _seconds(options))
    rate = [each.per_second(size * size) for each in found.values()]
    gpu, cycles, cpu = rate[: len(engines) - len(cards) - 2]
    gpu_by_projection, cpu_by_projection = rate[-2:]
    return dict(
        scene=name,
        samples=found[engines[0]].samples,
        pixels=size * size,
        repeats=repeats,
        gpu_samples_per_second=gpu,
        cycles_samples_per_second=cycles,
        cpu_samples_per_second=cpu,
        gpu_samples_per_second_by_projection=gpu_by_projection,
        cpu_samples_per_second_by_projection=cpu_by_projection,
        **{f"cycles_{kind.lower()}_samples_per_second": speed for kind, speed in zip(cards, rate[3:-2])},
        ratio=gpu / cpu,
        ratio_by_projection=gpu_by_projection / cpu_by_projection,
        mean_gpu=found[engines[0]].mean,
        mean_cpu=found[ON_CPU].mean,
        gpu_first_render_seconds=found[engines[0]].first,
        **gpu_parts.seconds(lambda: render(engines[0], few + found[engines[0]].samples)),
    )


def on_lamp_scenes(options, parts: Parts, progress: Progress) -> tuple[dict, list[dict]]:
    rows = []
    for name in _lamp_scenes(options):
        progress.show(name)
        rows.append(parts.of(name, functools.partial(on_lamp_scene, name, options)))
        progress.step()
    ratios = [row["ratio"] for row in rows]
    return dict(
        gpu_to_cpu_samples_ratio=statistics.geometric_mean(ratios),
        gpu_to_cpu_samples_ratio_min=min(ratios),
        gpu_to_cpu_samples_ratio_by_projection=statistics.geometric_mean(row["ratio_by_projection"] for row in rows),
    ), rows


def run(options) -> tuple[dict, list[dict]]:
    on_gpu = options.device == "GPU"
    with_startup = not on_gpu and options.name != "all"  # which runs ``startup`` by itself
    steps = 1 + len(_lamp_scenes(options)) if on_gpu else 1 + startup.turns(options) if with_startup else 0
    progress = Progress(len(CASES) + steps)
    parts = Parts(options)
    if on_gpu:
        progress.show("the GPU's programs")
        cases = [case for name in _lamp_scenes(options) for case in programs.lamp_cases(name)[:2]]  # without bounces
        programs.fill_cache([*programs.PLAIN_CASES, *cases], options.processes or os.cpu_count() or 1)
        progress.step()
    summary, rows = rates(options, parts, progress)
    found, added = {}, []
    if on_gpu:
        found, added = on_lamp_scenes(options, parts, progress)
    elif with_startup:
        found, added = startup.measured(options, parts, progress)
    summary |= found
    rows += added
    parts.finish()
    progress.close()
    return summary, rows
