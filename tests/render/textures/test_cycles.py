# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural textures are those of the Cycles of the installed bpy, point by point.

Cycles computes in single precision, so points may differ where two cells tie: three of a case's 576 at most.
"""

import importlib.metadata
import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from sdf_lights import jit
from tests.render.textures.cases import FAST, SIZE, SLOW, ours

TOLERANCE, TIES = 1e-3, 3 / SIZE**2

_GROUPS = [*FAST, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)]


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")
@pytest.mark.parametrize("group", _GROUPS)
def test_nodes_look_as_in_cycles(group, tmp_path):
    try:
        version = tuple(map(int, importlib.metadata.version("bpy").split(".")[:2]))
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("bpy is not installed")
    cases = (FAST | SLOW)[group]
    (tmp_path / "cases.json").write_text(json.dumps(cases))
    script = pathlib.Path(__file__).with_name("render_textures.py")
    command = [sys.executable, str(script), str(tmp_path / "cases.json"), str(tmp_path / "result.npy")]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path, timeout=600)
    wrong, everywhere, plain = [], [], 0
    for case, theirs in zip(cases, np.load(tmp_path / "result.npy"), strict=True):
        plain += np.ptp(theirs) < 0.01
        error = np.abs(ours(case, version) - theirs.reshape(-1, 3)).max(axis=1)
        off = ~(error < TOLERANCE)
        everywhere.append(off.mean())
        if off.mean() > TIES:
            wrong.append(f"{off.mean():.1%} of points, up to {np.max(error):.3g}: {case}")
    assert plain < 0.02 * len(cases)  # there are patterns to compare
    print(f"{len(cases)} cases, {np.mean(everywhere):.2e} of points off")
    assert not wrong, "\n".join(wrong)
