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
    assert 0.0 < row["percentile_error"] < 0.05 and 0.0 < row["worst_error"] < 0.1
    assert 0.4 < row["flicker"] < 0.6 and 0.3 < row["flicker_of_blocks"] < 0.7
    assert row["used"] and abs(row["deviation"]) < 4.0


def test_blotches_flicker_in_blocks():
    """Noise that all pixels of a block share is as strong in its mean; noise of single pixels is not."""
    for pixels, blocks in ((16, 1.0), (1, 1.0 / 16.0)):
        noise = np.random.default_rng(5).standard_normal((40, 32 // pixels, 32 // pixels, 1))
        frames = 1.0 + 0.1 * noise.repeat(pixels, 1).repeat(pixels, 2)
        alone = indirect.flicker_of(frames, 1)
        assert alone == pytest.approx(0.1 * np.sqrt(2.0), rel=0.15)
        assert indirect.flicker_of(frames, 16) == pytest.approx(alone * blocks, rel=0.25)


def test_equal_pictures_lose_time_alone():
    stacks = {indirect.WITHOUT: noisy(0.1, 3), indirect.AUTOMATIC: noisy(0.1, 3)}
    row = indirect.row_of(stacks, {indirect.WITHOUT: 1.0, indirect.AUTOMATIC: 1.1})
    assert row["gain"] == pytest.approx(1.0 / 1.1)
    assert not row["used"] and row["deviation"] == 0.0


def test_summary_has_the_least_room_and_the_greatest_loss():
    rows = [
        dict(indirect_scene=scene, gain=gain, used=used)
        for scene, gain, used in (
            ("cove", 8.0, True),
            ("door", 2.0, True),
            ("cove_area", 3.0, True),
            ("S4", 0.8, False),
            ("street", 1.0, True),
        )
    ]
    assert indirect.summary_of(rows) == {
        "loss_max": pytest.approx(1.25),
        "used_elsewhere": 1,
        "rooms_gain_min": 2.0,
        "rooms_gain_geomean": pytest.approx(4.0),
        "lights_gain_min": 3.0,
    }


def test_summary_compares_rivals_by_kind_of_scene():
    """The better one of Cycles' path guiding and none counts."""
    rows = [
        dict(indirect_scene=scene, gain=1.0, used=False) | ratios
        for scene, ratios in (
            ("S1", dict(cycles=40.0, paper=2.0)),
            ("S2", dict(cycles=10.0, paper=8.0)),
            ("cove", dict(cycles=90.0, cycles_guided=30.0)),
            ("door", dict(cycles=50.0, cycles_guided=60.0)),
            ("kitchen", dict(cycles=0.5)),
        )
    ]
    summary = indirect.summary_of(rows)
    assert summary["mse_ratio_cycles_bounces_geomean"] == pytest.approx(20.0)
    assert summary["mse_ratio_cycles_bounces_min"] == 10.0
    assert summary["mse_ratio_paper_bounces_geomean"] == pytest.approx(4.0)
    assert summary["rooms_ratio_cycles_min"] == 30.0
    assert summary["interiors_ratio_cycles_geomean"] == summary["interiors_ratio_cycles_min"] == 0.5


def test_rows_of_other_scenes_stay_in_the_document(tmp_path, monkeypatch):
    copy = tmp_path / "sampling.md"
    copy.write_text(indirect.DOCUMENT.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(indirect, "DOCUMENT", copy)
    indirect.document([])
    before = copy.read_text(encoding="utf-8").splitlines()
    indirect.document(
        [dict(indirect_scene="sign", used=True, chosen="path reuse", gain=2.5, cycles=12.0, cycles_guided=13.0)]
    )
    after = copy.read_text(encoding="utf-8").splitlines()
    assert "| sign | path reuse | 2.50 |  | 12 | 13 |  |  |  |  |" in after
    assert [line for line in after if not line.startswith("| sign ")] == [
        line for line in before if not line.startswith("| sign ")
    ]


@pytest.mark.slow
def test_a_room_is_measured():
    parser = argparse.ArgumentParser()
    indirect.arguments(parser)
    options = parser.parse_args(["--rooms", "cove"])
    vars(options).update(quick=True, repeats=2, device="CPU", resume=None, document_indirect=False, even=False)
    summary, (row,) = indirect.run(options)
    assert row["used"] and row["gain"] > 2.0
    assert summary["rooms_gain_min"] == row["gain"]
    assert summary["rooms_ratio_cycles_min"] == min(row["cycles"], row["cycles_guided"]) > 1.0
