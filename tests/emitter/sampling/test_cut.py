# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cell-cut sampling: its density is that of its directions, it is unbiased, and no transform changes it."""

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.emitter.building import build, pack
from sdf_lights.emitter.sampling import cut, hidden
from sdf_lights.emitter.sampling.strategies import BOXES, PROJECTION
from sdf_lights.emitter.tree import moments
from sdf_lights.emitter.tree.interior import tree
from sdf_lights.jit import fill_table, kernel
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.shapes import Box, BoxFrame, Sphere, Torus, Transformed, Union
from support.chi2 import chi2_sphere, sphere_integral
from support.lamps.shapes_under_test import COMPOSITES, FIELDS, PLACEMENTS, moved, scaled, turned
from support.rivals import baselines
from support.rivals.baselines import LampBlock, Technique

SHAPES = {
    "torus": Torus(0.7, 0.2),
    "box": Box((0.7, 0.4, 0.2)),
    "frame": BoxFrame((0.6, 0.5, 0.4), 0.08),
    "apart": COMPOSITES["apart"],
    "nested": COMPOSITES["nested"],
    "thin": COMPOSITES["thin"],
    "blob": FIELDS["blob"],
}
POINTS = {
    "above": ((0.3, 0.2, 1.6), (0.0, 0.1, -1.0)),
    "close": ((0.75, 0.0, 0.3), (0.3, 0.0, -1.0)),
    "beside": ((1.0, 0.1, 0.05), (0.0, 0.0, 1.0)),
    "middle": ((0.02, 0.01, 0.03), (0.1, 0.2, 1.0)),
}
TIGHT = 0.0  # tolerance: as many boxes as there is room for


def unit(n):
    return tuple(np.asarray(n, float) / np.linalg.norm(n))


@kernel
def _prepare(blocks, x, n, two_sided, tolerance, limit, keys, store, cuts):
    cut.prepare(blocks[0], 0, x, n, two_sided, 1, tolerance, limit, keys, store, cuts[0])


@kernel
def sample(blocks, x, spans, store, cuts, u):
    out = np.empty((len(u), 3))
    for i in range(len(u)):
        out[i] = cut.sample(blocks[0], 0, x, store, cuts[0], u[i, 0], u[i, 1], u[i, 2])
    return out


@kernel
def density(blocks, x, store, cuts, directions, spans):
    out = np.empty(len(directions))
    for i in range(len(directions)):
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        count = lamps.trace(blocks[0], 0, x, d, spans)
        out[i] = cut.density(blocks[0], 0, d, store, cuts[0], spans, count)
    return out


@kernel
def _project(blocks, x, cuts):
    cut.project(blocks[0], 0, x, 0, cuts[0])


class Cut:
    """The cut of a lamp for a point."""

    def __init__(self, lamp: LampBlock, x, n, tolerance=TIGHT, limit=16, two_sided=0):
        self.lamp, self.x, self.rows = lamp, tuple(map(float, x)), np.zeros(1, cut.CUT)
        self.spans, self.store = pack.new_spans(int(lamp.blocks["lamp_rows"][0]), 1), np.zeros(4, cut.BOXES)
        _prepare(
            lamp.blocks, self.x, unit(n), two_sided, tolerance, limit, np.zeros(4, cut.KEYS), self.store, self.rows
        )

    @property
    def boxes(self):
        """How many there are; 0 for projection sampling."""
        by_boxes = self.rows["strategy"][0] == BOXES
        return int(self.store["count"][int(self.rows["slot"][0])]) if by_boxes else 0

    def sample(self, u):
        return sample(self.lamp.blocks, self.x, self.spans, self.store, self.rows, u)

    def density(self, directions):
        return density(self.lamp.blocks, self.x, self.store, self.rows, np.ascontiguousarray(directions), self.spans)


@pytest.fixture(scope="module")
def lamp():
    made = {}

    def get(shape, matrix=np.eye(4)):
        key = shape, matrix.tobytes()
        if key not in made:
            made[key] = LampBlock(shape, matrix)
        return made[key]

    return get


