# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``bench indirect``: figures of pictures whose noise is known, and a run."""

import argparse

import numpy as np
import pytest
from benchmarks import indirect


def noisy(noise: float, seed: int) -> np.ndarray:
    return 1.0 + noise * np.random.default_rng(seed).standard_normal((6, 20, 20, 3))


def test_gain_is_error_times_time():
    stacks = {indirect.WITHOUT: noisy(0.2, 1), indirect.AUTOMATIC: noisy(0.1, 2)}
    row = indirect.row_of(stacks, {indirect.WITHOUT: 2.0, indirect.AUTOMATIC: 1.0})
    assert row["gain"] == pytest.approx(8.0, rel=0.15)
    assert row["time"] == pytest.approx(0.5)
    assert 0.4 < row["percentile"] < 0.6 and 0.4 < row["worst"] < 0.6
    assert row["used"] and abs(row["deviation"]) < 4.0


def test_equal_pictures_lose_time_alone():
    stacks = {indirect.WITHOUT: noisy(0.1, 3), indirect.AUTOMATIC: noisy(0.1, 3)}
    row = indirect.row_of(stacks, {indirect.WITHOUT: 1.0, indirect.AUTOMATIC: 1.1})
    assert row["gain"] == pytest.approx(1.0 / 1.1)
    assert not row["used"] and row["deviation"] == 0.0


def test_summary_has_the_least_room_and_the_greatest_loss():
    rows = [
        dict(indirect_scene=scene, gain=gain, used=used)
        for scene, gain, used in (("cove", 8.0, True), ("door", 2.0, True), ("S4", 0.8, False), ("street", 1.0, True))
    ]
    assert indirect.summary_of(rows) == {
        "loss_max": pytest.approx(1.25),
        "used_elsewhere": 1,
        "rooms_gain_min": 2.0,
        "rooms_gain_geomean": pytest.approx(4.0),
    }


@pytest.mark.slow
def test_a_room_is_measured():
    parser = argparse.ArgumentParser()
    indirect.arguments(parser)
    options = parser.parse_args(["--rooms", "cove"])
    vars(options).update(quick=True, repeats=2, device="CPU", resume=None)
    summary, (row,) = indirect.run(options)
    assert row["used"] and row["gain"] > 2.0
    assert summary["rooms_gain_min"] == row["gain"]
