# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark of single features: its figures, and every feature beside Cycles."""

import argparse

import numpy as np
import pytest

pytest.importorskip("bpy")

from benchmarks import features


def noisy(seed: int, brightness: float = 1.0) -> np.ndarray:
    random = np.random.default_rng(seed)
    return brightness * random.uniform(0.5, 1.5, (4, 64, 64, 3))


def test_noise_is_no_difference():
    assert features._difference(noisy(1), noisy(2))["mean_difference"] < 0.003


@pytest.mark.parametrize(("low", "expected"), [(0.0, 0.05), (-2.0, 0.1)])
def test_a_difference_is_found(low, expected):
    """In the brightness of one channel; of data below zero, relative to what they are above their least."""
    ours = noisy(2)
    ours[..., 1] *= 1.05
    found = features._difference(noisy(1) + low, ours + low)
    assert found["mean_difference"] == pytest.approx(expected, rel=0.2)


def test_figures_of_rows():
    good = {"feature": "a", "pass": "Combined", "error": "", "mean_difference": 0.002, "is_beyond_noise": False}
    rows = [
        good,
        dict(good, mean_difference=0.02),
        dict(good, feature="b", block_difference=-0.3, is_beyond_noise=True),
    ]
    rows.append({"feature": "c", "pass": "", "error": "the process ended with code 1"})
    assert features.summary_of(rows) == dict(
        features=3, features_failed=1, features_over_one_percent=2, features_worst_mean_difference=0.02
    )
    assert features.complaints(rows) == [
        "a, Combined: its mean differs by 2 %.",
        "b, Combined: a part of it differs by 30 %.",
        "c: the process ended with code 1.",
    ]


def test_a_difference_must_be_there_with_more_samples(monkeypatch):
    def measured(name, device, samples):
        few = samples < features.SAMPLES
        return [{"error": "", "mean_difference": 0.0, "is_beyond_noise": few or name == "b", "samples": samples}]

    monkeypatch.setattr(features, "_measured", measured)
    quick = argparse.Namespace(quick=True, device="CPU")
    assert [features.differs(row) for name in "ab" for row in features.measure(name, quick)] == [False, True]


def test_unknown_names_are_told():
    with pytest.raises(SystemExit, match="there is no 'sunn'"):
        features.run(argparse.Namespace(features=["sunn"]))


# One of each kind: `bench features` has them all, and so have tests of tests/blender.
FEATURES = (
    *("depth of field", "mirror ball", "right eye", "clipping", "render region", "hair as ribbons", "points", "alpha"),
    *("adaptive subdivision", "displacement and bump", "shadow catcher", "light linking", "lights without shadow"),
    *("zooming camera", "moving instances", "rolling shutter", "passes", "cryptomatte", "light groups mixed anew"),
    *("film", "without sky", "excluded and indirect only", "haze with a spot", "absorption", "phase functions"),
)


@pytest.mark.slow
@pytest.mark.parametrize("name", FEATURES)
def test_means_are_those_of_cycles(name):
    rows = features.measure(name, argparse.Namespace(quick=True, device="CPU"))
    assert rows
    for row in rows:
        assert row["error"] == "" and not features.differs(row), row