def test_lamps_that_are_chosen_seldom_have_fewer_boxes(lamp):
    tolerances = [cut.tolerance_for(chance) for chance in (1.0, 0.3, 0.1, 0.02, 1e-9, 0.0)]
    assert tolerances[0] == tolerances[1] == cut.TOLERANCE and tolerances[-1] <= 4.0 * cut.MOST_TOLERANCE
    found = [Cut(lamp(SHAPES["torus"]), *POINTS["above"], tolerance=tolerance).boxes for tolerance in tolerances]
    assert found == sorted(found, reverse=True) and found[0] >= 2 * found[3] >= 2 * found[-1] > 0, found


@pytest.mark.parametrize("emission, even", [("1", True), ("1 + height", True), ("exp(-30 * depth)", False)])
def test_lamps_that_no_boxes_follow_are_projected(emission, even):
    """Nor is a region asked for them: its boxes would take their time and not be used."""
    glowing = LampBlock(SHAPES["torus"], np.eye(4), emission=EmissionExpression(emission).emission())
    assert (glowing.tables["lamp_placements"]["rough"][0] < cut.ROUGHEST) == even
    found = Cut(glowing, *POINTS["above"])
    assert (found.boxes > 0) == even and bool(found.store["count"].any()) == even


@pytest.mark.parametrize("count", [1, 7, 8, 9, cut.LIMIT])
def test_boxes_are_fitted_in_whole_vectors(count):
    together = int(cut._together(count))
    assert count <= together < count + cut.WIDTH and together % cut.WIDTH == 0 and together <= cut.MOST_BOXES


@pytest.mark.parametrize("shape", SHAPES)
def test_cells_add_up(shape):
    """The moments of the root are those of the shape; children divide their parents."""
    volume = build.volume_of(SHAPES[shape])[0]
    cells = moments.cells(tree(SHAPES[shape]), volume)
    assert cells["volume"][0] == pytest.approx(volume, rel=1e-12)
    inner = cells[cells["first"] >= 0]
    left, right = cells[inner["first"]], cells[inner["first"] + 1]
    assert np.allclose(left["volume"] + right["volume"], inner["volume"], rtol=1e-12)
    assert np.all(np.minimum(left["low"], right["low"]) == inner["low"])
    assert np.all(np.maximum(left["high"], right["high"]) == inner["high"])
    assert np.all((cells["centroid"] >= cells["low"]) & (cells["centroid"] <= cells["high"]))
    axis = inner["axis"][:, None]
    assert np.all(np.take_along_axis(left["high"], axis, 1) <= np.take_along_axis(right["low"], axis, 1))


def test_moments_of_a_sphere():
    cells = moments.cells(tree(Sphere(0.5)), Sphere(0.5).volume())
    assert np.allclose(cells["centroid"][0], 0.0, atol=1e-4)
    assert np.allclose(cells["spread"][0], 0.2 * 0.25, rtol=0.05)  # of the boxes around it, so a little too large


@pytest.mark.parametrize("point", POINTS)
@pytest.mark.parametrize("shape", SHAPES)
def test_density_integrates_to_one(lamp, shape, point):
    """Within the quadrature's own error, and what the volumes of boxes that are sampled are known to."""
    found = Cut(lamp(SHAPES[shape]), *POINTS[point])
    if found.boxes == 0:
        return
    total, error = sphere_integral(found.density, 200_000, seed=3)
    assert error < 5e-3
    assert abs(total - 1.0) < 4.0 * error + 1e-3


@pytest.mark.parametrize(
    "shape, point",
    [
        ("torus", "close"),
        ("frame", "middle"),
        ("nested", "above"),
        ("thin", "beside"),
        ("blob", "above"),
        ("apart", "middle"),
        ("box", "beside"),
    ],
)
def test_directions_have_their_density(lamp, shape, point):
    found = Cut(lamp(SHAPES[shape]), *POINTS[point])
    assert found.boxes > 4
    result = chi2_sphere(found.sample, found.density, n=100_000, seed=5, quadrature=48)
    assert result.passed, result


