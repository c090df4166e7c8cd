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
PYTEST = "-m pytest -c tests/pytest.ini --rootdir . -q -n 2 --dist worksteal --durations=40".split()
FAULTS = tuple(
    f"tests/{name}.py"
    for name in (
        *("blender/test_bad_input", "blender/test_bounded_time", "blender/test_extreme_values", "blender/test_faults"),
        *("blender/test_hostile_files", "blender/test_registration", "blender/test_soak", "test_canaries"),
    )
)
SUITE = ("tests/blender", "tests/render/shading/test_cycles.py", "tests/test_canaries.py")
# Of the Blender that `scripts/test` uses without arguments, its fast tests have been run. The newest has all the
# others. The oldest has the fast ones, and all nodes of values, as nodes are what changes from one version to the next;
# the first case of each node is one of all. Between these two only what is wrong in files, and what fails, is tried.
RUNS = {  # Blender: pytest's marks, names, and files
    "4.5": ("not gui and not matrix", "not slow and not first_case or values_are_those_of_cycles", *SUITE),
    "5.0": ("slow and not gui and not matrix", "not five_hundred_steps and not killed_process", *FAULTS),
    "5.1": ("not gui and not matrix", "not five_hundred_steps and not (killed_process and CPU)", *FAULTS),
    "5.2": ("not gui and not matrix", "not first_case", *SUITE),
}
ENVIRONMENT = REPOSITORY / "scripts" / "environment.sh"


def _run(*command) -> subprocess.CompletedProcess:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    return subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=2400)


@pytest.fixture(scope="module")
def environments(request):
    """How the environment of each wanted Blender was made. The next ones are made while tests run in the first."""
    wanted = {item.callspec.params["blender"] for item in request.session.items if item.module is request.module}
    with ThreadPoolExecutor(1) as pool:
        yield {blender: pool.submit(_run, ENVIRONMENT, "--blender", blender) for blender in RUNS if blender in wanted}


@pytest.mark.matrix
@pytest.mark.parametrize("blender", RUNS)
def test_blender_suite_and_zip(environments, blender, capfd):
    made = environments[blender].result()
    if made.returncode == NO_PYTHON:
        pytest.skip(made.stderr.strip())
    assert made.returncode == 0, made.stderr
    marks, names, *files = RUNS[blender]
    tests = _run(made.stdout.strip(), *PYTEST, "-m", marks, "-k", names, *files)
    lines = tests.stdout.strip().splitlines()
    failures = [line for line in lines if line.startswith(("FAILED ", "ERROR "))]
    with capfd.disabled():
        print(f"\nBlender {blender}:", *lines[-1:], *failures, sep="\n")
    # What Cycles prints is most of the output: the names of what failed come last, where no limit cuts them off.
    assert tests.returncode == 0, "\n".join([(tests.stderr + tests.stdout)[-20000:], *failures])
