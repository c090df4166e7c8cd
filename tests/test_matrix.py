# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests of everything that touches Blender, and of materials against its Cycles, in every supported Blender."""

import os
import pathlib
import subprocess
from concurrent.futures import ThreadPoolExecutor
from threading import Lock

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
NO_PYTHON = 3  # exit code of scripts/environment.sh
BLENDERS = ("4.5", "5.0", "5.1", "5.2")
PYTEST = "-m pytest -c tests/pytest.ini --rootdir . -q --durations=40".split()
FAULTS = tuple(
    f"tests/{name}.py"
    for name in (
        *("blender/test_bad_input", "blender/test_bounded_time", "blender/test_extreme_values", "blender/test_faults"),
        *("blender/test_hostile_files", "blender/test_registration", "blender/test_soak", "test_canaries"),
    )
)
SUITE = ("tests/blender", "tests/render/shading/test_cycles.py", "tests/test_canaries.py")
NODES = "tests/blender/test_shader_nodes.py"
NEWEST = "5.2"
# Of the Blender that `scripts/test` uses without arguments, its fast tests have been run. The newest has all the
# others. The oldest has the fast ones, and all nodes of values, as nodes are what changes from one version to the next.
# Between these two only what is wrong in files, and what fails, is tried.
# Blender, pytest's arguments; long ones first, of one Python one after the other, as the first of them compiles
JOBS = (
    (NEWEST, ("-m", "not slow and not gui and not matrix", *SUITE)),
    ("4.5", ("-m", "not slow and not gui and not matrix", *SUITE)),
    (NEWEST, ("-m", "slow and not gui and not matrix", *SUITE, f"--ignore={NODES}")),
    (NEWEST, ("-m", "slow and not gui and not matrix", NODES)),
    ("4.5", ("-m", "slow", "-k", "values_are_those_of_cycles", NODES)),
    ("5.1", ("-m", "not gui and not matrix", *FAULTS, "-k", "not five_hundred_steps and not (killed_process and CPU)")),
    ("5.0", ("-m", "slow and not gui and not matrix", *FAULTS, "-k", "not five_hundred_steps and not killed_process")),
)
ENVIRONMENT = REPOSITORY / "scripts" / "environment.sh"


def _run(environment: dict, *command) -> subprocess.CompletedProcess:
    return subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=2400)


def _job(blender: str, arguments: tuple) -> tuple[subprocess.CompletedProcess, subprocess.CompletedProcess | None]:
    """How the environment of a Blender was made, and if it was, how the tests went in it."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    with _making:
        made = _run(environment, ENVIRONMENT, "--blender", blender)
    if made.returncode:
        return made, None
    return made, _run(environment, made.stdout.strip(), *PYTEST, *arguments)


_making = Lock()


@pytest.fixture(scope="module")
def jobs(request):
    """Jobs of each Blender that is asked for; two run side by side."""
    wanted = {item.callspec.params["blender"] for item in request.session.items if item.module is request.module}
    running = {}
    with ThreadPoolExecutor(2) as pool:
        for blender, arguments in JOBS:
            if blender in wanted:
                running.setdefault(blender, []).append(pool.submit(_job, blender, arguments))
        yield running


@pytest.mark.matrix
@pytest.mark.parametrize("blender", BLENDERS)
def test_blender_suite_and_zip(jobs, blender, capfd):
    done = [job.result() for job in jobs[blender]]
    for made, _ in done:
        if made.returncode == NO_PYTHON:
            pytest.skip(made.stderr.strip())
        assert made.returncode == 0, made.stderr
    told, wrong = [], []
    for _, tests in done:
        lines = tests.stdout.strip().splitlines()
        failures = [line for line in lines if line.startswith(("FAILED ", "ERROR "))]
        told += [*lines[-1:], *failures]
        if tests.returncode:
            wrong += [(tests.stderr + tests.stdout)[-20000:], *failures]
    with capfd.disabled():
        print(f"\nBlender {blender}:", *told, sep="\n")
    # What Cycles prints is most of the output: the names of what failed come last, where no limit cuts them off.
    assert not wrong, "\n".join(wrong)
