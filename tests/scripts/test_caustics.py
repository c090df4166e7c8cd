# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``bench caustics``: figures of pictures whose noise is known, and a run."""

import argparse

import numpy as np
import pytest
from benchmarks import caustics


def noisy(noise: float, seed: int, count: int = 40) -> np.ndarray:
    return 1.0 + noise * np.random.default_rng(seed).standard_normal((count, 64, 3))


def test_figures_of_known_noise():
    """Half of the noise in twice the time is half of error × time."""
    row = caustics.row_of(
        {
            caustics.WITHOUT: (noisy(0.2, 1), 1.0),
            caustics.AUTOMATIC: (noisy(0.1, 2), 2.0),
            caustics.ALWAYS: (noisy(0.05, 3), 1.0),
        }
    )
    assert row["automatic"] == pytest.approx(2.0, rel=0.1)
    assert row["always"] == pytest.approx(16.0, rel=0.1)
    assert row["noise_without"] == pytest.approx(20.0, rel=0.05)
    assert row["noise"] == pytest.approx(10.0, rel=0.05)
    assert row["time"] == 2.0 and abs(row["deviation"]) < 4.0


def test_light_that_is_missing_is_an_error():
    """Pictures without noise, in which a tenth of the light is missing."""
    row = caustics.row_of(
        {
            caustics.WITHOUT: (np.full((40, 64, 3), 0.9), 1.0),
            caustics.AUTOMATIC: (noisy(0.05, 2), 1.0),
            caustics.ALWAYS: (noisy(0.01, 3), 1.0),
        }
    )
    assert row["noise_without"] == pytest.approx(10.0, rel=0.05)
    assert row["automatic"] == pytest.approx(4.0, rel=0.1)


@pytest.mark.slow
def test_caustic_paths_pay_under_a_lamp():
    parser = argparse.ArgumentParser()
    caustics.arguments(parser)
    options = parser.parse_args(["--caustics", "ball_large"])
    vars(options).update(quick=True, repeats=4, device="CPU", resume=None)
    summary, (row,) = caustics.run(options)
    assert row["automatic"] > 1.3 and abs(row["deviation"]) < 5.0
    assert summary["caustics_large"] == pytest.approx(row["automatic"])
