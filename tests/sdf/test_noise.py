# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise: how tight the bounds are that are found of its slope."""

import numpy as np
import pytest

from sdf_lights.graph.formula import POINT, Vector
from sdf_lights.graph.lipschitz import lipschitz
from sdf_lights.graph.numpy_evaluation import evaluate
from sdf_lights.sdf.noise import STEEPEST, value_noise


@pytest.mark.parametrize("size, loose", [(0.02, 1.5), (0.1, 3.0), (0.3, 7.0), (1.0, 25.0)])
def test_slopes_in_boxes(size, loose):
    """At the median of boxes; the whole polynomial of the fade from 0 would make it 8, 60 and 1500 for the last
    three."""
    noise = value_noise(Vector(*POINT))
    rng = np.random.default_rng(1)
    low = rng.uniform(-3.0, 3.0, (100, 3))
    found = lipschitz(noise, low, low + size)
    points = low[:, None] + rng.random((100, 200, 3)) * size
    slopes = [(evaluate(noise, points + step) - evaluate(noise, points - step)) / 2e-5 for step in 1e-5 * np.eye(3)]
    steepest = np.linalg.norm(slopes, axis=0).max(axis=1)
    assert (steepest <= found * (1.0 + 1e-6)).all() and steepest.max() <= STEEPEST
    assert np.median(found / steepest) < loose
