# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sections of the report on samplers: all scenes, the scenes of the paper, and points."""

from __future__ import annotations

import math
import pathlib

from .prose import OURS, PAPER, heading, listed, load, number, reached, settings, shown, summary, table
from .results import METRICS, Result

ALL_SCENES = """\
Errors to ours, without denoising if nothing else is said, at the time that Cycles takes for its samples. Ours guides its
samples by noise and divides paths; *guided* is the paper's sampler with that, too. The errors of the worst pixels are
those of the 99.9th percentile of a picture and its greatest, which are means over the seeds, and the greatest of all seeds:
one pixel of one picture, which chance decides. Cycles has no lamps whose light varies, nor some of the shapes. What stands
before the first sample is in all times. The last column is the standard error of the reference, of the least error that it
judges.
"""

MORE_SEEDS = """\
Where fewer seeds leave it open which sampler is better, or for longer renders. Columns are those of all scenes.
"""

PAPER_SCENES = """\
The scenes of Huang et al. 2026 are not published; these are of the same kinds: a torus over a detailed mesh, a room
with five lamps of simple shapes, a kitchen with a fractal lamp, a corridor with an extruded sign. Direct light. Errors
depend on how much of a picture is hard, so ratios are compared: errors to those of projection sampling.
"""

PAPER_BSDF = """\
A ratio to BSDF samples is first of all how small the lamp is, seen from what it lights: our lamps are not the paper's.
"""

PAPER_COMPETITORS = """\
The paper's competitor is uniform sampling of the surface for its simple shapes, and of the bounding volume for its
fractal and its sign. Here that is a box, whose sides are those of the world. MAPE to that of projection sampling, of
pictures, and of pixels of as many samples at points that the camera sees, without occlusion. What sets these ratios
apart is distance: a ray's weight by projection differs less and less from that of others as the lamp gets smaller, seen from
what it lights, while the weight of a ray that grazes a surface, or passes through part of a box, stays what it is. In
pictures shadows and edges add an error that all techniques share, which brings ratios nearer to 1. How far the paper's
lamps are, and how much of its pictures is in their penumbrae, is not published.
"""

ESTIMATORS = """\
The light of one lamp at one point, without occlusion, by the same Sobol numbers. Errors are relative, of pixels of 64
samples. Efficiency is that of ours to the paper's sampler: the ratio of squared errors by that of times.
"""


def lamps(result: Result) -> list[str]:
    """A row for each scene and number of bounces, and where ours has more error than the paper's sampler."""
    paper = f"{PAPER} / {OURS}"
    found = [row for row in result.rows if paper in row]
    seeds = max((row["seeds"] for row in result.rows if "seeds" in row), default=0)
    title = "All scenes" if result.name == "lamps" else f"Some scenes with {seeds} seeds"
    keys = (
        paper,
        f"{PAPER} guided / {OURS}",
        f"worst_999 {paper}",
        f"worst_mean {paper}",
        f"worst {paper}",
        "cycles",
        "cycles denoised",
        "both denoised",
    )
    rows = [
        [row["scene"], row["bounces"], row["seconds"], *(row.get(key) for key in keys), math.sqrt(row["reference"])]
        for row in found
    ]
    lost = [
        f"{row['scene']} with {row['bounces']} bounces by {label} ({number(row[key])} times our error)"
        for key, label in (
            (paper, "relMSE"),
            (f"worst_999 {paper}", "the 99.9th percentile"),
            (f"worst_mean {paper}", "the greatest error"),
            (f"worst {paper}", "the greatest error of all seeds"),
        )
        for row in found
        if row.get(key, 1.0) < 1.0
    ]
    return [
        *heading(title, result, load(result)),
        ALL_SCENES if result.name == "lamps" else MORE_SEEDS,
        f"**The paper's sampler is better** in {listed(lost)}.\n"
        if lost
        else "The paper's sampler is better nowhere.\n",
        table(
            [
                "scene",
                "bounces",
                "seconds",
                "paper's sampler",
                "paper's, guided",
                "paper's, 99.9th percentile",
                "paper's, greatest",
                "paper's, of all seeds",
                "Cycles",
                "Cycles denoised",
                "both denoised",
                "reference",
            ],
            rows,
        ),
        summary(result),
    ]


def efficiencies(result: Result) -> dict[str, list[float]]:
    """Of cuts to projection sampling and to the paper's sampler, by scene."""
    found = {}
    for scene in dict.fromkeys(row["scene"] for row in result.rows):
        cost = {row["method"]: row["rel_mse"] * row["seconds"] for row in result.of(scene=scene) if "method" in row}
        found[scene] = [cost[method] / cost[OURS] for method in ("PROJECTION", PAPER)]
    return found


