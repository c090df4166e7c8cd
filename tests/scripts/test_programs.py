# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forms of the GPU's programs compute what the programs compute as they are."""

import json
import subprocess
import sys

import pytest

pytest.importorskip("bpy")

import host
from benchmarks import program_session

from tests.gpu.support import device_or_skip


@pytest.mark.slow
def test_every_form_computes_the_same():
    device_or_skip()
    forms = list(program_session.FORMS)
    command = [sys.executable, host.REPOSITORY / "scripts" / "bench.py", "programs", "--quick", "--json"]
    options = ["--program-scenes", "S1", "--for-card", "--forms", ",".join(forms)]
    done = subprocess.run([*command, *options], stdout=subprocess.PIPE, text=True, check=True)
    rows = json.loads(done.stdout)["rows"]
    assert any(row["thread_words"] for row in rows)  # they are those of a graphics card
    assert len({row["program"] for row in rows}) * len(forms) == len(rows)
    assert all("problem" not in row and row["finished"] and row["difference"] < 1e-6 for row in rows), rows
