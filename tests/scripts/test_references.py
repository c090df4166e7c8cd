# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""References are kept between runs, know their error, and belong to one scene."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from benchmarks import lamp_scenes, references  # noqa: E402


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))


def noise(seed: int) -> tuple[np.ndarray, float]:
    return 1.0 + 0.1 * np.random.default_rng(seed).standard_normal((30, 30, 3)), 0.5


def test_an_interrupted_reference_goes_on_where_it_was():
    first = references.Reference("scene")
    for _ in range(3):
        first.add(noise)
    again = references.Reference("scene")
    assert len(again.renders) == 3 and again.seconds == 1.5
    again.add(noise)
    assert len({render[0, 0, 0] for render in again.renders}) == 4  # another seed for each
    assert references.Reference("another").renders == []


def test_variance_is_that_of_the_mean():
    reference = references.Reference("scene")
    for _ in range(8):
        reference.add(noise)
    assert reference.variance.mean() == pytest.approx(0.01 / 8, rel=0.1)
    assert np.mean((reference.pixels - 1.0) ** 2) == pytest.approx(0.01 / 8, rel=0.1)


def test_a_reference_made_anew_forgets_what_was_kept():
    first = references.Reference("scene")
    for _ in range(3):
        first.add(noise)
    again = references.Reference("scene")
    assert np.allclose(again.pixels, first.pixels) and np.allclose(again.variance, first.variance)
    again.forget()
    again.add(noise)
    assert np.array_equal(again.pixels, noise(references.FIRST_SEED)[0]) and np.all(np.isinf(again.variance))
    assert len(references.Reference("scene").renders) == 1


def test_a_scene_that_is_built_again_has_the_same_fingerprint():
    prints = []
    for name in ("S1", "S2", "S1"):
        lamp_scenes.SCENES[name].build(64)
        bpy.context.view_layer.update()
        prints.append(references.fingerprint())
    assert prints[0] == prints[2] != prints[1]
    bpy.data.lights["Lamp"].sdf_lamp.density *= 2.0
    assert references.fingerprint() != prints[0]
