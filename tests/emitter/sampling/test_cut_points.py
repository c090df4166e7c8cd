# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points that stand for rays towards a lamp: what they give is what its rays give, with less noise where emission
varies."""

import math

import numpy as np
import pytest

from sdf_lights.emitter.sampling import cut, cut_points
from sdf_lights.jit import kernel
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.shapes import Sphere, Torus
from support.lamps.shapes_under_test import COMPOSITES, FIELDS, scaled, turned
from support.rivals import baselines
from support.rivals.baselines import LampBlock, Technique

N = 20_000
SHAPES = {"torus": Torus(0.7, 0.2), "ball": Sphere(0.6), "nested": COMPOSITES["nested"], "blob": FIELDS["blob"]}
EMISSIONS = {
    "even": None,
    "shell": "exp(-30 * depth)",
    "height": "height",
    "half": "1 if p.x > 0 else 0",
    "spots": "1 if sin(40 * p.x) * sin(40 * p.y) > 0.9 else 0",
}
PLACES = {
    "above": ((0.3, 0.2, 1.9), (0.0, 0.1, -1.0)),
    "beside": ((-2.0, 0.4, 0.1), (1.0, 0.0, 0.3)),
    "far": ((3.0, 8.0, 40.0), (0.0, -0.2, -1.0)),
}


@kernel
def _lit(blocks, x, n, has_glossy, afar, tolerance, keys, store, cuts, u):
    """What each light ray by points gives the irradiance at x; the first number is −1 where rays are asked for."""
    out = np.zeros(len(u))
    if afar:
        cut_points.project_afar(blocks[0], 0, x, has_glossy, cuts[0])
    else:
        cut.prepare(blocks[0], 0, x, n, 0, has_glossy, tolerance, cut.LIMIT, keys, store, cuts[0])
    if not cuts[0].points:
        out[0] = -1.0
        return out
    for i in range(len(u)):
        way, intensity = cut_points.sample_point(blocks[0], 0, x, store, cuts[0], u[i, 0], u[i, 1], u[i, 2])
        square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2]
        cosine = (n[0] * way[0] + n[1] * way[1] + n[2] * way[2]) / math.sqrt(square)
        out[i] = max(cosine, 0.0) / square * (intensity[0] + intensity[1] + intensity[2]) / 3.0
    return out


def lit(block, x, n, afar=False, has_glossy=0, seed=1, tolerance=4.0 * cut.TOLERANCE):
    n = tuple(np.asarray(n, float) / np.linalg.norm(n))
    return _lit(
        block.blocks,
        x,
        n,
        has_glossy,
        afar,
        tolerance,
        np.zeros(4, cut.KEYS),
        np.zeros(4, cut.BOXES),
        np.zeros(1, cut.CUT),
        np.random.default_rng(seed).random((N, 3)),
    )


@pytest.fixture(scope="module")
def lamp():
    made = {}

    def get(shape, emission, matrix=np.eye(4)):
        key = shape, emission, matrix.tobytes()
        if key not in made:
            text = EMISSIONS[emission]
            made[key] = LampBlock(
                SHAPES[shape], matrix, emission=None if text is None else EmissionExpression(text).emission()
            )
        return made[key]

    return get


@pytest.mark.parametrize("afar", [False, True])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("emission", EMISSIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_points_give_what_rays_give(lamp, shape, emission, place, afar):
    """Within 4.5 standard errors, in 96 configurations, and what leaves' volumes are known to."""
    block, (x, n) = lamp(shape, emission), PLACES[place]
    found = lit(block, x, n, afar)
    # Spots that leaves are too coarse for are left to rays.
    assert (found[0] == -1.0) == (emission == "spots")
    if emission == "spots":
        return
    rays = baselines.run(Technique.PROJECTION, block.blocks, 0, x, tuple(np.asarray(n) / np.linalg.norm(n)), 4 * N, 2)
    error = math.hypot(found.std() / math.sqrt(N), rays.error)
    assert abs(found.mean() - rays.mean) < 4.5 * error + 2e-3 * rays.mean
    assert error < 0.03 * rays.mean


@pytest.mark.parametrize("shape, most", [("torus", 0.2), ("ball", 0.1), ("nested", 0.2), ("blob", 0.15)])
def test_a_shell_is_far_less_noisy(lamp, shape, most):
    """No box follows it; the leaves do."""
    block, (x, n) = lamp(shape, "shell"), PLACES["above"]
    found = lit(block, x, n)
    rays = baselines.run(Technique.PROJECTION, block.blocks, 0, x, tuple(np.asarray(n) / np.linalg.norm(n)), N, 2)
    assert found.var() < most * rays.variance


def test_lamps_may_be_stretched(lamp):
    matrix = scaled(1.5, 0.6, 1.0) @ turned(0.3, 1)
    block, (x, n) = lamp("torus", "shell", matrix), PLACES["above"]
    found = lit(block, x, n)
    rays = baselines.run(Technique.PROJECTION, block.blocks, 0, x, tuple(np.asarray(n) / np.linalg.norm(n)), 8 * N, 2)
    assert abs(found.mean() - rays.mean) < 4.0 * math.hypot(found.std() / math.sqrt(N), rays.error) + 2e-3 * rays.mean


def test_rays_are_asked_for_where_they_compete(lamp):
    """Lobes of microfacets are weighed against a density of directions; close to a lamp, so is the cosine."""
    for emission in ("even", "shell"):
        block = lamp("torus", emission)
        for afar in (False, True):
            assert lit(block, *PLACES["above"], afar=afar, has_glossy=1)[0] == -1.0
            assert lit(block, (0.75, 0.0, 0.3), (0.3, 0.0, -1.0), afar=afar)[0] == -1.0


def test_surfaces_inside_a_lamp_hide_parts_of_rays(lamp):
    """So rays are less noisy there, as long as boxes follow the emission."""
    for emission, rays in (("even", True), ("height", True), ("shell", False)):
        block = lamp("torus", emission)
        placed = block.tables["lamp_placements"]
        assert placed["clear"][0] == 1 and lit(block, *PLACES["above"])[0] >= 0.0
        placed["clear"] = 0
        assert (lit(block, *PLACES["above"])[0] == -1.0) == rays
        placed["clear"] = 1


@pytest.mark.parametrize("shape, rays", [("torus", True), ("ball", True), ("nested", False), ("blob", False)])
def test_rays_through_a_primitive_cost_little(lamp, shape, rays):
    """So they are less noisy for their time, unless the lamp is one of many."""
    block = lamp(shape, "even")
    assert (lit(block, *PLACES["above"], tolerance=cut.TOLERANCE)[0] == -1.0) == rays
    assert lit(block, *PLACES["above"])[0] >= 0.0
