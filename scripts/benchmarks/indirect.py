# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gain of light paths and path reuse: error × time without both, over that with the automatic choice, in rooms that
lamps and lights light by way of walls and in scenes where they should not be used. And error × time of Cycles and of
the paper's sampler over ours: see ``indirect_rivals``.

As in ``allocation``, the error is the variance of renders with different seeds, and both variants take turns. The time
is the processor time of a whole render, with all that is needed before the first sample.
"""

from __future__ import annotations

import math
import statistics

import host
import numpy as np

from . import (
    allocation,
    beside_cycles,
    errors,
    indirect_rivals,
    indirect_rooms,
    lamp_scenes,
    pictures,
    simple_scenes,
    some_of,
)
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "the gain of light paths and path reuse in rooms that are lit by way of walls, and what they lose elsewhere"

ROOMS, LIGHTS, THINGS = tuple(indirect_rooms.ROOMS), tuple(indirect_rooms.LIGHTS), tuple(indirect_rooms.THINGS)
STAGES = (*lamp_scenes.THE_FIVE, "room")
INTERIORS = indirect_rivals.INTERIORS
ORDINARY = (*INTERIORS, "street")
SCENES = (*ROOMS, *LIGHTS, *THINGS, *STAGES, *ORDINARY)
QUICK = ("cove", "sign", "S1", "S2", "S4", "kitchen")  # each summary has one, in two minutes
BOUNCES = 4  # of scenes of lamps
SIZE, QUICK_SIZE = 128, 80
SAMPLES = 32
LIGHTS_SAMPLES = 64  # without SDF lamps, shorter renders do not try light paths
INTERIORS_SIZE = 128  # smaller renders would mostly measure what comes before the first sample
SEEDS, QUICK_SEEDS = 8, 2
# A few pixels of glass hold a third of the error of the kitchen, and rare bright samples much of that of the demo room.
# Eight seeds tell such figures within a fifth.
MORE_SEEDS = {"kitchen": 32, "demo_points": 24}
BRANCHES = 4  # of each path, where all pixels have equally many
TRUTH = 16  # times as many samples, of as many seeds, tell the errors of denoised pictures
DOCUMENT = host.REPOSITORY / "docs" / "sampling.md"
BEGIN, END = "<!-- indirect -->", "<!-- end of indirect -->"
COLUMNS = dict(
    gain="without both",
    paper="the paper's sampler",
    cycles="Cycles",
    cycles_guided="Cycles, path guiding",
    percentile="99.9th percentile",
    worst="greatest",
    flicker="flicker",
    flicker_of_blocks="flicker of blocks",
)
BLOCK = 16  # pixels across that two groups of path reuse have together
# Values of ``scene.sdf_lights.lamp_paths`` and ``path_reuse``.
WITHOUT, AUTOMATIC = "NEVER", "AUTOMATIC"


def arguments(parser) -> None:
    parser.add_argument("--document-indirect", action="store_true", help="write the table of docs/sampling.md")
    parser.add_argument(
        "--rooms", type=some_of(SCENES), metavar="SCENES", help=f"with commas between: {', '.join(SCENES)}"
    )
    parser.add_argument("--even", action="store_true", help=f"all pixels have as many samples, and {BRANCHES} branches")
    parser.add_argument("--denoised", action="store_true", help="compare denoised pictures of rooms with Cycles', too")
    parser.add_argument("--no-rivals", dest="rivals", action="store_false", help="compare only with and without both")


def _render(
    name: str,
    scene,
    variant: str,
    samples: int,
    seed: int,
    device: str,
    reuse: str = "",
    denoise: bool = False,
    even: bool = False,
) -> pictures.Picture:
    if name in ORDINARY:
        beside_cycles.settings(scene, beside_cycles.GUIDED, samples, seed, device)
    else:
        simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, device)
        scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = 0, True
        scene.sdf_lights.seed = seed
    scene.sdf_lights.lamp_paths, scene.sdf_lights.path_reuse = variant, reuse or variant
    scene.sdf_lights.denoise = denoise
    if even:
        scene.sdf_lights.indirect_paths, scene.sdf_lights.guided_samples = BRANCHES, False
    return pictures.render()


def measure(name: str, options) -> dict:
    """The row of a scene."""
    build = indirect_rivals.build_interior if name in INTERIORS else allocation.build
    size = INTERIORS_SIZE if name in INTERIORS else QUICK_SIZE if options.quick else SIZE
    scene = (indirect_rooms.build if name in (*ROOMS, *LIGHTS, *THINGS) else build)(name, size)
    samples = LIGHTS_SAMPLES if name in (*LIGHTS, *THINGS, *INTERIORS) else SAMPLES
    seeds = max(options.repeats or (QUICK_SEEDS if options.quick else MORE_SEEDS.get(name, SEEDS)), 2)
    for variant in (WITHOUT, AUTOMATIC):
        # Compiles, and fills caches. On the GPU, a program with light paths needs as many samples as tell of them.
        _render(name, scene, variant, samples if options.device == "GPU" else 2, 0, options.device)
    made = in_turns(
        (WITHOUT, AUTOMATIC),
        range(seeds),
        lambda variant, seed: _render(name, scene, variant, samples, seed, options.device, even=options.even),
    )
    row = dict(indirect_scene=name, samples=samples) | row_of(
        {variant: stack_of(pile) for variant, pile in made.items()},
        {variant: work_of(pile) for variant, pile in made.items()},
    )
    if row["used"] and not options.quick:
        row["chosen"] = "both"
        for only, variant, reuse in (("light paths", AUTOMATIC, WITHOUT), ("path reuse", WITHOUT, AUTOMATIC)):
            alone = _render(name, scene, variant, samples, 0, options.device, reuse=reuse, even=options.even)
            if np.array_equal(alone.pixels, made[AUTOMATIC][0].pixels):
                row["chosen"] = only
                break
    if options.denoised and name in ROOMS:
        row["denoised"] = _denoised(name, scene, samples, seeds, options.device)
    rivals = _rivals(name, options.device) if options.rivals else {}
    return row | {key: indirect_rivals.ratio(rival, made[AUTOMATIC], seeds) for key, rival in rivals.items()}


def _denoised(name: str, scene, samples: int, seeds: int, device: str) -> float:
    """The mean square relative error of Cycles' pictures over that of ours, both denoised by OpenImageDenoise, in the
    time that ours take. Denoised pictures have a bias, so many more of our samples tell the error."""
    truth = stack_of(
        [_render(name, scene, AUTOMATIC, TRUTH * samples, seeds + seed, device) for seed in range(seeds)]
    ).mean(axis=0)
    ours = [_render(name, scene, AUTOMATIC, samples, seed, device, denoise=True) for seed in range(-1, seeds)][1:]
    rival = indirect_rivals.by_cycles(BOUNCES, surfaces=True, denoise=True)
    cycles = rival.pictures(statistics.median(picture.work for picture in ours), seeds)
    found = [np.mean([errors.rel_mse(each.pixels, truth) for each in pile]) for pile in (cycles, ours)]
    return float(found[0] / found[1])


def _rivals(name: str, device: str) -> dict[str, indirect_rivals.Rival]:
    """The rivals in a scene, by the key of the row."""
    if name in ROOMS:
        return dict(
            cycles=indirect_rivals.by_cycles(BOUNCES, surfaces=True),
            cycles_guided=indirect_rivals.by_cycles(BOUNCES, surfaces=True, guiding=True),
        )
    if name in (*LIGHTS, *THINGS):
        return dict(cycles=indirect_rivals.by_cycles(BOUNCES))
    if name in lamp_scenes.THE_FIVE:
        return dict(cycles=indirect_rivals.by_cycles(BOUNCES), paper=indirect_rivals.by_paper(BOUNCES, device))
    return dict(cycles=indirect_rivals.by_cycles_defaults(device)) if name in INTERIORS else {}


def row_of(stacks: dict[str, np.ndarray], work: dict[str, float]) -> dict:
    """Figures of pictures (seeds, height, width, channels) and seconds of both variants.

    ``gain`` and ``gain_of_most``: see ``allocation.gains_of``. ``time``: with over without. ``percentile``, ``worst``:
    the 99.9th percentile and the greatest of the errors of pixels, with over without, and ``…_error``, the standard
    errors of these ratios of means over the seeds. ``flicker`` and
    ``flicker_of_blocks``: see ``flicker_of``, with over without; blocks are ``BLOCK`` pixels wide.
    ``change_of_blocks``: that of blocks itself, with both.
    ``difference``: of the means, as a part of the picture; ``deviation``: the same in standard errors. ``used``:
    whether the choice has changed anything.
    """
    names = {WITHOUT: "without", AUTOMATIC: allocation.ALL}
    gains = allocation.gains_of(
        {names[variant]: stack for variant, stack in stacks.items()}, {names[v]: seconds for v, seconds in work.items()}
    )["without"]
    mean = np.mean([stack.mean(axis=0) for stack in stacks.values()], axis=0)
    ends = {
        variant: np.array([errors.pixel_errors(picture, mean) for picture in stack])
        for variant, stack in stacks.items()
    }
    flicker, of_blocks = ([flicker_of(stacks[each], size) for each in (AUTOMATIC, WITHOUT)] for size in (1, BLOCK))
    whole = {variant: stack.mean(axis=(1, 2, 3)) for variant, stack in stacks.items()}
    error = np.sqrt(sum(each.var(ddof=1) / len(each) for each in whole.values()))
    (percentile, worst), (percentile_error, worst_error) = _ratio(ends[AUTOMATIC], ends[WITHOUT])
    used = not np.array_equal(stacks[WITHOUT], stacks[AUTOMATIC])
    difference = whole[AUTOMATIC].mean() - whole[WITHOUT].mean()
    return dict(
        gain=gains["gain"],
        gain_of_most=gains["gain_of_most"],
        time=1.0 / gains["time"],
        percentile=float(percentile),
        worst=float(worst),
        percentile_error=float(percentile_error),
        worst_error=float(worst_error),
        flicker=flicker[0] / max(flicker[1], 1e-300),
        flicker_of_blocks=of_blocks[0] / max(of_blocks[1], 1e-300),
        change_of_blocks=of_blocks[0],
        difference=float(difference / whole[WITHOUT].mean()),
        deviation=float(difference / error) if used else 0.0,
        used=used,
    )


def _ratio(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ratios of the means of columns (n, k), and their standard errors."""
    ratio = a.mean(axis=0) / np.maximum(b.mean(axis=0), 1e-300)
    parts = [x.var(axis=0, ddof=1) / (len(x) * np.maximum(x.mean(axis=0), 1e-300) ** 2) for x in (a, b)]
    return ratio, ratio * np.sqrt(parts[0] + parts[1])


