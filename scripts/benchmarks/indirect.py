# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gain of light paths: error × time without them, over that with the automatic choice, in rooms that lamps light by
way of walls and in scenes where they should not be used.

As in ``allocation``, the error is the variance of renders with different seeds, and both variants take turns. The time
is the processor time of a whole render, with all that light paths need before the first sample.
"""

from __future__ import annotations

import statistics

import numpy as np

from . import (
    allocation,
    beside_cycles,
    errors,
    indirect_rooms,
    pictures,
    simple_scenes,
    some_of,
)
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "the gain of light paths in rooms that lamps light by way of walls, and what they lose elsewhere"

ROOMS = tuple(indirect_rooms.ROOMS)
STAGES = ("S1", "S4", "S5", "room")
ORDINARY = ("living_room_night", "street")
SCENES = (*ROOMS, *STAGES, *ORDINARY)
QUICK = (*ROOMS, "S4", "street")
BOUNCES = 4  # of scenes of lamps
SIZE, QUICK_SIZE = 128, 64
SAMPLES, QUICK_SAMPLES = 32, 16
SEEDS, QUICK_SEEDS = 8, 3
WITHOUT, AUTOMATIC = "NEVER", "AUTOMATIC"  # values of ``scene.sdf_lights.lamp_paths``


def arguments(parser) -> None:
    parser.add_argument(
        "--rooms", type=some_of(SCENES), metavar="SCENES", help=f"with commas between: {', '.join(SCENES)}"
    )


def _render(name: str, scene, variant: str, samples: int, seed: int, device: str) -> pictures.Picture:
    if name in ORDINARY:
        beside_cycles.settings(scene, beside_cycles.GUIDED, samples, seed, device)
    else:
        simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, device)
        scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = 0, True
        scene.sdf_lights.seed = seed
    scene.sdf_lights.lamp_paths = variant
    return pictures.render()


def measure(name: str, options) -> dict:
    """The row of a scene."""
    build = indirect_rooms.build if name in ROOMS else allocation.build
    scene = build(name, QUICK_SIZE if options.quick else SIZE)
    samples = QUICK_SAMPLES if options.quick else SAMPLES
    seeds = max(options.repeats or (QUICK_SEEDS if options.quick else SEEDS), 2)
    for variant in (WITHOUT, AUTOMATIC):
        _render(name, scene, variant, 2, 0, options.device)  # compiles, and fills caches
    made = in_turns(
        (WITHOUT, AUTOMATIC),
        range(seeds),
        lambda variant, seed: _render(name, scene, variant, samples, seed, options.device),
    )
    return dict(indirect_scene=name, samples=samples) | row_of(
        {variant: stack_of(pile) for variant, pile in made.items()},
        {variant: work_of(pile) for variant, pile in made.items()},
    )


def row_of(stacks: dict[str, np.ndarray], work: dict[str, float]) -> dict:
    """Figures of pictures (seeds, height, width, channels) and seconds of both variants.

    ``gain`` and ``gain_of_most``: see ``allocation.gains_of``. ``time``: with over without. ``percentile``, ``worst``:
    the 99.9th percentile and the greatest of the errors of pixels, with over without.
    ``deviation``: of the means, in standard errors. ``used``: whether the choice has changed anything.
    """
    names = {WITHOUT: "without", AUTOMATIC: allocation.ALL}
    gains = allocation.gains_of(
        {names[variant]: stack for variant, stack in stacks.items()}, {names[v]: seconds for v, seconds in work.items()}
    )["without"]
    mean = np.mean([stack.mean(axis=0) for stack in stacks.values()], axis=0)
    ends = {
        variant: np.mean([errors.pixel_errors(picture, mean) for picture in stack], axis=0)
        for variant, stack in stacks.items()
    }
    whole = {variant: stack.mean(axis=(1, 2, 3)) for variant, stack in stacks.items()}
    error = np.sqrt(sum(each.var(ddof=1) / len(each) for each in whole.values()))
    percentile, worst = ends[AUTOMATIC] / np.maximum(ends[WITHOUT], 1e-300)
    used = not np.array_equal(stacks[WITHOUT], stacks[AUTOMATIC])
    difference = whole[AUTOMATIC].mean() - whole[WITHOUT].mean()
    return dict(
        gain=gains["gain"],
        gain_of_most=gains["gain_of_most"],
        time=1.0 / gains["time"],
        percentile=float(percentile),
        worst=float(worst),
        deviation=float(difference / error) if used else 0.0,
        used=used,
    )


def summary_of(rows: list[dict]) -> dict:
    """``rooms_gain_min`` and ``…_geomean``: of rooms. ``loss_max``: the greatest error × time with the automatic choice
    over that without light paths, of all scenes. ``used_elsewhere``: in how many other scenes light paths are used."""
    rooms = [row["gain"] for row in rows if row["indirect_scene"] in ROOMS]
    summary = dict(loss_max=max(1.0 / row["gain"] for row in rows))
    summary["used_elsewhere"] = sum(row["used"] for row in rows if row["indirect_scene"] not in ROOMS)
    if rooms:
        summary |= dict(rooms_gain_min=min(rooms), rooms_gain_geomean=statistics.geometric_mean(rooms))
    return summary


def run(options) -> tuple[dict, list[dict]]:
    names = options.rooms or list(QUICK if options.quick else SCENES)
    rows = in_parts(names, lambda name: measure(name, options), options)
    return summary_of(rows), rows
