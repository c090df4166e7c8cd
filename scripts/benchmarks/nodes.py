# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares every shader node in every mode with Cycles, and materials of many nodes: differences of pictures, and
costs.

A node is shown as a tile of one picture: as the light of an object, or as the surface, volume or displacement of a ball
under a lamp. ``node_cases`` lists the cases, ``node_pictures`` compares them. A material has its own scene, which both
engines render in turns.
"""

from __future__ import annotations

import argparse
import functools
import pathlib
import statistics

from . import methods, node_rows, some_of
from .isolation import Isolated
from .node_limits import over
from .progress import Progress
from .resume import Parts

HELP = "every shader node and 40 materials beside Cycles: differences, samples a second, error by time"

# Parts of the run, with the kinds of their cases.
PARTS = {
    "values": ("value", "rays"),
    "lit": ("scattered", "closure", "volume", "displacement"),
    "worlds": ("world", "light"),
    "materials": (),
    "compiling": (),
}
LIT_SAMPLES, QUICK_LIT_SAMPLES = 32, 8  # of each render, at first
LIT_ROUNDS, QUICK_LIT_ROUNDS = 2, 2  # of more samples, where noise leaves cases in doubt
QUICK_WORLDS = 4  # one of so many worlds and lights
# Of all parts together; of materials alone, a quick run has all of them.
QUICK_MATERIALS = ("car_paint", "leaf", "oak", "brick", "dirty_glass", "skin", "neon_sign", "terrain")
BRIEF = dict(parts=["values"])


def words(text: str) -> list[str]:
    return [word.strip().lower() for word in text.split(",") if word.strip()]


def arguments(parser) -> None:
    parser.add_argument(
        "--parts", type=some_of(PARTS), metavar="PARTS", help=f"with commas between; default: all of {', '.join(PARTS)}"
    )
    parser.add_argument(
        "--like", type=words, metavar="WORDS", help="only cases and materials with one of these in their names"
    )
    parser.add_argument("--first", action="store_true", help="only the first case of each node, as with --quick")
    parser.add_argument(
        "--sheets", type=pathlib.Path, metavar="FOLDER", help="write contact sheets: Cycles left, ours right"
    )
    parser.add_argument(
        "--document", action="store_true", help="write pictures and a table of the materials into docs/materials.md"
    )
    parser.add_argument("--table", type=pathlib.Path, metavar="FILE", help="write a table of all nodes, as Markdown")
    methods.picture_arguments(parser)


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each node that differs without explanation, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "case" in row and "p99" in row and over(row) and not row["explained"]:
            differs = (
                row["error"] or f"differs by {_percent(row['mean_difference'])}, 99th percentile {_percent(row['p99'])}"
            )
            said.append(f"{row['case']}: {differs.rstrip('.')}. {row['warning']}".rstrip())
    return said


def _percent(part: float) -> str:
    return f"{100.0 * part:.2g} %"


def summary_of(rows: list[dict]) -> dict:
    """The figures of the issue, from the available rows."""
    cases = [row for row in rows if "p99" in row]
    materials = [row for row in rows if "material" in row]
    compiling = next((row for row in rows if "compiled_materials" in row), None)
    summary = {}
    if compiling:
        summary |= {f"compile_{name}": value for name, value in compiling.items() if name.startswith("seconds")}
        summary["graphs_compiled_after_changes"] = compiling["graphs_compiled_after_changes"]
    if cases:
        wrong = [row for row in cases if over(row)]
        summary |= dict(
            nodes=len({row["node"] for row in cases}),
            node_cases=len(cases),
            nodes_over_one_percent=sum(not row["explained"] for row in wrong),
            nodes_explained=sum(bool(row["explained"]) for row in wrong),
        )
    if materials:
        differences = [row["mean_difference"] for row in materials]
        summary |= dict(materials=len(materials), materials_failed=differences.count(None))
        known = [row for row in materials if row["mean_difference"] is not None]
        if known:
            summary["materials_worst_mean_difference"] = max(row["mean_difference"] for row in known)
            ratios = [row["samples_ratio"] for row in known]
            summary |= dict(
                samples_ratio_to_cycles_geomean=statistics.geometric_mean(ratios),
                samples_ratio_to_cycles_min=min(ratios),
                error_time_ratio_to_cycles_geomean=statistics.geometric_mean(row["error_time_ratio"] for row in known),
            )
    return summary


def run(options) -> tuple[dict, list[dict]]:
    from . import material_compile, node_sheets

    wanted = options.parts or list(PARTS)
    groups = {part: _cases(part, options) for part in wanted if PARTS[part]}
    names = _materials(options) if "materials" in wanted else []
    progress, parts, rows = Progress(sum(map(bool, groups.values())) + max(len(names), 0) or 1), Parts(options), []
    for part, cases in groups.items():
        if cases:
            rows += parts.of(part, functools.partial(_compared, part, cases, options, progress))
            progress.step()
    other = Isolated()
    for name in names:
        progress.show(name)
        rows.append(parts.of(f"material {name}", functools.partial(_material, name, options, other)))
        progress.step()
    other.close()
    if "compiling" in wanted and not options.like:
        progress.show("compiling")
        rows.append(parts.of("compiling", functools.partial(material_compile.measured, options.quick)))
    if options.sheets:
        node_sheets.join(options.sheets, groups, names)
    made = [row for row in rows if "material" in row]
    if options.document and made:
        node_sheets.document(made, summary_of(rows))
    if options.table:
        options.table.write_text(node_sheets.table(rows), encoding="utf-8")
    parts.finish()
    progress.close()
    return summary_of(rows), rows


def _like(name: str, options) -> bool:
    return not options.like or any(word in name.lower() for word in options.like)


def _cases(part: str, options) -> list:
    from . import node_cases

    found = [case for case in node_cases.cases() if case.place in PARTS[part] and _like(case.name, options)]
    brief = options.first or (options.quick and not options.like)
    found = first_of_each_node(found) if brief else found
    return found[::QUICK_WORLDS] if options.quick and brief and part == "worlds" else found


def first_of_each_node(cases: list) -> list:
    return list({case.node: case for case in reversed(cases)}.values())[::-1]


def _materials(options) -> list[str]:
    from .materials import MATERIALS

    return [
        name
        for name in MATERIALS
        if _like(name, options)
        and (not options.quick or options.like or options.parts == ["materials"] or name in QUICK_MATERIALS)
    ]


def _compared(part: str, cases: list, options, progress: Progress) -> list[dict]:
    samples, rounds = (QUICK_LIT_SAMPLES, QUICK_LIT_ROUNDS) if options.quick else (LIT_SAMPLES, LIT_ROUNDS)
    return node_rows.rows_of(cases, samples, rounds, options, lambda text: progress.show(f"{part}: {text}"))


def _material(name: str, options, other: Isolated) -> dict:
    from . import material_pictures

    given = argparse.Namespace(
        **{key: getattr(options, key) for key in ("size", "quick", "repeats", "device", "reference_seconds", "fresh")},
        sheets=bool(options.sheets or options.document),
    )
    try:
        return other.call(material_pictures.measure, name, given)
    except RuntimeError as error:
        return material_pictures.failed(name, str(error))
