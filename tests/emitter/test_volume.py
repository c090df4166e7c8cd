# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes by columns against closed forms, and uniform points against moments and counts."""

import time

import numpy as np
import pytest
from scipy import stats

from sdf_lights.emitter import lamps, volume
from sdf_lights.sdf.shapes import Box, Cylinder, Difference, Intersection, Sphere, Transformed, Union

from tests.emitter.shapes_under_test import COMPOSITES, PLACEMENTS, PRIMITIVES, SHAPES, moved, turned
from tests.emitter.support import Lamps


def lens(radius, distance):
    """Volume of the overlap of two equal balls."""
    return np.pi * (2 * radius - distance) ** 2 * (distance**2 + 4 * distance * radius) / (12 * distance)


KNOWN = {
    "lens": (Intersection(Sphere(1.0), Transformed(Sphere(1.0), moved(1.2))), lens(1.0, 1.2)),
    "two balls": (Union(Sphere(1.0), Transformed(Sphere(1.0), moved(0.7, 0.2, 0.1))),
                  8 / 3 * np.pi - lens(1.0, np.sqrt(0.54))),
    "bicylinder": (
        Intersection(Cylinder(0.5, 3.0), Transformed(Cylinder(0.5, 3.0), turned(np.pi / 2, 0))), 16 / 3 * 0.125),
    "shell": (Difference(Sphere(1.0), Sphere(0.98)), 4 / 3 * np.pi * (1 - 0.98**3)),
    "boxes": (Difference(Box((1, 1, 1)), Transformed(Box((0.5, 1, 1)), moved(0.5))), 4.0),
    "drilled ball": (Difference(Sphere(1.0), Cylinder(0.6, 4.0)), np.pi / 6 * 1.6**3),
    "crossed bars": (
        Union(*(Transformed(Box((1.0, 0.02, 0.02)), turned(a) @ moved(0, 0, 0.2 * a)) for a in range(5))),
        5 * 8 * 1.0 * 0.02**2),
}


@pytest.mark.parametrize("name", KNOWN)
def test_volume_of_composites(name):
    shape, exact = KNOWN[name]
    assert shape.volume() is None
    estimate, bound = volume.estimate(shape.program(), *shape.bounds())
    assert abs(estimate - exact) <= max(bound, 1e-9 * exact)
    thin = name in ("shell", "crossed bars")
    assert bound < (1.5e-3 if thin else 1e-4) * exact


@pytest.mark.parametrize("name", PRIMITIVES)
def test_columns_agree_with_closed_forms(name):
    """A primitive put through the integral that is meant for composites comes out at its own volume."""
    shape = PRIMITIVES[name]
    for matrix in (np.eye(4), PLACEMENTS["sheared"]):
        exact = shape.volume() * abs(np.linalg.det(matrix[:3, :3]))
        estimate, bound = volume.estimate(shape.program(matrix), *shape.bounds(matrix))
        assert abs(estimate - exact) <= max(bound, 1e-9 * exact)
        assert bound < 5e-4 * exact


def test_error_bound_is_honest():
    """Over many different shapes the errors, in units of the stated standard error, are of order one."""
    rng = np.random.default_rng(4)
    scores = []
    for _ in range(40):
        a, b = rng.uniform(0.5, 1.0, 2)
        offset = rng.uniform(-0.4, 0.4, 3)
        shape = Union(Sphere(a), Transformed(Sphere(b), moved(*offset)))
        r = np.linalg.norm(offset)
        if r <= abs(a - b):
            continue
        overlap = np.pi * (a + b - r) ** 2 * (r * r + 2 * r * (a + b) - 3 * (a - b) ** 2) / (12 * r)
        exact = 4 / 3 * np.pi * (a**3 + b**3) - overlap
        estimate, bound = volume.estimate(shape.program(), *shape.bounds())
        scores.append((estimate - exact) / (bound / volume.SAFETY))
    assert np.sqrt(np.mean(np.square(scores))) < 1.6
    assert abs(np.mean(scores)) < 0.6


def test_volume_of_twenty_primitives_is_quick():
    shape = COMPOSITES["twenty"]
    program, bounds = shape.program(), shape.bounds()
    volume.estimate(program, *bounds)
    start = time.process_time()
    _, bound = volume.estimate(program, *bounds)
    assert time.process_time() - start < 2.0  # about 0.3 s on a quiet machine
    assert bound / volume.estimate(program, *bounds)[0] < 3e-4


@pytest.mark.parametrize("name", SHAPES)
def test_points_are_inside_and_uniform(name):
    """χ² of counts in a grid against the volume of the shape in each of its cells, found by the formula; at 99.99 %."""
    shape = SHAPES[name]
    lamp = Lamps(lamps.build_lamp(name, shape, np.eye(4)))
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


@pytest.mark.parametrize("name", ["torus", "cone", "capsule", "frame"])
def test_points_keep_stratification(name):
    """The mean of a smooth function over a jittered 3-D grid has a fraction of the error of independent numbers."""
    shape = SHAPES[name]
    lamp = Lamps(lamps.build_lamp(name, shape, np.eye(4)))
    side = 12
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    rng = np.random.default_rng(6)
    value = lambda p: np.sin(2.0 * p[:, 0] + p[:, 1]) + p[:, 2] ** 2
    jittered = [value(lamp.points((cells + rng.random(cells.shape)) / side)).mean() for _ in range(24)]
    independent = [value(lamp.points(rng.random(cells.shape))).mean() for _ in range(24)]
    # A quarter of the frame's points are drawn again, with numbers that no longer are stratified.
    assert np.std(jittered) < (0.75 if name == "frame" else 0.5) * np.std(independent)
