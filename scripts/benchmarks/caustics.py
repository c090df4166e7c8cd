# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics of lamps: error × time without caustic paths, over that with them. See "Caustics" in docs/sampling.md."""

from __future__ import annotations

import math
import pathlib
import statistics

import bpy
import numpy as np
from scenery.modelling import add, plane, turned

from . import errors, lamp_scenes, pictures, simple_scenes, some_of
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "what caustic paths gain, in scenes with mirrors and glass"
BRIEF = dict(caustics=["ball_large"])
DOCUMENT = pathlib.Path(__file__).resolve().parents[2] / "docs" / "sampling.md"
BEGIN, END = "<!-- caustics -->\n", "<!-- end of caustics -->"

BOUNCES = 8  # beyond the first surface
SIZE, QUICK_SIZE = 96, 64  # smaller renders try no caustic paths
SAMPLES, QUICK_SAMPLES = 64, 32
SEEDS, QUICK_SEEDS = 6, 3
MASK_SAMPLES = 16
EYE, TARGET, DEGREES = (0.0, -2.4, 1.8), (0.0, 0.0, 0.1), 40.0
AT = (0.9, -0.8, 1.9)  # of the lamp: on the side of the camera, so that this sees the caustics
# Values of ``scene.sdf_lights.caustic_paths``.
WITHOUT, AUTOMATIC, ALWAYS = "NEVER", "AUTOMATIC", "ALWAYS"
COLUMNS = dict(automatic="automatic", always="always on", noise_without="noise without, %", noise="noise, %")


def _glass():
    return simple_scenes.material("Glass", "ShaderNodeBsdfGlass", (1.0, 1.0, 1.0), roughness=0.0)


def _ball() -> None:
    angles = [math.pi * step / 64 for step in range(65)]
    profile = [(0.3 * math.sin(angle), -0.3 * math.cos(angle)) for angle in angles]
    add("Thing", turned("Thing", profile, 128), _glass(), location=(0.1, 0.1, 0.45))


def _ring(roughness: float = 0.0) -> None:
    metal = simple_scenes.material("Metal", "ShaderNodeBsdfAnisotropic", (0.9, 0.8, 0.6), roughness=roughness)
    add("Thing", turned("Thing", [(0.45, 0.0), (0.45, 0.4)], 256), metal, location=(0.0, 0.1, 0.01))


def _brushed() -> None:
    _ring(0.3)


def _water() -> None:
    """A round sheet with waves. Its rim is flat."""
    top = [(0.01 * step, 0.5 + 0.015 * math.cos(0.4 * step)) for step in range(81)]
    mesh = turned("Thing", [(0.0, 0.4), (0.8, 0.4), *reversed(top)], 256)
    for face in mesh.polygons:
        face.use_smooth = abs(face.normal.z) > 0.5
    add("Thing", mesh, _glass(), location=(0.2, 0.2, 0.0))


THINGS = dict(ball=_ball, ring=_ring, brushed=_brushed, water=_water)
LAMPS = dict(small=0.03, large=0.3, huge=0.8)  # radius in metres
SCENES = tuple(f"{thing}_{lamp}" for thing in THINGS for lamp in LAMPS)


def build(name: str, size: int) -> bpy.types.Scene:
    """A thing on a diffuse floor, under a lamp of 8 W/sr."""
    thing, lamp = name.split("_")
    scene = simple_scenes.empty(size, EYE, TARGET, DEGREES)
    add("Floor", plane("Floor", (6.0, 6.0)), simple_scenes.diffuse("Floor", (0.7, 0.68, 0.65)))
    THINGS[thing]()
    radius = LAMPS[lamp]
    density = lamp_scenes.INTENSITY / (4.0 / 3.0 * math.pi * radius**3)
    lamp_scenes.add_lamp("Lamp", f"sphere({radius})", None, lamp_scenes.turned(at=AT), density)
    return scene


def arguments(parser) -> None:
    parser.add_argument(
        "--caustics", type=some_of(SCENES), metavar="SCENES", help=f"with commas between: {', '.join(SCENES)}"
    )
    parser.add_argument("--document-caustics", action="store_true", help="write the table of docs/sampling.md")


def _render(scene, variant: str, samples: int, seed: int, device: str) -> pictures.Picture:
    """With the defaults but for the variant."""
    simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, device)
    settings = scene.sdf_lights
    settings.indirect_paths, settings.guided_samples = 0, True
    settings.caustic_paths, settings.seed = variant, seed
    return pictures.render()


def measure(name: str, options) -> dict:
    """The row of a scene."""
    quick = options.quick
    scene = build(name, QUICK_SIZE if quick else SIZE)
    samples = QUICK_SAMPLES if quick else SAMPLES
    seeds = max(options.repeats or (QUICK_SEEDS if quick else SEEDS), 2)
    variants = WITHOUT, AUTOMATIC, ALWAYS
    for variant in variants:
        _render(scene, variant, samples, 0, options.device)  # compiles, and fills caches
    before = statistics.median(_render(scene, WITHOUT, 1, seed, options.device).work for seed in range(3))
    mask = _diffuse_alone(scene)
    made = in_turns(
        variants,
        range(seeds),
        # The mean with them always on is the reference, and must not have the samples of the others.
        lambda variant, seed: _render(scene, variant, samples, seed + seeds * (variant == ALWAYS), options.device),
    )
    return dict(caustic=name) | row_of(
        {variant: (stack_of(pile)[:, mask], work_of(pile) - before) for variant, pile in made.items()}
    )


