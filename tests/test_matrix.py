# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests of everything that touches Blender, and of materials against its Cycles, in every supported Blender."""

import os
import pathlib
import subprocess
from concurrent.futures import ThreadPoolExecutor

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
NO_PYTHON = 3  # exit code of scripts/environment.sh
BLENDERS = ("4.5", "5.0", "5.2")
SUITE = ("-m", "not gui and not matrix", "-q", "--durations=10", "tests/blender", "tests/render/shading/test_cycles.py")
# Materials of many nodes are of nodes that are compared one by one: they are rendered in the newest Blender alone.
OLDER = ("-k", "not every_material_of_many_nodes")


def _run(environment: dict, *command) -> subprocess.CompletedProcess:
    return subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=1800)


def _suite(blender: str) -> tuple[subprocess.CompletedProcess, subprocess.CompletedProcess | None]:
    """How the environment of a Blender was made, and if it was, how the tests went in it."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    made = _run(environment, REPOSITORY / "scripts" / "environment.sh", "--blender", blender)
    if made.returncode:
        return made, None
    return made, _run(
        environment,
        made.stdout.strip(),
        *("-m", "pytest", "-c", "tests/pytest.ini", "--rootdir", ".", *SUITE),
        *(OLDER if blender != BLENDERS[-1] else ()),
    )


@pytest.fixture(scope="module")
def suites(request):
    """Blenders whose suites run, two side by side; the one with a Python of its own first, for which all is compiled."""
    wanted = {item.callspec.params["blender"] for item in request.session.items if item.module is request.module}
    with ThreadPoolExecutor(2) as pool:
        yield {blender: pool.submit(_suite, blender) for blender in reversed(BLENDERS) if blender in wanted}


@pytest.mark.matrix
@pytest.mark.parametrize("blender", BLENDERS)
def test_blender_suite_and_zip(suites, blender, capfd):
    made, done = suites[blender].result()
    if made.returncode == NO_PYTHON:
        pytest.skip(made.stderr.strip())
    assert made.returncode == 0, made.stderr
    output = done.stdout + done.stderr
    with capfd.disabled():
        print(f"\nBlender {blender}: {done.stdout.strip().splitlines()[-1]}")
    assert done.returncode == 0, output[-20000:]
