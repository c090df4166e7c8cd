# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The section of the report on error against time, beside Cycles."""

from __future__ import annotations

import math
import pathlib

from .prose import LIGHT, OURS, PAPER, PEERS, heading, listed, number, reached, settings, shown, table
from .results import METHODS, METRICS, Result

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
