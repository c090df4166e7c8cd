# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of the report. Every number in it is read from results; results also select the sentences that judge."""

from __future__ import annotations

import math
import pathlib
import string

from . import records
from .results import METHODS, METRICS, NUMBERS, RULES, RUNS, Result

OURS, PAPER = "CUT", "MIS"
PEERS = ("Cycles volume", "Cycles mesh light")
LIGHT = {"cycles_direct": ("Direct light", "direct"), "cycles_bounces": ("Four bounces", "bounces")}
DRAWN = (*LIGHT, "paper", "intervals", "scaling")  # results that have plots
MANY = 0.01  # of the rays of a shape: smaller ones are not listed
TENTH = 0.1  # standard error of a reference at which it is good enough, relative to the least error that it judges

INTRODUCTION = """\
# Speed against error

Written by `./scripts/report` from the results in [report](report). Above each part stands the command that measured it;
`./scripts/report --run` measures all of it again. [scripts/README.md](../scripts/README.md) says what each benchmark
measures and how. Scenes S1 to S5 are a stage with one lamp: a torus; the same, half sunk in the floor; a thin frame;
Menger's sponge; a stretched torus.

Of a picture x and its reference r with mean r̄, relMSE is the mean of (x − r)² / (r² + 0.01 r̄²) and MAPE that of
|x − r| / (r + 0.01 r̄), both scene-linear; FLIP is LDR-FLIP of both as sRGB, clipped.
"""

CURVES = """\
Lines are means of the seeds, bands reach from the best seed to the worst. Errors at the time that Cycles takes for its
most samples of the volume:
"""

PREPARATION = """\
Equal time holds what a render needs before its first sample, which weighs the more the shorter the time is. Here it is
by itself, read off the fewest and the most samples of the ladder; and beside it relMSE × seconds of the samples alone,
at the most of them, to ours:
"""

MESH_LIGHTS = """\
A mesh light is another lamp: the same mesh, the same power, but light from its surface. It is judged by its own
converged picture, so its column tells how noisy it is, not how near it comes to the lamp; how far it is from that is in
the last two columns here.
"""

REFERENCES = """\
References are renders of other seeds, of the lamp by the paper's sampler, of the mesh light by Cycles. How they differ
is their own error; its square is taken off relMSE, while MAPE and FLIP still hold it. Seconds are those that their
renders take at the rate measured here; they are kept between runs. Means of the pictures, as a check of all of them:
"""

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

MACHINES = """\
Results are of the revisions in this table; a + after one says that files had been changed.
"""

IMAGES = """\
Images say as PNG text, `Result`, which result they were drawn from, with its hash.
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


def number(value) -> str:
    """Three figures, all of a whole number, or a dash."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return f"{value:,}"
    if 1000.0 <= abs(value) < 1e5:
        return f"{value:,.0f}"
    return f"{value:.3g}" if value == 0.0 or 1e-3 <= abs(value) < 1e5 else f"{value:.2e}"


def whole(value):
    """A count that was kept as a float, as a count."""
    return int(value) if isinstance(value, float) and value >= 1.0 and value.is_integer() else value


