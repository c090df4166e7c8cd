# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node, in every mode that this Blender has, looks as in its Cycles: within 1 %, in the mean and the 99th
percentile.

Materials of many nodes are within 2 % in the mean.

Whole grids of nodes are rendered in a process of its own, by ``scripts/bench nodes``; each case is one test. The
default suite takes the first case of each node of values, the slow one all of them, and the first of each closure,
volume and displacement.
"""

import json
import pathlib
import subprocess
import sys

import pytest

bpy = pytest.importorskip("bpy")

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))

from benchmarks import node_cases, nodes  # noqa: E402  (found on the path set above)
from benchmarks.materials import MATERIALS  # noqa: E402

# Nodes, or single cases, that are not modelled yet. What is here and agrees with Cycles fails a test.
NOT_MODELLED: set[str] = set()


def _cases(*parts: str) -> list:
    places = [place for part in parts for place in nodes.PARTS[part]]
    return [case for case in node_cases.cases() if case.place in places]


def _named(cases: list) -> list:
    return [pytest.param(case, id=case.name) for case in cases]


@pytest.fixture(scope="module")
def rows_of(shared):
    """``rows_of(name, *arguments)`` are rows of the benchmark by the name of the case."""

    def rows(name: str, *arguments: str, key: str = "case") -> dict[str, dict]:
        def run(out: pathlib.Path) -> None:
            done = subprocess.run(
                [sys.executable, SCRIPTS / "bench.py", "nodes", "--out", out, *arguments],
                capture_output=True,
                text=True,
                timeout=1800,
            )
            assert done.returncode in (0, 1) and out.is_file(), done.stdout + done.stderr

        found = shared(f"{name}.json", run)
        return {row[key]: row for row in json.loads(found.read_text(encoding="utf-8"))["rows"]}

    return rows


def _listed(case) -> bool:
    return bool(NOT_MODELLED & {case.node, case.name})


def _check(case, row: dict) -> None:
    if _listed(case):
        pytest.skip("not modelled yet")
    assert row["error"] == "", row["error"]
    if not row["explained"]:
        told = f"mean {row['mean_difference']:.4f}, 99th percentile {row['p99']:.4f}. {row['warning']}"
        assert not nodes.over(row), told


@pytest.fixture(scope="module")
def first_values(rows_of):
    return rows_of("first_values", "--parts", "values", "--first")


@pytest.fixture(scope="module")
def values(rows_of):
    return rows_of("values", "--parts", "values,worlds")


@pytest.fixture(scope="module")
def closures(rows_of):
    return rows_of("closures", "--parts", "lit", "--quick", "--first")


@pytest.fixture(scope="module")
def artists_materials(rows_of):
    return rows_of("materials", "--parts", "materials", "--quick", key="material")


@pytest.mark.parametrize("case", _named(nodes.first_of_each_node(_cases("values"))))
def test_the_first_case_of_each_node_of_values(case, first_values):
    _check(case, first_values[case.name])


@pytest.mark.slow
@pytest.mark.parametrize("case", _named(_cases("values", "worlds")))
def test_values_are_those_of_cycles(case, values):
    _check(case, values[case.name])


@pytest.mark.slow
@pytest.mark.parametrize("case", _named(nodes.first_of_each_node(_cases("lit"))))
def test_closures_look_as_in_cycles(case, closures):
    _check(case, closures[case.name])


def _agrees(name: str, rows: dict[str, dict], cases: list) -> bool:
    """Whether all that stands for an entry of the list agrees with Cycles, and so the entry should go."""
    found = [rows[case.name] for case in cases if name in (case.node, case.name) and case.name in rows]
    return bool(found) and not any(nodes.over(row) for row in found)


@pytest.mark.slow
def test_what_is_listed_differs(values):
    cases = node_cases.cases()
    known = {case.node for case in cases} | {case.name for case in cases}
    assert [name for name in sorted(NOT_MODELLED) if name not in known or _agrees(name, values, cases)] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_of_many_nodes(name, artists_materials):
    row = artists_materials[name]
    assert row["error"] == "", row["error"]
    assert row["mean_doubt"] < 0.02
    assert row["mean_difference"] < 0.02 + 2.0 * row["mean_doubt"], row["warning"]
