# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that compile beside a session: it waits for what it needs, sees how far they are, and outlives what fails."""

import ctypes
import os
import pathlib
import subprocess
import sys
import time

import pytest

from sdf_lights import jit, kernel_cache
from sdf_lights.interruption import Interrupted
from sdf_lights.render.cpu import background, precompile, priority

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="Linux alone tells how a process is scheduled")

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]

MODULE = """
import os, sys, time
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
    """A function that makes a package whose ``precompile`` ends each group with a line of Python."""
    monkeypatch.setattr(kernel_cache, "writable_folder", lambda: tmp_path)
    monkeypatch.setattr(kernel_cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(background, "PACKAGE", tmp_path / "stand_in")

    def make(ending: str = "pass") -> None:
        folder = tmp_path / "stand_in" / "render" / "cpu"
        folder.mkdir(parents=True)
        (folder / "precompile.py").write_text(MODULE.format(ending=ending), encoding="utf-8")

    yield make
    background.stop()


def until(holds) -> None:
    """Wait until a condition holds."""
    limit = time.monotonic() + 30.0
    while not holds() and time.monotonic() < limit:
        time.sleep(0.02)
    assert holds()


def until_it_ends() -> None:
    until(lambda: not background.running())


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


def schedulers() -> set[int]:
    return {os.sched_getscheduler(process._process.pid) for process in background._processes if process.running}


@on_linux
def test_what_a_render_waits_for_is_as_urgent_as_the_session(package):
    """And no longer than that, if the system allows it."""
    package("time.sleep(1)")
    own, seen = os.sched_getscheduler(0), []
    background.start(processes=(("paths", "special"),))
    assert schedulers() == {os.SCHED_IDLE}
    allowed = priority.restore(background._processes[0]._process.pid)
    priority.lower(background._processes[0]._process.pid)
    background.wait(lambda: seen.append(schedulers()))
    assert {own if allowed else os.SCHED_IDLE} in seen
    assert schedulers() == {os.SCHED_IDLE}


def states() -> set[str]:
    """Of running processes: T for those that are stopped (proc(5))."""
    return {
        pathlib.Path(f"/proc/{process._process.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
        for process in background._processes
        if process.running
    }


@on_linux
def test_processes_pause_and_a_render_lets_them_go_on(package):
    package()
    background.start()
    background.pause()
    until(lambda: states() == {"T"})  # each stops when it has its next turn on a processor
    time.sleep(0.2)  # a line may be on its way
    paused = background.progress()
    time.sleep(0.5)
    assert background.progress() == paused and states() == {"T"}
    background.proceed()
    until(lambda: "T" not in states())
    background.pause()
    background.wait(lambda: None)
    until_it_ends()
    assert background.progress() == (4, 4)


@on_linux
def test_a_paused_process_ends_with_the_session(package):
    package("time.sleep(60)")
    background.start()
    background.pause()
    processes = [process._process for process in background._processes]
    background.stop()
    assert all(process.wait(timeout=10.0) for process in processes)


@pytest.fixture
def ordinary():
    """This thread without root's right to raise a priority (capabilities(7), CAP_SYS_NICE)."""
    libc, head = ctypes.CDLL(None, use_errno=True), (ctypes.c_uint32 * 2)(0x20080522, 0)
    rights = (ctypes.c_uint32 * 6)()
    assert libc.capget(head, rights) == 0
    before = rights[0]
    rights[0] &= ~(1 << 23)
    assert libc.capset(head, rights) == 0
    yield
    rights[0] = before
    assert libc.capset(head, rights) == 0


@on_linux
def test_a_starved_process_that_may_not_be_raised_is_replaced(package, ordinary, monkeypatch):
    package(f"time.sleep(0 if os.sched_getscheduler(0) != {os.SCHED_IDLE} else 600)")
    monkeypatch.setattr(background, "STARVED_SECONDS", 0.5)
    background.start(processes=(("paths",),))
    first = background._processes[0]._process
    if priority.restore(first.pid):
        pytest.skip("this user may raise a priority (RLIMIT_NICE)")
    limit = time.monotonic() + 30.0

    def check() -> None:
        assert time.monotonic() < limit

    background.wait(check)
    assert background._processes[0].finished == {"paths"}
    assert first.wait(10.0) and background._processes[0]._process is not first


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is missing")
def test_what_an_entry_calls_is_counted():
    """The kernels that Numba compiles for an entry, but for a few that it finds it does not need, are those that are
    counted."""
    from sdf_lights.emitter.primitives.box import box_span

    assert jit.reachable(box_span) > {box_span}
    for group in precompile.GROUPS.values():
        entries, _ = group()
        done, total = jit.progress(entries)
        assert 0 <= done <= total and total >= len(entries)
    assert jit.progress([])[1] == 0


@pytest.mark.slow  # compiles what no other test has compiled
@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is missing")
@pytest.mark.parametrize("group", precompile.GROUPS)
def test_all_kernels_of_a_group_are_compiled(group):
    done = subprocess.run(
        [sys.executable, "-m", "sdf_lights.render.cpu.precompile", group],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    *lines, last, processor = done.stdout.splitlines()
    assert f"finished {group}" in lines and len(set(last.split(" of "))) == 1 and processor.startswith("for ")


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is missing")
def test_the_process_ends_with_its_session(tmp_path):
    """Whose end it sees by that of its standard input."""
    done = subprocess.run(
        [sys.executable, "-m", "sdf_lights.render.cpu.precompile", "--beside", "paths"],
        cwd=REPOSITORY,
        env={**os.environ, "SDF_LIGHTS_CACHE": str(tmp_path)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 1 and "finished" not in done.stdout and not done.stderr
