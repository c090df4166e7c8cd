# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node cases compared in a process of their own: where an engine crashes, one case is lost and not the run.

Results come case by case over a pipe. When the process ends before all are there, what it was rendering then is rendered
again in halves, until the case is known at which it ends.
"""

from __future__ import annotations

import json
import os
import pathlib
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable

Told = Callable[[str], None]


def rows_of(cases: list, samples: int, rounds: int, options, told: Told) -> list[dict]:
    """Rows of all cases, in their order; those at which a process ended have an error."""
    from . import node_pictures

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
    """Add the rows of cases to ``rows``, as far as a new process comes; how it ended."""
    process = subprocess.Popen(
        [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8"
    )
    with process, process.stdin as wishes:
        wishes.write(json.dumps(wish | dict(names=[case.name for case in cases])))
        wishes.close()
        for line in process.stdout:
            kind, what = json.loads(line)
            if kind == "told":
                told(what)
            else:
                rows[what["case"]] = what
    if process.returncode >= 0:
        return f"The process ended with code {process.returncode}"
    return f"The process ended with {signal.Signals(-process.returncode).name}"


def main() -> None:
    """Compare the cases that standard input names; lines of standard output are ["told", text] or ["row", row]."""
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])
    wish = json.load(sys.stdin)
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as results:
        os.dup2(2, 1)  # what Blender prints is no result
        import host

        host.register_extension()
        from benchmarks import node_cases, node_pictures, node_sheets

        def send(kind: str, what) -> None:
            results.write(json.dumps([kind, what]) + "\n")
            results.flush()

        names = set(wish["names"])
        cases = [case for case in node_cases.cases() if case.name in names]
        for pair in node_pictures.render_all(
            cases, wish["samples"], wish["device"], lambda text: send("told", text), wish["fresh"], wish["rounds"]
        ):
            if wish["sheets"] and pair.whole:
                node_sheets.keep(pair.case.name, *(pair.mean(engine) for engine in node_pictures.ENGINES))
            send("row", pair.row())
    host.finish(0)


if __name__ == "__main__":
    try:
        main()
    except Exception:
        traceback.print_exc()
        os._exit(1)  # as ``host.finish`` does
