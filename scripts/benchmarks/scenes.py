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
BEGIN_COSTS, END_COSTS = "<!-- costs: made by scripts/bench scenes --costs --document -->", "<!-- end of costs -->"
COSTS = {
    "start": "from launch to picture",
    "first": "its render alone",
    "sync": "synchronisation",
    "again": "with Persistent Data",
    "memory": "memory",
}


def arguments(parser) -> None:
    parser.add_argument(
        "--scenes", type=some_of(KNOWN), metavar="SCENES", help=f"with commas between: {', '.join(KNOWN)}"
    )
    parser.add_argument(
        "--sheet", type=pathlib.Path, metavar="FILE", help="write a contact sheet: Cycles left, ours right"
    )
    parser.add_argument("--costs", action="store_true", help="measure start, synchronisation and memory alone")
    parser.add_argument("--document", action="store_true", help="write the tables of docs/cycles.md")
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
    _write(BEGIN, lines, END)


def document_costs(rows: list[dict]) -> None:
    """Write the table of start, synchronisation and memory of docs/cycles.md."""
    lines = [
        f"| scene | {' | '.join(COSTS.values())} |",
        f"|---|{'---|' * len(COSTS)}",
        *(
            f"| {row['artist_scene'].replace('_', ' ')} | {' | '.join(_cost(row, cost) for cost in COSTS)} |"
            for row in rows
            if "start_ratio" in row
        ),
    ]
    _write(BEGIN_COSTS, lines, END_COSTS)


def _cost(row: dict, cost: str) -> str:
    """Our figure, and its ratio to Cycles'."""
    if f"{cost}_ratio" not in row:
        return ""
    ours = f"{row[cost] / (1 << 20):.0f} MiB" if cost == "memory" else f"{row[cost]:.2f} s"
    return f"{ours}, {row[f'{cost}_ratio']:.2f} ×"


def _write(begin: str, lines: list[str], end: str) -> None:
    """Replace what is between two marks of the document."""
    before, found, rest = DOCUMENT.read_text(encoding="utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"{DOCUMENT.name} lacks the mark {end if found else begin}.")
    DOCUMENT.write_text("\n".join([before + begin, *lines, end]) + after, encoding="utf-8")


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each scene that could not be rendered or whose mean differs, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "artist_scene" not in row:
            continue
        if row["error"]:
            said.append(f"{row['artist_scene']}: {row['error'].rstrip('.')}.")
        elif row.get("mean_difference", 0.0) > LIMIT:
            said.append(f"{row['artist_scene']}: its mean differs by {100.0 * row['mean_difference']:.2g} %.")
    return said


def summary_of(rows: list[dict]) -> dict:
    """The figures of all scenes that could be rendered."""
    known = [row for row in rows if not row["error"]]
    summary = dict(scenes=len(rows), scenes_failed=len(rows) - len(known))
    if not known:
        return summary
    means = [row["mean_difference"] for row in known if "mean_difference" in row]
    if means:
        summary["worst_mean_difference"] = max(means)
    for name, column in (
        ("error_time_ratio_to_cycles", "error_time_ratio"),
        ("denoised_error_time_ratio_to_cycles", "denoised_error_time_ratio"),
    ):
        ratios = [row[column] for row in known if row.get(column) is not None]
        if ratios:
            summary |= {f"{name}_geomean": statistics.geometric_mean(ratios), f"{name}_min": min(ratios)}
    for name in COSTS:
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
    if options.sheet and not options.costs:
        from . import scene_pictures

        scene_pictures.write_sheet(options.sheet, names)
    parts.finish()
    progress.close()
    summary = summary_of(rows)
    if options.document:
        document_costs(rows)
    if options.document and not options.costs:
        samples = {row["cycles_samples"] for row in rows if not row["error"]}
        document(summary, rows, f"{' or '.join(map(str, sorted(samples)))} samples of Cycles.")
    return summary, rows


def _row(name: str, options, shared: Isolated) -> dict:
    from . import scene_costs, scene_pictures

    chosen = ("size", "quick", "repeats", "device", "reference_seconds", "fresh", "sheet")
    given = argparse.Namespace(**{key: getattr(options, key) for key in chosen})
    row = dict(artist_scene=name, error="")
    try:
        if not options.costs:
            row |= shared.call(scene_pictures.measure, name, given)
        if options.costs or not options.quick or name in QUICK_COSTS:
            row |= scene_costs.ratios(name, given)
    except RuntimeError as error:
        row["error"] = str(error)
    return row
