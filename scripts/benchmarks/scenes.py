# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole scenes typical of artists' work, by both engines: difference of pictures, error at equal time, time before
samples.

Both engines keep their defaults, so ours splits paths and spends more samples on noisy pixels. References are renders
of many samples by Cycles, kept in the user's cache.
"""

from __future__ import annotations

import argparse
import functools
import pathlib
import statistics

import host

from . import methods, some_of
from .isolation import Isolated
from .progress import Progress
from .resume import Parts

HELP = "ten scenes typical of artists' work, compared with Cycles: differences, error at equal time, start, memory"
# The names of ``artist_scenes``, which is not loaded for the help of other benchmarks.
KNOWN = (
    "living_room_day",
    "living_room_night",
    "kitchen",
    "neon_bar",
    "product",
    "character",
    "street",
    "forest",
    "landscape",
    "animation",
)
BRIEF = dict(scenes=["living_room_night"])
QUICK_COSTS = ("forest",)  # whose start and memory a quick run measures
LIMIT = 0.02  # of the difference of means
DOCUMENT = host.REPOSITORY / "docs" / "cycles.md"
BEGIN, END = "<!-- scenes: made by scripts/bench scenes --document -->", "<!-- end of scenes -->"


def arguments(parser) -> None:
    parser.add_argument(
        "--scenes", type=some_of(KNOWN), metavar="SCENES", help=f"with commas between: {', '.join(KNOWN)}"
    )
    parser.add_argument(
        "--sheet", type=pathlib.Path, metavar="FILE", help="write a contact sheet: Cycles left, ours right"
    )
    parser.add_argument("--document", action="store_true", help="write the table of docs/cycles.md")
    methods.picture_arguments(parser)


def document(summary: dict, rows: list[dict], sampled: str) -> None:
    """Write the table of docs/cycles.md; ``sampled`` is the sentence about the number of samples."""
    lines = [
        "| scene | mean, Cycles' as 1 | samples a second | Cycles' error × time to ours | denoised |",
        "|---|---|---|---|---|",
        *(
            f"| {row['artist_scene'].replace('_', ' ')} | {row['mean_ratio']:.3f} ± {row['mean_doubt']:.3f} "
            f"| {row['samples_ratio']:.2f} × | {row['error_time_ratio']:.2f} × ± {100.0 * row['error_time_doubt']:.0f} % "
            + (f"| {row['denoised_error_time_ratio']:.2f} × |" if "denoised_error_time_ratio" in row else "| |")
            for row in rows
            if not row["error"]
        ),
        "",
        f"{sampled} Error × time: {summary['error_time_ratio_to_cycles_geomean']:.2f} × in the geometric mean.",
        *(
            [f"Denoised: {summary['denoised_error_time_ratio_to_cycles_geomean']:.2f} ×."]
            if "denoised_error_time_ratio_to_cycles_geomean" in summary
            else []
        ),
    ]
    costs = {name: summary.get(f"{name}_ratio_to_cycles_max") for name in ("sync", "again", "start", "first", "memory")}
    measured = [row["artist_scene"] for row in rows if "start_ratio" in row]
    if None not in costs.values():
        lines.append(
            f"Of what comes before samples, over Cycles' in the worst of {len(measured)} scenes: synchronisation {costs['sync']:.1f}, "
            f"an unchanged frame with Persistent Data {costs['again']:.1f}, a process from its launch to its first picture "
            f"{costs['start']:.1f} (its render alone {costs['first']:.1f}), memory {costs['memory']:.1f}. Less than a tenth "
            "of a second, or 64 MiB, counts as that."
        )
    before, begin, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{DOCUMENT.name} lacks the marks of scenes.")
    DOCUMENT.write_text("\n".join([before + BEGIN, *lines, END]) + after, encoding="utf-8")


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each scene that could not be rendered or whose mean differs, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "artist_scene" not in row:
            continue
        if row["error"]:
            said.append(f"{row['artist_scene']}: {row['error'].rstrip('.')}.")
        elif row["mean_difference"] > LIMIT:
            said.append(f"{row['artist_scene']}: its mean differs by {100.0 * row['mean_difference']:.2g} %.")
    return said


def summary_of(rows: list[dict]) -> dict:
    """The figures of all scenes that could be rendered."""
    known = [row for row in rows if not row["error"]]
    summary = dict(scenes=len(rows), scenes_failed=len(rows) - len(known))
    if not known:
        return summary
    summary["worst_mean_difference"] = max(row["mean_difference"] for row in known)
    for name, column in (
        ("error_time_ratio_to_cycles", "error_time_ratio"),
        ("denoised_error_time_ratio_to_cycles", "denoised_error_time_ratio"),
    ):
        ratios = [row[column] for row in known if row.get(column) is not None]
        if ratios:
            summary |= {f"{name}_geomean": statistics.geometric_mean(ratios), f"{name}_min": min(ratios)}
    for name in ("start", "first", "sync", "again", "memory"):
        ratios = [row[f"{name}_ratio"] for row in known if row.get(f"{name}_ratio") is not None]
        if ratios:
            summary[f"{name}_ratio_to_cycles_max"] = max(ratios)
    return summary


def run(options) -> tuple[dict, list[dict]]:
    names = options.scenes or list(KNOWN)
    progress, parts, rows = Progress(len(names)), Parts(options), []
    shared = Isolated()
    for name in names:
        progress.show(name)
        rows.append(parts.of(name, functools.partial(_row, name, options, shared)))
        progress.step()
    shared.close()
    if options.sheet:
        from . import scene_pictures

        scene_pictures.write_sheet(options.sheet, names)
    parts.finish()
    progress.close()
    summary = summary_of(rows)
    if options.document:
        samples = {row["cycles_samples"] for row in rows if not row["error"]}
        document(summary, rows, f"{' or '.join(map(str, sorted(samples)))} samples of Cycles.")
    return summary, rows


def _row(name: str, options, shared: Isolated) -> dict:
    from . import scene_costs, scene_pictures

    chosen = ("size", "quick", "repeats", "device", "reference_seconds", "fresh", "sheet")
    given = argparse.Namespace(**{key: getattr(options, key) for key in chosen})
    row = dict(artist_scene=name, error="")
    try:
        row |= shared.call(scene_pictures.measure, name, given)
        if not options.quick or name in QUICK_COSTS:
            row |= scene_costs.ratios(name, given)
    except RuntimeError as error:
        row["error"] = str(error)
    return row
