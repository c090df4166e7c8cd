# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``bench allocation``: figures of pictures whose noise is known, and a run."""

import argparse
import importlib

import numpy as np
import pytest
from benchmarks import allocation

SHAPE = (400, 6, 5, 3)


def noisy(scale: float, seed: int) -> np.ndarray:
    return 1.0 + scale * np.random.default_rng(seed).standard_normal(SHAPE)


def test_gains_are_ratios_of_variance_times_time():
    """Of 36,000 normal numbers the variance is within 3 % with a confidence of 0.9999."""
    stacks = {allocation.ALL: noisy(0.1, 1), "splitting": noisy(0.2, 2), "guidance": noisy(0.1, 3)}
    found = allocation.gains_of(stacks, {allocation.ALL: 2.0, "splitting": 1.0, "guidance": 3.0})
    assert set(found) == {"splitting", "guidance"}
    assert found["splitting"]["gain"] == pytest.approx(4.0 * 0.5, rel=0.06)
    assert found["guidance"]["gain"] == pytest.approx(1.5, rel=0.06)
    assert found["splitting"]["time"] == 0.5 and found["guidance"]["time"] == 1.5


def test_the_second_figure_leaves_the_noisiest_pixels_out():
    stacks = {allocation.ALL: noisy(0.1, 4), "power": noisy(0.1, 5)}
    stacks["power"][:, 2, 2] += 50.0 * np.random.default_rng(6).standard_normal((SHAPE[0], 3))
    found = allocation.gains_of(stacks, {allocation.ALL: 1.0, "power": 1.0})["power"]
    assert found["gain"] > 100.0 and found["gain_of_most"] == pytest.approx(1.0, rel=0.1)


def test_summary_tells_lamps_from_other_scenes():
    rows = [
        dict(allocation_scene=scene, without="splitting", gain=9.0, gain_of_most=gain, time=1.0)
        for scene, gain in (("S1", 2.0), ("S4", 8.0), ("street", 0.5))
    ]
    assert allocation.summary_of(rows) == {
        "splitting_gain_lamps_geomean": pytest.approx(4.0),
        "splitting_gain_lamps_min": 2.0,
        "splitting_gain_ordinary_geomean": pytest.approx(0.5),
        "splitting_gain_ordinary_min": 0.5,
    }


@pytest.mark.parametrize("term", allocation.TERMS)
def test_what_a_term_switches_off_exists(term):
    from sdf_lights.render.cpu import path_splitting
    from sdf_lights.render.settings import Settings

    _, settings, values = allocation.TERMS[term]
    assert settings or values
    assert all(hasattr(Settings(), name) for name in settings)
    modules = path_splitting, *(importlib.import_module(f"sdf_lights.{owner}") for owner in allocation.OWNERS)
    assert all(sum(hasattr(module, name) for module in modules) == 1 for name in values)


def test_constants_of_kernels_reach_them():
    """Constants of ``path_splitting`` are compiled into the kernel of a tile and those that it calls."""
    from sdf_lights.render.cpu import path_splitting

    tile = allocation._tile(path_splitting, (("CONNECTION_COST", 0.25), ("LEAST_SURVIVAL", 0.5)))
    branches = tile.__wrapped__.__globals__["trace_branches"]
    roulette = branches.__wrapped__.__globals__["roulette_branches"]
    assert branches.__wrapped__.__globals__["CONNECTION_COST"] == 0.25
    assert roulette.__wrapped__.__globals__["LEAST_SURVIVAL"] == 0.5
    assert path_splitting.LEAST_SURVIVAL != 0.5 and tile.__name__ != path_splitting.render_tile.__name__


def noise(first: float, second: float):
    from sdf_lights.render import sample_allocation

    count = np.full(50, 1.0)
    return sample_allocation._Noise(np.ones(50, bool), first * count, second * count, 1.0, met=2.0, cost=3.0)


@pytest.mark.parametrize(("first", "second"), [(0.1, 0.4), (1.0, 30.0), (0.02, 0.01)])
def test_factors_of_ears_minimise_variance_times_time(first, second):
    """Where all pixels are alike, the best splitting factor is √(I C / (D m))."""
    rate, count = allocation.ears(noise(first, second), None, 16, (1.0,), (1, 2, 4, 8, 16))
    expected = np.sqrt(second * 3.0 / (first * 2.0))
    assert (rate == 1.0).all() and count == pytest.approx(np.clip(expected, 1.0, 16.0), abs=1.0)
    assert (allocation.ears(noise(first, second), None, 16, (1.0,), (1,))[1] == 1.0).all()


@pytest.mark.slow
def test_a_scene_is_measured():
    parser = argparse.ArgumentParser()
    allocation.arguments(parser)
    options = parser.parse_args(["--only", "S4", "--terms", "splitting"])
    vars(options).update(quick=True, repeats=2, device="CPU", resume=None)
    (row,) = allocation.measure("S4", ["splitting"], options)
    assert row["allocation_scene"] == "S4" and row["without"] == "splitting"
    assert 0.0 < row["gain"] < np.inf and 0.0 < row["time"] < np.inf
