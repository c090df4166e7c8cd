# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attacks that the program survived, build times of the worst lamps, memory of pictures and scenes, and leaks after
hours of work.

Inputs (``trust_inputs``) are random, with fixed seeds. Each must give a result or a sentence. Anything else is a fault,
and the command fails.
"""

from __future__ import annotations

import pathlib
import tempfile
import time

import host
import numpy as np
from sessions import seen_by

from . import isolation, some_of, trust_limits
from .progress import Progress
from .soaking import C_LIBRARY
from .trust_inputs import TRIED

HELP = "inputs tried, faults survived, time of the worst lamps, memory of pictures and scenes"

PARTS = ("tried", "builds", *trust_limits.PARTS, "soak")
CHUNKS = 10  # parts of the inputs of a kind
STEPS, SECONDS = 500, 780.0  # of the soak, and its maximum time
SOAK = pathlib.Path(__file__).with_name("soak_session.py")
SOAK_HEADS = (
    "allocator of|steps|before they count|renders|cancels|undos|MB at the end|more MB|more threads|more handles|min"
)
DOCUMENT = host.REPOSITORY / "docs" / "trust.md"
MEGABYTE = 1e6


def arguments(parser) -> None:
    """Options of its own."""
    parser.add_argument(
        "--parts", type=some_of(PARTS), default=list(PARTS), help=f"of {','.join(PARTS)}; all unless given"
    )
    parser.add_argument(
        "--inputs", default="", help="kinds of inputs that are tried, by a word of their names; all unless given"
    )
    parser.add_argument("--document", action="store_true", help="write the tables into docs/trust.md")


def builds() -> list[dict]:
    """Processor time of slow lamps, and the longest time in which a thread does not check for a cancel."""
    import threading

    from sdf_lights.emitter.building.build import build_lamp
    from sdf_lights.interruption import Watch, watched
    from sdf_lights.sdf.expression import evaluate
    from support.lamps.hard_cases import scattered

    def rounds(count: int, factor: float):
        text = (
            f"q = p\nfor i in range({count}):\n    q = q + 0.001 * sin({factor} * q)\nfield(length(q) - 1.5) & box(2)"
        )
        return evaluate(text)

    cases = {
        "2,000 primitives": lambda small: scattered(5 if small else 2000, seed=3, smooth=False),
        "2,000 primitives, blended": lambda small: scattered(5 if small else 2000, seed=3),
        "a loop of 1,000 rounds": lambda small: rounds(3 if small else 1000, 2.75),
    }
    rows = []
    for name, make in cases.items():
        build_lamp("Lamp", make(True), np.eye(4))  # compiles
        last: dict[int, float] = {}
        pauses = [0.0]

        def stop(last=last, pauses=pauses) -> bool:
            thread, now = threading.get_ident(), time.thread_time()
            pauses.append(now - last.get(thread, now))
            last[thread] = now
            return False

        started = time.process_time()
        shape = make(False)
        with watched(Watch(stop)):
            lamp = build_lamp("Lamp", shape, np.eye(4))
        arrays = (lamp.tree.nodes, lamp.tree.lists, lamp.tree.boxes)
        rows.append(
            dict(
                lamp=name,
                seconds=time.process_time() - started,
                longest_pause=max(pauses),
                megabytes=sum(array.nbytes for array in arrays) / MEGABYTE,
            )
        )
    return rows


def soak(quick: bool) -> list[dict]:
    """Resources of a Blender with a window after a third of its work, and at the end, with the C library's allocator
    and with its own. None if there is no such Blender."""
    command = host.windowed_blender()
    if command is None:
        print(f"The soak is left out: there is {host.NO_WINDOW}.")
        return []
    return [_soaked(command, "the C library", C_LIBRARY, quick), _soaked(command, "Blender", {}, quick)]


def _soaked(command: list[str], allocator: str, environment: dict[str, str], quick: bool) -> dict:
    steps, seconds = (STEPS, 30.0) if quick else (STEPS, SECONDS)
    with tempfile.TemporaryDirectory() as folder:
        found = seen_by(
            command,
            SOAK,
            pathlib.Path(folder),
            str(steps),
            str(seconds),
            "7",
            size=(800, 540),
            real_keys=True,
            environment=environment,
        )
    before, after, counts = found["before"], found["after"], found["counts"]
    return dict(
        allocator=allocator,
        steps=found["steps"],
        warm_up=found["steps of the warm-up"],
        renders=counts.get("render", 0),
        cancels=counts.get("escape", 0) + counts.get("give_up", 0),
        undos=counts.get("undo", 0),
        megabytes=after["memory"] / MEGABYTE,
        more_megabytes=(after["memory"] - before["memory"]) / MEGABYTE,
        more_threads=len(after["threads"]) - len(before["threads"]),
        more_handles=after["handles"] - before["handles"],
        minutes=found["seconds"] / 60.0,
    )


def tried(process: isolation.Isolated, what: str, quick: bool) -> dict:
    """Outcomes of all inputs of a kind, whose process may end."""
    attempt, count = TRIED[what]
    total = dict(tried=0, results=0, sentences=0, faults=0, worst_seconds=0.0, seconds=0.0)
    for seed in range(1 if quick else CHUNKS):
        size = max(count // (20 * CHUNKS), 1) if quick else count // CHUNKS
        try:
            found = process.call(attempt, size, seed)
        except RuntimeError as error:
            found = dict(tried=size, results=0, sentences=0, faults=size, worst_seconds=0.0, seconds=0.0)
            print(f"{what}: {error}")
        worst = max(total["worst_seconds"], found["worst_seconds"])
        total = {name: total[name] + found[name] for name in total} | dict(worst_seconds=worst)
    return dict(what=what) | total


def _table(rows: list[dict], heads: list[str], form) -> str:
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *("| " + " | ".join(form(row)) + " |" for row in rows)])


def document(rows: list[dict]) -> None:
    """Write the tables into docs/trust.md, between its marks."""

    def kept(name: str) -> list[dict]:
        return [{key: value for key, value in row.items() if key != "part"} for row in rows if row["part"] == name]

    tables = {
        "tried": _table(
            kept("tried"),
            ["what", "inputs", "gave a result", "gave a sentence", "faults", "longest, s", "all, s"],
            lambda row: [
                row["what"],
                *(f"{row[key]:,}" for key in ("tried", "results", "sentences", "faults")),
                f"{row['worst_seconds']:.2f}",
                f"{row['seconds']:.0f}",
            ],
        ),
        "builds": _table(
            kept("builds"),
            ["lamp", "processor time, s", "longest time between two looks for a cancel, s", "MB"],
            lambda row: [
                row["lamp"],
                f"{row['seconds']:.1f}",
                f"{row['longest_pause']:.2f}",
                f"{row['megabytes']:.0f}",
            ],
        ),
        "lamps": _table(
            kept("lamps"),
            ["lamps", "processor time, s", "KB of each"],
            lambda row: [f"{row['lamps']:,}", f"{row['seconds']:.1f}", f"{row['kilobytes_each']:.1f}"],
        ),
        "pictures": _table(
            kept("pictures"),
            ["pass", "MB of a megapixel", "GB of 16,384 × 16,384 pixels"],
            lambda row: [row["passes"], f"{row['megabytes_per_megapixel']}", f"{row['gigabytes_of_16k']:.1f}"],
        ),
        "scenes": _table(
            kept("scenes"),
            ["what", "number", "processor time, s", "bytes of each"],
            lambda row: [row["what"], f"{row['number']:,}", f"{row['seconds']:.1f}", f"{row['bytes_each']:.0f}"],
        ),
        "soak": _table(
            kept("soak"),
            SOAK_HEADS.split("|"),
            lambda row: [
                row["allocator"],
                *(f"{row[key]:,}" for key in ("steps", "warm_up", "renders", "cancels", "undos")),
                f"{row['megabytes']:.0f}",
                f"{row['more_megabytes']:.0f}",
                f"{row['more_threads']}",
                f"{row['more_handles']}",
                f"{row['minutes']:.1f}",
            ],
        ),
    }
    text = DOCUMENT.read_text(encoding="utf-8")
    for name in dict.fromkeys(row["part"] for row in rows):
        start, end = f"<!-- {name}: made by scripts/bench trust -->", f"<!-- end of {name} -->"
        before, mark, rest = text.partition(start)
        old, closing, after = rest.partition(end)
        if not (mark and closing):
            raise ValueError(f"{DOCUMENT.name} lacks the marks of {name}.")
        table = tables[name]
        if name == "tried":  # with only some kinds, their rows are replaced
            fresh = {line.split("|")[1]: line for line in table.splitlines()}
            table = "\n".join([fresh.pop(line.split("|")[1], line) for line in old.split("\n") if "|" in line])
            table = "\n".join([table, *fresh.values()]).strip()
        text = f"{before}{start}\n{table}\n{end}{after}"
    DOCUMENT.write_text(text, encoding="utf-8")


def run(options) -> tuple[dict, list[dict]]:
    """Rows of all parts; inputs run in another process, which may end."""
    progress, rows, process = Progress(len(TRIED) + len(PARTS) - 1), [], isolation.Isolated()
    for what in [name for name in TRIED if options.inputs in name] if "tried" in options.parts else ():
        progress.show(what)
        rows.append(dict(part="tried") | tried(process, what, options.quick))
        progress.step()
    process.close()
    measured = {"builds": lambda quick: builds(), **trust_limits.PARTS, "soak": soak}
    for name, part in measured.items():
        if name in options.parts:
            progress.show(name)
            rows += [dict(part=name) | row for row in part(options.quick)]
        progress.step()
    progress.close()
    if options.document:
        document(rows)
    inputs, built = ([row for row in rows if row["part"] == name] for name in ("tried", "builds"))
    return dict(
        inputs_tried=sum(row["tried"] for row in inputs),
        faults=sum(row["faults"] for row in inputs),
        worst_input_seconds=max((row["worst_seconds"] for row in inputs), default=0.0),
        worst_build_seconds=max((row["seconds"] for row in built), default=0.0),
        longest_pause_seconds=max((row["longest_pause"] for row in built), default=0.0),
    ), rows


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each kind of inputs with faults."""
    return [
        f"{row['faults']} of {row['tried']} {row['what']} gave neither a result nor a sentence."
        for row in rows
        if row["part"] == "tried" and row["faults"]
    ]
