# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``bench caustics``: figures of pictures whose noise is known, means of light paths, and a run."""

import argparse

import numpy as np
import pytest
from benchmarks import caustics

MASK = np.ones((8, 8), bool)


def noisy(mean: float, noise: float, seed: int, count: int = 40) -> np.ndarray:
    return mean + noise * np.random.default_rng(seed).standard_normal((count, 8, 8, 3))


def test_figures_of_known_noise():
    hidden = np.ones((40, 8, 8, 3))
    by_light = {
        "connect": caustics.Estimates(noisy(0.5, 0.1, 1), 1.0),
        "aimed": caustics.Estimates(noisy(0.5, 0.05, 2), 1.0),
        "merge_1": caustics.Estimates(noisy(0.8, 0.1, 3), 1.0),
    }
    row = caustics.row_of(hidden + noisy(0.5, 0.2, 4), hidden, 2.0, by_light, MASK)
    assert row["part"] == pytest.approx(1.0 / 3.0, rel=0.02)
    assert row["gain_connect"] == pytest.approx(8.0, rel=0.1)
    assert row["gain_aimed"] == pytest.approx(32.0, rel=0.1)
    assert row["bias_merge_1"] == pytest.approx(0.3 / 1.5, rel=0.05)
    for name in caustics.CONNECTED:
        assert abs(row[f"deviation_{name}"]) < 4.0 * row[f"deviation_{name}_error"] < 0.1


@pytest.mark.slow
def test_light_paths_find_the_light_of_paths():
    """With a large lamp, which paths find well."""
    parser = argparse.ArgumentParser()
    caustics.arguments(parser)
    options = parser.parse_args(["--caustics", "ball_large"])
    vars(options).update(quick=True, repeats=8, device="CPU", resume=None)
    summary, (row,) = caustics.run(options)
    assert row["deviation_aimed_error"] < 0.05 and row["gain_aimed"] > 2.0
    assert summary["caustics_deviation_max"] < 4.0
    assert "caustics_large_gain_aimed" in summary
