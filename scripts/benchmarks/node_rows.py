# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares node cases in another process: if an engine crashes, one case is lost and not the run.

Results arrive case by case. If the process ends before all are there, the cases that it was rendering are rendered
again in halves, until the faulty case is found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import node_cases, node_pictures
from .isolation import Isolated

Told = Callable[[str], None]


def rows_of(cases: list, samples: int, rounds: int, options, told: Told) -> list[dict]:
    """Rows of all cases, in order; those at which a process ended have an error."""
    wish = dict(samples=samples, rounds=rounds, device=options.device, fresh=options.fresh, sheets=bool(options.sheets))
    rows: dict[str, dict] = {}
    waiting = [list(cases)]
    while waiting:
        batch = waiting.pop()
        ended = _run(batch, wish, rows, told)
        left = [case for case in batch if case.name not in rows]
        if not left:
            continue
        first = node_pictures.groups(left)[0]
        told(f"{ended}; looking for the case, of {len(first)}")
        if len(first) == 1:
            rows[first[0].name] = node_pictures.Pair(first[0], error=f"{ended}.").row()
        rest = [case for case in left if case not in first]
        middle = len(first) // 2
        waiting += [part for part in (rest, first[middle:] if middle else [], first[:middle]) if part]
    return [rows[case.name] for case in cases]


def _run(cases: list, wish: dict, rows: dict[str, dict], told: Told) -> str:
    """Add the rows of cases to ``rows``, as far as a new process gets; returns how it ended."""
    process = Isolated()
    try:
        for kind, what in process.stream(compared, [case.name for case in cases], wish):
            if kind == "told":
                told(what)
            else:
                rows[what["case"]] = what
    except RuntimeError as error:
        text = str(error)
        return text[0].upper() + text[1:]
    finally:
        process.close()
    return "The process ended without its results"


def compared(names: list[str], wish: dict) -> Iterator[tuple[str, object]]:
    """Compare the cases of these names: ("told", text) and ("row", row), as they come."""
    from . import node_sheets

    told: list[str] = []
    cases = [case for case in node_cases.cases() if case.name in set(names)]
    for pair in node_pictures.render_all(
        cases, wish["samples"], wish["device"], told.append, wish["fresh"], wish["rounds"]
    ):
        while told:
            yield "told", told.pop(0)
        if wish["sheets"] and pair.whole:
            node_sheets.keep(pair.case.name, *(pair.mean(engine) for engine in node_pictures.ENGINES))
        yield "row", pair.row()
