# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples a second, against Cycles in the same process, and what a render costs before its first sample.

Boxes and a glossy sphere lit by one point light, direct light only and with four bounces. The engines take turns; a
rate is the number of further samples over the further time of a long render against a short one, so that no engine's
start-up counts; medians of all turns. With ``--device gpu`` the GPU is compared with the CPU on the lamp scenes, too.
"""

from __future__ import annotations

import statistics

import bpy

from . import lamp_scenes, pictures, scenes, startup

HELP = "samples a second against Cycles in the same process, and start-up"

ENGINES = ("SDF Lights", "Cycles")
BOUNCES = (0, 4)
LAMP_SCENES = ("S1", "S2", "S3", "S4", "S5")


def _prepare(name: str, scene, samples: int, bounces: int, device: str) -> None:
    if name == "Cycles":
        scenes.plain_cycles(scene, samples, bounces)
    else:
        scenes.plain_sdf_lights(scene, samples, bounces, device)


def rates(options) -> tuple[dict, list[dict]]:
    size = 128 if options.quick else 256
    few, many = (1, 9) if options.quick else (8, 136)
    if options.device == "REFERENCE":
        size, few, many = 64, 1, 3
    repeats = options.repeats or (1 if options.quick else 5)
    scene = scenes.boxes_and_sphere(size)
    scenes.add_point_light()
    rows, summary = [], {}
    for bounces in BOUNCES:
        seconds = {(name, samples): [] for name in ENGINES for samples in (few, many)}
        means = {}
        for turn in range(repeats + 1):
            for name in ENGINES:
                for samples in (few, many):
                    _prepare(name, scene, samples, bounces, options.device)
                    picture = pictures.render()
                    if turn:  # the first turn compiles and fills caches
                        seconds[name, samples].append(picture.seconds)
                    means[name] = float(picture.pixels.mean())
        rate = {}
        for name in ENGINES:
            differences = [long - short for short, long in zip(seconds[name, few], seconds[name, many])]
            rate[name] = size * size * (many - few) / max(statistics.median(differences), 1e-9)
            rows.append(
                dict(
                    engine=name,
                    bounces=bounces,
                    samples=many - few,
                    pixels=size * size,
                    repeats=repeats,
                    samples_per_second=rate[name],
                    fastest=size * size * (many - few) / max(min(differences), 1e-9),
                    slowest=size * size * (many - few) / max(max(differences), 1e-9),
                    mean=means[name],
                )
            )
        key = "direct" if bounces == 0 else f"{bounces}_bounces"
        summary[f"samples_per_second_{key}"] = rate["SDF Lights"]
        summary[f"samples_per_second_ratio_to_cycles_{key}"] = rate["SDF Lights"] / rate["Cycles"]
    # The claim is about both, so the smaller of the two ratios stands for them.
    summary["samples_per_second_ratio_to_cycles"] = min(
        value for name, value in summary.items() if name.startswith("samples_per_second_ratio_to_cycles_")
    )
    return summary, rows


def against_cpu(options) -> tuple[dict, list[dict]]:
    """Samples a second of the GPU and of the CPU on the lamp scenes, direct light, each by its own default sampling."""
    size = 128 if options.quick else 256
    few, many = (1, 5) if options.quick else (4, 36)
    repeats = options.repeats or (1 if options.quick else 3)
    rows, ratios = [], []
    for name in LAMP_SCENES[:1] if options.quick else LAMP_SCENES:
        lamp_scenes.SCENES[name].build(size)
        lamp_scenes.show(volumes=False)
        scene = bpy.context.scene
        seconds = {(device, samples): [] for device in ("CPU", "GPU") for samples in (few, many)}
        for turn in range(repeats + 1):
            for device, samples in seconds:
                scenes.plain_sdf_lights(scene, samples, 0, device)
                picture = pictures.render()
                if turn:  # the first turn compiles
                    seconds[device, samples].append(picture.seconds)
        rate = {}
        for device in ("CPU", "GPU"):
            differences = [long - short for short, long in zip(seconds[device, few], seconds[device, many])]
            rate[device] = size * size * (many - few) / max(statistics.median(differences), 1e-9)
        ratios.append(rate["GPU"] / rate["CPU"])
        rows.append(dict(scene=name, samples=many - few, pixels=size * size, repeats=repeats,
                         cpu_samples_per_second=rate["CPU"], gpu_samples_per_second=rate["GPU"], ratio=ratios[-1]))
    return dict(gpu_to_cpu_samples_ratio=statistics.geometric_mean(ratios),
                gpu_to_cpu_samples_ratio_min=min(ratios)), rows


def run(options) -> tuple[dict, list[dict]]:
    summary, rows = rates(options)
    if options.device == "GPU":
        found, added = against_cpu(options)
        summary |= found
        rows += added
    more, further = startup.run(options)
    return summary | more, rows + further
