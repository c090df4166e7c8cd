# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the tables in the documents that are generated from the program or from kept results of benchmarks: run it
after changes of settings, passes, the settings copied from Cycles, or docs/report.

A test fails if they differ.
"""

from __future__ import annotations

import dataclasses
import enum
import pathlib
from collections.abc import Callable

import host
from reporting import data_tables

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]


def settings_table() -> str:
    from sdf_lights.render.settings import Settings

    lines = ["| `scene.sdf_lights.` | default | |", "|---|---|---|"]
    for field in dataclasses.fields(Settings):
        if field.metadata["developer"]:
            continue
        default = field.default.value if isinstance(field.default, enum.Enum) else field.default
        lines.append(f"| `{field.name}` | {default} | {field.metadata['description']} |")
    return "\n".join(lines)


def passes_table() -> str:
    from sdf_lights.render.passes import PASSES

    lines = ["| pass | channels | |", "|---|---|---|"]
    lines += [f"| {item.name} | {item.channels} | {item.description} |" for item in PASSES]
    return "\n".join(lines)


def copied_table() -> str:
    from sdf_lights.blender import cycles_table

    return cycles_table.table()


def rest_table() -> str:
    from sdf_lights.blender import cycles_table

    return cycles_table.rest()


def nodes_table() -> str:
    from sdf_lights.render.nodes import reference

    return reference.markdown()


# The tables of each document, by the names in their marks.
TABLES: dict[pathlib.Path, dict[str, Callable[[], str]]] = {
    REPOSITORY / "docs" / "settings.md": {"settings": settings_table, "passes": passes_table},
    REPOSITORY / "docs" / "materials.md": {"nodes": nodes_table},
    REPOSITORY / "docs" / "lamps.md": data_tables.TABLES,
    REPOSITORY / "docs" / "cycles.md": {"copied": copied_table, "rest": rest_table},
}


def with_tables(document: pathlib.Path) -> str:
    """The text of a document with every table between its two marks written again."""
    text = document.read_text(encoding="utf-8")
    for name, table in TABLES[document].items():
        start, end = f"<!-- {name}: made by scripts/readme_tables.py -->", f"<!-- end of {name} -->"
        before, mark, rest = text.partition(start)
        _, closing, after = rest.partition(end)
        if not (mark and closing):
            raise ValueError(f"{document.name} lacks the marks of the table of {name}.")
        text = f"{before}{start}\n{table()}\n{end}{after}"
    return text


if __name__ == "__main__":
    for path in TABLES:
        path.write_text(with_tables(path), encoding="utf-8")
    host.finish(0)