def slower(result: Result) -> str:
    """The cases in which cuts do not pay."""
    lost = [
        f"{scene} to {name} ({number(ratio)})"
        for scene, found in efficiencies(result).items()
        for name, ratio in zip(("projection sampling", "the paper's sampler"), found)
        if ratio < 1.0
    ]
    return f"**Cuts lose** in {listed(lost)}.\n" if lost else "Cuts pay in all of them.\n"


def paper(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section on the paper's scenes."""
    found = [row for row in result.rows if "competitor" in row]
    pictures = [
        [
            row["scene"],
            label,
            *(
                row[key.format(metric)]
                for key in (
                    "paper_{}_bsdf_to_projection",
                    "{}_bsdf_to_projection",
                    "{}_mis_to_projection",
                    "{}_cut_to_projection",
                )
            ),
        ]
        for row in found
        for metric, label in METRICS.items()
        if metric != "rel_mse"
    ]
    competitors = []
    for row in found:
        other = "surface" if row["competitor"] == "surface area" else "bounding"
        for name, label in (("surface", "surface"), ("bounding", "bounding box")):
            published = [
                row[f"paper_{metric}_competitor_to_projection"] if name == other else None
                for metric in ("mape", "flip")
            ]
            competitors.append(
                [
                    row["scene"],
                    label,
                    published[0],
                    row.get(f"mape_{name}_to_projection"),
                    published[1],
                    row.get(f"flip_{name}_to_projection"),
                    row.get(f"points_{name}_to_projection"),
                ]
            )

    def of_methods(column: str) -> str:
        methods = ("BSDF", "BOUNDING", "SURFACE", "PROJECTION", PAPER, OURS)
        rows = [
            [
                row["scene"],
                *(
                    next((known[column] for known in result.of(scene=row["scene"], method=method)), None)
                    for method in methods
                ),
            ]
            for row in found
        ]
        heads = ["scene", "BSDF", "bounding box", "surface", "projection", "paper's sampler", "cuts"]
        if any(f"paper_{column}_bsdf" in row for row in found):
            heads += ["paper: BSDF", "paper: its competitor", "paper: projection"]
            for line, row in zip(rows, found):
                line += [row.get(f"paper_{column}_{what}") for what in ("bsdf", "competitor", "projection")]
        return table(heads, rows)

    return [
        *heading("The scenes of the paper", result, settings(result)),
        PAPER_SCENES,
        table(
            [
                "scene",
                "measure",
                "BSDF / projection: paper",
                "here",
                "paper's sampler with MIS / projection",
                "cuts / projection",
            ],
            pictures,
        ),
        reached(list({row["scene"]: row for row in result.rows if "reference" in row}.values())),
        PAPER_BSDF,
        PAPER_COMPETITORS,
        table(
            [
                "scene",
                "competitor",
                "MAPE / projection: paper",
                "here",
                "FLIP / projection: paper",
                "here",
                "MAPE / projection, at points",
            ],
            competitors,
        ),
        "Equal samples hide what a sample costs. Efficiency is 1 / (relMSE × seconds), here of cuts to others:\n",
        table(
            ["scene", "cuts / projection", "cuts / paper's sampler"],
            [[scene, *values] for scene, values in efficiencies(result).items()],
        ),
        slower(result),
        "MAPE of the pictures:\n",
        of_methods("mape"),
        "Their FLIP:\n",
        of_methods("flip"),
        "Their seconds:\n",
        of_methods("seconds"),
        *shown(sorted(images.glob("report_pictures_paper_*.png")), "Renders of equal samples, and their errors", page),
    ]


def estimators(result: Result) -> list[str]:
    """Section of samplers at points."""
    best = {row["case"]: row for row in result.of(technique="cut")}
    rows = [
        [
            case,
            row["group"],
            other["error_64"],
            row["error_64"],
            other["ns"],
            row["ns"],
            row["gain_64"],
            row["gain_256"],
        ]
        for case, row in best.items()
        for other in result.of(case=case, technique="mis")
    ]
    return [
        *heading("Samplers at points", result, load(result)),
        ESTIMATORS,
        table(
            [
                "lamp and point",
                "kind",
                "error, paper's sampler",
                "error, ours",
                "ns of a sample, paper's sampler",
                "ns, ours",
                "efficiency, 64 samples",
                "efficiency, 256 samples",
            ],
            rows,
        )
        if rows
        else "",
        summary(result),
    ]
