# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers, tables, lists and headings, as the report writes them."""

from __future__ import annotations

import math
import pathlib

from .results import Result

OURS, PAPER = "CUT", "MIS"
PEERS = ("Cycles volume", "Cycles mesh light")
LIGHT = {
    "cycles_direct": ("Direct light", "direct"),
    "cycles_bounces": ("Four bounces", "bounces"),
    "corridor": ("Lamps of data in a corridor, direct light", "direct"),
}
DRAWN = (*LIGHT, "paper", "intervals", "scaling")  # results that have plots
TENTH = 0.1  # standard error of a reference at which it is good enough, relative to the least error that it judges


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


def summary(result: Result) -> str:
    """The numbers of a result by their names."""
    return table(["figure", "value"], [[f"`{name}`", value] for name, value in result.summary.items()])
