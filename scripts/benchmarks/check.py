# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that nothing has become less efficient: ratios that do not depend on the machine, compared with the committed
ones.

Every ratio compares with something measured in the same process, and greater is better. Most are counts and variances
with fixed seeds, the same on every run; only the change of the code changes them. Timed ratios use medians of turns,
and a loss counts only if it is confirmed when measured again.
"""

from __future__ import annotations

import json
import pathlib

from . import some_of
from .ratios import RATIOS
from .resume import in_parts

HELP = "efficiency against committed ratios; exit code 1 where more than 20 % is lost"

EXPECTED = pathlib.Path(__file__).with_name("expected.json")
LOSS = 0.2
TRIES = 3  # measurements of a timed ratio that seems to have fallen


def arguments(parser) -> None:
    parser.add_argument(
        "--ratios",
        type=some_of(RATIOS),
        metavar="RATIOS",
        help=f"with commas between; default: all of {', '.join(RATIOS)}; --quick: fewer",
    )
    parser.add_argument("--write", action="store_true", help="commit the measured ratios: write them to expected.json")


def expected() -> dict[str, float]:
    return json.loads(EXPECTED.read_text(encoding="utf-8")) if EXPECTED.is_file() else {}


def lost(found: float, committed: float | None) -> bool:
    """Also if nothing is committed, or the found value is not a number."""
    return committed is None or not found >= (1.0 - LOSS) * committed


def measured(name: str, committed: float | None) -> float:
    ratio = RATIOS[name]
    found = ratio.measure()
    for _ in range(TRIES - 1 if ratio.timed and committed is not None else 0):
        if not lost(found, committed):
            break
        found = max(found, ratio.measure())
    return found


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each ratio that has fallen, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "ratio" in row and row.get("lost"):
            if row["expected"] is None:
                said.append(
                    f"{row['ratio']} is {row['found']:.4g}, and nothing is committed to compare it with: "
                    "run `bench check --write`."
                )
            else:
                said.append(
                    f"{row['ratio']} has fallen from {row['expected']:.4g} to {row['found']:.4g}, by "
                    f"{100.0 * (1.0 - row['found'] / row['expected']):.0f} %."
                )
    return said


def run(options) -> tuple[dict, list[dict]]:
    names = options.ratios or [name for name, ratio in RATIOS.items() if ratio.quick or not options.quick]
    committed = {} if options.write else expected()
    found = dict(zip(names, in_parts(names, lambda name: measured(name, committed.get(name)), options)))
    if options.write:
        found = {name: float(f"{value:.4g}") for name, value in found.items()}
        kept = {name: value for name, value in expected().items() if name in RATIOS}
        committed = kept | found
        EXPECTED.write_text(json.dumps(dict(sorted(committed.items())), indent=1) + "\n", encoding="utf-8")
    rows = [
        dict(
            ratio=name,
            timed=RATIOS[name].timed,
            found=value,
            expected=committed.get(name),
            lost=lost(value, committed.get(name)),
        )
        for name, value in found.items()
    ]
    return dict(ratios_checked=len(rows), ratios_lost=sum(row["lost"] for row in rows)), rows
