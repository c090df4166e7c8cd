# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels of textures give the same compiled, as plain Python and as GLSL."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from sdf_lights import jit
from tests.gpu.support import device_or_skip, on_gpu
from tests.render.textures.cases import FAR, FAST, LARGE, SLOW, At, ours

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

_GROUPS = [*FAST, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)]
_VERSIONS = (5, 2), (4, 5)  # their Voronoi cells have other hashes


def calls(cases: list[dict], every: int) -> dict:
    """What functions the cases call with the operands (points, operands), and what they give: (points, results)."""
    found = {}

    class Noting(At):
        def call(self, function, operands):
            results = super().call(function, operands)
            columns = np.broadcast_arrays(*operands, *results, np.empty(self.count))
            rows = np.stack(columns[:-1], axis=1)
            found.setdefault(function, (rows[:, : len(operands)], rows[:, len(operands) :]))
            return results

    for version in _VERSIONS:
        for case in cases:
            if case["origin"] not in (FAR["origin"], LARGE["origin"]):
                ours(case, version, every, Noting)
    return found


@pytest.mark.parametrize("group", _GROUPS)
def test_plain_python_gives_the_same(group, tmp_path):
    found = calls((FAST | SLOW)[group], 151)
    (tmp_path / "calls.json").write_text(
        json.dumps(
            [
                [f"{function.kernel.__module__}.{function.kernel.__name__}", function.static, operands.tolist()]
                for function, (operands, _) in found.items()
            ]
        )
    )
    script = pathlib.Path(__file__).with_name("plain_textures.py")
    subprocess.run(
        [sys.executable, str(script), str(tmp_path / "calls.json"), str(tmp_path / "result.json")],
        check=True,
        capture_output=True,
        timeout=600,
    )
    plain = json.loads((tmp_path / "result.json").read_text())
    for (function, (_, expected)), values in zip(found.items(), plain, strict=True):
        np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9, err_msg=str(function))


@pytest.mark.parametrize("group", _GROUPS)
def test_glsl_gives_the_same(group):
    device_or_skip()
    for function, (operands, expected) in calls((FAST | SLOW)[group], 9).items():
        static = [np.full(len(expected), number) for number in function.static]
        found = on_gpu(function.kernel, *static, *operands.T)
        # Single precision, 100 to 200 from the origin, where distortion and colours are taken. Two cells may tie.
        off = ~(np.abs(found - expected).max(axis=1) < 1e-3)
        assert np.count_nonzero(off) <= 1, function


@pytest.mark.parametrize("coordinate", [np.nan, np.inf, -np.inf, 1e30])
def test_coordinates_that_are_no_place_do_no_harm(coordinate):
    """Patterns may be anything there, but kernels come to an end."""
    for case in FAST["few"]:
        ours({**case, "origin": (coordinate,) * 4}, (5, 2), 200)


def test_noise_goes_on_at_large_coordinates():
    values = ours({**FAST["few"][0], **LARGE}, (5, 2))
    assert 0.0 < values.min() and values.max() < 1.0 and values.std() > 0.02
