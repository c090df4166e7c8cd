# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of the report. Every number in it is read from results; results also select the sentences that judge."""

from __future__ import annotations

import pathlib
import string

from . import records
from .prose import LIGHT, PEERS, listed, number, table
from .race import race
from .results import METRICS, RUNS, Result
from .sampling_sections import estimators, lamps, paper
from .sections import figures, hard, intervals, scaling, throughput

INTRODUCTION = """\
# Speed against error

Written by `./scripts/report` from the results in [report](report). Above each part stands the command that measured it;
`./scripts/report --run` measures all of it again. [scripts/README.md](../scripts/README.md) says what each benchmark
measures and how. Scenes S1 to S5 are a stage with one lamp: a torus; the same, half sunk in the floor; a thin frame;
Menger's sponge; a stretched torus.

Of a picture x and its reference r with mean r̄, relMSE is the mean of (x − r)² / (r² + 0.01 r̄²) and MAPE that of
|x − r| / (r + 0.01 r̄), both scene-linear; FLIP is LDR-FLIP of both as sRGB, clipped.
"""

MACHINES = """\
Results are of the revisions in this table; a + after one says that files had been changed.
"""

IMAGES = """\
Images say as PNG text, `Result`, which result they were drawn from, with its hash.
"""


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