def _diffuse_alone(scene) -> np.ndarray:
    """(height, width) where pixels and their neighbors show nothing but what is diffuse. Caustics that the camera sees
    by way of mirrors or glass are left to paths, and their rare bright dots would hide all else."""
    objects = {name: bpy.data.objects[name] for name in ("Floor", "Thing")}
    kept = {name: each.data.materials[0] for name, each in objects.items()}
    lamp = bpy.data.objects["Lamp"]
    for name, each in objects.items():
        each.data.materials[0] = simple_scenes.material(
            f"{name} mask", "ShaderNodeEmission", (1.0, 1.0, 1.0) if name == "Floor" else (0.0, 0.0, 0.0)
        )
    lamp.hide_render = True
    found = _render(scene, WITHOUT, MASK_SAMPLES, 0, "CPU").pixels.min(axis=2) > 1.0 - 1e-4
    lamp.hide_render = False
    for name, each in objects.items():
        each.data.materials[0] = kept[name]
    around = np.pad(found, 1, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(around, (3, 3)).all(axis=(2, 3))


def row_of(made: dict[str, tuple[np.ndarray, float]]) -> dict:
    """Figures of pixels (seeds, n, RGB) of each variant, and the processor seconds of one picture.

    ``automatic`` and ``always``: error × time without caustic paths over that with them, and
    ``…_error`` their standard errors. Without them, light may be missing in all pictures, so errors are those from the
    mean with them always on. ``noise…``: root of the mean square relative error in %, without them and by default.
    ``time``: by default, over that without. ``deviation``: of the means, in standard errors.
    """
    reference = made[ALWAYS][0].mean(axis=0)
    square = reference**2 + errors.FLOOR * reference.mean() ** 2
    count = len(made[ALWAYS][0])
    spread = float((made[ALWAYS][0].var(axis=0, ddof=1) / square).mean()) / count  # of the reference itself
    error, products, uncertain = {}, {}, {}
    for variant, (stack, work) in made.items():
        center = reference if variant == WITHOUT else stack.mean(axis=0)
        each = ((stack - center) ** 2 / square).mean(axis=(1, 2))
        # The mean of its own pictures is nearer to them than the truth.
        found = float(each.mean()) - spread if variant == WITHOUT else float(each.mean()) * count / (count - 1)
        found = max(found, 1e-12)
        error[variant], products[variant] = found, found * work
        uncertain[variant] = float(each.std(ddof=1)) / math.sqrt(count) / found
    row = {}
    for key, variant in dict(automatic=AUTOMATIC, always=ALWAYS).items():
        row[key] = products[WITHOUT] / products[variant]
        row[f"{key}_error"] = row[key] * math.hypot(uncertain[WITHOUT], uncertain[variant])
    row["noise_without"], row["noise"] = (100.0 * math.sqrt(error[variant]) for variant in (WITHOUT, AUTOMATIC))
    row["time"] = made[AUTOMATIC][1] / made[WITHOUT][1]
    one, other = (made[variant][0].mean(axis=(1, 2)) for variant in (WITHOUT, AUTOMATIC))
    apart = one - other
    row["deviation"] = float(apart.mean()) / max(float(apart.std(ddof=1)) / math.sqrt(count), 1e-12)
    return row


def summary_of(rows: list[dict]) -> dict:
    """The geometric mean of gains for each size of lamp, and the least."""
    summary = {}
    for lamp in LAMPS:
        found = [row["automatic"] for row in rows if row["caustic"].endswith(lamp)]
        if found:
            summary[f"caustics_{lamp}"] = statistics.geometric_mean(found)
    return summary | dict(caustics_least=min(row["automatic"] for row in rows))


def document(rows: list[dict]) -> None:
    """Write these rows into the table of docs/sampling.md; the rows of other scenes stay."""
    before, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    table, _, after = rest.partition(END)
    lines = {line.split(" | ")[0].removeprefix("| "): line for line in table.strip().splitlines()[2:]}

    def number(value: float) -> str:
        return f"{value:.{0 if value >= 10.0 else 2}f}"

    for row in rows:
        cells = [
            f"{number(row[key])} ± {number(row[f'{key}_error'])}" if f"{key}_error" in row else f"{row[key]:.1f}"
            for key in COLUMNS
        ]
        lines[row["caustic"]] = f"| {row['caustic']} | {' | '.join(cells)} |"
    head = [f"| scene | {' | '.join(COLUMNS.values())} |", "|---" * (len(COLUMNS) + 1) + "|"]
    body = [lines[name] for name in SCENES if name in lines]
    DOCUMENT.write_text("\n".join([before + BEGIN.rstrip("\n"), *head, *body, END]) + after, encoding="utf-8")


def run(options) -> tuple[dict, list[dict]]:
    rows = in_parts(options.caustics or SCENES, lambda name: measure(name, options), options)
    if options.document_caustics:
        document(rows)
    return summary_of(rows), rows
