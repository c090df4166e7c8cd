# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every line of docs/trust.md that says what holds what is read has tests, and they exist."""

import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
PAGE = (REPOSITORY / "docs" / "trust.md").read_text(encoding="utf-8")
LINES = [
    line.strip().strip("|").split("|")
    for line in PAGE.partition("## Inputs and their sources")[2].partition("The add-on never")[0].splitlines()
    if line.startswith("|") and "---" not in line
][1:]


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[0].strip())
def test_what_is_read_is_tested(line):
    assert len(line) == 4
    names = re.findall(r"`([\w/.]+)`", line[3])
    assert names or "extension's own" in line[1]
    sources = "\n".join(
        path.read_text(encoding="utf-8") for path in (REPOSITORY / "tests" / "blender").glob("test_*.py")
    )
    for name in names:
        found = (REPOSITORY / name).is_file() if "/" in name else f"def {name}(" in sources
        assert found, name


LIMITS = [
    line.strip().strip("|").split("|")
    for line in PAGE.partition("## Limits")[2].partition("Lamps, each")[0].splitlines()
    if line.startswith("|") and "---" not in line
][1:]


@pytest.mark.parametrize("line", LIMITS, ids=lambda line: line[0].strip())
def test_what_is_beyond_a_limit_is_tested(line):
    _, _, beyond, tests = line
    names = re.findall(r"`(\w+)`", tests)
    assert bool(names) == bool(beyond.strip())
    sources = "\n".join(path.read_text(encoding="utf-8") for path in (REPOSITORY / "tests").rglob("test_*.py"))
    assert [name for name in names if f"def {name}(" not in sources] == []


@pytest.mark.parametrize("name", ["tried", "builds", "lamps", "pictures", "scenes", "soak"])
def test_the_figures_are_there(name):
    table = PAGE.partition(f"<!-- {name}: made by scripts/bench trust -->")[2].partition(f"<!-- end of {name} -->")[0]
    rows = [line for line in table.splitlines() if line.startswith("|")]
    assert len(rows) > 3
    if name == "tried":
        assert all(int(row.split("|")[5].replace(",", "")) == 0 for row in rows[2:]), "a fault"
    if name == "soak":
        for row in rows[2:]:
            assert all(int(number) <= 0 for number in row.split("|")[9:11]), "threads and handles"
        assert int(rows[2].split("|")[8]) <= 50, "MB, with the C library's allocator"
