# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes from interior trees against closed forms, and uniform points against moments and counts."""

import numpy as np
import pytest
from scipy import stats

from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build
from sdf_lights.emitter.tree import interior, volume
from sdf_lights.sdf.program import NoClosedForm
from sdf_lights.sdf.shapes import SHAPES as REGISTRY
from sdf_lights.sdf.shapes import Box, Cylinder, Difference, Intersection, Sphere, Torus, Transformed, Union
from support.lamps.shapes_under_test import LAMPS, FieldOf, moved, turned


def lens(radius, distance):
    """Volume of the overlap of two equal balls."""
    return np.pi * (2 * radius - distance) ** 2 * (distance**2 + 4 * distance * radius) / (12 * distance)


KNOWN = {
    "lens": (Intersection(Sphere(1.0), Transformed(Sphere(1.0), moved(1.2))), lens(1.0, 1.2)),
    "two balls": (
        Union(Sphere(1.0), Transformed(Sphere(1.0), moved(0.7, 0.2, 0.1))),
        8 / 3 * np.pi - lens(1.0, np.sqrt(0.54)),
    ),
    "bicylinder": (
        Intersection(Cylinder(0.5, 3.0), Transformed(Cylinder(0.5, 3.0), turned(np.pi / 2, 0))),
        16 / 3 * 0.125,
    ),
    "shell": (Difference(Sphere(1.0), Sphere(0.98)), 4 / 3 * np.pi * (1 - 0.98**3)),
    "boxes": (Difference(Box((1, 1, 1)), Transformed(Box((0.5, 1, 1)), moved(0.5))), 4.0),
    "drilled ball": (Difference(Sphere(1.0), Cylinder(0.6, 4.0)), np.pi / 6 * 1.6**3),
    "crossed bars": (
        Union(*(Transformed(Box((1.0, 0.02, 0.02)), turned(a) @ moved(0, 0, 0.2 * a)) for a in range(5))),
        5 * 8 * 1.0 * 0.02**2,
    ),
}


KINDS = {"closed": lambda shape: shape, "field": FieldOf}


def measured(shape):
    return volume.measure(interior.tree(shape))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", KNOWN)
def test_volume_of_composites(name, kind):
    shape, exact = KNOWN[name]
    assert shape.volume() is None
    found = measured(KINDS[kind](shape))
    assert abs(found.value - exact) <= max(found.error, 1e-9 * exact)
    assert found.low <= exact * (1.0 + 1e-9) and found.high >= exact * (1.0 - 1e-9)
    thin = name in ("shell", "crossed bars")
    assert found.error < (2e-2 if thin else 1.5e-3) * exact


def _with_volume():
    for name, make in REGISTRY.items():
        try:
            shape = make()
        except TypeError:
            continue  # it is made of others
        if not shape.validate() and shape.bounded and shape.volume() is not None:
            yield name


@pytest.mark.parametrize("name", list(_with_volume()))
def test_fields_have_the_volumes_of_closed_forms(name):
    """Every shape of the registry that states its volume, by its field, and by its program if it is made of several."""
    shape = REGISTRY[name]()
    exact = shape.volume()
    try:
        closed = len(shape.program()) > 1
    except NoClosedForm:
        closed = False
    for kind in ["field"] + ["closed"] * closed:
        found = measured(KINDS[kind](shape))
        assert abs(found.value - exact) <= max(found.error, 1e-9 * exact), kind
        assert found.low <= exact * (1.0 + 1e-9) and found.high >= exact * (1.0 - 1e-9), kind
        assert found.error < 2e-2 * exact, kind


def test_error_bound_is_honest():
    """Over many different shapes the errors, in units of the stated standard error, are of order one or less."""
    rng = np.random.default_rng(4)
    scores = []
    for index in range(40):
        a, b = rng.uniform(0.5, 1.0, 2)
        offset = rng.uniform(-0.4, 0.4, 3)
        shape = Union(Sphere(a), Transformed(Sphere(b), moved(*offset)))
        r = np.linalg.norm(offset)
        if r <= abs(a - b):
            continue
        overlap = np.pi * (a + b - r) ** 2 * (r * r + 2 * r * (a + b) - 3 * (a - b) ** 2) / (12 * r)
        exact = 4 / 3 * np.pi * (a**3 + b**3) - overlap
        found = measured(FieldOf(shape) if index % 2 else shape)
        scores.append((found.value - exact) / (found.error / volume.SAFETY))
    assert 0.2 < np.sqrt(np.mean(np.square(scores))) < 1.0
    assert abs(np.mean(scores)) < 0.3