def table(heads: list[str], rows: list[list]) -> str:
    lines = [heads, ["---"] * len(heads), *([number(value) for value in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def load(result: Result, by_clock: bool = False) -> str:
    """The machine of a measurement, and its other load. ``by_clock``: times are wall-clock times."""
    machine = result.machine
    text = f"On {machine['cores']} cores of {machine['processor']}"
    busy = machine.get("load")
    if busy is None:
        return text + ".\n"
    text += f", with a load of {number(busy)} before the run"
    if busy <= 0.5 * machine["cores"]:
        return text + ", otherwise idle.\n"
    return f"{text}: **other work ran beside it.**\n" + (
        "Times are those of the clock, so they are too long.\n"
        if by_clock
        else "Times of renders are processor time by cores, which other work disturbs less than the clock.\n"
    )


def settings(result: Result) -> str:
    rows = [row for row in result.rows if "method" in row]
    samples = sorted({row["samples"] for row in result.of(method=PEERS[0]) or rows})
    seeds = sorted({row["seeds"] for row in rows})
    return (
        f"{listed([str(count) for count in samples])} samples a pixel, {listed([str(count) for count in seeds])} "
        f"{'seed' if seeds == [1] else 'seeds'} a point. {load(result)}"
    )


def heading(title: str, result: Result, about: str) -> list[str]:
    return [f"## {title}\n", f"    {result.command}\n", about]


def shown(paths: list[pathlib.Path], about: str, page: pathlib.Path) -> list[str]:
    """Links to the images that exist."""
    return [f"![{about}]({path.relative_to(page.parent).as_posix()})\n" for path in paths if path.is_file()]


# --- error against time -----------------------------------------------------------------------------------------------


def ratios(result: Result, method: str) -> list[tuple[str, str, float]]:
    """Scene, measure, and the error of a method over ours, at equal time, if both are known."""
    return [
        (row["scene"], label, row[f"{metric} {method}"] / row[f"{metric} {OURS}"])
        for metric, label in METRICS.items()
        for row in result.rows
        if row.get(f"{metric} {method}") is not None and row.get(f"{metric} {OURS}")
    ]


def verdict(result: Result) -> str:
    """The cases that we lose, and by how much; without any, our least gain."""
    sentences = []
    for method in (*PEERS, PAPER):
        found = ratios(result, method)
        if not found:
            continue
        who = METHODS[method][0].split(" (")[0]
        lost = [
            f"{scene} by {metric} ({number(ratio)} times our error)" for scene, metric, ratio in found if ratio < 1.0
        ]
        scene, metric, least = min(found, key=lambda one: one[2])
        sentences.append(
            f"**{who} is better** in {listed(lost)}."
            if lost
            else f"{who} is better nowhere; it comes closest in {scene} by {metric}, with {number(least)} times our error."
        )
    return "\n".join(f"- {sentence}" for sentence in sentences) + "\n"


def equal_time(result: Result) -> str:
    """Errors at equal time, a row for each scene and measure, with ratios to ours."""
    names = (OURS, PAPER, *PEERS)
    rows = []
    for row in result.rows:
        for metric, label in METRICS.items():
            values = [row.get(f"{metric} {name}") for name in names]
            if any(value is not None for value in values):
                rows.append(
                    [
                        row["scene"],
                        row["seconds"],
                        label,
                        *values,
                        *(value / values[0] if None not in (value, values[0]) else None for value in values[1:]),
                    ]
                )
    return table(
        [
            "scene",
            "seconds",
            "measure",
            *(METHODS[name][0] for name in names),
            "paper's sampler / ours",
            "volume / ours",
            "mesh light / ours",
        ],
        rows,
    )


def preparation(result: Result) -> str:
    """Seconds before the first sample, and the comparison without them."""
    names = (OURS, PAPER, *PEERS)
    rows = []
    for row in (row for row in result.rows if "method" not in row):
        starts, costs = [], []
        for name in names:
            # There are renders of more samples, at equal time.
            known = result.of(scene=row["scene"], method=name)
            curve = sorted((one for one in known if one["samples"] <= row["samples"]), key=lambda one: one["samples"])
            if len(curve) < 2:
                starts.append(None)
                costs.append(None)
                continue
            few, many = curve[0], curve[-1]
            each = (many["seconds"] - few["seconds"]) / (many["samples"] - few["samples"])
            starts.append(max(few["seconds"] - each * few["samples"], 0.0))
            costs.append(many["rel_mse"] * each * many["samples"] if each > 0.0 else None)
        rows.append(
            [
                row["scene"],
                row["seconds"],
                *starts,
                *(cost / costs[0] if cost is not None and costs[0] else None for cost in costs[1:]),
            ]
        )
    if not any(start is not None for row in rows for start in row[2 : 2 + len(names)]):
        return ""
    return f"{PREPARATION}\n" + table(
        [
            "scene",
            "equal time",
            *(f"{METHODS[name][0]}: before the first sample" for name in names),
            "paper's sampler / ours",
            "volume / ours",
            "mesh light / ours",
        ],
        rows,
    )


def references(result: Result) -> str:
    """Facts about the references, and the difference of mesh lights."""
    found = [row for row in result.rows if "surface_reference" in row]
    if not found:
        return ""
    rows = [
        [
            row["scene"],
            *(
                value
                for key in ("reference", "surface_reference")
                for value in (math.sqrt(row[key]), row.get(f"{key}_renders"), row.get(f"{key}_seconds"))
            ),
            row["surface_mape"],
            row["surface_mean_ratio"],
        ]
        for row in found
    ]
    heads = [
        "scene",
        "standard error of the lamp's reference / least error judged",
        "its renders",
        "their seconds",
        "standard error of the mesh light's reference / least error judged",
        "its renders",
        "their seconds",
        "mesh light's picture: MAPE",
        "and mean, to the lamp's",
    ]
    return f"{MESH_LIGHTS}\n{table(heads, rows)}\n{reached(found)}{REFERENCES}"


def reached(rows: list[dict]) -> str:
    """Whether references are good enough, of rows that have the variance of one as part of the least relMSE."""
    missed = [
        f"{row['scene']}{of} ({number(math.sqrt(row[key]))})"
        for key, of in (("reference", ""), ("surface_reference", "'s mesh light"))
        for row in rows
        if key in row and math.sqrt(row[key]) > TENTH
    ]
    return (
        (
            f"**The standard error of a reference is more than a tenth of the least error that it judges** in "
            f"{listed(missed)}.\n"
        )
        if missed
        else "The standard error of every reference is at most a tenth of the least error that it judges.\n"
    )


def means(result: Result) -> str:
    """Whether the methods agree: the largest deviation of the mean of each, at the most samples of the ladder."""
    # There are renders of more samples, at equal time.
    rows, most = [], max(row["samples"] for row in result.rows if "method" not in row)
    for method, (label, *_) in METHODS.items():
        found = result.of(method=method, samples=most)
        if found:
            worst = max(found, key=lambda row: abs(row["mean_ratio"] - 1.0))
            error = worst["mean_ratio_error"]
            rows.append(
                [
                    label,
                    worst["scene"],
                    f"{100.0 * (worst['mean_ratio'] - 1.0):+.2f} %",
                    None if error is None else f"{100.0 * error:.2f} %",
                ]
            )
    return table(["method", "scene", "largest deviation of a picture's mean", "its standard error"], rows)


def race(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section on error against time."""
    name = result.name
    strips = shown(
        sorted(images.glob(f"report_pictures_{name}_*.png")), "Renders at equal time, and their errors", page
    )
    return [
        *heading(f"Error against time: {LIGHT[name][0].lower()}", result, settings(result)),
        *(
            link
            for metric, label in METRICS.items()
            for link in shown(
                [images / f"report_{name}_{metric}.png"], f"{label} against seconds, by scene and method", page
            )
        ),
        CURVES,
        equal_time(result),
        verdict(result),
        preparation(result),
        references(result),
        means(result),
        *(["Renders at equal time, one seed each, with the relative error of each pixel below:\n"] if strips else []),
        *strips,
    ]


# --- the paper --------------------------------------------------------------------------------------------------------


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


# --- the rest ---------------------------------------------------------------------------------------------------------


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


def summary(result: Result) -> str:
    """The numbers of a result by their names."""
    return table(["figure", "value"], [[f"`{name}`", value] for name, value in result.summary.items()])


def figures(result: Result) -> list[str]:
    """Section of a benchmark without a special one."""
    return [*heading(f"`{result.name}`", result, load(result)), summary(result)]


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
    for bounces in dict.fromkeys(row["bounces"] for row in result.rows if "engine" in row):
        rates = {row["engine"]: row for row in result.of(bounces=bounces) if "engine" in row}
        theirs = rates.get("Cycles")
        rows += [
            [
                bounces,
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


def overview(results: dict[str, Result]) -> list[str]:
    """Geometric means over all scenes."""
    rows = [
        [
            light,
            label,
            *(
                results[name].summary.get(f"{metric}_ratio_{peer.lower().replace(' ', '_')}_{key}_{kind}")
                for peer in PEERS
                for kind in ("equal_time", "equal_samples")
            ),
        ]
        for name, (light, key) in LIGHT.items()
        if name in results
        for metric, label in METRICS.items()
    ]
    rows = [row for row in rows if any(value is not None for value in row[2:])]
    if not rows:
        return []
    return [
        "Cycles' error to ours, geometric means over the scenes; above 1, ours is less:\n",
        table(
            [
                "",
                "measure",
                "volume, equal time",
                "volume, equal samples",
                "mesh light, equal time",
                "mesh light, equal samples",
            ],
            rows,
        ),
    ]


# Result: a sentence, in which the numbers of its summary stand by their names.
SENTENCES = {
    "lamps": "Full renders at equal time, direct light and four bounces: the paper's sampler has {mse_ratio_paper_direct_geomean} and "
    "{mse_ratio_paper_bounces_geomean} times our relMSE over S1 to S5, {mse_ratio_paper_direct_min} and "
    "{mse_ratio_paper_bounces_min} times at least in all scenes; denoised, Cycles has "
    "{mse_ratio_both_denoised_direct_geomean} and {mse_ratio_both_denoised_bounces_geomean} times our error.",
    "estimators": "Samplers at points: {efficiency_gain_geomean} times the efficiency of the paper's, in the geometric mean; "
    "{efficiency_gain_min} times at least.",
    "intervals": "Crossings of rays: a fraction of {wrong_crossing_fraction_certified} of {rays_certified} rays through "
    "shapes with a proven bound has a wrong number of them; the published rule takes "
    "{evaluations_ratio_paper_to_ours} times as many evaluations at the same resolution.",
    "throughput": "Samples a second: {samples_per_second_ratio_to_cycles_direct} times those of Cycles with direct light, "
    "{samples_per_second_ratio_to_cycles_4_bounces} times with four bounces.",
    "scaling": "Time at equal error: {time_ratio_1000_to_10_lamps} times as long for 1,000 lamps as for 10, "
    "{time_ratio_1000000_to_1000_triangles} times for a million triangles as for a thousand.",
    "hard": "Hard cases: {hard_cases_failed} of {hard_cases} limits do not hold.",
}


def lacking(results: dict[str, Result]) -> list[str]:
    """Parts that are missing on this page."""
    absent = [name for name in RUNS if name not in results]
    found = [f"- **Not measured: {listed(absent)}.**"] if absent else []
    for name in (*LIGHT, "paper"):
        rows = [row for row in results[name].rows if "method" in row] if name in results else []
        unknown = [label for metric, label in METRICS.items() if rows and all(row.get(metric) is None for row in rows)]
        if unknown:
            found.append(f"- **{listed(unknown)} of `{name}` {'was' if len(unknown) == 1 else 'were'} not measured.**")
    return ["\n".join(found) + "\n"] if found else []


def sentences(results: dict[str, Result]) -> list[str]:
    """The conclusion of each result."""
    found = []
    for name, sentence in SENTENCES.items():
        values = {key: number(value) for key, value in results[name].summary.items()} if name in results else {}
        if all(key in values for _, key, *_ in string.Formatter().parse(sentence) if key):
            found.append(f"- {sentence.format(**values)}")
    return ["\n".join(found) + "\n"] if found else []


def machines(results: dict[str, Result]) -> str:
    keys = list(dict.fromkeys(key for result in results.values() for key in result.machine))
    return table(
        ["result", *keys],
        [[name, *(str(result.machine.get(key, "–")) for key in keys)] for name, result in results.items()],
    )


def drawn(results: dict[str, Result], images: pathlib.Path) -> str:
    """Whether the images are of these results."""
    unknown, others = records.compared(results, images)
    return IMAGES + "".join(
        f"{sentence} {listed([f'`{name}`' for name in names])}.\n"
        for sentence, names in (
            ("These were drawn before they did, and may be of earlier renders:", unknown),
            ("**These are of other results:**", others),
        )
        if names
    )


def text(results: dict[str, Result], images: pathlib.Path, page: pathlib.Path) -> str:
    """The content of the page, from results and the plots in ``images``."""
    parts = [INTRODUCTION, *overview(results), *sentences(results), *lacking(results)]
    for name, result in results.items():
        if name in LIGHT:
            parts += race(result, images, page)
        elif name == "paper":
            parts += paper(result, images, page)
        elif name in ("intervals", "scaling"):
            parts += dict(intervals=intervals, scaling=scaling)[name](result, images, page)
        elif name.startswith("lamps"):
            parts += lamps(result)
        else:
            own = dict(estimators=estimators, throughput=throughput, hard=hard)
            parts += own.get(name, figures)(result)
    parts += ["## Machine\n", MACHINES, machines(results), drawn(results, images)]
    return "\n".join(part for part in parts if part)
