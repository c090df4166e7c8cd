# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark of whole scenes: its figures, and every scene beside Cycles."""

import pytest

bpy = pytest.importorskip("bpy")

from benchmarks import artist_scenes, scene_pictures, scenes  # noqa: E402  (found on the path that conftest.py sets)

SAMPLES, SEEDS = 32, 4


def test_all_scenes_are_known_by_name():
    assert sorted(scenes.KNOWN) == sorted(artist_scenes.SCENES)


def test_figures_of_rows():
    good = dict(
        artist_scene="a", error="", mean_difference=0.01, error_time_ratio=4.0, sync_ratio=0.5, memory_ratio=1.2
    )
    worse = dict(good, artist_scene="b", mean_difference=0.03, error_time_ratio=1.0, sync_ratio=1.4)
    failed = dict(artist_scene="c", error="the process ended with code 1")
    summary = scenes.summary_of([good, worse, failed])
    assert (summary["scenes"], summary["scenes_failed"]) == (3, 1)
    assert summary["worst_mean_difference"] == 0.03
    assert summary["error_time_ratio_to_cycles_geomean"] == pytest.approx(2.0)
    assert summary["error_time_ratio_to_cycles_min"] == 1.0
    assert summary["sync_ratio_to_cycles_max"] == 1.4
    assert "denoised_error_time_ratio_to_cycles_min" not in summary
    assert [text.partition(":")[0] for text in scenes.complaints([good, worse, failed])] == ["b", "c"]


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.KNOWN)
def test_mean_is_that_of_cycles(name):
    row = scene_pictures.difference(name, scene_pictures.QUICK_WIDTH, SAMPLES, SEEDS)
    assert row["mean_difference"] <= scenes.LIMIT + 2.0 * row["mean_doubt"], row
    assert row["mean_doubt"] < scenes.LIMIT, row
