# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts of boxes that are the same for all points: on the CPU, by the same kernels, and as the GPU reads them."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.emitter import lamps
from sdf_lights.emitter.building import pack
from sdf_lights.emitter.sampling import cut
from sdf_lights.emitter.sampling.strategies import BOXES
from sdf_lights.jit import kernel
from sdf_lights.render.gpu import lamp_kernels as gpu_lamps
from sdf_lights.render.kernels.workspace import box_table, cut_of, spans_of
from sdf_lights.sdf.expression import Expression
from support.chi2 import chi2_sphere, sphere_integral
from support.rivals.baselines import LampBlock
from tests.emitter.sampling.test_cut import POINTS, SHAPES, density, sample, unit
from tests.gpu.support import with_lamp
from tests.gpu.test_session import balls

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

ALL = 0.0  # tolerance
TRACED = {  # by boxes of parts, and by a program that is written out
    **SHAPES,
    "balls": Expression(f"union({balls(12)})").shape(),
    "shell": Expression("box(0.5) - sphere(0.6)").shape(),
}


@kernel
def _prepare(blocks, x, n, store, rows):
    gpu_lamps.prepare(blocks[0], 0, x, n, 0, 1, ALL, gpu_lamps.LIMIT, None, store, rows[0])


class FlatCut:
    """The cut of a lamp for a point, on the CPU."""

    def __init__(self, shape, x, n):
        self._lamp, self._x, self.rows = (
            LampBlock(shape, np.eye(4)),
            tuple(map(float, x)),
            np.zeros(1, gpu_lamps.FLAT_CUT),
        )
        self._spans = pack.new_spans(int(self._lamp.blocks["lamp_rows"][0]), 1)
        self.store = gpu_lamps.flat_boxes(self._lamp.tables)
        _prepare(self._lamp.blocks, self._x, unit(n), self.store, self.rows)

    def sample(self, u):
        return sample(self._lamp.blocks, self._x, self._spans, self.store, self.rows, np.ascontiguousarray(u, float))

    def density(self, directions):
        return density(
            self._lamp.blocks, self._x, self.store, self.rows, np.ascontiguousarray(directions, float), self._spans
        )


def test_there_is_room_for_whole_vectors_of_boxes():
    assert gpu_lamps.LIMIT % cut.WIDTH == 0


@pytest.mark.parametrize("shape", SHAPES)
def test_boxes_hold_the_lamp(shape):
    store = FlatCut(SHAPES[shape], *POINTS["above"]).store[0]
    assert 1 < store["count"] <= gpu_lamps.LIMIT
    clipped = store["solid"][: store["count"]] == 0
    volume = store["volume"][: store["count"]]
    assert volume[clipped].sum() <= 1.0 + 1e-5 and volume.sum() >= 1.0 - 1e-5


@pytest.mark.parametrize("point", POINTS)
@pytest.mark.parametrize("shape", ["torus", "frame", "blob"])
def test_density_integrates_to_one(shape, point):
    """Within the quadrature's own error, and what the volumes of boxes that are sampled are known to."""
    found = FlatCut(SHAPES[shape], *POINTS[point])
    total, error = sphere_integral(found.density, 200_000, seed=3)
    assert error < 1e-2
    assert abs(total - 1.0) < 4.0 * error + 1e-3


@pytest.mark.parametrize(
    "shape, point", [("torus", "close"), ("frame", "beside"), ("nested", "above"), ("blob", "above")]
)
def test_directions_have_their_density(shape, point):
    found = FlatCut(SHAPES[shape], *POINTS[point])
    assert found.rows["strategy"][0] == BOXES
    result = chi2_sphere(found.sample, found.density, n=100_000, seed=5, quadrature=48)
    assert result.passed, result


@kernel
def drawn(block, workspace, x, n, u, d):
    """A direction by the cut for a point, its density, and that of another direction."""
    store, row, spans = box_table(workspace), cut_of(workspace), spans_of(workspace)
    gpu_lamps.prepare(block, 0, x, n, 0, 1, ALL, gpu_lamps.LIMIT, None, store, row)
    w = cut.sample(block, 0, x, store, row, u[0], u[1], u[2])
    own = cut.density(block, 0, w, store, row, spans, lamps.trace(block, 0, x, w, spans))
    other = cut.density(block, 0, d, store, row, spans, lamps.trace(block, 0, x, d, spans))
    return w[0], w[1], w[2], own, other


@pytest.mark.parametrize("shape", ["torus", "nested", "balls", "shell"])
def test_the_gpu_draws_what_the_cpu_does(shape):
    """The same directions but where rounding takes another way, and the same densities but where a ray grazes an
    edge."""
    rng = np.random.default_rng(7)
    for x, n in POINTS.values():
        here = FlatCut(TRACED[shape], x, n)
        u = rng.random((512, 3)).astype(np.float32).astype(float)
        d = rng.normal(size=(512, 3)) + 2.0 * here.sample(u)
        d = (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32).astype(float)
        arguments = np.concatenate([np.tile([*x, *unit(n)], (512, 1)), u, d], axis=1)
        there, _ = with_lamp(drawn, TRACED[shape], arguments)
        assert np.allclose(np.linalg.norm(there[:, :3], axis=1), 1.0, atol=1e-5)
        alike = np.abs(there[:, :3] - here.sample(u)).max(1) < 1e-3
        assert alike.mean() > 0.6  # draws that are repeated take other numbers
        for found, expected in ((there[:, 3], here.density(there[:, :3])), (there[:, 4], here.density(d))):
            off = np.abs(found - expected) > 2e-3 * np.maximum(expected, 1e-2 * expected.mean())
            assert off.mean() < 0.01
