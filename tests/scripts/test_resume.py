# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An interrupted benchmark goes on where it was, and measures anew once it is done."""

import argparse

import pytest

pytest.importorskip("bpy")

from benchmarks import gpucuts
from benchmarks.resume import Parts


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))


def run(measured: list[str], broken: str | None = None, **options) -> list[str]:
    """Results of three parts, of which one may be interrupted; ``measured`` gets those that were not known."""

    def measure(name: str) -> str:
        if name == broken:
            raise KeyboardInterrupt
        measured.append(name)
        return f"result of {name}"

    parts = Parts(argparse.Namespace(**options))
    found = [parts.of(name, lambda name=name: measure(name)) for name in ("one", "two", "three")]
    parts.finish()
    return found


def test_what_was_measured_before_an_interruption_is_kept():
    measured = []
    with pytest.raises(KeyboardInterrupt):
        run(measured, broken="three", benchmark="lamps", quick=False)
    assert run(measured, benchmark="lamps", quick=False) == [f"result of {name}" for name in ("one", "two", "three")]
    assert measured == ["one", "two", "three"]
    run(measured, benchmark="lamps", quick=False)
    assert len(measured) == 6


@pytest.mark.parametrize("other", [dict(benchmark="cycles", quick=False), dict(benchmark="lamps", quick=True)])
def test_parts_belong_to_one_benchmark_with_the_same_options(other):
    measured = []
    with pytest.raises(KeyboardInterrupt):
        run(measured, broken="two", benchmark="lamps", quick=False)
    run(measured, **other)
    assert measured == ["one", "one", "two", "three"]


def test_where_the_result_is_written_to_does_not_matter():
    measured = []
    with pytest.raises(KeyboardInterrupt):
        run(measured, broken="two", benchmark="lamps", out=None)
    run(measured, benchmark="lamps", out="file.json")
    assert measured == ["one", "two", "three"]


def test_scenes_on_the_gpu_that_are_done_are_kept(monkeypatch):
    measured, broken = [], ["S3"]

    def measure(name, options):
        if name in broken:
            raise KeyboardInterrupt
        measured.append(name)
        return dict(scene=name, gain=2.0)

    monkeypatch.setattr(gpucuts, "measure", measure)
    options = argparse.Namespace(quick=False, cut_scenes=["S1", "S3", "S5"], cut_bounces=0)
    with pytest.raises(KeyboardInterrupt):
        gpucuts.run(options)
    broken.clear()
    summary, rows = gpucuts.run(options)
    assert measured == [row["scene"] for row in rows] == ["S1", "S3", "S5"]
    assert summary == dict(gpu_cut_gain=pytest.approx(2.0))
    gpucuts.run(options)
    assert len(measured) == 6
