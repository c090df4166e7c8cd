# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sections of the report on rays, hard cases, throughput and scaling, and on any benchmark without a special
section."""

from __future__ import annotations

import pathlib

from .prose import heading, listed, load, number, shown, summary, table
from .results import NUMBERS, RULES, Result

MANY = 0.01  # of the rays of a shape: smaller ones are not listed

MORE = {  # columns of hard cases beside the figure: title and key
    "rays": "rays",
    "too_fine_to_judge": "too fine to judge",
    "unresolved": "length unresolved",
    "deviation": "of the whole picture",
    "standard_error": "its standard error",
}

INTERVALS = """\
Every shape and operator of the tests and the hard cases, judged by a march through the whole formula in finer steps.
The published rule and sphere tracing march through the same compiled field, and locate zeros by the same bracketing, so
what differs is the search: how often the field is evaluated, and what is missed. Their shortest step is the resolution
at which our own search stops, or, coarse, a much longer one.
"""

SMOOTH_CASES = """\
Evaluations of the field on a ray, where the field is smooth and the published rule could do well:
"""

THROUGHPUT = """\
Boxes and a glossy sphere under one point light, the same work in both engines, which take turns in one process. A rate
is the further samples of a long render over its further seconds. Means of the pictures agree if both compute the same.
"""

SCALING = """\
All lamps together have the same power and volume, however many they are. The error is the variance of renders with
different seeds; the number of samples that one level of it takes is read off the curve of error against samples. What a
render needs before the first one is told by itself.
"""

TIMES = """\
What these renders take. The last column is how the time of the paper's rule grows, with a coarse shortest step, by its
evaluations on rays through both lamps.
"""

HARD_CASES = """\
Cases on which light is easily wrong or dear. A limit was there before the measurement, and a figure must not be above
it. Each is a test of the same name, too.
"""

HARD = {  # kind of case: title, and the source of its limits
    "rays": (
        "Rays",
        """\
Counts of crossings must be right: the search finds all zeros that are farther apart than its resolution, which is the
limit of the lengths. Balls have closed forms; all else is judged by the tests' own march in much finer steps.
""",
    ),
    "light": (
        "Size, place and form",
        """\
A lamp lights a floor as a body of its density attracts it by Newton's law, so affine images of a ball have renders in
closed form. A mean may be off by four standard errors, what float32 rounds, and what cuts do not know of volumes in
boxes.
""",
    ),
    "scattered": (
        "Scattered light",
        """\
A sphere of diffuse faces spreads all that it scatters evenly, so the light of all bounces is known, wherever the lamp
is. Light paths and path reuse may be off by as many standard errors over seeds as are exceeded once in 16,000 times, by
what float32 rounds, and by how far faces are inside the sphere.
""",
    ),
    "faces": (
        "Coincident faces",
        """\
Boxes that stand on a floor, fill a box or touch a wall; light must neither be lost where faces meet nor leak through.
""",
    ),
    "single": (
        "Single precision",
        """\
Fields as the GPU evaluates them, its pictures, and hits of triangles, against double precision: limits are what rounding
may do. Pictures of both use the same random numbers; their means, and those of blocks, may differ by what seeds scatter,
four standard errors for all means together, and by what a rounded number makes of a shape.
""",
    ),
    "cost": (
        "Cost",
        """\
Render times and evaluations with a hard lamp to those with an easy one. Limits are the ratios of the paper's times,
for high-frequency noise and for a sparse frame. But our smooth field takes far fewer evaluations than its rule does, so
evaluations are compared for noise, and of its time the limit is what is evaluated.
""",
    ),
    "samples": (
        "A million samples a pixel",
        """\
Sums must not drift, and the error must fall at least as fast as that of independent samples.
""",
    ),
    "motion": (
        "Flicker",
        """\
