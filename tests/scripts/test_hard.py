# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every hard case of the benchmark keeps its limit; and the closed forms that some are compared with hold."""

import dataclasses
import json

import numpy as np
import pytest
from benchmarks.hard_cases import CASES, Figure, attraction

from support import glsl
from support.scenes import rotation, scaling, translation

# The same as others but dearer: `bench hard` has them.
APART = "flicker-bounces-of-one-seed", "flicker-bounces-against-the-paper", "finer-noise-cost"


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if case.slow else ())
        for name, case in CASES.items()
        if name not in APART
    ],
)
def test_case(name):
    case = CASES[name]
    if case.blender:
        pytest.importorskip("bpy")
    if case.opengl:
        glsl.context()
    figure = case.measure(True)
    assert figure.holds, f"{figure.value:.4g} is above {figure.limit:.4g}: {case.about}; {figure.more}"


def test_the_command_tells_what_holds_and_fails_where_something_does_not(tmp_path, monkeypatch):
    pytest.importorskip("bpy")
    import bench

    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))
    cases = {name: CASES[name] for name in ("near-tangent-lengths", "noise-evaluations")}
    arguments = ["hard", "--quick", "--cases", ",".join(cases), "--out", str(tmp_path / "out.json")]
    assert bench.main(arguments) == 0
    result = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert result["summary"] == dict(hard_cases=2, hard_cases_failed=0)
    assert [row["case"] for row in result["rows"]] == list(cases) and all(row["holds"] for row in result["rows"])

    def broken(quick):
        raise ValueError("no such lamp")

    monkeypatch.setitem(CASES, "noise-evaluations", dataclasses.replace(cases["noise-evaluations"], measure=broken))
    monkeypatch.setitem(
        CASES,
        "near-tangent-lengths",
        dataclasses.replace(cases["near-tangent-lengths"], measure=lambda quick: Figure(np.float64(2.0), 1.0)),
    )
    assert bench.main(arguments) == 1
    result = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert result["summary"]["hard_cases_failed"] == 2
    assert "no such lamp" in result["rows"][1]["error"]


def test_each_case_says_what_it_measures_in_one_line():
    assert all(case.about and "\n" not in case.about for case in CASES.values())


def test_what_is_not_a_number_holds_no_limit():
    assert Figure(1.0, 1.0).holds
    assert not Figure(np.nan, 1.0).holds and not Figure(1.1, 1.0).holds and not Figure(np.inf, np.inf).holds


def quadrature(inside, low, high, points, count=60):
    """∫ z / r³ dV over the points of a grid that are ``inside``, by the midpoint rule."""
    steps = [a + (np.arange(count) + 0.5) / count * (b - a) for a, b in zip(low, high)]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[inside(grid)]
    offsets = grid[None] - points[:, None]
    volume = np.prod(np.subtract(high, low)) / count**3
    return volume * (offsets[..., 2] / np.linalg.norm(offsets, axis=2) ** 3).sum(axis=1)


def test_a_ball_attracts_like_a_point_outside_and_by_its_core_inside():
    matrix = translation(0.0, 0.0, 2.0) @ scaling(0.5, 0.5, 0.5)
    points = np.array([(0.0, 0.0, 0.0), (3.0, 0.0, 2.0), (0.0, 0.0, 1.8)])
    found = attraction.of_ellipsoid(matrix, points, (0.0, 0.0, 1.0))
    assert found == pytest.approx([0.25, 0.0, 0.2 / 0.5**3], rel=1e-12, abs=1e-15)


def test_an_ellipsoid_attracts_as_the_sum_of_its_parts():
    matrix = translation(0.1, 0.2, 1.0) @ rotation("x", 30.0) @ scaling(0.9, -0.3, 0.5)
    points = np.array([(0.0, 0.0, 0.0), (0.7, -0.4, -0.2)])
    inverse = np.linalg.inv(matrix)

    def inside(x):
        return np.linalg.norm(x @ inverse[:3, :3].T + inverse[:3, 3], axis=1) < 1.0

    volume = 4.0 / 3.0 * np.pi * abs(np.linalg.det(matrix))
    expected = quadrature(inside, (-0.9, -0.8, 0.3), (1.1, 1.2, 1.7), points) / volume
    assert attraction.of_ellipsoid(matrix, points, (0.0, 0.0, 1.0)) == pytest.approx(expected, rel=5e-3)


def test_a_box_attracts_as_the_sum_of_its_parts():
    low, high = (-0.4, -0.3, 0.1), (0.5, 0.3, 0.7)
    points = np.array([(0.0, 0.0, 0.0), (0.4, 0.1, -0.3), (0.9, -0.7, 0.0)])
    expected = quadrature(lambda x: np.ones(len(x), bool), low, high, points)
    assert attraction.of_box(low, high, points, 2.0) == pytest.approx(2.0 * expected, rel=2e-3)