def flicker_of(frames: np.ndarray, size: int) -> float:
    """The root mean square of the relative change from one frame to the next, of means of blocks of ``size`` pixels.
    ``frames`` (n, height, width, channels) have different seeds, as those of a film."""
    count, height, width, channels = frames.shape
    rows, columns = max(height // size, 1), max(width // size, 1)
    whole = frames[:, : rows * size, : columns * size]
    blocks = whole.reshape(count, rows, min(size, height), columns, min(size, width), channels).mean(axis=(2, 4))
    mean = blocks.mean(axis=0)
    return math.sqrt(np.mean([errors.rel_mse(each, mean) for each in np.diff(blocks, axis=0) + mean]))


def summary_of(rows: list[dict]) -> dict:
    """``rooms_gain_min`` and ``…_geomean``: of rooms with lamps. ``lights_gain_min``: of those that other lights light
    by way of walls. ``loss_max``: the greatest error × time with the automatic choice over that without both, of all
    scenes. ``used_elsewhere``: in how many other scenes one of them is used.

    Error × time over ours: ``mse_ratio_cycles_bounces_…`` of Cycles' emission volumes and ``mse_ratio_paper_bounces_…``
    of the paper's sampler in S1 to S5, ``rooms_ratio_cycles_min`` of Cycles' mesh lights in rooms, the better one of
    path guiding and none, ``interiors_ratio_cycles_…`` in rooms without SDF lamps. ``rooms_ratio_denoised_min``: error
    at equal time of denoised pictures in rooms, of Cycles over ours.
    """
    rooms = [row["gain"] for row in rows if row["indirect_scene"] in ROOMS]
    summary = dict(loss_max=max(1.0 / row["gain"] for row in rows))
    summary["used_elsewhere"] = sum(
        row["used"] for row in rows if row["indirect_scene"] not in (*ROOMS, *LIGHTS, *THINGS)
    )
    if rooms:
        summary |= dict(rooms_gain_min=min(rooms), rooms_gain_geomean=statistics.geometric_mean(rooms))
    lights = [row["gain"] for row in rows if row["indirect_scene"] in LIGHTS]
    if lights:
        summary["lights_gain_min"] = min(lights)
    for title, names, key in (
        ("mse_ratio_cycles_bounces", lamp_scenes.THE_FIVE, "cycles"),
        ("mse_ratio_paper_bounces", lamp_scenes.THE_FIVE, "paper"),
        ("interiors_ratio_cycles", INTERIORS, "cycles"),
    ):
        found = [row[key] for row in rows if row["indirect_scene"] in names and key in row]
        if found:
            summary |= {f"{title}_geomean": statistics.geometric_mean(found), f"{title}_min": min(found)}
    denoised = [row["denoised"] for row in rows if "denoised" in row]
    if denoised:
        summary["rooms_ratio_denoised_min"] = min(denoised)
    cycles = [min(row["cycles"], row["cycles_guided"]) for row in rows if "cycles_guided" in row]
    return summary | (dict(rooms_ratio_cycles_min=min(cycles)) if cycles else {})


def document(rows: list[dict]) -> None:
    """Write these rows into the table of docs/sampling.md; the rows of other scenes stay."""
    before, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    table, _, after = rest.partition(END)
    lines = {}
    for line in table.strip().splitlines()[2:]:  # a row that is older may have fewer columns
        missing = len(COLUMNS) + 3 - line.count("|")
        lines[line.split(" | ")[0].removeprefix("| ")] = line + "  |" * missing
    for row in rows:
        cells = (_cell(row, key) for key in COLUMNS)
        chosen = row.get("chosen", "" if row["used"] else "neither")
        lines[row["indirect_scene"]] = f"| {row['indirect_scene']} | {chosen} | {' | '.join(cells)} |"
    head = [f"| scene | chosen | {' | '.join(COLUMNS.values())} |", "|---" * (len(COLUMNS) + 2) + "|"]
    body = [lines[name] for name in SCENES if name in lines]
    DOCUMENT.write_text("\n".join([before + BEGIN, *head, *body, END]) + after, encoding="utf-8")


def _cell(row: dict, key: str) -> str:
    """A figure of the table, with its standard error if the row has one."""
    if key not in row:
        return ""
    error = f" ± {row[key + '_error']:.2f}" if key + "_error" in row else ""
    return f"{row[key]:.{0 if row[key] >= 10.0 else 2}f}{error}"


def run(options) -> tuple[dict, list[dict]]:
    names = options.rooms or list(QUICK if options.quick else SCENES)
    rows = in_parts(names, lambda name: measure(name, options), options)
    if options.document_indirect:
        document(rows)
    return summary_of(rows), rows