@pytest.mark.parametrize("point", POINTS)
@pytest.mark.parametrize("shape", SHAPES)
def test_unbiased(lamp, shape, point):
    """The same irradiance as cosine sampling gives, within 4.5 standard errors: one in 5,000 of all 28 cases
    together."""
    block, (x, n) = lamp(SHAPES[shape]), POINTS[point]
    found = baselines.run(Technique.CUT, block.blocks, 0, x, unit(n), 40_000, 7)
    expected = baselines.run(Technique.COSINE, block.blocks, 0, x, unit(n), 400_000, 8)
    assert abs(found.mean - expected.mean) < 4.5 * np.hypot(found.error, expected.error) + 2e-4 * expected.mean


@pytest.mark.parametrize("placement", [name for name in PLACEMENTS if name not in ("far", "stretched")])
def test_transforms_leave_the_density(lamp, placement):
    """∫p = 1 and χ² for lamps that are turned, stretched unevenly, sheared, mirrored, small."""
    matrix = PLACEMENTS[placement]
    local = np.array([0.8, 0.3, 0.5, 1.0])
    x = (matrix @ local)[:3]
    n = matrix[:3, 3] - x
    found = Cut(lamp(SHAPES["nested"], matrix), x, n)
    assert found.boxes > 4
    total, error = sphere_integral(found.density, 200_000, seed=3)
    assert abs(total - 1.0) < 4.0 * error + 1e-3
    result = chi2_sphere(found.sample, found.density, n=60_000, seed=5, quadrature=48)
    assert result.passed, result


@pytest.mark.parametrize(
    "matrix",
    [turned(0.5, 0) @ turned(0.3, 2), scaled(-1.0, 1.0, 1.0), moved(1e3, -2e3, 5e2)],
    ids=["turned", "mirrored", "moved"],
)
def test_rigid_motions_change_nothing(lamp, matrix):
    """Lamp and point moved together: the same cut, directions and densities."""
    x, n = POINTS["close"]
    here = Cut(lamp(SHAPES["frame"]), x, n)
    there = Cut(lamp(SHAPES["frame"], matrix), (matrix @ [*x, 1.0])[:3], matrix[:3, :3] @ unit(n))
    assert here.boxes == there.boxes and there.rows["total"] == pytest.approx(here.rows["total"], rel=1e-9)
    directions = here.sample(np.random.default_rng(1).random((2000, 3)))
    assert np.allclose(there.density(directions @ matrix[:3, :3].T), here.density(directions), rtol=1e-6, atol=1e-9)


def test_far_away_is_projection(lamp):
    """A lamp that is small for its distance takes a single box, and farther off none."""
    block = lamp(SHAPES["torus"])
    x = (3.0, 4.0, 20.0)
    found = Cut(block, x, (0.0, 0.0, -1.0), tolerance=cut.TOLERANCE)
    assert found.boxes == 1 and found.rows["bsdf_mis_scale"] == 0.0
    assert Cut(block, (6.0, 8.0, 120.0), (0.0, 0.0, -1.0), tolerance=cut.TOLERANCE).boxes == 0
    estimate = baselines.run(Technique.CUT, block.blocks, 0, x, (0.0, 0.0, -1.0), 20_000, 1)
    expected = baselines.run(Technique.PROJECTION, block.blocks, 0, x, (0.0, 0.0, -1.0), 20_000, 2)
    assert estimate.mean == pytest.approx(expected.mean, rel=1e-3)


@pytest.mark.parametrize("shape", ["torus", "frame", "blob"])
def test_at_a_distance_points_stand_for_their_rays(lamp, shape):
    """For light that is scattered again. Where they begin to, they are not much noisier than rays."""
    block, n, rows = lamp(SHAPES[shape]), unit((0.1, 0.0, -1.0)), np.zeros(1, cut.CUT)
    size = float(5.0 / 3.0 * block.tables["lamp_placements"]["extent"][0]) ** 0.5
    for distance, points in ((0.5 * size, 0), (0.6 * size, 1), (5.0 * size, 1)):
        x = tuple(map(float, block.built.row["center"][0] + (0.0, 0.0, block.built.row["half"][0, 2] + distance)))
        _project(block.blocks, x, rows)
        assert rows["strategy"][0] == PROJECTION and rows["points"][0] == points
        assert (rows["bsdf_mis_scale"][0] == 0.0) == points
        if points:
            point, ray = (
                baselines.run(technique, block.blocks, 0, x, n, 100_000, seed)
                for seed, technique in enumerate((Technique.POINT, Technique.PROJECTION))
            )
            assert abs(point.mean - ray.mean) < 4.0 * np.hypot(point.error, ray.error)
            assert point.variance < 0.5 * point.mean**2


