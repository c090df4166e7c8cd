# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tabulated albedos are what their generator computes."""

import numpy as np
import pytest

from sdf_lights.render.tables import albedo, generate


@pytest.mark.parametrize("name", albedo.SHAPES)
def test_entries_are_reproduced(name):
    shape = albedo.SHAPES[name]
    table = albedo.load()[albedo.OFFSETS[name] :][: np.prod(shape)].reshape(shape)
    rng = np.random.default_rng(4)
    for index in [tuple(rng.integers(0, n) for n in shape) for _ in range(4)]:
        assert generate.entry(name, index) == pytest.approx(table[index], abs=1.0 / albedo.SCALE)


def test_smooth_surfaces_lose_nothing():
    n = albedo.SIZE
    reflection = albedo.load()[albedo.OFFSETS["reflection"] :][: n * n].reshape(n, n)
    assert reflection[1:, 0] == pytest.approx(1.0, abs=1e-4)
    assert np.all(np.diff(reflection[n // 2]) < 1e-3)  # rougher loses more