How much pixels of an animation change beyond what moves, at four samples a pixel. Light bounces once where no number is
told. Independent frames have 1, with four standard errors; others may not be better than ours.
""",
    ),
}


def whole(value):
    """A count that was kept as a float, as a count."""
    return int(value) if isinstance(value, float) and value >= 1.0 and value.is_integer() else value


def hard(result: Result) -> list[str]:
    """Section of cases with limits, a table for each kind."""
    rows = [row for row in result.rows if "measures" in row]
    failed = [row["case"] for row in rows if not row["holds"]]
    parts = [
        *heading("Hard cases", result, load(result)),
        HARD_CASES,
        f"**Limits that do not hold: {listed(failed)}.**\n" if failed else "All limits hold.\n",
    ]
    for kind in dict.fromkeys(row.get("kind") for row in rows):
        title, text = HARD.get(kind, ("Others", ""))
        own = [row for row in rows if row.get("kind") == kind]
        more = [key for key in MORE if any(key in row for row in own)]
        parts += [
            f"### {title}\n",
            text,
            table(
                ["case", "what is measured", "figure", "limit", "", *(MORE[key] for key in more)],
                [
                    [
                        row["case"],
                        row["measures"],
                        row["figure"],
                        row["limit"],
                        "" if row["holds"] else "**fails**",
                        *(whole(row.get(key)) for key in more),
                    ]
                    for row in own
                ],
            ),
        ]
        timed = [row for row in own if "easy_ns_per_sample" in row]
        if timed:
            parts += [
                TIMES,
                table(
                    ["case", "ns of a sample, hard", "easy", "hard / easy", "by the paper's rule"],
                    [
                        [
                            row["case"],
                            row["hard_ns_per_sample"],
                            row["easy_ns_per_sample"],
                            row["figure"],
                            row.get("published_time_ratio"),
                        ]
                        for row in timed
                    ],
                ),
            ]
    return parts


def figures(result: Result) -> list[str]:
    """Section of a benchmark without a special one."""
    return [*heading(f"`{result.name}`", result, load(result)), summary(result)]


def intervals(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section of rays and their crossings."""
    cases = [row for row in result.rows if "published_wrong" in row]
    wrong = [row["case"] for row in cases if row["certified"] and row["wrong"] > 0.0]
    missed = sorted(
        (row for row in cases if max(row["published_wrong"], row["published_coarse_wrong"]) > 0.0),
        key=lambda row: -max(row["published_wrong"], row["published_coarse_wrong"]),
    )
    most = [row for row in missed if max(row["published_wrong"], row["published_coarse_wrong"]) >= MANY]
    names = [key for key, *_ in RULES]
    found = (
        [
            f"{number(int(sum(row['rays'] for row in cases)))} rays through {len(cases)} shapes. "
            + (
                f"**With a proven bound, rays are wrong in {listed(wrong)}.**\n"
                if wrong
                else "With a proven bound, no ray has a wrong number of crossings.\n"
            )
        ]
        if cases
        else []
    )
    return [
        *heading("Crossings of rays", result, load(result)),
        INTERVALS,
        *found,
        *shown([images / "report_intervals.png"], "Evaluations on a ray, and the time of a ray by parts", page),
        *(
            [
                SMOOTH_CASES,
                table(
                    ["smooth case", *(label for _, label, *_ in RULES), "published / ours"],
                    [
                        [row["case"], *(row[name] for name in names), row["published_evaluations"] / row["evaluations"]]
                        for row in cases
                        if row["smooth"]
                    ],
                ),
            ]
            if cases
            else []
        ),
        *(
            [
                f"The published rule has a wrong number of crossings in {len(missed)} of these shapes, at our resolution in "
                f"{sum(row['published_wrong'] > 0.0 for row in missed)}. Part of the rays that it marches along, where that "
                f"is at least {number(MANY)}:\n",
                table(
                    [
                        "case",
                        "ours",
                        "published rule, at our resolution",
                        "published rule, coarse",
                        "sphere tracing, at our resolution",
                    ],
                    [
                        [
                            row["case"],
                            row["wrong"],
                            row["published_wrong"],
                            row["published_coarse_wrong"],
                            row["spheres_wrong"],
                        ]
                        for row in most
                    ],
                ),
            ]
            if missed
            else []
        ),
        summary(result),
    ]


def throughput(result: Result) -> list[str]:
    """Section of samples a second, and start-up."""
    rows = []
    for bounces, surfaces in dict.fromkeys(
        (row["bounces"], row.get("surfaces")) for row in result.rows if "engine" in row
    ):
        of_case = result.of(bounces=bounces)
        rates = {row["engine"]: row for row in of_case if "engine" in row and row.get("surfaces") == surfaces}
        theirs = rates.get("Cycles")
        rows += [
            [
                bounces,
                surfaces,
                name,
                row["samples_per_second"],
                row["slowest"],
                row["fastest"],
                row["samples_per_second"] / theirs["samples_per_second"] if theirs else None,
                row["mean"],
            ]
            for name, row in rates.items()
        ]
    started = [[row["start"], row["seconds"]] for row in result.rows if "start" in row and "seconds" in row]
    return [
        *heading("Samples a second", result, load(result, by_clock=True)),
        *(
            [
                THROUGHPUT,
                table(
                    [
                        "bounces",
                        "surfaces",
                        "engine",
                        "samples / s, median",
                        "slowest turn",
                        "fastest turn",
                        "to Cycles",
                        "mean of the picture",
                    ],
                    rows,
                ),
            ]
            if rows
            else []
        ),
        *(["Seconds to the first pixels of the demo scene:\n", table(["", "seconds"], started)] if started else []),
        summary(result),
    ]


def scaling(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section of render time by numbers."""
    rows = [
        [
            NUMBERS.get(row["curve"], row["curve"]),
            row["count"],
            row["samples"],
            row["each"],
            row["seconds"],
            row["start"],
        ]
        for row in result.rows
    ]
    return [
        *heading("Scaling", result, load(result)),
        SCALING,
        *shown([images / "report_scaling.png"], "Seconds at equal error, by numbers of things", page),
        *(
            [
                table(
                    [
                        "of",
                        "number",
                        "samples at equal error",
                        "seconds of a sample",
                        "seconds at equal error",
                        "seconds before the first sample",
                    ],
                    rows,
                )
            ]
            if rows
            else []
        ),
        summary(result),
    ]
