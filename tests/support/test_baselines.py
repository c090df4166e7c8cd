# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The published variances of estimators around a torus, and the checks that go with them."""

import math

import numpy as np
import pytest

from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build
from sdf_lights.jit import fill_table
from sdf_lights.sdf.shapes import Torus
from support.chi2 import sphere_integral
from support.rivals import baselines
from support.rivals.baselines import EVEN, TORUS_SHELL, LampBlock, Technique

ABOVE, INSIDE = (0.4, 0.2, 1.6), (1.0, 0.0, 0.1)
DOWN = (0.0, 0.0, -1.0)
CASES = {"above": (ABOVE, EVEN, 0.22912), "inside": (INSIDE, EVEN, 0.70850), "shell": (ABOVE, TORUS_SHELL, 0.3327)}
PUBLISHED = {
    Technique.UNIFORM: {"above": 0.5597, "inside": 0.7608, "shell": 1.3912},
    Technique.COSINE: {"above": 0.1273, "inside": 0.0712, "shell": 0.3365},
    Technique.POINT: {"above": 0.0058, "shell": 0.0580},
    Technique.PROJECTION: {"above": 0.0037, "inside": 4.8135, "shell": 0.0485},
    Technique.MIS: {"above": 0.0087, "inside": 0.0536, "shell": 0.0458},
}
SAMPLES = 400_000


@pytest.fixture(scope="module")
def torus():
    return Lamps(build.build_lamp("torus", Torus(1.0, 0.35), np.eye(4), power=4.0 * math.pi))


@pytest.fixture(scope="module")
def lit():
    return LampBlock(Torus(1.0, 0.35), np.eye(4), surface=True)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("technique", PUBLISHED, ids=lambda t: t.name.lower())
def test_published_variances(lit, technique, case):
    """Within the 5 % the table states as its own noise; the means within four standard errors."""
    x, shell, truth = CASES[case]
    estimate = baselines.run(technique, lit.blocks, 0, x, DOWN, SAMPLES, 1, shell)
    assert abs(estimate.mean - truth) < 4.0 * estimate.error + 1e-4
    if case in PUBLISHED[technique]:
        assert estimate.variance == pytest.approx(PUBLISHED[technique][case], rel=0.05)
    else:
        # A point light inside the lamp: the variance is infinite, so no figure is stable (35 was published, with a mean
        # of 0.656). What holds is that it dwarfs all others.
        assert estimate.variance > 25.0


# Variances of resampling, of the other weights and of the cut that a prototype had, with half as much again for room.
PROTOTYPE = {
    Technique.MIS_BETA: {"above": 0.0050, "inside": 0.0378},
    Technique.RIS: {"above": 0.0011},
    Technique.RADIAL: {"above": 0.0053, "inside": 0.054},
    Technique.CUT: {"above": 0.00033, "inside": 0.0378, "shell": 0.054},
    Technique.BOUNDING: {},
    Technique.SURFACE: {},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("technique", PROTOTYPE, ids=lambda t: t.name.lower())
def test_other_techniques(lit, technique, case):
    """Unbiased where their variance is finite, and as good as they were."""
    x, shell, truth = CASES[case]
    if technique == Technique.RADIAL and shell != EVEN:
        pytest.skip("its weights are for uniform emission")
    if technique == Technique.RIS and case == "inside":
        pytest.skip("its variance is infinite")
    estimate = baselines.run(technique, lit.blocks, 0, x, DOWN, SAMPLES // 4, 1, shell)
    assert abs(estimate.mean - truth) < 4.0 * estimate.error + 1e-4
    assert estimate.variance < PROTOTYPE[technique].get(case, np.inf)


@pytest.mark.parametrize("x", [ABOVE, INSIDE])
def test_density_integrates_to_one(torus, x):
    total, error = sphere_integral(lambda d: torus.pdf(x, d), 200_000, seed=3)
    assert error < 2e-3 and abs(total - 1.0) < 4.0 * error


@pytest.mark.parametrize("distance, published", [(1.5, 0.013), (3.0, 0.004), (10.0, 0.0)])
def test_weights_become_constant_with_distance(torus, distance, published):
    """Coefficient of variation of L/p over projection samples, to the digits that were published."""
    x = (0.0, 0.0, distance)
    directions = torus.sample(x, np.random.default_rng(4).random((100_000, 3)))
    weight = torus.chord(x, directions) / torus.pdf(x, directions)
    assert abs(weight.std() / weight.mean() - published) < 6e-4


def with_wrong_volume(lit):
    """Blocks of the same lamp with a volume that is 5 % too large, and the tables that they read."""
    tables = {name: array.copy() for name, array in lit.tables.items()}
    tables["lamps"]["volume"] *= 1.05
    tables["lamps"]["emission"] /= 1.05
    blocks = lit.blocks.copy()
    for name, array in tables.items():
        fill_table(blocks, name, array)
    return blocks, tables


def test_a_wrong_volume_cancels_in_projection_only(lit):
    """V̂ = 1.05 V: projection sampling keeps its mean, directions of the BSDF lose a factor of exactly 1.05."""
    blocks, _tables = with_wrong_volume(lit)
    for technique, ratio in ((Technique.PROJECTION, 1.0), (Technique.POINT, 1.0), (Technique.COSINE, 1.0 / 1.05)):
        right, wrong = (baselines.run(technique, b, 0, ABOVE, DOWN, 50_000, 5).mean for b in (lit.blocks, blocks))
        assert wrong / right == pytest.approx(ratio, rel=1e-12)


def test_wrong_volume_bounds_the_bias_of_mis(lit):
    """Both techniques together are off by less than the volume is."""
    blocks, _tables = with_wrong_volume(lit)
    right, wrong = (baselines.run(Technique.MIS, b, 0, ABOVE, DOWN, SAMPLES, 6) for b in (lit.blocks, blocks))
    assert 1.0 / 1.05 - 1e-3 < wrong.mean / right.mean < 1.0 + 1e-3
