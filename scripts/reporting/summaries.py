# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Summaries of results: what the report shows of them. The repository keeps these; all rows are build output."""

from __future__ import annotations

import dataclasses
import pathlib
import tempfile
from collections.abc import Callable

from . import data_tables, page
from .results import Result

DIGITS = 8  # of each number


class _Row(dict):
    """A row that notes in ``shown`` what is read of it, or asked for by ``in``."""

    def __init__(self, values: dict):
        super().__init__(values)
        self.shown = {}

    def __getitem__(self, key):
        value = super().__getitem__(key)
        self.shown[key] = value
        return value

    def get(self, key, default=None):
        return self[key] if super().__contains__(key) else default

    def __contains__(self, key):
        self.get(key)
        return super().__contains__(key)


def _rounded(value):
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def summarised(result: Result, draw: Callable[[dict[str, Result], pathlib.Path, pathlib.Path], None]) -> Result:
    """A result with only those rows, and of these only those values, that the page, the tables of docs/lamps.md, or the
    images read. It has the digest of all that was measured. ``draw(results, images, renders)`` draws the images."""
    noting = dataclasses.replace(result, rows=[_Row(row) for row in result.rows])
    with tempfile.TemporaryDirectory() as folder:
        images = pathlib.Path(folder)
        draw({result.name: noting}, images, images)
        page.text({result.name: noting}, images, images / "report.md")
    if result.name in data_tables.TABLES_OF_RESULTS:
        data_tables.TABLES_OF_RESULTS[result.name](noting)
    rows = [{key: _rounded(value) for key, value in row.shown.items()} for row in noting.rows if row.shown]
    summary = {key: _rounded(value) for key, value in result.summary.items()}
    return dataclasses.replace(result, summary=summary, rows=rows, full_digest=result.digest)
