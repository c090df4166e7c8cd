# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests of everything that touches Blender, and of materials against its Cycles, in every supported Blender."""

import os
import pathlib
import subprocess

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
NO_PYTHON = 3  # exit code of scripts/environment.sh


@pytest.mark.matrix
@pytest.mark.parametrize("blender", ["4.5", "5.0", "5.2"])
def test_blender_suite_and_zip(blender, capfd):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    made = subprocess.run(
        [REPOSITORY / "scripts" / "environment.sh", "--blender", blender],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        timeout=1800,
    )
    if made.returncode == NO_PYTHON:
        pytest.skip(made.stderr.strip())
    assert made.returncode == 0, made.stderr
    done = subprocess.run(
        [
            made.stdout.strip(),
            "-m",
            "pytest",
            "-c",
            "tests/pytest.ini",
            "--rootdir",
            ".",
            "-m",
            "not gui and not matrix",
            "-q",
            "tests/blender",
            "tests/render/shading/test_cycles.py",
        ],
        cwd=REPOSITORY,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=1800,
    )
    with capfd.disabled():
        print(f"\nBlender {blender}: {done.stdout.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stdout[-20000:]