BENCHMARK = {
    # With the relative errors at 2^21 evaluations of an octree with jittered points in its boundary cells, as reported;
    # jittered points in the whole bounding box have 7e-5, 6e-3 and 5e-4.
    "torus": (FieldOf(Torus(1.0, 0.35)), 4.1e-5),
    "turned frame": (FieldOf(Transformed(REGISTRY["box_frame"](1.0, 0.08), turned(0.6, 0) @ turned(0.4, 1))), 1.4e-4),
    "sponge": (FieldOf(REGISTRY["menger_sponge"](levels=4)), 5.7e-4),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "turned frame")) for name in BENCHMARK]
)
def test_errors_at_two_million_evaluations(name):
    """Root mean square over seeds, at a division with about as many evaluations, and in inverse proportion to them."""
    shape, known = BENCHMARK[name]
    exact = shape.child.volume()
    tree = interior.tree(shape)
    sizes = np.prod(tree.boxes[:, 3:] - tree.boxes[:, :3], axis=1)
    certain, coarsest, found = sizes[tree.inside].sum(), sizes[tree.boundary].max(), []
    while True:
        errors = []
        for seed in range(1, 49):
            sums, calls = np.zeros(4), np.zeros(len(tree.boundary))
            volume.sample(
                tree.program,
                *tree.arrays,
                tree.nodes,
                tree.lists,
                tree.boxes,
                tree.boundary,
                np.full(len(tree.boundary), coarsest),
                np.array([seed], np.uint64),
                sums,
                calls,
            )
            evaluations = 8.0 * calls.sum()
            errors.append((certain + sums[0] + sums[2]) / exact - 1.0)
            if evaluations > 2**22:
                break
        if evaluations > 2**22:
            break
        found.append(np.sqrt(np.mean(np.square(errors))) * evaluations / 2**21)
        coarsest /= 4.0
    assert found[-1] < known


@pytest.mark.parametrize("name", LAMPS)
def test_points_are_inside_and_uniform(name):
    """χ² of counts in a grid against the volume of the shape in each of its cells, found by the formula; at 99.99 %."""
    shape = LAMPS[name]
    lamp = Lamps(build.build_lamp(name, shape, np.eye(4)))
    rng = np.random.default_rng(9)
    points = lamp.points(rng.random((60_000, 3)))
    assert np.mean(shape.distance(points) <= 1e-9) == 1.0
    low, high = shape.bounds()
    edges = [np.linspace(a - 1e-9, b + 1e-9, 7) for a, b in zip(low, high)]
    counts = np.histogramdd(points, edges)[0].ravel()
    assert counts.sum() == len(points)
    grid = 6 * 16
    jittered = (np.stack(np.meshgrid(*[np.arange(grid)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5) / grid
    reference = low + (jittered + rng.uniform(-0.5, 0.5, jittered.shape) / grid) * (high - low)
    reference = reference[np.concatenate([shape.distance(part) <= 0.0 for part in np.array_split(reference, 30)])]
    expected = np.histogramdd(reference, edges)[0].ravel()
    expected *= len(points) / expected.sum()
    keep = expected > 20.0
    # The reference counts have noise of their own, in the same proportion to the sizes of the two samples.
    noise = expected[keep] * (1.0 + len(points) / len(reference))
    statistic = np.sum((counts[keep] - expected[keep]) ** 2 / noise)
    assert stats.chi2.sf(statistic, keep.sum() - 1) > 1e-4


@pytest.mark.parametrize("name", ["torus", "cone", "capsule", "frustum", "frame", "blob"])
def test_points_keep_stratification(name):
    """The mean of a smooth function over a jittered 3-D grid has a fraction of the error of independent numbers."""
    shape = LAMPS[name]
    lamp = Lamps(build.build_lamp(name, shape, np.eye(4)))
    side = 12
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    rng = np.random.default_rng(6)
    value = lambda p: np.sin(2.0 * p[:, 0] + p[:, 1]) + p[:, 2] ** 2
    jittered = [value(lamp.points((cells + rng.random(cells.shape)) / side)).mean() for _ in range(24)]
    independent = [value(lamp.points(rng.random(cells.shape))).mean() for _ in range(24)]
    # A fifth of the frame's points are drawn again, with numbers that no longer are stratified.
    assert np.std(jittered) < (0.75 if name in ("frame", "blob") else 0.5) * np.std(independent)
