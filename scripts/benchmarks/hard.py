# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases of ``hard_cases``: one row each, with its figure, its limit, and whether it holds."""

from __future__ import annotations

import time

from . import some_of
from .hard_cases import CASES
from .resume import in_parts

HELP = "cases in which light is easily wrong or expensive, each with a figure and its limit"


BRIEF = dict(cases=[name for name, case in CASES.items() if not case.slow])


def arguments(parser) -> None:
    parser.add_argument(
        "--cases", type=some_of(CASES), metavar="CASES", help=f"with commas between; default: all of {', '.join(CASES)}"
    )


def measured(name: str, quick: bool) -> dict:
    """A row. A case that cannot be measured has failed, and gives the reason."""
    case = CASES[name]
    started = time.perf_counter()
    row = dict(case=name, kind=case.kind, measures=case.about, figure=None, limit=None, holds=False)
    try:
        figure = case.measure(quick)
    except Exception as error:
        return row | dict(seconds=time.perf_counter() - started, error=f"{type(error).__name__}: {error}")
    more = {key: float(value) for key, value in figure.more.items()}
    return (
        row
        | dict(
            figure=float(figure.value),
            limit=float(figure.limit),
            holds=figure.holds,
            seconds=time.perf_counter() - started,
        )
        | more
    )


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each failed case, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "measures" in row and not row["holds"]:
            what = row.get("error") or f"{row['figure']:.3g} is above its limit of {row['limit']:.3g}"
            said.append(f"{row['case']}: {what} ({row['measures']})")
    return said


def run(options) -> tuple[dict, list[dict]]:
    names = options.cases or list(CASES)
    rows = in_parts(names, lambda name: measured(name, options.quick), options)
    summary = dict(hard_cases=len(rows), hard_cases_failed=len(complaints(rows)))
    ratios = {
        f"{row['case'].replace('-', '_')}_ratio": row["figure"]
        for row in rows
        if row["case"].endswith("-cost") and row["figure"] is not None
    }
    return summary | ratios, rows