def test_parts_below_the_horizon_are_left_out(lamp):
    shape = Union(Transformed(Sphere(0.2), moved(z=1.0)), Transformed(Sphere(0.2), moved(z=-1.0)))
    found = Cut(lamp(shape), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert np.all(found.sample(np.random.default_rng(2).random((2000, 3)))[:, 2] > 0.0)


@pytest.mark.parametrize("point, most", [("above", 0.02), ("close", 0.04)])
def test_variance_is_below_that_of_the_paper(lamp, point, most):
    """Measured are a hundredth and a fiftieth: the factors leave room."""
    x = {"above": (0.4, 0.2, 1.6), "close": (1.0, 0.0, 0.6)}[point]
    block, n = lamp(Torus(1.0, 0.35)), (0.0, 0.0, -1.0)
    found = baselines.run(Technique.CUT, block.blocks, 0, x, unit(n), 40_000, 3)
    paper = baselines.run(Technique.MIS, block.blocks, 0, x, unit(n), 40_000, 3)
    assert found.variance < most * paper.variance


def half_hidden(shape) -> LampBlock:
    """A lamp whose lower half no place of a scene sees."""
    looks = np.full((hidden.SIDE, hidden.SIDE, hidden.SIDE, 2), 64, np.int64)
    looks[:, :, : hidden.SIDE // 2, 1] = 0
    sums = hidden.sums_of(looks.reshape(-1, 2))
    block = LampBlock(shape, np.eye(4))
    block.tables["lamp_seen"] = sums
    block.tables["lamp_placements"]["first_seen"] = 0
    fill_table(block.blocks, "lamp_seen", sums)
    return block


@pytest.mark.parametrize("shape", SHAPES)
def test_hidden_parts_leave_the_light(shape):
    """The density integrates to one, and the irradiance is that of cosine sampling within 4.5 standard errors."""
    block = half_hidden(SHAPES[shape])
    x, n = POINTS["above"]
    total, error = sphere_integral(Cut(block, x, n).density, 200_000, seed=3)
    assert abs(total - 1.0) < 4.0 * error + 1e-3
    found = baselines.run(Technique.CUT, block.blocks, 0, x, unit(n), 40_000, 7)
    expected = baselines.run(Technique.COSINE, block.blocks, 0, x, unit(n), 400_000, 8)
    assert abs(found.mean - expected.mean) < 4.5 * np.hypot(found.error, expected.error) + 2e-4 * expected.mean


@pytest.mark.parametrize("shape, most", [("box", 0.08), ("frame", 0.08), ("torus", 0.4)])
def test_hidden_parts_are_drawn_seldom(lamp, shape, most):
    """Of a point on the level of the middle, half of all directions lead to the lower half. A box is one full leaf. Of
    a ring, many boxes of the tree have both."""
    at, u = ((1.6, 0.0, 0.0), (-1.0, 0.0, 0.0)), np.random.default_rng(5).random((20_000, 3))
    even, found = (
        np.mean(Cut(made, *at, limit=cut.LIMIT).sample(u)[:, 2] < 0.0)
        for made in (lamp(SHAPES[shape]), half_hidden(SHAPES[shape]))
    )
    assert abs(even - 0.5) < 0.02 and found < most


def test_only_what_next_to_none_see_is_hidden():
    looks = np.full((hidden.CELLS, 2), 64, np.int64)
    looks[: hidden.CELLS // 2, 1] = 16  # half of the lamp, which a quarter of the places see
    assert hidden.sums_of(looks) is None
    looks[:3, 1] = 0  # less than a fiftieth
    assert hidden.sums_of(looks) is None
    looks[:, 1] = 0  # nobody sees any of it
    assert hidden.sums_of(looks) is None
