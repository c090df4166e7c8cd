# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through lamps that are fields, on the GPU, against the CPU's intervals."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.emitter import lamps
from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build
from sdf_lights.emitter.tree.interior import tree
from sdf_lights.jit import kernel
from sdf_lights.render.gpu import crossings
from sdf_lights.render.kernels.workspace import spans_of
from sdf_lights.render.settings import LampSampling
from sdf_lights.sdf.expression import Expression
from support.lamps.hard_cases import SMOOTH, scattered
from tests.gpu.support import with_lamp

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

BLOB = (
    "smooth_union(translate(sphere(0.5), (-0.45, 0, 0)), translate(sphere(0.4), (0.4, 0.1, 0.2)), "
    "translate(sphere(0.3), (0.1, -0.2, -0.5)), 0.25)"
)
COUNT = 4096

# Shape, and of rays: the mean error of the length inside, relative to the reach; the part with another number of
# intervals; the part of the length that is left unresolved.
FIELDS = {
    "blob": (Expression(BLOB).shape(), 2e-7, 0.0, 1e-3),
    "smooth combination": (SMOOTH, 1e-6, 1e-3, 2e-3),
    "30 parts": (scattered(30), 1e-6, 2e-3, 4e-3),
    "noise": (Expression("noise_displacement(sphere(0.7), 0.1, 0.2, 3)").shape(), 2e-7, 1e-3, 5e-3),
    "twist": (Expression("twist(box(0.15, 0.1, 0.4), 1.5)").shape(), 2e-7, 0.0, 1e-3),
    "helix": (Expression("helix()").shape(), 2e-7, 0.0, 1e-3),
    # Nothing bounds its slope everywhere.
    "free expression": (Expression("length(p) - 0.5 + 0.1 * sqrt(abs(p.x))").shape(), 1e-6, 2e-3, 1e-2),
    "Mandelbulb": (Expression("mandelbulb()").shape(), 5e-5, 0.15, 0.07),
}


@kernel
def traced(block, workspace, o, d):
    """Of a ray: the number of intervals, their length, and its first moment."""
    spans = spans_of(workspace)
    count = lamps.trace(block, 0, o, d, spans)
    total, moment = 0.0, 0.0
    for index in range(count):
        total += 2.0 * spans[index, 1]
        moment += 2.0 * spans[index, 1] * spans[index, 0]
    return float(count), total, moment


def rays(lamp: Lamps, far: float, rng) -> np.ndarray:
    """(COUNT, 6) origins so many reaches away, and directions into the box, as float32 has them."""
    way = rng.normal(size=(COUNT, 3))
    origins = lamp.row["center"] + far * lamp.row["bounding_radius"] * way / np.linalg.norm(way, axis=1, keepdims=True)
    directions = lamp.row["center"] + lamp.row["half"] * rng.uniform(-1.0, 1.0, (COUNT, 3)) - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.hstack([origins, directions]).astype(np.float32).astype(float)


@pytest.mark.parametrize("name", FIELDS)
def test_intervals_are_those_of_the_cpu(name):
    shape, length_error, other, left = FIELDS[name]
    lamp = Lamps(build.build_lamp(name, shape, np.eye(4)))
    assert lamp.row["kind"] == lamps.FIELD
    reach = lamp.row["bounding_radius"]
    for far in (3.0, 0.3):
        given = rays(lamp, far, np.random.default_rng(1))
        expected = np.zeros((COUNT, 3))
        for row, ray in zip(expected, given):
            spans = lamp.trace(ray[:3], ray[3:])
            row[:] = len(spans), 2.0 * spans[:, 1].sum(), 2.0 * (spans[:, 1] * spans[:, 0]).sum()
        found, (unresolved, inside) = with_lamp(traced, shape, given, LampSampling.MIS)
        assert (found[:, 0] != expected[:, 0]).mean() <= other
        assert np.abs(found[:, 1] - expected[:, 1]).mean() < length_error * reach
        assert found[:, 1].sum() == pytest.approx(expected[:, 1].sum(), rel=1e-4)
        assert found[:, 2].sum() == pytest.approx(expected[:, 2].sum(), rel=1e-4)
        assert 0.0 <= unresolved <= left * (unresolved + inside)


@pytest.mark.parametrize("name", FIELDS)
def test_flat_nodes_hold_the_bounds(name):
    """In float16, and on the safe side."""
    nodes = tree(FIELDS[name][0]).nodes
    flat = crossings.flat_nodes(nodes)
    assert np.array_equal(flat["what"] & 3, nodes["state"])
    assert np.array_equal(flat["what"] >> 2 & 3, nodes["axis"])
    assert np.array_equal((flat["what"] >> crossings.SHIFT) - 1, nodes["first"])
    bounded = flat["what"] & crossings.BOUNDED != 0
    assert np.isfinite(nodes["gradient"][bounded]).all()
    kept = np.ascontiguousarray(flat["slopes"]).view(np.float16).reshape(-1, 3, 2).astype(float)[bounded]
    given = nodes["gradient"][bounded].astype(float)
    assert (kept[:, :, 0] <= given[:, 0]).all() and (kept[:, :, 1] >= given[:, 1]).all()
    assert np.abs(kept.transpose(0, 2, 1) - given).max(initial=0.0) < 2e-3 * max(np.abs(given).max(initial=0.0), 1.0)
