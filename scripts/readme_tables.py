# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the README's tables of settings and passes from the program: run it after changing either.

A test fails while they differ.
"""

from __future__ import annotations

import dataclasses
import enum
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
README = REPOSITORY / "README.md"


def settings_table() -> str:
    from sdf_lights.render.settings import Settings

    lines = ["| `scene.sdf_lights.` | default | |", "|---|---|---|"]
    for field in dataclasses.fields(Settings):
        default = field.default.value if isinstance(field.default, enum.Enum) else field.default
        lines.append(f"| `{field.name}` | {default} | {field.metadata['description']} |")
    return "\n".join(lines)


def passes_table() -> str:
    from sdf_lights.render.passes import PASSES

    lines = ["| pass | channels | |", "|---|---|---|"]
    lines += [f"| {item.name} | {item.channels} | {item.description} |" for item in PASSES]
    return "\n".join(lines)


def with_tables(text: str) -> str:
    """The README ``text`` with every table between its two marks made anew."""
    for name, table in (("settings", settings_table()), ("passes", passes_table())):
        start, end = f"<!-- {name}: made by scripts/readme_tables.py -->", f"<!-- end of {name} -->"
        before, mark, rest = text.partition(start)
        _, closing, after = rest.partition(end)
        if not (mark and closing):
            raise ValueError(f"README.md lacks the marks of the table of {name}.")
        text = f"{before}{start}\n{table}\n{end}{after}"
    return text


if __name__ == "__main__":
    sys.path.insert(0, str(REPOSITORY))
    README.write_text(with_tables(README.read_text(encoding="utf-8")), encoding="utf-8")
