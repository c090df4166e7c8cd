# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of docs/lamps.md on lamps that data make, from the results that the report keeps."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

from .prose import OURS, PEERS, load, number, table
from .results import Result, read

SCENES = {"text": "sign", "curve": "spring", "mesh": "statue", "picture": "logo", "network": "rabbit"}  # kind: of lamps


def _measured(name: str, table_of: Callable[[Result], str]) -> str:
    """The table of a result, or how to measure it."""
    result = read().get(name)
    return table_of(result) if result else f"Not measured yet: `./scripts/report --run {name}` does it."


def _with_command(result: Result, *parts: str) -> str:
    return "\n".join([f"    {result.command}\n", load(result), *parts]).rstrip("\n")


def _kinds(result: Result) -> str:
    """Crossings and the cost of a ray through each kind of lamp, and the error of Cycles; then other figures."""
    compared = {row["scene"]: row for row in result.rows if "cycles" in row}
    rows = []
    for row in result.rows:
        if "case" in row:
            beside = compared.get(SCENES.get(row["case"], ""), {})
            doubt = math.sqrt(beside["reference"]) if beside else None
            wrong = round(row["wrong"] * row["rays"])
            rows.append([row["case"], row["rays"], wrong, row["ns"], beside.get("cycles"), doubt])
    summary = result.summary
    costs = (
        f"A ray through a grid takes {number(summary['cost_ratio_grid_to_sponge'])} times as long as one through Menger's "
        f"sponge. One through 200 letters takes\n{number(summary['cost_ratio_200_to_1_letters'])} times as long as one "
        "through a letter.\n"
    )
    return _with_command(
        result,
        table(
            ["lamp", "rays", "wrong crossings", "ns a ray", "relMSE of Cycles to ours", "error of the reference"], rows
        ),
        costs,
    )


def _grids(result: Result) -> str:
    """The time to build grids of meshes."""
    keys = ("triangles", "voxels", "seconds_per_million", "processor_seconds_per_million", "megabytes_per_million")
    heads = ["mesh", "triangles", "voxels", "seconds a million", "processor seconds a million", "MB a million"]
    return _with_command(result, table(heads, [[row["grid_of"], *(row[key] for key in keys)] for row in result.rows]))


def _corridor(result: Result) -> str:
    """Errors at equal time in a corridor."""
    rows = []
    for row in result.rows:
        if f"rel_mse {OURS}" in row:
            ours, *theirs = (row[f"rel_mse {method}"] for method in (OURS, *PEERS))
            ratios = [None if error is None else error / ours for error in theirs]
            rows.append([row["scene"], row["seconds"], ours, *ratios, math.sqrt(row["reference"])])
    heads = ["scene", "seconds", "our relMSE", "emission volume", "mesh light", "error of the reference"]
    return _with_command(result, table(heads, rows))


TABLES_OF_RESULTS = {"kinds": _kinds, "grids": _grids, "corridor": _corridor}
TABLES = {name: functools.partial(_measured, name, table_of) for name, table_of in TABLES_OF_RESULTS.items()}
