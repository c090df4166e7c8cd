# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark of start-up goes on with the kernels that an interrupted run has compiled, and needs none to be
compiled."""

import argparse
import pathlib

import pytest

pytest.importorskip("bpy")

import demo
import host
from benchmarks import startup
from benchmarks.progress import Progress
from benchmarks.resume import Parts

OPTIONS = dict(repeats=2, quick=True, device="CPU")


@pytest.fixture
def starts(tmp_path, monkeypatch):
    """Folders of kernels, one for each start, and whether they had been compiled; the third start is interrupted."""
    found = []

    def measure(blend, device, cache):
        if len(found) == 2:
            found.append(None)
            raise KeyboardInterrupt
        found.append((pathlib.Path(cache), pathlib.Path(cache).is_dir()))
        pathlib.Path(cache).mkdir(parents=True, exist_ok=True)
        return dict(blender=0.1, first=5.0 if not found[-1][1] else 0.5, later=0.2)

    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path / "parts"))
    monkeypatch.setattr(startup, "_measure", measure)
    monkeypatch.setattr(startup, "work_folder", lambda: tmp_path)
    monkeypatch.setattr(demo, "demo_scene", lambda: "demo.blend")
    return found


def measured(cold: bool) -> dict:
    options = argparse.Namespace(**OPTIONS, cold=cold)
    parts = Parts(options)
    summary, _ = startup.measured(options, parts, Progress(3))
    parts.finish()
    return summary


def test_kernels_are_compiled_once(starts):
    with pytest.raises(KeyboardInterrupt):
        measured(cold=True)
    summary = measured(cold=True)
    assert [known for _, known in filter(None, starts)] == [False, True, True]
    assert summary == dict(startup_seconds=0.5, startup_seconds_later=0.2, cold_compile_seconds=4.5)
    assert not starts[0][0].exists()


def test_kernels_that_are_gone_are_compiled_again_before_anything_is_measured(starts):
    with pytest.raises(KeyboardInterrupt):
        measured(cold=True)
    starts[0][0].rmdir()
    assert measured(cold=True)["cold_compile_seconds"] == 4.5
    assert [known for _, known in filter(None, starts)] == [False, True, False, True]


def test_the_start_with_empty_caches_may_be_left_out(starts, tmp_path, monkeypatch):
    monkeypatch.setattr(host, "REPOSITORY", tmp_path)
    with pytest.raises(KeyboardInterrupt):
        measured(cold=False)
    assert "cold_compile_seconds" not in measured(cold=False)
    assert starts[0][0].is_dir()  # they belong to the user
