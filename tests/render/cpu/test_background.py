# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that compile beside a session: it waits for what it needs, sees how far they are, and outlives what fails."""

import os
import pathlib
import subprocess
import sys
import time

import pytest

from sdf_lights import jit, kernel_cache
from sdf_lights.interruption import Interrupted
from sdf_lights.render.cpu import ahead, background

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]

MODULE = """
import sys, time
groups = [word for word in sys.argv[1:] if word[0] != "-"]
for group in groups:
    for done in range(3):
        print(done, "of", 2, flush=True)
        time.sleep(0.1)
    {ending}
    print("finished", group, flush=True)
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A function that makes a package whose ``ahead`` ends each group with a line of Python."""
    monkeypatch.setattr(kernel_cache, "writable_folder", lambda: tmp_path)
    monkeypatch.setattr(kernel_cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(background, "PACKAGE", tmp_path / "stand_in")

    def make(ending: str = "pass") -> None:
        folder = tmp_path / "stand_in" / "render" / "cpu"
        folder.mkdir(parents=True)
        (folder / "ahead.py").write_text(MODULE.format(ending=ending), encoding="utf-8")

    yield make
    background.stop()


def until_it_ends() -> None:
    limit = time.monotonic() + 30.0
    while background.running() and time.monotonic() < limit:
        time.sleep(0.02)
    assert not background.running()


def test_what_is_needed_is_waited_for_and_all_is_remembered(package):
    package()
    assert background.needed() and background.text() == ""
    background.start()
    seen = set()
    background.wait(lambda: seen.add(background.text()))
    finished = set().union(*(process.finished for process in background._processes))
    assert finished >= {group for groups in background.NEEDED for group in groups}
    assert any(text.endswith(" of 4") for text in seen)
    until_it_ends()
    assert background.progress() == (4, 4)
    limit = time.monotonic() + 10.0
    while background.needed() and time.monotonic() < limit:  # its reader notes it after the process has ended
        time.sleep(0.02)
    assert not background.needed()
    background.start()
    assert not background.running()
    (background.PACKAGE / "new.py").touch()  # as an update does
    assert background.needed()


def test_a_failure_costs_time_alone(package):
    package("sys.exit(1)")
    background.start()
    background.wait(lambda: None)
    until_it_ends()
    assert background.needed()


def test_a_wait_can_be_ended(package):
    package("time.sleep(60)")
    background.start()

    def check() -> None:
        raise Interrupted

    with pytest.raises(Interrupted):
        background.wait(check)
    background.stop()
    assert background.text() == ""


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is missing")
def test_what_an_entry_calls_is_counted():
    """The kernels that Numba compiles for an entry, but for a few that it finds it does not need, are those that are counted."""
    from sdf_lights.emitter.primitives.box import box_span

    assert jit.reachable(box_span) > {box_span}
    for group in ahead.GROUPS.values():
        entries, _ = group()
        done, total = jit.progress(entries)
        assert 0 <= done <= total and total >= len(entries)
    assert jit.progress([])[1] == 0


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is missing")
def test_the_process_ends_with_its_session(tmp_path):
    """Whose end it sees by that of its standard input."""
    done = subprocess.run(
        [sys.executable, "-m", "sdf_lights.render.cpu.ahead", "--beside", "--low", "paths"],
        cwd=REPOSITORY,
        env={**os.environ, "SDF_LIGHTS_CACHE": str(tmp_path)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 1 and "finished" not in done.stdout and not done.stderr
