# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests of everything that touches Blender, and of materials against its Cycles, in every supported Blender."""

import os
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
NO_PYTHON = 3  # exit code of scripts/environment.sh
BLENDERS = ("4.5", "5.0", "5.1", "5.2")
PYTEST = "-m pytest -c tests/pytest.ini --rootdir . -q --durations=40".split()
FAULTS = (
    *(
        f"tests/blender/test_{name}.py"
        for name in ("bad_input", "bounded_time", "extreme_values", "faults", "hostile_files")
    ),
    *("tests/blender/test_registration.py", "tests/blender/test_soak.py", "tests/test_canaries.py"),
)
SUITE = ("tests/blender", "tests/render/shading/test_cycles.py", "tests/test_canaries.py")
# Between two that are tried in full: only what is wrong in files, what fails, and what is overridden.
BRIEF = ("5.0", "5.1")
# Materials of many nodes are of nodes that are compared one by one: they are rendered in the newest Blender alone. So is what
# takes minutes and asks little of Blender.
OLDER = ("-k", "not every_material_of_many_nodes and not five_hundred_steps and not (killed_process and CPU)")


ENVIRONMENT = REPOSITORY / "scripts" / "environment.sh"


def _run(environment: dict, *command) -> subprocess.CompletedProcess:
    return subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=2400)


def _suite(blender: str) -> tuple[subprocess.CompletedProcess, subprocess.CompletedProcess | None]:
    """How the environment of a Blender was made, and if it was, how the tests went in it.

    Of the Blender that ``scripts/test`` uses without arguments only the slow tests are left to do.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    made = _run(environment, ENVIRONMENT, "--blender", blender)
    if made.returncode:
        return made, None
    tests = FAULTS if blender in BRIEF else SUITE
    chosen = "not gui and not matrix"
    if sys.executable == made.stdout.strip():
        chosen = f"slow and {chosen}"
    older = OLDER if blender != BLENDERS[-1] else ()
    return made, _run(environment, made.stdout.strip(), *PYTEST, "-m", chosen, *tests, *older)


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
    lines = done.stdout.strip().splitlines()
    failures = [line for line in lines if line.startswith(("FAILED ", "ERROR "))]
    with capfd.disabled():
        print(f"\nBlender {blender}:", *lines[-1:], *failures, sep="\n")
    # What Cycles prints is most of the output: the names of what failed come last, where no limit cuts them off.
    assert done.returncode == 0, "\n".join([(done.stderr + done.stdout)[-20000:], *failures])
