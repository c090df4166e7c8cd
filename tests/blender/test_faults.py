# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A process that is ended without warning, at random moments of a render, an animation, of saving: what it leaves is
whole, but for the frame in work, and the next process goes on as if nothing had been."""

import json
import pathlib
import random
import subprocess
import sys
import time

import pytest

SESSION = pathlib.Path(__file__).with_name("fault_session.py")


def start(what: str, folder: pathlib.Path, device: str) -> subprocess.Popen:
    process = subprocess.Popen(
        [sys.executable, str(SESSION), what, str(folder), device],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    for line in process.stdout:
        if line.startswith("READY"):
            return process
    raise AssertionError(f"the session ended with {process.wait()}")


def report(folder: pathlib.Path, device: str) -> dict:
    process = start("check", folder, device)
    output = process.communicate(timeout=300)[0]
    line = next((line for line in output.splitlines() if line.startswith("REPORT ")), None)
    assert line, output
    return json.loads(line.removeprefix("REPORT "))


def ended(what: str, folder: pathlib.Path, device: str, seconds: float) -> None:
    """Run a session, and kill it so many seconds after it has something to lose."""
    process = start(what, folder, device)
    wanted, patience = (1, "*.blend") if what == "saving" else (3, "*.png"), time.monotonic() + 300.0
    while len(list(folder.glob(wanted[1]))) < wanted[0] and time.monotonic() < patience:
        time.sleep(0.05)
    time.sleep(seconds)
    process.kill()  # SIGKILL: nothing of the process runs any more
    process.communicate()


@pytest.mark.parametrize(
    "what, device, times",
    [
        *((what, "REFERENCE", 1) for what in ("render", "animation", "saving")),
        *(pytest.param(what, "CPU", 4, marks=pytest.mark.slow) for what in ("render", "animation", "saving")),
    ],
)
def test_a_killed_process_loses_the_frame_in_work_alone(tmp_path, what, device, times):
    moments = random.Random(f"{what} {times}")
    told = []
    for number in range(times):
        folder = tmp_path / str(number)
        folder.mkdir()
        ended(what, folder, device, moments.uniform(0.0, 2.0))
        told.append(report(folder, device))
    for found in told:
        pictures = dict(found["pictures"])
        whole = pictures.pop("whole.png")
        order = sorted(pictures, key=lambda name: pictures[name][2])
        if what == "saving":
            assert found["lamp"] == "TORUS"
        else:
            assert len(order) > 2
            assert all(pictures[name][:2] == whole[:2] for name in order[:-1])
    assert all(found["pictures"]["whole.png"][:2] == told[0]["pictures"]["whole.png"][:2] for found in told)
