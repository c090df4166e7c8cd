# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Worked examples of the expression language: text files of this folder, each with a title in its first line."""

from __future__ import annotations

import functools
import pathlib
from typing import NamedTuple


class Example(NamedTuple):
    """An expression; ``text`` begins with ``# title``."""

    title: str
    text: str


@functools.cache
def examples() -> dict[str, Example]:
    """Every example by the name of its file without the suffix, in alphabetical order."""
    return read(pathlib.Path(__file__).parent)


def read(folder: pathlib.Path) -> dict[str, Example]:
    """The text files of a folder."""
    found = {}
    for path in sorted(folder.glob("*.txt")):
        text = path.read_text(encoding="utf-8")
        found[path.stem] = Example(text.splitlines()[0].removeprefix("#").strip(), text)
    return found
