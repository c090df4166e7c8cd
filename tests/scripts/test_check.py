# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The regression gate: what it lets through, what it stops, and with which words."""

import json
import math

import pytest

pytest.importorskip("bpy")

import bench
from benchmarks import check
from benchmarks.ratios import RATIOS, Ratio


@pytest.fixture
def gate(tmp_path, monkeypatch):
    """``gate(committed, measured…, timed=False) -> (complaints, measurements)`` of one ratio."""
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))
    monkeypatch.setattr(check, "EXPECTED", tmp_path / "expected.json")

    def judge(committed, *measured, timed=False, write=False):
        if committed is not None:
            check.EXPECTED.write_text(json.dumps({"speed": committed}), encoding="utf-8")
        turns = list(measured)
        monkeypatch.setattr(check, "RATIOS", {"speed": Ratio(lambda: turns.pop(0), timed)})
        options = bench.parse(["check", *(["--write"] if write else [])])
        summary, rows = check.run(options)
        said = check.complaints(rows)
        assert summary == dict(ratios_checked=1, ratios_lost=len(said))
        return said, len(measured) - len(turns)

    return judge


def test_a_fifth_may_be_lost(gate):
    assert gate(10.0, 8.001) == ([], 1)
    assert gate(10.0, 30.0) == ([], 1)
    said, _ = gate(10.0, 7.9)
    assert said == ["speed has fallen from 10 to 7.9, by 21 %."]


def test_what_is_not_a_number_is_lost(gate):
    assert len(gate(10.0, math.nan)[0]) == 1


def test_a_timed_ratio_is_lost_only_if_it_is_lost_again(gate):
    assert gate(10.0, 5.0, 9.0, timed=True) == ([], 2)
    said, turns = gate(10.0, 5.0, 7.0, 6.0, timed=True)
    assert said == ["speed has fallen from 10 to 7, by 30 %."] and turns == 3


def test_a_ratio_that_nothing_is_committed_for_is_not_let_through(gate):
    said, _ = gate(None, 3.0)
    assert "run `bench check --write`" in said[0]


def test_what_is_written_is_what_is_expected_next(gate):
    assert gate(10.0, 2.00049, write=True) == ([], 1)
    assert check.expected() == {"speed": 2.0}
    assert gate(None, 1.9) == ([], 1)
    assert len(gate(None, 1.5)[0]) == 1


def test_everything_that_is_checked_is_committed():
    assert set(check.expected()) == set(RATIOS)


def test_a_worse_sampler_fails_the_command(tmp_path, monkeypatch):
    """The real measurement, against a committed value that was three times as good."""
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))
    name = "variance_frame_above"
    better = tmp_path / "expected.json"
    better.write_text(json.dumps({name: 3.0 * check.expected()[name]}), encoding="utf-8")
    arguments = ["check", "--ratios", name, "--out", str(tmp_path / "out.json")]
    assert bench.main(arguments) == 0
    monkeypatch.setattr(check, "EXPECTED", better)
    assert bench.main(arguments) == 1
    assert json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))["summary"]["ratios_lost"] == 1
